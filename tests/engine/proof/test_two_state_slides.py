"""Sliding of angle and speed under friction, by hand: a spring of 4, which turns the knob every half period of pi."""

from math import asin, cos, exp, inf, pi, sin, sqrt
from typing import Any

import pytest

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.slide_two import coefficients, skip_turns, step_with_friction, until_zero, way
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.general_knob import make_body
from hknob_cli.specs.scene import SceneSpec

SPRING = 4.0
TURN = 0.5 * pi  # from a turning point to the next


def body(alpha: float = 0.0, beta: float = SPRING, friction: float = 1.0, drive: float = 0.0) -> Body:
    """Of second order, in counts and samples."""
    scene = {
        "knob": {"inertia": 1.0, "damping": alpha, "coulomb_torque": friction},
        "hand": {"stiffness": beta},
        "wall": {"stiffness": 0.0},
    }
    plain = SceneSpec.model_validate(scene).plain()
    return make_body(plain, period=1.0, quantum=1.0, shift=0.0, split=0.0)[0]._replace(drive=drive)


def test_a_motion_slides_its_way_or_is_held() -> None:
    """At the very level of friction it is held."""
    for v, pull, mode in (
        (0.5, -9.0, 1), (-0.5, 9.0, -1), (0.0, 1.0, 0), (0.0, -1.0, 0), (0.0, 1.5, 1), (0.0, -1.5, -1), (0.0, 0.0, 0)
    ):  # fmt: skip
        assert way(v, pull, 1.0) == mode


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 0.0), (0.5, 0.25), (1e-6, 1e-9), (0.9, 0.01), (40.0, 9.0)])
def test_coefficients_are_those_of_a_hold(alpha: float, beta: float) -> None:
    """By the series where it converges quickly, which is not for a strong damper."""
    one = body(alpha, beta)
    assert (one.terms > 0) == (alpha < 1.0)
    for t in (1.0, 0.75, 0.125, 2.0**-30):
        assert coefficients(t, one) == pytest.approx(hold_coefficients(alpha, beta, t), rel=1e-14)
    known = body(0.5, 0.25)._replace(terms=0)
    assert coefficients(0.75, known) == hold_coefficients(0.5, 0.25, 0.75)


def told(x: float, v: float, drive: float, mode: int, left: float, *, known: bool = True) -> Any:
    one = body()
    given = hold_coefficients(one.alpha, one.beta, left) if known else (7.0, 7.0, 7.0)
    return until_zero(x, v, drive, mode, left, given, known, one)


def test_a_slide_lasts_until_its_speed_vanishes() -> None:
    """From a turning point half a period, at 2 counts and as much speed an eighth of the period; or the time left."""
    for mode in (1, -1):
        for x, v, part in ((-2.0, 0.0, 1.0), (2.0, 4.0, 0.25), (0.0, 4.0, 0.5), (-2.0, 4.0, 0.75)):
            time = part * TURN
            for known in (True, False):
                for left in (time + 1e-9, 2.0 * TURN, 9.0):
                    sgf, t, ended = told(mode * x, mode * v, 0.0, mode, left, known=known)
                    assert ended
                    assert t == pytest.approx(time, rel=1e-14)
                    assert sgf == pytest.approx(hold_coefficients(0.0, SPRING, t), rel=1e-12, abs=1e-15)
                for left in (time - 1e-9, 0.5 * time):
                    assert told(mode * x, mode * v, 0.0, mode, left, known=known) == (
                        hold_coefficients(0.0, SPRING, left), left, False,
                    )  # fmt: skip
    # Such a slow one that it stops at once, as far as numbers go.
    assert told(1.0, 5e-324, 0.0, 1, 1.0) == ((0.0, 0.0, 1.0), 0.0, True)
    assert told(-1.0, -5e-324, 0.0, -1, 1.0) == ((0.0, 0.0, 1.0), 0.0, True)
    assert told(1.0, 1e-200, 0.0, 1, 1.0)[1:] == (pytest.approx(2.5e-201), True)
    # And one that turns after all where it is longer than the distance of its zeros.
    assert told(-2.0, 0.0, 0.0, 1, 2.5 * TURN)[1:] == (pytest.approx(TURN), True)


def moved(x: float, v: float, u: float, span: float, one: Body) -> tuple[float, float]:
    return step_with_friction(x, v, u, span, *hold_coefficients(one.alpha, one.beta, span), one)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_swings_shrink_by_half_the_friction_each(side: float) -> None:
    """Friction of 1 on a spring of 4 shifts the middle by 1/4: from 2 to -3/2, 1, -1/2, and 0, where it is held."""
    for drive, u in ((0.0, 0.0), (3.0, -3.0), (0.0, 8.0 * side), (-2.0, 6.0)):
        one, rest = body(drive=drive), (u + drive) / SPRING
        for turns, x in enumerate((2.0, -1.5, 1.0, -0.5, 0.0, 0.0, 0.0)):
            place, speed = moved(rest + side * 2.0, 0.0, u, max(turns * TURN, 1e-12), one)
            assert place == pytest.approx(rest + side * x, abs=1e-11)
            assert speed == pytest.approx(0.0, abs=1e-10)
    # Between the turns it swings about the shifted middle: a quarter period after the first, and after the second.
    one = body()
    assert moved(side * 2.0, 0.0, 0.0, 0.5 * TURN, one) == pytest.approx((side * 0.25, side * -3.5))
    assert moved(side * 2.0, 0.0, 0.0, 1.5 * TURN, one) == pytest.approx((side * -0.25, side * 2.5))
    assert moved(side * 0.25, side * -3.5, 0.0, TURN, one) == pytest.approx((side * -0.25, side * 2.5))


