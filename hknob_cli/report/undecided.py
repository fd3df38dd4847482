"""Trials without a decided end: how many, and for what reasons."""

from collections.abc import Iterable, Iterator
from typing import Any

import pyarrow as pa

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


def undecided_in(orbits: pa.Table, trials: int) -> list[Reason]:
    """Why trials are undecided in a table of orbits."""
    found = Undecided(trials)
    found.take(*(orbits[name].to_pylist() for name in ("outcome", "reason", "basin_fraction")))
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
