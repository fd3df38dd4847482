"""Smoothing and differentiation: no phase, gain within the bound that the docstring states, exact for polynomials."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.identify.motion import CUTOFF, ORDER, differentiate, low_pass, smooth

RATE = 10_000.0
MIDDLE = slice(500, -500)


def bound(frequency_hz: float, factor: int) -> float:
    """Share of its amplitude that a sine may lose: 1 - 1/(1 + x^(2 order)) <= x^(2 order), and the spline's error."""
    filtered = (frequency_hz / (CUTOFF * RATE / (2 * factor))) ** (2 * ORDER)
    return filtered + 5.0 / 384.0 * (2.0 * np.pi * frequency_hz * factor / RATE) ** 4


@pytest.mark.parametrize("factor", [2, 5, 10, 20])
@pytest.mark.parametrize("frequency", [5.0, 20.0, 60.0, 100.0])
def test_a_sine_keeps_phase_and_amplitude(frequency: float, factor: int) -> None:
    time = np.arange(4000) / RATE
    given, wave = (np.cos(2.0 * np.pi * frequency * time + 0.3), np.exp(2j * np.pi * frequency * time))
    kept = smooth(given, factor)[MIDDLE]
    limit = bound(frequency, factor)
    assert np.abs(kept - given[MIDDLE]).max() <= limit + 1e-9
    basis = np.stack([wave.real, wave.imag], axis=1)[MIDDLE]
    real, imaginary = np.linalg.lstsq(basis, kept, rcond=None)[0]
    # What the spline adds at other frequencies is within its bound; the phase of the rest is exact.
    assert abs(np.arctan2(-imaginary, real) - 0.3) <= 1e-3 * limit + 1e-9
    assert abs(np.hypot(real, imaginary) - 1.0) <= limit + 1e-9


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_polynomials_pass_unchanged(degree: int) -> None:
    time = np.linspace(-1.0, 1.0, 3000)
    assert smooth(time**degree, 10)[MIDDLE] == pytest.approx((time**degree)[MIDDLE], abs=1e-11)


def test_what_decimation_would_fold_is_taken_out() -> None:
    fast = np.sin(2.0 * np.pi * 1500.0 * np.arange(3000) / RATE)
    assert np.abs(low_pass(fast, 10)[MIDDLE]).max() <= (400.0 / 1500.0) ** 8 * 1.2


def test_factor_one_is_no_smoothing() -> None:
    signal = np.random.default_rng(1).normal(size=50)
    assert smooth(signal, 1) is signal
    assert low_pass(signal, 1) is signal


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-5, 5), st.integers(3, 40), st.floats(1e-4, 1.0))
def test_differences_are_exact_for_quadratics(a: float, b: float, c: float, count: int, dt: float) -> None:
    time = dt * np.arange(count)
    rate = differentiate(a * time**2 + b * time + c, dt)
    # Rounding: a few units in the last place of the values, over the interval.
    slack = 1e-14 * (abs(a) * time[-1] ** 2 + abs(b) * time[-1] + abs(c) + 1e-300) / dt
    assert np.abs(rate - (2.0 * a * time + b)).max() <= slack + 1e-300
    assert np.abs(differentiate(rate, dt) - 2.0 * a).max() <= 4.0 * slack / dt + 1e-14 * abs(a)
