"""Of which starts a largest cycle is, where starts are ranges: all of them, or so many drawn at random."""

from typing import Any

Row = dict[str, Any]


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
