"""Predictions in words and numbers: the summary as data, and as the table on the terminal."""

from collections import Counter
from typing import Any

from hknob_cli.report.matrix import MAX_ROWS, fits, matrix, short
from hknob_cli.report.overlap import overlap_text
from hknob_cli.report.table import table
from hknob_cli.stages.predict.limits_text import describe_limits, limits_text

_DIFFERENCES = {
    "p2p_difference": "p2p",
    "p2p_max_difference": "p2p, to the largest",
    "frequency_difference": "frequency",
}

Rows = list[dict[str, Any]]


def describe_predictions(laws: dict[str, Rows], passivity: Rows, *, axes: list[str]) -> dict[str, Any]:
    """Summary of predictions, by law, and of stability limits as plain data."""
    return {
        "axes": {axis: list(dict.fromkeys(row[axis] for row in passivity)) for axis in axes},
        "laws": {
            law: {
                "in_domain": sum(row["in_domain"] for row in rows),
                "reasons": dict(Counter(row["reason"] for row in rows if row["reason"])),
            }
            for law, rows in laws.items()
        },
        **describe_limits(passivity),
        "cells": [row for rows in laws.values() for row in rows],
        "passivity": passivity,
    }


def predictions_text(summary: dict[str, Any], axes: list[str]) -> str:
    """The table on the terminal: two matrices a law over two axes, else one line per cell and law."""
    cells = len(summary["passivity"])
    wide = [axis for axis in axes if len(summary["axes"][axis]) > 1]
    fixed = [f"; {axis} = {short(summary['axes'][axis][0])}" for axis in axes if axis not in wide]
    inside = ", ".join(f"{law} {found['in_domain']}" for law, found in summary["laws"].items())
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    count = "1 cell" if cells == 1 else f"{cells} cells"
    lines = [f"{summary['name']}: {count}, in domain: {inside}{stale}{''.join(fixed)}"]
    if len(wide) == 2 and fits(summary["passivity"], wide):
        lines += _matrices(summary, wide)
    else:
        lines += ["", *_list(summary, wide)]
    lines += ["", *_reasons(summary)]
    lines += [*overlap_text(summary), *_statistics(summary)]
    return "\n".join([*lines, *limits_text(summary)])


def _mark(row: dict[str, Any]) -> str:
    return "" if row["in_domain"] else "~"


def _matrices(summary: dict[str, Any], wide: list[str]) -> list[str]:
    lines = []
    for law in summary["laws"]:
        rows = [row for row in summary["cells"] if row["law"] == law]
        for column, scale, what in (("p2p_rad", 1e3, "peak to peak, mrad"), ("frequency_hz", 1.0, "frequency, Hz")):
            if any(row[column] is not None for row in rows):
                lines += ["", *matrix(rows, wide, column, scale=scale, title=f"{law}: {what}", mark=_mark)]
    return lines


def _list(summary: dict[str, Any], wide: list[str]) -> list[str]:
    heads = [*wide, "law", "p2p mrad", "frequency Hz", "reason"]
    rows = summary["cells"]
    body = [
        [
            *(short(row[axis], 6) for axis in wide),
            row["law"],
            short(None if row["p2p_rad"] is None else 1e3 * row["p2p_rad"]) + _mark(row),
            short(row["frequency_hz"]),
            row["reason"],
        ]
        for row in rows[:MAX_ROWS]
    ]
    lines = table(heads, body, left={len(wide), len(wide) + 3}, keys=len(wide) + 1, flow=len(wide) + 3)
    return [*lines, f"... and {len(rows) - MAX_ROWS} more in predict.parquet"] if len(rows) > MAX_ROWS else lines


def _reasons(summary: dict[str, Any]) -> list[str]:
    lines = []
    for law, found in summary["laws"].items():
        reasons = "; ".join(f"{reason} ({count})" for reason, count in found["reasons"].items())
        lines += [f"~ outside the domain of {law}: {reasons}"] if reasons else []
    return [*lines, ""] if lines else []


def _statistics(summary: dict[str, Any]) -> list[str]:
    """Differences to the sweep over the grid, in percent of the sweep."""
    if "statistics" not in summary:
        return []
    heads = ["law", "of", "cells", "", "mean", "std", "least", "largest"]
    body = []
    for law, found in summary["statistics"].items():
        for column, what in _DIFFERENCES.items():
            for suffix, which in (("", "all"), ("_in_domain", "in domain")):
                numbers = found.get(column + suffix)
                if numbers:
                    shares = [f"{100.0 * numbers[key]:+.1f}" for key in ("mean", "std", "least", "largest")]
                    shares[1] = shares[1].lstrip("+")
                    body.append([law, what, str(numbers["cells"]), which, *shares])
    title = f"difference to {summary['against']}, % of the sweep"
    return [title, *table(heads, body, left={0, 1, 3}, keys=4), ""]
