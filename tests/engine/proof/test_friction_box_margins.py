"""Pieces with friction, followed to their ends, with all that moves and ends them written down.

Whether a piece reads one thing, is small, or is followed for too long, each on its margin; and no measure is lost.
"""

from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import CYCLE_PROVEN, GREW, REST_PROVEN, UNSETTLED
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets import friction_box
from hknob_cli.engine.general.sets.box import ENDED, KEPT, PARTED, UNPROVEN
from hknob_cli.engine.general.sets.cell import Cell, Centre
from hknob_cli.engine.general.sets.friction_box import OFTEN, follow_friction, follow_piece
from hknob_cli.engine.general.sets.friction_rest import UNKNOWN
from hknob_cli.engine.general.sets.known import FULL, NO_ROOM
from hknob_cli.engine.general.sets.piece import (
    BEFORE,
    COUNT,
    ERROR,
    LEVEL,
    SAMPLE,
    SPREAD,
    STATE,
    WEIGHT,
    piece_size,
)
from hknob_cli.engine.general.sets.room import make_piece_room
from hknob_cli.engine.general.sets.scope import Scope

from .friction_work import body_of, drift_of, wall_of, zeros

HUGE = 2.0**40
WIDE = [
    -0.25,
    -0.5,
    0.25,
    -0.5,
    0.25,
    0.5,
    -0.25,
    0.5,
]  # half a count, as the next
SLIM = [-0.25, 0.0, 0.25, 0.0]  # its radius is an eighth
AT = 3  # pieces that wait beneath


def piece(
    x: float = -1.5, v: float = 0.25, *, corners: list[float] | None = None, error: float = 0.0, before: float = -9.0,
    level: float = -2.0, sample: float = 16.0, weight: float = 0.5, spread: float = 0.0, ring: tuple[float, ...] = (),
    late: tuple[float, ...] = (),
) -> list[float]:  # fmt: skip
    """Numbers of a piece; it reads -2 unless told otherwise, and did so before."""
    given = SLIM if corners is None else corners
    one = zeros(piece_size(2 + len(late), len(ring)))
    one[ERROR], one[BEFORE], one[LEVEL], one[SAMPLE] = error, before, level, sample
    one[WEIGHT], one[COUNT], one[SPREAD] = weight, len(given) / 2.0, spread
    numbers = [x, v, *late, *ring, *given]
    one[STATE : STATE + len(numbers)] = numbers
    return one


class Followed:
    """Follows one piece, then those that each of its moves leaves; what all others are asked, by name.

    ``rows``: of a rest, by how often it is asked. Motions go on until no piece is left; then it is parted into two.
    """

    def __init__(self, *pieces: list[float], delay: int = 0, order: int = 2) -> None:
        self.pieces, self.delay, self.order = list(pieces), delay, order
        self.asked: list[tuple[str, tuple[Any, ...]]] = []
        self.rest: Any = UNKNOWN
        self.captor, self.keep, self.part, self.move = -1, False, AT + 3, AT + 2
        self.found: tuple[int, int] = (0, 100)
        self.known: Any = SimpleNamespace(
            law=None, turns=None, why=zeros(16), table=[REST_PROVEN, *zeros(FIELDS - 1)] * 4
        )
        self.body = body_of(0.5)
        self.body.order = order

    def __call__(self, patch: pytest.MonkeyPatch, **given: Any) -> tuple[int, int, int, int]:
        for name in ("part_piece", "captor", "resting_piece", "keep", "seek", "move_piece"):
            patch.setattr(friction_box, name, lambda *a, name=name: self._answer(name, a))
        numbers = {
            "width": 0.0, "patience": 1000, "budget": 1000, "limit": inf, "drift": drift_of(), "wall": wall_of(),
        } | given  # fmt: skip
        size = piece_size(self.order, self.delay)
        self.room: Any = make_piece_room(zeros, self.order, self.delay, lattice=8, deep=8)
        self.room = self.room._replace(stack=zeros(size * 8))
        self.put()
        scope = Scope(numbers["budget"], 0, numbers["patience"], numbers["limit"], fine=True)
        cell = Cell(numbers["drift"], self.known, self.body, numbers["wall"])
        given_to = self.room, "work", AT + 1, numbers["width"], scope, cell
        return follow_piece(*given_to)  # type: ignore[no-any-return, no-untyped-call]

    def put(self) -> None:
        size = piece_size(self.order, self.delay)
        self.room.stack[AT * size : (AT + 1) * size] = self.pieces.pop(0)

    def _answer(self, name: str, given: tuple[Any, ...]) -> Any:
        self.asked.append((name, tuple(self._as_it_is(one) for one in given)))
        if name == "move_piece" and self.pieces:
            self.put()
            return AT + 1
        answer = {"part_piece": self.part, "captor": self.captor, "keep": self.keep, "move_piece": self.move}
        if name == "resting_piece":
            return self.rest(given) if callable(self.rest) else self.rest
        return self.found if name == "seek" else answer[name]

    def _as_it_is(self, one: Any) -> Any:
        """What is told, before it changes; of the room its corners."""
        if isinstance(one, Centre):
            return one._replace(z=list(one.z), ring=list(one.ring))
        if one is self.room:
            return list(self.room.corners)
        return list(one) if isinstance(one, list) else one

    def names(self) -> list[str]:
        return [name for name, _ in self.asked]

    def of(self, name: str) -> list[tuple[Any, ...]]:
        return [given for one, given in self.asked if one == name]


