"""Intervals of clock phases with what becomes of their pieces written down: what is halved, and what each counts.

No measure of phases is without an end: each is an attractor's, or undecided.
"""

from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets import friction_phases
from hknob_cli.engine.general.sets.box import ENDED, KEPT, PARTED
from hknob_cli.engine.general.sets.box import UNPROVEN as NOT_PROVEN
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.friction_phases import (
    FIRST,
    HALVINGS,
    NARROWEST,
    STRAIGHT,
    TOO_MANY,
    UNPROVEN,
    follow_interval,
    follow_phases,
)
from hknob_cli.engine.general.sets.known import NO_ROOM
from hknob_cli.engine.general.sets.piece import WEIGHT, piece_size
from hknob_cli.engine.general.sets.scope import Scope

from .friction_work import body_of, drift_of, room_of, wall_of, work_of, zeros

SHARE = 6  # of an attractor's row: how many trials, or which share of them, end there
ROWS = 4
SCOPE = Scope(budget=1000, skip=0, patience=64, limit=9.0, fine=True)


def known_of() -> Any:
    return SimpleNamespace(table=zeros(FIELDS * ROWS), why=zeros(16), turns=None)


def shares(known: Any) -> list[float]:
    assert not any(value for k, value in enumerate(known.table) if k % FIELDS != SHARE)
    found: list[float] = known.table[SHARE::FIELDS]
    return found


# One interval.


