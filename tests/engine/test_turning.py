"""When a velocity vanishes within a hold: by hand, and against the motion in 60 digits."""

from math import inf, log, nextafter, pi, sqrt
from random import Random

import mpmath
import pytest

from hknob_cli.engine.turning import first_zero, zero_spacing


@pytest.mark.parametrize("size", [1.0, 2.0**-40, 2.0**40])
def test_a_ringing_motion_turns_once_in_half_a_period(size: float) -> None:
    """Of a spring of 4 at 2 a sample: tan 2 t = -2 v / y. A damper of 2 beside one of 5 rings as fast: y less v."""
    for v, y, time in (
        (1.0, 2.0, 0.75 * pi / 2.0),
        (1.0, -2.0, 0.25 * pi / 2.0),
        (-1.0, 2.0, 0.25 * pi / 2.0),
        (-1.0, -2.0, 0.75 * pi / 2.0),
        (1.0, 0.0, 0.5 * pi / 2.0),
        (-1.0, 0.0, 0.5 * pi / 2.0),
        (0.0, 2.0, pi / 2.0),  # that at the start does not count
        (0.0, -2.0, pi / 2.0),
    ):
        assert first_zero(size * v, size * y, 0.0, 4.0) == pytest.approx(time, rel=1e-15)
        assert first_zero(size * v, size * (y + v), 2.0, 5.0) == pytest.approx(time, rel=1e-15)
    assert first_zero(size, size * 2.0, 0.0, 1.0) == pytest.approx(pi + mpmath.atan(-0.5), rel=1e-15)


@pytest.mark.parametrize("size", [1.0, 2.0**-40, 2.0**40])
def test_a_creeping_motion_turns_once_or_never(size: float) -> None:
    """A damper of 5/2 and a spring of 1: exponents of -1/2 and -2, that is -5/4 and 3/4 to either side."""
    for v, rate, time in (
        (1.0, -2.0, log(1.375 / 0.625) / 1.5),
        (-1.0, 2.0, log(1.375 / 0.625) / 1.5),
        (1.0, -0.75, inf),  # just never
        (1.0, -0.5, inf),
        (1.0, 2.0, inf),
        (1.0, 0.0, inf),
        (-1.0, 0.0, inf),
        (0.0, 2.0, inf),
        (0.0, -2.0, inf),
    ):
        assert first_zero(size * v, size * (rate + 1.25 * v), 2.5, 1.0) == pytest.approx(time, rel=1e-15)
    assert first_zero(1.0, 1.25 - nextafter(0.75, 1.0) - 2.0**-40, 2.5, 1.0) < inf
    # At the border: 1 - 2 t; and a damper alone, of 2, against which 1 is pulled by 1/2 more than it takes.
    assert first_zero(size, size * -1.0, 2.0, 1.0) == 0.5
    assert first_zero(size, size * 3.0, 2.0, 1.0) == inf
    assert first_zero(size, size * 1.0, 2.0, 1.0) == inf
    assert first_zero(0.0, size, 2.0, 1.0) == inf
    assert first_zero(size, size * -2.0, 2.0, 0.0) == pytest.approx(0.5 * log(2.0), rel=1e-15)


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 3.0), (1.0, 0.3), (1.0, 0.2), (3.0, 0.0), (0.1, 40.0), (30.0, 7.0)])
def test_the_first_zero_is_one_of_the_motion(alpha: float, beta: float) -> None:
    """Zero to the rounding of its arguments, and of one sign before; where there is none, of one sign for long."""
    chance, found = Random(f"{alpha} {beta}"), 0
    with mpmath.workdps(60):
        a, b = mpmath.mpf(alpha) / 2, mpmath.mpf(beta)
        root = mpmath.sqrt(a * a - b + mpmath.mpc(0))  # imaginary where it rings

        def speed(v: float, y: float, t: float) -> mpmath.mpf:
            rate = mpmath.mpf(y) - a * v
            return mpmath.re(mpmath.exp(-a * t) * (v * mpmath.cosh(root * t) + rate * mpmath.sinh(root * t) / root))

        for _ in range(30):
            v, y = chance.gauss(0.0, 1.0), chance.gauss(0.0, 1.0) * 10.0 ** chance.uniform(-2.0, 2.0)
            t = first_zero(v, y, alpha, beta)
            end = t if t < inf else 40.0 / (1.0 + alpha)
            signs = {mpmath.sign(speed(v, y, end * k / 40.0)) for k in range(1, 40)}
            assert signs == {mpmath.sign(v)}
            if t < inf:
                found += 1
                bend = abs(y - alpha * v) + abs(v) * (alpha + sqrt(beta)) + abs(y)
                assert abs(speed(v, y, t)) <= 2.0**-48 * bend * (t + 1.0 / (alpha + sqrt(beta)))
    assert found >= 10


@pytest.mark.parametrize(("alpha", "beta"), [(0.1, 1.0), (3.0, 1.0), (2.0, 1.0), (2.5, 0.0)])
@pytest.mark.parametrize("v", [5e-324, -5e-324])
def test_a_speed_whose_quotients_underflow_stops_at_once(alpha: float, beta: float, v: float) -> None:
    """It is no standstill: slowed, it ends now; driven, it turns when one that leaves a standstill does."""
    slowing = -3.0 if v > 0.0 else 3.0
    assert first_zero(v, slowing, alpha, beta) == 0.0
    assert first_zero(v, -slowing, alpha, beta) == first_zero(0.0, -slowing, alpha, beta)


def test_zeros_are_half_a_period_apart() -> None:
    """Where it rings at all."""
    for alpha, beta, apart in (
        (0.0, 4.0, pi / 2.0),
        (2.0, 5.0, pi / 2.0),
        (2.0, 1.0, inf),
        (2.5, 1.0, inf),
        (0.0, 0.0, inf),
        (2.0, 1.25, pi / 0.5),
    ):
        assert zero_spacing(alpha, beta) == apart
