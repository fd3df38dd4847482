"""How far the likelihood lets a quantity go: straight, bent, flat and twofold valleys of known shape."""

from math import exp, inf, sqrt

import numpy as np
import pytest

from hknob_cli.identify.motion import Motion
from hknob_cli.identify.nearest import NEARLY, RISE, Minimum, Nearest, cost, nearest, spread

COUNT, NOISE = 400, 1e-3
TORQUE = np.concatenate([np.zeros(10), np.ones(COUNT - 10)])
WAVES = np.stack([np.sin(2.0 * np.pi * k * np.arange(COUNT) / COUNT) for k in (3, 7)])


def fitted(shape, slope, at: float, others: tuple[float, ...] = ()) -> Nearest:
    """Of an angle that is ``shape`` (2,) of the logarithm times two orthogonal waves, seen through white noise."""

    def answer(p):
        return shape(p[0]) @ WAVES, (slope(p[0]) @ WAVES)[:, None]

    angle = shape(at) @ WAVES + NOISE * np.random.default_rng(1).normal(size=COUNT)

    def elsewhere(fit, begin):
        return [fit(begin), *(fit(np.array([other, 0.0])) for other in others)]

    return nearest(Motion(1e-3, TORQUE, angle), answer, np.array([at + 0.01]), elsewhere=elsewhere)


def itself(p):
    return float(p[0]), np.array([1.0])


def test_of_a_straight_valley_it_is_the_standard_error() -> None:
    """A model linear in the value itself, known to 1 %: the profile adds what two steps of it may, and no more."""
    found = fitted(lambda p: np.array([exp(p), 0.0]), lambda p: np.array([exp(p), 0.0]), np.log(0.007))
    own = sqrt(found.covariance[0, 0])
    assert own <= spread(found, itself) <= own * (1.02 / sqrt(NEARLY)) ** 2 * 1.02


def test_of_a_flattening_valley_it_reaches_as_far_as_chance_does() -> None:
    """1 - exp(-8 p) saturates above p: at the upper limit the sum of squares has risen by the 3.84 of its noise."""
    scale = 0.001
    found = fitted(
        lambda p: scale * np.array([1.0 - exp(-8.0 * p), 0.0]),
        lambda p: scale * np.array([8.0 * exp(-8.0 * p), 0.0]),
        0.18,
    )
    own, share = sqrt(found.covariance[0, 0]), spread(found, itself)
    here = found.parameters[0]
    there = here + np.log1p(1.96 * share)
    moved = scale * (exp(-8.0 * here) - exp(-8.0 * there)) * np.linalg.norm(WAVES[0])
    assert share > 1.05 * own
    noise = cost(found) / (COUNT - 2)
    # The rest angle, also fitted, is orthogonal to the waves except for rounding: all that moves shows in the sum.
    assert moved**2 >= 0.999 * NEARLY * RISE * noise
    assert (
        moved**2 <= 1.5 * RISE * noise
    )  # a last step of 1.02/sqrt(0.25) at most, and the sandwich above the classical


def test_of_a_valley_without_an_end_it_is_endless() -> None:
    found = fitted(
        lambda p: 0.0015 * np.array([1.0 - exp(-8.0 * p), 0.0]),
        lambda p: 0.0015 * np.array([8.0 * exp(-8.0 * p), 0.0]),
        0.3,
    )
    assert sqrt(found.covariance[0, 0]) < 1.0
    assert spread(found, itself) == inf


@pytest.mark.parametrize(("apart", "told"), [(0.2, True), (1.5, False)])
def test_a_second_valley_that_is_as_deep_is_held(apart: float, told: bool) -> None:
    """(p - middle)^2 is the same on both sides of it."""
    middle = 0.5
    found = fitted(
        lambda p: np.array([(p - middle) ** 2, 0.0]),
        lambda p: np.array([2.0 * (p - middle), 0.0]),
        middle + apart / 2,
        others=(middle - apart / 2,),
    )
    share = spread(found, itself)
    if told:
        assert 1.96 * share >= abs(exp(-apart) - 1.0)
        assert share < 1.0
    else:
        assert share == inf or 1.96 * share >= 1.0 - exp(-apart)


def test_nothing_is_told_where_the_derivatives_tell_nothing() -> None:
    found = fitted(lambda p: np.array([exp(p), 0.0]), lambda p: np.array([exp(p), 0.0]), -5.0)
    blind = found._replace(slopes=np.zeros_like(found.slopes), covariance=np.full((1, 1), np.nan))
    assert spread(blind, itself) == inf
    assert isinstance(found.others[0], Minimum)
