"""Half-sample prediction: the wall's torque for where a model says that the knob will be in the middle of the interval.

Gillespie & Cutkosky (1996), as the dissertation describes it (Section 10.4). The model is the hand and knob without the
push, which a controller does not know; it needs position and velocity. The velocity is the difference of two counts, or a
sensor's.
"""

import numpy as np

from hknob_cli.remedies.lanes import Array, Lanes, flow_over
from hknob_cli.remedies.remedy import Action, Plain, Reading


class HalfSample(Plain):
    """``sensor``: the velocity is sensed, not differenced."""

    rows = 2

    def __init__(self, *, sensor: bool) -> None:
        self.senses_speed = sensor

    def constants(self, lanes: Lanes) -> tuple[Array, ...]:
        """Where counts lie, the plant over half an interval, and the torque's effect."""
        return (lanes.offset, *flow_over(lanes, 0.5), lanes.kappa, lanes.beta)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The plain wall's torque at the predicted place."""
        offset, s, g, _, kappa, beta = fixed
        at = reading.count + offset
        speed = at - memory[0] if reading.speed is None else reading.speed
        middle = at + s * speed + g * (kappa * memory[1] - beta * at)
        torque = np.maximum(-middle, 0.0)
        return Action((torque,), np.stack([at, torque]), (middle,))
