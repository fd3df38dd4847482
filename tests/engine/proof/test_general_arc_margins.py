"""Arcs of the general loop that wait, are followed, cut and counted, where what happens to them is written down.

What balls, searches and measures of arcs say is scripted; so an arc stands exactly where it ends, is cut, or looks for
an end of its own, and no phase of it may be lost. How the first one is told is checked at 60 digits.
"""

import random
from collections.abc import Callable
from math import inf
from types import SimpleNamespace
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN, REST_PROVEN, UNSETTLED
from hknob_cli.engine.follow import GREW as GREW_FATE
from hknob_cli.engine.general.body import Body, norm
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets import arc, arc_parts
from hknob_cli.engine.general.sets.arc_parts import (
    ARC_BEFORE,
    ARC_ERROR,
    ARC_LEVEL,
    ARC_SAMPLE,
    ARC_STATE,
    HIGH,
    LOW,
    arc_size,
)
from hknob_cli.engine.general.sets.ball import CAPTURED, FIRST_REST_TEST, GREW, MEETS_EDGE, OUT_OF_SAMPLES
from hknob_cli.engine.general.sets.cell import Cell, Centre
from hknob_cli.engine.general.sets.known import NO_ROOM, UNPROVEN_END
from hknob_cli.engine.general.sets.room import ArcRoom, make_arc_room
from hknob_cli.engine.general.sets.scope import Scope
from tests.engine.general.sets.cells import centre

from .orbits import DIGITS
from .test_general_capture_margins import body_of, room, wall_of
from .test_general_cutting_margins import drift_of, zeros

BODY = body_of(1.0, 4.0, 1.0)  # half a count for a norm of 1
DRIFT = drift_of()
DAMPED = wall_of(damping=0.25)  # each count acts by itself, and the last reading is remembered
NOTHING = SimpleNamespace(law=None, turns=None)
BUDGET, LIMIT, SLACK, LONG = 1000, 77.0, 0.125, 10**9
BALL = "centre", "radius", "run", "next_test", "samples", "limit", "small", "cell"
Answer = tuple[Any, ...]


def small_room(delay: int = 0, slots: int = 8, order: int = 2, ended: int = 30) -> ArcRoom:
    one = make_arc_room(zeros, order, delay)
    return one._replace(stack=[9.0] * (arc_size(order, delay) * slots), ended=[9.0] * ended)


def waiting(work: ArcRoom, at: int = 0, delay: int = 0, order: int = 2) -> list[float]:
    size = arc_size(order, delay)
    return list(work.stack[size * at : size * (at + 1)])


def says(event: int, used: int, row: int = -1, **more: Any) -> tuple[Answer, dict[str, Any]]:
    """What a ball comes to, and where its centre is then."""
    one = {"before": 0.0, "head": 0, "error": 0.25, "level": -2.0, "run": 3, "next_test": 16} | more
    return (event, row, *(one[k] for k in ("before", "head", "error", "level", "run", "next_test")), used), more


# Arcs that wait.


@pytest.mark.parametrize(("order", "delay"), [(2, 0), (3, 2)])
def test_an_arc_waits_with_all_that_goes_on_from_it(order: int, delay: int) -> None:
    """Its commands from the oldest on; the arcs before and after it are left alone."""
    assert tuple(range(7)) == (LOW, HIGH, ARC_ERROR, ARC_BEFORE, ARC_LEVEL, ARC_SAMPLE, ARC_STATE)
    assert arc_size(order, delay) == 7 - 1 + order + delay
    size, work = arc_size(order, delay), small_room(delay, 4, order)
    told = centre([3.0, 4.0, 5.0][:order], [20.0, 10.0][:delay], -1.0, head=1, error=0.125, level=-2.0, sample=7.0)
    assert arc_parts.wait_arc(work, 2, (0.25, 0.5), told) == 3
    assert work.stack[: 2 * size] == [9.0] * (2 * size)
    assert work.stack[2 * size : 3 * size] == [
        *(0.25, 0.5, 0.125, -1.0, -2.0, 7.0),
        *[3.0, 4.0, 5.0][:order],
        *[10.0, 20.0][:delay],
    ]
    assert work.stack[3 * size :] == [9.0] * size


@pytest.fixture
def moves(monkeypatch: pytest.MonkeyPatch) -> list[Answer]:
    """The centres that are told from another: the middle, the phase and the sample of each; both become its state."""
    told: list[Answer] = []

    def move_centre(centre: Centre, middle: float, to: float, *rest: Any) -> None:
        told.append((list(centre.z), middle, to, centre.sample))
        rest[-1][0], rest[-1][1] = to, middle

    monkeypatch.setattr(arc_parts, "move_centre", move_centre)
    return told


LOW_PHASE, HIGH_PHASE = 0.125, 0.625


