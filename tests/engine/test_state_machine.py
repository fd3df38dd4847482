"""Pieces, edges and turning points: closed forms, grazing, and rest on an edge."""

from math import inf, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.unsampled.state_machine import (
    EDGE,
    ENDS,
    TURN,
    Unsampled,
    crossing_time,
    damped_step,
    glide_time,
    heading,
    move_on,
    place,
    potential,
    rest_range,
    undamped_step,
)

BALL = Unsampled(alpha=0.0, beta=0.0, kappa=1.0, gamma=0.5, phi=0.0, offset=0.0, counted=1.0)

unit = st.floats(0.01, 3.0)


@given(
    v=unit, y=unit, beta=st.sampled_from([0.0, 1e-9, 0.3, 4.0]), gap=st.floats(0.01, 1.0), way=st.sampled_from([-1, 1])
)
def test_undamped_time_is_that_of_the_motion(v: float, y: float, beta: float, gap: float, way: int) -> None:
    """After the time in closed form the exact response is at the edge, at the velocity in closed form."""
    kind, move, after, t = undamped_step(way * v, way * y, float(way), way * gap, beta)
    s, g, f = hold_coefficients(0.0, beta, t)
    scale = (v + y * t) * t
    assert abs(s * way * v + g * way * y - move) <= 1e-14 * scale
    assert kind in (EDGE, TURN)
    # Half-angle form and coefficients: some ten roundings, each relative to the largest term.
    assert abs(f * way * v + s * way * y - after) <= 1e-14 * (v + y * t)
    assert kind == TURN or move == way * gap


def test_full_swing_takes_half_a_ringing_period() -> None:
    assert glide_time(0.0, 2.0, 4.0) == pi / 2.0


@given(
    v=st.one_of(st.just(0.0), st.floats(1e-12, 2.0)),
    y=st.one_of(st.floats(-2.0, -1e-12), st.just(0.0), st.floats(1e-12, 2.0)),
    alpha=st.floats(1e-6, 5.0),
    beta=st.sampled_from([0.0, 1e-6, 0.5, 3.0]),
)
def test_damped_step_ends_where_its_time_says(v: float, y: float, alpha: float, beta: float) -> None:
    if v == 0.0 and y <= 0.0:
        y = 0.5 - y
    kind, move, after, t = damped_step(v, y, 1.0, 0.7, alpha, beta)
    if kind == ENDS:
        assert 0.0 <= move <= 0.7
        return
    s, g, f = hold_coefficients(alpha, beta, t)
    scale = abs(s * v) + abs(g * y)
    assert abs(s * v + g * y - move) <= 1e-14 * scale
    if kind == EDGE:
        assert move == 0.7
        assert after >= 0.0
        assert abs(f * v + s * y - after) <= 1e-14 * (v + abs(s * y))
    else:
        assert 0.0 <= move < 0.7
        assert abs(f * v + s * y) <= 1e-14 * (v + abs(y) * t)


def test_crossing_near_the_turning_point_stays_inside_its_bracket() -> None:
    """The edge lies 1e-14 of the way before the turning point, where the velocity all but vanishes."""
    v, y, alpha = 1.0, -1.0, 1e-3
    t = damped_step(v, y, 1.0, 1e9, alpha, 0.0)[3]
    s, g, _ = hold_coefficients(alpha, 0.0, t)
    gap = (s * v + g * y) * (1.0 - 1e-14)
    found = crossing_time(v, y, gap, alpha, 0.0, t)
    assert 0.0 < found <= t
    s, g, _ = hold_coefficients(alpha, 0.0, found)
    assert abs(s * v + g * y - gap) <= 4e-16


