"""Half-sample prediction: the wall's torque for where a model says that the knob will be in the middle of the interval.

Gillespie & Cutkosky (1996), as the dissertation describes it (Section 10.4): a model simulated ahead half a time
step. The model is the hand and knob under the torque that will be held, without the push, which a controller does not
know; the torque u = max(0, -x) at the place x = (A x0 + S v0 + G kappa u) is solved for. It needs position and
velocity. The velocity is the difference of two counts, or a sensor's.
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Differencing, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch, flow_over
from hknob_cli.specs.controller import Controller


class HalfSample(Differencing):
    """``sensor``: the velocity is sensed, not differenced."""

    def __init__(self, *, sensor: bool) -> None:
        self.senses_speed = sensor

    @classmethod
    def of(cls, plan: Controller) -> "HalfSample":
        """With the numbers of a spec."""
        return cls(sensor=plan.velocity == "sensor")

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Where counts lie, the plant over half an interval, and what of a torque is left by the way it goes in it."""
        s, g, _ = flow_over(lanes, 0.5)
        return lanes.offset, s, 1.0 - g * lanes.beta, 1.0 / (1.0 + g * lanes.kappa)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The plain wall's torque at the predicted place."""
        offset, s, a, yielding = fixed
        at = reading.level + offset
        speed = at - memory[0] if reading.speed is None else reading.speed
        middle = (a * at + s * speed) * yielding
        return Action((np.maximum(-middle, 0.0),), at[None], (middle,))
