"""A wall designed in the digital domain: full state feedback that gives the loop the continuous wall's poles.

In the manner of Gillespie & Cutkosky (1996; dissertation, Section 10.4): with the gains l of det(zI - Phi + Gamma l)
= (z - exp(s1 T))(z - exp(s2 T)), s1 and s2 the poles of knob, hand and wall together, the knob in the wall moves from
sample to sample as against a continuous spring. It needs position and velocity, differenced or sensed.
"""

from math import inf
from typing import Any

import numpy as np

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.specs.controller import Controller


def matched_gains(plant: Plant) -> tuple[float, float]:
    """Gains on position and velocity, in steps of the wall per count and per count a sample."""
    s, g, f = hold_coefficients(plant.alpha, plant.beta, 1.0)
    held_s, held_g, _ = hold_coefficients(plant.alpha, plant.beta + plant.kappa, 1.0)
    # The trace of Phi = [[1 - beta g, s], [-beta s, f]], f = 1 - alpha s - beta g, is to become that with the wall's
    # spring; its determinant exp(-alpha) stays: g l1 + s l2 = more, (g f - s s) l1 + s l2 = 0.
    more = 2.0 * plant.kappa * held_g + 2.0 * plant.beta * (held_g - g) + plant.alpha * (held_s - s)
    with np.errstate(all="ignore"):  # no gain where a hold ends at a node of the hand: the trial then diverges
        both = more / np.float64(plant.kappa * (g * s - s * (g * f - s * s)))
        return float(both * s), float(both * (s * s - g * f))


def matched_wall(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: the place. Fixed: offset, gains on place and pace, a sensor."""
    at = shown + fixed[0]
    pace = speed if fixed[3] > 0.0 else at - past[0]
    past[0] = at
    out[0] = -(fixed[1] * at + fixed[2] * pace) if shown < 0.0 else 0.0
    out[1] = -fixed[2] if shown < 0.0 else 0.0
    return inf


class MatchedWall(ControlLaw):
    """``sensor``: the velocity is sensed, not differenced."""

    act = staticmethod(matched_wall)
    rows = places = 1
    reads_outside = True

    def __init__(self, *, sensor: bool) -> None:
        self.senses_speed = sensor

    @classmethod
    def of(cls, plan: Controller) -> "MatchedWall":
        """With the numbers of a spec."""
        return cls(sensor=plan.velocity == "sensor")

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, the gains, and the sensor."""
        return [plant.offset, *matched_gains(plant), float(self.senses_speed)]

    def coarseness(self, plant: Plant) -> float:
        """The gains."""
        place, pace = matched_gains(plant)
        return 1.0 + abs(place) + abs(pace)