@pytest.mark.parametrize(
    ("alpha", "beta", "v", "y"),
    [(2.0, 0.0, 0.7429504449270792, -1.2508910964574058), (0.3, 0.5, 1.743914583216416, -1.4908622189372815)],
)
def test_an_edge_at_the_turning_point_is_passed_at_no_speed_backwards(
    alpha: float, beta: float, v: float, y: float
) -> None:
    """There the speed is 0; by the plant's coefficients it is a rounding below."""
    kind, gap, _, _ = damped_step(v, y, 1.0, 1e9, alpha, beta)
    assert kind == TURN
    kind, move, after, t = damped_step(v, y, 1.0, gap, alpha, beta)
    s, _, f = hold_coefficients(alpha, beta, t)
    assert -1e-15 < f * v + s * y < 0.0
    assert (kind, move, after) == (EDGE, gap, 0.0)


def test_a_goal_is_stopped_at_in_its_own_piece() -> None:
    """Before the edge; and also where it is the turning point."""
    ended = move_on(0.0, 0.0, 1.0, 0.0, -1.0, 0.5, BALL)  # half a count under 0.5
    assert ended == (EDGE, 0.0, 0.0, 0.5, -sqrt(0.5), pytest.approx(sqrt(2.0)))
    # From the edge at -1, in the first count with an acceleration of -0.5: 1 upwards is 1 count, to the edge at 0.
    pushed = BALL._replace(gamma=1.5)
    assert move_on(1.0, -1.0, 0.0, 1.0, 1.0, inf, pushed) == (EDGE, 0.0, 0.0, 0.0, 0.0, 2.0)
    assert move_on(1.0, -1.0, 0.0, 0.5, 1.0, -0.75, pushed) == (EDGE, 1.0, -1.0, 0.25, 0.0, 1.0)
    rubbed = pushed._replace(alpha=1e-3)
    kind, move, _, _ = damped_step(0.5, -0.5, 1.0, inf, 1e-3, 0.0)
    assert kind == TURN
    found = move_on(1.0, -1.0, 0.0, 0.5, 1.0, -1.0 + move, rubbed)
    assert found[1:3] == (1.0, -1.0)
    assert found[3] == pytest.approx(move, rel=1e-15)
    # Drawn out by 1, on a spring of 1, so damped that it never swings: it creeps to 1, and no further.
    creeps = BALL._replace(alpha=3.0, beta=1.0, gamma=-1.0)
    assert move_on(0.0, 0.0, 2.0, 0.0, -1.0, 1.0, creeps) == (ENDS, 0.0, 0.0, 1.0, 0.0, inf)


@pytest.mark.parametrize(
    ("x", "v", "wanted"),
    [
        (0.0, 0.0, (0.0, 0.0, 0.0)),
        (0.0, -1.0, (1.0, 0.0, 0.0)),
        (-1.0, 1.0, (1.0, -1.0, 0.0)),
        (-1.0, -1.0, (2.0, -1.0, 0.0)),
        (-0.25, 1.0, (1.0, 0.0, -0.25)),
        (-2.75, 0.0, (3.0, -3.0, 0.25)),
        (5.5, -1.0, (0.0, 0.0, 5.5)),
    ],
)
def test_place(x: float, v: float, wanted: tuple[float, float, float]) -> None:
    assert place(x, v, BALL) == wanted


def test_grazing_an_edge_by_one_rounding_keeps_the_piece() -> None:
    """Launched from the edge at 0 towards the one at -1: the speed that just reaches it, and its neighbours."""
    loop = BALL._replace(gamma=0.25)
    just = sqrt(2.0 * 0.75)
    for ulps in range(-3, 4):
        v = -just * (1.0 + ulps * 2.0**-52)
        n, edge, u, way = 1.0, 0.0, 0.0, -1.0
        seen = []
        for _ in range(6):
            kind, n, edge, u, v, _ = move_on(n, edge, u, v, way, inf, loop)
            if v == 0.0:
                n, way = heading(n, edge, u, loop)
            seen.append((kind, n))
            assert 0.0 - n <= edge + u <= 1.0 - n or n == 0.0
            if n == 0.0:
                break
        assert len(seen) <= 4
        assert n == 0.0
        assert abs(v - just) <= 1e-15


