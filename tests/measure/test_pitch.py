"""The pitch of a recorded buzz: maxima of the angle, or rises of the torque where the encoder misses maxima."""

from math import pi

import pytest

from hknob_cli.measure.pitch import pitch_hz

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
