"""Passivity, stability and further criteria in words: which limits hold, and what would satisfy them.

Predictions in words and numbers: the summary as data, and as the table on the terminal.
"""

from collections import Counter
from math import ceil, floor, log10
from typing import Any

from hknob_cli.report.table import MAX_ROWS, fits, matrix, short, table
from hknob_cli.report.theory import LIMITS, SWEEP_PROVES, overlap_text, passive_verdict
from hknob_cli.report.verdicts import expected

_WITH_HAND = "_with_hand"

Rows = list[dict[str, Any]]

_DIFFERENCES = {
    "p2p_difference": "p2p",
    "p2p_max_difference": "p2p, to the largest",
    "frequency_difference": "frequency",
}


def describe_limits(rows: Rows) -> dict[str, Any]:
    """Cells that satisfy each limit, and what binds; with the hand's damping too where the scene has a hand."""
    found: dict[str, Any] = {
        "device_passive": sum(row["device_passive"] for row in rows),
        "limits": {name: sum(row[name] for row in rows) for name in LIMITS},
        "binding": dict(Counter(row["binding_limb"] for row in rows)),
    }
    if _has_hand(rows):
        found["limits_with_hand"] = {name: sum(row[_with_hand(row, name)] for row in rows) for name in LIMITS}
        found["binding_with_hand"] = dict(Counter(_plain(row["binding_limb_with_hand"]) for row in rows))
    return found


def limits_text(summary: dict[str, Any]) -> list[str]:
    """Lines under the predictions: passive or not, the limits one by one, and what would satisfy them."""
    rows: Rows = summary["passivity"]
    passive, one = summary["device_passive"], len(rows) == 1
    how_many = ("yes" if passive else "no") if one else f"{passive} of {len(rows)} cells"
    held = summary["limits"]
    lines = [
        f"passive, whoever holds the knob: {how_many}",
        "  by its own damping: " + _counts(held, ("colgate_schenkel", "abbott_okamura"), one=one),
    ]
    if _has_hand(rows):
        names = ("gil_hulin", "colgate_schenkel", "abbott_okamura")
        lines.append("  with the hand's: " + _counts(summary["limits_with_hand"], names, one=one))
    else:
        lines.append("  stable with no hand on it: " + _counts(held, ("gil_hulin",), one=one))
    lines.append("  by friction alone: " + _counts(held, ("niemeyer",), one=one))
    binding = (LIMITS[name] + ("" if one else f" {count}") for name, count in summary["binding"].items())
    return [*lines, f"  largest load: {', '.join(binding)}", *_needs(rows)]


def _counts(held: dict[str, int], names: tuple[str, ...], *, one: bool) -> str:
    return ", ".join(f"{LIMITS[name]} {('yes' if held[name] else 'no') if one else held[name]}" for name in names)


def _needs(rows: Rows) -> list[str]:
    """What would satisfy all limits; none where all hold."""
    if all(row[name] for row in rows for name in LIMITS):
        return []
    damping, rate = "damping_needed_nm_s_per_rad", "rate_needed_hz"
    lines = [
        "needed to satisfy all of them, at least:",
        "  damping of the knob " + _either(rows, (damping, "N·m·s/rad"), (rate, "a sample rate of", "Hz")),
        "  friction " + _either(rows, ("friction_needed_nm", "N·m"), ("counts_needed", "an encoder of", "counts")),
    ]
    if _has_hand(rows):
        damping, rate = "damping_needed_with_hand_nm_s_per_rad", "rate_needed_with_hand_hz"
        both = _either(rows, (damping, "N·m·s/rad"), (rate, "a sample rate of", "Hz"))
        lines.append(f"  with the hand's damping, both together {both}")
    return lines


def _either(rows: Rows, first: tuple[str, str], second: tuple[str, str, str]) -> str:
    """Two ways to satisfy the limits: a column and its unit, and another that may be enough in no cell."""
    column, article, unit = second
    known = [row[column] for row in rows if row[column] is not None]
    text = _span([row[first[0]] for row in rows], first[1])
    noun = article.split()[1:-1]
    none = f"no {' '.join(noun)} is enough"
    if not known:
        return f"{text} ({none})"
    less = len(rows) - len(known)
    return f"{text}, or {article} {_span(known, unit)}" + (f" (in {less} cells {none})" if less else "")


