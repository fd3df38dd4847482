"""Tests of `engine.sets.ball` and `engine.sets.ball`: when a ball may be parted, and when it is captured."""

from math import nextafter, sqrt

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, follow
from hknob_cli.engine.loop import Loop, level_of, make_loop
from hknob_cli.engine.sets.ball import (
    FIRST_REST_TEST,
    GREW,
    MEETS_EDGE,
    OUT_OF_SAMPLES,
    STEPS_DEEPER,
    Trial,
    add_end,
    captor,
    follow_ball,
    resting,
    step_through,
)
from hknob_cli.engine.sets.room import Known

from .loops import knob, known, loops


def ball(loop: Loop, ends: Known, x: float, v: float, radius: float, **more: float) -> tuple:
    """Follow a ball that has just begun."""
    level = more.get("level", level_of(x, loop.sense))
    start = Trial(x, v, more.get("error", 0.0), level, 0, FIRST_REST_TEST, 0)
    samples, limit, small = int(more.get("samples", 200)), more.get("limit", 1e6), bool(more.get("small", False))
    event, row, end, used = follow_ball(start, radius, [], samples, limit, small, ends, loop)
    return event, row, *end, used


def learned(loop: Loop, x: float = 2.0) -> Known:
    """Room that knows the orbit of the trial from ``x``."""
    ends = known()
    fate, n, at_x, at_v, head, _ = follow(x, 0.0, [], 0, 65_536, 1e6, loop)
    assert fate == CYCLE_PROVEN
    assert add_end(fate, n, at_x, at_v, [], head, ends, loop) == 0
    return ends


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_ball_that_touches_an_edge_meets_it(sense: float) -> None:
    """By a hair it does not: radius and rounding error together decide, on either side."""
    loop, gap = knob(sense), 0.25
    for x in (-2.0 + gap, -1.0 - gap):
        assert ball(loop, known(), x, 0.0, gap * 0.999, samples=1)[0] == OUT_OF_SAMPLES
        assert ball(loop, known(), x, 0.0, nextafter(gap, 1.0) * 1.0001, samples=1)[0] == MEETS_EDGE
        assert ball(loop, known(), x, 0.0, 0.5 * gap, error=0.499 * gap, samples=1)[0] == OUT_OF_SAMPLES
        assert ball(loop, known(), x, 0.0, 0.5 * gap, error=0.501 * gap, samples=1)[0] == MEETS_EDGE


def test_a_ball_that_meets_an_edge_has_not_acted() -> None:
    """State and level are those of the sample before anything was commanded."""
    event, row, x, v, error, level, *_, used = ball(knob(), known(), -0.1, 0.3, 0.2, level=-3.0)
    assert (event, row, x, v, error, level, used) == (MEETS_EDGE, -1, -0.1, 0.3, 0.0, -3.0, 0)


def test_a_ball_far_out_has_grown() -> None:
    """Past the limit nothing comes back, as in `follow`."""
    assert ball(knob(), known(), 101.5, 0.0, 0.1, limit=100.0)[0] == GREW
    assert ball(knob(), known(), 99.5, 0.0, 0.1, limit=100.0, samples=1)[0] == OUT_OF_SAMPLES


def test_a_small_ball_stops_where_the_wall_steps_deeper() -> None:
    """And a ball that is not small goes on."""
    loop = knob()
    stop = ball(loop, known(), 0.9, -0.3, 1e-6, small=True)
    assert stop[0] == STEPS_DEEPER
    assert level_of(stop[2], loop.sense) < stop[5] <= 0.0  # the level before is kept, so that it is asked again
    assert ball(loop, known(), 0.9, -0.3, 1e-6)[0] != STEPS_DEEPER


def test_a_ball_inside_the_margin_is_captured() -> None:
    """Where the wall steps deeper: up to the margin less the error of the orbit, and no farther."""
    loop = knob()
    ends = learned(loop)
    x, v, margin, bound = ends.points[1], ends.points[2], ends.table[4], ends.table[7]
    room = margin - bound
    assert captor(x, v, 0.999 * room, [], 0, ends, loop) == 0
    assert captor(x, v, 1.001 * room, [], 0, ends, loop) == -1
    assert captor(x + 0.5 * room, v, 0.499 * room, [], 0, ends, loop) == 0
    assert captor(x + 0.5 * room, v, 0.501 * room, [], 0, ends, loop) == -1
    # Velocities count by the norm in which the free plant never grows.
    apart = 0.5 * room * sqrt(loop.beta)
    assert captor(x, v - apart, 0.499 * room, [], 0, ends, loop) == 0
    assert captor(x, v - apart, 0.501 * room, [], 0, ends, loop) == -1


