"""Whiteness, variance accounted for, and the words of doubt."""

import numpy as np
import pytest

from hknob_cli.identify.fit import Estimate, doubts, misfit, vaf, whiteness
from hknob_cli.identify.motion import Motion, encoder_step, runs
from tests.identify.pulses import LIGHT, motion


def test_white_residuals_have_even_p_values() -> None:
    """400 values of an even distribution: the share below 0.05 has a standard deviation of 1.1 %."""
    rng = np.random.default_rng(0)
    found = [whiteness(rng.normal(size=300)) for _ in range(400)]
    assert 0.05 - 0.034 < np.mean(np.array(found) < 0.05) < 0.05 + 0.034
    assert 0.44 < np.mean(found) < 0.56


def test_slow_residuals_are_not_white() -> None:
    assert whiteness(np.sin(np.arange(300) / 10.0)) < 1e-10
    assert whiteness(np.zeros(300)) is None
    assert whiteness(np.ones(10)) is None


def test_vaf() -> None:
    wave = np.sin(np.arange(100.0))
    assert vaf(wave, wave) == 1.0
    assert vaf(wave, 0.0 * wave) == pytest.approx(0.0)
    assert vaf(wave, wave + 3.0) == pytest.approx(1.0)
    assert np.isnan(vaf(np.ones(5), np.ones(5)))
    assert np.isnan(vaf(wave, np.full(100, np.nan)))


def still(**known: float) -> Motion:
    return Motion(1e-4, np.ones(10), 0.1 * np.ones(10), **known)


def test_residuals_within_the_known_noise_are_no_misfit() -> None:
    noisy = still(noise_rad=1e-5)
    assert misfit(1e-9, 0.99, 1e-5, noisy) == ()
    assert misfit(0.5, 0.99, 1e-3, noisy) == ()
    (flag,) = misfit(1e-9, 0.99, 1e-4, noisy)
    assert flag == "the model does not fit: residuals are not white (p = 1e-09), 10.0 times the noise, VAF 99.00 %"
    (flag,) = misfit(1e-9, 0.99, 1e-4, still())
    assert flag == "the model does not fit: residuals are not white (p = 1e-09), VAF 99.00 %"


def test_residuals_that_averaging_leaves_are_no_misfit() -> None:
    """Trials that differ by 5 mrad of 100, one part in twenty, leave a part in four hundred of the motion."""
    mean = still(noise_rad=1e-5, averaged=3, scatter_rad=5e-3)
    assert mean.trials_differ == pytest.approx(0.05)
    assert misfit(1e-9, 0.99, 2.4e-4, mean) == ()
    assert misfit(1e-9, 0.99, 2.6e-4, mean) != ()


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((2e-6, 3e-3, 0.05), "overdamped (damping ratio 4.7)"),
        ((2e-6, 3e-3, 0.005), "ends before the slow return (600 ms)"),
        ((2e-6, 1e-6, 0.2), "hardly damped"),
        ((2e-6, 3e-4, -0.2), "stiffness came out negative"),
        ((1e-200, 1e-150, 1e-200), "overdamped (damping ratio 5e+49)"),  # their product is too small for a number
        ((2e-6, 3e-3, 1e-322), "ends before the slow return ("),
    ],
)
def test_doubts(values, words: str) -> None:
    names = ("inertia", "damping", "stiffness")
    estimates = {name: Estimate(value, 1e-3 * abs(value)) for name, value in zip(names, values, strict=True)}
    assert any(words in flag for flag in doubts(estimates, motion(LIGHT)))


def test_runs_of_equal_readings_are_one_observation() -> None:
    seen = runs(np.array([0.0, 0.0, 1.0, 1.0, 1.0, 0.0]))
    assert seen.take(np.arange(6.0)).tolist() == [0.5, 3.0, 5.0]
    assert seen.take(np.ones((6, 2))).shape == (3, 2)


def test_the_encoders_count_shows_in_its_readings() -> None:
    true = motion(LIGHT)
    step = 2.0 * np.pi / 4000
    counted = true._replace(angle_rad=np.floor(true.angle_rad / step) * step - 0.3)
    assert encoder_step(counted) == pytest.approx(step, rel=1e-9)
    thirds = sum(np.floor(true.angle_rad / step + phase) * step for phase in (0.1, 0.4, 0.8)) / 3.0
    assert encoder_step(true._replace(angle_rad=thirds, averaged=3)) == pytest.approx(step, rel=1e-9)
    assert encoder_step(true) == 0.0
