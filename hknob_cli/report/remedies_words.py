"""Remedies over a grid, and over a further axis of it, in words: the tables on the terminal, the words of a picture."""

from collections.abc import Sequence
from typing import Any

from hknob_cli.report.table import table

Row = dict[str, Any]
_HEADS = ("smaller", "least", "at rest %", "proven %")


def grid_text(grid: dict[str, Row]) -> list[str]:
    """A line for each remedy, that which makes the buzz smallest first, and what the columns say."""
    wide = max(len(name) for name in grid)
    diverges = any(row["diverged_fraction"] for row in grid.values())
    heads = (*_HEADS, *(["diverge %"] if diverges else []))
    lines = ["over the grid, all cells and hands", f"{'':{wide}}  " + "".join(f"{head:>10}" for head in heads)]
    for name, row in sorted(grid.items(), key=lambda item: -(item[1]["ratio_median"] or 0.0)):
        cells = [
            times(row["ratio_median"]),
            times(row["ratio_least"]),
            *(f"{100.0 * row[part]:.3g}" for part in ("at_rest_fraction", "certified_fraction")),
            *([f"{100.0 * row['diverged_fraction']:.3g}"] if diverges else []),
        ]
        lines.append(f"{name:{wide}}  " + "".join(f"{cell:>10}" for cell in cells))
    return [
        *lines,
        "",
        "smaller: times, by the largest cycles, median of the cells and hands where the remedy does not rest;",
        "least: of the cell and hand that gain least. at rest: of all trials.",
    ]


def times(value: float | None) -> str:
    """How many times smaller, as a table has it; a dash if there is nothing to compare."""
    return "-" if value is None else f"{value:.3g}"


def over_text(axis: str, found: dict[str, list[Row]]) -> list[str]:
    """A table: a line a remedy, a column a value of the axis."""
    heads = [f"{row[axis]:.3g}" for row in next(iter(found.values()))]
    return [
        f"over {axis}: times smaller, for the hand and cell that gain least",
        *table(["", *heads], [[name, *(said(row) for row in rows)] for name, rows in found.items()], left={0}),
        "below 1: larger than with the reference. rest: all come to rest. -: nothing to compare.",
        "starts: the remedy buzzes where the reference rests. *: outside its stated domain.",
    ]


def said(row: Row) -> str:
    """How much a remedy helps at a value of the axis, in a word or a number."""
    mark = "*" if row["outside_domain"] else ""
    if row["starts"]:
        return f"starts{mark}"
    if row["rests"]:
        return f"rest{mark}"
    return "-" if row["times_least"] is None else f"{row['times_least']:.2g}{mark}"


def tuned_values(cases: list[Row], grid: list[Row], further: Sequence[str], name: str) -> str:
    """To what a remedy was tuned, at every case and over each further axis, in words; empty where it was not."""
    mine = [row for row in grid if row["remedy"] == name]
    if not mine or mine[0].get("tuned") is None:
        return ""
    said = [
        f"{row['tuned']:g} at {case}"
        for case, row in {row["case"]: row for row in cases if row["remedy"] == name}.items()
    ]
    for axis in further:
        values: dict[Any, list[float]] = {}
        for row in mine:
            values.setdefault(row[axis], []).append(row["tuned"])
        said.append(f"{', '.join(_span(some) for _, some in sorted(values.items()))} over {axis}")
    return "; ".join(said) or _span([row["tuned"] for row in mine])


def _span(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
