"""The cells of a grid, in order: any run of them by number, without a list of all."""

import itertools
from collections.abc import Iterator
from math import prod
from typing import TYPE_CHECKING, Any

from hknob_cli.spec.plan import COUNTS, PERSON, Axes, Cell, DfaPlan, PredictPlan, SweepPlan

if TYPE_CHECKING:
    from numpy.typing import NDArray

WHOLE = (COUNTS, PERSON)  # axes of whole numbers


def cells_of(plan: SweepPlan | DfaPlan | PredictPlan) -> "Cells":
    """The cells of a plan's grid."""
    return Cells(plan.axes)


class Cells:
    """Every combination of axis values, the last axis fastest."""

    def __init__(self, axes: Axes) -> None:
        self.axes = axes

    def __len__(self) -> int:
        return prod(len(values) for values in self.axes.values())

    def __iter__(self) -> Iterator[Cell]:
        return self.run(0, len(self))

    def run(self, start: int, stop: int) -> Iterator[Cell]:
        """Cells ``start`` to ``stop``."""
        if start == 0 and stop == len(self):
            for values in itertools.product(*self.axes.values()):
                yield dict(zip(self.axes, values, strict=True))
            return
        for number in range(start, stop):
            yield self._at(number)

    def _at(self, number: int) -> Cell:
        cell: Cell = {}
        for name, values in reversed(self.axes.items()):
            number, at = divmod(number, len(values))
            cell[name] = values[at]
        return {name: cell[name] for name in self.axes}

    def columns(self, start: int, stop: int) -> "dict[str, NDArray[Any]]":
        """Values of cells ``start`` to ``stop`` by axis: float64, or int64 for counts and persons; (stop - start,)."""
        import numpy as np

        number = np.arange(start, stop)
        found: dict[str, NDArray[Any]] = {}
        for name, values in reversed(self.axes.items()):
            number, at = np.divmod(number, len(values))
            found[name] = np.array(values, dtype=np.int64 if name in WHOLE else np.float64)[at]
        return {name: found[name] for name in self.axes}
