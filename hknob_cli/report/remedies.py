"""Remedies in words and numbers: what each costs, does over a grid, and did on a knob.

A remedy is a change of a scene and its grid. What it touches tells what it takes: a controller is firmware, and so is
the wall, but a softer one is felt; a sample rate is a faster loop; all else, and a velocity sensor, is a part.
"""

from collections.abc import Mapping, Sequence
from math import inf
from statistics import median
from typing import Any

import pyarrow as pa

from hknob_cli.report.table import short, table
from hknob_cli.specs.plan import RATE

Row = dict[str, Any]
NOTHING, FIRMWARE, SOFTER, LOOP, PART = "nothing", "firmware only", "stiffness", "a faster loop", "a new part"
_ORDER = (NOTHING, FIRMWARE, SOFTER, LOOP, PART)
_MOST_NAMED = 3  # remedies that bring the knob to rest
_FELT = 0.9  # of the stiffness: where less is left, it is said


def effort_of(remedy: Mapping[str, Any]) -> str:
    """The most that a remedy asks for, as a spec has it: by its change, and the number that it tunes."""
    change = remedy.get("change") or {}
    asked = {_of_part(part, value) for part, value in (change.get("scene") or {}).items()}
    asked |= {LOOP if axis == RATE else _of_path(axis) for axis in change.get("grid") or {}}
    asked |= {_of_path(path) for path in remedy.get("tune") or {}}
    return max(asked, key=_ORDER.index, default=NOTHING)


def _of_path(path: str) -> str:
    part, _, key = path.partition(".")
    return _of_part(part, {key: None})


def _of_part(part: str, value: Any) -> str:
    keys = value if isinstance(value, Mapping) else {}
    if part == "wall":
        return SOFTER if "stiffness" in keys else FIRMWARE
    return FIRMWARE if part == "controller" and keys.get("velocity") != "sensor" else PART


def most_of(grid: Mapping[str, Row], costs: Mapping[str, str]) -> str:
    """The remedy that does most without stiffness, and of several at rest the cheapest; empty if none helps."""
    some = [name for name in grid if costs[name] not in (NOTHING, SOFTER)]
    return quietest_of(sorted(some, key=lambda name: _ORDER.index(costs[name])), grid)


def cost_lines(
    grid: Mapping[str, Row],
    quietest: str,
    *,
    needs: Mapping[str, str],
    costs: Mapping[str, str],
    kept: Mapping[str, float | None],
) -> list[str]:
    """What the remedies that do most cost, and the quietest in firmware alone where they are none.

    ``grid``: what each remedy does over the grid; ``quietest``: the one with the smallest buzz, empty if none helps;
    ``needs``: in words of the spec; ``costs``: of `effort_of`; ``kept``: shares of the stiffness, where they are known.
    """

    def cost(name: str) -> str:
        share = kept[name]
        left = f" It keeps {share:.2g} of the stiffness." if share is not None and share < _FELT else ""
        return f"{name} costs {costs[name]}{f': {needs[name]}' if needs[name] else ''}.{left}"

    still = [name for name, row in grid.items() if rests_everywhere(row) and costs[name] != NOTHING]
    named = [*still[:_MOST_NAMED], *([quietest] if quietest else [])]
    lines = [cost(name) for name in named]
    if not named or any(costs[name] == FIRMWARE for name in named):
        return lines
    cheap = quietest_of([name for name in grid if costs[name] == FIRMWARE], grid)
    if not cheap:
        return [*lines, "None in firmware alone makes the buzz smaller."]
    does = (
        "comes to rest everywhere"
        if rests_everywhere(grid[cheap])
        else f"{grid[cheap]['ratio_median']:.3g} times smaller"
    )
    return [*lines, f"In firmware alone: {cheap}, {does}.", cost(cheap)]


def rests_everywhere(row: Row) -> bool:
    """Whether a remedy brings the knob to rest everywhere."""
    return bool(row["at_rest_fraction"] > 1.0 - 1e-9)


def quietest_of(names: Sequence[str], grid: Mapping[str, Row]) -> str:
    """Of some remedies one that rests everywhere, else that which makes the largest cycles smallest; empty if none."""
    some = [name for name in names if rests_everywhere(grid[name]) or (grid[name]["ratio_median"] or 0.0) > 1.0]
    return max(some, key=lambda name: (rests_everywhere(grid[name]), grid[name]["ratio_median"] or 0.0), default="")


def over_the_grid(rows: list[Row]) -> dict[str, Row]:
    """Each remedy by name, over all cells and hands of ``remedies.parquet``."""
    return {name: _grid(rows, name) for name in dict.fromkeys(row["remedy"] for row in rows)}


