"""The average of a first-order hold, by extrapolation of the wall's torque, with or without correction of its error.

Ellis, Sarkar & Jenkins (1996, 1997), as the dissertation describes it (Sections 6.2, 10.4): the torque of the next
sample is extrapolated from the last two, and the mean of now and then is held; what the last mean missed is added.
Where the encoder is read faster than torque goes out, ``detections`` times an interval, the next torque is on the line
that fits all of these best. Where torque goes out faster, in ``steps``, they follow the line from now to then.
"""

from math import inf
from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller

LINE = 8.0  # sum of the weights of torques on a line that is fitted, drawn out and corrected, at most


def first_order_hold(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: the wall's last torque, the last mean. Fixed: offset, whether to correct, looks, steps."""
    now, before = depth_of(shown, fixed[0]), past[0]
    mean, acted = 1.5 * now - 0.5 * before, 0.5 * (now + before)
    count, steps = int(fixed[2]) + 1, int(fixed[3])
    if count > 1:
        total, moment = 0.0, 0.0
        for k in range(count + 1):
            w = before if k == 0 else now if k == count else depth_of(past[2 + k], fixed[0])
            total = total + w
            moment = moment + (k - 0.5 * count) * w
        slope = moment * (12.0 / ((count + 1) * (count + 2)))
        mean = 0.5 * (now + (total / (count + 1) + 1.5 * slope))
        acted = (total - 0.5 * (before + now)) / count
    missed = acted - past[1] if fixed[1] > 0.0 else 0.0
    past[0], past[1] = now, mean
    out[0] = mean + missed
    if steps > 1:
        rise = 2.0 * (mean - now)
        for k in range(steps):
            out[k] = now + (k + 0.5) / steps * rise + missed
    return inf


class FirstOrderHold(ControlLaw):
    """Mean of this torque and the next one extrapolated; ``correct``: what the last prediction missed is added."""

    act = staticmethod(first_order_hold)
    rows = 2

    def __init__(self, *, correct: bool, detections: int = 1, steps: int = 1) -> None:
        self.correct = correct
        self.looks = tuple(k / detections for k in range(1, detections))
        self.parts = tuple((k + 1) / steps - k / steps for k in range(steps))

    @classmethod
    def of(cls, plan: Controller) -> "FirstOrderHold":
        """With the numbers of a spec."""
        return cls(correct=plan.correct, detections=plan.detections, steps=plan.steps)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, whether to correct, looks, and steps."""
        return [plant.offset, float(self.correct), float(len(self.looks)), float(len(self.parts))]

    def coarseness(self, plant: Plant) -> float:
        """The weights on a line, where there is one."""
        del plant
        return LINE if self.looks or len(self.parts) > 1 else 1.0
