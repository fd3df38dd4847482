"""The 60-digit model of the whole scene against two others: the plain 60-digit model, and SciPy's DOP853.

With the plain model: 50 digits. With DOP853: what its tolerances leave, 1e-9 of the largest value met over 40 samples.
"""

from itertools import pairwise

import numpy as np
import pytest

from tests import digits as mp
from tests.crosscheck.general_ivp import integrate

from .general_reference import simulate
from .general_scenes import CASES, Case
from .reference import build_cell
from .reference_bodies import Bodies
from .reference_friction import Friction
from .scenes import hand_on_knob

SAMPLES = 40
WITHIN = 1e-9


@pytest.mark.parametrize(
    ("rounding", "offset", "delay"), [("floor", 0.0, 0.0), ("nearest", 0.3, 2.4), ("ceil", 0.6, 1.0)]
)
def test_same_as_the_plain_model(rounding: str, offset: float, delay: float) -> None:
    scene = hand_on_knob(rounding=rounding, offset=offset, delay=delay)
    clock = {"sample_rate_hz": 1000.0, "counts_per_rev": 1024}
    trial = simulate(scene, **clock, angle_rad=0.02, velocity_rad_s=-1.5, samples=500)
    cell = build_cell(scene, **clock)
    start = cell.start((mp.mpf(0.02), mp.mpf(-1.5)), 0, 1)
    for sample, ((theta, _), _) in zip(trial.samples, cell.run(start, 501), strict=True):
        assert abs(sample.angle - theta) < mp.mpf(10) ** -50


@pytest.mark.one_in(3)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_same_as_scipy(case: Case) -> None:
    arguments = {**case.arguments, "samples": min(SAMPLES, case.samples)}
    trial, run = simulate(case.scene, **arguments), integrate(case.scene, **arguments)
    for name in ("time_s", "angle_rad", "velocity_rad_s", "torque_nm"):
        exact = np.array([float(getattr(sample, name.split("_")[0])) for sample in trial.samples])
        assert getattr(run, name) == pytest.approx(exact, rel=0, abs=WITHIN * max(np.abs(exact).max(), 1e-9)), name
    stuck = [bool(sample.velocity == 0) for sample in trial.samples]
    assert list(run.velocity_rad_s == 0) == stuck


def test_all_reversals_of_a_hold_are_found() -> None:
    """A fast ringing and a slow swing in one long hold: as many reversals as a fine scan of the same motion shows."""
    bodies = Bodies(
        *map(mp.mpf, (2e-6, 0.0, 0.0, 0.0, 0.0, 0.0)),
        finger=True,
        finger_inertia=mp.mpf(3e-5),
        finger_damping=mp.mpf(1e-5),
        finger_stiffness=mp.mpf(0.4),
        pad_damping=mp.mpf(2e-5),
        pad_stiffness=mp.mpf(20.0),
    )
    start = tuple(map(mp.mpf, (0.01, 0.05, 0.0102, 1.0, 0.0, 0.0, 1.0, 0.0)))
    duration = mp.mpf(1) / 8
    motion = Friction(bodies, duration, start, find_turns=True)
    motion.hold(mp.mpf(0.003), duration)
    direct = bodies.move(1, (*start[:4], mp.mpf(0.003), mp.zero, mp.one, mp.zero), duration, recurs=True)
    assert abs(motion.z[0] - direct[0]) < mp.mpf(10) ** -48
    steps = 20_000
    z, signs = (*start[:4], mp.mpf(0.003), mp.zero, mp.one, mp.zero), []
    for _ in range(steps):
        signs.append(z[1] > 0)
        z = bodies.move(1, z, duration / steps, recurs=True)
    changes = sum(a != b for a, b in pairwise(signs))
    assert len(motion.turns) == changes > 20
