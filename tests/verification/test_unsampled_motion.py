"""The motion without a sample clock against a 50-digit model, event by event.

A step rounds time, velocity and position by a few units in the last place, relative to the motion's size; an event
passes errors on to the next without magnifying them by more than the ratio of velocities there, at most some tens in
these scenes. With 60 events 1e-12 of the motion's scale leaves a factor ten. A different event would show as 1e-4.
"""

import math
from typing import Any

import pytest

from hknob_cli.measure.unsampled import events
from hknob_cli.scene.plain_knob import reduce_unsampled
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp

from .unsampled_reference import Ball

WITHIN = 1e-12


@pytest.mark.parametrize(
    ("damping", "stiffness", "wall", "counts", "velocity"),
    [
        (0.0, 0.0, 0.27, 1024, 0.0),
        (0.0, 0.0, 0.27, 2650, 3.0),
        (0.0, 0.0, 2700.0, 1024, 0.0),
        (3.45e-4, 0.0, 0.27, 2048, 0.0),
        (0.0, 0.04, 0.27, 512, -2.0),
        (3.45e-4, 0.04, 0.27, 1024, 0.0),
        (2.5e-3, 0.04, 0.27, 1024, 2.0),
    ],
)
def test_events(damping: float, stiffness: float, wall: float, counts: int, velocity: float) -> None:
    scene: dict[str, Any] = {
        "knob": {"inertia": 2.2e-6, "damping": damping},
        "hand": {"stiffness": stiffness},
        "wall": {"stiffness": wall},
        "bias": {"torque": 0.001},
        "sampling": "continuous",
    }
    knob = reduce_unsampled(SceneSpec.model_validate(scene).plain(), counts_per_rev=counts)
    ball = Ball(
        inertia=mp.mpf(2.2e-6),
        damping=mp.mpf(damping),
        stiffness=mp.mpf(stiffness),
        wall=mp.mpf(wall),
        bias=mp.mpf(0.001),
        quantum=2 * mp.pi / counts,
    )
    motion = events(knob, angle_rad=0.02, velocity_rad_s=velocity, duration_s=0.12)
    number = min(len(motion.rows) - 1, 24)
    wanted = ball.run(0.02, velocity, number)
    assert number >= 8 or damping == 2.5e-3
    speed = max(abs(motion.velocity_rad_s))
    for i, (time, theta, omega, level) in enumerate(wanted, start=1):
        assert motion.rows[i, 1] == -level
        assert abs(motion.time_s[i] - time) <= WITHIN * 0.1
        assert abs(motion.angle_rad[i] - theta) <= WITHIN * 0.02
        assert abs(motion.velocity_rad_s[i] - omega) <= WITHIN * speed
        assert math.isclose(motion.torque_nm[i], ball.torque(level), rel_tol=1e-14)
