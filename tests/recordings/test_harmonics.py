"""Harmonics of a recording against waves whose series is known in closed form."""

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.recordings.harmonics import recorded_harmonics


def test_a_triangle_of_speed_has_its_fourier_series() -> None:
    """v falls and rises straight between ±A: 8A/(pi k)^2 for odd k, nothing for even; whatever rows are between."""
    high, period = 0.3, 0.0125
    time = np.array([0.0, 0.2, 0.5, 0.51, 0.93, 1.0]) * period + 1.7
    speed = high * np.array([1.0, 0.2, -1.0, -0.96, 0.72, 1.0])
    found = recorded_harmonics(time, speed, highest_hz=2000.0)
    k = np.arange(1, 26)
    np.testing.assert_allclose(found.frequency_hz, k / period)
    expected = np.where(k % 2 == 1, 8.0 * high / (np.pi * k) ** 2, 0.0)
    # Slopes and times carry a few roundings of 1e-16, of terms of up to 4 high / (pi k)^2 times six rows.
    np.testing.assert_allclose(found.speed_rad_s, expected, rtol=0.0, atol=1e-12 * high)
    angle = (found.angle_rad * np.exp(2j * np.pi * np.outer([0.25], k))).real.sum(axis=1)
    # After a quarter the speed has been positive all the time: the angle is at its peak, A P / 8 above its mean. What
    # is left out above 2 kHz is less than the sum of 4 A P / (pi k)^3 from k = 27 on, below 1e-4 A P.
    assert angle[0] == pytest.approx(high * period / 8.0, abs=1e-4 * high * period)


def test_a_jump_of_speed_between_two_rows_is_kept() -> None:
    """A pulse of one row: the strokes of a square wave, 4A/(pi k), as long as the pulse is short of the harmonic."""
    time = np.array([0.0, 0.5 - 1e-6, 0.5, 1.0 - 1e-6, 1.0])
    speed = np.array([1.0, 1.0, -1.0, -1.0, 1.0])
    found = recorded_harmonics(time, speed, highest_hz=9.0)
    # A stroke of 1e-6 of the period smooths the kth harmonic by (pi k 1e-6)^2 / 6, below 2e-10.
    expected = [4.0 / np.pi / k if k % 2 else 0.0 for k in range(1, 10)]
    np.testing.assert_allclose(found.speed_rad_s, expected, atol=2e-5)


@pytest.mark.parametrize("time", [[0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 2.0, 1.0]])
def test_what_is_no_period_is_refused(time: list[float]) -> None:
    with pytest.raises(UsageError, match="three rows or more, at times that increase"):
        recorded_harmonics(time, np.zeros(len(time)), highest_hz=10.0)
