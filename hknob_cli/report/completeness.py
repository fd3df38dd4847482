"""Whether a sweep's list of attractors is complete, and for which starts, in words."""

from typing import Any

from hknob_cli.report.matrix import labels
from hknob_cli.spec.plan import Starts


def describe_completeness(cells: list[dict[str, Any]], starts: Starts) -> dict[str, Any]:
    """Of how many cells the list is proven to be complete, and why not of the others, as plain data."""
    sampled = [row for row in cells if not row["complete"] and row["piece_count"] == 0]
    left = [row for row in cells if not row["complete"] and row["piece_count"] > 0]
    return {
        "starts": _scope(starts),
        "cells": len(cells),
        "complete": sum(row["complete"] for row in cells),
        "sampled": len(sampled),
        "phases": starts.phases,
        "shares_counted": starts.span is not None,
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
    if left := total - complete - found["sampled"]:
        share = f"at most {100.0 * found['undecided_max']:.2g} % of them"
        lines.append(
            f"In {left} of {total} cells some starts have no proven end, {share}; undecided_fraction says how many."
        )
        lines += [f"  {count} cell{'s' if count > 1 else ''}: {reason}." for reason, count in found["reasons"].items()]
    if found["sampled"] and found["shares_counted"]:
        lines.append(f"In {found['sampled']} of {total} cells no set of starts was followed; orbits.parquet says why.")
    elif found["sampled"]:
        lines.append(
            f"In {found['sampled']} of {total} cells starts cannot be followed all at once; "
            f"{found['phases']} clock phases were sampled there."
        )
    if found["shares_counted"] and found["sampled"] < total:
        lines.append("Shares are counted: 4096 random starts, with a standard error of at most 0.8 %.")
    return lines


def _scope(starts: Starts) -> str:
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
