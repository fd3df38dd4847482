"""A describing-function analysis on the terminal: sizes and pitches by method, and how far they are from a sweep.

How much of a grid a sweep covers that predictions are compared with.
"""

import re
from collections import Counter
from collections.abc import Sequence
from typing import Any

import pyarrow as pa

from hknob_cli.report.table import MAX_ROWS, fits, matrix, short, table
from hknob_cli.report.verdicts import expected

SWEEP_PROVES = "These are estimates: a sweep of the same scene computes the cycles, and proves them."
_NUMBER = re.compile(r"\b\d+(\.\d+)?(e[-+]?\d+)?\b")  # of a cell, in the reason; cells are counted together


def overlap_text(summary: dict[str, Any]) -> list[str]:
    """A line where the sweep has some of the cells only; nothing where it has all, or there is none."""
    found = summary.get("overlap")
    if not found or found["with_partner"] == found["cells"]:
        return []
    return [f"{found['with_partner']} of {found['cells']} cells are in the sweep, too; only these are compared with it"]


def describe_dfa(table: pa.Table, *, axes: list[str], statistics: dict[str, Any] | None) -> dict[str, Any]:
    """Summary as plain data; ``statistics`` by method where there is a sweep to compare with."""
    rows = table.to_pylist()
    return {
        "axes": {axis: list(dict.fromkeys(row[axis] for row in rows)) for axis in axes},
        "methods": list(dict.fromkeys(row["method"] for row in rows)),
        **({"statistics": statistics} if statistics else {}),
        "rows": rows,
    }


def dfa_text(summary: dict[str, Any]) -> str:
    """Matrices of each method over two axes, or a list; marks say what is out of domain or ambiguous."""
    rows = summary["rows"]
    wide = [axis for axis, values in summary["axes"].items() if len(values) > 1]
    fixed = [f"{axis} = {short(values[0])}" for axis, values in summary["axes"].items() if axis not in wide]
    cells = len({tuple(row[axis] for axis in summary["axes"]) for row in rows})
    lines = [
        f"{summary['name']}: {cells} cell{'s' if cells != 1 else ''} by {', '.join(summary['methods'])}"
        + "".join(f"; {f}" for f in fixed)
    ]
    axes = list(summary["axes"])
    of = {method: [row for row in rows if row["method"] == method] for method in summary["methods"]}
    lines += ["", *(expected(method, largest_cycles(found, axes)) for method, found in of.items()), SWEEP_PROVES]
    if not wide:
        lines += ["", *_one_cell(rows)]
    for method in summary["methods"] if wide else ():
        lines += ["", *_method(method, of[method], wide)]
    notes = [*_notes(rows, axes), *overlap_text(summary), *_listed(rows, axes)]
    lines += ["", *notes] if notes else []
    for method, groups in summary.get("statistics", {}).items():
        lines += ["", *statistics_lines(method, groups)]
    return "\n".join(lines)


def _method(method: str, rows: list[dict[str, Any]], wide: list[str]) -> list[str]:
    counts: dict[tuple[Any, ...], int] = {}
    for row in rows:
        key = tuple(row[axis] for axis in wide)
        counts[key] = counts.get(key, 0) + 1
    # Of several cycles the table shows the largest; all are in the file.
    last = [{**row, "several": counts[tuple(row[axis] for axis in wide)] > 1} for row in largest_cycles(rows, wide)]
    if len(wide) == 2 and fits(rows, wide):
        size = f"{method}: peak to peak, mrad"
        return [
            *matrix(last, wide, "p2p_rad", scale=1e3, title=size, mark=_mark),
            *matrix(last, wide, "frequency_hz", scale=1.0, title=f"{method}: frequency, Hz", mark=_mark),
        ]
    heads = [*wide, "p2p mrad", "frequency Hz", ""]
    body = []
    for row in last[:MAX_ROWS]:
        p2p = None if row["p2p_rad"] is None else 1e3 * row["p2p_rad"]
        body.append([*(short(row[axis], 6) for axis in wide), short(p2p), short(row["frequency_hz"]), _mark(row)])
    lines = [f"{method}:", *table(heads, body, left={len(heads) - 1}, keys=len(wide) or 1)]
    return [*lines, f"  ... and {len(last) - MAX_ROWS} more cells in dfa.parquet"] if len(last) > MAX_ROWS else lines


