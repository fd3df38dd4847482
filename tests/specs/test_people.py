"""People drawn at random: their moments, correlations and order, each within what a sample of that size allows."""

from math import log, sqrt

import numpy as np
import pytest
from scipy.linalg import sqrtm

from hknob_cli.specs.find_people import Spread, draw, spread_of

MEANS, STDS = (1.3e-7, 3.45e-4, 0.04), (0.5e-7, 0.647e-4, 0.01)
CORRELATIONS = ((1.0, -0.4, 0.3), (-0.4, 1.0, 0.6), (0.3, 0.6, 1.0))
MANY = 40_000


def test_logarithms_have_the_moments_of_the_lognormal() -> None:
    """Standard errors of a mean and of a standard deviation of n normals: s / sqrt(n), s / sqrt(2 n); five of them."""
    logs = np.log(np.array(draw(Spread(MEANS, STDS), people=MANY, seed=3)))
    for column, mean, std in zip(logs.T, MEANS, STDS, strict=True):
        variance = log(1.0 + (std / mean) ** 2)
        assert abs(column.mean() - (log(mean) - 0.5 * variance)) < 5.0 * sqrt(variance / MANY)
        assert abs(column.std() - sqrt(variance)) < 5.0 * sqrt(variance / (2.0 * MANY))


@pytest.mark.parametrize("correlations", [None, CORRELATIONS])
def test_the_numbers_themselves_have_means_deviations_and_correlations(correlations) -> None:
    hands = np.array(draw(Spread(MEANS, STDS, correlations), people=MANY, seed=4))
    assert np.all(hands > 0.0)
    error = np.array(STDS) / sqrt(MANY)
    assert np.all(abs(hands.mean(axis=0) - MEANS) < 5.0 * error)
    # The variance of a sample variance has the fourth moment in it, at most some 6 times a normal's here.
    assert np.all(abs(hands.std(axis=0) / STDS - 1.0) < 5.0 * sqrt(6.0 / (2.0 * MANY)))
    wanted = np.eye(3) if correlations is None else np.array(correlations)
    assert np.all(abs(np.corrcoef(hands.T) - wanted) < 5.0 * sqrt(6.0 / MANY))


def test_a_seed_is_the_same_people_and_more_people_begin_with_them() -> None:
    spread = Spread(MEANS, STDS, CORRELATIONS)
    few = draw(spread, people=20, seed=1)
    assert few == draw(spread, people=20, seed=1)
    assert few == draw(spread, people=500, seed=1)[:20]
    assert few != draw(spread, people=20, seed=2)


def test_logarithms_are_normals_times_a_symmetric_root_of_their_covariance() -> None:
    """By SciPy's root of a matrix; the numbers of a seed are those of any release."""
    spread = Spread(MEANS, STDS, CORRELATIONS)
    variation = np.array(STDS) / np.array(MEANS)
    covariance = np.log1p(np.array(CORRELATIONS) * np.outer(variation, variation))
    normals = np.random.default_rng(7).standard_normal((20, 3)) @ sqrtm(covariance)
    wanted = np.array(MEANS) * np.exp(normals - 0.5 * np.diag(covariance))
    np.testing.assert_allclose(draw(spread, people=20, seed=7), wanted, rtol=1e-12)


def test_spread_of_hands_is_that_of_the_sample() -> None:
    hands = [(1.0, 2.0, 4.0), (2.0, 2.0, 3.0), (3.0, 2.0, 2.0)]
    spread = spread_of(hands)
    assert spread.means == (2.0, 2.0, 3.0)
    assert spread.stds == (1.0, 0.0, 1.0)
    assert spread.correlations == ((1.0, 0.0, -1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 1.0))


def test_what_cannot_be_is_drawn_as_near_as_can_be() -> None:
    """Two hands alone are perfectly correlated; three cannot all be opposite to one another."""
    two = np.array(draw(spread_of([(1e-7, 3e-4, 0.03), (2e-7, 4e-4, 0.05)]), people=MANY, seed=5))
    assert np.corrcoef(np.log(two).T)[0, 2] == pytest.approx(1.0, abs=1e-3)
    opposite = tuple(tuple(1.0 if i == j else -0.9 for j in range(3)) for i in range(3))
    hands = np.array(draw(Spread(MEANS, STDS, opposite), people=MANY, seed=6))
    assert np.all(abs(hands.mean(axis=0) - MEANS) < 5.0 * np.array(STDS) / sqrt(MANY))
    constant = draw(Spread(MEANS, (0.0, 0.0, 0.0)), people=3, seed=7)
    assert np.allclose(constant, [MEANS] * 3, rtol=1e-12)


def test_opposite_numbers_that_vary_much_have_their_correlation() -> None:
    """Of logarithms ln(1 + r u v), by its standard error in a sample, sqrt((s t + c²) / n); five of them."""
    opposite = ((1.0, -0.15, 0.0), (-0.15, 1.0, 0.0), (0.0, 0.0, 1.0))
    logs = np.log(np.array(draw(Spread((1.0, 1.0, 1.0), (2.0, 2.0, 0.1), opposite), people=MANY, seed=8)))
    covariance, variance = log(1.0 - 0.15 * 4.0), log(5.0)
    found = float(np.cov(logs.T)[0, 1])
    assert abs(found - covariance) < 5.0 * sqrt((variance**2 + covariance**2) / MANY)
