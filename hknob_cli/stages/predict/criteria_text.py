"""Further criteria of stability in words: where each holds, and whether the sweep cycles there."""

from collections import Counter
from typing import Any

ABOUT = {
    "tsypkin": "Tsypkin, no oscillation in this hand",
    "tsai_colgate": "Tsai & Colgate, no oscillation in this hand",
    "miller": "Miller, no oscillation, by the damping of knob and hand",
    "love_book": "Love & Book, the knob alone is stable",
    "llewellyn": "Llewellyn, stable as a virtual coupling, by the knob's damping",
}

Rows = list[dict[str, Any]]


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