def _one_cell(rows: list[dict[str, Any]]) -> list[str]:
    """Every cycle of every method."""
    body = [
        [
            row["method"],
            short(None if row["p2p_rad"] is None else 1e3 * row["p2p_rad"]),
            short(row["frequency_hz"]),
            "" if row["in_domain"] else "~",
        ]
        for row in rows
    ]
    return table(["method", "p2p mrad", "frequency Hz", ""], body, left={0, 3})


def largest_cycles(rows: list[dict[str, Any]], axes: Sequence[str]) -> list[dict[str, Any]]:
    """One row for each cell of the axes: of several cycles of one method the largest."""
    best: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        key = tuple(row[axis] for axis in axes)
        if key not in best or (row["p2p_rad"] or 0.0) > (best[key]["p2p_rad"] or 0.0):
            best[key] = row
    return list(best.values())


def nearest_cycles(rows: list[dict[str, Any]], axes: list[str]) -> list[dict[str, Any]]:
    """One row a cell: of several cycles the one nearest to the sweep in peak to peak."""
    best: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        key = tuple(row[axis] for axis in axes)
        difference = row["p2p_difference"]
        known = best.get(key, {}).get("p2p_difference")
        if key not in best or (difference is not None and (known is None or abs(difference) < abs(known))):
            best[key] = row
    return list(best.values())


def _mark(row: dict[str, Any]) -> str:
    return ("*" if row["several"] else "") + ("" if row["in_domain"] else "~")


def _notes(rows: list[dict[str, Any]], axes: list[str]) -> list[str]:
    said: dict[tuple[str, str], Counter[str]] = {}  # by method, and by reason without its number
    for row in rows:
        for reason in filter(None, row["reason"].split("; ")):
            said.setdefault((row["method"], _NUMBER.sub("…", reason, count=1)), Counter())[reason] += 1
    cells: dict[tuple[Any, ...], int] = {}
    for row in rows:
        key = (row["method"], *(row[axis] for axis in axes))
        cells[key] = cells.get(key, 0) + 1
    several = max(cells.values()) > 1 and len({key[1:] for key in cells}) > 1
    notes = ["* several limit cycles, the largest shown"] if several else []
    for method in dict.fromkeys(method for method, _ in said):
        why = [
            f"{reason if len(found) > 1 else next(iter(found))} ({found.total()})"
            for (of, reason), found in said.items()
            if of == method
        ]
        notes.append(f"~ outside the domain of {method}: {'; '.join(why)}")
    return notes


def _listed(rows: list[dict[str, Any]], axes: list[str]) -> list[str]:
    """How the cycles found by formula and the complete lists of the sweep agree; nothing without such lists."""
    some = [row for row in rows if row.get("listed_count") is not None]
    if not some:
        return []
    counts = {tuple(row[axis] for axis in axes): row["listed_count"] for row in some}
    found = [row["listed"] for row in some if row["listed"] is not None]
    both, every = sum(found), sum(counts.values())
    cells = "cell" if len(counts) == 1 else f"{len(counts)} cells"
    lines = [f"sampled against the complete list{'s' * (len(counts) > 1)} of the {cells}:"]
    lines.append(f"  {both} of its {len(found)} cycles are listed" + ("" if both == len(found) else ";"))
    if both < len(found):
        lines[-1] += f" no start of the sweep ends in the other {len(found) - both}"
    if both < every:
        lines.append(f"  the lists have {every - both} more: over more than two levels, or of several turns a period")
    return lines


def statistics_lines(name: str, groups: dict[str, Any]) -> list[str]:
    """Differences from a sweep over the grid, in percent, as the dissertation states them."""
    titles = {
        "p2p_difference": "peak to peak",
        "p2p_max_difference": "peak to peak, to the largest",
        "amplitude_difference": "its half against peak to peak",
        "frequency_difference": "frequency",
    }
    nearest = " (of several cycles the nearest)" if name == "sampled" else ""
    body = []
    for key, found in groups.items():
        if found is not None:
            title = titles[key.removesuffix("_in_domain")] + (", in domain" if key.endswith("_in_domain") else "")
            shares = [f"{100 * found[part]:.1f}" for part in ("mean", "std", "least", "largest")]
            body.append([title, str(found["cells"]), *shares])
    heads = ["of", "cells", "mean", "std", "least", "largest"]
    return [f"{name} against the sweep, %{nearest}", *table(heads, body, left={0})]
