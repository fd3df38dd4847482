"""Arcs that wait, are followed, cut and counted: what becomes of each where balls, cuts and ends are written down.

What `follow_ball`, `cut`, `follow` and `add_end` say is scripted; so an arc stands exactly where it ends, is cut, or
looks for an end of its own, and no phase of it may be lost.
"""

from collections.abc import Callable
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN, REST_EDGE, REST_PROVEN, UNSETTLED
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.sets import arc
from hknob_cli.engine.sets.arc import ARC, COVERED, DONE, PATIENCE, PROGRESS, SHORTEST, SPENT, TAKEN, UNDECIDED, WHOLE
from hknob_cli.engine.sets.arc_cut import arc_speed, free_motion
from hknob_cli.engine.sets.ball import CAPTURED, FIRST_REST_TEST, GREW, MEETS_EDGE, OUT_OF_SAMPLES, Start, Trial
from hknob_cli.engine.sets.room import ArcRoom
from tests.engine.sets.loops import known, zeros

from .orbits import DIGITS
from .test_arc_margins import truly

LOOP = make_loop(0.3, 0.25, 0.5, 0.375, 1.0, 0.0, 0.0)  # at rest at -1.5
REST, ANGLE, VELOCITY = -1.5, 2.0, 0.25
BUDGET, LONG = 1000, 10**9
BALL = ("x", "v", "radius", "error", "level", "run", "next_test", "ring", "head", "samples", "limit", "small")
Answer = tuple[Any, ...]  # of `follow_ball`: event, row, trial, used


def says(event: int, used: int, row: int = -1, x: float = 5.0, **more: float) -> Answer:
    one = {"v": 0.5, "error": 0.0, "level": -2.0, "run": 3, "next_test": 16, "head": 0} | more
    return event, row, Trial(x, *(one[k] for k in ("v", "error", "level", "run", "next_test", "head"))), used


class Search:
    """All phases of one start, with what is found on the way."""

    def __init__(self, patch: pytest.MonkeyPatch, balls: list[Answer], **more: Any) -> None:
        """``cuts``: parts of one arc after another; ``ends``: fate, samples and row; ``rows`` are known before."""
        self.balls, self.cuts = list(balls), list(more.get("cuts", []))
        self.ends, self.delay, self.rows = list(more.get("ends", [])), more.get("delay", 0), more.get("rows", 0)
        self.seen: list[dict[str, Any]] = []
        self.cut_at: list[Answer] = []
        self.steps: list[Answer] = []
        self.looked: list[Answer] = []
        for name in ("follow_ball", "cut", "follow", "add_end", "step_through"):
            patch.setattr(arc, name, getattr(self, name))
        slots = more.get("slots", 8)
        self.room = ArcRoom(
            stack=[9.0] * ARC * slots, rings=[9.0] * 8 * slots, ring=zeros(self.delay), spare=[9.0] * self.delay,
            cuts=zeros(30), ended=zeros(more.get("ended", 30)), progress=[9.0] * PROGRESS,
        )  # fmt: skip
        self.known = known(self.delay)
        self.known.counts[0] = self.rows
        self.start = Start(ANGLE, VELOCITY, self.delay)
        arc.begin_arcs(self.start, more.get("patience", 64), self.room, LOOP)
        if "span" in more:
            self.room.stack[:2] = more["span"]

    def follow_ball(self, *given: Any) -> Answer:
        trial, radius, ring, samples, limit, small, *_ = given
        told = {"radius": radius, "ring": list(ring), "samples": samples, "limit": limit, "small": small}
        self.seen.append(trial._asdict() | told)
        assert self.seen[-1]["small"] is False
        if self.delay:
            ring[:] = [10.0 * len(self.seen) + k for k in range(self.delay)]
        return self.balls.pop(0)

    def cut(self, *given: Any) -> int:
        low, high, x, v, reach, flight, cuts, _ = given
        self.cut_at.append((low, high, x, v, flight.speed, flight.base, reach, flight.dx, flight.dv))
        parts = self.cuts.pop(0)
        if isinstance(parts, int):
            return parts
        for k, part in enumerate(parts):
            cuts[3 * k : 3 * k + 3] = part
        return len(parts)

    def follow(
        self, x: float, v: float, ring: Any, head: int, samples: int, limit: float, loop: Any, final: bool
    ) -> Any:
        self.looked.append((x, v, list(ring), head, samples, limit, final))
        fate, steps, _ = self.ends[0]
        return fate, 6, 1.25, 0.5, 1, steps

    def add_end(self, fate: int, period: int, x: float, v: float, ring: Any, head: int, *_: Any) -> int:
        assert (fate, period, x, v, head) == (self.ends[0][0], 6, 1.25, 0.5, 1)
        return int(self.ends.pop(0)[2])

    def step_through(self, x: float, v: float, error: float, level: float, ring: Any, head: int, loop: Any) -> Any:
        self.steps.append((x, v, error, level, list(ring), head))
        if self.delay:
            ring[head] = level
        return x + 0.5, v + 0.25, error + 0.125, (head + 1) % self.delay if self.delay else head

    def run(self, most: int = LONG, budget: int = BUDGET) -> int:
        return int(arc.follow_arcs(self.start, budget, 77.0, most, True, self.room, self.known, LOOP))

    def told(self, *names: int) -> list[float]:
        return [self.room.progress[k] for k in names]

    def shares(self) -> list[float]:
        return [self.known.table[10 * row + 8] for row in range(6)]

    def waiting(self, at: int = 0) -> list[float]:
        return list(self.room.stack[ARC * at : ARC * (at + 1)])


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Search]:
    return lambda balls, **more: Search(monkeypatch, balls, **more)


