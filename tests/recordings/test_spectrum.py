"""Harmonics of a recording against waves whose series is known in closed form.

The pitch of a recorded buzz: maxima of the angle, or rises of the torque where the encoder misses maxima.

Rises of the wall's torque, against pulses whose number is known.
"""

from math import pi

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.recordings.spectrum import pitch_hz, recorded_harmonics, torque_rises_hz

FINE = 640_000  # counts per revolution of the device's own encoder


@pytest.mark.parametrize(("own_counts", "pitch"), [(9.9, 200.0), (10.1, 100.0)])
def test_pitch_of_a_swing_too_small_to_see_is_that_of_the_torque(own_counts: float, pitch: float) -> None:
    p2p = own_counts * 2.0 * pi / FINE
    found = pitch_hz(p2p_rad=p2p, cycle_hz=100.0, torque_hz=200.0, native_counts=FINE, counts_per_rev=256)
    assert found == pitch


def test_a_coarse_encoder_of_the_device_leaves_only_maxima() -> None:
    """Where the wall sees counts nearly as fine as the device's own, a swing of ten of these crosses several."""
    found = pitch_hz(p2p_rad=1e-4, cycle_hz=100.0, torque_hz=200.0, native_counts=2048, counts_per_rev=512)
    assert found == 100.0


@pytest.mark.parametrize("cycle_s", [0.004, 0.0125])
def test_one_pulse_a_cycle(cycle_s: float) -> None:
    """Sampled at 4 kHz, the first and the last rise are each late by less than a sample."""
    time = np.arange(0.0, 1.0, 0.25e-3)
    torque = np.where((time + 1e-9) % cycle_s < 0.3 * cycle_s, 1e-3, 0.0)
    found = torque_rises_hz(time, torque)
    assert found == pytest.approx(1.0 / cycle_s, rel=2 * 0.25e-3 / 0.9)


def test_a_step_more_is_a_rise_more() -> None:
    time = np.arange(8.0)
    assert torque_rises_hz(time, np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0])) == pytest.approx(4.0 / 6.0)


@pytest.mark.parametrize("torque", [[0.0] * 5, [1.0] * 5, [0.0, 1.0, 1.0, 0.0, 0.0], [], [1.0]])
def test_fewer_than_two_rises_have_no_pitch(torque: list[float]) -> None:
    assert torque_rises_hz(np.arange(float(len(torque))), np.array(torque)) == 0.0


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
