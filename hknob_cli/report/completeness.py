"""Whether a sweep's list of attractors is complete, and for which starts, in words."""

from typing import Any

from hknob_cli.report.matrix import labels
from hknob_cli.spec.plan import Starts


def describe_completeness(cells: list[dict[str, Any]], starts: Starts, *, controlled: bool = False) -> dict[str, Any]:
    """Of how many cells the list is proven to be complete, and why not of the others, as plain data.

    ``controlled``: whether the wall has a controller; of ranges, shares are areas then.
    """
    sampled = [row for row in cells if not row["complete"] and row["piece_count"] == 0]
    left = [row for row in cells if not row["complete"] and row["piece_count"] > 0]
    return {
        "starts": _scope(starts),
        "cells": len(cells),
        "complete": sum(row["complete"] for row in cells),
        "sampled": len(sampled),
        "phases": starts.phases,
        "ranged": starts.many,
        "shares_counted": starts.many and not controlled,
        **({"random": starts.random} if starts.random else {}),
        **({"regions": _regions(cells)} if starts.anywhere else {}),
        **({"undecided_max": max(row["undecided_fraction"] for row in left)} if left else {}),
        **({"reasons": _reasons(left)} if left else {}),
    }


def completeness_text(found: dict[str, Any]) -> list[str]:
    """What `describe_completeness` says, for the terminal."""
    total, complete = found["cells"], found["complete"]
    where = "" if total == 1 else " in every cell" if complete == total else f" in {complete} of {total} cells"
    lines = [f"Complete{where}: {found['starts']} is proven to end in one of these."]
    if complete == 0:
        lines = ["The list is not proven to be complete."]
    if complete == total and found["ranged"]:
        lines[0] += " However the knob is let go there, its buzz is no larger than the largest cycle above."
    if left := total - complete - found["sampled"]:
        share = f"at most {100.0 * found['undecided_max']:.2g} % of them"
        lines.append(
            f"In {left} of {total} cells some starts have no proven end, {share}; undecided_fraction says how many."
        )
        lines += [f"  {count} cell{'s' if count > 1 else ''}: {reason}." for reason, count in found["reasons"].items()]
    if found["sampled"] and "random" in found:
        lines.append(
            f"In {found['sampled']} of {total} cells starts cannot be followed all at once; "
            f"{found['random']} random ones were simulated there, and other starts may end elsewhere."
        )
    elif found["sampled"] and found["ranged"]:
        lines.append(f"In {found['sampled']} of {total} cells no set of starts was followed; orbits.parquet says why.")
    elif found["sampled"]:
        lines.append(
            f"In {found['sampled']} of {total} cells starts cannot be followed all at once; "
            f"{found['phases']} clock phases were sampled there."
        )
    regions = found.get("regions")
    if regions:
        angles, speeds = labels([1e3 * angle for angle in regions["angle_rad"]]), labels(regions["velocity_rad_s"])
        lines.append(
            f"Every motion comes within {_range(angles)} mrad and {_range(speeds)} rad/s, from however far"
            + (f": in {regions['cells']} of {total} cells." if regions["cells"] < total else ".")
        )
    if found["shares_counted"] and found["sampled"] < total:
        where = " in that region" if regions else ""
        lines.append(f"Shares are counted: 4096 random starts{where}, with a standard error of at most 0.8 %.")
    return lines


def _regions(cells: list[dict[str, Any]]) -> dict[str, Any]:
    """In how many cells every motion comes into a region, and the least and the largest of these; empty for none."""
    known = [row for row in cells if row["region_rad"] is not None]
    if not known:
        return {}
    angles, speeds = ([row[name] for row in known] for name in ("region_rad", "region_rad_s"))
    return {
        "cells": len(known),
        "angle_rad": [min(angles), max(angles)],
        "velocity_rad_s": [min(speeds), max(speeds)],
    }


def _range(ends: list[str]) -> str:
    return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


def _scope(starts: Starts) -> str:
    if starts.anywhere:
        return "every start at a sample, however far,"
    if starts.span is None:
        return "every clock phase of the start"
    low, high = labels([1e3 * angle for angle in starts.span[:2]])
    slowest, fastest = labels(list(starts.span[2:]))
    return f"every start from {low} to {high} mrad and {slowest} to {fastest} rad/s at a sample"


def _reasons(cells: list[dict[str, Any]]) -> dict[str, int]:
    """Why most of the starts without a proven end have none, and in how many cells: the most frequent first."""
    counts: dict[str, int] = {}
    for row in cells:
        counts[row["incomplete_reason"]] = counts.get(row["incomplete_reason"], 0) + 1
    return dict(sorted(counts.items(), key=lambda one: (-one[1], one[0])))
