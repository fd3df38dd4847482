"""Impulse damping: a torque pulse that makes good what the hold got wrong when a count was crossed (Section 11.2).

A crossing is seen at the next sample, half an interval late on average: the torque-time integral is wrong by K times
the counts crossed, times T/2. A pulse over the part ``pulse`` of the next interval gives it back, T_I = K dtheta
(T/2) / t_I. With ``detections`` above 1 a fast sub-controller reads the encoder so many times an interval, and the
integral that was wrong is known to 1/detections of it.
"""

from hknob_cli.controllers.controller import Action, Plain, Reading
from hknob_cli.controllers.plant_batch import Array, wall_depth
from hknob_cli.specs.controller import Controller


class ImpulseDamping(Plain):
    """Length of the ``pulse`` (part of an interval), ``gain`` on its integral, ``detections`` of a crossing."""

    rows = 1
    counted: tuple[int, ...] = (0,)

    def __init__(self, pulse: float, gain: float, detections: int) -> None:
        self.pulse = pulse
        self.gain = gain
        self.parts = (pulse, 1.0 - pulse) if pulse < 1.0 else (1.0,)
        self.looks = tuple(k / detections for k in range(1, detections)) if detections > 1 else ()

    @classmethod
    def of(cls, plan: Controller) -> "ImpulseDamping":
        """With the numbers of a spec."""
        return cls(plan.pulse, plan.gain, plan.detections)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The wall, and before it the pulse."""
        now, before = reading.depth, memory[0]
        if reading.seen is None:
            missed = 0.5 * (now - before)
        else:
            # A crossing lies half a detection before it is seen, as it does half an interval without any: the sum of
            # the steps between detections i and i + 1 of n, each late by (n - i - 1/2)/n, by parts.
            count = len(reading.seen) + 1
            between = wall_depth(reading.seen, fixed[0]).sum(axis=0)
            missed = (0.5 * now - (count - 0.5) * before + between) / count
        pulse = now + self.gain * missed / self.pulse
        return Action((pulse, now) if self.pulse < 1.0 else (pulse,), now[None])
