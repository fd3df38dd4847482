"""The plant over one hold, against 150-digit arithmetic, from the undamped to the overdamped by 10^6 and beyond.

Verified: `hold_coefficients` (S, G, F of its module's docstring) against the partial fractions of the plant's response,
which share no formula with it and lose digits freely, having enough; these in turn against a matrix exponential.

The tolerance is that of a mixed forward-backward stable evaluation: the result may be off as if each of alpha, beta, t
and the result had been rounded a few times,

    |error| <= ROUNDINGS * u * (|f| + |alpha df/d alpha| + |beta df/d beta| + |t df/d t|),   u = 2^-53.

A formula of about ten operations, none of which cancels, cannot exceed ten. No evaluation in double precision can do
much better: where the condition number is large (an undamped plant that rings 10^4 times in a hold, an e^-500 left of a
motion) the digits are lost to the rounding of the inputs, and relative accuracy with them. Elsewhere, where the result
changes by at most 100 times the relative change of its inputs, 1e-13 relative is asked for.
"""

from math import inf, isfinite, nextafter
from typing import Any

import mpmath
import pytest

from hknob_cli.engine.propagator import hold_coefficients, slowest_rate

mp = mpmath.MPContext()
mp.dps = 150

TIMES = (1e-3, 0.3, 1.0, 7.0)
UNIT = mp.mpf(2) ** -53
ROUNDINGS = 10
UNDERFLOW = mp.mpf(2) ** -1000  # less is not asked for: doubles end at 2^-1074, and lose digits before
STEP = mp.mpf(10) ** -45  # relative; a difference quotient good to 45 digits
WELL_CONDITIONED, RELATIVE = 100, 1e-13

Point = tuple[float, float, float]  # alpha, beta, t


def partial_fractions(alpha: Any, beta: Any, t: Any) -> tuple[Any, Any, Any]:
    """S, G, F from the roots of s^2 + alpha s + beta."""
    if alpha == 0 and beta == 0:
        return t, t * t / 2, mp.mpf(1)
    if beta == 0:
        s = (1 - mp.exp(-alpha * t)) / alpha
        return s, (t - s) / alpha, mp.exp(-alpha * t)
    root = mp.sqrt(mp.mpc(alpha**2 - 4 * beta))
    if root == 0:
        a = alpha / 2
        decay = mp.exp(-a * t)
        return t * decay, (1 - decay * (1 + a * t)) / beta, decay * (1 - a * t)
    s1, s2 = (-alpha + root) / 2, (-alpha - root) / 2
    e1, e2 = mp.exp(s1 * t), mp.exp(s2 * t)
    return ((e1 - e2) / root).real, (((e1 - 1) / s1 - (e2 - 1) / s2) / root).real, ((s1 * e1 - s2 * e2) / root).real


def sensitivity(point: tuple[Any, ...], exact: tuple[Any, ...]) -> list[Any]:
    """Sum over alpha, beta, t of |p df/dp|, for each of S, G, F."""
    total = [mp.mpf(0)] * 3
    for i, value in enumerate(point):
        if value != 0:
            moved = partial_fractions(*(p * (1 + STEP) if i == j else p for j, p in enumerate(point)))
            total = [sum_ + abs(new - old) / STEP for sum_, new, old in zip(total, moved, exact, strict=True)]
    return total


def check(points: list[Point]) -> None:
    """Compare S, G and F at each point."""
    for point in points:
        wide = tuple(mp.mpf(value) for value in point)
        exact = partial_fractions(*wide)
        sensitive = sensitivity(wide, exact)
        for name, found, value, slope in zip("SGF", hold_coefficients(*point), exact, sensitive, strict=True):
            where = f"{name}(alpha={point[0]!r}, beta={point[1]!r}, t={point[2]!r}) = {found!r}"
            assert isfinite(found), where
            error = abs(mp.mpf(found) - value)
            units = error / (UNIT * (abs(value) + slope) + UNDERFLOW)
            assert units <= ROUNDINGS, f"{where}: {float(units):.3g} roundings off, {mp.nstr(value, 17)} expected"
            if slope <= WELL_CONDITIONED * abs(value):
                assert error <= RELATIVE * abs(value) + UNDERFLOW, f"{where}: {float(error / abs(value)):.3g} relative"


