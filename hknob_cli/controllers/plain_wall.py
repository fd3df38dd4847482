"""The plain wall as a law: the depth of the count. It stands where no controller is given, but its loop is needed.

The general loop remembers one count. Virtual damping beside hysteresis of the encoder wants two, those of the last
sample and of the last turning point, which the loop under a law remembers.
"""

from math import inf
from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.general.laws.step import depth_of


def plain_wall(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Without memory. Fixed: offset, whether there is a wall."""
    out[0] = fixed[1] * depth_of(shown, fixed[0])
    return inf


class PlainWall(ControlLaw):
    """The virtual wall by itself."""

    act = staticmethod(plain_wall)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, and whether there is a wall."""
        return [plant.offset, float(plant.walled)]
