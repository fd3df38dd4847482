"""A wall whose step from count to count comes late: a lag compensator that has a say over one count only.

torque = w - (1 - keep) clip(w - m, -1, 1), where w is the plain wall's and m its running mean. Of a step between
adjacent counts only the part ``keep`` acts at once; the rest follows over the time constant. The buzz between counts,
a relay oscillation of that step, shrinks with it, and its frequency, which does not depend on the relay's height
(physics: f = sqrt(b / 24 J T)), stays. The torque never differs from the plain wall's by more than (1 - keep) of one
count's step, and not at all once the knob is still: at rest the wall is as stiff as before.
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Plain, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import Controller


class BoundedLag(Plain):
    """``keep`` of a step at once, the rest over ``time_constant`` (s)."""

    rows = 1

    def __init__(self, keep: float, time_constant: float) -> None:
        self.keep = keep
        self.time_constant = time_constant

    @classmethod
    def of(cls, plan: Controller) -> "BoundedLag":
        """With the numbers of a spec."""
        return cls(plan.keep, plan.time_constant)

    def settling(self, lanes: PlantBatch) -> Array:
        """The mean's time constant."""
        return self.time_constant / lanes.period_s

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Part of the way that the mean goes in an interval."""
        return (-np.expm1(-lanes.period_s / self.time_constant),)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The step's part, and the mean."""
        w = reading.depth
        mean = memory[0] + fixed[0] * (w - memory[0])
        off = w - mean
        torque = w - (1.0 - self.keep) * np.minimum(np.maximum(off, -1.0), 1.0)
        return Action((torque,), mean[None], (1.0 - np.abs(off),))
