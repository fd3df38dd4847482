"""What a controller tells apart of the encoder's counts, and the edges between that."""

from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.plant_batch import Array, count_at


class Counting(NamedTuple):
    """Rounding ``sense`` of an encoder, as in `PlantBatch`, and whether counts ``outside`` the wall are told apart.

    Where they are not, all of them are count 0.
    """

    sense: float
    outside: bool

    def at(self, x: Array) -> Array:
        """The count at positions."""
        return self.told(count_at(x, np.array([self.sense])))

    def told(self, count: Array) -> Array:
        """A count as the controller tells it from others."""
        return count + 0.0 if self.outside else np.minimum(count, 0.0)

    def lower(self, count: Array) -> Array:
        """Lower end of the positions of a count."""
        if self.sense > 0.0:
            return count
        return np.where(count > 0.0, count, count - 1.0) if self.sense == 0.0 else count - 1.0

    def upper(self, count: Array) -> Array:
        """Upper end of the positions of a count."""
        if self.sense > 0.0:
            end = count + 1.0
        elif self.sense == 0.0:
            end = np.where(count < 0.0, count, count + 1.0)
        else:
            end = count
        return end if self.outside else np.where(count >= 0.0, np.inf, end)
