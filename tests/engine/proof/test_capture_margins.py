"""Balls of states and what captures them, on their margins: rounding is added up, and nothing beyond it is captured."""

from math import nextafter, sqrt
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON, step_error
from hknob_cli.engine.follow import CYCLE_CONTINUUM, CYCLE_ON_EDGE, CYCLE_PROVEN, GREW, REST_PROVEN
from hknob_cli.engine.loop import Loop, interval, level_of, make_loop, push
from hknob_cli.engine.sets import ball
from hknob_cli.engine.sets.ball import Trial
from hknob_cli.engine.sets.room import Known, make_known

from .orbits import Orbit, orbits

SOFT = make_loop(0.3, 0.04, 0.5, 0.3, 1.0, 0.0, 0.0)
RESTS = make_loop(1.0, 1.0, 1.0, 1.5, 1.0, 0.0, 0.0)  # level -1 rests at -0.5, to 24 units of rounding
ORBITS = [*orbits(1, 6), *orbits(2, 3, delay=1), *orbits(3, 3, delay=3)]


def zeros(count: int) -> list[float]:
    return [0.0] * count


def room(delay: int = 0) -> Known:
    return make_known(zeros, delay)


def follow(loop: Loop, x: float, v: float, samples: int, **more: Any) -> tuple:
    ring, head = more.get("ring", []), more.get("head", 0)
    small, limit = more.get("small", False), more.get("limit", 1e6)
    error, level, ends = more.get("error", 0.0), more.get("level", level_of(x, loop.sense)), more.get("ends")
    start = Trial(x, v, error, level, more.get("run", 0), more.get("next_test", 8), head)
    known_ends = ends or room(len(ring))
    given = ring, samples, limit, small, known_ends, loop
    event, row, end, used = ball.follow_ball(start, more.get("radius", 0.0), *given)
    return event, row, *end, used


# A ball.


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_the_error_of_the_centre_is_the_sum_of_all_roundings(delay: int) -> None:
    """Those of every sample, velocities weighed by the norm; the delay line goes along."""
    loop = SOFT if delay == 0 else make_loop(0.3, 0.04, 0.5, 0.3, 1.0, 0.0, 0.4)
    ring, line = [-1.0, 0.0, -2.0][:delay], [-1.0, 0.0, -2.0][:delay]
    head = at = delay - 1 if delay else 0
    x, v, error = 3.0, -0.7, 1e-12
    event, row, *found, used = follow(loop, x, v, 9, error=error, ring=ring, head=head)
    for _ in range(9):
        older, newer = push(level_of(x, 1.0), line, at, loop)
        error += step_error(x, v, older, newer, 5.0, loop)
        x, v = interval(x, v, older, newer, loop)
        at = (at + 1) % delay if delay else 0
    assert (event, row, used) == (ball.OUT_OF_SAMPLES, -1, 9)
    assert found[:3] == [x, v, pytest.approx(error, rel=1e-9, abs=0.0)]
    assert (found[6], ring) == (at, line)
    older, newer = push(-1.0, line, at, loop)
    expected = *interval(x, v, older, newer, loop), error + step_error(x, v, older, newer, 5.0, loop)
    *stepped, to = ball.step_through(x, v, error, -1.0, ring, at, loop)
    assert stepped == pytest.approx(expected, rel=1e-9, abs=0.0)
    assert (to, ring) == ((at + 1) % delay if delay else 0, line)


def test_a_ball_at_the_limit_has_grown() -> None:
    for x in (100.0, -100.0):
        assert follow(SOFT, x, 0.0, 1, limit=100.0)[0] == ball.GREW
        assert follow(SOFT, nextafter(x, 0.0), 0.0, 1, limit=100.0)[0] == ball.OUT_OF_SAMPLES


def test_a_small_ball_stops_at_the_next_sample_that_is_deeper_not_at_its_first() -> None:
    """Else it would never go on."""
    event, *_, used = follow(SOFT, 0.1, -0.4, 5, small=True)
    assert (event, used) == (ball.STEPS_DEEPER, 1)
    event, *_, used = follow(SOFT, -0.5, 0.3, 5, small=True, level=0.0)
    assert (event, used) == (ball.OUT_OF_SAMPLES, 5)


