"""Sweeps whose starts are ranges: the one start shown beside them, and of which starts a largest cycle is."""

from typing import Any

from hknob_cli.specs.plan import BESIDE, SweepPlan

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
