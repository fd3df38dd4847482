"""What a sweep says in sentences: of motion that does not end or repeat, and of touch and hearing.

Trials without a decided end: how many, and for what reasons.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.perception.level import published
from hknob_cli.report.table import short


def of_cells(some: int, count: int) -> str:
    """So many of the cells, in words."""
    if count == 1:
        return "this cell"
    how_many = "any of " if not some else "all " if some == count else f"{some:,} of "
    return f"{how_many}{count:,} cells"


def range_text(values: Sequence[float], unit: str) -> str:
    """The least and the largest, in words; one where both are written alike."""
    low, high = short(min(values)), short(max(values))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def rattle_text(swings: Sequence[float], where: str = "") -> str:
    """A sentence, after a space, on teeth that part and meet again in no order; empty where none do."""
    if not swings:
        return ""
    swing = f"the knob swings by {range_text([1e3 * one for one in swings], 'mrad')} (one trial each, not proven)"
    return f" It moves on{where} and no trial repeats: {swing}."


def jitter_text(swings: Sequence[float], where: str = "", *, behind: bool = False) -> str:
    """A sentence, after a space, on trials that a jittering clock keeps from repeating; empty where there are none.

    ``behind``: whether the swings are those of a motor, with the knob behind a gear that yields.
    """
    if not swings:
        return ""
    what = "motor" if behind else "knob"
    swing = f"the {what} swings by {range_text([1e3 * one for one in swings], 'mrad')} on average"
    return (
        f" It buzzes{where} without repeating, because the sample clock jitters: {swing} (one trial each, not proven)."
    )


def every_clock_text(bounds: Sequence[float], cells: int = 1) -> str:
    """A sentence, after a space, on what is proven for every clock, in some of so many ``cells``."""
    swings = [1e3 * one for one in bounds if one > 0.0]
    said = []
    if rests := len(bounds) - len(swings):
        said.append(f"it comes to rest{f' in {of_cells(rests, cells)}' if cells > 1 else ''}")
    if swings:
        where = f" in {of_cells(len(swings), cells)}" if cells > 1 else ""
        said.append(f"in the end it swings by at most {range_text(swings, 'mrad')}{where}, largest less smallest angle")
    return f" Whatever the intervals are, {' and '.join(said)} (proven)." if said else ""


Reason = dict[str, Any]


class Undecided:
    """Counts of undecided trials by reason, taken in from one table of orbits after the other."""

    def __init__(self, trials: int) -> None:
        """``trials``: of a cell."""
        self._trials = trials
        self._cells: dict[str, int] = {}
        self._shares: dict[str, float] = {}

    def take(self, outcomes: Iterable[str], reasons: Iterable[str], shares: Iterable[float]) -> None:
        """Columns ``outcome``, ``reason`` and ``basin_fraction`` of some orbits."""
        for outcome, reason, share in zip(outcomes, reasons, shares, strict=True):
            if outcome == "undecided":
                self._cells[reason] = self._cells.get(reason, 0) + 1
                self._shares[reason] = self._shares.get(reason, 0.0) + share

    def reasons(self) -> list[Reason]:
        """Each reason with the cells and trials that have it, the most frequent first."""
        found = [
            {"reason": reason, "cells": cells, "trials": max(1, round(self._shares[reason] * self._trials))}
            for reason, cells in self._cells.items()
        ]
        return sorted(found, key=lambda one: (-int(one["trials"]), str(one["reason"])))


def undecided_in(orbits: pa.Table, axes: Sequence[str], trials: int) -> list[Reason]:
    """Why trials are undecided in a table of orbits over ``axes``; several ends of a cell may have one reason."""
    found = Undecided(trials)
    cells = orbits.group_by([*axes, "outcome", "reason"]).aggregate([("basin_fraction", "sum")])
    found.take(*(cells[name].to_pylist() for name in ("outcome", "reason", "basin_fraction_sum")))
    return found.reasons()


def undecided_text(reasons: list[Reason]) -> str:
    """How many trials are undecided, and why."""
    return f"{_trials(sum(one['trials'] for one in reasons))} undecided: {'; '.join(_why(reasons))}"


def _why(reasons: list[Reason]) -> Iterator[str]:
    for one in reasons:
        where = f"{one['cells']} cell{'s' if one['cells'] != 1 else ''}"
        yield f"{one['reason'] or 'no reason given'} ({one['trials']} in {where})"


def _trials(count: int) -> str:
    return f"{count} trial{'s' if count != 1 else ''}"


class Level(NamedTuple):
    """A column of levels in dB: title over a table or picture, head of a list."""

    column: str
    title: str
    head: str


_LEVELS = (
    Level("touch_db", "touch, dB above threshold (the harmonic of a cycle that is felt best)", "touch dB"),
    Level("hearing_db", "sound, dB above threshold (the most audible harmonic)", "sound dB"),
    Level("hearing_relative_db", "sound, relative dB (no sound gain given: only differences mean something)", "sound"),
)


def perceived_levels(rows: list[dict[str, Any]]) -> list[Level]:
    """Levels that cells have a value of, none where a sweep was not asked for them."""
    return [one for one in _LEVELS if any(row.get(one.column) is not None for row in rows)]


def perceived_text(rows: list[dict[str, Any]]) -> list[str]:
    """How many cells are felt and heard, and where nothing is published."""
    found = []
    for fraction, level, verb in (("felt_fraction", "touch_db", "felt"), ("heard_fraction", "hearing_db", "heard")):
        if level not in rows[0]:
            continue
        known = [row for row in rows if row[level] is not None]
        some = [row[level] for row in known if row[fraction] > 0.0]
        missing = sum(map(_cycles, rows)) - len(known)
        if not known and not missing:
            continue  # nothing moves
        text = f"{verb} in {len(some)} of {len(known)} cells with a level"
        if some:
            text += f", by {_span(some)} dB above an average person's threshold"
        elif known:
            below = -max(row[level] for row in known)
            text += f": the strongest is {below:.3g} dB below an average person's threshold"
        found.append(text + (f"; {missing} with cycles have none, outside what is published" if missing > 0 else ""))
        if level == "touch_db" and known:
            found.append(touch_uncertainty())
    steps = [row["torque_step_db"] for row in rows if row.get("torque_step_db") is not None]
    if steps:
        less = f" ({len(rows) - len(steps)} cells are outside what is published)" if len(steps) < len(rows) else ""
        found.append(f"torque step of a count: {_span(steps)} dB above the least variation detected{less}")
    return found


def _span(values: list[float]) -> str:
    low, high = f"{min(values):.3g}", f"{max(values):.3g}"
    return low if low == high else f"{low} to {high}"


def touch_uncertainty() -> str:
    """How well a level of touch is known: the reading of one set of thresholds, and the sets among each other."""
    data = published("touch")
    return (
        f"levels of touch are known to about {data['within_set_db']} dB within one set of thresholds, "
        f"to about {data['between_sets_db']} dB between sets"
    )


def _cycles(row: dict[str, Any]) -> bool:
    return bool(row["at_rest_fraction"] + row["diverged_fraction"] + row["undecided_fraction"] < 1.0)
