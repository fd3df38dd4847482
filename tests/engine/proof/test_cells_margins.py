"""Cells of which all clock phases are followed: what is told of each, where arcs and ends are written down."""

from collections.abc import Callable
from math import isnan
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine import cells as any_cells
from hknob_cli.engine.budget import OPEN, TOO_FINE
from hknob_cli.engine.cells import CELL, FIELD, Asked
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import UNSETTLED
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.orbit_holds import LENGTH
from hknob_cli.engine.sets import cells
from hknob_cli.engine.sets.arc import COVERED, DONE, PROGRESS, TAKEN, UNDECIDED, WAITING, WHOLE
from hknob_cli.engine.sets.ball import Start
from hknob_cli.engine.sets.cells import (
    TOLD,
    UNFOLLOWED,
    ArcWork,
    first_patience,
    follow_cell,
    lost_share,
    run_arc_cells,
    share_error,
)
from hknob_cli.engine.sets.room import ArcRoom
from tests.engine.sets.loops import known as room_of

LOOP = make_loop(0.3, 0.25, 0.5, 0.375, 1.0, 0.0, 0.0)
Answer = tuple[Any, ...]


def arcs_of(**told: float) -> ArcRoom:
    progress = [7.0] * PROGRESS
    for name, place in (
        ("waiting", WAITING), ("taken", TAKEN), ("covered", COVERED), ("undecided", UNDECIDED), ("done", DONE),
        ("whole", WHOLE),
    ):  # fmt: skip
        progress[place] = told.get(name, 7.0)
    lists = ([9.0] * 4 for _ in range(4))
    return ArcRoom(*lists, cuts=[9.0], ended=[9.0], progress=progress)


def test_an_attractor_is_looked_for_after_half_the_transient() -> None:
    assert [first_patience(skip) for skip in (0, 127, 128, 129, 130, 131, 1000)] == [64, 64, 64, 64, 65, 65, 500]


# One cell.


class One:
    """Calls of `follow_cell`, with what is to come of them."""

    def __init__(self, patch: pytest.MonkeyPatch, fate: int = OPEN, whole: float = 1.0, left: float = 0.0) -> None:
        self.fate, self.whole, self.left = fate, whole, left
        self.begun: list[Answer] = []
        self.followed: list[Answer] = []
        for name in ("prospect", "begin_arcs", "follow_arcs"):
            patch.setattr(cells, name, getattr(self, name))

    def prospect(self, x: float, v: float, most: int, loop: Any) -> Answer:
        assert (x, v, most) == (2.0, 0.25, 77)
        return self.fate, 1000, 300, 55.0

    def begin_arcs(self, *given: Any) -> None:
        self.begun.append((*given[0], given[1]))

    def follow_arcs(self, *given: Any) -> int:
        self.followed.append((*given[0], *given[1:5]))
        given[5].progress[WHOLE], given[5].progress[WAITING] = self.whole, self.left
        return 33

    def run(self, tries: int = 0, waiting: float = 0.0, loop: Any = LOOP) -> tuple[Answer, Any]:
        arcs, known = arcs_of(waiting=waiting), room_of(2)
        known.counts[:] = [3.0, 4.0, 5.0]
        return follow_cell(loop, Start(2.0, 0.25, 2), 77, tries, 50, arcs, known), known


