"""The cells of a grid or design, in order: any run of them by number, without a list of all."""

import itertools
from collections.abc import Iterable, Iterator
from math import isfinite, prod
from typing import TYPE_CHECKING, Any

from hknob_cli.specs.plan import COUNTS, PERSON, Axes, Cell, DfaPlan, PredictPlan, SweepPlan
from hknob_cli.specs.unit_points import Points, unit_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

WHOLE = (COUNTS, PERSON)  # axes of whole numbers
_AT_ONCE = 4096  # cells of a design that are made together


def cells_of(plan: SweepPlan | DfaPlan | PredictPlan) -> "Cells":
    """The cells of a plan's grid, or of its design."""
    return cells_over(plan.axes, plan.points)


def cells_over(axes: Axes, points: Points | None) -> "Cells":
    """The cells of a grid of these axes, or of a design within their bounds."""
    return DesignCells(axes, points) if points else Cells(axes)


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
            found[name] = np.array(values, dtype=_kind(name))[at]
        return {name: found[name] for name in self.axes}


class DesignCells(Cells):
    """The points of a design, each for every person where there are people, people fastest."""

    def __init__(self, axes: Axes, points: Points) -> None:
        """``axes``: the two ends of a range, the values of a list, in the order of the columns."""
        super().__init__(axes)
        self.points = points
        self._varied = [name for name, values in axes.items() if name != PERSON and len(values) > 1]
        dimensions = len(self._varied)
        self._unit = unit_points(points.method, count=points.number, dimensions=dimensions, seed=points.seed)
        self._people = len(axes.get(PERSON, [0]))

    def __len__(self) -> int:
        return self.points.number * self._people

    def run(self, start: int, stop: int) -> Iterator[Cell]:
        """Cells ``start`` to ``stop``."""
        for begin in range(start, stop, _AT_ONCE):
            columns = self.columns(begin, min(begin + _AT_ONCE, stop))
            for values in zip(*(column.tolist() for column in columns.values()), strict=True):
                yield dict(zip(columns, values, strict=True))

    def columns(self, start: int, stop: int) -> "dict[str, NDArray[Any]]":
        """As `Cells.columns`."""
        import numpy as np

        number, person = np.divmod(np.arange(start, stop), self._people)
        first = start // self._people
        unit = self._unit.run(first, -(-stop // self._people))
        found: dict[str, NDArray[Any]] = {}
        for name, values in self.axes.items():
            if name == PERSON:
                found[name] = np.array(values, dtype=np.int64)[person]
            elif name in self._varied:
                share = unit[:, self._varied.index(name)]
                found[name] = _placed(share, name, values, self.points.scales.get(name))[number - first]
            else:
                found[name] = np.full(stop - start, values[0], dtype=_kind(name))
        return found


def _kind(name: str) -> type:
    """Type of the numbers of an axis."""
    import numpy as np

    return np.int64 if name in WHOLE else np.float64


def _placed(share: "NDArray[Any]", name: str, values: list[float | int], scale: str | None) -> "NDArray[Any]":
    """Where shares in [0, 1) lie on an axis: on a range by its scale, of a list (``scale`` None) one of its values."""
    import numpy as np

    if scale is None:
        return np.array(values, dtype=_kind(name))[(share * len(values)).astype(np.int64)]
    first, last = values
    linear = first + (last - first) * share
    found = np.asarray(log_between(first, last, share.tolist()) if scale == "log" else linear)
    found = found.clip(min(values), max(values))
    return np.asarray(np.rint(found).astype(np.int64) if name in WHOLE else found)


def log_between(first: float, last: float, shares: Iterable[float]) -> list[float]:
    """Numbers at ``shares``, 0 to 1, of the way from ``first`` to ``last``, both > 0, on a log scale.

    One by one by the C library's power: that of arrays depends on the processor, and on where in one a number is.
    """
    ratio = last / first
    if isfinite(ratio) and ratio > 0.0:
        return [first * ratio**share for share in shares]
    return [first ** (1.0 - share) * last**share for share in shares]  # further apart than floats reach
