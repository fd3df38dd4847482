"""A sweep in words and numbers: the summary as data, and as the table on the terminal.

A sweep of one cell in a sentence: does it buzz, how large, at what pitch, from what share of the starts, proven?
"""

from typing import Any

import pyarrow as pa

from hknob_cli.report.large import describe_people, people_text
from hknob_cli.report.sweep_words import (
    Level,
    every_clock_text,
    jitter_text,
    perceived_levels,
    perceived_text,
    rattle_text,
    undecided_in,
    undecided_text,
)
from hknob_cli.report.table import MAX_ROWS, fits, matrix, short, table
from hknob_cli.report.verdicts import grid_verdict, percent, unproven_of
from hknob_cli.report.what_matters import describe_matters, matters_of, matters_text
from hknob_cli.results.columns import differs
from hknob_cli.specs.plan import PERSON
from hknob_cli.stages.sweep.completeness_text import random_trials

Row = dict[str, Any]
MOST_ORBITS = 20  # lines
_ALMOST = 1.0 - 1e-9  # of the starts, all
# Columns of what moves without repeating: their titles, and their heads in a list.
_SWINGS = (
    ("rattle_max_rad", "swing that does not repeat, mrad (one trial each, not proven)", "swing mrad"),
    ("jitter_max_rad", "mean swing, mrad, which does not repeat (one trial each, not proven)", "mean swing mrad"),
    ("clock_bound_rad", "swing at most, mrad, whatever the intervals are (proven)", "at most mrad"),
)


def describe_one(orbits: list[Row]) -> list[Row]:
    """The ends of the trials as plain data: what each is, how large, at what pitch, of how many, and if proven."""
    keys = (
        "outcome",
        "p2p_rad",
        "frequency_hz",
        "basin_fraction",
        "certified",
        "reason",
        "knob_p2p_rad",
        "rattle_p2p_rad",
        "jitter_p2p_rad",
        "jitter_frequency_hz",
    )
    return [{key: row[key] for key in keys if key in row} for row in orbits]


def one_cell_text(
    orbits: list[Row], *, unproven: float = 0.0, trials: int = 0, bound: float | None = None
) -> list[str]:
    """The sentence, and a table where there are several cycles.

    ``unproven``: part of a range of starts without a proven end. ``trials``: how many random starts of that range were
    tried, 0 where shares are areas. ``bound``: on the swing under every clock, rad.
    """
    cycles = sorted((row for row in orbits if row["outcome"] == "cycle"), key=lambda row: -row["p2p_rad"])
    rattles = rattle_text([row["rattle_p2p_rad"] for row in orbits if row.get("rattle_p2p_rad")])
    jitters = [row for row in orbits if row.get("jitter_p2p_rad")]
    rattles += jitter_text(
        [row["jitter_p2p_rad"] for row in jitters], behind=any(row.get("knob_p2p_rad") for row in jitters)
    )
    rattles += every_clock_text([] if bound is None else [bound])
    tried = f"{trials} random starts" if trials and unproven else "every start tried"
    left = f" {percent(unproven)} of the range has no proven end." if unproven else ""
    if not cycles:
        return [_without_cycle(orbits, tried, left) + rattles]
    share = sum(row["basin_fraction"] for row in cycles)
    worst = cycles[0]
    of = "" if len(cycles) == 1 else f" in the largest of {len(cycles)} limit cycles"
    sentence = (
        f"It buzzes, from {_share(share, tried)}: {_size(worst)} at {short(worst['frequency_hz'])} Hz{of} "
        f"({_proof(cycles)}).{left}"
    )
    if len(cycles) > 1:
        size, pitch = (sum(row["basin_fraction"] * row[name] for row in cycles) for name in ("p2p_rad", "frequency_hz"))
        if share > 0.0:
            mean = f"{short(1e3 * size / share)} mrad at {short(pitch / share)} Hz"
            sentence += f" The mean of the starts that cycle is {mean}."
    others = [row for row in orbits if row["outcome"] != "cycle"]
    if others:
        sentence += f" The others: {_ends(others)}.{rattles}"
    if len(cycles) == 1:
        return [sentence]
    body = [
        [
            short(1e3 * row["p2p_rad"]),
            short(row["frequency_hz"]),
            short(100.0 * row["basin_fraction"]),
            "yes" if row["certified"] else "no",
        ]
        for row in cycles[:MOST_ORBITS]
    ]
    more = [f"... and {len(cycles) - MOST_ORBITS} smaller ones in orbits.parquet"] if len(cycles) > MOST_ORBITS else []
    return [sentence, "", *table(["p2p mrad", "frequency Hz", "% of starts", "proven"], body), *more]