def test_rest_is_thought_of_after_8_16_and_32_samples_in_one_level() -> None:
    ends = room()
    event, row, *_, run, next_test, _, used = follow(RESTS, -0.5, 0.0, 50, radius=0.1, ends=ends)
    assert (event, row, run, next_test, used) == (ball.CAPTURED, 0, 8, 16, 7)
    for samples, run, next_test in ((7, 7, 8), (8, 8, 16), (15, 15, 16), (16, 16, 32)):
        found = follow(SOFT, 50.0, 60.0, samples)  # far from its level's rest point
        assert found[0] == ball.OUT_OF_SAMPLES
        assert found[6:8] == (run, next_test)
    assert follow(SOFT, 50.0, 60.0, 3, level=-1.0, run=5, next_test=32)[6:8] == (2, 8)


def test_a_ball_that_an_orbit_captures_says_which() -> None:
    """Where the wall steps deeper, before anything is done there."""
    for one in ORBITS[:3]:
        ends = room()
        for row in range(2):
            given = {"radius": 0.5 * ends.table[4], "ends": ends, "level": 0.0}
            event, found, *_ = follow(one.loop, one.x, one.v, 3 * one.n, **given)
            assert (event == ball.CAPTURED and found == 0) == (row == 1)
            enter(one, ends)


# What captures it.


def planted(margin: float, bound: float, *points: tuple[int, float, float], rows: int = 1) -> Known:
    """Room with proven orbits of this margin; the second half as much."""
    ends = room()
    for row in range(rows):
        ends.table[10 * row + 4], ends.table[10 * row + 7] = margin / (row + 1), bound / (row + 1)
    for k, point in enumerate(sorted(points, key=lambda point: point[1])):
        ends.points[3 * k : 3 * k + 3] = point
        row = 10 * int(point[0])
        ends.margins[k] = ends.table[row + 4] - ends.table[row + 7]
    ends.counts[0], ends.counts[1] = rows, len(points)
    ends.counts[2] = max(ends.margins[: len(points)], default=0.0)
    return ends


def test_a_ball_is_captured_below_the_margin_less_its_error() -> None:
    """3/8, at and beside the orbit's own sample."""
    one = make_loop(1.0, 4.0, 1.0, 1.0, 1.0, 0.0, 0.0)
    ends = planted(0.5, 0.125, (0, -0.25, 0.5))
    assert ball.captor(-0.25, 0.5, nextafter(0.375, 0.0), [], 0, ends, one) == 0
    assert ball.captor(-0.25, 0.5, 0.375, [], 0, ends, one) == -1
    apart = 0.25 * (1.0 + 2.0 * EPSILON)  # as `distance` rounds it
    assert ball.captor(-0.25, 1.0, 0.375 - apart, [], 0, ends, one) == -1
    assert ball.captor(-0.25, 1.0, 0.375 - apart - EPSILON, [], 0, ends, one) == 0
    far = planted(0.5, 0.125, (0, -4.25, 0.5))  # where the room that is left is below the last digit
    assert ball.captor(-4.25, 0.5, nextafter(0.375, 0.0), [], 0, far, one) == 0
    for side in (-1.0, 1.0):
        assert ball.captor(-0.25 + side * 0.25, 0.5, 0.124, [], 0, ends, one) == 0
        assert ball.captor(-0.25 + side * 0.25, 0.5, 0.126, [], 0, ends, one) == -1
        assert ball.captor(-0.25, 0.5 + side * 0.5, 0.124, [], 0, ends, one) == 0
        assert ball.captor(-0.25, 0.5 + side * 0.5, 0.126, [], 0, ends, one) == -1
        assert ball.captor(-0.25 + side * 0.15, 0.5 + side * 0.4, 0.124, [], 0, ends, one) == 0  # 3, 4, 5
        assert ball.captor(-0.25 + side * 0.15, 0.5 + side * 0.4, 0.126, [], 0, ends, one) == -1


def test_each_orbit_captures_by_its_own_margin() -> None:
    ends = planted(0.5, 0.125, (0, -0.25, 0.5), (1, -5.25, 0.5), (1, -7.25, 0.5), rows=2)
    for x in (-5.25, -7.25):
        assert ball.captor(x, 0.5, 0.187, [], 0, ends, SOFT) == 1
        assert ball.captor(x, 0.5, 0.188, [], 0, ends, SOFT) == -1


