"""A trial of remedies on the terminal: at every case, what each leaves of the buzz, at what pitch, at what cost."""

from statistics import median
from typing import Any

import pyarrow as pa

from hknob_cli.report.matrix import short
from hknob_cli.report.table import table

Row = dict[str, Any]
LEVELS = ("touch_db", "touch_change_db", "hearing_change_db")
_HEAD = ("p2p mrad", "smaller", "Hz", "static K", "knock", "grid", "proven %")
_FELT = ("touch dB", "louder", "by ear")


def describe_trial(grid: pa.Table, cases: pa.Table) -> dict[str, Any]:
    """Summary as plain data: of every case and remedy the hands together, the remedy that does most first."""
    over = grid.to_pylist()
    rows = cases.to_pylist()
    everywhere = {name: _grid(over, name) for name in dict.fromkeys(row["remedy"] for row in over)}
    found: dict[str, list[Row]] = {}
    for case in dict.fromkeys(row["case"] for row in rows):
        here = [
            _together([row for row in rows if row["case"] == case and row["remedy"] == name]) for name in everywhere
        ]
        found[case] = sorted(here, key=lambda row: row["p2p_rad"] if row["p2p_rad"] is not None else 1e9)
    loose = sum((row.get("undecided_fraction") or 0.0) > 0.0 for row in (*over, *rows))
    hands = list(dict.fromkeys(row["hand"] for row in over))
    return {"hands": hands, "grid": everywhere, "cases": found, "undecided": loose}


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


def _together(rows: list[Row]) -> Row:
    """Hands together: the largest motion and its pitch, the least gain, and the means of what it costs."""
    moving = [row for row in rows if row["p2p_rad"] is not None]
    worst = max(moving, key=lambda row: row["p2p_rad"]) if moving else None
    ratios = [row["p2p_ratio"] for row in rows if row["p2p_ratio"] is not None]
    return {
        "remedy": rows[0]["remedy"],
        "needs": rows[0]["needs"],
        "p2p_rad": worst["p2p_rad"] if worst else None,
        "frequency_hz": worst["frequency_hz"] if worst else None,
        "hand": worst["hand"] if worst else None,
        "ratio_least": min(ratios) if ratios else None,
        "at_rest_fraction": sum(row["at_rest_fraction"] for row in rows) / len(rows),
        "diverged_fraction": sum(row["diverged_fraction"] for row in rows) / len(rows),
        "certified_fraction": sum(row["certified_fraction"] for row in rows) / len(rows),
        "stiffness_kept": _mean(rows, "stiffness_kept"),
        "knock_ratio": _mean(rows, "knock_ratio"),
        **({name: _most(rows, name) for name in LEVELS} if LEVELS[0] in rows[0] else {}),
    }


def _most(rows: list[Row], column: str) -> float | None:
    """Of the hand that notices most."""
    return max((row[column] for row in rows if row[column] is not None), default=None)


def _mean(rows: list[Row], column: str) -> float | None:
    values = [row[column] for row in rows if row[column] is not None]
    return sum(values) / len(values) if values else None


def trial_text(summary: dict[str, Any]) -> str:
    """A table of each case, and what its columns say."""
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    remedies, hands = len(summary["grid"]), len(summary["hands"])
    cells = next(iter(summary["grid"].values()))["cells"] // hands
    lines = [f"{summary['name']}: {remedies} remedies, {hands} hands, a grid of {cells} cells{stale}"]
    felt = any(LEVELS[0] in row for rows in summary["cases"].values() for row in rows)
    heads = (*_HEAD, *(_FELT if felt else ()))
    for case, rows in summary["cases"].items():
        body = [[row["remedy"], *_line(row, summary["grid"][row["remedy"]], len(heads))] for row in rows]
        lines += ["", f"{case}: of the hand that buzzes most", *table(["", *heads], body, left={0})]
    lines += [
        "",
        "smaller: times, for the hand that gains least; 0 where the reference rests and the remedy does not.",
        "static K: stiffness under a steady push, and knock: depth of a quick knock, both over the reference's.",
        "grid: median over cells and hands of how many times smaller.",
    ]
    if felt:
        lines += [
            "touch dB: above threshold. louder: dB that it is felt more than the reference, by ear: that it sounds",
            "louder; of the hand that notices most.",
        ]
        if summary["undecided"]:
            lines.append(f"{summary['undecided']} rows have trials that never repeat: those have no level.")
    return "\n".join(lines)


def _line(row: Row, grid: Row, count: int) -> list[str]:
    if row["p2p_rad"] is None:
        return ["diverges", *[""] * 4, _times(grid["ratio_median"]), *[""] * (count - 6)]
    return [
        "rest" if row["p2p_rad"] == 0.0 else short(1e3 * row["p2p_rad"]),
        "rest" if row["p2p_rad"] == 0.0 else _times(row["ratio_least"]),
        "" if row["p2p_rad"] == 0.0 else short(row["frequency_hz"]),
        _times(row["stiffness_kept"]),
        _times(row["knock_ratio"]),
        _times(grid["ratio_median"]),
        f"{100 * row['certified_fraction']:.0f}",
        *(decibel(row[name], signed=name != "touch_db") for name in LEVELS if name in row),
    ]


def _times(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def decibel(value: float | None, *, signed: bool = False) -> str:
    """A level; a dash for none."""
    return "-" if value is None else f"{value:+.1f}" if signed else f"{value:.1f}"
