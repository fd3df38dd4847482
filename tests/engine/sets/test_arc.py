"""Tests of `engine.sets.arc`: whatever a state's level is, a part with that level holds it."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.loop import Loop, level_of, lower_edge, make_loop, upper_edge
from hknob_cli.engine.sets.arc_cut import (
    BENT,
    Flight,
    arc_speed,
    cut,
    extent,
    free_motion,
    part_within,
    solve_phase,
    turn_after,
)
from hknob_cli.engine.sets.room import make_arc_room

from .loops import follow_all, free_response, knob, known, loops, zeros

speeds = st.floats(-8.0, 8.0)
places = st.floats(-6.0, 6.0)
phases = st.floats(0.0, 1.0)


def curve(loop: Loop, dx: float, dv: float, low: float, high: float, count: int = 400) -> list[tuple[float, float]]:
    """Phases of an arc and positions of its free motion there."""
    return [(phase, free_motion(phase, dx, dv, loop)[0]) for phase in np.linspace(low, high, count)]


def radius_of(low: float, high: float, dx: float, dv: float, loop: Loop) -> float:
    """Half the length of an arc times the largest speed along it."""
    return 0.5 * (high - low) * arc_speed(*free_motion(low, dx, dv, loop), loop)


def cut_arc(
    low: float, high: float, base: float, reach: float, dx: float, dv: float, cuts: list[float], loop: Loop
) -> int:
    """Parts of an arc between two phases of a free motion."""
    x, v = free_motion(low, dx, dv, loop)
    return cut(low, high, x, v, reach, Flight(dx, dv, base, arc_speed(x, v, loop)), cuts, loop)


@settings(deadline=None)
@given(loop=loops, dx=places, dv=speeds, t=st.floats(0.0, 30.0))
def test_free_motion_is_the_plants(loop: Loop, dx: float, dv: float, t: float) -> None:
    """By a matrix exponential, to its own accuracy of some 1e-12 of the largest motion there can be."""
    expected = free_response(loop, t) @ [dx, dv]
    scale = (abs(dx) + abs(dv) / sqrt(loop.beta)) * (1.0 + sqrt(loop.beta))
    assert free_motion(t, dx, dv, loop) == pytest.approx(tuple(expected), abs=1e-11 * (1.0 + scale))


@settings(deadline=None)
@given(loop=loops, dx=places, dv=speeds, low=phases, high=phases)
def test_no_state_of_an_arc_is_farther_than_its_radius(
    loop: Loop, dx: float, dv: float, low: float, high: float
) -> None:
    """In the norm in which the free plant never grows."""
    low, high = min(low, high), max(low, high)
    radius = radius_of(low, high, dx, dv, loop)
    middle = free_motion(0.5 * (low + high), dx, dv, loop)
    apart = [
        sqrt((x - middle[0]) ** 2 + (v - middle[1]) ** 2 / loop.beta)
        for x, v in (free_motion(phase, dx, dv, loop) for phase in np.linspace(low, high, 50))
    ]
    scale = abs(dx) + abs(dv) / sqrt(loop.beta)
    assert max(apart) <= radius + 1e-12 * scale


def test_the_radius_of_a_short_arc_is_half_its_length() -> None:
    """Speed times half the phases, to first order."""
    loop, low, high = knob(), 0.4, 0.4 + 1e-5
    x, v = free_motion(low, 3.0, -0.2, loop)
    rate = -loop.beta * x - loop.alpha * v
    assert radius_of(low, high, 3.0, -0.2, loop) == pytest.approx(0.5e-5 * sqrt(v * v + rate * rate / loop.beta))


@settings(deadline=None)
@given(loop=loops, dx=places, dv=speeds)
def test_extent_is_the_least_and_the_largest_position(loop: Loop, dx: float, dv: float) -> None:
    """No position of an arc lies outside, and some lie at either end except for what a grid of phases misses."""
    least, most = extent(0.0, 1.0, dx, dv, loop)
    found = [x for _, x in curve(loop, dx, dv, 0.0, 1.0)]
    scale = abs(dx) + abs(dv) + 1.0
    assert least <= min(found) + 1e-12 * scale
    assert most >= max(found) - 1e-12 * scale
    step = radius_of(0.0, 1.0, dx, dv, loop) * 2.0 / 399.0
    assert least >= min(found) - step - 1e-12 * scale
    assert most <= max(found) + step + 1e-12 * scale


@settings(deadline=None)
@given(loop=loops, dx=places, dv=speeds, low=phases)
def test_the_velocity_vanishes_where_an_arc_turns(loop: Loop, dx: float, dv: float, low: float) -> None:
    """And does not change its sign before."""
    turn = turn_after(low, dx, dv, loop)
    if turn > 50.0 or dv == 0.0 == dx:
        return
    scale = (abs(dx) * sqrt(loop.beta) + abs(dv)) * (1.0 + sqrt(loop.beta)) + 1e-300
    assert abs(free_motion(turn, dx, dv, loop)[1]) <= 1e-9 * scale
    between = [free_motion(low + part * (turn - low), dx, dv, loop)[1] for part in np.linspace(0.01, 0.99, 30)]
    assert max(between) <= 1e-9 * scale or min(between) >= -1e-9 * scale


@settings(max_examples=300, deadline=None)
@given(loop=loops, dx=places, dv=speeds, base=places, low=phases, high=phases, reach=st.sampled_from([0.0, 1e-9, 0.05]))
def test_every_state_lies_in_a_part_of_its_level(
    loop: Loop, dx: float, dv: float, base: float, low: float, high: float, reach: float
) -> None:
    """Of its level, and of any other within reach of it; no part holds what is farther, except for some thousandths."""
    low, high = min(low, high), max(low, high)
    cuts = zeros(3000)
    parts = cut_arc(low, high, base, reach, dx, dv, cuts, loop)
    assert parts >= 1
    rows = [cuts[3 * k : 3 * k + 3] for k in range(parts)]
    rounding = 1e-12 * (abs(dx) + abs(dv) + abs(base) + 1.0)
    for phase, x in curve(loop, dx, dv, low, high, 60):
        for near in {level_of(x + base + side * max(0.0, reach - rounding), loop.sense) for side in (-1.0, 0.0, 1.0)}:
            edge = min(abs(x + base - lower_edge(near, loop.sense)), abs(x + base - upper_edge(near, loop.sense)))
            if edge < rounding:
                continue
            assert any(q == near and first <= phase <= last for q, first, last in rows), (phase, near, rows)
    wide = reach * (1.0 + 4.0 * BENT)
    for q, first, last in rows:
        assert low <= first <= last <= high
        for _, x in curve(loop, dx, dv, first, last, 9):
            assert x + base >= lower_edge(q, loop.sense) - wide - rounding
            assert x + base <= upper_edge(q, loop.sense) + wide + rounding


def test_an_arc_that_turns_beyond_an_edge_is_cut_in_three() -> None:
    """It rises over an edge and comes back: before, beyond and after are parts, in order along it."""
    loop = make_loop(0.01, 4.0, 1.0, 0.0, 1.0, 0.0, 0.0)
    cuts = zeros(30)
    assert cut_arc(0.0, 1.0, -1.47, 0.0, 0.0, 1.0, cuts, loop) == 3
    assert cuts[0:9:3] == [-2.0, -1.0, -2.0]
    assert cuts[1] == 0.0
    assert cuts[8] == 1.0
    assert cuts[4] == pytest.approx(cuts[2], abs=1e-15)
    assert cuts[7] == pytest.approx(cuts[5], abs=1e-15)
    assert cuts[2] < cuts[5]


@settings(max_examples=300, deadline=None)
@given(loop=loops, dx=places, dv=speeds, base=places, low=phases, high=phases, part=phases)
def test_a_cut_lies_between_two_phases_that_only_rounding_parts(
    loop: Loop, dx: float, dv: float, base: float, low: float, high: float, part: float
) -> None:
    """On either side of the target, as evaluated, and as near to it as positions can be told apart there."""
    low, high = min(low, high), max(low, high)
    high = min(high, turn_after(low, dx, dv, loop))
    a, b = (free_motion(phase, dx, dv, loop)[0] + base for phase in (low, high))
    target = a + part * (b - a)
    if not min(a, b) < target < max(a, b):
        return
    left, right = solve_phase(target, low, high, b > a, base, dx, dv, loop)
    assert low <= left <= right <= high
    near, far = (free_motion(phase, dx, dv, loop)[0] + base for phase in (left, right))
    assert (near < target) == (a < target)
    assert (far < target) != (a < target)
    assert abs(far - near) <= 1e-13 * (abs(dx) + abs(dv) * (1.0 + 1.0 / sqrt(loop.beta)) + abs(base) + 1e-6)


def test_an_arc_that_meets_too_many_edges_is_not_cut() -> None:
    """There is no room for its parts, which is said instead of leaving some out."""
    loop = make_loop(0.01, 0.01, 1.0, 0.0, 1.0, 0.0, 0.0)
    assert cut_arc(0.0, 1.0, -500.0, 0.0, 0.0, 900.0, zeros(30), loop) == -1


def test_a_part_takes_in_what_touches_its_edges() -> None:
    """A monotone arc from -1 to 1, cut to what lies within 0.25 of 0.25."""
    loop = make_loop(1e-9, 1e-12, 1.0, 0.0, 1.0, 0.0, 0.0)
    first, last = part_within(0.0, 0.5, 0.0, 1.0, -1.0, 0.0, 2.0, loop)
    assert (first, last) == pytest.approx((0.5, 0.75), abs=1e-8)
    assert part_within(1.5, 2.0, 0.0, 1.0, -1.0, 0.0, 2.0, loop) == (1.0, 0.0)
    assert part_within(-9.0, 9.0, 0.0, 1.0, -1.0, 0.0, 2.0, loop) == (0.0, 1.0)
    assert part_within(-2.0, -1.5, 0.0, 1.0, -1.0, 0.0, 2.0, loop) == (1.0, 0.0)
    assert part_within(1.0, 2.0, 0.0, 1.0, 1.0, 0.0, -2.0, loop) == pytest.approx((0.0, 0.0), abs=1e-15)
    assert part_within(-2.0, -1.0, 0.0, 1.0, -1.0, 0.0, 2.0, loop) == pytest.approx((0.0, 0.0), abs=1e-15)
    for side in (1.0, -1.0):  # from a corner at an edge on, away from it and across
        assert part_within(-side - 3.0, -side + 3.0, 0.0, 0.5, -side, 0.0, side * 2.0, loop) == (0.0, 0.5)
        low, high = sorted((-side, -0.5 * side))
        assert part_within(low, high, 0.0, 1.0, -side, 0.0, side * 2.0, loop) == pytest.approx((0.0, 0.25), abs=1e-8)


@pytest.mark.parametrize("delay", [0, 2])
def test_shares_of_all_arcs_make_one(delay: int) -> None:
    """The lengths of the arcs of all ends, whatever the delay line."""
    loop, ends = knob(split=0.4 if delay else 0.0), known(delay)
    samples, arcs, undecided, shortest, covered, cut_whole = follow_all(
        2.0, 0.0, delay, 65_536, 64, 1e6, make_arc_room(zeros, delay), ends, loop
    )
    rows = int(ends.counts[0])
    assert cut_whole
    assert undecided == 0.0
    assert samples > arcs > 0
    assert 0.0 < shortest <= 1.0
    assert sum(ends.table[10 * row + 8] for row in range(rows)) == pytest.approx(covered, abs=1e-12)
    assert covered == pytest.approx(1.0, abs=1e-7)


def test_what_has_no_proven_end_within_the_budget_is_undecided() -> None:
    """All of it, where there are no samples to speak of."""
    ends = known()
    _, _, undecided, _, covered, cut_whole = follow_all(2.0, 0.0, 0, 3, 64, 1e6, make_arc_room(zeros, 0), ends, knob())
    assert cut_whole
    assert undecided == covered
