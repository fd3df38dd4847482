"""Remedies over a grid, and over a further axis of it: where each helps and where it harms."""

from collections.abc import Sequence
from math import inf
from statistics import median
from typing import Any

from hknob_cli.report.table import table

Row = dict[str, Any]


def over_the_grid(rows: list[Row]) -> dict[str, Row]:
    """Each remedy by name, over all cells and hands of ``remedies.parquet``."""
    return {name: _grid(rows, name) for name in dict.fromkeys(row["remedy"] for row in rows)}


def _grid(rows: list[Row], name: str) -> Row:
    """A remedy over the grid, where the reference buzzes in the same cell: median and least of how much smaller."""
    mine = [row for row in rows if row["remedy"] == name]
    ratios = [row["p2p_ratio"] for row in mine if row["p2p_ratio"] is not None]
    return {
        "cells": len(mine),
        "at_rest_fraction": sum(row["at_rest_fraction"] for row in mine) / len(mine),
        "certified_fraction": sum(row["certified_fraction"] for row in mine) / len(mine),
        "diverged_fraction": sum(row["diverged_fraction"] for row in mine) / len(mine),
        "ratio_median": median(ratios) if ratios else None,
        "ratio_least": min(ratios) if ratios else None,
    }


def over_axis(rows: list[Row], axis: str) -> dict[str, list[Row]]:
    """Of every remedy, at each value of the axis, how many times smaller the largest cycle is: least and median.

    Cells where reference and remedy both rest say nothing; where only the remedy rests it is infinitely smaller, which
    is None in ``times_least`` with ``rests`` set. ``starts``: cells where the remedy buzzes and the reference rests.
    """
    found: dict[str, list[Row]] = {}
    values = sorted({row[axis] for row in rows})
    for name in dict.fromkeys(row["remedy"] for row in rows):
        mine = [row for row in rows if row["remedy"] == name]
        found[name] = [{axis: value, **_together([row for row in mine if row[axis] == value])} for value in values]
    return found


def _together(rows: list[Row]) -> Row:
    ratios = sorted(inf if _rests(row) else row["p2p_ratio"] for row in rows if _rests(row) or _compared(row))
    moves = [one for one in ratios if one < inf]
    return {
        "cells": len(rows),
        "times_least": moves[0] if moves else None,
        "times_median": median(ratios) if ratios and median(ratios) < inf else None,
        "rests": bool(ratios) and not moves,
        "starts": sum(row["p2p_ratio"] == 0.0 for row in rows),
        "worse": sum(one < 1.0 for one in ratios),
        "outside_domain": sum(row.get("in_domain") is False for row in rows),
    }


def _rests(row: Row) -> bool:
    """Whether all trials come to rest, and none is undecided."""
    return bool(row["p2p_max_rad"] == 0.0 and row["at_rest_fraction"] > 1.0 - 1e-9)


def _compared(row: Row) -> bool:
    return row["p2p_ratio"] is not None


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