@pytest.mark.parametrize("margins", [(0.375, 0.125), (0.125, 0.375)])
def test_an_orbit_captures_by_its_own_margin_whichever_was_entered_last(margins: tuple[float, float]) -> None:
    """A smaller margin after a larger one hides nothing, nor the other way round."""
    ends = room()
    for row, margin in enumerate(margins):
        ends.table[10 * row + 4] = margin
        ball.add_point(row, -0.25 - 5.0 * row, 0.5, [], 0, ends)
    for row, margin in enumerate(margins):
        assert ball.captor(-0.25 - 5.0 * row, 0.5, margin - 1e-6, [], 0, ends, SOFT) == row
        assert ball.captor(-0.25 - 5.0 * row, 0.5, margin + 1e-6, [], 0, ends, SOFT) == -1


def test_a_rest_point_captures_below_its_margin_less_all_roundings() -> None:
    """Half a count less 24 units; what is added up is rounded, too."""
    unit = EPSILON
    for x, v, reach in ((-0.5, 0.0, 0.5), (-0.25, 0.0, 0.25), (-0.75, 0.0, 0.25), (-0.5, 0.25, 0.25), (-0.2, 0.4, 0.0)):
        ends = room()
        assert ball.resting(x, v, reach - 24.0 * unit, -1.0, [], 0, ends, RESTS) == -1
        if reach > 0.0:
            assert ball.resting(x, v, reach - 26.0 * unit, -1.0, [], 0, ends, RESTS) == 0
            assert ends.table[:4] == [REST_PROVEN, 1, -0.5, 0.0]
    assert ball.resting(-0.5, 0.0, 0.5 - 25.0 * unit, -1.0, [], 0, room(), RESTS) == 0
    ringing = make_loop(0.0, 1.0, 1.0, 1.5, 1.0, 0.0, 0.0)
    assert ball.resting(-0.4, 0.0, 0.0, -1.0, [], 0, room(), ringing) == -1  # swings for ever


def test_an_other_command_under_way_may_drive_it_out() -> None:
    for line, row in (([-1.0, -1.0], 0), ([0.0, -1.0], -1), ([-1.0, 0.0], -1)):
        assert ball.resting(-0.5, 0.0, 0.0, -1.0, line, 0, room(2), RESTS) == row


# What is entered.


@pytest.mark.parametrize("one", ORBITS, ids=lambda one: f"{one.n} samples, {len(one.ring)} under way")
def test_the_samples_at_which_the_wall_steps_deeper_are_entered(one: Orbit) -> None:
    """Each of a period once, with what is under way."""
    delay, ends = len(one.ring), room(len(one.ring))
    ball.add_points(5, one.x, one.v, list(one.ring), one.head, one.n, ends, one.loop)
    x, v, line, at, before, expected = one.x, one.v, list(one.ring), one.head, 1.0, []
    for i in range(2 * one.n):
        level = level_of(x, one.loop.sense)
        if i >= one.n and level < before:
            expected.append((5, x, v, [line[(at + k) % delay] for k in range(delay)]))
        before = level
        older, newer = push(level, line, at, one.loop)
        x, v = interval(x, v, older, newer, one.loop)
        at = (at + 1) % delay if delay else 0
    expected = expected[: ball.POINTS_OF_ORBIT]
    assert expected
    assert ends.counts[1] == len(expected)
    for k, (row, x, v, line) in enumerate(sorted(expected, key=lambda one: one[1])):
        assert ends.points[3 * k : 3 * k + 3] == [row, x, v]
        assert ends.point_lines[k * delay : (k + 1) * delay] == line


def test_no_more_samples_are_entered_than_there_is_room_for() -> None:
    """64 of an orbit, and no more than the list holds."""
    ends = room()
    long = make_loop(0.05, 0.01, 0.5, 0.3, 1.0, 0.0, 0.0)
    for times in (1, 2):
        ball.add_points(0, 2.0, 0.0, [], 0, 3000, ends, long)
        assert ends.counts[1] == 64 * times
    for size in (3, 5, 6):
        short = ends._replace(points=zeros(size), counts=[0.0, 0.0, 0.0])
        ball.add_points(0, 2.0, 0.0, [], 0, 3000, short, long)
        assert short.counts[1] == size // 3


def enter(one: Orbit, ends: Known, fate: int = CYCLE_PROVEN, n: int | None = None, off: float = 0.0) -> int:
    given = fate, one.n if n is None else n, one.x + off, one.v, list(one.ring), one.head
    return ball.add_end(*given, ends, one.loop)