@pytest.mark.parametrize(
    ("first", "last", "parts"),
    [
        (0.25, 0.5, [(0.125, 0.25), (0.25, 0.5), (0.5, 0.625)]),
        (0.5, 0.5, [(0.125, 0.5), (0.5, 0.625)]),
        (0.125, 0.5, [(0.125, 0.5), (0.5, 0.625)]),
        (0.5, 0.625, [(0.125, 0.5), (0.5, 0.625)]),
    ],
)
@pytest.mark.parametrize("delay", [0, 2])
def test_an_arc_is_cut_at_two_phases(
    moves: list[Answer], first: float, last: float, parts: list[tuple[float, float]], delay: int
) -> None:
    """Without a gap; each part is told from its own middle, with what that rounds, and has not moved on."""
    work, z, ring = small_room(delay), [3.0, 4.0], [20.0, 10.0][:delay]
    told = centre(z, ring, -1.0, head=1, error=0.25 + SLACK, level=-2.0, sample=7.0)
    cell = Cell(DRIFT, NOTHING, BODY, DAMPED)
    assert arc_parts.split_arc(work, 2, (LOW_PHASE, HIGH_PHASE), first, last, told, cell) == 2 + len(parts)
    assert moves == [([3.0, 4.0], 0.375, 0.5 * (low + high), 7) for low, high in parts]
    for k, (low, high) in enumerate(parts):
        waits = [low, high, 0.25 + SLACK, -1.0, 0.0, 7.0, 0.5 * (low + high), 0.375, *[10.0, 20.0][:delay]]
        assert waiting(work, 2 + k, delay) == waits


# Parts at edges.


class Parted:
    """A chord from ``left`` to ``right``, of phases from 1/8 to 5/8, parted at its edges."""

    def __init__(self, patch: pytest.MonkeyPatch, left: float, right: float, levels: Any, **more: Any) -> None:
        self.delay, self.steps = more.get("delay", 0), []
        patch.setattr(arc_parts, "step_through", self.step_through)
        self.work = small_room(self.delay, more.get("slots", 8))
        z = [0.5 * (left + right), 4.0]
        self.work.below[0], self.work.above[0] = left - z[0], right - z[0]
        self.ring = [20.0, 10.0][: self.delay]
        wall, drift = more.get("wall", DAMPED), DRIFT._replace(bottom=more.get("bottom", -inf))
        sample, reach = float(more.get("sample", 7)), more.get("reach", 0.0)
        told = centre(z, self.ring, -9.0, head=1, error=0.25 + SLACK, sample=sample)
        given = (LOW_PHASE, HIGH_PHASE), told, reach, *levels, Cell(drift, NOTHING, BODY, wall)
        self.total = arc_parts.part_arc(self.work, more.get("first", 2), *given)
        assert self.ring == [20.0, 10.0][: self.delay]

    def step_through(self, centre: Centre, *_: Any) -> Centre:
        z, before, ring, head, error, level, sample, _ = centre
        self.steps.append((list(z), before, error, level, list(ring), head))
        z[0], z[1] = z[0] + 100.0, z[1] + 10.0
        if self.delay:
            ring[0] = level
        head = 1 if self.delay else 0
        return centre._replace(before=level - 50.0, error=error + 1.0, head=head, sample=sample + 1.0)

    def phases(self) -> list[tuple[float, float, float]]:
        return [(one[ARC_LEVEL], one[LOW], one[HIGH]) for one in self.parts()]

    def parts(self) -> list[list[float]]:
        return [waiting(self.work, k, self.delay) for k in range(2, self.total)]


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize(("sample", "was"), [(7, [-9.0] * 3), (1, [-9.0] * 3), (0, [-2.0, -1.0, 0.0])])
def test_parts_move_on_as_their_readings_act(
    monkeypatch: pytest.MonkeyPatch, moves: list[Answer], delay: int, sample: int, was: list[float]
) -> None:
    """With what telling them from their middles rounds. At the first sample the last reading is the part's own."""
    one = Parted(monkeypatch, -2.0, 2.0, (-2.0, 0.0), delay=delay, wall=DAMPED, sample=sample)
    spans, levels = [(0.125, 0.25), (0.25, 0.375), (0.375, 0.5)], (-2.0, -1.0, 0.0)
    lines = [(20.0, level) for level in levels]
    assert moves == [([0.0, 4.0], 0.375, 0.5 * (low + high), sample) for low, high in spans]
    assert one.steps == [
        ([0.5 * (low + high), 0.375], last, 0.25 + SLACK, level, [10.0, 20.0][:delay], 0)
        for (low, high), last, level in zip(spans, was, levels, strict=True)
    ]
    assert one.parts() == [
        [low, high, 1.25 + SLACK, level - 50.0, level, sample + 1.0, 0.5 * (low + high) + 100.0, 10.375, *line[:delay]]
        for (low, high), level, line in zip(spans, levels, lines, strict=True)
    ]