def flown(samples: float) -> tuple[float, float]:
    """The free motion about its rest point so long after the start."""
    return free_motion(samples, ANGLE - REST, VELOCITY, LOOP)


def radius_at(samples: int, low: float = 0.0, high: float = 1.0) -> float:
    """Half the arc's length, at its speed from its first phase on."""
    return 0.5 * (high - low) * arc_speed(*free_motion(low, *flown(float(samples)), LOOP), LOOP)


def test_one_arc_of_all_phases_waits_at_first(search: Callable[..., Search]) -> None:
    """With its middle where half a sample of free flight leads, at 60 digits."""
    one = search([], delay=2, patience=7)
    low, high, n, x, v, error, level, run, next_test, radius, since, wait = one.waiting()
    assert (low, high, n, level, run, next_test, since, wait) == (0.0, 1.0, 0.0, 0.0, 0.0, FIRST_REST_TEST, 0.0, 0.0)
    with mp.workdps(DIGITS):
        true_x, true_v = truly(mp.mpf(0.5), ANGLE - REST, VELOCITY, LOOP)
        assert abs(true_x + REST - x) < 1e-14
        assert abs(true_v - v) < 1e-14
    assert error == arc.position_error(ANGLE, VELOCITY, LOOP)
    assert radius == 0.5 * arc_speed(ANGLE - REST, VELOCITY, LOOP)
    assert one.room.rings[:3] == [0.0, 0.0, 9.0]
    assert one.room.progress == [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 7.0]


