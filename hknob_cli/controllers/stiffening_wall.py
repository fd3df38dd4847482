"""A wall that stiffens with depth: soft at its surface, as stiff as asked for at a depth and beyond (Section 11)."""

import numpy as np

from hknob_cli.controllers.controller import Action, Plain, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import Controller


class StiffeningWall(Plain):
    """``surface``: part of the stiffness at the surface; all of it from ``depth`` (rad) on, linearly between."""

    def __init__(self, surface: float, depth: float) -> None:
        self.surface = surface
        self.depth = depth

    @classmethod
    def of(cls, plan: Controller) -> "StiffeningWall":
        """With the numbers of a spec."""
        return cls(plan.surface, plan.depth)

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """A count, in parts of the depth."""
        return (lanes.quantum_rad / self.depth,)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """Torque of a secant stiffness that rises with depth."""
        risen = np.minimum(reading.depth * fixed[0], 1.0)
        return Action((reading.depth * (self.surface + (1.0 - self.surface) * risen),), memory)
