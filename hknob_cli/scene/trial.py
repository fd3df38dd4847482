"""One trial by the exact engine: the state at every sample."""

from math import pi
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.engine.loop import interval, level_of, push
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.errors import ComputationError
from hknob_cli.scene.sampled_knob import sample_knob
from hknob_cli.spec.plan import Scene


class Trial(NamedTuple):
    """States at the samples; each array has one entry more than there are sample intervals."""

    time_s: Any
    angle_rad: Any
    velocity_rad_s: Any
    torque_nm: Any


def simulate(
    scene: Scene,
    *,
    sample_rate_hz: float,
    counts_per_rev: int | None,
    angle_rad: float,
    velocity_rad_s: float,
    phase: float = 0.5,
    samples: int,
    compiled: bool,
) -> Trial:
    """Follow one trial. Raises `ComputationError` for what this version does not have."""
    del compiled
    hand, actuator = scene.hand, scene.actuator
    beyond = (
        not scene.sampled
        or scene.encoder is None
        or counts_per_rev is None
        or scene.knob.coulomb_torque
        or scene.wall.damping
        or (hand and hand.finger)
        or (actuator and (actuator.time_constant or actuator.torque_limit is not None or actuator.torque_step))
    )
    if beyond or counts_per_rev is None:
        raise ComputationError("the exact engine does not have this scene yet")
    knob = sample_knob(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev)
    loop = knob.loop
    x, v = knob.position(angle_rad), knob.speed(velocity_rad_s)
    s, g, f = hold_coefficients(loop.alpha, loop.beta, phase)
    y = -loop.gamma - loop.beta * x
    x, v = x + s * v + g * y, f * v + s * y
    # Commands before the first are no torque: level 0.
    ring, head = np.zeros(knob.delay_line), 0
    quantum = 2.0 * pi / counts_per_rev
    angles, speeds, torques = [], [], []
    for _ in range(samples + 1):
        level = level_of(x, loop.sense)
        angles.append((x + knob.shift) * quantum)
        speeds.append(v / knob.period_s * quantum)
        torques.append(-scene.wall.stiffness * (level + loop.offset) * quantum if level < 0.0 else 0.0)
        older, newer = push(level, ring, head, loop)
        if knob.delay_line:
            head = (head + 1) % knob.delay_line
        x, v = interval(x, v, older, newer, loop)
    times = (phase + np.arange(samples + 1)) * knob.period_s
    return Trial(times, np.array(angles), np.array(speeds), np.array(torques))
