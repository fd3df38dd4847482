"""A set over a hold with friction, by hand: a plant whose coefficients are dyadic, so that each number is exact.

Over a time t a speed of 1 goes t far and falls to 1 - t, and a torque of 1 goes t^2 / 2 far. A stop is where that
says so; what it leaves of a difference is put together from its parts, as the file's head has them.
"""

from itertools import permutations, product
from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets import friction_step
from hknob_cli.engine.general.sets.friction_step import (
    CUT,
    ENCLOSED,
    GROWN,
    HELD,
    MOST_PARTS,
    NARROW,
    NARROW_SMOOTH,
    SLID,
    Hold,
    Room,
    Shape,
    ask_for_cut,
    excess,
    map_corners,
    middle_of,
    move_set,
    parts_of_hold,
    slide_corners,
    take_in,
    take_in_hold,
    take_in_side,
    take_in_slide,
    take_in_turn,
)

from .friction_work import zeros

Matrix = tuple[tuple[float, float], tuple[float, float]]
State = tuple[float, float]
T, BETA, FRICTION = 0.5, 0.25, 1.0  # length of the hold; the spring; friction
S, G, F = 0.5, 0.125, 0.5
HOLD = Hold(T, S, G, F)
BODY: Any = SimpleNamespace(alpha=0.0, beta=BETA, friction=FRICTION, drive=0.0)
NONE = [inf, -inf] * 4


def plant(t: float, _body: Any = None) -> tuple[float, float, float]:
    return t, 0.5 * t * t, 1.0 - t


def first_zero(v: float, y: float, alpha: float, beta: float) -> float:
    """When v (1 - t) + y t vanishes."""
    assert v > 0.0
    assert (alpha, beta) == (0.0, BETA)
    return v / (v - y) if y < v else inf


@pytest.fixture(autouse=True)
def by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(friction_step, "coefficients", plant)
    monkeypatch.setattr(friction_step, "first_zero", first_zero)


def response(t: float, beta: float = BETA) -> Matrix:
    """Of a state to a difference of states, a time before."""
    s, g, f = plant(t)
    return (1.0 - beta * g, s), (-beta * s, f)


def hull(*matrices: Matrix) -> list[float]:
    """The intervals of entries that hold all of these."""
    return [end(m[i][j] for m in matrices) for i in (0, 1) for j in (0, 1) for end in (min, max)]


def slid() -> list[Matrix]:
    return [response(T)]


def stuck(first: float, last: float) -> list[Matrix]:
    """What stops keeps its place."""
    return [(response(t)[0], (0.0, 0.0)) for t in (first, last)]


def turned(first: float, last: float, *jumps: float, span: float = T) -> list[Matrix]:
    """Phi(T) - m Phi(tau) e2 e2' Phi(t): of all jumps m, and of all t, and tau, between the first and the last stop."""
    whole, found = response(span), []
    for m, t, tau in product(jumps, (first, last), (span - first, span - last)):
        entering, leaving = response(t)[1], (response(tau)[0][1], response(tau)[1][1])
        rows = [tuple(whole[i][j] - m * leaving[i] * entering[j] for j in (0, 1)) for i in (0, 1)]
        found.append((rows[0], rows[1]))
    return found  # type: ignore[return-value]


def jump(pull: float) -> float:
    """Part of the rate that the turn of a state changes: 2 friction over what friction and pull come to."""
    return 2.0 * FRICTION / (FRICTION - pull)


# How many parts.