def test_a_knob_that_is_held_stays() -> None:
    for x in (0.25, -0.25, 0.0):
        assert moved(x, 0.0, 0.0, 1.0, body()) == (x, 0.0)
        assert moved(x, 0.0, 4.0 - 8.0 * x, 9.0, body(friction=9.0)) == (x, 0.0)
    assert moved(0.2501, 0.0, 0.0, 1.0, body())[0] < 0.2501
    # It stops on the way, where friction then holds it: at rest from a speed of 1/2 on no spring.
    free = body(beta=0.0, friction=0.5)
    assert moved(3.0, 0.5, 0.0, 2.0, free) == (3.25, 0.0)
    assert moved(3.0, 0.5, 0.0, 0.5, free) == pytest.approx((3.0 + 0.25 - 0.0625, 0.25))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("turns", [12, 13, 20])
def test_many_turns_are_taken_at_once(turns: int, side: float) -> None:
    """All but the last two that fit, or that are left until it is held: each by half a count less, as one by one."""
    one = body()
    for x, left, taken in ((50.0, turns + 0.5, turns - 2), (0.25 + 0.5 * turns, 99.5, turns - 2)):
        place, time = skip_turns(3.0 + side * x, 12.0, left * TURN, one)
        assert time == pytest.approx(taken * TURN, rel=1e-14)
        assert place == pytest.approx(3.0 + side * (-1.0) ** taken * (x - 0.5 * taken), rel=1e-14)
        assert moved(3.0 + side * x, 0.0, 12.0, turns * TURN, one) == pytest.approx(
            (3.0 + side * (-1.0) ** turns * (x - 0.5 * turns), 0.0), abs=1e-9
        )
    assert skip_turns(50.0, 0.0, 2.9 * TURN, one) == (50.0, 0.0)
    assert skip_turns(50.0, 0.0, 3.1 * TURN, one)[1] == pytest.approx(TURN)
    assert skip_turns(-50.0, 0.0, inf, one)[1] == pytest.approx(97.0 * TURN)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_slide_that_goes_on_is_that_of_its_hold(side: float) -> None:
    """Friction of 1 against it, all along: an accelerated one, and such that slow down."""
    s, g, f = hold_coefficients(0.0, SPRING, 0.125)
    for friction in (1.0, 0.5):
        for x, v, u in ((0.125, 4.0, 0.0), (-0.25, 4.0, 0.0), (0.125, 0.5, 9.0), (0.0, 0.75, 0.0)):
            y = u - friction - SPRING * x
            place, speed = moved(side * x, side * v, side * u, 0.125, body(friction=friction))
            assert place == pytest.approx(side * (x + s * v + g * y), rel=1e-14)
            assert speed == pytest.approx(side * (f * v + s * y), rel=1e-14)
    # And shortly after a turn, from -3/2 about -1/4.
    angle = 0.02 * pi
    found = moved(side * 2.0, 0.0, 0.0, 1.02 * TURN, body())
    assert found == pytest.approx((side * (-0.25 - 1.25 * cos(angle)), side * 2.5 * sin(angle)))


@pytest.mark.parametrize("spring", [4.0, 1600.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_knob_is_held_for_good_where_its_spring_is_too_weak(spring: float, side: float) -> None:
    """From 1.9 to -1.4, 0.9, -0.4 and -0.1: however much time is left. From full speed through the middle, too."""
    one, turn = body(beta=spring, friction=0.25 * spring), pi / spring**0.5
    for turns in (4.0, 4.5, 5.0, 8.5, 20.0):
        place, speed = moved(side * 1.9, 0.0, 0.0, turns * turn, one)
        assert place == pytest.approx(side * -0.1 if turns > 4.0 else place, abs=1e-11)
        assert speed == 0.0 or turns == 4.0
    for turns in (9, 12, 13):
        expected = side * (-1.0) ** turns * (50.0 - 0.5 * turns), 0.0
        assert moved(side * 50.0, 0.0, 0.0, turns * turn, one) == pytest.approx(expected, abs=1e-8)
        for part in (0.5, 0.25):  # of the first turn
            begun = side * (0.25 + 49.75 * cos(pi * part)), -side * spring**0.5 * 49.75 * sin(pi * part)
            assert moved(*begun, 0.0, (turns - part) * turn, one) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turns_are_counted_from_the_first_not_from_the_begin(side: float) -> None:
    """At a speed of 1 the knob is a little short of its turning point at 49.75, which is 50 from the middle."""
    x = sqrt(50.0**2 - 0.25)
    first = 0.5 * asin(0.5 / 50.0)
    for turns in (9, 12):
        expected = side * (-1.0) ** turns * (49.75 - 0.5 * turns), 0.0
        found = moved(side * (x - 0.25), side, 0.0, first + turns * TURN, body())
        assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("alpha", "beta", "friction"), [(0.01, 4.0, 0.5), (0.2, 4.0, 0.01), (0.001, 1.0, 0.02)])
def test_damped_swings_are_counted_until_friction_holds_the_last(alpha: float, beta: float, friction: float) -> None:
    """One by one: a swing is what damping leaves, less what friction takes on both sides. Two are left over."""
    one = body(alpha, beta, friction)
    q, left = friction / beta, exp(-0.5 * alpha * one.spacing)
    for away in (20.0, 20.1, 20.2, 20.5, 33.0, 57.0):
        swings, swing = [], away
        while swing > q:
            swings.append(swing)
            swing = left * swing - (1.0 + left) * q
        taken = len(swings) - 1 - 2  # the first of the list is where it begins
        place, time = skip_turns(away, 0.0, inf, one)
        assert time == pytest.approx(taken * one.spacing, rel=1e-14)
        assert place == pytest.approx((-1.0) ** taken * swings[taken], rel=1e-9)
