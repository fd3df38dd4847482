"""Whether a sweep's list of attractors is complete, and for which starts, in words."""

from typing import Any

from hknob_cli.report.table import labels
from hknob_cli.specs.plan import Starts

RANGES = "starts={angle: [-0.05, 0.05], velocity: [-5, 5]}"  # rad and rad/s, of a knob that a hand lets go
COUNTED = 4096  # random starts in a range whose ends are counted for shares (`engine.sets.search.SAMPLED`)


def describe_completeness(cells: list[dict[str, Any]], starts: Starts, *, areas: bool = False) -> dict[str, Any]:
    """Of how many cells the list is proven to be complete, and why not of the others, as plain data.

    ``areas``: whether shares of ranges are areas, and not counted.
    """
    open_ = [row for row in cells if not row["complete"] and not row.get("grows_rad")]
    sampled = [row for row in open_ if row["piece_count"] == 0]
    left = [row for row in open_ if row["piece_count"] > 0]
    return {
        "starts": _scope(starts),
        "cells": len(cells),
        "complete": sum(row["complete"] for row in cells),
        "sampled": len(sampled),
        "phases": starts.phases,
        "ranged": starts.many,
        "shares_counted": starts.many and not areas,
        **({"random": starts.random} if starts.random else {}),
        **({"regions": _reaches(cells, "region"), "growing": _reaches(cells, "grows")} if starts.anywhere else {}),
        **({"undecided_max": max(row["undecided_fraction"] for row in left)} if left else {}),
        **({"reasons": _reasons(left)} if left else {}),
    }


def completeness_text(found: dict[str, Any], *, buzzes: bool) -> list[str]:
    """What `describe_completeness` says, for the terminal; ``buzzes``: whether there is a limit cycle."""
    total, complete = found["cells"], found["complete"]
    where = "" if total == 1 else " in every cell" if complete == total else f" in {complete} of {total} cells"
    lines = [f"Complete{where}: {found['starts']} is proven to end in one of these."]
    if complete == 0:
        lines = ["The list is not proven to be complete."]
    if complete == total and found["ranged"] and buzzes:
        there = "" if "regions" in found else " there"
        lines[0] += f" However the knob is let go{there}, its buzz is no larger than the largest cycle above."
    if total == 1 and not found["ranged"]:
        end = "a larger cycle" if buzzes else "a limit cycle"
        lines += [f"This is one start. Another may end in {end}. To look for one, add", f"  --set '{RANGES}'"]
    growing = found.get("growing") or {"cells": 0}
    if left := total - complete - found["sampled"] - growing["cells"]:
        lines += _unproven(found, left)
    if found["sampled"]:
        lines.append(_sampled(found))
    if regions := found.get("regions"):
        some = f": in {regions['cells']} of {total} cells." if regions["cells"] < total else "."
        lines.append(f"Every motion comes within {_within(regions)}, from however far{some}")
    if growing["cells"]:
        where = "Every" if total == 1 else f"In {growing['cells']} of {total} cells every"
        lines.append(f"{where} motion from beyond {_within(growing, 'or')} grows without bound:")
        lines[-1] += " the wall is too stiff for its rate."
    if found["shares_counted"] and found["sampled"] + growing["cells"] < total:
        where = " in that region" if regions else ""
        lines.append(f"Shares are counted: {COUNTED} random starts{where}, with a standard error of at most 0.8 %.")
    return lines


def _unproven(found: dict[str, Any], left: int) -> list[str]:
    """Why some starts have no proven end in the ``left`` cells."""
    most = found["undecided_max"]
    share = "perhaps all of them" if most > 0.99 else f"at most {100.0 * most:.2g} % of them"
    where = f"In {left} of {found['cells']} cells"
    return [
        f"{where} some starts have no proven end, {share}; undecided_fraction says how many.",
        *(f"  {count} cell{'s' if count > 1 else ''}: {reason}." for reason, count in found["reasons"].items()),
    ]


def _sampled(found: dict[str, Any]) -> str:
    """What was done in cells whose starts were not followed all at once."""
    where = f"In {found['sampled']} of {found['cells']} cells"
    if "random" in found:
        done = f"{found['random']} random ones were simulated there, and other starts may end elsewhere."
    elif found["ranged"]:
        return f"{where} no set of starts was followed; orbits.parquet says why."
    else:
        done = f"{found['phases']} clock phases were sampled there."
    return f"{where} starts cannot be followed all at once; {done}"


def random_trials(found: dict[str, Any]) -> int:
    """How many random starts of a range the shares of the one cell are of; 0 where they are of something else."""
    if found["sampled"]:
        return int(found.get("random", 0))
    return COUNTED if found["shares_counted"] else 0


def _reaches(cells: list[dict[str, Any]], name: str) -> dict[str, Any]:
    """In how many cells a region is known, and the least and the largest angle and speed of those; empty for none."""
    known = [row for row in cells if row[f"{name}_rad"] is not None]
    if not known:
        return {}
    angles, speeds = ([row[column] for row in known] for column in (f"{name}_rad", f"{name}_rad_s"))
    return {
        "cells": len(known),
        "angle_rad": [min(angles), max(angles)],
        "velocity_rad_s": [min(speeds), max(speeds)],
    }


def _within(found: dict[str, Any], both: str = "and") -> str:
    """The angles and the speeds, in words."""
    angles, speeds = labels([1e3 * angle for angle in found["angle_rad"]]), labels(found["velocity_rad_s"])
    return f"{' to '.join(dict.fromkeys(angles))} mrad {both} {' to '.join(dict.fromkeys(speeds))} rad/s"


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