def test_a_part_of_a_hold_turns_by_little_and_keeps_the_sign_of_a_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quarter of a radian; a speed may come to 0 in it."""
    for span, beta, parts in (
        (1.0, 0.0625, 1), (1.0, 0.0626, 2), (0.5, 0.25, 1), (1.0, 0.25, 2), (2.0, 0.0625, 2), (1.0, 1.0, 4),
        (1.0, 4096.0, 256), (1.0, 4097.0, 0), (1.0, 16384.0, 0), (1.0, 1e9, 0), (0.0625, 1e-9, 1),
    ):  # fmt: skip
        assert parts_of_hold(span, SimpleNamespace(beta=beta)) == parts
    assert MOST_PARTS == 256
    for least, parts in ((0.25, 4), (0.2499, 8), (1.0, 1), (0.5, 2), (2.0**-8, 256), (2.0**-9, 0)):

        def rings(t: float, body: Any, least: float = least) -> tuple[float, float, float]:
            return -1.0, -1.0, least - t

        monkeypatch.setattr(friction_step, "coefficients", rings)
        assert parts_of_hold(1.0, SimpleNamespace(beta=1e-9)) == parts


# Intervals of the derivative.


def test_an_interval_is_widened_by_another() -> None:
    for entry in range(4):
        jac = [1.0, 2.0] * 4
        for low, high, right in ((1.25, 1.5, [1.0, 2.0]), (0.5, 1.5, [0.5, 2.0]), (0.75, 3.0, [0.5, 3.0])):
            take_in(jac, entry, low, high)
            assert jac[2 * entry : 2 * entry + 2] == right
        assert jac[: 2 * entry] + jac[2 * entry + 2 :] == [1.0, 2.0] * 3


def test_what_slides_moves_by_the_free_response() -> None:
    for t, beta in ((0.5, 0.25), (0.25, 2.0)):
        jac = list(NONE)
        take_in_slide(Hold(9.0, *plant(t)), beta, jac)
        assert jac == hull(response(t, beta))


def test_what_is_held_keeps_its_place() -> None:
    for first, last in ((0.25, 0.25), (0.125, 0.375), (0.0, 0.5)):
        for beta in (0.25, 2.0):
            jac = list(NONE)
            sa, ga, _ = plant(first)
            sb, gb, _ = plant(last)
            take_in_hold(sa, ga, sb, gb, beta, jac)
            assert jac == hull(*((response(t, beta)[0], (0.0, 0.0)) for t in (first, last)))


def test_what_turns_round_moves_by_less_what_the_jump_takes() -> None:
    """No wider than jumps and times by themselves make each entry."""
    for span in (0.5, 0.75):
        for first, last in ((0.25, 0.25), (0.125, 0.375), (0.0, 0.5)):
            for small, large in ((0.5, 0.5), (0.25, 0.75), (0.0, 1.0)):
                jac = list(NONE)
                take_in_turn(Hold(span, *plant(span)), first, last, small, large, BODY, jac)
                assert jac == hull(*turned(first, last, small, large, span=span))


def test_corners_go_by_the_free_response() -> None:
    corners = [1.0, 0.5, -2.0, 4.0, 0.25, -8.0, 7.0, 7.0]
    slide_corners(corners, 3, 0.5, 0.125, 0.75, 0.25)
    (a, b), (c, d) = (1.0 - 0.25 * 0.125, 0.5), (-0.25 * 0.5, 0.75)
    states = ((1.0, 0.5), (-2.0, 4.0), (0.25, -8.0))
    assert corners == [value for x, v in states for value in (a * x + b * v, c * x + d * v)] + [7.0, 7.0]


JAC = [1.0, 1.5, -0.5, 0.25, 2.0, 4.0, -1.0, -0.25]  # of a derivative, row by row
MIDDLES = (1.25, -0.125, 3.0, -0.625)


def test_a_matrix_of_middles_moves_the_corners() -> None:
    assert middle_of(JAC) == MIDDLES
    a, b, c, d = MIDDLES
    corners = [1.0, 0.5, -2.0, 4.0, 0.25, -8.0, 7.0, 7.0]
    assert not map_corners(corners, 3, JAC)
    states = ((1.0, 0.5), (-2.0, 4.0), (0.25, -8.0))
    assert corners == [value for x, v in states for value in (a * x + b * v, c * x + d * v)] + [7.0, 7.0]


def test_all_are_held_where_no_speed_answers_anything() -> None:
    for wrong in range(8):
        for by in (1.0, -1.0, 0.5, 5e-324):
            jac = [1.0, 1.5, -0.5, 0.25, 0.0, 0.0, 0.0, 0.0]
            jac[wrong] += by
            assert map_corners([1.0, 1.0], 1, jac) == (wrong < 4)


@pytest.mark.parametrize("beta", [0.25, 4.0])
def test_an_enclosure_is_as_much_wider_as_the_intervals_are_wide(beta: float) -> None:
    """Half of each, by the extent; and the largest radius after it is of a corner, widened to both sides."""
    states = ((1.0, 0.5), (-2.0, 4.0), (0.25, -8.0), (-0.5, -0.5))
    a, b, c, d = MIDDLES
    more_x, more_v = 0.25 * 3.0 + 0.375 * 5.0, 1.0 * 3.0 + 0.375 * 5.0
    for count in range(1, 5):
        corners = [value for one in states for value in one]
        found = excess(JAC, 3.0, 5.0, corners, count, beta)
        moved = [(a * x + b * v, c * x + d * v) for x, v in states[:count]]
        grown = max(sqrt((abs(x) + more_x) ** 2 + (abs(v) + more_v) ** 2 / beta) for x, v in moved)
        assert found[:2] == (more_x, more_v)
        assert found[2] == pytest.approx(sqrt(more_x**2 + more_v**2 / beta), rel=1e-15)
        assert found[3] == pytest.approx(grown, rel=1e-15)
        assert corners == [value for one in states for value in one]
    small = [value / 1024.0 for one in states for value in one]
    assert excess(JAC, 3.0 / 1024.0, 5.0 / 1024.0, small, 4, beta) == pytest.approx([one / 1024.0 for one in found])


def test_a_cut_is_told_from_the_callers_centre() -> None:
    corners, line = [1.0, 0.5, -2.0, 4.0, 7.0, 7.0], [3.0, 5.0, 0.25]
    ask_for_cut(corners, 2, 0.5, -2.0, line)
    assert (corners, line) == ([1.5, -1.5, -1.5, 2.0, 7.0, 7.0], [3.0, 5.0, 0.25 + 1.5 - 10.0])


# Those that begin in one direction. A pull of y - friction acts on a state: (pv, y) says what it does.


def state(y: float, pv: float) -> State:
    """One whose speed is ``pv`` and grows at ``y``, under a torque of 3 and friction."""
    return (3.0 - FRICTION - y) / BETA, pv


def side(
    *states: State, slack: float = 0.0, free: float = 3.0, centre: State = (2.0, 0.5), sign: float = 1.0
) -> tuple[list[float], bool, float, list[float]]:
    """Intervals, whether smooth, spread and line of such a set: the same, mirrored, in the other direction."""
    found = []
    for way in (sign, -sign):
        jac, line = list(NONE), [9.0, 9.0, 9.0]
        at = (way * centre[0], way * centre[1])
        corners = [value for x, v in states for value in (way * x - at[0], way * v - at[1])]
        shape, room = Shape(*at, corners, len(states)), Room(jac, line, None, None)
        smooth, spread = take_in_side(way, shape, way * free, slack, HOLD, BODY, room)
        a, b, c = line
        found.append((jac, smooth, spread, [way * a, way * b, c] if line != [9.0, 9.0, 9.0] else line))
    assert found[0][:3] == found[1][:3]
    jac, smooth, spread, (a, b, c) = found[0]
    return jac, smooth, spread, [a, b, c]


def pull_of(one: State) -> float:
    return 3.0 - BETA * one[0]


@pytest.mark.parametrize("by", range(3))
def test_where_all_slide_the_motion_is_smooth(by: int) -> None:
    """Also those that stop as the hold ends, or stand where friction just holds them."""
    for states in (
        (state(1.0, 1.0), state(0.5, 2.0), state(-1.0, 4.0)),
        (state(1.0, 1.0), state(-1.0, 1.0), state(0.0, 0.0)),
        (state(-1.0, 1.0), state(-2.0, 2.0), state(-3.0, 3.0)),
        (state(1.0, 0.0), state(0.0, 0.0), state(0.0, 2.0)),
        (state(0.0, 0.0),),
    ):  # fmt: skip
        turned_round = states[by:] + states[:by]
        assert side(*turned_round) == (hull(*slid()), True, 0.0, [9.0, 9.0, 9.0])


def test_a_state_is_told_to_within_its_rounding() -> None:
    """One slower than that stands; one that stops that little before the end slides to it."""
    slack = 2.0**-6
    one = state(2.0, 1.0)
    for other, slides in (
        (state(2.0, -slack), True), (state(2.0, -slack - 2.0**-40), False),
        (state(-1.0 - 2.0 * slack, 1.0), True), (state(-1.0 - 2.001 * slack, 1.0), False),
        (state(-2.0 * slack, -slack), True), (state(-2.001 * slack, -slack), False),
    ):  # fmt: skip
        jac, smooth, spread, _ = side(one, other, slack=slack)
        assert (jac == hull(*slid()), smooth) == (slides, slides)
        assert (spread == 0.0) == slides


def held_at(*states: State) -> bool:
    return all(pull_of(one) > -FRICTION for one in states)


def test_what_stops_and_is_held() -> None:
    """From the first stop to the last: after 1/4, 1/8, 3/8 and at once."""
    quarter, eighth, three, none = state(-1.5, 0.5), state(-1.75, 0.25), state(-1.25, 0.75), state(-1.5, 0.0)
    assert held_at(quarter, eighth, three, none)
    for states, first, last in (
        ((quarter,), 0.25, 0.25), ((eighth, quarter), 0.125, 0.25), ((quarter, eighth), 0.125, 0.25),
        ((quarter, three), 0.25, 0.375), ((three, quarter, eighth), 0.125, 0.375), ((none,), 0.0, 0.0),
        ((quarter, none), 0.0, 0.25), ((none, three), 0.0, 0.375),
    ):  # fmt: skip
        jac, smooth, spread, line = side(*states)
        assert (jac, smooth) == (hull(*stuck(first, last)), True)
        assert spread == last - first
        check_line(line, 0.5 * (first + last))


def check_line(line: list[float], at: float, centre: State = (2.0, 0.5), free: float = 3.0) -> None:
    """It is that of the states whose speed vanishes at a time: told from the centre, to both sides."""
    a, b, c = line
    assert (a, b) == (-BETA * at, 1.0 - at)
    for x, v in ((0.0, 0.0), (1.0, 2.0), (-3.0, 0.5)):
        dx, dv = x - centre[0], v - centre[1]
        speed = (1.0 - at) * v + at * (free - FRICTION - BETA * x)
        assert a * dx + b * dv - c == pytest.approx(speed, abs=1e-15)


def test_what_stops_and_turns_round() -> None:
    """The pull where it stops is that at its place, and how much farther it may have come."""
    quarter, eighth = state(-3.0, 1.0), state(-7.0, 1.0)  # pulls of -2 and -6, a quarter and an eighth on the way
    for states, first, last, least, most in (
        ((quarter,), 0.25, 0.25, -2.0 - BETA * 0.25, -2.0),
        ((eighth, quarter), 0.125, 0.25, -6.0 - BETA * 0.25, -2.0),
        ((quarter, eighth), 0.125, 0.25, -6.0 - BETA * 0.25, -2.0),
        ((quarter, state(-3.0, 0.0)), 0.0, 0.25, -2.0 - BETA * 0.25, -2.0),
        ((state(-9.0, 3.0), quarter), 0.25, 0.25, -8.0 - BETA * 0.25 * 3.0, -2.0),
    ):  # fmt: skip
        jac, smooth, spread, line = side(*states)
        assert jac == pytest.approx(hull(*turned(first, last, jump(least), jump(most))), rel=1e-15)
        assert smooth
        times, jumps = (last - first) * jump(most), (jump(most) - jump(least)) * T
        assert spread == pytest.approx(max(times, jumps), rel=1e-15)
        if times >= jumps:
            check_line(line, 0.5 * (first + last))
        else:
            assert line == [1.0, 0.0, 0.0]  # half its width


@pytest.mark.parametrize("friction", [0.5, 2.0])
def test_a_jump_is_by_friction(friction: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pull of -6 where they stop; and of a little more, where the fastest may come."""
    monkeypatch.setattr(BODY, "friction", friction)
    one = ((3.0 + 6.0) / BETA, 1.0)  # its rate is -6 less friction
    stop = 1.0 / (1.0 + 6.0 + friction)
    jumps = [2.0 * friction / (friction - pull) for pull in (-6.0 - BETA * stop, -6.0)]
    assert side(one)[0] == pytest.approx(hull(*turned(stop, stop, *jumps)), rel=1e-14)