def _grid(rows: list[Row], name: str) -> Row:
    """A remedy over the grid, where the reference buzzes in the same cell: median and least of how much smaller."""
    mine = [row for row in rows if row["remedy"] == name]
    ratios = [row["p2p_ratio"] for row in mine if row["p2p_ratio"] is not None]
    return {
        "cells": len(mine),
        "at_rest_fraction": sum(row["at_rest_fraction"] for row in mine) / len(mine),
        "certified_fraction": sum(row["certified_fraction"] for row in mine) / len(mine),
        "diverged_fraction": sum(row["diverged_fraction"] for row in mine) / len(mine),
        "ratio_median": median(ratios) if ratios else None,
        "ratio_least": min(ratios) if ratios else None,
    }


def over_axis(rows: list[Row], axis: str) -> dict[str, list[Row]]:
    """Of every remedy, at each value of the axis, how many times smaller the largest cycle is: least and median.

    Cells where reference and remedy both rest say nothing; where only the remedy rests it is infinitely smaller, which
    is None in ``times_least`` with ``rests`` set. ``starts``: cells where the remedy buzzes and the reference rests.
    """
    found: dict[str, list[Row]] = {}
    values = sorted({row[axis] for row in rows})
    for name in dict.fromkeys(row["remedy"] for row in rows):
        mine = [row for row in rows if row["remedy"] == name]
        found[name] = [{axis: value, **_together([row for row in mine if row[axis] == value])} for value in values]
    return found


def _together(rows: list[Row]) -> Row:
    ratios = sorted(inf if _all_rest(row) else row["p2p_ratio"] for row in rows if _all_rest(row) or _compared(row))
    moves = [one for one in ratios if one < inf]
    return {
        "cells": len(rows),
        "times_least": moves[0] if moves else None,
        "times_median": median(ratios) if ratios and median(ratios) < inf else None,
        "rests": bool(ratios) and not moves,
        "starts": sum(row["p2p_ratio"] == 0.0 for row in rows),
        "worse": sum(one < 1.0 for one in ratios),
        "outside_domain": sum(row.get("in_domain") is False for row in rows),
    }


def _all_rest(row: Row) -> bool:
    """Whether all trials come to rest, and none is undecided."""
    return bool(row["p2p_max_rad"] == 0.0 and row["at_rest_fraction"] > 1.0 - 1e-9)


def _compared(row: Row) -> bool:
    return row["p2p_ratio"] is not None


_HEADS = ("smaller", "least", "at rest %", "proven %")


def grid_text(grid: dict[str, Row]) -> list[str]:
    """A line for each remedy, that which makes the buzz smallest first, and what the columns say."""
    wide = max(len(name) for name in grid)
    diverges = any(row["diverged_fraction"] for row in grid.values())
    heads = (*_HEADS, *(["diverge %"] if diverges else []))
    lines = ["over the grid, all cells and hands", f"{'':{wide}}  " + "".join(f"{head:>10}" for head in heads)]
    for name, row in sorted(grid.items(), key=lambda item: -(item[1]["ratio_median"] or 0.0)):
        cells = [
            times(row["ratio_median"]),
            times(row["ratio_least"]),
            *(f"{100.0 * row[part]:.3g}" for part in ("at_rest_fraction", "certified_fraction")),
            *([f"{100.0 * row['diverged_fraction']:.3g}"] if diverges else []),
        ]
        lines.append(f"{name:{wide}}  " + "".join(f"{cell:>10}" for cell in cells))
    return [
        *lines,
        "",
        "smaller: times, by the largest cycles, median of the cells and hands where the remedy does not rest;",
        "least: of the cell and hand that gain least. at rest: of all trials.",
    ]


def times(value: float | None) -> str:
    """How many times smaller, as a table has it; a dash if there is nothing to compare."""
    return "-" if value is None else f"{value:.3g}"


def over_text(axis: str, found: dict[str, list[Row]]) -> list[str]:
    """A table: a line a remedy, a column a value of the axis."""
    heads = [f"{row[axis]:.3g}" for row in next(iter(found.values()))]
    return [
        f"over {axis}: times smaller, for the hand and cell that gain least",
        *table(["", *heads], [[name, *(said(row) for row in rows)] for name, rows in found.items()], left={0}),
        "below 1: larger than with the reference. rest: all come to rest. -: nothing to compare.",
        "starts: the remedy buzzes where the reference rests. *: outside its stated domain.",
    ]


def said(row: Row) -> str:
    """How much a remedy helps at a value of the axis, in a word or a number."""
    mark = "*" if row["outside_domain"] else ""
    if row["starts"]:
        return f"starts{mark}"
    if row["rests"]:
        return f"rest{mark}"
    return "-" if row["times_least"] is None else f"{row['times_least']:.2g}{mark}"


def tuned_values(cases: list[Row], grid: list[Row], further: Sequence[str], name: str) -> str:
    """To what a remedy was tuned, at every case and over each further axis, in words; empty where it was not."""
    mine = [row for row in grid if row["remedy"] == name]
    if not mine or mine[0].get("tuned") is None:
        return ""
    said = [
        f"{row['tuned']:g} at {case}"
        for case, row in {row["case"]: row for row in cases if row["remedy"] == name}.items()
    ]
    for axis in further:
        values: dict[Any, list[float]] = {}
        for row in mine:
            values.setdefault(row[axis], []).append(row["tuned"])
        said.append(f"{', '.join(_span(some) for _, some in sorted(values.items()))} over {axis}")
    return "; ".join(said) or _span([row["tuned"] for row in mine])


