"""Sliding under friction: many half cycles at once, one half cycle, and more than two states."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.advance import UNKNOWN
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.slide_many import slide_many
from hknob_cli.engine.general.slide_two import SERIES, coefficients, skip_turns, until_zero, way
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import zero_spacing

from .bodies import knob

EPS = 2.0**-52


def ringing(alpha: float, beta: float, friction: float) -> Body:
    """A second-order body of given numbers."""
    return knob().body._replace(
        alpha=alpha, beta=beta, friction=friction, spacing=zero_spacing(alpha, beta), drive=0.0, terms=0
    )


def turn_by_turn(x: float, free: float, turns: int, body: Body) -> tuple[float, float]:
    """Position and time after a number of half cycles, one after another."""
    time, v = 0.0, 0.0
    for _ in range(turns):
        mode = way(v, free - body.beta * x, body.friction)
        if mode == 0:
            break
        drive = free - mode * body.friction
        (s, g, _), t, _ = until_zero(x, v, drive, mode, 1e9, UNKNOWN, False, body)
        y = drive - body.beta * x
        x, v = x + (s * v + g * y), 0.0
        time += t
    return x, time


@given(
    alpha=st.floats(1e-6, 0.2),
    beta=st.floats(1.0, 100.0),
    part=st.floats(0.002, 0.3),
    away=st.floats(0.5, 50.0),
    free=st.floats(-5.0, 5.0),
    left=st.floats(10.0, 200.0),
)
@settings(max_examples=300, deadline=None)
def test_skipped_turns_are_those_taken_one_by_one(
    alpha: float, beta: float, part: float, away: float, free: float, left: float
) -> None:
    """One rounding of the largest swing for each turn, on either side, and a few in the closed form's terms."""
    body = ringing(alpha, beta, part * away * beta * 0.1)
    start = free / beta + away
    x, time = skip_turns(start, free, left, body)
    turns = round(time / body.spacing)
    assert time <= left
    expected, taken = turn_by_turn(start, free, turns, body)
    assert taken == pytest.approx(time, rel=1e-12)
    assert abs(x - expected) <= 64.0 * EPS * (turns + 4.0) * (abs(start) + abs(free / beta) + away)
    if turns > 0:
        assert way(0.0, free - beta * x, body.friction) != 0, "skipped past where friction stops the knob"


@given(
    alpha=st.floats(0.0, 3.0),
    beta=st.floats(0.0, 9.0),
    x=st.floats(-10.0, 10.0),
    v=st.floats(0.01, 10.0),
    drive=st.floats(-20.0, 20.0),
)
@settings(max_examples=300, deadline=None)
def test_slide_ends_where_the_velocity_vanishes(alpha: float, beta: float, x: float, v: float, drive: float) -> None:
    """At the end the velocity is zero to rounding; before, it has not been."""
    body, left = ringing(alpha, beta, 0.0), 1.0
    (s, _, f), t, ended = until_zero(x, v, drive, 1, left, hold_coefficients(alpha, beta, left), True, body)
    y = drive - beta * x
    size = v + abs(y) * max(t, 1e-3) + beta * abs(x)
    if ended:
        assert abs(f * v + s * y) <= 64.0 * EPS * size
    else:
        assert t == left
        assert f * v + s * y >= -64.0 * EPS * size
    for k in range(1, 20):
        s, _, f = hold_coefficients(alpha, beta, t * k / 20)
        assert f * v + s * y > 0.0


@given(x=st.floats(-3.0, 3.0), v=st.floats(-1.0, 1.0), u=st.floats(-0.5, 0.5))
@settings(max_examples=200, deadline=None)
def test_more_states_agree_with_two(x: float, v: float, u: float) -> None:
    """A lag whose torque is already the command's changes nothing: the third-order slide is the second-order one.

    Its end is found to the last bit of a sample period; the states add a rounding for each of its 53 steps.
    """
    two, three = knob().body, knob(actuator={"time_constant": 1e-3}).body
    assert (two.order, three.order) == (2, 3)
    mode = way(v, u + two.drive - two.beta * x, two.friction)
    if mode == 0:
        assert slide_many([x, 0.0, u], u, 0, 1.0, three, [0.0] * 6) == (1.0, False, 1)
        return
    drive = u + two.drive - mode * two.friction
    (s, g, f), t, ended = until_zero(x, v, drive, mode, 1.0, UNKNOWN, False, two)
    y = drive - two.beta * x
    z = [x, v, u]
    taken, over, _ = slide_many(z, u, mode, 1.0, three, [0.0] * 6)
    size = abs(x) + abs(v) + abs(y)
    assert z[2] == u
    assert z[0] == pytest.approx(x + s * v + g * y, rel=0, abs=200.0 * EPS * size)
    if ended == over:
        slope = abs(y - two.alpha * v) / 4.0  # speed lost per time, at least
        assert abs(taken - t) <= 200.0 * EPS * (1.0 + size / max(slope, EPS))
    else:
        assert min(1.0 - taken, 1.0 - t) <= 1e-9 or abs(f * v + s * y) <= 200.0 * EPS * size


@pytest.mark.parametrize(("alpha", "beta"), [(0.1, 1.0), (3.0, 1.0), (2.0, 1.0), (0.5, 0.0)])
def test_speed_too_small_for_the_formulas_ends_at_once(alpha: float, beta: float) -> None:
    """-v / rate underflows to 0, which must not be read as a standstill that leaves, half a ringing period long."""
    body = ringing(alpha, beta, 0.2)
    _, t, ended = until_zero(0.0, 5e-324, -0.2, 1, 1.0, UNKNOWN, False, body)
    assert 0.0 <= t <= 1e-322
    assert ended


def test_the_series_is_asked_for_one_sample_period_at_most() -> None:
    """Of a series that is S = 7 t, G = 7 t^2: it is seen where it is used. Without terms none is."""
    vectors = [0.0] * SERIES + [7.0, 7.0]
    one = knob().body._replace(alpha=0.5, beta=0.25, terms=1, vectors=vectors)
    for t in (0.25, 0.75, 1.0):
        s, g = 7.0 * t, 7.0 * t * t
        assert coefficients(t, one) == (s, g, 1.0 - 0.25 * g - 0.5 * s)
        assert coefficients(t, one._replace(terms=0)) == hold_coefficients(0.5, 0.25, t)
    for t in (1.0 + EPS, 1.5, 30.0, 1e15):
        assert coefficients(t, one) == hold_coefficients(0.5, 0.25, t)