def test_a_cell_begins_with_all_phases_and_nothing_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """And goes on where some still wait."""
    for waiting, begun in ((0.0, [(2.0, 0.25, 2, 150)]), (1.0, []), (5.0, [])):
        one = One(monkeypatch)
        found, known = one.run(waiting=waiting)
        assert found == (1, 33)
        assert one.begun == begun
        assert known.counts == ([3.0, 4.0, 5.0] if waiting else [0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("tries", "samples", "final"),
    [(0, 1000, True), (999, 999, False), (1, 1, False), (1000, 1000, True), (2000, 1000, True)],
)
def test_motions_get_all_their_samples_or_those_of_a_try(
    monkeypatch: pytest.MonkeyPatch, tries: int, samples: int, final: bool
) -> None:
    one = One(monkeypatch)
    one.run(tries)
    assert one.followed == [(2.0, 0.25, 2, samples, 55.0, 50, final)]


def test_what_becomes_of_a_call(monkeypatch: pytest.MonkeyPatch) -> None:
    """All have ended, some wait, or arcs cannot be followed; they are not where nothing damps or holds the knob."""
    for whole, left, state in ((1.0, 0.0, 1), (1.0, 1.0, 0), (1.0, 4.0, 0), (0.0, 0.0, -1), (0.0, 2.0, -1)):
        assert One(monkeypatch, whole=whole, left=left).run()[0] == (state, 33)
    for fate, loop in (
        (TOO_FINE, LOOP),
        (OPEN, make_loop(0.0, 0.25, 0.5, 0.375, 1.0, 0.0, 0.0)),
        (OPEN, make_loop(0.3, 0.0, 0.5, 0.375, 1.0, 0.0, 0.0)),
    ):
        one = One(monkeypatch, fate)
        found, known = one.run(loop=loop)
        assert found == (-1, 0)
        assert (one.begun, one.followed, known.counts) == ([], [], [3.0, 4.0, 5.0])


# What is told of it.


def test_the_share_that_is_lost_is_what_no_row_has() -> None:
    """Of the length of all arcs, which may overlap; a billionth is rounding; nothing is lost where all are proven."""
    table = [7.0] * 40
    table[8], table[18], table[28], table[38] = 0.25, 0.5, 0.125, 90.0
    for rows, covered, lost in ((3, 1.0, 0.125), (2, 1.0, 0.25), (3, 1.25, 0.3), (0, 1.0, 1.0)):
        progress = arcs_of(undecided=0.125, covered=covered).progress
        assert lost_share(table, rows, progress) == pytest.approx(lost, rel=1e-15)
    assert lost_share(table, 2, arcs_of(undecided=0.0, covered=1.0).progress) == 0.0
    for off, told in ((2.0**-30, 0.0), (2.0**-29, 2.0**-29), (-(2.0**-20), 0.0)):
        table[8] = 0.375 - off
        assert lost_share(table, 3, arcs_of(undecided=1.0, covered=1.0).progress) == told
    assert UNFOLLOWED == 1e-9


def test_a_share_is_wrong_by_overlaps_and_rounded_lengths() -> None:
    """No more than all lengths exceed 1, and half a unit of each length and each sum; by two times at least."""
    for covered, done, error in (
        (1.25, 7.0, 0.25 + 8.0 * EPSILON),
        (1.0, 7.0, 8.0 * EPSILON),
        (1.0 - 2.0**-50, 3.0, 4.0 * EPSILON),
        (1.0, 0.0, EPSILON),
    ):
        assert share_error(arcs_of(covered=covered, done=done).progress) == error


# Many cells.


class Run:
    """Cells of like numbers, whose arcs end as is written down."""

    def __init__(self, patch: pytest.MonkeyPatch, states: list[Answer], **more: Any) -> None:
        """``states``: state, samples, rows, undecided share and share that is lost of each call of a cell."""
        self.states, self.longest = list(states), list(more.get("longest", []))
        self.followed: list[Answer] = []
        self.sampled: list[Answer] = []
        self.written: list[Answer] = []
        self.ends: list[Answer] = []
        for name in ("follow_cell", "find_ends", "set_end"):
            patch.setattr(cells, name, getattr(self, name))
        for name in ("longest_orbit", "write_ends"):
            patch.setattr(any_cells, name, getattr(self, name))
        plants = more.get("plants", [(0.3, 0.25, 0.0)] * 4)
        self.cells = [7.0] * (CELL * len(plants))
        for k, (alpha, beta, split) in enumerate(plants):
            self.cells[CELL * k : CELL * k + 9] = [alpha, beta, 0.5, 0.375, 0.25, split, 2.0, 10.0 + k, 0.5]
        self.arcs, self.known = arcs_of(), room_of(4)
        holds = SimpleNamespace(drive=[0.0] * 100)
        self.room = SimpleNamespace(order=[0.0] * 8, table=[0.0] * 80, lines=[], holds=holds, parts=[5.0] * 36)
        self.out, self.told = [0.0] * (FIELD * more.get("slots", 99)), [9.0] * (TOLD * len(plants))

    def follow_cell(self, loop: Any, start: Any, most: int, tries: int, left: int, *rest: Any) -> Any:
        arcs, known = rest
        assert known is self.known
        assert (len(arcs.ring), len(arcs.spare), arcs.progress is self.arcs.progress) == (2, 2, True)
        self.followed.append((loop.alpha, loop.beta, loop.kappa, loop.gamma, loop.sense, loop.offset, loop.split))
        self.followed.append((*start, most, tries, left))
        state, taken, rows, undecided, lost = self.states.pop(0)
        arcs.progress[UNDECIDED], arcs.progress[COVERED], arcs.progress[DONE] = undecided, 1.0, 3.0
        arcs.progress[TAKEN], known.counts[0] = 40.0, float(rows)
        for row in range(rows):
            self.room.table[10 * row + 8] = (1.0 - lost) / rows
        return state, taken

    def find_ends(self, loop: Any, x: float, v: float, delay: int, *rest: Any) -> tuple[int, int]:
        self.sampled.append((x, v, delay, *rest[:3]))
        assert rest[3] is self.room
        return 5, 600

    def set_end(self, table: Any, row: int, fate: int, share: float) -> None:
        assert table is self.room.table
        self.ends.append((row, fate, share))

    def longest_orbit(self, found: int, table: Any, loop: Any) -> int:
        assert table is self.room.table
        return self.longest.pop(0) if self.longest else 100

    def write_ends(self, at: int, found: int, delay: int, loop: Any, room: Any, out: Any, rows: int) -> None:
        self.written.append((at, found, delay, rows, room.parts[LENGTH]))
        room.parts[LENGTH] = 5.0

    def run(self, first: int = 0, stop: int = 4, most: int = 10_000) -> Answer:
        work = ArcWork(self.arcs, self.known, self.told, 9)
        return tuple(run_arc_cells(self.cells, first, stop, Asked(-1.0, 64, 77, most), work, self.room, self.out))


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Run]:
    return lambda states, **more: Run(monkeypatch, states, **more)