def test_turning_exactly_on_an_edge() -> None:
    """v^2 = 2 y gap in whole numbers: the knob has no speed left on the edge, and is pushed back."""
    loop = BALL._replace(kappa=1.0, gamma=0.5)
    kind, n, edge, u, v, t = move_on(1.0, 0.0, 0.0, -1.0, -1.0, inf, loop)
    assert (kind, n, edge, u, v, t) == (EDGE, 2.0, -1.0, 0.0, 0.0, 2.0)
    assert heading(n, edge, u, loop) == (1.0, 1.0)


def test_heading_on_an_edge() -> None:
    between = BALL._replace(gamma=1.5)  # pieces 1 and 2 push -0.5 and +0.5
    assert heading(1.0, -1.0, 0.0, between) == (1.0, 0.0)
    assert heading(0.0, 0.0, 0.0, between) == (1.0, -1.0)
    assert heading(2.0, -2.0, 0.0, between) == (2.0, 1.0)
    held = between._replace(gamma=2.4, phi=0.5)
    assert heading(1.0, -1.0, 0.0, held) == (1.0, 0.0)  # -1.4 above, -0.4 below, which friction holds
    assert heading(1.0, -1.0, 0.0, held._replace(phi=0.3)) == (2.0, -1.0)
    assert heading(2.0, -1.0, 0.0, held._replace(gamma=0.6)) == (2.0, 0.0)  # 0.4 above, which friction holds
    assert heading(2.0, -1.5, 0.0, held)[1] == 0.0
    assert heading(1.0, -0.5, 0.2, held)[1] == -1.0


@given(
    beta=st.sampled_from([0.0, 0.2, 1.0]),
    gamma=st.floats(0.0, 6.0),
    phi=st.sampled_from([0.0, 0.01, 0.4, 2.0]),
    offset=st.sampled_from([0.0, 0.25]),
    counted=st.sampled_from([0.0, 1.0]),
    kappa=st.sampled_from([0.0, 1.0]),
    x=st.floats(-12.0, 12.0),
)
def test_rest_range_is_where_a_still_knob_stays(
    beta: float, gamma: float, phi: float, offset: float, counted: float, kappa: float, x: float
) -> None:
    loop = Unsampled(0.3, beta, kappa, gamma, phi, offset, counted)
    low, high = rest_range(loop)
    near = 1e-9
    n, edge, u = place(x, 0.0, loop)
    way = heading(n, edge, u, loop)[1]
    if low + near < x < high - near:
        assert way == 0.0
    if x > high + near:
        assert way == -1.0
    if x < low - near:
        assert way == 1.0


@given(gamma=st.floats(0.0, 6.0), beta=st.sampled_from([0.0, 0.3]), counted=st.sampled_from([0.0, 1.0]))
def test_potential_is_least_at_the_rest_point(gamma: float, beta: float, counted: float) -> None:
    loop = Unsampled(0.0, beta, 1.0, gamma, 0.0, 0.25, counted)
    low, _ = rest_range(loop)
    least = potential(low, loop)
    for step in (-1.5, -0.5, -1e-3, 1e-3, 0.5, 1.5):
        assert potential(low + step, loop) >= least - 1e-14 * (1.0 + abs(least))


def test_an_edge_at_the_end_of_a_swing_is_reached_although_its_energy_rounds_below() -> None:
    """From rest it swings to twice its middle; some such ends are short of the energy by a rounding."""
    below = 0
    for k in range(1, 400):
        y, beta = k / 397.0, 0.75 + k / 1999.0
        gap, latest = 2.0 * y / beta, pi / sqrt(beta)
        below += gap * (2.0 * y - beta * gap) < 0.0
        assert 0.0 < crossing_time(0.0, y, gap, 0.0, beta, latest) <= latest * (1.0 + 1e-15)
    assert below > 10