def _size(row: Row) -> str:
    """How far it swings; behind a gear that yields, the knob and the encoder's side."""
    size = f"{short(1e3 * row['p2p_rad'])} mrad peak to peak"
    behind = row.get("knob_p2p_rad")
    return size if behind is None else f"the knob swings by {short(1e3 * behind)} mrad, the motor by {size}"


def _without_cycle(orbits: list[Row], tried: str, left: str) -> str:
    """``tried``: which starts; ``left``: a sentence on those without a proven end, empty if there are none."""
    rest = [row for row in orbits if row["outcome"] == "rest"]
    if not rest or len(rest) < len(orbits):
        return f"No limit cycle was found: {_ends(orbits)}.{left}"
    if not left:
        return f"It does not buzz: it comes to rest, from {tried} ({_proof(rest)})."
    proof = "" if all(row["certified"] for row in rest) else f" ({_proof(rest)})"
    all_rest = f"All {tried} come" if tried[0].isdigit() else f"{tried.capitalize()} comes"
    return f"No limit cycle was found. {all_rest} to rest{proof};{left}"


def _ends(orbits: list[Row]) -> str:
    """How trials end that do not cycle, by share of the starts."""
    words = {"rest": "come to rest", "diverged": "diverge", "undecided": "are undecided"}
    shares = {
        word: sum(row["basin_fraction"] for row in orbits if row["outcome"] == outcome)
        for outcome, word in words.items()
    }
    why = _reasons([row for row in orbits if row["outcome"] == "diverged"])
    words_of = {**{word: word for word in shares}, "diverge": f"diverge ({why})" if why else "diverge"}
    return ", ".join(
        f"{short(100.0 * share)} % of the starts {words_of[word]}" for word, share in shares.items() if share > 0.0
    )


def _share(share: float, tried: str = "every start tried") -> str:
    if share <= _ALMOST:
        return f"{short(100.0 * share)} % of the starts tried"
    return f"all {tried}" if tried[0].isdigit() else tried  # a number of random ones


def _proof(orbits: list[Row]) -> str:
    if all(row["certified"] for row in orbits):
        return "proven"
    why = _reasons([row for row in orbits if not row["certified"]])
    what = "some of it not proven" if any(row["certified"] for row in orbits) else "not proven"
    return f"{what}: {why}" if why else what


def _reasons(orbits: list[Row]) -> str:
    """Why these ends are what they are, each reason once."""
    return "; ".join(dict.fromkeys(row["reason"] for row in orbits if row["reason"]))


def describe_sweep(cells: pa.Table, orbits: pa.Table, *, axes: list[str], trials: int = 1) -> dict[str, Any]:
    """Summary of a sweep as plain data, one entry per cell under ``cells``; ``trials``: of a cell."""
    rows = cells.to_pylist()
    outcomes = orbits["outcome"].to_pylist()
    people = {"population": describe_people(rows, axes)} if PERSON in axes else {}
    undecided = undecided_in(orbits, axes, trials) if "undecided" in outcomes else []
    matters = describe_matters(matters_of(rows, axes))
    return {
        "axes": {axis: list(dict.fromkeys(row[axis] for row in rows)) for axis in axes},
        "orbits": {kind: outcomes.count(kind) for kind in ("cycle", "rest", "diverged", "undecided")},
        "certified_fraction": sum(row["certified_fraction"] for row in rows) / len(rows),
        **({"undecided": undecided} if undecided else {}),
        **({"ends": describe_one(orbits.to_pylist())} if len(rows) == 1 and "growth_j_per_s2" not in rows[0] else {}),
        **people,
        **({"what_matters": matters} if matters else {}),
        "cells": rows,
    }


