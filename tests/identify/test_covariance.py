"""The sandwich: its sums of windows are Bartlett's kernel, and its errors those of repeated fits."""

import numpy as np
import pytest

from hknob_cli.identify.fit import bandwidth, bread_of, cautious, classical, condition, sandwich


def test_the_sandwich_is_bartletts_weighted_sum() -> None:
    rng = np.random.default_rng(0)
    slopes = rng.normal(size=(200, 3))
    residuals = np.convolve(rng.normal(size=200), np.ones(6), mode="same")
    lags, bread = bandwidth(residuals), bread_of(slopes)
    leverage = np.diagonal(slopes @ bread @ slopes.T)
    scores = slopes * (residuals / (1.0 - leverage))[:, None]
    meat = scores.T @ scores
    for lag in range(1, lags + 1):
        pair = scores[lag:].T @ scores[:-lag]
        meat += (1.0 - lag / (lags + 1)) * (pair + pair.T)
    b = lags / 200
    wider = (1.96 + 2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    assert sandwich(slopes, residuals) == pytest.approx(bread @ meat @ bread * wider**2, rel=1e-9)


def test_the_bandwidth_is_five_correlation_times() -> None:
    """White: half a sample; AR(1) of 0.8: 0.5 + 0.8/0.2 = 4.5 samples."""
    rng = np.random.default_rng(0)
    white = rng.normal(size=20_000)
    slow = np.zeros_like(white)
    for i in range(1, len(slow)):
        slow[i] = 0.8 * slow[i - 1] + white[i]
    assert bandwidth(white) in (2, 3, 4)
    assert bandwidth(slow) == pytest.approx(22.5, abs=4)
    assert bandwidth(np.zeros(50)) == 0


def test_of_white_residuals_both_are_one() -> None:
    rng = np.random.default_rng(0)
    slopes, residuals = rng.normal(size=(50_000, 2)), rng.normal(size=50_000)
    both = [np.diagonal(of(slopes, residuals)) for of in (sandwich, classical, cautious)]
    assert both[0] == pytest.approx(both[1], rel=0.05)
    assert np.all(both[2] >= both[1] * (1.0 - 1e-12))


def test_what_cannot_be_told_apart_has_no_covariance() -> None:
    twin = np.ones((50, 2))
    assert condition(twin) > 1e15
    assert condition(np.zeros((5, 2))) == float("inf")
    assert np.all(np.isnan(bread_of(np.zeros((5, 2)))))
    assert np.all(np.isnan(sandwich(np.ones((2, 2)), np.ones(2))))
