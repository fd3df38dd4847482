"""Half-sample prediction: the wall's torque for where a model says that the knob will be in the middle of the interval.

Gillespie & Cutkosky (1996), as the dissertation describes it (Section 10.4): a model simulated ahead half a time
step. The model is the hand and knob under the torque that will be held, without the push, which a controller does not
know; the torque u = max(0, -x) at the place x = (A x0 + S v0 + G kappa u) is solved for. It needs position and
velocity. The velocity is the difference of two counts, or a sensor's.
"""

from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.specs.controller import Controller


def half_sample(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: the place. Fixed: offset, S of half an interval, the part of a place left, the yielding, a sensor."""
    at = shown + fixed[0]
    pace = speed if fixed[4] > 0.0 else at - past[0]
    middle: float = (fixed[2] * at + fixed[1] * pace) * fixed[3]
    past[0] = at
    slope: float = fixed[1] * fixed[3]
    out[0] = max(-middle, 0.0)
    out[1] = -slope if middle < 0.0 else 0.0
    return abs(middle) / slope


class HalfSample(ControlLaw):
    """``sensor``: the velocity is sensed, not differenced."""

    act = staticmethod(half_sample)
    rows = places = 1
    reads_outside = True

    def __init__(self, *, sensor: bool) -> None:
        self.senses_speed = sensor

    @classmethod
    def of(cls, plan: Controller) -> "HalfSample":
        """With the numbers of a spec."""
        return cls(sensor=plan.velocity == "sensor")

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, the plant over half an interval, what is left of a torque by the way, and the sensor."""
        s, g, _ = hold_coefficients(plant.alpha, plant.beta, 0.5)
        return [plant.offset, s, 1.0 - g * plant.beta, 1.0 / (1.0 + g * plant.kappa), float(self.senses_speed)]