def test_what_is_under_way_must_agree_to_be_captured() -> None:
    """With a delay line the state alone does not tell the future."""
    loop = make_loop(0.338, 0.0844, 0.5696, 0.344, 1.0, 0.0, 0.0)
    ends, ring = known(2), [0.0, 0.0]
    fate, n, x, v, head, _ = follow(2.0, 0.0, ring, 0, 65_536, 1e6, loop)
    assert fate == CYCLE_PROVEN
    add_end(fate, n, x, v, ring, head, ends, loop)
    # A sample at which two different commands are under way, so that their order is seen to matter.
    lines = [list(ends.point_lines[2 * k : 2 * k + 2]) for k in range(int(ends.counts[1]))]
    k = next(k for k, line in enumerate(lines) if line[0] != line[1])
    at_x, at_v, line = ends.points[3 * k + 1], ends.points[3 * k + 2], lines[k]
    assert captor(at_x, at_v, 0.0, line, 0, ends, loop) == 0
    assert captor(at_x, at_v, 0.0, line[::-1], 1, ends, loop) == 0
    assert captor(at_x, at_v, 0.0, line[::-1], 0, ends, loop) == -1
    assert captor(at_x, at_v, 0.0, [line[0] - 1.0, line[1]], 0, ends, loop) == -1


def test_a_ball_around_a_rest_point_is_captured_within_its_margin() -> None:
    """Of the rest point's distance to the nearest edge that changes the torque."""
    loop = make_loop(0.3, 0.08, 0.5, 0.52, 1.0, 0.0, 0.0)
    rest = (loop.kappa - loop.gamma) / loop.beta  # -1/4
    assert -1.0 < rest < 0.0
    margin = min(rest + 1.0, -rest)
    ends = known()
    assert resting(rest, 0.0, 0.99 * margin, -1.0, [], 0, ends, loop) == 0
    assert ends.table[0] == REST_PROVEN
    assert ends.table[2] == pytest.approx(rest)
    assert resting(rest, 0.0, 1.01 * margin, -1.0, [], 0, ends, loop) == -1
    assert resting(rest, 0.0, 0.0, -1.0, [-1.0, 0.0], 0, ends, loop) == -1  # another level is still under way


def test_an_end_is_entered_once() -> None:
    """Trials that reach it at other samples find its row; and the table says when it is full."""
    loop = knob()
    ends = learned(loop)
    count, points = ends.counts[0], ends.counts[1]
    fate, n, x, v, head, _ = follow(1.3, 0.1, [], 0, 65_536, 1e6, loop)
    if abs(x - ends.table[2]) < 1e-9:
        assert add_end(fate, n, x, v, [], head, ends, loop) == 0
        assert (ends.counts[0], ends.counts[1]) == (count, points)
    full = ends._replace(table=ends.table[:10])
    assert add_end(REST_PROVEN, 1, -17.5, 0.0, [], 0, full, loop) == -1


@settings(deadline=None)
@given(
    loop=loops,
    x=st.floats(-20.0, 20.0),
    v=st.floats(-3.0, 3.0),
    level=st.sampled_from([0.0, -1.0, -2.0, -9.0]),
)
def test_rounding_of_a_step_is_less_than_its_bound(loop: Loop, x: float, v: float, level: float) -> None:
    """One sample at 60 digits from the same doubles, its coefficients included."""
    at_x, at_v, bound, _ = step_through(x, v, 0.0, level, [], 0, loop)
    with mpmath.workdps(60):
        alpha, beta = mpmath.mpf(loop.alpha), mpmath.mpf(loop.beta)
        drive = (-mpmath.mpf(loop.kappa) * level if level < 0.0 else 0) - mpmath.mpf(loop.gamma)
        matrix = mpmath.matrix([[0, 1, 0], [-beta, -alpha, 1], [0, 0, 0]])
        hold = mpmath.expm(matrix, method="taylor")
        right_x = hold[0, 0] * x + hold[0, 1] * v + hold[0, 2] * drive
        right_v = hold[1, 0] * x + hold[1, 1] * v + hold[1, 2] * drive
        error = mpmath.sqrt((right_x - at_x) ** 2 + (right_v - at_v) ** 2 / beta)
        assert error <= bound
