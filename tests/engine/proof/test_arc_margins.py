"""Arcs of clock phases on their margins: at 60 digits no part is too short, none much too long, no speed too small."""

import random
from itertools import pairwise
from math import cos, pi, sin, sqrt

import mpmath as mp
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.loop import Loop, make_loop
from hknob_cli.engine.sets import arc_cut
from hknob_cli.engine.sets.arc import position_error
from hknob_cli.engine.sets.arc_cut import BENT, NEXT, Flight, arc_speed, cut, free_motion, pass_edge, turn_after

from .orbits import DIGITS, Number, plant

LOOP = make_loop(0.3, 0.25, 0.5, 0.3, 1.0, 0.0, 0.0)
RISING, FALLING = (-1.0, 2.0), (1.0, -2.0)  # free motions


def some_loop(chance: random.Random, stiffest: float = 0.5) -> Loop:
    """Soft or stiff, lightly damped or overdamped, at rest at 0."""
    beta = 10.0 ** chance.uniform(-5.0, stiffest)
    alpha = sqrt(beta) * 10.0 ** chance.uniform(-3.0, 0.6)
    return make_loop(alpha, beta, 1.0, 0.0, chance.choice([-1.0, 1.0]), 0.0, 0.0)


def truly(t: float | Number, dx: float, dv: float, loop: Loop) -> tuple[Number, Number]:
    """The free motion, without a rounding."""
    p, s, _, f = plant(loop, t)
    return p * dx + s * dv, -mp.mpf(loop.beta) * s * dx + f * dv


def test_the_stated_rounding_of_a_free_motion() -> None:
    """64 units of start and rest, and as many for each radian that the plant rings until it has decayed."""
    loop = make_loop(0.25, 0.25, 1.0, 0.5, 1.0, 0.0, 0.0)  # at rest at -2
    assert position_error(3.0, -1.5, loop) == 64.0 * EPSILON * 3.0 * (5.0 + 3.0 + 2.0)
    assert position_error(-3.0, 1.5, make_loop(2.0, 0.25, 1.0, 0.0, 1.0, 0.0, 0.0)) == 64.0 * EPSILON * 1.25 * 6.0


def test_free_motions_are_within_the_stated_rounding() -> None:
    """Of a phase, samples after the start, as arcs have it: in two steps."""
    chance, worst = random.Random(1), mp.mpf(0)
    with mp.workdps(DIGITS):
        for _ in range(400):
            loop = some_loop(chance)
            dx, dv = chance.gauss(0.0, 1.0), chance.gauss(0.0, 1.0) * sqrt(loop.beta)
            samples, phase = float(int(10.0 ** chance.uniform(0.0, 4.0))), chance.random()
            x, v = free_motion(phase, *free_motion(samples, dx, dv, loop), loop)
            true_x, true_v = truly(mp.mpf(samples) + mp.mpf(phase), dx, dv, loop)
            error = mp.sqrt((true_x - x) ** 2 + (true_v - v) ** 2 / loop.beta)
            assert error <= position_error(dx, dv, loop)
            worst = max(worst, error / position_error(dx, dv, loop))
    assert worst > 1.0 / 200.0


def test_the_stated_speed() -> None:
    """0.6 and 0.08 / 0.5, rounded up."""
    assert arc_speed(0.4, -0.6, LOOP) == sqrt(0.6 * 0.6 + 0.08 * 0.08 / 0.25) * (1.0 + 64.0 * EPSILON)


def test_no_speed_along_an_arc_is_larger() -> None:
    """Nor at the sample after it: of position and velocity in the norm, at 60 digits."""
    chance = random.Random(2)
    with mp.workdps(DIGITS):
        for _ in range(300):
            loop = some_loop(chance)
            dx, dv = chance.gauss(0.0, 1.0), chance.gauss(0.0, 1.0) * sqrt(loop.beta)
            for t in (0.0, chance.random(), 1.0, 2.0):
                x, v = truly(t, dx, dv, loop)
                speed = mp.sqrt(v**2 + (loop.beta * x + loop.alpha * v) ** 2 / loop.beta)
                assert speed <= arc_speed(dx, dv, loop)
                if t == 0.0:
                    assert arc_speed(dx, dv, loop) <= speed * (1.0 + 70.0 * EPSILON)


def passed(
    edge: float, reach: float, low: float, high: float, base: float, motion: tuple[float, float], loop: Loop
) -> tuple[float, float]:
    """As `cut` calls it."""
    begin, v = free_motion(low, *motion, loop)
    end, _ = free_motion(high, *motion, loop)
    return pass_edge(edge, reach, low, high, begin, end, Flight(*motion, base, arc_speed(begin, v, loop)), loop)