def test_a_stop_that_rounding_puts_behind_the_end_is_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(friction_step, "first_zero", lambda *given: inf)
    assert side(state(-1.5, 0.5))[0] == hull(*stuck(T, T))


def test_what_may_be_held_or_turn_round() -> None:
    """Where friction just holds one, the jump of its rate is all of it."""
    held, turns = state(-1.5, 0.5), state(-3.0, 1.0)
    jac, smooth, spread, _ = side(held, turns)
    least = -2.0 - BETA * 0.25
    assert jac == pytest.approx(hull(*turned(0.25, 0.25, jump(least), 1.0), *stuck(0.25, 0.25)), rel=1e-15)
    assert smooth
    assert spread == pytest.approx((1.0 - jump(least) + BETA) * T, rel=1e-15)
    # A pull of exactly friction on the way: both, where it comes no farther; and of less nothing turns round.
    edge = state(-2.0, 0.0)
    jac, _, spread, _ = side(edge)
    assert (jac, spread) == (hull(*stuck(0.0, 0.0)), 0.0)
    jac, _, spread, _ = side(edge, state(-3.0, 0.0))
    assert jac == hull(*turned(0.0, 0.0, jump(-2.0), 1.0), *stuck(0.0, 0.0))
    assert spread == (1.0 - jump(-2.0) + BETA) * T
    assert side(state(-2.0 - 2.0**-40, 0.0))[0] == pytest.approx(hull(*turned(0.0, 0.0, 1.0)), abs=1e-11)
    least = -1.0 - BETA * 0.25 * (2.0 / 3.0)  # at -friction it moves on
    found = side(state(-2.0, 2.0 / 3.0))[0]
    assert found == pytest.approx(hull(*turned(0.25, 0.25, jump(least), 1.0), *stuck(0.25, 0.25)), rel=1e-14)