@pytest.mark.parametrize("turned", [False, True])
def test_parts_reach_beyond_their_edges_by_what_they_must(
    monkeypatch: pytest.MonkeyPatch, moves: list[Answer], turned: bool
) -> None:
    """Whichever way the chord goes; nowhere beyond its ends. What lies on an edge is in the parts on both its sides."""

    def parted(left: float, right: float, levels: Any, reach: float, **more: Any) -> list[tuple[float, float, float]]:
        ends = (right, left) if turned else (left, right)
        return Parted(monkeypatch, *ends, levels, reach=reach, **more).phases()

    def spans(*parts: tuple[float, float, float]) -> list[tuple[float, float, float]]:
        """From shares of the chord."""
        if turned:
            parts = tuple((level, 1.0 - high, 1.0 - low) for level, low, high in parts)
        return [(level, 0.125 + 0.5 * low, 0.125 + 0.5 * high) for level, low, high in parts]

    eighth = 1.0 / 8.0
    assert parted(-1.5, 0.5, (-2.0, 0.0), 0.0) == spans((-2.0, 0.0, 0.25), (-1.0, 0.25, 0.75), (0.0, 0.75, 1.0))
    assert parted(-1.5, 0.5, (-2.0, 0.0), 0.25) == spans(
        (-2.0, 0.0, 3 * eighth), (-1.0, eighth, 7 * eighth), (0.0, 5 * eighth, 1.0)
    )
    assert parted(-0.75, -0.25, (-1.0, -1.0), 0.0) == spans((-1.0, 0.0, 1.0))
    assert parted(-2.0, -1.0, (-2.0, -1.0), 0.0) == spans((-2.0, 0.0, 1.0), (-1.0, 1.0, 1.0))
    assert parted(-1.0, 0.0, (-2.0, -1.0), 0.0) == spans((-2.0, 0.0, 0.0), (-1.0, 0.0, 1.0))
    # A reading that only roundings could make it show has no part where it is farther than these.
    assert parted(-1.0, 0.0, (-4.0, 1.0), 0.5) == spans((-2.0, 0.0, 0.5), (-1.0, 0.0, 1.0), (0.0, 0.5, 1.0))
    # Outside the wall and below where the amplifier is saturated all act alike.
    plain = wall_of()
    assert parted(-1.0, 1.0, (-1.0, 0.0), 0.0, wall=plain) == spans((-1.0, 0.0, 0.5), (0.0, 0.5, 1.0))
    assert parted(-3.0, 1.0, (-2.0, 0.0), 0.0, wall=plain, bottom=-2.0) == spans(
        (-2.0, 0.0, 0.5), (-1.0, 0.5, 0.75), (0.0, 0.75, 1.0)
    )


def test_an_arc_of_one_place_is_in_parts_that_reach_it(monkeypatch: pytest.MonkeyPatch, moves: list[Answer]) -> None:
    """As a whole, wherever its speed leads later."""
    whole = LOW_PHASE, HIGH_PHASE
    for place, reach, levels in (
        (-1.0, 0.0, [-2.0, -1.0]),
        (-1.5, 0.0, [-2.0]),
        (-0.75, 0.25, [-2.0, -1.0]),
        (-0.25, 0.25, [-1.0, 0.0]),
        (-0.5, 0.25, [-1.0]),
        (0.0, 0.0, [-1.0, 0.0]),
    ):
        one = Parted(monkeypatch, place, place, (-3.0, 1.0), reach=reach)
        assert one.phases() == [(level, *whole) for level in levels]


def test_there_is_room_for_all_parts_or_none_is_made(monkeypatch: pytest.MonkeyPatch, moves: list[Answer]) -> None:
    for slots, first, found in ((3, 0, 3), (2, 0, -1), (5, 2, 5), (4, 2, -1), (3, 2, -1)):
        assert Parted(monkeypatch, -2.0, 2.0, (-2.0, 0.0), slots=slots, first=first).total == found


# The first arc.


def half_on(start: list[float], body: Body) -> list[Any]:
    """Where free motion leads in half a sample, at the digits of the moment."""
    n = body.order
    rates = mp.matrix(n + 1, n + 1)
    for i in range(n):
        for j in range(n):
            rates[i, j] = mp.mpf(body.matrices[i * n + j])
        rates[i, n] = mp.mpf(body.vectors[i])
    moved = mp.expm(rates / 2) * mp.matrix([*map(mp.mpf, start), mp.mpf(1)])
    return list(moved)[:n]


