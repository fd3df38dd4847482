"""Passivity and stability in words: which limits hold, and what would satisfy them."""

from collections import Counter
from math import ceil, floor, log10
from typing import Any

LIMITS = {
    "colgate_schenkel": "Colgate & Schenkel",
    "abbott_okamura": "Abbott & Okamura",
    "gil_hulin": "Gil & Hulin",
    "niemeyer": "Niemeyer",
}
_WITH_HAND = "_with_hand"

Rows = list[dict[str, Any]]


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
