"""Remedies over a grid, and over a further axis of it: how much each helps, and where it harms, as numbers."""

from math import inf
from statistics import median
from typing import Any

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
