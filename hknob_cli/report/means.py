"""The largest cycle of a cell, which it is judged by, and the mean beside it, where that is another."""

from collections.abc import Mapping, Sequence
from typing import Any

WORST = ("p2p_max_rad", "frequency_at_max_hz")  # columns of size and pitch that cells are judged by
ONE = ("p2p_rad", "frequency_hz")  # those of a law or method, which has one cycle a cell; of cells the means
MEANS = dict(zip(WORST, ONE, strict=True))
SAME = 5e-4  # a mean this near to the largest is not told: a table shows no more digits


def mean_beside(cell: Mapping[str, Any], column: str) -> float | None:
    """The mean over the trials that cycle, in the unit of the ``column``; None where it is that of the largest cycle.

    ``column``: one of `MEANS`; any other has no mean.
    """
    largest, mean = cell.get(column), cell.get(MEANS.get(column, ""))
    if not largest or mean is None or abs(mean / largest - 1.0) <= SAME:
        return None
    return float(mean)


def differs(cells: Sequence[Mapping[str, Any]]) -> bool:
    """Whether any cell has cycles of several sizes or pitches."""
    return any(mean_beside(cell, column) is not None for cell in cells for column in MEANS)