DONE_CELL = (1, 30, 3, 0.0, 0.0)


def test_cells_are_told_one_after_another(runs: Callable[..., Run]) -> None:
    """Samples are those of all calls of a cell; rows go on where the last one's end."""
    one = runs([DONE_CELL, (1, 50, 2, 0.0, 0.0)])
    assert one.run(1, 3) == (3, 5, 80, 0)
    assert one.followed == [
        (0.3, 0.25, 0.5, 0.375, -1.0, 0.25, 0.0), (11.0, 0.5, 2, 77, 0, 10_001),
        (0.3, 0.25, 0.5, 0.375, -1.0, 0.25, 0.0), (12.0, 0.5, 2, 77, 0, 9971),
    ]  # fmt: skip
    assert one.written == [(1, 3, 2, 0, 0.0), (2, 2, 2, 3, 5.0)]
    assert one.told == [9.0] * 3 + [1.0, 3.0, 4.0 * EPSILON] * 2 + [9.0] * 3
    assert (one.ends, one.sampled) == ([], [])


def test_what_is_lost_is_an_end_of_its_own(runs: Callable[..., Run]) -> None:
    one = runs([(1, 30, 2, 0.25, 0.25), (1, 30, 2, 0.25, 0.0), (1, 30, 2, 0.25, 0.5)])
    assert one.run(0, 3) == (3, 3 + 2 + 3, 120, 0)
    assert one.ends == [(2, UNSETTLED, 0.25), (2, UNSETTLED, 0.5)]
    assert [one.told[TOLD * k] for k in range(3)] == [0.0] * 3
    assert [written[1:4:2] for written in one.written] == [(3, 0), (2, 3), (3, 5)]


def test_phases_are_sampled_where_arcs_cannot_be_followed(runs: Callable[..., Run]) -> None:
    """That list is not proven to be complete."""
    one = runs([(-1, 30, 2, 0.0, 0.0), DONE_CELL])
    assert one.run(0, 2) == (2, 8, 640, 0)
    assert one.sampled == [(10.0, 0.5, 2, 64, 77, 9)]
    assert one.told[:2] == [0.0, 0.0]
    assert isnan(one.told[2])
    assert one.followed[3][-1] == 10_000 - 630 + 1


def test_a_call_ends_with_its_samples_its_room_or_within_a_cell(runs: Callable[..., Run]) -> None:
    assert runs([DONE_CELL] * 2).run(most=59) == (2, 6, 80, 0)
    assert runs([DONE_CELL] * 3).run(most=60) == (3, 9, 120, 0)
    assert runs([DONE_CELL]).run(most=29) == (1, 3, 40, 0)
    for state, first in (((0, 30, 3, 0.0, 0.0), 2), ((0, 30, 3, 0.5, 0.0), 2)):
        one = runs([DONE_CELL, DONE_CELL, state])
        assert one.run() == (first, 6, 80, 0)
        assert one.told[TOLD * 2 :] == [9.0] * 6
    for slots, stops in ((10, 0), (11, 1), (13, 1), (14, 2)):  # of 8 ends that a cell may have
        one = runs([DONE_CELL] * 2, slots=slots - 3)
        assert one.run(0, 2)[0] == stops
    assert runs([DONE_CELL] * 2, slots=8).run(0, 2) == (1, 3, 40, 0)


def test_an_orbit_that_finds_no_room_ends_a_call(runs: Callable[..., Run]) -> None:
    """With its length; the cell is begun anew."""
    one = runs([DONE_CELL] * 2, longest=[100, 101])
    assert one.run() == (1, 3, 40, 101)
    assert len(one.written) == 1


def test_parts_are_made_anew_for_another_plant(runs: Callable[..., Run]) -> None:
    for plants, anew in (
        ([(0.3, 0.25, 0.0)] * 3, [0.0, 5.0, 5.0]),
        ([(0.3, 0.25, 0.0), (0.4, 0.25, 0.0), (0.4, 0.25, 0.0)], [0.0, 0.0, 5.0]),
        ([(0.3, 0.25, 0.0), (0.3, 0.5, 0.0), (0.3, 0.25, 0.0)], [0.0, 0.0, 0.0]),
        ([(0.3, 0.25, 0.0), (0.3, 0.25, 0.5), (0.3, 0.25, 0.5)], [0.0, 0.0, 5.0]),
    ):
        one = runs([DONE_CELL] * 3, plants=plants)
        one.run(0, 3)
        assert [written[-1] for written in one.written] == anew