def test_all_phases_wait_as_one_arc_about_half_a_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its error is more than what it is off, at 60 digits, and no more than 8 units of both ends and of the way."""
    chance, units = random.Random(1), [2.0, 0.75]
    for delay in (0, 2):
        for _ in range(40):
            body = body_of(10.0 ** chance.uniform(-2.0, 0.5), 10.0 ** chance.uniform(-2.0, 0.5), chance.gauss(0.0, 1.0))
            start = [chance.uniform(-100.0, 100.0), chance.uniform(-10.0, 10.0)]
            given: list[Answer] = []

            def wait_arc(work: Any, waits: int, span: Any, centre: Centre, said: Any = given) -> int:
                z, before, ring, *rest, _ = centre
                said.append((waits, *span, list(z), before, list(ring), *rest, len(z)))
                return waits + 1

            monkeypatch.setattr(arc, "wait_arc", wait_arc)
            work, drift = small_room(delay), DRIFT._replace(units=units, coast=1e-14)
            work.own_ring[:] = [9.0] * delay
            slack = arc.fill_arcs(start, work, drift, body)
            rate = [start[1], body.drive - body.beta * start[0] - body.alpha * start[1]]
            assert slack == pytest.approx(1e-14 * norm(rate, body), rel=1e-12, abs=0.0)
            waits, low, high, z, before, ring, head, error, level, sample, n = given[0]
            assert (len(given), waits, low, high, before, ring, head) == (1, 0, 0.0, 1.0, 0.0, [0.0] * delay, 0)
            assert (level, sample, n) == (0.0, 0.0, 2)
            sizes = sum(unit * (abs(one) + abs(other)) for unit, one, other in zip(units, start, z, strict=True))
            assert error == pytest.approx(slack + 8.0 * EPSILON * sizes, rel=1e-12, abs=0.0)
            with mp.workdps(DIGITS):
                off = [abs(mp.mpf(one) - true) for one, true in zip(z, half_on(start, body), strict=True)]
                assert sum(mp.mpf(unit) * one for unit, one in zip(units, off, strict=True)) < error


# Following.


class Followed:
    """All phases of one start, or a part of them."""

    def __init__(self, patch: pytest.MonkeyPatch, balls: list[Any], **more: Any) -> None:
        """``arcs``: low, high and sample of those that wait; ``seeks``: row and samples of each search."""
        self.balls, self.seeks, self.halts = list(balls), list(more.get("seeks", [])), more.get("halts", 0.0)
        self.bulges, self.wide = list(more.get("bulges", [])), more.get("wide", 0.25)
        self.ways = more.get("ways")
        self.parted = more.get("parted", [])
        self.seen: list[dict[str, Any]] = []
        self.measured: list[Answer] = []
        self.looked: list[Answer] = []
        self.steps: list[Answer] = []
        self.cuts: list[Answer] = []
        self.parts: list[Answer] = []
        for name in ("follow_ball", "seek", "measure_arc", "step_through", "split_arc", "part_arc"):
            patch.setattr(arc, name, getattr(self, name))
        self.delay, self.wall = more.get("delay", 0), more.get("wall", DAMPED)
        self.body, self.known = BODY._replace(halt=[0.0]), room(self.delay)
        self.cell = Cell(DRIFT, self.known, self.body, self.wall)
        self.known.table[0], self.known.table[FIELDS] = CYCLE_PROVEN, REST_PROVEN
        self.known.table[2 * FIELDS] = CYCLE_ON_EDGE
        self.room = small_room(self.delay, more.get("slots", 8), ended=more.get("ended", 30))
        self.totals, self.waits = [0.0, 0.0, 1.0, 0.0], 0
        error = more.get("error", 1.0)
        for low, high, sample in more.get("arcs", [(0.25, 0.75, 7)]):
            one = low, high, error, 5.0, -3.0, float(sample), more.get("x", 4.0), -2.0
            size = arc_size(2, self.delay)
            line = [10.0 * k for k in range(1, self.delay + 1)]
            self.room.stack[size * self.waits : size * (self.waits + 1)] = [*one, *line]
            self.waits += 1

    def follow_ball(self, *given: Any) -> Answer:
        one = dict(zip(BALL, given, strict=True))
        told, cell = one["centre"], one["cell"]
        self.seen.append(one | told._asdict() | cell._asdict() | {"z": list(told.z), "ring": list(told.ring)})
        (event, row, before, head, error, level, run, next_test, used), more = self.balls.pop(0)
        told.z[0] = more.get("x", told.z[0])
        if self.delay:
            told.ring[:] = [100.0, 200.0]
        sample = told.sample + used
        end = told._replace(before=before, head=head, error=error, level=level, sample=sample)
        return event, row, end, run, next_test

    def measure_arc(self, low: float, high: float, sample: int, *_: Any) -> tuple[float, float]:
        """The radius says which sample it is of, and how long the arc."""
        self.measured.append((low, high, sample))
        self.room.below[0], self.room.above[0] = self.ways or (-self.wide, self.wide)
        bulge = self.bulges.pop(0) if len(self.bulges) > 1 else (self.bulges or [0.0])[0]
        return high - low + sample / 1024.0, bulge

    def seek(self, centre: Centre, scope: Scope, cell: Cell) -> Any:
        z, before, ring, head = centre[:4]
        self.looked.append((list(z), before, list(ring), head, scope.budget - int(centre.sample), scope.limit))
        assert cell == self.cell
        self.body.halt[0] = self.halts
        return self.seeks.pop(0)

    def step_through(self, centre: Centre, *_: Any) -> Centre:
        z, before, ring, head, error, level, sample, _ = centre
        self.steps.append((list(z), before, error, level, list(ring), head))
        z[0] += 0.5
        return centre._replace(before=before + 1.0, error=error + 0.125, head=head + 1, sample=sample + 1.0)

    def split_arc(self, work: Any, waits: int, span: Any, first: float, last: float, centre: Centre, cell: Cell) -> int:
        z, before, _, head, error, _, sample, _ = centre
        self.cuts.append((waits, *span, first, last, list(z), before, head, error, sample))
        return self.parted.pop(0) if self.parted else 0

    def part_arc(
        self, work: Any, waits: int, span: Any, centre: Centre, reach: float, least: float, most: float, cell: Cell
    ) -> int:
        z, before, _, head, error, _, sample, _ = centre
        assert cell == self.cell
        self.parts.append((waits, *span, list(z), before, head, error, reach, sample, least, most))
        return self.parted.pop(0) if self.parted else 0

    def run(self, samples: int = LONG, patience: int = 64, budget: int = BUDGET, slack: float = SLACK) -> Answer:
        scope = Scope(budget=budget, skip=0, patience=patience, limit=LIMIT, fine=True)
        found = arc.follow_arcs(self.waits, slack, samples, self.totals, scope, self.room, self.cell)
        assert self.balls == []
        return tuple(found)

    def shares(self) -> list[float]:
        return [self.known.table[FIELDS * row + 6] for row in range(3)]

    def blamed(self) -> dict[int, float]:
        return {fate: weight for fate, weight in enumerate(self.known.why) if weight}


@pytest.fixture
def followed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Followed]:
    return lambda balls, **more: Followed(monkeypatch, balls, **more)


@pytest.mark.parametrize("delay", [0, 2])
def test_an_arc_is_followed_as_a_ball_around_its_middle(followed: Callable[..., Followed], delay: int) -> None:
    """With its error, its last reading and its commands; its radius with what all its states may be off."""
    one = followed([says(CAPTURED, 5, row=1)], delay=delay)
    assert one.run() == (0, 6)
    seen = one.seen[0]
    assert (seen["z"], seen["before"], seen["level"], seen["error"]) == ([4.0, -2.0], 5.0, -3.0, 1.0)
    assert (seen["ring"], seen["head"]) == ([10.0, 20.0][:delay], 0)
    assert (seen["run"], seen["next_test"], seen["limit"], seen["small"]) == (0, FIRST_REST_TEST, LIMIT, False)
    assert seen["radius"] == 0.5 + 7 / 1024 + SLACK
    assert (seen["drift"], seen["known"], seen["body"], seen["wall"]) == (DRIFT, one.known, one.body, DAMPED)
    assert one.measured == [(0.25, 0.75, 7)]
    assert one.shares() == [0.0, 0.5, 0.0]
    assert one.room.ended[:4] == [0.25, 0.75, 1.0, 9.0]
    assert one.totals == [1.0, 0.0, 0.5, 0.5]
    assert one.blamed() == {}


def test_arcs_are_counted_where_they_end(followed: Callable[..., Followed]) -> None:
    """The last that waits first; a search among them. The shortest is told, and all their lengths."""
    arcs = [(0.0, 0.25, 7), (0.25, 0.375, 7), (0.375, 1.0, 7)]
    balls = [says(CAPTURED, 5, row=0), says(GREW, 2), says(CAPTURED, 0, row=0)]
    one = followed(balls, arcs=arcs)
    assert one.run() == (0, 6 + 3 + 1)
    assert one.shares() == [0.875, 0.0, 0.0]
    assert one.totals == [3.0, 0.125, 0.125, 1.0]
    assert one.blamed() == {GREW_FATE: 0.125}
    assert one.room.ended[:10] == [0.375, 1.0, 0.0, 0.25, 0.375, -1.0, 0.0, 0.25, 0.0, 9.0]
    for ended, kept in ((9, 9), (8, 6), (3, 3), (2, 0)):
        one = followed(balls, arcs=arcs, ended=ended)
        one.run()
        assert sum(value != 9.0 for value in one.room.ended) == kept
        assert one.totals == [3.0, 0.125, 0.125, 1.0]


def test_what_grows_or_spends_its_samples_is_undecided(followed: Callable[..., Followed]) -> None:
    """Whatever row a search before has told."""
    for answer, sample, fate in (
        (says(GREW, 3, row=4), 7, GREW_FATE),
        (says(GREW, 5), 995, GREW_FATE),
        (says(OUT_OF_SAMPLES, 5), 995, UNSETTLED),
        (says(OUT_OF_SAMPLES, 6), 995, UNSETTLED),
        (says(MEETS_EDGE, 5), 995, UNSETTLED),
    ):
        one = followed([answer], arcs=[(0.25, 0.75, sample)])
        assert one.run() == (0, 1 + answer[0][-1])
        assert one.blamed() == {fate: 0.5}
        assert one.totals == [1.0, 0.5, 0.5, 0.5]
        assert one.room.ended[:3] == [0.25, 0.75, -1.0]
        assert not any(one.known.table[6::FIELDS])
    one = followed([says(OUT_OF_SAMPLES, 10), says(GREW, 0)], seeks=[(1, 0)])
    one.run(patience=10)
    assert one.room.ended[2] == -1.0
    one = followed([says(CAPTURED, 5, row=0)], arcs=[(0.25, 0.75, 995)])
    one.run()
    assert one.totals[1] == 0.0


def test_calls_end_with_their_samples_or_where_all_is_given_up(followed: Callable[..., Followed]) -> None:
    """An arc costs one sample more than it takes."""
    arcs = [(0.0, 0.25, 7), (0.25, 0.5, 7), (0.5, 1.0, 7)]
    for samples, count in ((0, 0), (1, 1), (4, 1), (5, 2), (8, 2), (9, 3)):
        one = followed([says(CAPTURED, 3, row=0)] * count, arcs=arcs)
        assert one.run(samples) == (3 - count, 4 * count)
        assert one.totals[0] == count
    one = followed([], arcs=arcs)
    one.body.halt[0] = 1.0
    assert one.run() == (3, 0)
    assert followed([], arcs=[]).run() == (0, 0)


def test_samples_end_with_patience_or_budget(followed: Callable[..., Followed]) -> None:
    """Whichever is first; a look begins it anew, twice as long."""
    balls = [*(says(OUT_OF_SAMPLES, used) for used in (10, 8, 12)), says(CAPTURED, 0, row=0)]
    one = followed(balls, seeks=[(0, 100), (1, 30), (1, 7)])
    assert one.run(patience=10) == (0, 1 + 10 + 8 + 12 + 137)
    assert [seen["samples"] for seen in one.seen] == [10, 20, 40, 80]
    assert [seen["radius"] for seen in one.seen] == [0.5 + at / 1024 + SLACK for at in (7, 17, 25, 37)]
    assert [looked[4] for looked in one.looked] == [BUDGET - 17, BUDGET - 25, BUDGET - 37]
    assert one.measured == [(0.25, 0.75, at) for at in (7, 17, 25, 37)]
    one = followed([says(OUT_OF_SAMPLES, 4), says(GREW, 0)], arcs=[(0.25, 0.75, 990)], seeks=[(0, 0)])
    one.run()
    assert [seen["samples"] for seen in one.seen] == [10, 6]


def test_an_arc_long_in_no_known_attractor_looks_for_its_middles_own(followed: Callable[..., Followed]) -> None:
    ways = says(OUT_OF_SAMPLES, 10, x=3.0, before=2.0, head=1)
    for row in (0, 1):
        one = followed([ways, says(CAPTURED, 0, row=row)], seeks=[(row, 100)], delay=2)
        assert one.run(patience=10) == (0, 111)
        assert one.looked == [([3.0, -2.0], 2.0, [100.0, 200.0], 1, BUDGET - 17, LIMIT)]
        assert one.shares()[row] == 0.5
        seen = one.seen[1]
        assert (seen["before"], seen["head"], seen["error"], seen["level"]) == (2.0, 1, 0.25, -2.0)
        assert (seen["run"], seen["next_test"]) == (3, 16)
    for row, fate in ((2, CYCLE_ON_EDGE), (UNPROVEN_END, UNSETTLED), (-2, NO_ROOM)):
        one = followed([ways], seeks=[(row, 100)])
        assert one.run(patience=10) == (0, 111)
        assert one.blamed() == {fate: 0.5}
        assert one.totals == [1.0, 0.5, 0.5, 0.5]
        assert one.room.ended[:3] == [0.25, 0.75, row]
        assert one.shares() == [0.0, 0.0, 0.5 if row == 2 else 0.0]


def test_an_arc_waits_on_where_a_search_is_given_up_or_a_call_ends(followed: Callable[..., Followed]) -> None:
    """With where it is; how long it has been in no attractor begins anew."""
    ways = says(OUT_OF_SAMPLES, 10, x=3.0, before=2.0, head=1)
    told = [0.25, 0.75, 0.25, 2.0, -2.0, 17.0, 3.0, -2.0, 200.0, 100.0]
    for halts, samples in ((1.0, LONG), (0.0, 111), (0.0, 50)):
        one = followed([ways], seeks=[(UNPROVEN_END, 100)], delay=2, halts=halts)
        assert one.run(samples, patience=10) == (1, 111)
        assert waiting(one.room, 0, 2) == told
        assert (one.totals, one.blamed(), one.room.ended[0]) == ([0.0, 0.0, 1.0, 0.0], {}, 9.0)
    one = followed([ways], seeks=[(UNPROVEN_END, 100)])
    assert one.run(112, patience=10) == (0, 111)


# At an edge.


def met(x: float, **more: Any) -> tuple[Answer, dict[str, Any]]:
    return says(MEETS_EDGE, 0, x=x, **({"error": 0.25} | more))


def test_an_arc_inside_one_reading_goes_on_one_sample(followed: Callable[..., Followed]) -> None:
    """As that reading acts; which counts for rest and for its patience."""
    for level, run, next_test in ((-2.0, 4, 16), (-1.0, 0, FIRST_REST_TEST)):
        one = followed([met(-1.5, before=2.0, head=7, level=level), says(CAPTURED, 3, row=0)])
        assert one.run(patience=10) == (0, 1 + 1 + 3)
        assert one.steps == [([-1.5, -2.0], 2.0, 0.25, -2.0, [], 7)]
        seen = one.seen[1]
        assert (seen["z"], seen["before"], seen["error"], seen["head"]) == ([-1.0, -2.0], 3.0, 0.375, 8)
        assert (seen["level"], seen["run"], seen["next_test"], seen["samples"]) == (-2.0, run, next_test, 9)
        assert seen["radius"] == 0.5 + 7 / 1024 + SLACK
    one = followed([met(-1.5), says(GREW, 0)], arcs=[(0.25, 0.75, 990)])
    one.run()
    assert one.seen[1]["samples"] == 9
    one = followed([says(MEETS_EDGE, 3, x=-1.5), says(CAPTURED, 0, row=0)])
    assert one.run(patience=10) == (0, 1 + 3 + 1)
    assert [seen["samples"] for seen in one.seen] == [10, 6]


def test_at_the_first_sample_nothing_has_acted_yet(followed: Callable[..., Followed]) -> None:
    """No ball is followed there; what reads alike has shown that reading before, too."""
    one = followed([says(CAPTURED, 3, row=0)], arcs=[(0.25, 0.75, 0)], x=-1.5, error=0.25)
    assert one.run() == (0, 1 + 1 + 3)
    assert one.steps == [([-1.5, -2.0], -2.0, 0.25, -2.0, [], 0)]
    assert one.measured == [(0.25, 0.75, 0)] * 2
    assert one.seen[0]["z"] == [-1.0, -2.0]
    for sample in (1, 2):
        one = followed([met(-1.5, before=4.0), says(CAPTURED, 0, row=0)], arcs=[(0.25, 0.75, sample)])
        one.run()
        assert one.steps[0][1] == 4.0
    plain = followed([says(CAPTURED, 0, row=0)], arcs=[(0.25, 0.75, 0)], x=-1.5, error=0.25, wall=wall_of())
    plain.run()
    assert plain.steps[0][1] == 0.0
    spent = followed([], arcs=[(0.25, 0.75, 0)])
    assert spent.run(budget=0) == (0, 1)
    assert spent.blamed() == {UNSETTLED: 0.5}


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("x", [-8.0, 8.0, 0.0])
def test_an_arc_reaches_as_far_as_its_ends_its_bulge_and_its_roundings(
    followed: Callable[..., Followed], x: float, turned: bool
) -> None:
    """Errors as positions, half of what they are in the norm; beside both edges of a count, whichever way it goes."""
    short, long = (0.25, -0.125) if turned else (-0.125, 0.25)
    least_off, most_off = min(short, long), max(short, long)
    for bulge in (0.0, 0.125, 0.25):
        reach = 0.5 * (0.125 + SLACK) + 0.5 * bulge
        for off in (1e-9, -1e-9):
            for edge, middle in (
                (x + 1.0, x + 1.0 - most_off - reach - off),
                (x, x - least_off + reach + off),
            ):
                then = [] if off < 0.0 else [says(CAPTURED, 0, row=0)]
                one = followed([met(middle, error=0.125), *then], bulges=[bulge], ways=(short, long))
                one.run()
                assert (len(one.parts), len(one.steps)) == ((1, 0) if off < 0.0 else (0, 1))
                if off < 0.0:
                    waits, low, high, z, before, head, error, told, sample, least, most = one.parts[0]
                    assert (waits, low, high, z, before, head) == (0, 0.25, 0.75, [middle, -2.0], 0.0, 0)
                    assert (error, sample, least, most) == (0.125 + SLACK, 7, edge - 1.0, edge)
                    assert told == pytest.approx(reach + 8.0 * EPSILON * abs(middle), rel=1e-15, abs=0.0)


def test_the_place_of_an_arc_is_rounded_too(followed: Callable[..., Followed]) -> None:
    """8 units of it: seen where there is no error, and nothing else to be lost."""
    for x in (1024.0, -1024.0):
        for off in (7.0, -7.0, 9.0, -9.0):
            parted = abs(off) < 8.0
            then = [] if parted else [says(CAPTURED, 0, row=0)]
            one = followed([met(x + off * EPSILON * 1024.0, error=0.0), *then], ways=(0.0, 0.0))
            one.run(slack=0.0)
            assert len(one.parts) == parted


def test_an_arc_that_bulges_by_more_than_rounding_is_cut_beside_the_edge(followed: Callable[..., Followed]) -> None:
    """Twice its reach before and beyond it; which way ever it goes. Then its parts wait, and nothing has ended."""
    narrow, bulge = 0.5 * 0.03125, 0.0625
    reach = narrow + 0.5 * bulge + 8.0 * EPSILON * 8.0
    for wide in (0.375, -0.375):
        for x, share in ((-8.0, 0.5), (-8.1875, 0.75)):
            one = followed([met(x, error=0.0, before=2.0, head=7)], bulges=[bulge], ways=(-wide, wide), parted=[0])
            assert one.run(slack=0.03125) == (0, 1)
            waits, low, high, first, last, z, before, head, error, sample = one.cuts[0]
            assert (waits, low, high, z, before, head) == (0, 0.25, 0.75, [x, -2.0], 2.0, 7)
            assert (error, sample) == (0.03125, 7)
            middle, part = share if wide > 0.0 else 1.0 - share, 2.0 * reach / 0.75
            assert first == pytest.approx(0.25 + 0.5 * (middle - part), rel=1e-12)
            assert last == pytest.approx(0.25 + 0.5 * (middle + part), rel=1e-12)
            assert (one.parts, one.totals, one.blamed()) == ([], [0.0, 0.0, 1.0, 0.0], {})
        # At an end of the arc there is nothing beyond.
        for x, share in ((-8.390625, 1.0), (-7.609375, 0.0)):
            one = followed([met(x, error=0.0)], bulges=[bulge], ways=(-wide, wide))
            one.run(slack=0.03125)
            first, last = one.cuts[0][3:5]
            end = share if wide > 0.0 else 1.0 - share
            assert (last if end == 1.0 else first) == (0.75 if end == 1.0 else 0.25)
            assert last - first == pytest.approx(0.5 * (2.0 * reach - 0.015625) / 0.75, rel=1e-9)


def test_an_arc_that_bulges_much_is_halved(followed: Callable[..., Followed]) -> None:
    """By a sixteenth of its way from end to end."""
    bow = 0.0625
    for part, halved in ((1.0 + 1e-12, False), (1.0, True), (1.0 - 1e-12, True)):
        wide = 8.0 * bow * part
        one = followed([met(0.0, error=0.0)], bulges=[2.0 * bow], ways=(-wide, wide), arcs=[(0.125, 0.625, 7)])
        one.run(slack=0.0)
        assert (one.cuts[0][3:5] == (0.375, 0.375)) == halved


@pytest.mark.parametrize("turned", [False, True])
def test_an_arc_whose_end_alone_meets_the_edge_is_halved_where_rounding_hides_that(
    followed: Callable[..., Followed], turned: bool
) -> None:
    """Else the same arc would be cut for ever."""
    ways = (2.0**-70, -0.75) if turned else (-0.75, 2.0**-70)
    one = followed([met(0.0, error=0.0)], bulges=[2.0**-65], ways=ways)
    one.run(slack=0.0)
    assert one.cuts[0][3:5] == (0.5, 0.5)
    assert one.parts == []


def test_what_is_shorter_than_can_be_told_apart_is_parted_with_its_bulge(followed: Callable[..., Followed]) -> None:
    """And so is what bulges by no more than rounding."""
    for high, cut in ((1e-13, False), (1.00000001e-13, True)):
        one = followed([met(0.0, error=0.0)], bulges=[1.0], arcs=[(0.0, high, 7)])
        one.run(slack=0.0)
        assert (len(one.cuts), len(one.parts)) == (cut, not cut)
        if not cut:
            assert one.parts[0][7] == 0.5
    for high, cut in ((0.5 + 1e-13, True), (0.5 + 0.9e-13, False)):
        one = followed([met(0.0, error=0.0)], bulges=[1.0], arcs=[(0.5, high, 7)])
        one.run(slack=0.0)
        assert (len(one.cuts), len(one.parts)) == (cut, not cut)
    for bulge, cut in ((0.375, False), (0.375 + 1e-12, True)):
        one = followed([met(0.0)], bulges=[bulge])
        one.run()
        assert (len(one.cuts), len(one.parts)) == (cut, not cut)


def test_there_is_room_for_what_an_arc_is_cut_into_or_the_search_ends(followed: Callable[..., Followed]) -> None:
    """Four places are left at least; what finds none ends it all."""
    for slots, others, room_left in ((8, 4, True), (8, 5, False), (5, 1, True), (5, 2, False)):
        one = followed([met(0.0)], slots=slots, arcs=[(0.0, 0.25, 7)] * others + [(0.25, 0.75, 7)])
        found = one.run(1)
        assert found == ((0, 1) if room_left else (-1, 1))
        assert len(one.parts) == room_left
    for parted, found in ((-1, (-1, 1)), (0, (0, 1))):
        assert followed([met(0.0)], parted=[parted]).run() == found
    # What is left of the arcs goes on.
    one = followed([met(0.0), says(CAPTURED, 2, row=0)], parted=[1])
    assert one.run() == (0, 1 + 1 + 2)
    assert one.totals[0] == 1.0