def test_some_slide_while_others_stop() -> None:
    """Then there are stops at any time until the hold ends, and the cut is at those that stop as it ends."""
    stops, slides, ends = state(-1.5, 0.5), state(1.0, 1.0), state(-1.0, 1.0)
    jac, smooth, spread, line = side(stops, slides)
    assert (jac, smooth) == (hull(*slid(), *stuck(0.25, T)), False)
    assert spread == T - 0.25
    check_line(line, T)
    # One that stops as the hold ends does not slide.
    jac, smooth, spread, line = side(stops, ends)
    assert (jac, smooth, spread) == (hull(*stuck(0.25, T)), True, T - 0.25)
    check_line(line, 0.5 * (T + 0.25))
    # One that stands where friction just holds it is one of all times.
    for first in (state(0.0, 0.0), state(2.0**-8, -(2.0**-8))):
        jac, smooth, _, _ = side(first, stops, slack=2.0**-6)
        assert (jac, smooth) == (hull(*stuck(0.25, 0.25)), True)
    for more, smooth in ((0.0, True), (2.0**-4, False), (2.0**-6, True)):
        one = state(more - 1.0, 1.0)
        jac, found, _, _ = side(one, stops, slack=2.0**-6)
        assert (jac[1:4], found) == (hull(*stuck(0.25, T), *([] if smooth else slid()))[1:4], smooth)
        jac, found, _, _ = side(stops, one, slack=2.0**-6)
        assert (jac[1:4], found) == (hull(*stuck(0.25, T), *([] if smooth else slid()))[1:4], smooth)
    for pv, late in ((2.0**-6, False), (2.0**-5, True)):
        jac, _, _, _ = side(state(-pv, pv), stops, slack=2.0**-6)
        assert jac[3] == (T if late else 0.25)
    late = side(state(1.0, 2.0**-7), stops, slack=2.0**-6)
    assert late[0][3] == T
    # Whichever comes after it.
    assert side(state(-1.0, 1.0), state(0.0, 0.0), stops)[0] == hull(*stuck(0.25, T))
    for order in permutations((slides, ends, stops)):
        assert side(*order)[:2] == (hull(*slid(), *stuck(0.25, T)), False)
    # Where a jump is what is left of the hold the cut is at the end of the hold, too.
    jac, smooth, spread, line = side(state(-99.0, 1.0), slides)
    assert not smooth
    check_line(line, T)


