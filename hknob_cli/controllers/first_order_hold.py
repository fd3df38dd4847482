"""The average of a first-order hold, by extrapolation of the wall's torque, with or without correction of its error.

Ellis, Sarkar & Jenkins (1996, 1997), as the dissertation describes it (Sections 6.2, 10.4): the torque of the next
sample is extrapolated from the last two, and the mean of now and then is held; what the last mean missed is added.
Where the encoder is read faster than torque goes out, ``detections`` times an interval, the next torque is on the line
that fits all of these best. Where torque goes out faster, in ``steps``, they follow the line from now to then.
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Plain, Reading
from hknob_cli.controllers.plant_batch import Array, wall_depth
from hknob_cli.specs.controller import Controller


class FirstOrderHold(Plain):
    """Mean of this torque and the next one extrapolated; ``correct``: what the last prediction missed is added."""

    rows = 2
    counted: tuple[int, ...] = (0, 1)

    def __init__(self, *, correct: bool, detections: int = 1, steps: int = 1) -> None:
        self.correct = correct
        self.looks = tuple(k / detections for k in range(1, detections))
        self.parts = tuple((k + 1) / steps - k / steps for k in range(steps))

    @classmethod
    def of(cls, plan: Controller) -> "FirstOrderHold":
        """With the numbers of a spec."""
        return cls(correct=plan.correct, detections=plan.detections, steps=plan.steps)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """Torques from those of the wall at this sample, the last one and between; remembers torque and mean."""
        now, before, foretold = reading.depth, memory[0], memory[1]
        mean, acted = 1.5 * now - 0.5 * before, 0.5 * (now + before)
        if reading.seen is not None:
            ahead, acted = _fitted(np.array([before, *wall_depth(reading.seen, fixed[0]), now]))
            mean = 0.5 * (now + ahead)
        missed = acted - foretold if self.correct else np.zeros_like(now)
        steps = len(self.parts)
        rise = 2.0 * (mean - now)
        ramp = [now + (k + 0.5) / steps * rise + missed for k in range(steps)] if steps > 1 else [mean + missed]
        return Action(tuple(ramp), np.array([now, mean]))


def _fitted(torques: Array) -> tuple[Array, Array]:
    """The torque an interval after the last, on the best line, and their mean over the interval by trapezoids."""
    count = len(torques) - 1
    total, moment = np.zeros_like(torques[0]), np.zeros_like(torques[0])
    for k in range(count + 1):
        total = total + torques[k]
        moment = moment + (k - 0.5 * count) * torques[k]
    slope = moment * (12.0 / ((count + 1) * (count + 2)))
    ahead = total / (count + 1) + 1.5 * slope
    return ahead, (total - 0.5 * (torques[0] + torques[count])) / count
