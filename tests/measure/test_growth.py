"""The energy growth rate: its fit, and its size against the leak of a hold."""

import math
from typing import Any

import numpy as np
import pytest

from hknob_cli.measure.growth import Peaks, bounce_peaks, energy_growth, parabola
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.scene import SceneSpec

J, K, G = 2.2e-6, 0.27, 0.001
RATES_HZ = tuple(100.0 * 10.0 ** (i / 3) for i in range(7))


def sampled(rate: float, counts: int, **parts: object) -> SampledKnob:
    scene = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3e-7},
        "wall": {"stiffness": K},
        "bias": {"torque": G},
        **parts,
    }
    return sample_knob(SceneSpec.model_validate(scene).plain(), sample_rate_hz=rate, counts_per_rev=counts)


def run(one: SampledKnob, duration: float, functions: Any = None, phases: int = 64) -> list[Peaks]:
    return bounce_peaks(
        one, angle_rad=0.02, velocity_rad_s=0.0, phases=phases, duration_s=duration, functions=functions
    )


def test_parabola_is_recovered_far_from_the_origin() -> None:
    """Times 1e4 s from zero and 1 ms apart: c2 to 1e-16 * (|E| / spread of E), whatever the offset."""
    t = 1e4 + 1e-3 * np.array([0.0, 1.0, 2.5, 4.0, 4.5, 7.0])
    value = 3.0 - 2.0 * (t - 1e4) + 5.0 * (t - 1e4) ** 2
    c2 = parabola(t, value)[2]
    # The values' rounding, 4e-16, over the quadratic part's size, 5 * (3.5e-3)^2; times are rounded to 2e-12 s.
    assert c2 == pytest.approx(5.0, rel=1e-9 / 1.2e-5 * 1e-2)


def test_parabola_agrees_with_numpy() -> None:
    rng = np.random.default_rng(5)
    t, value = np.sort(rng.uniform(0.0, 1.0, 30)), rng.normal(size=30)
    assert parabola(t, value)[::-1] == pytest.approx(np.polyfit(t, value, 2), rel=1e-11)


@pytest.mark.parametrize("time", [[], [0.1, 0.2], [0.1, 0.1, 0.1], [0.1, 0.2, 0.2]])
def test_fewer_than_three_times_have_no_parabola(time: list[float]) -> None:
    assert all(math.isnan(c) for c in parabola(np.array(time), np.ones(len(time))))


def test_trials_without_a_fit_are_left_out() -> None:
    t = np.array([0.1, 0.2, 0.4])
    fit = Peaks(time_s=t, angle_rad=t, energy_j=2.0 * t**2)
    none = Peaks(time_s=t[:1], angle_rad=t[:1], energy_j=t[:1])
    found = energy_growth([fit, none])
    assert found.growth_j_per_s2 == pytest.approx(2.0, rel=1e-13)
    assert (found.fits, found.trials, found.bounces) == (1, 2, 2.0)
    assert math.isnan(energy_growth([none]).growth_j_per_s2)


def test_energy_is_that_of_bias_and_hand() -> None:
    one = sampled(1000.0, 1024, hand={"inertia": 3e-7, "stiffness": 0.02}, encoder={"rounding": "nearest"})
    for peaks in run(one, 0.2, phases=3):
        assert len(peaks.time_s) > 0
        assert np.all(peaks.angle_rad > -0.5 * one.quantum_rad)
        assert peaks.energy_j == pytest.approx(G * peaks.angle_rad + 0.01 * peaks.angle_rad**2, rel=1e-12)


def test_phases_are_those_of_the_sweep() -> None:
    """Phase i of n is sampled (i + 1/2)/n of a period after the start: each alone is one of an ensemble of its own."""
    one = sampled(464.0, 512)
    together = run(one, 0.3, phases=3)
    alone = run(one, 0.3, phases=1)
    assert together[1].time_s == pytest.approx(alone[0].time_s, rel=1e-9)
    assert np.all(together[0].time_s > 0.0)
    assert not np.allclose(together[0].energy_j, together[2].energy_j, rtol=1e-6)


@pytest.mark.parametrize(("rate", "counts"), [(1000.0, 4096), (100.0, 128)])
def test_compiled_and_interpreted_agree_to_the_last_bit(rate: float, counts: int, functions: Any) -> None:
    one = sampled(rate, counts)
    for plain, fast in zip(run(one, 1.0, phases=5), run(one, 1.0, functions, phases=5), strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(plain, fast, strict=True))


def contact_gain(rate: float) -> float:
    """Mean ratio of the speeds out of and into a wall with a hold but no counts, over where the samples fall.

    The bias is left out while in contact. Speeds in units of the wall's period: x += v - w x / 2, v -= w x.
    """
    w = K / J / rate**2
    total = 0.0
    for i in range(1000):
        x, v = -(i + 0.5) / 1000.0, -1.0
        while x < 0.0:
            x, v = x + v - 0.5 * w * x, v - w * x
        total += v
    return total / 1000.0


@pytest.mark.parametrize("counts", [512, 2048, 8192])
def test_growth_is_that_of_the_hold_alone(counts: int, functions: Any) -> None:
    """Speed gains the factor s per contact and a flight lasts as long as its speed: sqrt(E) grows evenly in time.

    c2 = g^2/(2J) ((s - 1)/(s + 1))^2, which for short periods is pi^2 K g^2 T^2 / (128 J^2). Left out are the time in
    contact and the bias during it, some per cent, and chance: 64 trials of some 25 bounces.
    """
    for rate in RATES_HZ[2:6]:
        gain = contact_gain(rate)
        wanted = G**2 / (2.0 * J) * ((gain - 1.0) / (gain + 1.0)) ** 2
        found = energy_growth(run(sampled(rate, counts), 4.0, functions))
        chance = 3.0 * found.growth_std_j_per_s2 / 8.0
        assert found.fits == 64
        assert abs(found.growth_j_per_s2 - wanted) <= 0.03 * wanted + chance
        assert chance < 0.1 * wanted


def test_growth_falls_with_the_square_of_the_rate(functions: Any) -> None:
    """Between 1 and 4.6 kHz, at the finest resolution: slope -2 on logarithmic axes."""
    low, high = (
        energy_growth(run(sampled(rate, 8192), 4.0, functions)).growth_j_per_s2 for rate in (RATES_HZ[3], RATES_HZ[5])
    )
    assert math.log(high / low) / math.log(RATES_HZ[5] / RATES_HZ[3]) == pytest.approx(-2.0, abs=0.05)