def test_a_set_through_a_speed_of_0_has_stops_at_once() -> None:
    """States that stand belong to both directions; it is cut there. Those that leave it slide."""
    stops, back = state(-1.5, 0.5), state(-1.5, -0.5)
    jac, smooth, spread, line = side(stops, back)
    assert (jac, smooth, spread) == (hull(*stuck(0.0, 0.25)), True, 0.25)
    check_line(line, 0.0)
    for other, slides in ((state(0.0, -0.5), True), (state(nextafter(0.0, -1.0) - 1e-15, -0.5), False)):
        jac, smooth, spread, line = side(stops, other)
        assert jac == pytest.approx(hull(*stuck(0.0, T if slides else 0.25), *(slid() if slides else [])), abs=1e-14)
        assert (smooth, spread) == (not slides, T if slides else 0.25)
        check_line(line, 0.0)
    # Those that come from the other side turn round where friction does not hold them: not smooth.
    jac, smooth, _, line = side(state(-3.0, 1.0), state(-3.0, -1.0))
    least = -2.0 - BETA * 0.25
    assert (jac, smooth) == (pytest.approx(hull(*turned(0.0, 0.25, jump(least), jump(-2.0))), rel=1e-15), False)
    check_line(line, 0.0)
    jac, smooth, _, _ = side(state(-2.0, 0.0), state(-2.0, -1.0))
    assert (jac, smooth) == (hull(*stuck(0.0, 0.0)), True)
    jac, smooth, spread, line = side(state(-1.0, 1.0), back)  # one that stops as the hold ends
    assert (jac, smooth, spread) == (hull(*stuck(0.0, T)), True, T)
    for order in permutations((state(1.0, -0.5), stops, back)):
        assert side(*order)[:2] == (hull(*stuck(0.0, T), *slid()), False)
    fast = state(-0.5, 4.0)  # slides all along, though its speed falls
    assert side(fast, back)[:2] == (hull(*stuck(0.0, T), *slid()), False)
    _, _, spread, line = side(state(-15.0, 1.0), state(-2.5, -1.0))  # jumps differ by more than times
    assert spread > jump(-1.5) * T / 8.0
    check_line(line, 0.0)
    # Only such as come from there.
    jac, smooth, spread, _ = side(back)
    assert (jac, smooth, spread) == (hull(*stuck(0.0, 0.0)), True, 0.0)
    jac, smooth, _, line = side(state(2.0, 1.0), state(-1.5, -0.5))
    assert (jac, smooth) == (hull(*stuck(0.0, T), *slid()), False)
    check_line(line, 0.0)


# A set over a hold.


