"""A set over a part of a hold under a torque that lags, by hand: as `test_friction_step_margins`, with one more number.

A torque that decays to half in the part gives three eighths of a speed, and a sixteenth of a way, for each that it is
off by at first.
"""

import random
from itertools import permutations, product
from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.sets import friction_step, lagged_step, lagged_stops
from hknob_cli.engine.general.sets.convex import widen
from hknob_cli.engine.general.sets.friction_step import (
    CUT,
    ENCLOSED,
    GROWN,
    HELD,
    NARROW,
    NARROW_SMOOTH,
    SLID,
    Room,
    Shape,
    slide_corners,
    take_in,
)
from hknob_cli.engine.general.sets.lagged_step import (
    COARSE,
    LATER,
    depth_at,
    move_lagged,
    slides_all_along,
)
from hknob_cli.engine.general.sets.lagged_stops import LaggedHold, take_in_any, take_in_stops

from .friction_work import zeros
from .test_friction_step_margins import (
    BETA,
    FRICTION,
    NONE,
    SQUARE,
    UNIT,
    F,
    G,
    Matrix,
    S,
    State,
    T,
    first_zero,
    hull,
    jump,
    plant,
    response,
    slid,
    stuck,
    turned,
)

LATE_X, LATE_V, LEFT = 0.0625, 0.375, 0.5
PART = [T, S, G, F, LATE_X, LATE_V, LEFT]
BODY: Any = SimpleNamespace(alpha=0.0, beta=BETA, friction=FRICTION, drive=0.0)
WHOLE: Any = SimpleNamespace(lag=4.0)
FREE: Any = SimpleNamespace(**{**vars(BODY), "friction": 0.0})


@pytest.fixture(autouse=True)
def by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (friction_step, lagged_stops):
        monkeypatch.setattr(module, "coefficients", plant)
        monkeypatch.setattr(module, "first_zero", first_zero)


def pushed(drive: float, friction: float = FRICTION) -> Any:
    return SimpleNamespace(**{**vars(BODY), "drive": drive, "friction": friction})


# How long a part is.


def test_a_part_is_as_long_as_its_place_allows_and_twice_the_last_at_most() -> None:
    """A place is a whole number of parts of its length."""
    for part, depth, found in (
        (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 5.0, 4.0), (3.0, 5.0, 4.0), (3.0, 1.0, 0.0), (0.5, 1.0, 1.0),
        (0.5, 2.0, 1.0), (0.5, 3.0, 2.0), (0.5, 7.0, 6.0), (0.25, 2.0, 2.0), (0.75, 2.0, 2.0), (1.75, 3.0, 2.0),
        (7.375, 3.0, 3.0), (7.625, 4.0, 3.0), (2.0**-20, 20.0, 20.0), (1.0 - 2.0**-20, 20.0, 20.0),
    ):  # fmt: skip
        assert depth_at(part, depth) == found


# Any motion at all.


