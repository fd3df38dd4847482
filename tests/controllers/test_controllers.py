"""Every controller, sample by sample, against the same written once more from its source in 40 digits."""

from itertools import islice
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.engine.general.sets.friction_phases import fly
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp
from tests.controllers.laws import CONTROLLERS
from tests.controllers.reference import Rig, law_of

BASE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}
# scene, rate, counts, start velocity
CELLS: dict[str, tuple[dict[str, Any], float, int, float]] = {
    "as it is": ({}, 1000.0, 360, 0.0),
    "fast and fine": ({"encoder": {"rounding": "nearest", "offset_counts": 0.3}}, 4000.0, 2650, -0.4),
    "slow": ({"encoder": {"rounding": "truncate"}, "bias": {"half_quantum": True}}, 300.0, 1024, -1.0),
    "limited": ({"actuator": {"torque_limit": 0.002}, "encoder": {"rounding": "ceil"}}, 1000.0, 1024, -1.0),
}
SAMPLES = 250
PHASES = 2


@pytest.mark.one_in(5)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("name", CONTROLLERS)
def test_motion_and_torque_are_the_references(name: str, cell: str) -> None:
    change, rate, counts, velocity = CELLS[cell]
    scene = {**BASE, **change, "controller": CONTROLLERS[name]}
    plan = SceneSpec.model_validate(scene).plain()
    made = make_law(plan, sample_rate_hz=rate, counts_per_rev=counts)
    knob, law, rig = made.knob, made.law, Rig(scene, rate, counts, mp.mpf)
    largest, acts = 0.0, 0
    # Each hold rounds by some 20 units in the last place of the largest position; a plant that is damped, with memory,
    # carries it on by a factor below 20.
    bound = 20 * 20 * SAMPLES * np.finfo(float).eps
    for phase in ((i + 0.5) / PHASES for i in range(PHASES)):
        z, past = list(fly(*knob.start(0.02, velocity), phase, knob.body)), [0.0] * len(law.beside)
        begin_past(past, read(z[0], knob.wall), law)
        trial = rig.trial(law_of(rig, CONTROLLERS[name]), 0.02, velocity, phase)
        for theta, omega, pieces in islice(trial, SAMPLES):
            at, pace = knob.angle_rad(z[0]), z[1] * knob.quantum_rad / knob.period_s
            largest = max(largest, abs(float(theta)), abs(float(omega)) * knob.period_s)
            assert abs(at - theta) <= bound * largest
            assert abs(pace - omega) <= bound * largest / knob.period_s
            advance_with_law(z, past, knob.body, knob.wall, law, [0.0] * 4)
            newest = past[law.line + (law.ages - 1) * law.parts :]
            assert len(newest) == len(pieces)
            for u, (torque, _) in zip(newest, pieces, strict=True):
                ours = u / knob.wall.kappa * plan.wall.stiffness * knob.quantum_rad
                # Steps of a torque follow the velocity by gains of up to 100 per sample.
                assert abs(ours - torque) <= 100 * bound * plan.wall.stiffness * largest
                acts += ours != 0.0
    assert acts > 0


def test_each_controller_acts_in_the_cells_that_are_compared() -> None:
    """The comparison would say little of a controller that never differs from the plain wall."""
    for name, controller in CONTROLLERS.items():
        differs = 0
        for change, rate, counts, velocity in CELLS.values():
            rig = Rig({**BASE, **change}, rate, counts)
            trial = rig.trial(law_of(rig, controller), 0.02, velocity, 0.5)
            for theta, _, pieces in islice(trial, SAMPLES):
                differs += any(abs(u - rig.spring(rig.measured(theta))) > 1e-9 for u, _ in pieces)
        assert differs > 20, name


def test_a_whole_samples_impulse_is_the_first_order_hold_without_its_correction() -> None:
    """T = w + K dtheta (T/2) / T is the mean of the torque and the next one, extrapolated: two names of one law."""
    rig = Rig(BASE, 1000.0, 360)
    one = rig.trial(law_of(rig, CONTROLLERS["impulse, whole"]), 0.02, 0.0, 0.5)
    other = rig.trial(law_of(rig, CONTROLLERS["first-order hold"]), 0.02, 0.0, 0.5)
    for (_, _, a), (_, _, b) in islice(zip(one, other, strict=True), SAMPLES):
        assert a[0][0] == pytest.approx(b[0][0], rel=1e-12, abs=1e-15)
