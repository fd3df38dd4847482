"""A describing-function analysis on the terminal: sizes and pitches by method, and how far they are from a sweep."""

from typing import Any

import pyarrow as pa

from hknob_cli.report.matrix import MAX_ROWS, fits, matrix, short


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
    lines = [f"{summary['name']}: {cells} cells by {', '.join(summary['methods'])}" + "".join(f"; {f}" for f in fixed)]
    for method in summary["methods"]:
        of = [row for row in rows if row["method"] == method]
        lines += ["", *_method(method, of, wide)]
    lines += ["", *_notes(rows)]
    for method, groups in summary.get("statistics", {}).items():
        lines += ["", *statistics_lines(method, groups)]
    return "\n".join(lines)


def _method(method: str, rows: list[dict[str, Any]], wide: list[str]) -> list[str]:
    counts: dict[tuple[Any, ...], int] = {}
    for row in rows:
        key = tuple(row[axis] for axis in wide)
        counts[key] = counts.get(key, 0) + 1
    # Of several cycles the table shows the largest; all are in the file.
    last = [{**row, "several": counts[tuple(row[axis] for axis in wide)] > 1} for row in _largest(rows, wide)]
    if len(wide) == 2 and fits(rows, wide):
        size = f"{method}: peak to peak, mrad"
        return [
            *matrix(last, wide, "p2p_rad", scale=1e3, title=size, mark=_mark),
            *matrix(last, wide, "frequency_hz", scale=1.0, title=f"{method}: frequency, Hz", mark=_mark),
        ]
    lines = [f"{method}: {'  '.join([*wide, 'p2p mrad', 'frequency Hz'])}"]
    for row in last[:MAX_ROWS]:
        p2p = None if row["p2p_rad"] is None else 1e3 * row["p2p_rad"]
        values = [*(short(row[axis], 6) for axis in wide), short(p2p), short(row["frequency_hz"])]
        lines.append("  " + "  ".join(f"{value:>12}" for value in values) + f" {_mark(row)}")
    return [*lines, f"  ... and {len(last) - MAX_ROWS} more cells in dfa.parquet"] if len(last) > MAX_ROWS else lines


def _largest(rows: list[dict[str, Any]], wide: list[str]) -> list[dict[str, Any]]:
    best: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        key = tuple(row[axis] for axis in wide)
        if key not in best or (row["p2p_rad"] or 0.0) > (best[key]["p2p_rad"] or 0.0):
            best[key] = row
    return list(best.values())


def _mark(row: dict[str, Any]) -> str:
    return ("*" if row["several"] else "") + ("" if row["in_domain"] else "~")


def _notes(rows: list[dict[str, Any]]) -> list[str]:
    notes = ["* several limit cycles, the largest shown"]
    reasons = {part.split(" is ")[0] for row in rows for part in row["reason"].split("; ") if part}
    if reasons:
        notes.append("~ out of the method's domain; the column `reason` says why")
    return notes


def statistics_lines(name: str, groups: dict[str, Any]) -> list[str]:
    """Differences from a sweep over the grid, in percent, as the dissertation states them."""
    titles = {
        "p2p_difference": "peak to peak",
        "p2p_max_difference": "peak to peak, to the largest cycle",
        "amplitude_difference": "its half against peak to peak",
        "frequency_difference": "frequency",
    }
    nearest = " (of several cycles the nearest)" if name == "sampled" else ""
    lines = [f"{name} against the sweep, %{nearest}"]
    for key, found in groups.items():
        if found is None:
            continue
        title = titles[key.removesuffix("_in_domain")] + (", in domain" if key.endswith("_in_domain") else "")
        low, high, mean, std = (100 * found[part] for part in ("least", "largest", "mean", "std"))
        lines.append(
            f"  {title:42} {found['cells']:4} cells: mean {mean:7.1f}, std {std:6.1f}, from {low:7.1f} to {high:7.1f}"
        )
    return lines
