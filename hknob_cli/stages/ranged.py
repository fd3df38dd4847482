"""Sweeps whose starts are ranges: the one start shown beside them, and of which starts a cell's largest cycle is."""

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