def test_an_edge_is_passed_by_its_reach_and_little_more() -> None:
    """At 60 digits, on both sides, or the arc is at its end; from fast arcs to those that are about to turn."""
    chance, met, slow = random.Random(3), 0, 0
    with mp.workdps(DIGITS):
        while met < 300:
            loop = some_loop(chance, stiffest=4.0)
            dx, dv = chance.gauss(0.0, 3.0), chance.gauss(0.0, 3.0)
            low = 0.5 * chance.random()
            high = min(low + chance.random() * (1.0 - low), turn_after(low, dx, dv, loop))
            base, reach = chance.gauss(0.0, 3.0), 10.0 ** chance.uniform(-12.0, -1.0)
            a, b = (truly(phase, dx, dv, loop)[0] + base for phase in (low, high))
            part = 1.0 - 10.0 ** chance.uniform(-6.0, 0.0)
            edge = float(a + (b - a) * part)
            if chance.random() < 0.5:  # at 0, as the wall's own
                a, b, base, edge = a - edge, b - edge, base - edge, 0.0
            if abs(b - a) < 4.0 * reach:
                continue
            met += 1
            comes, leaves = passed(edge, reach, low, high, base, (dx, dv), loop)
            assert low <= comes <= leaves <= high
            rising = 1.0 if b > a else -1.0
            rounding = 64.0 * EPSILON * (abs(dx) + abs(dv) + abs(base) + abs(edge))
            for phase, side in ((comes, -rising), (leaves, rising)):
                x, v = truly(phase, dx, dv, loop)
                beyond = side * (x + base - edge)
                slow += abs(v) * abs(v) < 2.0 * reach * arc_speed(dx, dv, loop) * sqrt(loop.beta) / BENT
                assert beyond <= reach * 1.004 + rounding + 4.0 * NEXT * abs(v)
                assert phase in (low, high) or beyond >= reach - rounding
    assert 20 < slow < 2 * met - 20  # both ways to solve for an edge


def test_a_step_that_bends_is_long_enough_as_far_as_it_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 60 digits, up to the root of 2, less 1, of the speed: the arc slows as much as its bound says."""
    monkeypatch.setattr(arc_cut, "BENT", 0.41)
    chance = random.Random(4)
    with mp.workdps(DIGITS):
        for _ in range(300):
            beta = 10.0 ** chance.uniform(-2.0, 3.0)
            loop = make_loop(1e-6 * sqrt(beta), beta, 1.0, 0.0, 1.0, 0.0, 0.0)
            side, w = chance.choice([-1.0, 1.0]), sqrt(beta)
            early, late = chance.uniform(0.1, 0.7), 1.5
            motion = side * cos(early), -side * w * sin(early)  # a cosine, from near its top
            reach, low, high = 10.0 ** chance.uniform(-4.0, -1.0), 0.0, (late - early) / w
            edge = side * chance.uniform(cos(late), cos(early))
            comes, leaves = passed(edge, reach, low, high, 0.0, motion, loop)
            for phase, far in ((comes, side), (leaves, -side)):
                beyond = far * (truly(phase, *motion, loop)[0] - edge)
                assert phase in (low, high) or beyond >= reach * (1.0 - 1e-9)


def test_phases_are_rounded_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both by as much as phases next to each other are."""
    loop = make_loop(1e-9, 1e-12, 1.0, 0.0, 1.0, 0.0, 0.0)
    monkeypatch.setattr(arc_cut, "NEXT", 0.0625)
    for motion in (RISING, FALLING):
        assert passed(0.0, 0.5, 0.0, 1.0, 0.0, motion, loop) == pytest.approx((0.1875, 0.8125), abs=1e-6)


def test_an_edge_beyond_the_ends_is_within_reach_of_them() -> None:
    """The arc is near it from its beginning, or until its end; and all along where it hardly moves."""
    loop = make_loop(1e-9, 1e-12, 1.0, 0.0, 1.0, 0.0, 0.0)
    for motion in (RISING, FALLING):
        side = 1.0 if motion is RISING else -1.0
        assert passed(-side * 1.25, 0.5, 0.0, 1.0, 0.0, motion, loop) == (0.0, pytest.approx(0.125, rel=1e-3))
        assert passed(side * 1.25, 0.5, 0.0, 1.0, 0.0, motion, loop) == (pytest.approx(0.875, rel=1e-3), 1.0)
        assert passed(0.0, 0.5, 0.0, 1.0, 0.0, motion, loop) == pytest.approx((0.25, 0.75), rel=1e-3)
        assert passed(side * 0.5, 0.25, 0.0, 1.0, 0.0, motion, loop) == pytest.approx((0.625, 0.875), rel=1e-3)
        assert passed(side * 2.0, 0.5, 0.0, 1.0, side, motion, loop) == pytest.approx((0.75, 1.0), rel=1e-3)
    assert passed(0.25, 0.5, 0.125, 0.75, 0.0, (0.0, 0.0), loop) == (0.125, 0.75)
    assert passed(0.25, 0.125, 0.125, 0.75, 0.0, (0.0, 0.0), loop) == (0.125, 0.75)