@pytest.mark.parametrize("one", ORBITS[:8], ids=lambda one: f"{one.n} samples, {len(one.ring)} under way")
def test_a_proven_end_is_entered_as_it_is_proven(one: Orbit) -> None:
    """Its state is the certificate's, however far from it the trial was; where nothing is proven, the trial's own."""
    from hknob_cli.engine.certificate import certify
    from hknob_cli.engine.ensemble import deepest

    ends, off = room(len(one.ring)), 1e-12
    assert enter(one, ends, off=off) == 0
    ring = list(one.ring)
    x, v, head, n = deepest(one.x + off, one.v, ring, one.head, one.n, one.loop)
    _, px, pv, *margins = certify(x, v, ring, head, n, one.loop)
    assert (n, px != x) == (one.n, True)
    assert ends.table[:10] == [CYCLE_PROVEN, n, px, pv, *margins, 0.0, 0.0]
    assert ends.lines[: len(ring)] == [ring[(head + k) % len(ring)] for k in range(len(ring))]
    assert ends.counts[0] == 1.0
    assert ends.counts[1] > 0.0
    left, points = ends.table[4] - ends.table[7], int(ends.counts[1])
    assert (ends.margins[:points], ends.counts[2]) == ([left] * points, left)
    assert enter(one, ends) == 0  # known already
    entered = ends.counts[1]
    for row, fate in enumerate((CYCLE_ON_EDGE, CYCLE_CONTINUUM), 1):
        assert enter(one, ends, fate, off=off) == row
        assert ends.table[10 * row : 10 * row + 10] == [fate, n, x, v, *margins, 0.0, 0.0]
    assert ends.counts[1] == entered  # nothing is captured by what is not proven


def test_an_end_without_an_orbit_has_no_margins() -> None:
    ends = room()
    assert ball.add_end(GREW, 0, 1e7, 3.0, [], 0, ends, SOFT) == 0
    assert ends.table[:10] == [GREW, 0, 1e7, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert ball.add_end(REST_PROVEN, 1, -0.5, 0.0, [], 0, ends, RESTS) == 1
    assert ends.table[10:20] == [REST_PROVEN, 1, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert ends.counts == [2.0, 0.0, 0.0]


def test_a_full_table_says_so() -> None:
    for size, rows in ((29, [0, 1, -1, -1]), (30, [0, 1, 2, -1])):
        ends = room()._replace(table=zeros(size))
        assert [ball.add_end(REST_PROVEN, 1, -0.1 * k, 0.0, [], 0, ends, RESTS) for k in range(4)] == rows
        assert ends.counts[0] == max(rows) + 1.0


def test_a_shorter_period_that_is_not_proven_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two turns may agree to the digits by which orbits are told apart, and differ."""
    one = next(one for one in ORBITS if one.n % 2 == 0 and not one.ring)
    shorter: list[int] = []

    def halved(*given: Any) -> tuple[float, float, int, int]:
        return given[0], given[1], given[3], shorter[0]

    monkeypatch.setattr(ball, "deepest", halved)
    for n, turns, entered in ((one.n // 2, one.n, one.n), (one.n, one.n, one.n), (one.n, 2 * one.n, one.n)):
        ends, shorter[:] = room(), [n]
        assert enter(one, ends, n=turns) == 0
        assert ends.table[1] == entered
        assert 0.0 < ends.table[7] < ends.table[4]
        shorter[:] = [one.n // 2]
        assert enter(one, ends, n=one.n) == 0  # known already, at its full length
        assert ends.counts[0] == 1.0


def test_the_margin_of_states_is_kept_through_a_period() -> None:
    """The heart of it: what is captured has the orbit's levels for three periods, however it lies."""
    for one in ORBITS[:5]:
        ends = room()
        enter(one, ends)
        x, v = ends.points[1], ends.points[2]
        for k in range(8):
            apart = ((k % 3) - 1.0) * 0.7 * ends.table[4], (k // 3 - 1.0) * 0.7 * ends.table[4] * sqrt(one.loop.beta)
            if ball.captor(x + apart[0], v + apart[1], 0.0, [], 0, ends, one.loop) < 0:
                continue
            a, b = (x, v), (x + apart[0], v + apart[1])
            for _ in range(3 * one.n):
                levels = level_of(a[0], one.loop.sense), level_of(b[0], one.loop.sense)
                assert levels[0] == levels[1]
                a, b = (interval(*s, *push(levels[0], [], 0, one.loop), one.loop) for s in (a, b))