class Sides:
    """Stands for what a side tells: ``(smooth, spread)`` by direction, an interval each, and a line."""

    def __init__(self, patch: pytest.MonkeyPatch, up: Any = (True, 0.25), down: Any = (True, 0.5)) -> None:
        self.told = {1.0: up, -1.0: down}
        self.asked: list[tuple[Any, ...]] = []
        self.excess = (0.0, 0.0, 0.0, 0.0)
        self.moved: list[tuple[Any, ...]] = []
        self.to = (5.0, 0.25)
        self.seen: list[Any] = []
        patch.setattr(friction_step, "take_in_side", self.take)
        patch.setattr(friction_step, "excess", self.excess_of)
        patch.setattr(friction_step, "step_with_friction", self.step)

    def take(self, sign: float, shape: Shape, free: float, slack: float, hold: Hold, _body: Any, room: Room) -> Any:
        x, v, corners, count = shape
        jac, line, _, _ = room
        self.asked.append((sign, x, v, free, *hold, slack, list(corners[: 2 * count]), count))
        take_in(jac, 0, 0.5, 0.5)
        take_in(jac, 1, sign, sign)
        take_in(jac, 2, 0.0, 0.0)
        take_in(jac, 3, 0.25, 0.25)
        line[:] = [sign, 2.0 * sign, 4.0]
        return self.told[sign]

    def excess_of(self, jac: Any, high_x: float, high_v: float, corners: Any, count: int, beta: float) -> Any:
        self.seen.append((list(jac[:8]), high_x, high_v, list(corners[: 2 * count]), beta))
        return self.excess

    def step(self, *given: Any) -> State:
        self.moved.append(given)
        return self.to