def times(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    ends = [one * other for one, other in product(a, b)]
    return min(ends), max(ends)


@pytest.mark.parametrize("most", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("beta", [0.25, 0.0625])
def test_any_motion_is_a_first_stop_and_all_that_may_come_after_it(beta: float, most: float) -> None:
    """Row by row: what a slide to the stop makes of a difference, what the stop leaves, and what comes of that."""
    span, first, last = 0.5, 0.125, 0.375
    (sa, ga, fa), (sb, gb, _) = plant(first), plant(last)
    jac = list(NONE)
    take_in_any(plant(first), plant(last), most, span, beta, jac)
    way = beta * span * span
    then = (((1.0 - way, 1.0), (-way * span, span)), ((-beta * span, 0.0), (-way, 1.0)))
    x, v = ((1.0 - beta * gb, 1.0 - beta * ga), (sa, sb)), ((-most * beta * sb, 0.0), (0.0, most * fa))
    right: list[float] = []
    for i, j in product((0, 1), (0, 1)):
        # A difference in x stays at most what it was, at first; v answers it by at most that.
        at = (x[0][0], 1.0) if (i, j) == (1, 0) else x[j]
        place, speed = times(then[i][0], at), times(then[i][1], v[j])
        right += [place[0] + speed[0], place[1] + speed[1]]
    assert jac == pytest.approx(right, abs=1e-15)


def test_no_motion_with_any_number_of_stops_is_left_out() -> None:
    """Random stops, each of which leaves some of a difference in speed; damped and not."""
    chance = random.Random(1)
    for _ in range(400):
        span = chance.uniform(0.1, 1.0)
        beta, alpha = (chance.uniform(0.05, 0.25) / span) ** 2, chance.choice([0.0, 0.5, 3.0])
        steps = 400
        stops = sorted(chance.randrange(steps) for _ in range(chance.randrange(1, 6)))
        most = chance.random()
        jac = list(NONE)
        # The time of the first stop, to within a step.
        near = [max(0.0, (stops[0] - 1) * span / steps), min(span, (stops[0] + 1) * span / steps)]
        soon, late = (real(t, alpha, beta) for t in near)
        take_in_any(soon, late, most, span, beta, jac)
        for column, (dx, dv) in enumerate(((1.0, 0.0), (0.0, 1.0))):
            for k in range(steps):
                if k in stops:
                    dv *= most * chance.random() if k == stops[0] else chance.random()
                s, g, f = real(span / steps, alpha, beta)
                dx, dv = (1.0 - beta * g) * dx + s * dv, f * dv - beta * s * dx
            for row, value in enumerate((dx, dv)):
                low, high = jac[4 * row + 2 * column : 4 * row + 2 * column + 2]
                assert low - 1e-9 <= value <= high + 1e-9


def real(t: float, alpha: float, beta: float) -> tuple[float, float, float]:
    from hknob_cli.engine.propagator import hold_coefficients

    found = hold_coefficients(alpha, beta, t)
    return float(found[0]), float(found[1]), float(found[2])


# Whether a state slides to the end.


def test_a_state_slides_where_its_least_torque_would_let_it_or_where_it_ends_so() -> None:
    """While torque falls, by its end; while it rises, by the least of it all along. To within a rounding."""
    slack = 2.0**-6
    for sign in (1.0, -1.0):
        for pv, end, rises, slides in (
            (-slack, -slack, False, True), (nextafter(-slack, -1.0), 1.0, False, False), (1.0, -slack, False, True),
            (1.0, nextafter(-slack, -1.0), False, False), (-1.0, 1.0, True, False), (-slack, 9.0, False, True),
        ):  # fmt: skip
            assert slides_all_along(sign, (5.0, pv), -7.0, end, rises, PART, slack, BODY) == slides
        for drive, low_a, px, pv, slides in (
            # F pv + S (low_a + drive - friction - beta px) = -slack
            (0.0, 0.5, 2.0, 1.0 - 2.0 * slack, True), (0.0, 0.5, 2.0, 1.0 - 2.001 * slack, False),
            (0.25, 0.5, 2.0, 0.75 - 2.0 * slack, True), (0.25, 0.5, 2.0, 0.75 - 2.001 * slack, False),
            (0.0, 0.25, 2.0, 1.25 - 2.0 * slack, True), (0.0, 0.25, 2.0, 1.25 - 2.001 * slack, False),
            (0.0, 0.5, 4.0, 1.5 - 2.0 * slack, True), (0.0, 0.5, 4.0, 1.5 - 2.001 * slack, False),
        ):  # fmt: skip
            body = pushed(sign * drive)
            assert slides_all_along(sign, (px, pv), low_a, -9.0, True, PART, slack, body) == slides
            assert slides_all_along(sign, (px, pv), low_a, 0.0, False, PART, slack, body)
        uneven = [T, 0.25, G, 0.75, LATE_X, LATE_V, LEFT]
        for pv, slides in ((1.0, True), (0.999, False)):  # a quarter of -3
            assert slides_all_along(sign, (0.0, pv), -2.0, -9.0, True, uneven, 0.0, BODY) == slides


# Those that begin in one direction. The torque falls from 9/4 to 2, to 7/4 in the end; or it rises from 7/4 to 2.

FALLS, RISES = (2.25, 1.75), (1.75, 2.25)
CHANGE = 0.25


class Stops:
    """Intervals, whether smooth, spread, whether half the time tells more, and the line: the same, mirrored, both ways.

    A state is told by its rate under the least torque, and its speed.
    """

    def __init__(
        self, *states: State, torque: tuple[float, float] = FALLS, slack: float = 0.0, drive: float = 0.5,
        centre: State = (1.0, 0.5), part: list[float] = PART, friction: float = FRICTION,
    ) -> None:  # fmt: skip
        a, u = torque
        to_a, self.drive, self.centre = u + (a - u) * LEFT, drive, centre
        self.free, self.late = u + drive, part[5] * (a - u)
        self.low = min(a, to_a) + drive - friction
        found = []
        for way in (1.0, -1.0):
            jac, line = list(NONE), [9.0, 9.0, 9.0]
            x, v = way * centre[0], way * centre[1]
            corners = [value for y, pv in states for value in (way * (self.low - y) / BETA - x, way * pv - v)]
            shape, hold = Shape(x, v, corners, len(states)), LaggedHold(way * a, 0.0, way * u, part, True)
            body, room = pushed(way * drive, friction), Room(jac, line, None, None)
            smooth, spread, later = take_in_stops(way, shape, slack, hold, body, room)
            if line[1:] != [0.0, 0.0]:  # else it halves the set's width, in both
                line = [way * line[0], way * line[1], line[2]]
            lined = line[2] != 9.0
            found.append((jac, smooth, spread, later, line if lined else None))
        assert found[0] == found[1]
        self.jac, self.smooth, self.spread, self.later, self.line = found[0]

    def is_cut_at(self, at: float) -> bool:
        """Whether the line is that of the states whose speed vanishes about then: told from the centre."""
        assert self.line is not None
        a, b, c = self.line
        same = (a, b) == (-BETA * at, 1.0 - at)
        for x, v in ((0.0, 0.0), (1.0, 2.0), (-3.0, 0.5)):
            dx, dv = x - self.centre[0], v - self.centre[1]
            speed = (1.0 - at) * v + at * (self.free - FRICTION - BETA * x) + self.late * at / T
            same = same and a * dx + b * dv - c == pytest.approx(speed, abs=1e-14)
        return same


def near(matrices: list[Matrix]) -> Any:
    return pytest.approx(hull(*matrices), rel=1e-14, abs=1e-14)


def any_of(first: float, last: float, most: float) -> list[float]:
    jac = list(NONE)
    take_in_any(plant(first), plant(last), most, T, BETA, jac)
    return jac


def union(one: list[float], matrices: list[Matrix]) -> Any:
    other = hull(*matrices)
    ends = [(min if k % 2 == 0 else max)(one[k], other[k]) for k in range(8)]
    return pytest.approx(ends, rel=1e-14, abs=1e-14)


def stop(y: float, pv: float) -> float:
    """When a state stops at that rate."""
    return min(pv / (pv - y), T) if pv > 0.0 else 0.0


def about(*states: State) -> float:
    """By how much the times differ at which these stop under the middle of the torques."""
    found = [stop(y + 0.5 * CHANGE, pv) for y, pv in states]
    return max(found) - min(found)


@pytest.mark.parametrize("by", range(3))
def test_where_all_slide_the_motion_is_smooth(by: int) -> None:
    """While the torque falls by where they end, with what it adds; while it rises by its least."""
    # A speed of half of pv + y, and a sixteenth more.
    for torque, states in (
        (FALLS, ((1.0, 1.0), (0.5, 2.0), (-1.0, 4.0))), (RISES, ((1.0, 1.0), (0.5, 2.0), (-1.0, 4.0))),
        (FALLS, ((-0.125, 0.0), (-1.125, 1.0), (1.0, 1.0))), (RISES, ((0.0, 0.0), (-1.0, 1.0), (1.0, 1.0))),
        (FALLS, ((-0.125, 0.0), (-1.125, 1.0), (-2.125, 2.0))), (FALLS, ((-0.125, 0.0),)), (RISES, ((0.0, 0.0),)),
    ):  # fmt: skip
        one = Stops(*states[by:], *states[:by], torque=torque)
        assert (one.jac, one.smooth, one.spread, one.later, one.line) == (hull(*slid()), True, 0.0, False, None)


def test_a_state_is_told_to_within_its_rounding() -> None:
    slack = 2.0**-6
    for torque, edge in ((FALLS, -0.125), (RISES, 0.0)):
        for state, slides in (
            ((2.0, -slack), True), ((2.0, -slack - 2.0**-40), False), ((edge - 1.0 - 2.0 * slack, 1.0), True),
            ((edge - 1.0 - 2.0 * slack - 2.0**-40, 1.0), False), ((edge - 2.0 * slack, -slack), True),
            ((edge - 2.0 * slack - 2.0**-40, -slack), False),
        ):  # fmt: skip
            one = Stops((2.0, 1.0), state, torque=torque, slack=slack)
            assert (one.jac == hull(*slid()), one.smooth, one.line is None) == (slides, slides, slides)


def test_what_stops_and_is_held() -> None:
    """From the first stop under the least torque to the last under the greatest."""
    one, two, three, none = (-1.5, 0.5), (-1.75, 0.25), (-1.5, 0.75), (-1.5, 0.0)
    for states in ((one,), (two, one), (one, two), (one, three), (three, one, two), (none,), (one, none), (none, two)):
        found = Stops(*states)
        first = min(stop(y, pv) for y, pv in states)
        last = max(stop(y + CHANGE, pv) for y, pv in states)
        assert (found.jac, found.smooth) == (near(stuck(first, last)), True)
        assert found.spread == pytest.approx(last - first)
        assert found.is_cut_at(0.5 * (first + last))
    # One that the greatest torque would just bring to the end may stop until then.
    for pv, last in ((1.25, T), (1.25 - 2.0**-8, stop(-1.25, 1.25 - 2.0**-8)), (1.3125, T)):
        found = Stops((-1.5, pv))
        assert found.jac == near(stuck(stop(-1.5, pv), last))
    # So may one that stands, where it leaves.
    found = Stops((-0.25, 0.0))
    assert found.jac == near(stuck(0.0, T))
    found = Stops((-0.25 - 2.0**-8, 0.0))
    assert found.jac == near(stuck(0.0, 0.0))


def pulls(y: float, pv: float, more: float = 0.0) -> tuple[float, float, float]:
    """Least and greatest pull of a state that stops, and the greatest on its way back; ``more``: what it is pushed."""
    way = T * (pv + T * more)
    least, most = y + FRICTION - BETA * way, y + CHANGE + FRICTION
    return least, most, most + BETA * (way + T * T * max(0.0, -FRICTION - least))


def test_what_stops_and_turns_round() -> None:
    """Where even the greatest pull on the way back is more than friction's."""
    for state in ((-3.0, 1.0), (-7.0, 1.0), (-9.0, 3.0), (-3.0, 0.0)):
        least, _, back = pulls(*state)
        found = Stops(state)
        first, last = stop(*state), stop(state[0] + CHANGE, state[1])
        assert (found.jac, found.smooth) == (near(turned(first, last, jump(least), jump(back))), True)
        spans, jumps = (last - first) * jump(back), (jump(back) - jump(least)) * T
        assert found.spread == pytest.approx(max(spans, jumps))
        assert found.line == [1.0, 0.0, 0.0] if jumps > spans else found.is_cut_at(0.5 * (first + last))
    # Of two: the least pull of one, on the way that the fastest comes, and the greatest of the other.
    least = -7.0 + FRICTION - BETA * T * 3.0
    back = -3.0 + CHANGE + FRICTION + BETA * (T * 3.0 + T * T * (-FRICTION - least))
    assert back < -FRICTION
    found = Stops((-7.0, 1.0), (-3.0, 1.0), (-9.0, 3.0))
    least = -9.0 + FRICTION - BETA * T * 3.0
    back = -3.0 + CHANGE + FRICTION + BETA * (T * 3.0 + T * T * (-FRICTION - least))
    assert back >= -FRICTION
    assert found.jac == pytest.approx(any_of(0.125, stop(-2.75, 1.0), 1.0 - jump(least)), rel=1e-14)
    found = Stops((-7.0, 1.0), (-4.0, 1.0))
    least = -7.0 + FRICTION - BETA * T
    back = -4.0 + CHANGE + FRICTION + BETA * (T + T * T * (-FRICTION - least))
    assert back < -FRICTION
    assert found.jac == near(turned(0.125, stop(-3.75, 1.0), jump(least), jump(back)))


def test_a_pull_of_just_friction_turns_nothing_round() -> None:
    """Not surely. And of one that holds it, all of a difference in speed goes."""
    at = (-17.0 * 1.125 / 8.0, 0.875)
    least, _, back = pulls(*at)
    assert back == -FRICTION
    assert Stops(at).jac == pytest.approx(any_of(stop(*at), stop(at[0] + CHANGE, at[1]), 1.0 - jump(least)), rel=1e-14)
    below = (at[0] - 2.0**-20, at[1])
    least, _, back = pulls(*below)
    assert Stops(below).jac == near(turned(stop(*below), stop(below[0] + CHANGE, below[1]), jump(least), jump(back)))


def test_jumps_are_of_friction_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 2: a pull of -6 turns a state by less than one of -3."""
    y, pv, friction = -6.0, 0.5, 2.0
    found = Stops((y, pv), friction=friction)
    first, last = stop(y, pv), stop(y + CHANGE, pv)
    least, most = y + friction - BETA * T * pv, y + CHANGE + friction
    back = most + BETA * (T * pv + T * T * (-friction - least))
    jumps = [2.0 * friction / (friction - pull) for pull in (least, back)]
    assert found.jac == near(turned(first, last, *jumps))
    for steady, later in ((CHANGE / friction, False), (nextafter(CHANGE / friction, 0.0), True)):
        monkeypatch.setattr(lagged_stops, "STEADY", steady)
        assert Stops((y, pv), friction=friction).later == later


def test_what_is_left_with_the_jumps_of_rates() -> None:
    """Where some may turn round and some are held, the spring moves the former on, too."""
    for y, pv, both in ((-2.0, 0.5, True), (-2.25, 0.5, True), (-1.9375, 0.5, False), (-1.5, 0.5, False)):
        least, most, back = pulls(y, pv)
        assert back >= -FRICTION
        assert both == (least < -FRICTION <= most)
        small = jump(min(least, -FRICTION))
        times, jumps = stop(y + CHANGE, pv) - stop(y, pv), (1.0 - small + (BETA if both else 0.0)) * T
        assert Stops((y, pv)).spread == pytest.approx(max(times, jumps), rel=1e-14)
        assert (jumps > times) == both


def test_the_line_is_told_from_any_centre() -> None:
    for centre in ((3.0, 0.5), (-2.0, 1.5), (0.5, -0.25)):
        for states, at in ((((-1.5, 0.5), (-1.5, 0.75)), None), (((-2.0, 0.5), (3.0, 1.0)), T)):
            found = Stops(*states, centre=centre)
            first, last = min(stop(y, pv) for y, pv in states), max(stop(y + CHANGE, pv) for y, pv in states)
            assert found.is_cut_at(0.5 * (first + last) if at is None else at)


def test_what_may_do_anything() -> None:
    """Neither surely held nor surely turning round: of a difference in speed each stop leaves between none and all."""
    for y, pv in ((-2.0, 0.5), (-2.125, 0.5), (-2.125, 1.0)):
        least, most, back = pulls(y, pv)
        assert least < -FRICTION <= back
        assert most <= FRICTION
        found = Stops((y, pv))
        first, last = stop(y, pv), stop(y + CHANGE, pv)
        assert found.jac == pytest.approx(any_of(first, last, 1.0 - jump(least)), rel=1e-14)
        assert found.smooth
    # A pull on the way back of exactly friction is not more than it; on the way there it holds.
    y = -2.0 - CHANGE
    least, _, back = pulls(y, 0.0)
    slower = -FRICTION - CHANGE - FRICTION - BETA * T * T * CHANGE
    for one in (slower, slower - 2.0**-6, slower + 2.0**-6):
        least, _, back = pulls(one, 0.0)
        found = Stops((one, 0.0))
        if back < -FRICTION:
            assert found.jac == near(turned(0.0, 0.0, jump(least), jump(back)))
        else:
            assert found.jac == pytest.approx(any_of(0.0, 0.0, 1.0 - jump(least)), rel=1e-14)
    assert Stops((-2.0, 0.0)).jac == near(stuck(0.0, 0.0))
    assert Stops((-2.0 - 2.0**-30, 0.0)).jac != near(stuck(0.0, 0.0))
    # A torque that pushes it on, by more than friction: that leaves nothing of a difference.
    for torque in (FALLS, RISES):
        found = Stops((-0.25, 0.0), torque=torque)
        slides = slid() if torque == RISES else []
        if torque == FALLS:
            assert found.jac == near(stuck(0.0, T))
        else:
            assert found.jac == union(any_of(0.0, T, 0.0), slides)
    found = Stops((-0.25 + 2.0**-8, 0.0), (-1.5, 0.0))
    assert found.jac == pytest.approx(any_of(0.0, T, 0.0), rel=1e-14)


def test_a_torque_that_pushes_it_on_brings_it_farther() -> None:
    """By as much again as the most that pushes any of it; those that slide are none that stops."""
    stops, slides = (-2.0, 0.5), (3.0, 1.0)
    found = Stops(stops, slides)
    least = -2.0 + FRICTION - BETA * T * (1.0 + T * (3.0 + CHANGE))
    assert found.jac == union(any_of(0.2, T, 1.0 - jump(least)), slid())
    assert not found.smooth
    assert found.is_cut_at(T)
    found = Stops(slides, stops)
    assert found.jac == union(any_of(0.2, T, 1.0 - jump(least)), slid())


def test_while_torque_rises_it_may_stop_and_go_on() -> None:
    """Where the greatest torque would let it slide: that is neither a stop nor a slide."""
    for y, pv in ((-3.125, 3.0), (-1.125, 1.0), (-1.25, 1.0), (-1.25 - 2.0**-8, 1.0)):
        least, _, back = pulls(y, pv)
        unsure = pv + y + CHANGE >= 0.0
        found = Stops((y, pv), torque=RISES)
        most = 1.0 - jump(least) if least < -FRICTION else 0.0
        if unsure:
            assert found.jac == union(any_of(stop(y, pv), T, most), slid())
            assert not found.smooth
        else:
            assert found.jac == near(stuck(stop(y, pv), stop(y + CHANGE, pv)))
            assert found.smooth
        assert back > -3.0
    slack = 2.0**-6
    for y, unsure in ((-1.25 - 2.0 * slack, True), (-1.25 - 2.001 * slack, False)):
        found = Stops((y, 1.0), torque=RISES, slack=slack)
        assert (not found.smooth) == unsure
    assert Stops((-1.125, 1.0), (-1.125, 0.5), torque=(1.75, 1.75)).smooth  # it neither rises nor falls


def test_some_slide_while_others_stop() -> None:
    """Then there are stops at any time until the end, as with a torque that does not lag."""
    stops = (-1.5, 0.5)
    for other, slides in (((1.0, 1.0), True), ((-1.125, 1.0), False)):
        for states in ((stops, other), (other, stops)):
            found = Stops(*states)
            assert found.jac == near([*stuck(0.25, T), *(slid() if slides else [])]) or slides
            assert found.smooth != slides
            assert found.spread >= 0.25
    slack = 2.0**-6
    for more, smooth in ((0.0, True), (2.0**-4, False), (2.0**-6, True)):
        for states in (((more - 1.125, 1.0), stops), (stops, (more - 1.125, 1.0))):
            found = Stops(*states, slack=slack)
            assert (found.smooth, found.jac[3]) == (smooth, T)
    # One that stands where friction just holds it is one of all times.
    for other, last in (((-0.125, 0.0), stop(-1.25, 0.5)), ((-0.125 - 2.0**-5, 2.0**-5), T)):
        found = Stops(other, stops, slack=slack)
        assert found.jac[3] == pytest.approx(last)
        assert found.smooth
    assert Stops((1.0, 2.0**-7), stops, slack=slack).jac[3] == T
    found = Stops((-99.0, 1.0), (1.0, 1.0))
    assert not found.smooth
    assert found.is_cut_at(T)


def test_one_that_just_slides_hides_none_that_does() -> None:
    """Nor one that stops at the end, in any order. One just as fast as a rounding is none of all times."""
    slack, stops = 2.0**-6, (-1.5, 0.5)
    slides, fast, slow = (1.0, 1.0), (-1.125, 1.0), (-0.125 - slack, slack)
    for states in permutations((slides, fast, stops)):
        found = Stops(*states, slack=slack)
        assert (found.jac, found.smooth, found.later) == (union(any_of(0.25, T, 0.0), slid()), False, False)
    for states in permutations((fast, slow, stops)):
        found = Stops(*states, slack=slack)
        assert (found.jac, found.smooth, found.later) == (any_of(0.25, T, 0.0), True, True)
    found = Stops(slow, stops, slack=slack)
    assert found.jac == any_of(0.25, stop(-1.25, 0.5), 0.0)


def test_a_set_through_a_speed_of_0_has_stops_at_once() -> None:
    stops, back = (-1.5, 0.5), (-1.5, -0.5)
    found = Stops(stops, back)
    last = stop(-1.25, 0.5)
    assert (found.jac, found.smooth) == (near(stuck(0.0, last)), True)
    assert found.spread == pytest.approx(last)
    assert found.is_cut_at(0.0)
    for y, slides in ((-CHANGE, True), (-CHANGE - 2.0**-30, False)):
        found = Stops(stops, (y, -0.5))
        assert (found.smooth, found.jac[3]) == (not slides, T if slides else pytest.approx(last))
        assert found.is_cut_at(0.0)
    found = Stops((-9.0, 1.0), (-9.0, -1.0))
    assert not found.smooth
    assert found.is_cut_at(0.0)
    # So it is where the jumps of rates are more than the times.
    found = Stops((-9.0, 2.0**-6), (-3.0, -1.0))
    assert found.spread > stop(-9.0 + CHANGE, 2.0**-6)
    assert found.is_cut_at(0.0)
    # What stands where friction does not hold it may go on: then there are stops until the end.
    found = Stops(stops, (1.0, -0.5))
    least, _, _ = pulls(-1.5, 0.5, 1.0 + CHANGE)
    assert found.jac == union(any_of(0.0, T, 1.0 - jump(min(least, -FRICTION))), slid())
    # One that slides by its speed alone does so, whatever the others would.
    found = Stops((-1.0, 4.0), back)
    assert not found.smooth
    assert (found.jac[5], found.jac[7]) == (0.0, F)
    found = Stops((-2.0, 0.0), (-2.0, -1.0))
    assert (found.jac, found.smooth) == (near(stuck(0.0, 0.0)), True)
    found = Stops(back)
    assert (found.jac, found.smooth, found.spread) == (near(stuck(0.0, 0.0)), True, 0.0)
    found = Stops((2.0, 1.0), back)
    assert not found.smooth
    assert found.is_cut_at(0.0)


def test_half_the_time_tells_more_where_the_torque_changes_by_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """And states stop in one half of it, if any; where that is not told otherwise, whatever the torque does."""
    held, unsure = (-1.5, 0.5), (-2.0, 0.5)
    for steady, later in ((CHANGE, False), (nextafter(CHANGE, 0.0), True), (1.0, False)):
        monkeypatch.setattr(lagged_stops, "STEADY", steady)
        assert Stops(held).later == later
        assert Stops(unsure).later
    monkeypatch.setattr(lagged_stops, "STEADY", 0.0)
    assert not Stops(held, (-1.5, -0.5)).later  # one that crosses
    assert not Stops(held, (1.0, 1.0)).later  # one that passes
    assert not Stops((1.0, 1.0), held).later
    assert Stops(held, (-1.125, 1.0)).later  # one that just stops
    for slow in ((-1.5, 0.0), (-1.5, 0.25), (-1.625, 1.25), (-0.875, 0.5)):
        for states in ((held, slow), (slow, held)):
            found = Stops(*states)
            assert found.later == (about(held, slow) < 0.5 * T)
    # A quarter apart: one that stands, and one that stops then, is not.
    for pv, later in ((0.5 - 2.0**-6, True), (0.5, False), (0.5 + 2.0**-6, False)):
        assert Stops((-1.625, 0.0), (-1.625, pv)).later == later
    # One that would not stop under the middle of the torques does so at the end, at the latest.
    for pv, later in ((0.75, True), (0.7, False)):
        states = (-1.0625, 1.0), (-2.25, pv)
        assert stop(-1.0625 + 0.5 * CHANGE, 1.0) == T
        found = Stops(*states, torque=RISES)
        assert found.later == later == (about(*states) < 0.5 * T)


def test_what_is_a_choice() -> None:
    assert (lagged_stops.STEADY, lagged_step.COARSE) == (0.05, 4.0)


# A set over a part of a hold.


class Sides:
    """Stands for what a side tells: ``(smooth, spread, later)`` by direction, an interval each, and a line."""

    def __init__(
        self, patch: pytest.MonkeyPatch, up: Any = (True, 0.25, False), down: Any = (True, 0.5, False)
    ) -> None:
        self.told = {1.0: up, -1.0: down}
        self.asked: list[tuple[Any, ...]] = []
        self.excess = (0.0, 0.0, 0.0, 0.0)
        self.to = (5.0, 0.25)
        self.speed = 0.25  # entry of the derivative
        self.moved: list[tuple[Any, ...]] = []
        self.seen: list[Any] = []
        patch.setattr(lagged_step, "take_in_stops", self.take)
        patch.setattr(lagged_step, "excess", self.excess_of)
        patch.setattr(lagged_step, "rub_many", self.rub)

    def take(self, sign: float, shape: Shape, slack: float, hold: LaggedHold, _body: Any, room: Room) -> Any:
        x, v, corners, count = shape
        (a, _, u, part, _), (jac, line, _, _) = hold, room
        self.asked.append((sign, x, v, a, u, part, slack, list(corners[: 2 * count]), count))
        for entry, value in enumerate((0.5, sign, 0.0, self.speed)):
            take_in(jac, entry, value, value)
        line[:] = [sign, 2.0 * sign, 4.0]
        return self.told[sign]

    def excess_of(self, jac: Any, high_x: float, high_v: float, corners: Any, count: int, beta: float) -> Any:
        self.seen.append((list(jac[:8]), high_x, high_v, list(corners[: 2 * count]), beta))
        return self.excess

    def rub(self, z: Any, u: float, span: float, body: Any, pad: Any) -> None:
        self.moved.append((list(z), u, span, body))
        z[0], z[1] = self.to


def moved(
    x: float, v: float, corners: list[float], *, torque: tuple[float, float] = FALLS, apart: float = 0.0,
    halve: bool = True, body: Any = BODY, least: float = 0.0,
) -> tuple[tuple[int, float, float, float, int], list[float], list[float]]:  # fmt: skip
    """Move a set over the part: what is returned, its corners, and the line."""
    work, line, (a, u) = [*corners, *zeros(200)], [7.0, 7.0, 7.0], torque
    shape, hold = Shape(x, v, work, len(corners) // 2), LaggedHold(a, apart, u, PART, halve)
    found = move_lagged(shape, hold, least, body, WHOLE, Room(zeros(200), line, zeros(3), zeros(6)))
    assert found[3] == (a if found[0] in (CUT, LATER) else u + 0.5 * (a - u))
    return found, work[: 2 * found[4]], line


SHIFTED = [value + by for value, by in zip(SQUARE, [0.5, -0.125] * 4, strict=True)]


def test_what_slides_one_way_moves_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """By what the torque is in the end, and what it is off by; friction is against it."""
    one = Sides(monkeypatch)
    expected = list(SQUARE)
    slide_corners(expected, 4, S, G, F, BETA)
    for x, v, (a, u), friction in (
        (1.0, 8.0, FALLS, 1.0), (1.0, 8.0, RISES, 1.0), (-1.0, -8.0, FALLS, 1.0), (9.0, -8.0, RISES, 1.0),
        (1.0, 0.0, FALLS, 0.0), (1.0, 0.25, RISES, 0.0), (-9.0, -8.0, FALLS, 0.0),
    ):  # fmt: skip
        for apart in (0.0, 0.5):
            y = u + 0.5 - BETA * x - (friction if v > 0.0 else -friction)
            found, corners, _ = moved(x, v, SQUARE, torque=(a, u), body=pushed(0.5, friction), apart=apart)
            late = a - u
            assert found[:4] == (
                SLID, x + S * v + G * y + LATE_X * late, F * v + S * y + LATE_V * late, u + 0.5 * late,
            )  # fmt: skip
            wider = list(expected) + zeros(200)
            # A torque of a half that decays to half, at a rate of 4: a sixteenth.
            count = widen(wider, 4, 0.5 * 0.0625, 0.0625, zeros(200)) if apart else 4
            assert corners == wider[: 2 * count]
    assert one.asked == []


def test_what_is_not_widened_keeps_its_corners_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Sides(monkeypatch)
    turned = [*SQUARE[4:], *SQUARE[:4]]
    expected = list(turned)
    slide_corners(expected, 4, S, G, F, BETA)
    assert moved(1.0, 8.0, turned)[1] == expected
    _, corners, _ = moved(1.0, 0.125, turned)
    assert len(one.asked) == 2
    middle = [value for k in range(4) for value in (0.5 * turned[2 * k], 0.25 * turned[2 * k + 1])]
    assert corners == middle


def fate(x: float, v: float, corners: list[float], **given: Any) -> int:
    return moved(x, v, corners, **given)[0][0]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_set_slides_to_within_the_roundings_of_its_terms(way: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """32 units of velocity, of the larger torque, of the push, of friction, and of the spring's; for each corner."""
    Sides(monkeypatch)
    for x, v, a, u, drive, friction in (
        (0.0, 0.0, 4.0, 4.0, 0.0, 1.0), (0.0, 0.0, 4.0, 8.0, 0.0, 1.0), (0.0, 0.0, 8.0, 4.0, 0.0, 1.0),
        (0.0, 0.0, 8.0, 8.0, -4.0, 1.0), (-32.0, 0.0, 4.0, 4.0, 0.0, 1.0), (32.0, 0.0, 16.0, 16.0, 0.0, 1.0),
        (0.0, 0.0, 8.0, 8.0, 0.0, 4.0), (0.0, 2.0, 4.0, 4.0, 0.0, 1.0),
    ):  # fmt: skip
        slack = UNIT * (abs(v) + max(a, u) + abs(drive) + friction + BETA * abs(x))
        for corner in range(2):
            for speed, slides in ((-slack, True), (-slack - 2.0**-51, False), (0.0, True)):
                corners = zeros(4)
                corners[2 * corner + 1] = way * (speed - v)
                found = fate(way * x, way * v, corners, torque=(way * a, way * u), body=pushed(way * drive, friction))
                assert (found == SLID) == slides, (x, v, a, u, drive, friction, speed)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_set_slides_as_long_as_none_of_it_stops(way: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """While torque falls by where it ends, with what it adds; while it rises by its least."""
    Sides(monkeypatch)
    for torque, edge in (((1.0, 0.0), 0.25), ((-1.0, 0.0), 2.0), ((0.0, 1.0), 1.0), ((0.0, 0.0), 1.0)):
        # Falling by 1 gives 3/8: half of the speed less half of friction's, and 3/8, is none at 1/4.
        for speed, slides in ((edge, True), (edge - 2.0**-40, False), (edge + 1.0, True)):
            for corner in range(2):
                corners = [0.0, way * 8.0, 0.0, way * 8.0]
                corners[2 * corner + 1] = way * speed
                found = fate(0.0, 0.0, corners, torque=(way * torque[0], way * torque[1]))
                assert (found == SLID) == slides, (torque, speed)
        for dx, slides in ((0.0, True), (-4.0, True), (2.0**-36, False)):
            corners = [way * dx, 0.0, 0.0, 0.0]
            found = fate(0.0, way * edge, corners, torque=(way * torque[0], way * torque[1]))
            assert (found == SLID) == slides
    for drive, edge in ((0.5, 0.5), (-0.5, 1.5)):
        for torque in ((0.0, 0.0), (0.0, 1.0)):
            for speed, slides in ((edge, True), (edge - 2.0**-40, False)):
                body = pushed(way * drive)
                found = fate(0.0, way * speed, [0.0, 0.0], torque=(0.0, way * torque[1]), body=body)
                assert (found == SLID) == slides


def test_what_stands_in_the_zone_all_along_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under every torque that acts, on any state of the set."""
    one = Sides(monkeypatch)
    one.excess = (0.0, 0.0, 1e9, 1e9)
    for torque in ((0.5, 0.0), (0.0, 0.5)):
        low_a, high_a = sorted((torque[0], 0.25))
        for drive, apart in ((0.0, 0.0), (0.5, 0.0), (-0.5, 0.125), (0.5, 0.125)):
            low, high = (high_a + apart + drive - 1.0) / BETA, (low_a - apart + drive + 1.0) / BETA
            middle = 0.5 * (low + high)
            for left, right, held in (
                (low, high, True), (low - 2.0**-20, high, False), (low, high + 2.0**-20, False), (middle, middle, True),
            ):  # fmt: skip
                corners = [left - middle, -0.25, right - middle, -0.25]
                found, after, _ = moved(middle, 0.25, corners, torque=torque, body=pushed(drive), apart=apart)
                assert (found == (HELD, middle, 0.25, 0.25, 2)) == held
                assert after == corners
            for corner in range(2):
                for dv in (2.0**-30, -(2.0**-30)):
                    corners = [-0.125, 0.0, 0.125, 0.0]
                    corners[2 * corner + 1] = dv
                    assert fate(middle, 0.0, corners, torque=torque, body=pushed(drive), apart=apart) != HELD
    # Nothing is held where nothing rubs.
    found, _, _ = moved(4.0, 0.0, [0.0, 0.0], torque=(1.0, 1.0), body=FREE)
    assert found == (SLID, 4.0, 0.0, 1.0, 1)


def test_both_sides_are_asked_where_a_set_has_both(monkeypatch: pytest.MonkeyPatch) -> None:
    for v, corners, ways in (
        (0.25, SQUARE, [1.0, -1.0]), (0.5, SQUARE, [1.0]), (-0.5, SQUARE, [-1.0]), (0.49, SQUARE, [1.0, -1.0]),
        (-0.49, SQUARE, [1.0, -1.0]), (0.0, [-9.0, 0.0, 9.0, 0.0], []),
    ):  # fmt: skip
        one = Sides(monkeypatch)
        shifted = [value + by for value, by in zip(corners, [0.5, -0.125] * 4, strict=False)]
        body = pushed(-1.5)
        moved(1.0, v + 0.125, shifted, body=body)
        assert [given[0] for given in one.asked] == ways
        slack = UNIT * (abs(v + 0.125) + 2.25 + 1.5 + 1.0 + 0.25)
        for given in one.asked:
            assert given[1:8] == (1.5, v, 2.25, 1.75, PART, slack, corners)
        jac, high_x, high_v, seen, beta = one.seen[0]
        assert (seen, high_x, high_v, beta) == (corners, corners[4] if ways else 9.0, 0.5 if ways else 0.0, BETA)
        if ways:
            assert jac[2:4] == [min(ways), max(ways)]


def test_what_stands_may_do_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is cut where friction just holds it at first; half the time tells more."""
    for drive, edges in ((0.0, (5.0, 13.0)), (0.5, (7.0, 15.0))):
        for low, high, edge in (
            (edges[0] - 6.0, edges[0] + 1.0, edges[0]), (edges[1] - 1.0, edges[1] + 9.0, edges[1]),
            (edges[0] - 3.0, edges[1] + 3.0, edges[0]), (edges[0], edges[1] - 0.25, None),
            (edges[0] + 0.25, edges[1], None),
        ):  # fmt: skip
            middle = 0.5 * (low + high)
            for halve, found_fate in ((True, LATER), (False, CUT)):
                one = Sides(monkeypatch)
                one.excess = (0.0, 0.0, 1e9, 1e9)
                corners = [low - middle, -0.25, high - middle, -0.25]
                found, after, line = moved(middle, 0.25, corners, body=pushed(drive), halve=halve)
                assert one.asked == []
                assert found[:1] + found[4:] == (found_fate, 2)
                assert after == corners
                jac = list(NONE)
                take_in_any((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0, T, BETA, jac)
                assert one.seen[0][0] == jac
                assert line == [1.0, 0.0, 0.0 if edge is None else edge - middle]
    way = BETA * T * T
    assert jac == [1.0 - way, 1.0, 0.0, 0.0, -BETA * T, 0.0, 0.0, 0.0]


def test_the_line_is_of_the_side_that_is_not_smooth_or_spreads_more(monkeypatch: pytest.MonkeyPatch) -> None:
    for up, down, way in (
        ((True, 0.25), (True, 0.5), -1.0), ((True, 0.5), (True, 0.25), 1.0), ((True, 0.5), (True, 0.5), -1.0),
        ((False, 0.25), (True, 0.5), 1.0), ((True, 0.5), (False, 0.25), -1.0), ((False, 0.5), (False, 0.25), -1.0),
        ((False, 0.25), (False, 0.5), -1.0),
    ):  # fmt: skip
        one = Sides(monkeypatch, (*up, False), (*down, False))
        one.excess = (0.0, 0.0, 1e9, 1e9)
        found, corners, line = moved(1.0, 0.125, SQUARE)
        assert found == (CUT, 1.0, 0.125, 2.25, 4)
        assert (corners, line) == (SQUARE, [way, 2.0 * way, 4.0])
    one = Sides(monkeypatch)
    one.excess = (0.0, 0.0, 1e9, 1e9)
    found, corners, line = moved(1.0, 0.125, SHIFTED)
    assert (found, corners, line) == ((CUT, 1.0, 0.125, 2.25, 4), SHIFTED, [-1.0, -2.0, 4.0 - 0.5 + 0.25])


def test_half_the_time_is_taken_first_where_it_tells_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of either side; of a set of any size, if half of it is left to take."""
    for up, down in ((True, False), (False, True), (True, True), (False, False)):
        for halve in (True, False):
            for least in (0.0, inf):
                one = Sides(monkeypatch, (True, 0.0, up), (True, 0.0, down))
                one.excess = (0.0, 0.0, 1e9, 1e9)
                found, corners, _ = moved(1.0, 0.125, SHIFTED, halve=halve, least=least)
                later = (up or down) and halve
                assert found[0] == (LATER if later else CUT if least == 0.0 else ENCLOSED)
                if later:
                    assert (found, corners) == ((LATER, 1.0, 0.125, 2.25, 4), SHIFTED)
                one.excess = (0.0, 0.0, 0.0, 0.0)
                assert fate(1.0, 0.125, SHIFTED, halve=halve, least=least) == ENCLOSED


def test_a_set_is_cut_unless_its_enclosure_is_narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """By its radius; wider where the motion is smooth. A coarse set may be wide if it has hardly grown."""
    for size in (1.0, COARSE / sqrt(2.0), nextafter(COARSE / sqrt(2.0), 0.0), 4.0):
        square = [size * value for value in SQUARE]
        radius = sqrt((size * 1.0) ** 2 + (size * 0.5) ** 2 / BETA)
        for up, down in ((True, True), (False, True), (True, False), (False, False)):
            smooth = up and down
            part = (NARROW_SMOOTH if smooth else NARROW) * radius
            may_grow = smooth or radius > COARSE
            for wider, grown, cut in (
                (part, inf, False), (nextafter(part, inf), inf, True), (inf, GROWN * radius, not may_grow),
                (inf, nextafter(GROWN * radius, inf), True), (0.0, inf, False),
            ):  # fmt: skip
                for least, small in ((0.0, False), (radius, True), (nextafter(radius, 0.0), False), (inf, True)):
                    one = Sides(monkeypatch, (up, 0.0, False), (down, 0.0, False))
                    one.excess = (0.0, 0.0, wider, grown)
                    assert (fate(1.0, 0.125, square, least=least) == CUT) == (cut and not small)


def test_a_set_as_wide_as_coarse_is_not_coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    for radius, cut in ((COARSE, True), (nextafter(COARSE, inf), False)):
        one = Sides(monkeypatch, (False, 0.0, False))
        one.excess = (0.0, 0.0, inf, GROWN * radius)
        assert (fate(9.0, 0.125, [-radius, 0.0, radius, 0.0]) == CUT) == cut


def test_an_enclosure_is_about_the_motion_of_its_centre(monkeypatch: pytest.MonkeyPatch) -> None:
    """Widened by what the intervals leave, and by what torques of the set differ."""
    for more_x, more_v in ((0.0, 0.0), (0.25, 0.0), (0.0, 0.125), (2.0, 0.5)):
        for apart in (0.0, 0.5):
            one = Sides(monkeypatch)
            one.excess = (more_x, more_v, 0.0, 0.0)
            found, corners, _ = moved(1.0, 0.25, SHIFTED, apart=apart)
            assert found == (ENCLOSED, 5.0, 0.25, 2.0, 4)
            assert one.moved == [([1.5, 0.125, 2.25], 1.75, T, WHOLE)]
            added = 0.0625 if apart else 0.0
            places = {abs(one) for one in corners[::2]}, {abs(one) for one in corners[1::2]}
            assert places == ({0.5 + more_x + 0.5 * added}, {0.125 + more_v + added})


def test_only_what_has_no_speed_at_all_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor may torques differ."""
    for speed, to_v, apart, held in (
        (0.0, 0.0, 0.0, True), (0.25, 0.0, 0.0, False), (0.0, 1e-300, 0.0, False), (0.0, -1.0, 0.0, False),
        (0.0, 0.0, 1e-9, False),
    ):  # fmt: skip
        one = Sides(monkeypatch)
        one.to, one.speed = (5.0, to_v), speed
        assert fate(1.0, 0.125, SQUARE, apart=apart) == (HELD if held else ENCLOSED)


def test_the_plant_of_these_tests() -> None:
    assert response(T)[0] == (1.0 - BETA * G, S)
