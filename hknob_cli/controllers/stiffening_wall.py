"""A wall that stiffens with depth: soft at its surface, as stiff as asked for at a depth and beyond (Section 11)."""

from math import inf
from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller


def stiffening(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """No memory. Fixed: offset, a count in parts of the depth, part of the stiffness at the surface."""
    now = depth_of(shown, fixed[0])
    out[0] = now * (fixed[2] + (1.0 - fixed[2]) * min(now * fixed[1], 1.0))
    return inf


class StiffeningWall(ControlLaw):
    """``surface``: part of the stiffness at the surface; all of it from ``depth`` (rad) on, linearly between."""

    act = staticmethod(stiffening)

    def __init__(self, surface: float, depth: float) -> None:
        self.surface = surface
        self.depth = depth

    @classmethod
    def of(cls, plan: Controller) -> "StiffeningWall":
        """With the numbers of a spec."""
        return cls(plan.surface, plan.depth)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, a count in parts of the depth, and the surface."""
        return [plant.offset, plant.quantum_rad / self.depth, self.surface]
