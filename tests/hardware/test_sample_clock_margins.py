"""The watch over a device's times stands exactly where it says, and counts from the first sample of its trial."""

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block, Drift
from hknob_cli.hardware.sample_clock import (
    CLOCK_S,
    MOST_DRIFT,
    SampleClock,
    audit,
    drift_fault,
    fault_of,
    histogram,
    missed_at,
)
from tests.hardware.trials import settings

FIRST = 100_000  # index of the first sample
TOLD = settings(1000)


def fault(*late: int, count: int = 200, step: int = 1000, overruns: int = 0, simulated: bool = False) -> str:
    """What is said of samples ``step`` us apart; in their midst, at places 20 apart, so many ticks have none."""
    times = np.arange(count) * step
    for k, ticks in enumerate(late):
        times[count // 4 + 20 * k :] += ticks * step
    return fault_of(FIRST + np.arange(count), times, TOLD, overruns=overruns, simulated=simulated)


def test_what_is_said_of_a_clock_that_is_wrong() -> None:
    assert fault(step=1020) == (
        "the device's clock is wrong, or not the one that was asked for: its times rise by 1020 us from sample to "
        "sample, where a period is 1000 us: 2.0% too much (at most 1%)"
    )
    assert "rise by 980 us from sample to sample, where a period is 1000 us: 2.0% too little" in fault(step=980)


def test_what_is_said_of_a_loop_that_leaves_out_samples() -> None:
    assert fault(10) == (
        "the loop did not run at 1000 Hz: it took 199 samples in 209 periods, which is 952.2 Hz, and does not say so "
        "(at most 1% may be left out)"
    )
    assert "952.2 Hz, and says so (at most" in fault(10, overruns=1)


@pytest.mark.parametrize(("count", "most"), [(200, 5), (1000, 10), (2000, 20)])
def test_five_ticks_or_a_hundredth_may_be_left_out(count: int, most: int) -> None:
    assert fault(most, count=count) == ""
    assert fault(most + 1, count=count) != ""


@pytest.mark.parametrize("places", [1, 2])
def test_a_simulated_loop_says_so_at_each_place(places: int) -> None:
    late = [10] * places
    assert fault(*late, overruns=places, simulated=True) == ""
    assert fault(*late, overruns=places - 1, simulated=True) != ""


@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_samples_have_a_slope(count: int) -> None:
    assert fault(count=count) == ""
    assert "2.0% too much" in fault(count=count, step=1020)


def test_late_samples_at_either_end_are_no_other_clock() -> None:
    """Of slopes over half of the samples few have the late ones, whichever they are."""
    for place in (0, 1, 99, 100, 198, 199):
        times = np.arange(200) * 1000
        times[place] += 900
        assert fault_of(FIRST + np.arange(200), times, TOLD, overruns=0, simulated=False) == ""


def test_ticks_without_a_sample_are_counted_however_many_they_are() -> None:
    """Where times fall behind there are none; they are not taken from others."""
    number = FIRST + np.arange(60)
    times = np.arange(60) * 1000
    times[30:] += 600_000
    assert missed_at(number, times, 1_000_000).sum() == 600
    times[30:] -= 603_000
    assert not missed_at(number, times, 1_000_000).any()


def test_the_drift_is_of_the_ticks_from_first_to_last() -> None:
    assert audit(np.array([5, 6]), np.array([0, 1010]), period_ns=1_000_000, overruns=0).drift == pytest.approx(0.01)
    back = audit(np.array([5, 6, 5]), np.array([0, 1000, 0]), period_ns=1_000_000, overruns=0)
    assert (back.drift, back.repeated, back.backwards) == (0.0, 1, 1)


def test_a_histogram_reaches_a_tick_further_than_its_values() -> None:
    """In whole ticks of the clock; of one bin, too, and of nothing at all."""
    edges, counts = histogram(np.array([3.0, -1.0, 0.0]) * CLOCK_S, bins=3)
    assert edges / 1e-6 == pytest.approx([-4.5, -1.5, 1.5, 4.5])
    assert counts.tolist() == [0, 2, 1]
    edges, counts = histogram(np.zeros(0), bins=3)
    assert edges / 1e-6 == pytest.approx([-1.5, -0.5, 0.5, 1.5])
    edges, counts = histogram(np.array([2e-6]), bins=1)
    assert edges / 1e-6 == pytest.approx([-3.0, 3.0])
    assert counts.tolist() == [1]
    for bins in (-1, 0, 2, 4):
        with pytest.raises(ValueError, match="must be odd"):
            histogram(np.zeros(0), bins=bins)


def block(count: int, first: int, begin_us: int) -> Block:
    times = begin_us + np.arange(count) * 2000
    return Block(first, times, np.zeros(count, int), np.zeros(count), np.zeros(count), np.zeros(count, bool), 0)


def test_a_rate_is_judged_once_from_the_hundredth_sample_on() -> None:
    clock = SampleClock(TOLD, simulated=False)
    clock.take(block(99, FIRST, 0))
    clock.judge()
    with pytest.raises(DeviceError, match="which is 500 Hz"):
        clock.take(block(1, FIRST + 99, 198_000))
    clock.take(block(50, FIRST + 100, 200_000))


def test_a_clock_may_be_off_by_just_the_limit() -> None:
    assert drift_fault(Drift(MOST_DRIFT, 0.0)) == drift_fault(Drift(-MOST_DRIFT, 0.0)) == ""
    assert drift_fault(Drift(-0.02, 0.001)).startswith(
        "the target's clock is 2.0% slow by this computer's (sure to 0.1%, at most 1% is allowed)"
    )
