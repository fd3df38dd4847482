"""What fast sampling does to numbers, against other programs and against the numbers themselves."""

from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from scipy.signal import butter

from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import ResultSet

NOTHING = ResultSet({})
KNOB = {"inertia": 2.2e-6, "damping": 3.45e-4, "stiffness": 0.04}


@pytest.mark.parametrize("rate", [100.0, 1000.0, 10000.0, 25000.0])
@pytest.mark.parametrize("lag", [0.0, 5e-5])
def test_zeros_are_those_of_another_program(rate: float, lag: float) -> None:
    control = pytest.importorskip("control")
    plant = control.tf(
        [1.0 / KNOB["inertia"]], [1.0, KNOB["damping"] / KNOB["inertia"], KNOB["stiffness"] / KNOB["inertia"]]
    )
    if lag:
        plant = plant * control.tf([1.0 / lag], [1.0, 1.0 / lag])
    other = max(abs(control.sample_system(control.ss(plant), 1.0 / rate, method="zoh").zeros()))
    # Rounding of its own states: velocity and angle differ by the rate.
    found = compute("sampling_zero", NOTHING, {**KNOB, "sample_rate_hz": rate, "lag_s": lag})
    assert found == pytest.approx(other, rel=1e-6)


def test_zeros_have_the_limits_of_their_orders() -> None:
    """-1 for two integrators more than zeros, and -2 - sqrt(3) for three (Astrom, Hagander & Sternby 1984)."""
    fast = {**KNOB, "sample_rate_hz": 3e5}
    assert compute("sampling_zero", NOTHING, fast) == pytest.approx(1.0, abs=1e-3)
    assert compute("sampling_zero", NOTHING, {**fast, "lag_s": 1e-3}) == pytest.approx(2.0 + sqrt(3.0), rel=1e-2)
    free = {"inertia": 2.2e-6, "damping": 0.0, "stiffness": 0.0, "sample_rate_hz": 1000.0}
    assert compute("sampling_zero", NOTHING, free) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("rate", [1000.0, 10000.0])
@pytest.mark.parametrize("low_pass", [0.0, 1e-3])
def test_the_jump_of_a_velocity_is_that_of_the_readings(rate: float, low_pass: float) -> None:
    """A knob at rest that turns by a count: largest of the filtered differences, one by one."""
    counts = [0.0] * 5 + [2.0 * pi / 1024] * 5
    speed, largest = 0.0, 0.0
    for before, now in pairwise(counts):
        given = (now - before) * rate
        speed = speed + (1.0 - np.exp(-1.0 / (rate * low_pass))) * (given - speed) if low_pass else given
        largest = max(largest, speed)
    given = {"counts_per_rev": 1024, "sample_rate_hz": rate, "low_pass": low_pass}
    assert compute("velocity_jump", NOTHING, given) == pytest.approx(largest, rel=1e-12)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("rate", "bits"), [(1000.0, 16), (10000.0, 16), (25000.0, 16), (25000.0, 24)])
def test_no_rounded_filter_is_farther_off_and_some_come_near(rate: float, bits: int) -> None:
    """Filters of SciPy with cut-offs about 100 Hz, rounded: the bound of each holds, and is three quarters reached."""
    step = 4.0 / 2.0**bits
    reached = []
    for cut_off in np.linspace(90.0, 110.0, 2000):
        b, a = butter(2, cut_off, fs=rate)
        kept = np.round(b[0] / step) * step, np.round(a[1:] / step) * step
        gain = 4.0 * kept[0] / (1.0 + kept[1].sum())
        bound = compute("coefficient_error", NOTHING, {"cut_off_hz": cut_off, "sample_rate_hz": rate, "bits": bits})
        assert abs(gain - 1.0) <= 0.01 * bound * (1.0 + 1e-9)
        reached.append(abs(gain - 1.0) / (0.01 * bound))
    assert max(reached) > 0.75
