"""Predictions in words and numbers: the summary as data, and as the table on the terminal."""

from collections import Counter
from typing import Any

from hknob_cli.report.matrix import MAX_ROWS, fits, matrix, short

LIMITS = {
    "colgate_schenkel": "Colgate & Schenkel",
    "abbott_okamura": "Abbott & Okamura",
    "gil_hulin": "Gil & Hulin",
    "niemeyer": "Niemeyer",
}
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
        "limits": {name: sum(row[name] for row in passivity) for name in LIMITS},
        "binding": dict(Counter(row["binding_limb"] for row in passivity)),
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
    lines += _statistics(summary)
    return "\n".join([*lines, _limits(summary, cells)])


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
    lines = _aligned([heads, *body], left={len(wide), len(wide) + 3})
    return [*lines, f"... and {len(rows) - MAX_ROWS} more in predict.parquet"] if len(rows) > MAX_ROWS else lines


def _aligned(table: list[list[str]], *, left: set[int]) -> list[str]:
    """Lines of a table, its columns flush right but those of ``left``."""
    widths = [max(len(line[i]) for line in table) for i in range(len(table[0]))]
    return [
        "  ".join(
            f"{text:<{width}}" if i in left else f"{text:>{width}}"
            for i, (text, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in table
    ]


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
    table = [["law", "of", "cells", "", "mean", "std", "least", "largest"]]
    for law, found in summary["statistics"].items():
        for column, what in _DIFFERENCES.items():
            for suffix, which in (("", "all"), ("_in_domain", "in domain")):
                numbers = found.get(column + suffix)
                if numbers:
                    shares = [f"{100.0 * numbers[key]:+.1f}" for key in ("mean", "std", "least", "largest")]
                    shares[1] = shares[1].lstrip("+")
                    table.append([law, what, str(numbers["cells"]), which, *shares])
    title = f"difference to {summary['against']}, % of the sweep"
    return [title, *_aligned(table, left={0, 1, 3}), ""]


def _limits(summary: dict[str, Any], cells: int) -> str:
    held = ", ".join(f"{LIMITS[name]} {count}" for name, count in summary["limits"].items())
    binding = ", ".join(f"{LIMITS[name]} ({count})" for name, count in summary["binding"].items())
    return f"stability limits held, of {cells}: {held}; binding: {binding}"