def _span(values: list[float], unit: str) -> str:
    low, high = _round_up(min(values)), _round_up(max(values))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def _round_up(value: float) -> str:
    """A need in four digits, never less than it is."""
    if value <= 0.0:
        return "0"
    step = 10.0 ** (floor(log10(value)) - 3)
    return f"{ceil(value / step * (1.0 - 1e-12)) * step:.4g}"


def _has_hand(rows: Rows) -> bool:
    return "binding_limb_with_hand" in rows[0]


def _with_hand(row: dict[str, Any], name: str) -> str:
    """The column of a limit with the hand's damping: its own where the hand is in it anyway, or makes no difference."""
    return name + _WITH_HAND if name + _WITH_HAND in row else name


def _plain(name: str) -> str:
    return name.removesuffix(_WITH_HAND)


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
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    count = "1 cell" if cells == 1 else f"{cells} cells"
    lines = [f"{summary['name']}: {count} by {', '.join(summary['laws'])}{stale}{''.join(fixed)}"]
    lines += [
        "",
        passive_verdict(summary["passivity"]),
        *(expected(law, [row for row in summary["cells"] if row["law"] == law]) for law in summary["laws"]),
    ]
    lines += [SWEEP_PROVES]
    if len(wide) == 2 and fits(summary["passivity"], wide):
        lines += _matrices(summary, wide)
    else:
        lines += ["", *_list(summary, wide)]
    lines += ["", *_reasons(summary)]
    lines += [*overlap_text(summary), *_statistics(summary)]
    return "\n".join([*lines, *limits_text(summary), *criteria_text(summary)])


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


ABOUT = {
    "tsypkin": "Tsypkin, no oscillation in this hand",
    "tsai_colgate": "Tsai & Colgate, no oscillation in this hand",
    "miller": "Miller, no oscillation, by the damping of knob and hand",
    "love_book": "Love & Book, the knob alone is stable",
    "llewellyn": "Llewellyn, stable as a virtual coupling, by the knob's damping",
}


def describe_criteria(rows: Rows) -> dict[str, Any]:
    """Cells by criterion: how many hold, how many have counts within its limit; those that cycle in the sweep."""
    groups: dict[str, Rows] = {}
    for row in rows:
        groups.setdefault(row["criterion"], []).append(row)
    return {name: _described(found) for name, found in groups.items()}


def _described(rows: Rows) -> dict[str, Any]:
    found: dict[str, Any] = {
        "cells": len(rows),
        "holds": sum(row["holds"] is True for row in rows),
        "in_domain": sum(row["in_domain"] for row in rows),
        "reasons": dict(Counter(row["reason"] for row in rows if row["reason"])),
    }
    compared = [row for row in rows if row.get("sweep_cycles") is not None and row["holds"] is not None]
    if compared:
        found["sweep"] = {
            where: {"cells": len(some), "cycle": sum(row["sweep_cycles"] for row in some)}
            for where, some in (
                ("holds", [row for row in compared if row["holds"]]),
                ("does not hold", [row for row in compared if not row["holds"]]),
            )
        }
    return found


def criteria_text(summary: dict[str, Any]) -> list[str]:
    """Lines under the limits; nothing where no criterion is asked for."""
    if "criteria" not in summary:
        return []
    lines = ["", "further criteria, of the wall without counts:"]
    for name, found in summary["criteria"].items():
        one = found["cells"] == 1
        says = ("yes" if found["holds"] else "no") if one else f"{found['holds']} of {found['cells']} cells"
        if not found["in_domain"]:
            says += f" (~ {', '.join(found['reasons'])})"
        lines.append(f"  {ABOUT[name]}: {says}")
        for where, counted in found.get("sweep", {}).items():
            if counted["cells"]:
                lines.append(
                    f"    where it {where}, the sweep cycles in {counted['cycle']} of {counted['cells']} cells"
                )
    return lines
