"""Backlash of a gear beside what else acts on the motor: controllers; against a 60-digit model in steps.

Bounds are those of `test_laws_in_the_general_loop`. The model brackets where teeth meet and part; it follows no event
that begins and ends within 1/64 of a sample, which would show as a difference.
"""

from math import pi
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.search import as_arrays
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import RATTLE, LawMeasurer
from tests.controllers.laws import EVERY

from .law_scenes import Drawn, reduce, search
from .test_laws_in_the_general_loop import check_orbit, check_trial

GEAR: dict[str, Any] = {
    "ratio": 7.4,
    "motor_inertia": 1e-8,
    "stiffness": 10.0,
    "mesh_damping": 2e-3,
    "backlash": 0.3 * pi / 180,
}


SHORT = 6  # samples of a period that is derived again, each of 64 steps
FIRM = {"inertia": 3e-7, "damping": 5e-3, "stiffness": 0.5}


def geared(controller: str, *, push: float = 3e-4, rate_hz: float = 1000.0, **more: Any) -> Drawn:
    """The iDrive's knob with a light push, under a controller; ``more``: of the gear, or parts of the scene."""
    scene: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": push},
        "gear": {**GEAR, **{key: value for key, value in more.items() if not isinstance(value, dict)}},
        **{key: value for key, value in more.items() if isinstance(value, dict)},
    }
    if controller:
        scene["controller"] = dict(EVERY[controller])
    return Drawn(controller, ("play",), scene, rate_hz, 360)


@pytest.mark.parametrize(
    "controller", ["bounded lag", "damping, sensor", "damping, differenced", "impulse, short", "speed, tracked"]
)
def test_trials_beside_a_controller(controller: str) -> None:
    """Two of three can be compared: at a light push, with a delay, and with soft teeth that ring."""
    more: list[dict[str, Any]] = [{}, {"actuator": {"delay_samples": 0.4}}, {"stiffness": 1.0, "mesh_damping": 1e-4}]
    errors = [check_trial(geared(controller, **one)) for one in more]
    assert np.isfinite(errors).sum() >= 2


def test_proven_cycles_beside_a_controller_on_one_flank() -> None:
    """The same with any backlash, and derived again."""
    found = []
    for backlash in (0.0, 0.005, 0.5):
        one = geared("speed, tracked", push=2e-3, mesh_damping=2e-2, hand=FIRM, backlash=backlash)
        made = reduce(one)
        engine, attractors = search(one, made)
        cycles = [end for end in attractors if end.outcome is Outcome.CYCLE and end.certified]
        measured = [LawMeasurer(made.knob, engine).measure(end) for end in cycles]
        assert all(each.mesh_least_nm > 0.0 for each in measured)
        found.append([(end.period, each.p2p_rad) for end, each in zip(cycles, measured, strict=True)])
        for end in cycles:
            if end.period <= SHORT and backlash == 0.005:
                check_orbit(one, made, engine, end)
    assert found[0]
    for other in found[1:]:
        assert np.array(other) == pytest.approx(np.array(found[0]), rel=1e-9)


def test_cycles_through_the_play_beside_a_controller() -> None:
    """They close in the engine's own motion, and what the torque puts in is taken: by dampers, and teeth that relax."""
    parted = 0
    for controller in ("damping, differenced", "speed, tracked", "impulse, short"):
        for push in (1e-4, 3e-4):
            one = geared(controller, push=push, mesh_damping=2e-2, hand=FIRM)
            made = reduce(one)
            engine, attractors = search(one, made)
            for end in attractors:
                if end.outcome is not Outcome.CYCLE:
                    continue
                measured = LawMeasurer(made.knob, engine).measure(end)
                assert measured.wall_work_j == pytest.approx(measured.damping_loss_j, rel=1e-9)
                assert end.certified == (end.reason is Reason.NONE)
                parted += end.reason is Reason.PARTS
    assert parted >= 3


@pytest.mark.parametrize(("controller", "push"), [("speed, tracked", 1e-4), ("damping, sensor", 3e-4)])
def test_chaos_beside_a_controller_is_what_two_motions_do(controller: str, push: float) -> None:
    """As `test_backlash` has it, with the same bound; a sensed speed makes torques of a neighbour others."""
    one = geared(controller, push=push, mesh_damping=2e-4)
    made = reduce(one)
    engine, attractors = search(one, made, phases=1)
    (end,) = attractors
    assert end.reason is Reason.NO_REPEAT
    measured = LawMeasurer(made.knob, engine).measure(end)
    assert measured.rattle_p2p_rad > 0.0
    advance, body, pad = compiled("laws")["general.laws.advance_with_law"], as_arrays(made.knob.body), np.zeros(8)
    n, past = 4, np.array(end.line)
    z = np.array([end.x, end.v, *end.state])
    other, beside, total = past.copy(), z + 5e-10, 0.0
    for _ in range(RATTLE):
        advance(z, past, body, made.knob.wall, engine.law, pad)
        advance(beside, other, body, made.knob.wall, engine.law, pad)
        assert (other[: made.law.line] == past[: made.law.line]).all() or made.law.fading >= 0
        off = float(np.linalg.norm(beside - z))
        total += np.log(off / 1e-9)
        beside = z + (beside - z) * (1e-9 / off)
        other[made.law.line :] = past[made.law.line :] + (other[made.law.line :] - past[made.law.line :]) * (1e-9 / off)
    assert n == made.knob.body.order
    assert total / RATTLE * 1000.0 == pytest.approx(
        measured.parting_per_s, abs=2.5 + 0.01 * abs(measured.parting_per_s)
    )