# What is moved on.


@pytest.mark.parametrize("ring", [(), (3.0, 5.0)])
def test_a_piece_is_moved_as_it_is_until_it_is_no_longer_one(
    ring: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sample each; what it becomes is what is followed on, and as it acts is what counts."""
    other = piece(-2.5, 0.5, corners=WIDE, error=0.0625, before=-8.0, level=-3.0, sample=17.0, weight=0.25, ring=ring)
    one = Followed(piece(ring=ring, corners=SLIM), other, delay=len(ring))
    assert one(monkeypatch) == (AT + 2, PARTED, -1, 2)
    first, second = one.of("move_piece")
    for told, z, before, error, level, sample, weight, corners in (
        (first, [-1.5, 0.25], -9.0, 0.0, -2.0, 16.0, 0.5, SLIM),
        (second, [-2.5, 0.5], -8.0, 0.0625, -3.0, 17.0, 0.25, WIDE),
    ):
        assert told[1:3] == ("work", AT)
        assert told[3] == (z, before, list(ring), 0, error, level, sample, weight)
        assert told[0][: len(corners)] == corners
        assert told[4] == len(corners) // 2
    assert one.names() == ["resting_piece", "move_piece"] * 2
    assert one.of("resting_piece")[0][0][:3] == ([-1.5, 0.25], -9.0, list(ring))
    assert not any(one.known.why)


def test_a_piece_for_which_there_is_no_room_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for after, fate in ((-1, UNPROVEN), (AT, PARTED), (0, PARTED), (AT + 2, PARTED)):
        one = Followed(piece())
        one.move = after
        assert one(monkeypatch) == ((AT, UNPROVEN, -1, 1) if after < 0 else (after, fate, -1, 1))
        assert one.known.why[NO_ROOM] == (0.5 if after < 0 else 0.0)
        assert sum(one.known.why) == one.known.why[NO_ROOM]


def test_a_piece_is_followed_below_its_budget_and_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    for sample, x, fate in (
        (1000.0, -1.5, UNSETTLED), (1001.0, -1.5, UNSETTLED), (999.0, -1.5, None), (1000.5, -1.5, UNSETTLED),
        (16.0, 8.5, GREW), (16.0, 9.0, GREW), (16.0, 8.25, None), (16.0, -8.5, GREW), (16.0, -9.0, GREW),
        (16.0, -8.25, None), (1000.0, 9.0, UNSETTLED),
    ):  # fmt: skip
        one = Followed(piece(x, sample=sample, level=x // 1.0, corners=[0.0, 0.0]))
        found = one(monkeypatch, limit=8.5)
        if fate is None:
            assert (found, sum(one.known.why)) == ((AT + 2, PARTED, -1, 1), 0.0)
        else:
            assert (found, one.known.why[fate], sum(one.known.why)) == ((AT, UNPROVEN, -1, 0), 0.5, 0.5)
            assert one.asked == []


# Cut into its readings.


def levels(one: Followed, patch: pytest.MonkeyPatch, **given: Any) -> tuple[float, float] | float:
    """The readings into which it is cut; the one it has, if it has only one."""
    found = one(patch, **given)
    if one.names() == ["part_piece"]:
        told = one.of("part_piece")[0]
        assert found == (AT + 3, PARTED, -1, 1)
        return told[4], told[5]
    return float(one.of("move_piece")[0][3].level)


@pytest.mark.parametrize("by", range(2))
def test_a_piece_that_may_read_two_things_is_cut(by: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """An error and a rounding of its place count. It begins where a count does, and ends before the next."""
    corners = SLIM[2 * by :] + SLIM[: 2 * by]
    for x, error, right in (
        (-1.5, 0.0, -2.0), (-1.75, 0.0, (-3.0, -2.0)), (-1.7499, 0.0, -2.0), (-1.25, 0.0, (-2.0, -1.0)),
        (-1.2501, 0.0, -2.0), (-1.7188, 2.0**-6, (-3.0, -2.0)), (-1.7187, 2.0**-6, -2.0),
        (-1.2812, 2.0**-6, (-2.0, -1.0)), (-1.2813, 2.0**-6, -2.0), (-1.0, 1.0, (-4.0, 0.0)),
    ):  # fmt: skip
        one = Followed(piece(x, error=error, corners=corners))
        assert levels(one, monkeypatch) == right
    step = 2.0**-12  # between two doubles at 2^40, where a rounding is 2^-9
    for beside, error, right in (
        (-0.25 - 2.0**-9 - step, 0.0, -1.0), (-0.25 - 2.0**-9, 0.0, (-1.0, 0.0)), (0.25 + 2.0**-9, 0.0, 0.0),
        (0.25 + 2.0**-9 - step, 0.0, (-1.0, 0.0)), (0.25 + 3.0 * 2.0**-9, 2.0**-9, 0.0),
        (0.25 + 3.0 * 2.0**-9 - step, 2.0**-9, (-1.0, 0.0)),
    ):  # fmt: skip
        one = Followed(piece(-HUGE + beside, error=error, corners=corners))
        found = levels(one, monkeypatch)
        moved = found + HUGE if isinstance(found, float) else (found[0] + HUGE, found[1] + HUGE)
        assert moved == right


def test_what_it_is_cut_from_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    for ring in ((), (3.0, 5.0)):
        one = Followed(piece(-1.75, error=2.0**-6, ring=ring, level=-1.0), delay=len(ring))
        assert one(monkeypatch) == (AT + 3, PARTED, -1, 1)
        told = one.of("part_piece")[0]
        reach = 2.0**-5 + 8.0 * EPSILON * 1.75
        assert told[1:3] == (AT, ([-1.75, 0.25], -9.0, list(ring), 0, 2.0**-6, -1.0, 16.0, 0.5))
        assert (told[0][:4], told[3:7]) == (SLIM, (2, -3.0, -2.0, reach))
        one = Followed(piece(-1.75, ring=ring), delay=len(ring))
        one.part = -1
        assert one(monkeypatch) == (AT, UNPROVEN, -1, 1)
        assert (one.known.why[NO_ROOM], sum(one.known.why)) == (0.5, 0.5)
        one = Followed(piece(-1.75, ring=ring), delay=len(ring))
        one.part = 0
        assert one(monkeypatch) == (0, PARTED, -1, 1)


def test_a_part_is_settled_and_acts_as_it_was_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a sample more says so, though it goes beyond its edges."""
    for x in (-1.75, -1.25):
        one = Followed(piece(x, sample=16.5, level=-2.0))
        assert levels(one, monkeypatch) == -2.0
        assert one.of("move_piece")[0][3].sample == 16.0
    one = Followed(piece(-1.75, sample=16.0, level=-2.0))
    assert levels(one, monkeypatch) == (-3.0, -2.0)


def test_what_acts_alike_is_not_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Outside the wall, and deeper than the amplifier tells."""
    one = Followed(piece(1.0))
    assert levels(one, monkeypatch) == 0.0
    one = Followed(piece(-5.0))
    assert levels(one, monkeypatch, drift=drift_of(bottom=-4.0)) == -4.0
    one = Followed(piece(-4.0))
    assert levels(one, monkeypatch, drift=drift_of(bottom=-4.0)) == -4.0
    one = Followed(piece(-3.0))
    assert levels(one, monkeypatch, drift=drift_of(bottom=-4.0)) == (-4.0, -3.0)


def test_under_a_law_its_own_readings_count(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Followed(piece(0.5, corners=WIDE))
    one.known.law = SimpleNamespace(watch=wall_of(damping=1.0))
    assert levels(one, monkeypatch) == 0.0
    one = Followed(piece(1.0, corners=WIDE))
    one.known.law = SimpleNamespace(watch=wall_of(damping=1.0))
    assert levels(one, monkeypatch) == (0.0, 1.0)


# Where it ends.


def test_a_piece_that_steps_deeper_may_be_captured_and_any_other_may_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that has come out of the wall does neither; one that begins may stand from the beginning."""
    for last, sample, asked in (
        (-1.0, 16.0, "captor"), (-2.0, 16.0, "resting_piece"), (-3.0, 16.0, None), (-3.0, 0.0, "resting_piece"),
        (-3.0, 1.0, None), (-1.0, 0.0, "captor"), (-3.0, 8.0, None),
    ):  # fmt: skip
        one = Followed(piece(level=last, sample=sample))
        assert one(monkeypatch) == (AT + 2, PARTED, -1, 1)
        assert one.names() == ([asked, "move_piece"] if asked else ["move_piece"])
        for row in (0, 3):
            one = Followed(piece(level=last, sample=sample))
            one.rest = one.captor = row
            assert one(monkeypatch) == ((AT, ENDED, row, 1) if asked else (AT + 2, PARTED, -1, 1))
    one = Followed(piece())
    one.rest = FULL
    assert one(monkeypatch) == (AT + 2, PARTED, -1, 1)


@pytest.mark.parametrize("lag", [0.0, 0.5])
def test_its_error_is_with_all_that_torques_still_add(lag: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """By their spread over the rate of the lag: 1/4 by 1/2 is 1/2."""
    late = (7.0,) if lag else ()
    ahead = 0.0625 + (0.5 if lag else 0.0)
    for level in (-1.0, -2.0):
        for ring in ((), (3.0, 5.0)):
            given = piece(error=0.0625, spread=0.25, late=late, ring=ring, level=level, sample=16.5)
            given[LEVEL] = -2.0
            one = Followed(given, delay=len(ring), order=2 + len(late))
            one.body.lag = lag
            one(monkeypatch)
            told = one.of("resting_piece")[0]
            assert (told[0][:3], told[1:3]) == (([-1.5, 0.25, *late], -9.0, list(ring)), (ahead, 0.125))
            assert (told[0].level, told[3][:4], told[4]) == (-2.0, SLIM, 2)
            one = Followed(piece(error=0.0625, spread=0.25, late=late, ring=ring, level=-1.0), delay=len(ring),
                           order=2 + len(late))  # fmt: skip
            one.body.lag = lag
            one(monkeypatch)
            told = one.of("captor")[0]
            assert told[:5] == ([-1.5, 0.25, *late], -9.0, list(ring), 0, 0.125 + ahead)
            assert one.of("move_piece")[0][3].error == 0.0625


# Merged with others.


def kept(patch: pytest.MonkeyPatch, *pieces: list[float], width: float, section: float = 2.0, **given: Any) -> Followed:
    """A lattice that has room: which takes pieces below half its width, where ``section`` wide ones are merged."""
    patch.setattr(friction_box, "SMALL", 0.5)
    patch.setattr(friction_box, "SECTION", section)
    one = Followed(*pieces, **given)
    one.keep = True
    one.result = one(patch, width=width)  # type: ignore[attr-defined]
    return one


def test_a_small_piece_is_kept_where_the_wall_steps_deeper(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its radius and its error, in counts, are less than half a width; and it has moved."""
    for error, width, taken in (
        (0.0, 0.5, False), (0.0, 0.5001, True), (0.0625, 0.75, False), (0.0625, 0.7501, True),
        (0.0, 0.25, False),
    ):  # fmt: skip
        for ring in ((), (3.0, 5.0)):
            deeper = piece(-1.5, error=error, level=-1.0, sample=17.0, ring=ring)
            one = kept(monkeypatch, piece(ring=ring), deeper, width=width, delay=len(ring))
            assert one.result == ((AT, KEPT, -1, 2) if taken else (AT + 2, PARTED, -1, 2))  # type: ignore[attr-defined]
            assert len(one.of("keep")) == taken
            if taken:
                told = one.of("keep")[0]
                assert told[1] == ([-1.5, 0.25], -9.0, list(ring), 0, error, -1.0, 17.0, 0.5)
                assert (told[2][:4], told[3:5]) == (SLIM, (2, width))
    one = kept(monkeypatch, piece(level=-1.0), piece(), width=9.0)  # as it begins
    assert one.of("keep") == []
    one = kept(monkeypatch, piece(), piece(level=-3.0, sample=17.0), width=1.0)  # steps out
    assert one.of("keep") == []


def test_a_piece_for_which_the_lattice_has_no_room_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Followed(piece(), piece(level=-1.0, sample=17.0))
    assert one(monkeypatch, width=9.0) == (AT + 2, PARTED, -1, 2)
    assert one.names()[-2:] == ["keep", "move_piece"]


def test_wide_pieces_are_kept_every_so_often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where they do not step deeper, too: at samples that are whole numbers of `OFTEN`."""
    for width, sample, taken in (
        (2.25, 2.0 * OFTEN, True), (2.0, 2.0 * OFTEN, False), (1.75, 2.0 * OFTEN, False), (2.25, OFTEN + 1.0, False),
        (2.25, 2.0 * OFTEN - 1.0, False), (2.25, 1.5 * OFTEN, False),
    ):  # fmt: skip
        one = kept(monkeypatch, piece(sample=2.0), piece(sample=sample), width=width)
        assert len(one.of("keep")) == taken
    one = kept(monkeypatch, piece(sample=2.0 * OFTEN), piece(sample=2.0 * OFTEN + 0.5), width=9.0)
    assert one.of("keep") == []  # where it began
    one = kept(monkeypatch, piece(sample=2.0 * OFTEN + 2.0), piece(sample=2.0 * OFTEN), width=9.0)
    assert one.of("keep") == []


# Followed for long.


def sought(patch: pytest.MonkeyPatch, start: int, patience: int, steps: int, **given: Any) -> list[int]:
    """Samples at which the trial of a piece's centre is followed, from ``start`` on."""
    one = Followed(*(piece(sample=float(start + k)) for k in range(steps)))
    one(patch, patience=patience, **given)
    return [1000 - left_of(told) for told in one.of("seek")]


def left_of(told: tuple[Any, ...]) -> int:
    """Samples that the budget leaves a trial that is sought."""
    centre, scope, _ = told
    left: int = scope.budget - int(centre.sample)
    return left


def test_a_piece_that_goes_on_is_looked_at_twice_as_late_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces of one kind are looked at at one sample."""
    assert sought(monkeypatch, 0, 3, 25) == [3, 9, 21]
    assert sought(monkeypatch, 8, 3, 25) == [9, 15, 27]
    assert sought(monkeypatch, 7, 3, 10) == [9, 15]
    assert sought(monkeypatch, 6, 3, 10) == [9, 15]
    assert sought(monkeypatch, 6, 1, 10) == [7, 9, 13]


def test_an_end_that_the_trial_has_is_entered_or_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for ring in ((), (3.0, 5.0)):
        for row, fate in ((0, REST_PROVEN), (1, CYCLE_PROVEN), (0, UNSETTLED), (FULL, NO_ROOM), (-1, UNSETTLED)):
            one = Followed(*(piece(sample=float(k), ring=ring) for k in range(4)), delay=len(ring))
            one.found = (row, 100)
            if row >= 0:
                one.known.table[row * FIELDS] = fate
            found = one(monkeypatch, patience=3, limit=77.0)
            told = one.of("seek")[0]
            assert told[0][:4] == ([-1.5, 0.25], -9.0, list(ring), 0)
            assert (left_of(told), told[1].limit) == (997, 77.0)
            if fate in (REST_PROVEN, CYCLE_PROVEN):
                assert (found, sum(one.known.why)) == ((AT + 2, PARTED, -1, 104), 0.0)
            else:
                assert found == (AT, UNPROVEN, -1, 104)
                assert (one.known.why[fate], sum(one.known.why)) == (0.5, 0.5)
                assert one.names()[-1] == "seek"


def test_a_search_that_is_given_up_leaves_its_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    for halt in (1.0, 0.5, 5e-324):
        one = Followed(*(piece(sample=float(k)) for k in range(4)))
        one.found, one.body.halt = (-1, 100), [halt]
        assert one(monkeypatch, patience=3) == (AT + 1, PARTED, -1, 104)
        assert not any(one.known.why)


# All that wait.


def followed(
    patch: pytest.MonkeyPatch, script: list[tuple[int, int, int, int]], *, samples: int = 1000, friction: float = 0.0,
    waiting: int = 3, halt: list[float] | None = None, delay: int = 0,
) -> tuple[tuple[int, int, float, int], Any, list[int]]:  # fmt: skip
    """Follow pieces that weigh 1, 2, 4, ...: what came of them, the table, and how many waited each time."""
    told: list[int] = []

    def follow(room: Any, work: Any, waiting: int, *more: Any) -> tuple[int, int, int, int]:
        assert (work, more) == ("work", (2.0, scope, ("drift", known, body, "wall")))
        told.append(waiting)
        return script[len(told) - 1]

    patch.setattr(friction_box, "follow_piece", follow)
    size = piece_size(2, delay)
    room = SimpleNamespace(stack=zeros(size * 8), own=zeros(size))
    for k in range(8):
        room.stack[k * size + WEIGHT] = 2.0**k
    body, known = body_of(friction), SimpleNamespace(table=zeros(FIELDS * 4), turns=None)
    body.halt = halt or [0.0]
    scope, cell = Scope(budget=4, skip=0, patience=3, limit=5.0, fine=True), Cell("drift", known, body, "wall")
    found = follow_friction(room, "work", waiting, 2.0, samples, scope, cell)  # type: ignore[no-untyped-call]
    return found, known.table, told


@pytest.mark.parametrize("delay", [0, 2])
def test_pieces_are_followed_until_none_waits(delay: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last first. What ends without friction takes its area; with friction measures are no areas."""
    script = [(2, ENDED, 1, 10), (3, PARTED, -1, 20), (2, UNPROVEN, -1, 30), (1, KEPT, -1, 40), (0, ENDED, 2, 50)]
    for friction in (0.0, 1e-300, 0.5):
        found, table, told = followed(monkeypatch, script, friction=friction, delay=delay)
        assert (found, told) == ((0, 4, 4.0, 150), [3, 2, 3, 2, 1])
        shares = {1: 4.0, 2: 1.0} if friction == 0.0 else {}
        assert {row: table[row * FIELDS + 6] for row in range(4) if table[row * FIELDS + 6]} == shares
        assert sum(table) == sum(shares.values())


def test_pieces_are_followed_for_so_many_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    script = [(2, ENDED, 0, 10), (1, UNPROVEN, -1, 10), (1, PARTED, -1, 10)]
    for samples, times in ((1, 1), (10, 1), (11, 2), (20, 2), (21, 3), (30, 3), (0, 0)):
        found, _, told = followed(monkeypatch, script, samples=samples)
        waiting = [3, 2, 1, 1][times]
        assert (found, len(told)) == ((waiting, min(times, 2), 2.0 if times > 1 else 0.0, 10 * times), times)
    for halt in (1.0, 5e-324):
        assert followed(monkeypatch, script, halt=[halt])[0] == (3, 0, 0.0, 0)
    assert followed(monkeypatch, script, waiting=0)[0] == (0, 0, 0.0, 0)
    assert followed(monkeypatch, [(0, ENDED, 0, 10)], waiting=1)[0] == (0, 1, 0.0, 10)