def parts_of(low: float, high: float, base: float, reach: float, motion: tuple[float, float], loop: Loop) -> list:
    cuts, (x, v) = [0.0] * 90, free_motion(low, *motion, loop)
    count = cut(low, high, x, v, reach, Flight(*motion, base, arc_speed(x, v, loop)), cuts, loop)
    return [tuple(cuts[3 * k : 3 * k + 3]) for k in range(count)]


def test_every_turn_of_an_arc_is_followed() -> None:
    """A plant that rings nearly four times a sample: each swing over the edge is a part, and there is no gap."""
    loop = make_loop(0.02, 600.0, 1.0, 0.0, 1.0, 0.0, 0.0)
    found = parts_of(0.0, 1.0, 0.0, 0.0, (-1.0, 0.0), loop)
    assert [level for level, _, _ in found] == [*[-1.0, 0.0] * 4, -1.0]
    for (_, _, last), (_, first, _) in pairwise(found):
        assert 0.0 <= last - first <= 4.0 * NEXT or last == pytest.approx(first, abs=1e-12)
        assert abs(free_motion(first, -1.0, 0.0, loop)[0]) <= 1e-9
    assert (found[0][1], found[-1][2]) == (0.0, 1.0)


def test_both_sides_of_an_edge_take_in_what_is_within_reach() -> None:
    """Levels -2, -1 and 0, up and down, with both roundings; one level alone is the whole."""
    for sense in (1.0, -1.0):
        loop = make_loop(1e-9, 1e-12, 1.0, 0.0, sense, 0.0, 0.0)
        top, base = (0.0, 0.5) if sense > 0.0 else (0.0, -0.5)
        edge = 0.0 if sense > 0.0 else -1.0
        for side in (1.0, -1.0):
            found = parts_of(0.0, 1.0, base, 0.125, (-side * 2.0, side * 4.0), loop)
            levels = [level for level, _, _ in found]
            assert sorted(levels)[-1] == top
            assert levels == sorted(levels, reverse=side < 0.0)
            for level, first, last in found:
                ends = sorted(base + side * (4.0 * phase - 2.0) for phase in (first, last))
                low = edge + level if level < 0.0 or sense < 0.0 else edge
                least, most = (low - 0.125, low + 1.125) if level < 0.0 else (edge - 0.125, 9.0)
                assert ends[0] == pytest.approx(max(least, base - 2.0), abs=1e-3)
                assert ends[1] == pytest.approx(min(most, base + 2.0), abs=1e-3)
        assert parts_of(0.25, 0.5, 9.0, 0.125, RISING, loop) == [(0.0, 0.25, 0.5)]


def test_an_arc_whose_ends_move_the_same_way_may_have_turned_between() -> None:
    """A whole turn of a plant that rings, and a little more: over the edge, back, and over it again."""
    loop = make_loop(0.02, 600.0, 1.0, 0.0, 1.0, 0.0, 0.0)
    whole = 2.0 * pi / sqrt(600.0)
    for motion, levels in (((-0.5, 15.0), [-1.0, 0.0, -1.0, 0.0]), ((0.5, -15.0), [0.0, -1.0, 0.0, -1.0])):
        for low in (0.0, 0.625):
            early = free_motion(-low, *motion, loop)
            found = parts_of(low, low + 1.2 * whole, 0.0, 0.0, early, loop)
            assert [level for level, _, _ in found] == levels
            assert (found[0][1], found[-1][2]) == (low, low + 1.2 * whole)


def test_an_arc_that_turns_within_a_level_is_one_part() -> None:
    """Also where others follow: it turns in level -1, where its first part goes on."""
    loop = make_loop(1e-9, 4.0, 1.0, 0.0, 1.0, 0.0, 0.0)
    assert parts_of(0.0, 1.0, 0.5, 0.0, (0.0, 0.25), loop) == [(0.0, 0.0, 1.0)]
    found = parts_of(0.0, 1.0, -0.25, 0.0, (0.0, 0.25), loop)
    assert found == [(-1.0, 0.0, 1.0)]
    found = parts_of(0.0, 1.5, -0.875, 0.0, (0.0, 1.0), loop)
    assert [level for level, _, _ in found] == [-1.0]


def test_there_must_be_room_for_every_part() -> None:
    """Three numbers each."""
    loop = make_loop(1e-9, 1e-12, 1.0, 0.0, 1.0, 0.0, 0.0)
    x, v = free_motion(0.0, *RISING, loop)
    flight = Flight(*RISING, 0.5, arc_speed(x, v, loop))
    for length, parts in ((9, 2), (6, 2), (5, -1), (3, -1)):
        assert cut(0.0, 1.0, x, v, 0.125, flight, [0.0] * length, loop) == parts
    assert cut(0.0, 0.125, x, v, 0.125, flight, [0.0] * 3, loop) == 1
    assert cut(0.0, 0.125, x, v, 0.125, flight, [0.0] * 2, loop) == -1