def follow(
    monkeypatch: pytest.MonkeyPatch, script: list[tuple[int, int]], wide: float, *, friction: float = 0.5,
    first: int = 1, halts: int | None = None, delay: int = 0,
) -> tuple[tuple[Any, ...], Any, list[float]]:  # fmt: skip
    """Follow the interval from 0.5 on; ``script``: fate and row of each piece; each takes 10 samples.

    A piece that is parted becomes two. ``first``: pieces of the chord. What is found, its tables, and what was blamed.
    """
    known, body, todo, blamed = known_of(), body_of(friction), list(script), []
    room, work = room_of(64, delay), work_of(delay=delay)

    def put(start: Any, span: Any, weight: float, *rest: Any) -> int:
        assert (start, span) == ((3.0, 0.25), (0.5, 0.5 + wide))
        blamed.append(weight)
        for k in range(64):  # the measure of the piece at each place
            room.stack[k * piece_size(2, delay) + WEIGHT] = 2.0**-20 * (k + 1)
        return first

    def piece(its: Any, own: Any, waiting: int, width: float, *rest: Any) -> tuple[int, int, int, int]:
        assert (its, own, width) == (room, work, 0.0)
        assert rest == (SCOPE, cell)
        fate, row = todo.pop(0)
        if halts is not None and len(script) - len(todo) == halts:
            body.halt[0] = 1.0
        return (waiting + 1 if fate == PARTED else waiting - 1), fate, row, 10

    monkeypatch.setattr(friction_phases, "put_chord", put)
    monkeypatch.setattr(friction_phases, "follow_piece", piece)
    cell = Cell(drift_of(), known, body, wall_of())
    found = follow_interval((3.0, 0.25), (0.5, 0.5 + wide), SCOPE, room, work, cell)
    assert todo == script[found[5] // 10 :]
    return found, known, blamed


def test_an_interval_that_ends_in_one_attractor_is_its(monkeypatch: pytest.MonkeyPatch) -> None:
    """However often it is parted on the way: the pieces that end are counted."""
    for wide in (0.25, 2.0**-12, NARROWEST):
        found, known, _ = follow(monkeypatch, [(ENDED, 2)], wide)
        assert found == (2, -1, True, 1, 0.0, 10)
        script = [(PARTED, -1), (ENDED, 0), (PARTED, -1), (ENDED, 0), (ENDED, 0)]
        found, known, _ = follow(monkeypatch, script, wide, delay=2)
        assert found == (0, -1, True, 3, 0.0, 50)
        assert not any(shares(known))
        assert not any(known.why)


def test_it_is_given_up_at_the_second_attractor(monkeypatch: pytest.MonkeyPatch) -> None:
    """For it will be halved; unless it is one of the narrowest."""
    for row, other in ((0, 1), (1, 0), (2, 3)):
        found, _, _ = follow(monkeypatch, [(PARTED, -1), (ENDED, row), (ENDED, other)], 0.25)
        assert found == (row, other, True, 2, 0.0, 30)
    script = [(PARTED, -1), (ENDED, 1), (ENDED, 0)]
    for wide in (0.25, 2.0**-20, 2.0 * NARROWEST):
        found, _, _ = follow(monkeypatch, [(PARTED, -1), *script], wide)
        assert found == (1, 0, True, 2, 0.0, 40)
    found, _, _ = follow(monkeypatch, [(PARTED, -1), *script, (ENDED, 1)], NARROWEST)
    assert found == (1, 0, True, 3, 0.0, 50)
    found, _, _ = follow(monkeypatch, [(PARTED, -1), *script, (ENDED, 3)], NARROWEST)
    assert found == (1, 3, True, 3, 0.0, 50)


@pytest.mark.parametrize("fate", [NOT_PROVEN, KEPT])
def test_it_is_given_up_at_an_end_that_is_not_proven(fate: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """And its measure is lost: the second of two pieces that wait has that of its place."""
    for wide in (0.25, 2.0**-20):
        found, _, _ = follow(monkeypatch, [(PARTED, -1), (fate, -1), (ENDED, 1)], wide)
        assert found == (-1, -1, False, 1, 2.0 * 2.0**-20, 20)
    found, _, _ = follow(monkeypatch, [(PARTED, -1), (fate, -1), (ENDED, 1)], NARROWEST)
    assert found == (1, -1, False, 2, 2.0 * 2.0**-20, 30)
    found, _, _ = follow(monkeypatch, [(PARTED, -1), (ENDED, 0), (fate, 1)], NARROWEST)
    assert found == (0, -1, False, 2, 2.0**-20, 30)


def test_without_friction_pieces_share_a_narrow_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    """By their measures; what has no proven end is lost."""
    script = [(PARTED, -1), (PARTED, -1), (ENDED, 1), (NOT_PROVEN, -1), (ENDED, 3)]
    found, known, _ = follow(monkeypatch, script, STRAIGHT, friction=0.0)
    assert found == (1, 3, False, 3, 2.0 * 2.0**-20, 50)
    assert shares(known) == [0.0, 3.0 * 2.0**-20, 0.0, 2.0**-20]
    for friction, wide in ((0.0, 2.0 * STRAIGHT), (0.5, NARROWEST)):
        _, known, _ = follow(monkeypatch, [(ENDED, 1)], wide, friction=friction)
        assert not any(shares(known))


def test_only_of_a_small_interval_it_is_said_why(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are halved."""
    for wide, weight in ((UNPROVEN, UNPROVEN), (0.5 * UNPROVEN, 0.5 * UNPROVEN), (1.5 * UNPROVEN, 0.0), (0.25, 0.0)):
        assert follow(monkeypatch, [(ENDED, 1)], wide)[2] == [weight]
        found, known, _ = follow(monkeypatch, [], wide, first=-1)
        assert found == (-1, -1, False, 0, weight, 0)
        assert known.why == [weight if fate == NO_ROOM else 0.0 for fate in range(16)]
        assert follow(monkeypatch, [], wide, first=0)[0] == (-1, -1, True, 0, 0.0, 0)
    assert UNPROVEN == 2.0**-10


def test_it_is_given_up_after_too_many_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Unless it is one of the narrowest, where each that is too many is lost."""
    monkeypatch.setattr(friction_phases, "TOO_MANY", 3)
    assert TOO_MANY == 4096
    script = [(PARTED, -1)] * 4 + [(ENDED, 1)] * 5
    for wide, weight in ((0.25, 0.0), (2.0**-11, 2.0**-11)):
        found, known, _ = follow(monkeypatch, script, wide)
        assert found == (1, -1, False, 4, 2.0 * 2.0**-20, 80)
        assert known.why == [weight if fate == NO_ROOM else 0.0 for fate in range(16)]
    found, known, _ = follow(monkeypatch, script, STRAIGHT, friction=0.0)
    assert found == (1, -1, False, 5, 3.0 * 2.0**-20, 90)
    assert shares(known) == [0.0, 12.0 * 2.0**-20, 0.0, 0.0]
    assert known.why[NO_ROOM] == 2.0 * STRAIGHT


def test_it_stops_where_it_is_told_to(monkeypatch: pytest.MonkeyPatch) -> None:
    for halts in (1, 2, 3):
        found, _, _ = follow(monkeypatch, [(PARTED, -1)] * 9, NARROWEST, halts=halts)
        assert found[5] == 10 * halts
    found, _, _ = follow(monkeypatch, [(ENDED, 1)] * 9, 0.25, first=3)
    assert found[5] == 30


# All intervals.


class Intervals:
    """Where each interval ends, by its least phase and its width: ``(row, other, proven, pieces, lost)``."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, friction: float = 0.5) -> None:
        self.known, self.body = known_of(), body_of(friction)
        self.told: list[tuple[float, float]] = []
        self.halts = -1
        self.stack = zeros(2 * (FIRST + HALVINGS + 2))
        monkeypatch.setattr(friction_phases, "follow_interval", self.follow)

    def of(self, low: float, wide: float) -> tuple[int, int, bool, int, float]:
        return 0, -1, True, 1, 0.0

    def follow(self, start: Any, span: Any, scope: Any, *rest: Any) -> tuple[Any, ...]:
        assert (start, scope) == ((3.0, 0.25), SCOPE)
        low, high = span
        self.told.append((low, high - low))
        self.body.halt[0] = float(len(self.told) == self.halts)
        return *self.of(low, high - low), 10

    def run(self, *waiting: tuple[float, float], samples: int = 100_000) -> tuple[Any, ...]:
        """Follow these, the last first."""
        for k, (low, high) in enumerate(waiting):
            self.stack[2 * k], self.stack[2 * k + 1] = low, high
        cell = Cell(drift_of(), self.known, self.body, wall_of())
        return follow_phases((3.0, 0.25), len(waiting), samples, self.stack, SCOPE, room_of(), work_of(), cell)


def test_intervals_that_end_are_counted_by_their_length(monkeypatch: pytest.MonkeyPatch) -> None:
    every = Intervals(monkeypatch)
    monkeypatch.setattr(every, "of", lambda low, wide: (2 if low < 0.5 else 1, -1, True, 3, 0.0))
    assert every.run((0.75, 1.0), (0.5, 0.75), (0.0, 0.5)) == (0, 9, 0.0, 0.25, 30)
    assert every.told == [(0.0, 0.5), (0.5, 0.25), (0.75, 0.25)]
    assert shares(every.known) == [0.0, 0.5, 0.5, 0.0]


@pytest.mark.parametrize(("friction", "least"), [(0.5, NARROWEST), (0.0, STRAIGHT)])
def test_an_interval_with_two_ends_is_halved(friction: float, least: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Until it ends in one, or is one of the narrowest: there the boundary lies. With friction the first takes it."""
    every, border = Intervals(monkeypatch, friction), 0.3

    def of(low: float, wide: float) -> tuple[int, int, bool, int, float]:
        one, other = (0, 1) if wide < 0.125 else (1, 0)  # whichever of them it meets first
        return (one, other, True, 2, 0.0) if low < border < low + wide else (int(low > border), -1, True, 1, 0.0)

    monkeypatch.setattr(every, "of", of)
    waiting, ended, undecided, shortest, taken = every.run((0.0, 1.0))
    halvings = {NARROWEST: 32, STRAIGHT: 16}[least]
    assert (waiting, undecided, shortest) == (0, 0.0, least)
    assert (ended, taken) == (halvings + 2, 10 * (2 * halvings + 1))
    below, above = shares(every.known)[:2]
    shared = 0.0 if friction else 2.0 * least  # by their pieces
    assert below + above + shared == 1.0
    assert abs(below - border) <= least
    assert abs(1.0 - above - border) <= least + shared
    assert [low for low, wide in every.told if wide == 0.25] == [0.25, 0.0]


def test_what_is_not_proven_is_halved_only_while_it_is_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then all of it is undecided, and of the narrowest without friction what its pieces lost."""
    for row, other in ((-1, -1), (1, -1), (1, 2)):
        every = Intervals(monkeypatch)
        monkeypatch.setattr(every, "of", lambda low, wide, row=row, other=other: (row, other, False, 1, 2.0**-20))
        found = every.run((0.0, 2.0 * UNPROVEN))
        assert found == (0, 2, 2.0 * UNPROVEN, UNPROVEN, 30)
        assert not any(shares(every.known))
    for friction, wide, undecided in (
        (0.0, STRAIGHT, 2.0**-20), (0.0, 2.0 * STRAIGHT, 2.0 * STRAIGHT), (0.5, STRAIGHT, STRAIGHT),
        (0.5, NARROWEST, NARROWEST),
    ):  # fmt: skip
        every = Intervals(monkeypatch, friction)
        monkeypatch.setattr(every, "of", lambda low, wide: (1, -1, False, 1, 2.0**-20))
        assert every.run((0.0, wide)) == (0, 1, undecided, wide, 10)
        assert not any(shares(every.known))


def test_an_interval_without_any_end_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    every = Intervals(monkeypatch)
    monkeypatch.setattr(every, "of", lambda low, wide: (-1, -1, True, 0, 0.0))
    assert every.run((0.5, 0.75)) == (0, 0, 0.25, 0.25, 10)
    monkeypatch.setattr(every, "of", lambda low, wide: (0, -1, True, 1, 0.0))
    assert every.run((0.5, 0.75)) == (0, 1, 0.0, 0.25, 10)
    assert shares(every.known)[0] == 0.25


def test_several_that_are_undecided_add_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """With and without friction, narrow and not."""
    for friction, wide, lost, undecided in (
        (0.5, NARROWEST, 0.5, 2.0 * NARROWEST),
        (0.5, UNPROVEN, 0.5, 2.0 * UNPROVEN),
        (0.0, STRAIGHT, 2.0**-20, 2.0**-19),
    ):  # fmt: skip
        every = Intervals(monkeypatch, friction)
        monkeypatch.setattr(every, "of", lambda low, wide, lost=lost: (-1, -1, False, 2, lost))
        assert every.run((0.0, wide), (wide, 2.0 * wide)) == (0, 4, undecided, wide, 20)


def test_what_is_left_waits_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """When the samples of this time are taken, or when it is told to stop: then nothing of it is counted."""
    waiting = [(0.75, 1.0), (0.5, 0.75), (0.0, 0.5)]
    for samples, left in ((30, 0), (21, 0), (20, 1), (11, 1), (10, 2), (0, 3)):
        assert Intervals(monkeypatch).run(*waiting, samples=samples)[0] == left
    for halts, left, counted in ((1, 3, 0.0), (2, 2, 0.5), (3, 1, 0.75)):
        every = Intervals(monkeypatch)
        every.halts = halts
        found = every.run(*waiting)
        assert (found[0], found[4]) == (left, 10 * halts)
        assert shares(every.known)[0] == counted
        assert every.stack[: 2 * left] == [phase for one in waiting[:left] for phase in one]
    every = Intervals(monkeypatch)
    every.body.halt[0] = 0.5
    assert every.run(*waiting)[0] == 3