def _span(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


_TRIED_HEADS = ("buzz", "mrad", "Hz", "smaller", "least")
_COMPUTED = ("mrad comp.", "Hz comp.", "smaller comp.", "least comp.")


def describe_tried(remedies: pa.Table, *, reference: str, against: str) -> dict[str, Any]:
    """What a campaign's summary says of remedies, as plain data; ``against``: the folder of what was computed."""
    return {"reference": reference, "against": against, "remedies": over_the_trials(remedies.to_pylist())}


def over_the_trials(rows: Sequence[Row]) -> list[Row]:
    """Each remedy of a campaign's ``remedies.parquet`` over all its cells, that with the smallest buzz first.

    Sizes (rad) and pitches (Hz) are medians over the cells that buzz; ``times``: how many times smaller than the
    reference's, median over the cells where both buzz, and ``times_least``. The same as ``computed_...`` where it was.
    """
    found = []
    for name in dict.fromkeys(row["remedy"] for row in rows):
        mine = [row for row in rows if row["remedy"] == name]
        row = {
            "remedy": name,
            "trials": sum(one["trials"] for one in mine),
            "sustained": sum(one["sustained"] for one in mine),
            **_sizes(mine, ""),
        }
        if "computed_p2p_rad" in mine[0]:
            row |= {
                **_sizes(mine, "computed_"),
                "p2p_over_computed": _median(mine, "p2p_over_computed"),
                "frequency_over_computed": _median(mine, "frequency_over_computed"),
            }
        found.append(row)
    return sorted(found, key=_buzz)


def _sizes(rows: list[Row], which: str) -> Row:
    ratios = [row[f"{which}p2p_ratio"] for row in rows if row[f"{which}p2p_ratio"] is not None]
    return {
        f"{which}p2p_rad": _median(rows, f"{which}p2p_rad"),
        f"{which}frequency_hz": _median(rows, f"{which}frequency_hz"),
        f"{which}times": median(ratios) if ratios else None,
        f"{which}times_least": min(ratios, default=None),
    }


def _median(rows: list[Row], column: str) -> float | None:
    values = [row[column] for row in rows if row[column]]
    return median(values) if values else None


def _buzz(row: Row) -> tuple[float, float]:
    """What rests is quietest, then what makes the buzz smallest."""
    return (0.0, 0.0) if not row["sustained"] else (1.0, -(row["times"] or 0.0))


def tried_verdict(found: Sequence[Row], reference: str) -> str:
    """Of remedies tried on a knob: which leaves the smallest buzz, and whether that was computed, too."""
    if not found:
        return "No trial could be measured."
    others = [row for row in found if row["remedy"] != reference]
    best = next(iter(others), None)
    if best is None:
        return "No remedy was tried beside the reference."
    if not best["sustained"]:
        return f"No sustained buzz: {best['remedy']}, in any of {best['trials']} trials."
    if (best["times"] or 0.0) <= 1.0:
        return "No remedy made the buzz smaller in the trials recorded."
    text = f"Smallest buzz: {best['remedy']}, {short(best['times'], 3)} times smaller (median of the cells; "
    text += f"at least {short(best['times_least'], 3)} times"
    if best.get("computed_times"):
        text += f"; {short(best['computed_times'], 3)} times as computed"
    return f"{text})."


def tried_text(summary: dict[str, Any]) -> list[str]:
    """The verdict, a line a remedy, and what the columns say; of a summary with what `describe_tried` says."""
    found, reference, against = (summary[name] for name in ("remedies", "reference", "against"))
    heads = ["", *_TRIED_HEADS, *(_COMPUTED if against else ())]
    lines = [
        tried_verdict(found, reference),
        "",
        *table(heads, [_line(row, bool(against)) for row in found], left={0}),
        "",
        "buzz: trials with a sustained buzz. mrad, Hz: peak to peak and pitch, medians over the cells that buzz.",
        f"smaller: times, {reference} over the remedy in the same cell, median, and least, of cells where both buzz.",
    ]
    return [*lines, f"comp.: as computed, in {against}, means over the starts."] if against else lines


def _line(row: Row, computed: bool) -> list[str]:
    shown = [row["remedy"], f"{row['sustained']}/{row['trials']}", *_four(row, "")]
    return [*shown, *_four(row, "computed_")] if computed else shown


def _four(row: Row, which: str) -> list[str]:
    scales = {"p2p_rad": 1e3, "frequency_hz": 1.0, "times": 1.0, "times_least": 1.0}
    return [short(None if (value := row[f"{which}{name}"]) is None else by * value, 3) for name, by in scales.items()]
