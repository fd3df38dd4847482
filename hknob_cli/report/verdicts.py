"""The answer first: what a result of many cells says, in a sentence with its scope."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from hknob_cli.report.table import short

Row = Mapping[str, Any]


def grid_verdict(cells: Sequence[Row], axes: Collection[str]) -> str:
    """Of a sweep: in how many cells it buzzes, and the largest and the smallest of the cells' largest cycles.

    ``cells``: rows of ``cells.parquet``; ``axes``: the names that vary.
    """
    buzz = [row for row in cells if row["p2p_max_rad"]]
    count = len(cells)
    if not buzz:
        rest = all(row["at_rest_fraction"] == 1.0 for row in cells)
        return f"It comes to rest in all {count} cells." if rest else f"No limit cycle in any of {count} cells."
    ends = sorted(buzz, key=lambda row: row["p2p_max_rad"])
    where = f"all {count}" if len(buzz) == count else f"{len(buzz)} of {count}"
    if len(buzz) == 1:
        return f"It buzzes in {where} cells{_scope(cells)}: {_size(ends[0])} ({_place(ends[0], axes)})."
    return (
        f"It buzzes in {where} cells{_scope(cells)}. The most: {_size(ends[-1])} ({_place(ends[-1], axes)}). "
        f"The least: {_size(ends[0])} ({_place(ends[0], axes)})."
    )


def _scope(cells: Sequence[Row]) -> str:
    """From which starts: all of the ranges that were asked for, or those that were tried."""
    if "complete" not in cells[0]:
        return ", from the starts tried"
    return (
        ", from the starts of the ranges"
        if all(row["complete"] for row in cells)
        else ", from the starts that were followed"
    )


def expected(name: str, rows: Sequence[Row]) -> str:
    """Of a formula, one row a cell: the sizes and pitches that it expects where its own assumptions hold."""
    inside = [row for row in rows if row["in_domain"]]
    of = f"{len(inside)} of {len(rows)} cells" if len(rows) > 1 else "this cell"
    if not inside:
        none = f"any of {len(rows)} cells" if len(rows) > 1 else "this cell"
        return f"{name}: its assumptions do not hold in {none}."
    cycles = [row for row in inside if row["p2p_rad"]]
    if not cycles:
        return f"{name}: no limit cycle in the cells where its assumptions hold ({of})."
    size = _range([1e3 * row["p2p_rad"] for row in cycles], "mrad peak to peak")
    pitches = [row["frequency_hz"] for row in cycles if row["frequency_hz"] is not None]
    pitch = f" at {_range(pitches, 'Hz')}" if pitches else ""
    none = f"; no limit cycle in {len(inside) - len(cycles)} of these" if len(cycles) < len(inside) else ""
    return f"{name}: {size}{pitch}, where its assumptions hold ({of}{none})."


def best_remedy(grid: Mapping[str, Row]) -> str:
    """Of a trial of remedies: which makes the largest cycles smallest over the grid, and how surely."""
    helped = {name: row for name, row in grid.items() if (row["ratio_median"] or 0.0) > 1.0}
    if not helped:
        return "No remedy makes the buzz smaller over the grid."
    name = max(helped, key=lambda key: helped[key]["ratio_median"])
    row = helped[name]
    proven = "all proven" if row["certified_fraction"] == 1.0 else f"{100.0 * row['certified_fraction']:.3g} % proven"
    least = f"at least {row['ratio_least']:.3g} times" if row["ratio_least"] else "in some cell it buzzes anew"
    return f"Smallest buzz: {name}, {row['ratio_median']:.3g} times smaller (median over the grid; {least}; {proven})."


def _size(row: Row) -> str:
    return f"{short(1e3 * row['p2p_max_rad'])} mrad at {short(row['frequency_at_max_hz'])} Hz"


def _place(row: Row, axes: Collection[str]) -> str:
    return ", ".join(f"{axis} = {short(row[axis], 6)}" for axis in axes)


def _range(values: Sequence[float], unit: str) -> str:
    low, high = short(min(values)), short(max(values))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"