@pytest.mark.one_in(3)
@pytest.mark.parametrize("t", TIMES)
def test_log_grid(t: float) -> None:
    """Damping 0 and 1e-12 ... 1e12, stiffness 0 and 1e-20 ... 1e8, in decades."""
    alphas = [0.0, *(10.0**k for k in range(-12, 13))]
    betas = [0.0, *(10.0**k for k in range(-20, 9))]
    check([(alpha, beta, t) for alpha in alphas for beta in betas])


def test_far_corners() -> None:
    """Scenes like 1e6 N m/rad on 1e-12 kg m^2 at 1 Hz (the extreme scenes): up to 1e18."""
    sizes = [1e-18, 1e-9, 1.0, 1e9, 1e12, 1e15, 1e18]
    check([(alpha, beta, t) for alpha in [0.0, *sizes] for beta in [0.0, *sizes] for t in TIMES])


@pytest.mark.one_in(3)
@pytest.mark.parametrize("t", TIMES)
def test_near_critical_damping(t: float) -> None:
    """alpha^2 = 4 beta (1 +- 10^-k) and equality: where the two roots meet."""
    points = []
    for alpha in (10.0 ** (k / 2) for k in range(-24, 10)):
        points.append((alpha, 0.25 * alpha * alpha, t))
        points += [(alpha, 0.25 * alpha * alpha / (1.0 + sign * 10.0**-k), t) for k in range(1, 17) for sign in (1, -1)]
    check(points)


def test_where_the_series_ends() -> None:
    """Both sides of the borders between the series and the closed forms: alpha t/2 = 1/2 and beta t^2 = 1."""
    points = []
    for alpha in (nextafter(1.0, 0.0), 1.0, nextafter(1.0, inf)):
        points += [(alpha, beta, 1.0) for beta in (0.0, 1e-20, 1e-8, 0.1, 0.2499, 0.25, 0.2501, 0.5, 1.0, 1.001)]
    for beta in (nextafter(1.0, 0.0), 1.0, nextafter(1.0, inf)):
        points += [(alpha, beta, 1.0) for alpha in (0.0, 1e-12, 1e-3, 0.3, 0.9, 1.1, 1.9999, 2.0, 2.0001, 3.0)]
    check(points)


@pytest.mark.parametrize(
    ("alpha", "beta", "rate"),
    [
        (2.5, 1.0, 0.5),  # the other root is 2
        (5.0, 4.0, 1.0),
        (2.0, 1.0, 1.0),
        (0.5, 4.0, 0.25),
        (3.0, 0.0, 3.0),
        (0.0, 4.0, 0.0),
        (0.0, 0.0, 0.0),
        (1e8, 1.0, 1e-8 * (1.0 + 1e-16)),
        (2e-9, 1e-30, 5e-22 * (1.0 + 2.5e-13)),
    ],
)
def test_the_slowest_rate_is_that_of_the_smaller_root(alpha: float, beta: float, rate: float) -> None:
    """Of what decays: without a spring the velocity alone. It is as good where the other root is far away."""
    assert slowest_rate(alpha, beta) == pytest.approx(rate, rel=1e-15)


def test_partial_fractions_are_the_matrix_exponential() -> None:
    """The reference itself: exp([[0, 1, 0], [-beta, -alpha, 1], [0, 0, 0]] t) holds S, G and F."""
    for alpha in (0.0, 1e-6, 0.3, 2.0, 40.0):
        for beta in (0.0, 1e-9, 0.0225, 1.0, 300.0):
            for t in TIMES:
                e = mp.expm(mp.matrix([[0, 1, 0], [-mp.mpf(beta), -mp.mpf(alpha), 1], [0, 0, 0]]) * mp.mpf(t))
                exact = partial_fractions(mp.mpf(alpha), mp.mpf(beta), mp.mpf(t))
                for found, value in zip((e[0, 1], e[0, 2], e[1, 1]), exact, strict=True):
                    assert abs(found - value) <= mp.mpf(10) ** -60 * (1 + abs(value)), (alpha, beta, t)
