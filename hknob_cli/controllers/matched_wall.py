"""A wall designed in the digital domain: full state feedback that gives the loop the continuous wall's poles.

In the manner of Gillespie & Cutkosky (1996; dissertation, Section 10.4): with the gains l of det(zI - Phi + Gamma l)
= (z - exp(s1 T))(z - exp(s2 T)), s1 and s2 the poles of knob, hand and wall together, the knob in the wall moves from
sample to sample as against a continuous spring. It needs position and velocity, differenced or sensed.
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Differencing, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch, flow_over
from hknob_cli.specs.controller import Controller


def matched_gains(lanes: PlantBatch) -> tuple[Array, Array]:
    """Gains on position and velocity, in steps of the wall per count and per count a sample."""
    s, g, f = flow_over(lanes, 1.0)
    held = flow_over(lanes._replace(beta=lanes.beta + lanes.kappa), 1.0)
    # The trace of Phi = [[1 - beta g, s], [-beta s, f]], f = 1 - alpha s - beta g, is to become that with the wall's
    # spring; its determinant exp(-alpha) stays: g l1 + s l2 = more, (g f - s s) l1 + s l2 = 0.
    more = 2.0 * lanes.kappa * held.g + 2.0 * lanes.beta * (held.g - g) + lanes.alpha * (held.s - s)
    with np.errstate(all="ignore"):  # no gain where a hold ends at a node of the hand: the trial then diverges
        both = more / (lanes.kappa * (g * s - s * (g * f - s * s)))
        return both * s, both * (s * s - g * f)


class MatchedWall(Differencing):
    """``sensor``: the velocity is sensed, not differenced."""

    def __init__(self, *, sensor: bool) -> None:
        self.senses_speed = sensor

    @classmethod
    def of(cls, plan: Controller) -> "MatchedWall":
        """With the numbers of a spec."""
        return cls(sensor=plan.velocity == "sensor")

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Where counts lie, and the gains."""
        return (lanes.offset, *matched_gains(lanes))

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """State feedback inside the wall, nothing outside."""
        offset, place, pace = fixed
        at = reading.level + offset
        speed = at - memory[0] if reading.speed is None else reading.speed
        return Action((np.where(reading.level < 0.0, -(place * at + pace * speed), 0.0),), at[None])
