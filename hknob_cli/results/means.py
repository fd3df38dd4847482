"""The largest cycle of a cell, by which it is judged, and of which starts it is; the mean beside it.

The largest cycle of a cell, which it is judged by, and the mean beside it, where that is another.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from hknob_cli.specs.plan import BESIDE, SweepPlan

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


Row = dict[str, Any]


def one_start(sweep: SweepPlan) -> SweepPlan:
    """The sweep from one start in place of ranges, without levels."""
    return sweep._replace(starts=BESIDE if sweep.starts.span else sweep.starts, perceive=None)


def extent(cell: Row, sweep: SweepPlan) -> Row:
    """Whether all starts of the ranges were followed in a cell (its row of cells.parquet), and how many were drawn."""
    drawn = not cell["complete"] and cell["piece_count"] == 0
    return {"complete": cell["complete"], "random_starts": sweep.starts.random if drawn else None}


def together(rows: list[Row]) -> Row:
    """Columns `results.columns.RANGED` of several hands: all complete, the most drawn, the largest from one start."""
    drawn = [row["random_starts"] for row in rows if row["random_starts"] is not None]
    sizes = [row["p2p_one_start_rad"] for row in rows if row["p2p_one_start_rad"] is not None]
    return {
        "complete": all(row["complete"] for row in rows),
        "random_starts": max(drawn, default=None),
        "p2p_one_start_rad": max(sizes, default=None),
    }


def from_where(row: Row) -> str:
    """Of how many starts the largest cycle of a row is, in a word: all, or the number drawn."""
    return "all" if row["complete"] else str(row["random_starts"]) if row["random_starts"] else "not all"