def table_text(summary: dict[str, Any], axes: list[str]) -> str:
    """The table on the terminal: two matrices over two axes, else what matters most, or one line per cell."""
    rows = summary["cells"]
    wide = [axis for axis in axes if len(summary["axes"][axis]) > 1]
    fixed = [f"{axis} = {short(summary['axes'][axis][0])}" for axis in axes if axis not in (*wide, PERSON)]
    lines = [_headline(summary) + (f"; {', '.join(fixed)}" if fixed else "")]
    if len(rows) > 1 and "population" not in summary and "growth_j_per_s2" not in rows[0]:
        lines += ["", grid_verdict(rows, wide)]
    if "what_matters" in summary:
        looked_at = sum(one["cells"] for one in summary["what_matters"][0]["bins"])
        some = f"{len(rows):,}" if looked_at == len(rows) else f"{looked_at:,} of {len(rows):,}"
        lines += ["", *matters_text(summary["what_matters"], some)]
        if len(rows) > MAX_ROWS:
            notes = [*_notes(summary), *perceived_text(rows)]
            return "\n".join([*lines, *(["", *notes] if notes else [])])
    if "population" in summary:
        return "\n".join([*lines, "", *people_text(summary, axes)])
    if "growth_j_per_s2" in rows[0] and len(wide) == 2 and fits(rows, wide):
        title = "growth of energy at bounce peaks, mJ/s^2 (second-order coefficient, mean of the trials)"
        lines += ["", *matrix(rows, wide, "growth_j_per_s2", scale=1e3, title=title)]
        lines += ["", "bounces do not settle: nothing damps them, so there are no limit cycles to prove"]
        return "\n".join(lines)
    if len(wide) == 2 and fits(rows, wide):
        for column, scale, title in _measures(rows):
            mark = _mark if column != "clock_bound_rad" else lambda _row: ""
            lines += ["", *matrix(rows, wide, column, scale=scale, title=title, mark=mark)]
        for level in perceived_levels(rows):
            lines += ["", *matrix(rows, wide, level.column, scale=1.0, title=level.title)]
    elif "ends" in summary:
        trials = random_trials(summary["completeness"]) if "completeness" in summary else 0
        bound = rows[0].get("clock_bound_rad")
        lines += ["", *one_cell_text(summary["ends"], unproven=unproven_of(rows)[1], trials=trials, bound=bound)]
        if levels := perceived_levels(rows):
            lines += ["", *_list(rows, wide, levels)]
    else:
        lines += ["", *_list(rows, wide, perceived_levels(rows))]
    notes = [*_notes(summary), *perceived_text(rows)]
    lines += ["", *notes] if notes else []
    return "\n".join(lines)


def _swings(rows: list[dict[str, Any]]) -> list[tuple[str, str, str]]:
    """Columns of what does not repeat that some cell has, with their titles and heads."""
    return [one for one in _SWINGS if any(row.get(one[0]) is not None for row in rows)]


def _measures(rows: list[dict[str, Any]]) -> list[tuple[str, float, str]]:
    """Columns to show, their scales and titles.

    Of the largest cycle of a cell, the means where they are others, and what moves without repeating.
    """
    swings = [(column, 1e3, title) for column, title, _ in _swings(rows)]
    if swings and all(row["p2p_max_rad"] is None for row in rows):
        return swings
    return [*_of_cycles(rows), *swings]