def moved(
    x: float, v: float, u: float, corners: list[float], *, body: Any = BODY, least: float = 0.0
) -> tuple[tuple[int, float, float, int], list[float], list[float]]:
    """Move a set by ``(S, G, F)``: what is returned, its corners, and the line."""
    work, line = [*corners, *zeros(200)], [7.0, 7.0, 7.0]
    shape, room = Shape(x, v, work, len(corners) // 2), Room(zeros(200), line, None, None)
    fate, to_x, to_v, count = move_set(shape, u, HOLD, least, body, room)
    return (fate, to_x, to_v, count), work[: 2 * count], line


SQUARE = [-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5]
TURNED = SQUARE[4:] + SQUARE[:4]
SHIFTED = [value + by for value, by in zip(SQUARE, [0.5, -0.125] * 4, strict=True)]
FREE: Any = SimpleNamespace(**{**vars(BODY), "friction": 0.0})


def test_what_slides_one_way_moves_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under the torque less friction; which is more in the other direction."""
    one = Sides(monkeypatch)
    body = SimpleNamespace(**{**vars(BODY), "drive": 0.5})
    expected = list(SQUARE)
    slide_corners(expected, 4, S, G, F, BETA)
    for x, v, u in ((1.0, 8.0, 0.25), (-1.0, -8.0, 0.25), (9.0, -8.0, -2.0)):
        y = u + 0.5 - (1.0 if v > 0.0 else -1.0) - BETA * x
        found, corners, _ = moved(x, v, u, SQUARE, body=body)
        assert found == (SLID, x + S * v + G * y, F * v + S * y, 4)
        assert corners == expected
    assert one.asked == []
    # Without friction whatever it does.
    for v in (0.0, 0.25):
        y = 0.25 - BETA
        assert moved(1.0, v, 0.25, SQUARE, body=FREE)[0] == (SLID, 1.0 + S * v + G * y, F * v + S * y, 4)


def fate(x: float, v: float, u: float, corners: list[float], body: Any = BODY) -> int:
    return moved(x, v, u, corners, body=body)[0][0]


UNIT = 32.0 * EPSILON


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_set_slides_to_within_the_roundings_of_its_terms(way: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """32 units of velocity, of the torque that acts, of friction, and of the spring's; for each corner."""
    Sides(monkeypatch)
    unit = UNIT
    for x, v, u, drive, friction in (
        (0.0, 0.0, 4.0, 0.0, 1.0), (0.0, 0.0, 8.0, -4.0, 1.0), (-32.0, 0.0, 4.0, 0.0, 1.0), (32.0, 0.0, 16.0, 0.0, 1.0),
        (0.0, 0.0, 8.0, 0.0, 4.0), (0.0, 2.0, 4.0, 0.0, 1.0),
    ):  # fmt: skip
        slack = unit * (abs(v) + abs(u + drive) + friction + BETA * abs(x))
        body = SimpleNamespace(**{**vars(BODY), "drive": way * drive, "friction": friction})
        for corner in range(2):
            for speed, slides in ((-slack, True), (-slack - 2.0**-51, False), (0.0, True)):
                corners = zeros(4)
                corners[2 * corner + 1] = way * (speed - v)
                found = fate(way * x, way * v, way * u, corners, body)
                assert (found == SLID) == slides, (x, v, u, drive, friction)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_set_slides_as_long_as_none_of_it_stops(way: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A speed that pull and friction end as the hold does, to within its rounding."""
    Sides(monkeypatch)
    slack = UNIT * (1.0 + 1.0)
    for corner in range(2):
        for speed, slides in ((0.0, True), (-2.0 * slack, True), (-2.0 * slack - 2.0**-48, False), (-0.5, False)):
            # Half of a speed of 1 and of a pull that is friction's are no speed.
            corners = zeros(4)
            corners[2 * corner + 1] = way * speed
            assert (fate(0.0, way, 0.0, corners) == SLID) == slides
        for dx, slides in ((0.0, True), (-4.0, True), (4.0, False), (2.0**-40, False)):
            corners = zeros(4)
            corners[2 * corner] = way * dx
            assert (fate(0.0, way, 0.0, corners) == SLID) == slides


def test_what_stands_in_the_zone_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """And nothing changes; up to the very end of the zone. One that moves, or is beyond, is not."""
    one = Sides(monkeypatch)
    one.excess = (0.0, 0.0, 9.0, 9.0)
    for u, drive, low, high in ((0.0, 0.0, -4.0, 4.0), (0.5, 0.0, -2.0, 6.0), (0.5, 1.0, 2.0, 10.0)):
        body = SimpleNamespace(**{**vars(BODY), "drive": drive})
        middle = 0.5 * (low + high)
        for left, right, held in (
            (low, high, True), (low - 0.5, high - 1.0, False), (low + 1.0, high + 0.5, False), (middle, middle, True),
        ):  # fmt: skip
            corners = [left - middle, -0.25, right - middle, -0.25]
            found, after, _ = moved(middle, 0.25, u, corners, body=body)
            assert (found == (HELD, middle, 0.25, 2)) == held
            assert after == corners
        for dv in (2.0**-30, -(2.0**-30)):
            for corner in range(2):
                corners = [-1.0, 0.0, 1.0, 0.0]
                corners[2 * corner + 1] = dv
                assert fate(middle, 0.0, u, corners, body) != HELD


def test_both_sides_are_asked_where_a_set_has_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the middle of its box, with its slack; what stands is no side's."""
    for v, corners, ways in (
        (0.25, SQUARE, [1.0, -1.0]), (0.5, SQUARE, [1.0]), (-0.5, SQUARE, [-1.0]), (0.49, SQUARE, [1.0, -1.0]),
        (-0.49, SQUARE, [1.0, -1.0]), (0.0, [-9.0, 0.0, 9.0, 0.0], []),
    ):  # fmt: skip
        one = Sides(monkeypatch)
        body = SimpleNamespace(**{**vars(BODY), "drive": 0.5})
        shifted = [value + by for value, by in zip(corners, [0.5, -0.125] * 4, strict=False)]
        moved(1.0, v + 0.125, -0.25, shifted, body=body)
        assert [given[0] for given in one.asked] == ways
        slack = UNIT * (abs(v + 0.125) + 0.25 + 1.0 + 0.25)
        for given in one.asked:
            assert given[1:8] == (1.5, v, 0.25, T, S, G, F)
            assert given[8] == slack
            assert given[9:] == (corners, len(corners) // 2)
        jac, high_x, high_v, seen, beta = one.seen[0]
        assert (seen, high_x, high_v, beta) == (corners, corners[4] if ways else 9.0, 0.5 if ways else 0.0, BETA)
        assert jac[2:4] == ([min(ways), max(ways)] if ways else [S, S])


def test_what_stands_is_held_or_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing between is left out; it is cut where friction just holds it."""
    for u, edges in ((0.0, (-4.0, 4.0)), (0.5, (-2.0, 6.0))):
        for low, high, edge in (
            (-20.0, 1.0, edges[0]), (1.0, 20.0, edges[1]), (edges[0] - 1.0, edges[1] - 1.0, edges[0]),
        ):  # fmt: skip
            for v in (0.0, 0.25):
                one = Sides(monkeypatch)
                one.excess = (0.0, 0.0, NARROW * 1000.0, 0.0)
                found, _, line = moved(0.5 * (low + high), v, u, [low - 0.5 * (low + high), -v, 0.5 * (high - low), -v])
                assert one.asked == []
                assert one.seen[0][0] == hull(response(T), ((1.0, S), (0.0, F)))
                assert found[0] == CUT
                a, b, c = line
                assert (b, c / a) == (0.0, edge - 0.5 * (low + high))
    # At the end of the zone, on the left, the edge that cuts is the other.
    one = Sides(monkeypatch)
    one.excess = (0.0, 0.0, 99.0, 99.0)
    _, _, line = moved(0.0, 0.0, 0.0, [-4.0, 0.0, 8.0, 0.0])
    assert line == [1.0, 0.0, 4.0]


def test_the_line_is_of_the_side_that_is_not_smooth_or_spreads_more(monkeypatch: pytest.MonkeyPatch) -> None:
    for up, down, way in (
        ((True, 0.25), (True, 0.5), -1.0), ((True, 0.5), (True, 0.25), 1.0), ((True, 0.5), (True, 0.5), -1.0),
        ((False, 0.25), (True, 0.5), 1.0), ((True, 0.5), (False, 0.25), -1.0), ((False, 0.5), (False, 0.25), -1.0),
        ((False, 0.25), (False, 0.5), -1.0),
    ):  # fmt: skip
        one = Sides(monkeypatch, up, down)
        one.excess = (0.0, 0.0, 99.0, 99.0)
        found, corners, line = moved(1.0, 0.125, 0.0, SQUARE)
        assert found == (CUT, 1.0, 0.125, 4)
        assert (corners, line) == (SQUARE, [way, 2.0 * way, 4.0])
    # Told from the caller's centre.
    one = Sides(monkeypatch)
    one.excess = (0.0, 0.0, 99.0, 99.0)
    shifted = [value + by for value, by in zip(SQUARE, [0.5, -0.125] * 4, strict=True)]
    found, corners, line = moved(1.0, 0.125, 0.0, shifted)
    assert (found, corners, line) == ((CUT, 1.0, 0.125, 4), shifted, [-1.0, -2.0, 4.0 - 0.5 + 0.25])


def test_a_set_is_cut_unless_its_enclosure_is_narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """By its radius; wider where the motion is smooth, or where it has hardly grown; and none is too small to cut."""
    radius = sqrt(2.0)  # of the square: x to 1, and 1/2 of v over sqrt(1/4)
    for up, down, narrow in (
        ((True, 0.0), (True, 0.0), NARROW_SMOOTH), ((False, 0.0), (True, 0.0), NARROW),
        ((True, 0.0), (False, 0.0), NARROW), ((False, 0.0), (False, 0.0), NARROW),
    ):  # fmt: skip
        smooth = narrow == NARROW_SMOOTH
        for wider, grown, cut in (
            (narrow * radius, inf, False), (nextafter(narrow * radius, inf), inf, True),
            (inf, GROWN * radius, not smooth), (inf, nextafter(GROWN * radius, inf), True), (0.0, inf, False),
        ):  # fmt: skip
            for least, small in ((0.0, False), (radius, True), (nextafter(radius, 0.0), False), (inf, True)):
                one = Sides(monkeypatch, up, down)
                one.excess = (0.0, 0.0, wider, grown)
                assert (moved(1.0, 0.125, 0.0, SQUARE, least=least)[0][0] == CUT) == (cut and not small)
    assert (NARROW, NARROW_SMOOTH, GROWN) == (0.03, 0.1, 1.02)
    # What stands is not smooth.
    for wider, cut in ((NARROW * 8.0, False), (nextafter(NARROW * 8.0, inf), True)):
        one = Sides(monkeypatch)
        one.excess = (0.0, 0.0, wider, 0.0)
        assert (moved(0.0, 0.0, 0.0, [-8.0, 0.0, 8.0, 0.0])[0][0] == CUT) == cut


def test_an_enclosure_is_about_the_motion_of_its_centre(monkeypatch: pytest.MonkeyPatch) -> None:
    """Corners go by the middle of the derivative, and are widened to both sides by what that leaves."""
    for more_x, more_v in ((0.0, 0.0), (0.25, 0.0), (0.0, 0.125), (0.25, 0.125), (2.0, 0.0), (0.0, 2.0)):
        one = Sides(monkeypatch)
        one.excess = (more_x, more_v, 0.0, 0.0)
        found, corners, _ = moved(1.0, 0.25, 0.5, SHIFTED)
        assert found[:3] == (ENCLOSED, 5.0, 0.25)
        assert one.moved == [(1.5, 0.125, 0.5, T, S, G, F, BODY)]
        # x / 2 and v / 4: the sides' answers of x to v cancel in the middle.
        places = {abs(one) for one in corners[::2]}, {abs(one) for one in corners[1::2]}
        assert places == ({0.5 + more_x}, {0.125 + more_v})
        assert found[3] == 4
    # Where they leave nothing, each corner is where it was in order.
    one = Sides(monkeypatch)
    again = SHIFTED[4:] + SHIFTED[:4]
    assert moved(1.0, 0.25, 0.5, again)[1] == [(0.5 if k % 2 == 0 else 0.25) * value for k, value in enumerate(TURNED)]


def test_only_what_has_no_speed_at_all_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    for entry, to_v, held in ((0.0, 0.0, True), (0.25, 0.0, False), (0.0, 1e-300, False), (0.0, -1.0, False)):
        one = Sides(monkeypatch)
        one.to = (5.0, to_v)

        def take(sign: float, *given: Any, entry: float = entry) -> tuple[bool, float]:
            jac = given[-1].space
            for k, value in enumerate((0.5, 0.0, 0.0, entry)):
                take_in(jac, k, value, value)
            return True, 0.0

        monkeypatch.setattr(friction_step, "take_in_side", take)
        assert moved(1.0, 0.125, 0.0, SQUARE)[0][0] == (HELD if held else ENCLOSED)
