"""The crossing of the Nyquist curve with the turned inverse of the describing function."""

import cmath
from math import pi

import numpy as np
import pytest

from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.theory.relay import crossing, plant_curve
from tests.conftest import loaded


@pytest.mark.parametrize("rate_hz", [100.0, 1000.0, 10000.0])
def test_the_crossing_is_on_the_curve_and_on_the_ray(rate_hz: float) -> None:
    scene = loaded().scene
    knob = sample_knob(scene, sample_rate_hz=rate_hz, counts_per_rev=1024)
    found = crossing(knob)
    assert found is not None
    inertia, damping = scene.knob.inertia + scene.hand.inertia, scene.hand.damping
    direct = 1.0 / (scene.hand.stiffness - inertia * found.omega**2 + 1j * damping * found.omega)
    assert found.point == pytest.approx(direct, rel=1e-9)
    assert complex(plant_curve(knob, np.array([found.omega]))[0]) == pytest.approx(direct, rel=1e-9)
    # Half a sample of delay turns the negative real axis counter-clockwise, in the plane where G's phase is negative.
    assert cmath.phase(-found.point) == pytest.approx(0.5 * found.omega / rate_hz, rel=1e-9)
    assert found.frequency_hz == pytest.approx(found.omega / (2.0 * pi))


def test_the_amplitude_is_that_of_a_relay_of_half_a_counts_torque() -> None:
    scene = loaded().scene
    found = crossing(sample_knob(scene, sample_rate_hz=1000.0, counts_per_rev=1024))
    assert found is not None
    level = 0.5 * scene.wall.stiffness * 2.0 * pi / 1024
    assert found.amplitude_rad == pytest.approx(4.0 * level / pi * abs(found.point), rel=1e-9)
