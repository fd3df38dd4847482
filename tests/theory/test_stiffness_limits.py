"""The lines of the K-B plane: on one side of each the limit holds, on the other it does not."""

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.theory.laws import WorkingEdge
from hknob_cli.theory.passivity import verdict
from hknob_cli.theory.stiffness_limits import stiffness_limits

EDGE = WorkingEdge(
    inertia=2.2e-6,
    damping=1.3e-3,
    knob_damping=1.0e-3,
    hand_stiffness=0.04,
    wall_stiffness=0.27,
    wall_damping=0.0,
    coulomb_torque=3.0e-3,
    quantum_rad=2.0 * np.pi / 1024,
    period_s=1.0e-3,
    transport_s=0.0,
    torque_step=1.0e-3,
    balance=0.5,
)
VIRTUAL = [0.0, 3.0e-4, 9.0e-4, 2.0e-3]
NEAR = 1e-6  # of the stiffness; the lines are roots to within a few roundings


def spectral_radius(edge: WorkingEdge, stiffness: float, virtual: float) -> float:
    """Of the loop, by the matrix exponential: angle, speed, last reading, torques under way."""
    period = edge.period_s
    motion = np.zeros((3, 3))
    motion[0, 1] = 1.0
    motion[1] = [-edge.hand_stiffness / edge.inertia, -edge.damping / edge.inertia, 1.0 / edge.inertia]
    whole, part = divmod(edge.transport_s / period, 1.0)
    late, rest = expm(motion * part * period), expm(motion * (1.0 - part) * period)
    waiting = int(whole) + 1  # torques computed and not yet all done
    size = 3 + waiting
    step = np.zeros((size, size))
    now = np.zeros(size)  # the torque computed at this sample
    now[[0, 2]] = -stiffness - virtual / period, virtual / period
    queue = np.eye(size)[3:]  # the newest first
    new = now if waiting == 1 else queue[waiting - 2]
    state = np.eye(size)[:2]
    between = late[:2, :2] @ state + np.outer(late[:2, 2], queue[waiting - 1])
    step[:2] = rest[:2, :2] @ between + np.outer(rest[:2, 2], new)
    step[2, 0] = 1.0
    step[3] = now
    step[4:] = queue[:-1]
    return float(np.abs(np.linalg.eigvals(step)).max())


@pytest.mark.parametrize("delay", [0.0, 0.4, 1.0, 2.3])
def test_the_exact_limit_is_where_the_loop_begins_to_grow(delay: float) -> None:
    edge = EDGE._replace(transport_s=delay * EDGE.period_s)
    found = stiffness_limits(edge, VIRTUAL).exact
    assert found[0] > 0.0
    for virtual, most in zip(VIRTUAL, found, strict=True):
        if most:
            assert spectral_radius(edge, most * (1.0 - NEAR), virtual) < 1.0
            assert spectral_radius(edge, most * (1.0 + NEAR), virtual) > 1.0
        else:
            assert min(spectral_radius(edge, stiffness, virtual) for stiffness in np.geomspace(1e-3, 1e2, 60)) > 1.0


@pytest.mark.parametrize("delay", [0.0, 0.4, 1.0])
def test_verdicts_change_at_the_lines(delay: float) -> None:
    edge = EDGE._replace(transport_s=delay * EDGE.period_s)
    lines = stiffness_limits(edge, VIRTUAL)
    for name in ("colgate_schenkel", "abbott_okamura", "gil_hulin", "niemeyer"):
        for virtual, most in zip(VIRTUAL, getattr(lines, name), strict=True):
            for factor in (1.0 - NEAR, 1.0 + NEAR):
                there = edge._replace(wall_stiffness=factor * most or NEAR, wall_damping=virtual)
                assert verdict(there).limits[name].holds == (factor < 1.0 and most > 0.0), (name, virtual)


def test_without_friction_or_within_a_long_delay() -> None:
    lines = stiffness_limits(EDGE._replace(coulomb_torque=0.0), VIRTUAL)
    assert lines.abbott_okamura == lines.niemeyer == [0.0] * len(VIRTUAL)
    assert lines.colgate_schenkel[0] == pytest.approx(2.0 * EDGE.knob_damping / EDGE.period_s)
    assert np.isnan(stiffness_limits(EDGE._replace(transport_s=1.0), VIRTUAL).exact).all()
