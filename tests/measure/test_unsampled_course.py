"""Contact, bounces, settling and the way that friction acted on: against the recorded events of the same motion."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.outcome import Outcome
from tests.measure.test_unsampled import B, knob, record, remaining, trial

RUBBING: dict[str, Any] = {"knob": {"inertia": 1.9e-6, "coulomb_torque": 5e-5}}
DAMPED: dict[str, Any] = {"hand": {"inertia": 3e-7, "damping": 0.1 * B, "stiffness": 0.01}}
SCENES = {
    "friction": knob(512, **RUBBING, hand={"inertia": 3e-7}),
    "friction and damping": knob(512, **RUBBING, **DAMPED),
    "friction, continuous": knob(None, **RUBBING, **DAMPED, encoder="none"),
    "damping": knob(512, **DAMPED),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("angle", "velocity"), [(0.02, 0.0), (0.01, -0.7), (-0.01, 0.4), (0.0, -0.3)])
@pytest.mark.parametrize("name", SCENES)
def test_what_is_said_of_a_course_is_what_its_events_show(name: str, angle: float, velocity: float) -> None:
    one = SCENES[name]
    said = trial(one, angle, velocity)
    finer = {"chatter_counts": 1e-9} if one.loop.phi > 0.0 else {}  # with damping alone chatter takes for ever
    motion = record(one, 3.0, angle, velocity, **finer)
    assert said.outcome is Outcome.REST
    piece, turn = motion.rows[:, 1], motion.angle_rad
    inside = piece > 0.0
    # The first event may be at the start itself.
    assert said.contact_s == pytest.approx(motion.time_s[int(np.argmax(inside))], rel=1e-12)
    settled = said.settling_s
    if one.loop.counted:
        assert remaining(motion, settled * (1.0 + 1e-9)) <= one.unit_rad * (1.0 + 1e-6)
        if settled > 0.0:  # else all of it is within a count
            assert remaining(motion, settled * (1.0 - 1e-6)) > one.unit_rad * (1.0 - 1e-6)
        until = motion.time_s <= settled
        left = inside[:-1] & ~inside[1:] & (motion.velocity_rad_s[1:] >= 0.0)
        assert int(left[until[1:]].sum()) <= said.bounces <= int(left.sum())
    if one.loop.phi > 0.0 and one.loop.alpha > 0.0:
        way = float(np.abs(np.diff(turn)).sum())
        assert said.friction_loss_j == pytest.approx(5e-5 * way, rel=0.02)