def test_an_arc_that_is_captured_counts_for_its_row(search: Callable[..., Search]) -> None:
    one = search([says(CAPTURED, 5, row=2)])
    assert one.run() == 5
    assert one.shares() == [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    assert one.room.ended[:3] == [0.0, 1.0, 2.0]
    assert one.room.progress == [0.0, 5.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 64.0]
    assert one.run() == 0


def test_what_grows_or_spends_its_samples_is_undecided(search: Callable[..., Search]) -> None:
    for answers, spent in (
        ([says(GREW, 5)], 0.0),
        ([says(GREW, BUDGET)], 0.0),
        ([says(OUT_OF_SAMPLES, BUDGET)], 1.0),
        ([says(OUT_OF_SAMPLES, BUDGET + 1)], 1.0),
        ([says(MEETS_EDGE, BUDGET)], 1.0),
        ([says(OUT_OF_SAMPLES, 999), says(GREW, 0)], 0.0),
    ):
        one = search(answers, patience=BUDGET)
        one.run()
        assert one.balls == []
        assert one.told(UNDECIDED, SPENT, COVERED, DONE, WHOLE) == [1.0, spent, 1.0, 1.0, 1.0]
        assert one.room.ended[:3] == [0.0, 1.0, -1.0]
        assert one.shares() == [0.0] * 6


def test_samples_end_with_patience_budget_or_call(search: Callable[..., Search]) -> None:
    """Whichever is first; and where a call ends, the next one goes on."""
    for patience, budget, most, samples in ((64, 100, 1000, 64), (200, 100, 1000, 100), (64, 100, 10, 10)):
        one = search([says(GREW, 0)], patience=patience)
        one.run(most, budget)
        assert one.seen[0]["samples"] == samples
        assert one.seen[0]["limit"] == 77.0
    halfway = says(OUT_OF_SAMPLES, 10, x=3.0, v=-0.5, error=0.125, level=-1.0, run=4, next_test=32, head=1)
    one = search([halfway, says(OUT_OF_SAMPLES, 10, head=1), says(CAPTURED, 3, row=0)], delay=3)
    assert one.run(10) == 10
    assert one.waiting() == [0.0, 1.0, 10.0, 3.0, -0.5, 0.125, -1.0, 4.0, 32.0, radius_at(0), 10.0, 64.0]
    assert one.room.rings[:3] == [11.0, 12.0, 10.0]  # the oldest first
    assert one.told(arc.WAITING, TAKEN, DONE, COVERED) == [1.0, 10.0, 0.0, 0.0]
    assert one.run(10) == 10
    assert one.run(100) == 3
    assert [seen["samples"] for seen in one.seen] == [10, 10, 44]
    second = one.seen[1]
    assert [second[k] for k in BALL[:9]] == [3.0, -0.5, radius_at(0), 0.125, -1.0, 4, 32, [11.0, 12.0, 10.0], 0]
    assert one.told(TAKEN, COVERED) == [23.0, 1.0]


def test_an_arc_without_an_end_looks_for_its_middles_own(search: Callable[..., Search]) -> None:
    """After its patience, which doubles; and that of all, where the end was known already."""
    for fate in (CYCLE_PROVEN, REST_PROVEN):
        for row, rows, patience in ((0, 0, 64.0), (3, 3, 64.0), (2, 3, 128.0), (0, 1, 128.0)):
            one = search(
                [says(OUT_OF_SAMPLES, 64, x=3.0, v=-0.5, head=1), says(CAPTURED, 3, row=row)],
                ends=[(fate, 20, row)],
                rows=rows,
                delay=2,
            )
            assert one.run() == 64 + 20 + 3
            assert one.looked == [(3.0, -0.5, [10.0, 11.0], 1, BUDGET - 64, 77.0, True)]
            assert one.seen[1]["samples"] == 128
            assert one.seen[1]["radius"] == radius_at(64)
            assert one.told(PATIENCE, UNDECIDED) == [patience, 0.0]
            assert one.shares()[row] == 1.0
    one = search([says(OUT_OF_SAMPLES, 64), says(CAPTURED, 3, row=0)], ends=[(CYCLE_PROVEN, 20, 0)], rows=1)
    one.run(budget=100)
    assert one.told(PATIENCE) == [100.0]
    assert one.seen[1]["samples"] == 36
    # It waits no longer than its own patience: 64, then 128.
    ends = [(CYCLE_PROVEN, 20, 0), (CYCLE_PROVEN, 20, 1)]
    one = search([says(OUT_OF_SAMPLES, 64), says(OUT_OF_SAMPLES, 128), says(GREW, 0)], ends=ends)
    one.run()
    assert len(one.looked) == 2
    assert one.seen[2]["samples"] == 256


def test_a_search_under_way_is_finished_before_a_call_ends(search: Callable[..., Search]) -> None:
    """Then no sample is left, not even one; the next call goes on."""
    none = says(OUT_OF_SAMPLES, 0)
    one = search([says(OUT_OF_SAMPLES, 64), none, says(CAPTURED, 1, row=0)], ends=[(CYCLE_PROVEN, 20, 0)])
    assert one.run(70) == 84
    assert one.run(70) == 1
    assert [seen["samples"] for seen in one.seen] == [64, 0, 70]
    again = search([says(OUT_OF_SAMPLES, 64), says(CAPTURED, 1, row=0)], ends=[(CYCLE_PROVEN, 20, 0)])
    again.run(100)
    assert [seen["samples"] for seen in again.seen] == [64, 16]


@pytest.mark.parametrize(
    ("fate", "steps", "row", "spent", "share"),
    [
        (CYCLE_PROVEN, 20, -1, 0.0, 0.0),
        (REST_PROVEN, BUDGET - 64, -1, 1.0, 0.0),
        (UNSETTLED, BUDGET - 65, 3, 0.0, 1.0),
        (UNSETTLED, BUDGET - 64, 3, 1.0, 1.0),
        (CYCLE_ON_EDGE, 20, 0, 0.0, 1.0),
        (REST_EDGE, 20, 1, 0.0, 1.0),
        (UNSETTLED, 20, -1, 0.0, 0.0),
    ],
)
def test_an_end_that_is_not_proven_decides_nothing(
    search: Callable[..., Search], fate: int, steps: int, row: int, spent: float, share: float
) -> None:
    """Its share is said to lead there, and is undecided."""
    one = search([says(OUT_OF_SAMPLES, 64)], ends=[(fate, steps, row)], rows=4)
    one.run()
    assert one.told(UNDECIDED, SPENT, PATIENCE, DONE) == [1.0, spent, 64.0, 1.0]
    assert one.room.ended[2] == -1.0
    assert sum(one.shares()) == share
    assert share == 0.0 or one.shares()[row] == share


def test_an_arc_is_cut_where_its_ball_as_it_is_now_meets_an_edge(search: Callable[..., Search]) -> None:
    """Radius and error from its middle, on either side of an edge, except for a billionth."""
    radius, error = radius_at(7), 0.125
    assert radius + error < 0.5
    for side in (1.0, -1.0):
        for near, cut in ((1.0 - 1e-9, True), (1.0 + 1e-9, False)):
            x = side * near * (radius + error)
            one = search([says(MEETS_EDGE, 7, x=x, error=error), says(GREW, 0)], cuts=[-1])
            one.run()
            assert bool(one.cut_at) == cut
            assert one.told(WHOLE) == [0.0 if cut else 1.0]
            if not cut:
                assert one.seen[1]["radius"] == radius


def meets(x: float = 0.0, used: int = 7, **more: float) -> Answer:
    return says(MEETS_EDGE, used, x=x, error=0.25, **more)


def test_a_cut_is_told_where_the_arc_lies(search: Callable[..., Search]) -> None:
    """Its ends, its first state and speed, what its middle lies off its free motion, and all errors."""
    one = search([meets(x=0.125)], cuts=[-1])
    one.run()
    motion, middle = flown(7.0), free_motion(0.5, *flown(7.0), LOOP)
    first = free_motion(0.0, *motion, LOOP)
    slack = arc.position_error(ANGLE, VELOCITY, LOOP)
    assert one.cut_at == [(0.0, 1.0, *first, arc_speed(*first, LOOP), 0.125 - middle[0], 0.25 + slack, *motion)]


def test_an_arc_in_one_level_takes_one_sample_more(search: Callable[..., Search]) -> None:
    """In the level that was found; whose samples go on being counted only where it is the same."""
    for level, run, next_test in ((-2.0, 4, 16), (-1.0, 0, FIRST_REST_TEST)):
        one = search(
            [meets(x=0.125, v=0.5, run=3, next_test=16, level=-2.0, head=1), says(CAPTURED, 2, row=0)],
            cuts=[[(level, 0.0, 1.0)]],
            delay=2,
        )
        assert one.run() == 7 + 1 + 2
        assert one.steps == [(0.125, 0.5, 0.25, level, [10.0, 11.0], 1)]
        assert [one.seen[1][k] for k in BALL[:10]] == [
            0.625, 0.75, radius_at(7), 0.375, level, run, next_test, [10.0, level], 0, 64 - 8,
        ]  # fmt: skip
        assert one.shares()[0] == 1.0
    late = search([meets(), says(OUT_OF_SAMPLES, BUDGET - 8)], cuts=[[(0.0, 0.0, 1.0)]], patience=2 * BUDGET)
    late.run()
    assert late.seen[1]["samples"] == BUDGET - 8
    assert late.told(SPENT, UNDECIDED) == [1.0, 1.0]  # its sample counts, too


def test_parts_of_an_arc_wait_each_with_its_own_middle(search: Callable[..., Search]) -> None:
    """One sample later, in its own level, from the middle that was followed; the last part is followed first."""
    parts = [(-2.0, 0.0, 0.5), (-1.0, 0.5, 0.75), (0.0, 0.75, 1.0)]
    slack, motion = arc.position_error(ANGLE, VELOCITY, LOOP), flown(7.0)
    middle = free_motion(0.5, *motion, LOOP)
    one = search([meets(x=0.125, head=1)], cuts=[parts], delay=2)
    assert one.run(8) == 7 + 3
    assert one.told(arc.WAITING, TAKEN, DONE, COVERED) == [3.0, 10.0, 0.0, 0.0]
    speed = arc_speed(*free_motion(0.0, *motion, LOOP), LOOP)
    for k, (level, first, last) in enumerate(parts):
        at = free_motion(0.5 * (first + last), *motion, LOOP)
        x, v = 0.125 + (at[0] - middle[0]), 0.5 + (at[1] - middle[1])
        assert one.steps[k] == (x, v, 0.25 + slack, level, [10.0, 11.0], 1)
        assert one.waiting(k) == [
            first, last, 8.0, x + 0.5, v + 0.25, 0.25 + slack + 0.125, level, 0.0, FIRST_REST_TEST,
            0.5 * (last - first) * speed, 0.0, 0.0,
        ]  # fmt: skip
        assert one.room.rings[2 * k : 2 * k + 2] == [10.0, level]
    one.balls = [says(CAPTURED, 4, row=2), says(CAPTURED, 5, row=1), says(GREW, 6)]
    assert one.run() == 15
    assert [seen["level"] for seen in one.seen[1:]] == [0.0, -1.0, -2.0]
    assert [seen["samples"] for seen in one.seen] == [8, 64, 64, 64]
    assert one.seen[1]["ring"] == [10.0, 0.0]
    assert one.shares() == [0.0, 0.25, 0.25, 0.0, 0.0, 0.0]
    assert one.room.ended[:9] == [0.75, 1.0, 2.0, 0.5, 0.75, 1.0, 0.0, 0.5, -1.0]
    assert one.told(UNDECIDED, COVERED, SHORTEST, DONE, TAKEN) == [0.5, 1.0, 0.25, 3.0, 25.0]


def test_an_arc_gets_the_samples_that_those_before_it_left(search: Callable[..., Search]) -> None:
    """Of one call: 20 less 7 and two parts, then less 4 more."""
    halves = [(-1.0, 0.0, 0.5), (0.0, 0.5, 1.0)]
    one = search([meets(), says(CAPTURED, 4, row=0), says(OUT_OF_SAMPLES, 7)], cuts=[halves])
    assert one.run(20) == 20
    assert [seen["samples"] for seen in one.seen] == [20, 11, 7]
    assert one.told(arc.WAITING, TAKEN, DONE) == [1.0, 20.0, 1.0]


def test_an_arc_that_finds_no_room_ends_the_search(search: Callable[..., Search]) -> None:
    """For its parts, among those that wait; or where arcs are too many, or overlap too much."""
    halves = [(-1.0, 0.0, 0.5), (0.0, 0.5, 1.0)]
    for slots, whole in ((2, True), (1, False)):
        one = search([meets(), says(GREW, 0), says(GREW, 0)], cuts=[halves], slots=slots)
        one.run()
        assert one.told(WHOLE, DONE) == ([1.0, 2.0] if whole else [0.0, 0.0])
    more = search([meets(), meets(), *[says(GREW, 0)] * 3], cuts=[halves, halves], slots=3)
    more.run()
    assert more.told(WHOLE, DONE) == [1.0, 3.0]
    full = search([meets(), meets()], cuts=[halves, halves], slots=2)
    full.run()
    assert full.told(arc.WAITING, WHOLE, DONE) == [0.0, 0.0, 0.0]


def test_arcs_that_are_too_many_or_overlap_too_much_end_the_search(
    search: Callable[..., Search], monkeypatch: pytest.MonkeyPatch
) -> None:
    for copies, whole in ((2, True), (3, False)):
        one = search([meets(), *[says(CAPTURED, 0, row=0)] * copies], cuts=[[(-1.0, 0.0, 1.0), (0.0, 0.0, 1.0)] * 2])
        one.cuts[0] = one.cuts[0][:copies]
        one.run()
        assert one.told(WHOLE, COVERED) == [float(whole), float(copies)]
    thirds = [(-1.0, 0.0, 0.25), (0.0, 0.25, 0.5), (-1.0, 0.5, 1.0)]
    for most, done, whole in ((2, 2.0, 0.0), (3, 3.0, 0.0), (4, 3.0, 1.0)):
        monkeypatch.setattr(arc, "MOST_ARCS", most)
        for room in (6, 8):  # for two
            one = search([meets(), *[says(CAPTURED, 0, row=0)] * 3], cuts=[thirds], ended=room)
            one.run()
            assert one.told(DONE, WHOLE, arc.WAITING) == [done, whole, 0.0]
            assert one.room.ended == [0.5, 1.0, 0.0, 0.25, 0.5, 0.0, 0.0, 0.0][:room]
    assert arc.MOST_COVERED == 2.0


LOW, HIGH = 0.25, 0.75


def test_a_part_of_all_phases_counts_as_long_as_it_is(search: Callable[..., Search]) -> None:
    """However it ends."""
    span, known_end = (LOW, HIGH), (CYCLE_PROVEN, 20, -1)
    for balls, ends, spent, row in (
        ([says(CAPTURED, 5, row=2)], [], 0.0, 2),
        ([says(OUT_OF_SAMPLES, BUDGET)], [], 0.5, -1),
        ([says(GREW, 5)], [], 0.0, -1),
        ([says(OUT_OF_SAMPLES, 64)], [known_end], 0.0, -1),
        ([says(OUT_OF_SAMPLES, 64)], [(UNSETTLED, BUDGET - 64, 1)], 0.5, 1),
    ):
        one = search(balls, ends=ends, span=span)
        one.run()
        open_end = balls[0][0] != CAPTURED
        assert one.told(COVERED, SHORTEST, SPENT, UNDECIDED) == [0.5, 0.5, spent, 0.5 if open_end else 0.0]
        assert one.room.ended[:3] == [LOW, HIGH, -1.0 if open_end else 2.0]
        assert one.shares() == [0.5 if k == row else 0.0 for k in range(6)]
        assert one.known.table[8::10] == [*one.shares(), *[0.0] * (len(one.known.table[8::10]) - 6)]


def test_a_part_of_all_phases_is_cut_about_its_own_middle(search: Callable[..., Search]) -> None:
    slack = arc.position_error(ANGLE, VELOCITY, LOOP)
    for low, high in ((LOW, HIGH), (0.5, 0.75)):
        motion = flown(7.0)
        first, middle = free_motion(low, *motion, LOOP), free_motion(0.5 * (low + high), *motion, LOOP)
        speed = arc_speed(*first, LOOP)
        one = search([meets(x=0.125), says(GREW, 0)], cuts=[[(-1.0, low, high)]], span=(low, high))
        one.run()
        assert one.cut_at == [(low, high, *first, speed, 0.125 - middle[0], 0.25 + slack, *motion)]
        assert one.seen[1]["radius"] == radius_at(7, low, high)