def _of_cycles(rows: list[dict[str, Any]]) -> list[tuple[str, float, str]]:
    size, pitch = "peak to peak, mrad (mean peak minus mean trough)", "frequency, Hz"
    if not differs(rows):
        return [("p2p_max_rad", 1e3, size), ("frequency_at_max_hz", 1.0, pitch)]
    mean = "mean of the trials that cycle"
    return [
        ("p2p_max_rad", 1e3, f"{size}, of the largest cycle"),
        ("p2p_rad", 1e3, f"peak to peak, mrad, {mean}"),
        ("frequency_at_max_hz", 1.0, f"{pitch}, of the largest cycle"),
        ("frequency_hz", 1.0, f"{pitch}, {mean}"),
    ]


def _headline(summary: dict[str, Any]) -> str:
    counts = {**summary["orbits"], "undecided": sum(one["trials"] for one in summary.get("undecided", []))}
    found = ", ".join(f"{number} {_plural(kind, number)}" for kind, number in counts.items() if number)
    share = summary["certified_fraction"]
    every = "every trial tried is proven, not every start" if unproven_of(summary["cells"])[0] else "all proven"
    proven = every if share == 1.0 else f"{100 * share:.4g} % of trials proven"
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    cells = len(summary["cells"])
    return f"{summary['name']}: {cells} {'cell' if cells == 1 else 'cells'}, {found}, {proven}{stale}"


def _plural(kind: str, number: int) -> str:
    names = {
        "cycle": ("limit cycle", "limit cycles"),
        "rest": ("rest point", "rest points"),
        "undecided": ("undecided trial", "undecided trials"),
    }
    one, many = names.get(kind, (f"{kind} end", f"{kind} ends"))
    return one if number == 1 else many


def _mark(row: dict[str, Any]) -> str:
    """Mark of a cell: several orbits, some rest, some diverge, some undecided."""
    marks = "*" if row["orbit_count"] > 1 else ""
    marks += "r" if row["at_rest_fraction"] > 0 else ""
    marks += "!" if row["diverged_fraction"] > 0 else ""
    return marks + ("?" if row["undecided_fraction"] > 0 else "")


def _notes(summary: dict[str, Any]) -> list[str]:
    marks = "".join(_mark(row) for row in summary["cells"])
    words = {
        "*": "several orbits coexist; which one a trial reaches depends on its start",
        "r": "trials come to rest; they are in no mean",
        "!": "trials diverge",
        "?": undecided_text(summary["undecided"]) if "undecided" in summary else "some starts have no proven end",
    }
    told = {"*", "r", "!"} if "ends" in summary else set()  # of one cell, by its sentence
    return [f"{mark} {text}" for mark, text in words.items() if mark in marks and mark not in told]


def _list(rows: list[dict[str, Any]], axes: list[str], levels: list[Level]) -> list[str]:
    sides, swings = ("", "mean ") if differs(rows) else ("",), _swings(rows)
    heads = [
        *axes,
        *(f"{side}{name}" for name in ("p2p mrad", "frequency Hz") for side in sides),
        *(head for _, _, head in swings),
        *(["at rest %"] if any(row["at_rest_fraction"] for row in rows) else []),
        "orbits",
        *(level.head for level in levels),
        "",
    ]
    body = [
        [
            *(short(row[axis], 6) for axis in axes),
            *(
                short(None if row[name] is None else scale * row[name])
                for names, scale in ((("p2p_max_rad", "p2p_rad"), 1e3), (("frequency_at_max_hz", "frequency_hz"), 1.0))
                for name in names[: len(sides)]
            ),
            *(short(None if row[name] is None else 1e3 * row[name]) for name, _, _ in swings),
            *([short(100.0 * row["at_rest_fraction"])] if "at rest %" in heads else []),
            str(row["orbit_count"]),
            *(short(row[level.column]) for level in levels),
            _mark(row) if len(rows) > 1 else "",  # the sentence about one cell says it
        ]
        for row in rows[:MAX_ROWS]
    ]
    lines = table(heads, body, keys=len(axes) or 1)
    if len(sides) > 1:
        lines += ["p2p and frequency are those of the largest cycle; means are of the trials that cycle"]
    if len(rows) > MAX_ROWS:
        lines.append(f"... and {len(rows) - MAX_ROWS} more cells in cells.parquet")
    return lines
