"""A wall whose step from count to count comes late: a lag compensator that has a say over one count only.

torque = w - (1 - keep) clip(w - m, -1, 1), where w is the plain wall's and m its running mean. Of a step between
adjacent counts only the part ``keep`` acts at once; the rest follows over the time constant. The buzz between counts,
a relay oscillation of that step, shrinks with it, and its frequency, which does not depend on the relay's height
(physics: f = sqrt(b / 24 J T)), stays. The torque never differs from the plain wall's by more than (1 - keep) of one
count's step, and not at all once the knob is still: at rest the wall is as stiff as before.
"""

from math import inf
from typing import Any

import numpy as np

from hknob_cli.controllers.controller import LONGEST, ControlLaw, Fading, Plant
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller


def bounded_lag(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: the wall's running mean. Fixed: offset, its part of the way, what of a step acts at once."""
    w = depth_of(shown, fixed[0])
    past[0] = past[0] + fixed[1] * (w - past[0])
    out[0] = w - (1.0 - fixed[2]) * min(max(w - past[0], -1.0), 1.0)
    return inf


class BoundedLag(ControlLaw):
    """``keep`` of a step at once, the rest over ``time_constant`` (s)."""

    act = staticmethod(bounded_lag)
    rows = 1

    def __init__(self, keep: float, time_constant: float) -> None:
        self.keep = keep
        self.time_constant = time_constant

    @classmethod
    def of(cls, plan: Controller) -> "BoundedLag":
        """With the numbers of a spec."""
        return cls(plan.keep, plan.time_constant)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, the part of the way that the mean goes in an interval, and what acts at once."""
        return [plant.offset, float(-np.expm1(-plant.period_s / self.time_constant)), self.keep]

    def settling(self, plant: Plant) -> float:
        """The mean's time constant."""
        return self.time_constant / plant.period_s

    def fading(self, plant: Plant) -> Fading:
        """The mean."""
        return Fading(0, min(float(np.exp(-plant.period_s / self.time_constant)), LONGEST), 1.0 - self.keep)
