"""Impulse damping: a torque pulse that makes good what the hold got wrong when a count was crossed (Section 11.2).

A crossing is seen at the next sample, half an interval late on average: the torque-time integral is wrong by K times
the counts crossed, times T/2. A pulse over the part ``pulse`` of the next interval gives it back, T_I = K dtheta
(T/2) / t_I. With ``detections`` above 1 a fast sub-controller reads the encoder so many times an interval, and the
integral that was wrong is known to 1/detections of it.
"""

from math import inf
from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller


def impulse_damping(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: the wall's last torque. Fixed: offset, pulse, gain, looks."""
    now, before = depth_of(shown, fixed[0]), past[0]
    looks = int(fixed[3])
    if looks == 0:
        missed = 0.5 * (now - before)
    else:
        count = looks + 1
        between = 0.0
        for i in range(looks):
            between += depth_of(past[2 + i], fixed[0])
        missed = (0.5 * now - (count - 0.5) * before + between) / count
    past[0] = now
    out[0] = now + fixed[2] * missed / fixed[1]
    if fixed[1] < 1.0:
        out[1] = now
    return inf


class ImpulseDamping(ControlLaw):
    """Length of the ``pulse`` (part of an interval), ``gain`` on its integral, ``detections`` of a crossing."""

    act = staticmethod(impulse_damping)
    rows = 1

    def __init__(self, pulse: float, gain: float, detections: int) -> None:
        self.pulse = pulse
        self.gain = gain
        self.detections = detections
        self.parts = (pulse, 1.0 - pulse) if pulse < 1.0 else (1.0,)
        self.looks = tuple(k / detections for k in range(1, detections)) if detections > 1 else ()

    @classmethod
    def of(cls, plan: Controller) -> "ImpulseDamping":
        """With the numbers of a spec."""
        return cls(plan.pulse, plan.gain, plan.detections)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, pulse, gain, and looks."""
        return [plant.offset, self.pulse, self.gain, float(len(self.looks))]

    def coarseness(self, plant: Plant) -> float:
        """The pulse is higher than the error by so much, of which each look is a term."""
        del plant
        return 1.0 + abs(self.gain) * self.detections / self.pulse
