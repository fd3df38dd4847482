"""Bounce peaks against the motion in closed form, hold by hold in SI units; the fit against sums by hand."""

from math import atan2, cos, floor, isnan, sin, sqrt, tau
from typing import Any

import numpy as np
import pytest

from hknob_cli.measure.growth import Peaks, bounce_peaks, energy_growth, parabola
from tests.measure.test_growth import G, J, K, sampled

HAND = 0.02  # N m/rad
W = sqrt(HAND / J)


def peaks_by_hand(
    rate: float, counts: int, *, phase: float, duration: float, delay: int = 0, up: float = 0.0
) -> list[tuple[float, float]]:
    """Times and angles of the peaks outside the wall: of each hold the free motion about where its torques balance.

    ``phase``: when the first sample is, in sample periods; ``delay`` of the torque, in samples; ``up``: by which part
    of a count the encoder rounds up.
    """
    line = [0] * delay
    quantum, period = tau / counts, 1.0 / rate
    angle, speed, clock, span = 0.02, 0.0, 0.0, phase * period
    level, touched, found = 0, False, []
    while clock < duration:
        rest = (-G - K * quantum * level) / HAND
        size, turned = sqrt((angle - rest) ** 2 + (speed / W) ** 2), atan2(speed / W, angle - rest)
        at = turned / W if turned > 0.0 else (turned + tau) / W
        while touched and at <= span:
            if rest + size >= -up * quantum and clock + at <= duration:
                found.append((clock + at, rest + size))
            at += tau / W
        angle, speed = rest + size * cos(W * span - turned), -W * size * sin(W * span - turned)
        clock, span = clock + span, period
        line.append(min(0, floor(angle / quantum + up)))
        touched = touched or line[-1] < 0
        level = line.pop(0)
    return found


@pytest.mark.parametrize(("rate", "duration"), [(1000.0, 0.25), (60.0, 0.4), (2.0, 4.0)])
def test_peaks_are_those_of_the_motion_in_closed_form(rate: float, duration: float) -> None:
    """At 2 Hz the free motion turns often between two samples: more peaks than samples."""
    one = sampled(rate, 512, hand={"inertia": 3e-7, "stiffness": HAND})
    found = bounce_peaks(one, angle_rad=0.02, velocity_rad_s=0.0, phases=3, duration_s=duration)
    for phase, peaks in enumerate(found):
        wanted = peaks_by_hand(rate, 512, phase=(phase + 0.5) / 3, duration=duration)
        assert len(wanted) > 4
        assert peaks.time_s == pytest.approx([time for time, _ in wanted], rel=1e-7)
        assert peaks.angle_rad == pytest.approx([angle for _, angle in wanted], rel=1e-6)
    if rate < W / tau:
        assert all(len(one.time_s) > rate * duration + 2 for one in found)


@pytest.mark.parametrize(
    ("parts", "delay", "up"),
    [({"actuator": {"delay_samples": 2}}, 2, 0.0), ({"encoder": {"rounding": "nearest"}}, 0, 0.5)],
)
def test_peaks_of_a_late_torque_and_of_counts_that_are_rounded(parts: dict[str, Any], delay: int, up: float) -> None:
    one = sampled(1000.0, 512, hand={"inertia": 3e-7, "stiffness": HAND}, **parts)
    (found,) = bounce_peaks(one, angle_rad=0.02, velocity_rad_s=0.0, phases=1, duration_s=0.25)
    wanted = peaks_by_hand(1000.0, 512, phase=0.5, duration=0.25, delay=delay, up=up)
    assert len(wanted) > 4
    assert found.time_s == pytest.approx([time for time, _ in wanted], rel=1e-7)
    assert found.angle_rad == pytest.approx([angle for _, angle in wanted], rel=1e-6)


def trial(time: list[float], energy: list[float]) -> Peaks:
    return Peaks(np.array(time), np.zeros(len(time)), np.array(energy))


def test_the_residual_is_what_the_parabola_leaves() -> None:
    """A pattern that no parabola over four even times has a part of is left whole."""
    time = [10.0, 11.0, 12.0, 13.0]
    left = [-1e-5, 3e-5, -3e-5, 1e-5]
    energy = [1e-3 * (0.02 + 0.03 * t + 0.05 * t * t) + one for t, one in zip(time, left, strict=True)]
    plain = [one - another for one, another in zip(energy, left, strict=True)]
    found = energy_growth([trial(time, energy), trial(time, plain)])
    assert found.growth_j_per_s2 == pytest.approx(5e-5, rel=1e-9)
    assert found.growth_std_j_per_s2 == pytest.approx(0.0, abs=1e-12)
    share = sqrt(sum(one * one for one in left) / 4) / float(np.std(energy))
    assert found.residual == pytest.approx(0.5 * share, rel=1e-7)


def test_an_energy_that_stays_has_a_fit_and_no_residual() -> None:
    found = energy_growth([trial([1.0, 2.0, 3.0], [7.0] * 3)])
    assert (found.growth_j_per_s2, found.fits) == (0.0, 1)
    assert isnan(found.residual)
    none = energy_growth([])
    assert isnan(none.bounces)
    assert (none.fits, none.trials) == (0, 0)


def test_three_times_are_enough_for_a_parabola() -> None:
    """However close two of them are, until roundings are all that is left of the bend."""
    assert parabola(np.array([0.0, 1.0, 2.0]), np.array([1.0, 0.0, 1.0])) == pytest.approx((1.0, -2.0, 1.0))
    assert all(map(isnan, parabola(np.array([0.0, 1.0]), np.array([1.0, 0.0]))))
    assert parabola(np.array([0.0, 1e-9, 1.0]), np.array([0.0, 1e-9, 2.0]))[2] == pytest.approx(1.0, rel=1e-5)
    assert all(map(isnan, parabola(np.array([0.0, 1e-13, 1.0]), np.array([0.0, 1e-13, 2.0]))))
