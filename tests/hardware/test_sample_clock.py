"""The audit of sample times: what a perfect clock shows, and every fault put in by hand.

A loop that did not run at its rate, and a clock that is not the computer's, are refused; late samples are not.
"""

import random

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.knob_motion import LATEST, Nuisances
from hknob_cli.hardware.port import Block, Drift
from hknob_cli.hardware.sample_clock import (
    CLOCK_S,
    MOST_DRIFT,
    MOST_OFF,
    SampleClock,
    audit,
    drift_fault,
    fault_of,
    histogram,
    jitter_of,
)
from hknob_cli.hardware.wire.sending import HostClock
from tests.hardware.trials import settings, virtual_trial


def clock(count: int = 2000, period_us: int = 250) -> tuple[np.ndarray, np.ndarray]:
    number = np.arange(count)
    return number, number * period_us


@pytest.mark.parametrize("rate", [455, 1000, 4000, 3_000])
def test_a_perfect_clock_is_even_to_its_resolution(rate: int) -> None:
    told = settings(rate)
    got = virtual_trial(told)
    number = np.arange(got.time_us.size)
    timing = audit(number, got.time_us, period_ns=told.period_ns, overruns=got.overruns)
    assert timing.clean
    assert timing.samples == got.time_us.size
    assert timing.jitter_max_s < CLOCK_S
    assert abs(timing.drift) * told.interval_s * (timing.samples - 1) < CLOCK_S
    assert timing.interval_min_s <= timing.interval_mean_s <= timing.interval_max_s


def test_jitter_is_what_the_virtual_clock_has() -> None:
    """Lateness |N(0, s)| at both ends of an interval: variance 2 (1 - 2/pi) s², four standard errors, rounding."""
    told, rms = settings(1000), 20e-6
    got = virtual_trial(told, duration_s=8.0, nuisances=Nuisances(jitter_s=rms, seed=4))
    number = np.arange(got.time_us.size)
    timing = audit(number, got.time_us, period_ns=told.period_ns, overruns=got.overruns)
    expected = np.sqrt(2 * (1 - 2 / np.pi)) * rms
    assert timing.interval_std_s == pytest.approx(expected, abs=4 * expected / np.sqrt(timing.samples) + 0.5 * CLOCK_S)
    assert timing.clean
    assert timing.jitter_p50_s < timing.jitter_p95_s < timing.jitter_p99_s < timing.jitter_p999_s < timing.jitter_max_s
    jitter = jitter_of(number, got.time_us, period_ns=told.period_ns)
    assert np.abs(jitter).max() == pytest.approx(timing.jitter_max_s)
    assert jitter.mean() == pytest.approx(timing.drift * told.interval_s, abs=1e-12)


def test_overruns_miss_ticks_but_no_index() -> None:
    told, share = settings(2000), 0.02
    got = virtual_trial(told, duration_s=4.0, nuisances=Nuisances(late_share=share, seed=4))
    n = got.time_us.size
    timing = audit(np.arange(n), got.time_us, period_ns=told.period_ns, overruns=got.overruns)
    assert abs(timing.overruns - share * n) < 4 * np.sqrt(share * n)
    assert timing.gaps == timing.backwards == 0
    assert not timing.clean
    # Every tick of the clock has a sample, or is missed; except for the last sample, which may be late.
    ticks = int(got.time_us[-1] * 1000 // told.period_ns)
    assert timing.overruns < timing.missed_ticks < 2 * timing.overruns
    assert abs(n - 1 + timing.missed_ticks - ticks) <= LATEST
    assert abs(timing.drift) < LATEST / n
    assert timing.interval_max_s <= (LATEST + 1) * told.interval_s


def test_missing_samples_are_counted_and_not_taken_for_jitter() -> None:
    number, time = clock()
    keep = ~np.isin(number, [100, 101, 102, 700])
    timing = audit(number[keep], time[keep], period_ns=250_000, overruns=0)
    assert (timing.gaps, timing.gap_count) == (4, 2)
    assert timing.jitter_max_s == pytest.approx(0.0, abs=1e-15)
    assert (timing.missed_ticks, timing.backwards, timing.repeated, timing.clean) == (0, 0, 0, False)


def test_clocks_that_go_wrong() -> None:
    number, time = clock()
    back = time.copy()
    back[500:] -= 1000
    assert audit(number, back, period_ns=250_000, overruns=0).backwards == 1
    stuck = np.where(number == 500, time[499], time)
    assert audit(number, stuck, period_ns=250_000, overruns=0).backwards == 1
    twice = np.where(number == 500, 499, number)
    timing = audit(twice, time, period_ns=250_000, overruns=3)
    assert (timing.repeated, timing.gaps, timing.overruns) == (1, 1, 3)
    fast = audit(number, time, period_ns=251_000, overruns=0)
    assert fast.drift == pytest.approx(250 / 251 - 1)
    assert not any((fast.missed_ticks, fast.gaps))


@pytest.mark.parametrize("count", [0, 1])
def test_no_intervals(count: int) -> None:
    number, time = clock(count)
    timing = audit(number, time, period_ns=250_000, overruns=0)
    assert timing.samples == count
    assert timing.clean
    assert timing.interval_max_s == timing.jitter_max_s == 0.0
    edges, counts = histogram(jitter_of(number, time, period_ns=250_000))
    assert counts.sum() == 0
    assert edges.size == counts.size + 1


@pytest.mark.parametrize("reach", [0.0, 3e-7, 5e-6, 31e-6, 1e-3])
def test_histogram_has_all_and_is_symmetric(reach: float) -> None:
    jitter = np.linspace(-reach, reach, 1001)
    edges, counts = histogram(jitter, bins=31)
    assert counts.sum() == jitter.size
    assert np.abs(edges + edges[::-1]).max() < 1e-18
    width = np.diff(edges)
    assert np.abs(width / CLOCK_S - np.rint(width[0] / CLOCK_S)).max() < 1e-9
    assert edges[-1] < reach + CLOCK_S + 31 * CLOCK_S


def test_histogram_wants_a_middle() -> None:
    with pytest.raises(ValueError, match="bins must be odd, got 30"):
        histogram(np.zeros(3), bins=30)


TOLD = settings(1000)


def fault(time_us: np.ndarray, *, overruns: int = 0, simulated: bool = False) -> str:
    return fault_of(np.arange(time_us.size), time_us.astype(np.int64), TOLD, overruns=overruns, simulated=simulated)


@pytest.mark.parametrize("step", [1000.0, 1000.09, 999.91, 1009.0, 991.0])
def test_times_within_the_limit_pass(step: float) -> None:
    assert fault(np.floor(np.arange(500) * step)) == ""


@pytest.mark.parametrize(
    ("step", "said"),
    [(500, "50.0% too little"), (1020, "2.0% too much"), (980, "2.0% too little"), (1500, "50.0% too")],
)
def test_times_of_another_clock_are_named(step: float, said: str) -> None:
    assert said in fault(np.arange(500) * step)
    assert f"at most {MOST_OFF:.0%}" in fault(np.arange(500) * step)


@pytest.mark.parametrize("factor", [2, 3, 10])
@pytest.mark.parametrize("simulated", [False, True])
def test_a_loop_at_a_half_a_third_or_a_tenth_of_its_rate_is_in_no_cell(factor: int, *, simulated: bool) -> None:
    said = fault(np.arange(400) * 1000 * factor, simulated=simulated)
    assert said.startswith("the loop did not run at 1000 Hz: ")
    assert f"which is {1000 / factor:.4g} Hz, and does not say so" in said


def busy(share: float) -> tuple[np.ndarray, int]:
    """Times of a loop that is late now and then, by up to three periods, and how often it was."""
    dice, tick, times, overruns = random.Random(3), 0, [], 0
    for _ in range(2000):
        late = dice.uniform(0.5, 3.0) if dice.random() < share else 0.0
        times.append((tick + late) * 1000)
        overruns += late > 0.5
        tick += 1 + int(late)
    return np.array(times), overruns


def test_a_busy_computer_that_owns_up_is_let_pass_where_the_knob_is_simulated_and_only_there() -> None:
    times, overruns = busy(0.1)
    assert fault(times, overruns=overruns, simulated=True) == ""
    assert "the loop did not run at 1000 Hz" in fault(times, overruns=overruns)
    assert "and does not say so" in fault(times, overruns=0, simulated=True)


def test_some_late_samples_are_no_other_rate() -> None:
    times, overruns = busy(0.002)
    assert fault(times, overruns=overruns) == ""


def test_the_first_samples_are_enough() -> None:
    """A wrong rate is found before the wall is on."""
    clock = SampleClock(TOLD, simulated=False)
    block = Block(0, np.arange(100) * 2000, np.zeros(100, int), np.zeros(100), np.zeros(100), np.zeros(100, bool), 0)
    with pytest.raises(DeviceError, match="which is 500 Hz"):
        clock.take(block)


def arrivals(share: float, *, seconds: float, seed: int = 0) -> HostClock:
    """Blocks of 10 ms of a clock that is fast by a share, late by some ms, and now and then by 50 ms."""
    clock, dice = HostClock(), random.Random(seed)
    for i in range(1, int(seconds * 100)):
        late = dice.expovariate(1 / 0.002) + (0.05 * dice.random() if dice.random() < 0.2 else 0.0)
        clock.note(arrived_s=5.0 + i * 0.01 / (1.0 + share) + late, told_s=i * 0.01)
    return clock


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("share", [0.0, 1e-4, -0.005])
def test_a_clock_within_the_limit_passes_however_late_blocks_are(share: float, seed: int) -> None:
    drift = arrivals(share, seconds=2.0, seed=seed).drift()
    assert drift is not None
    assert drift_fault(drift) == ""
    assert abs(drift.share - share) <= drift.uncertainty


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("share", "seconds"), [(0.03, 2.0), (0.02, 4.0), (-0.02, 4.0), (-0.5, 0.5), (1.0, 0.8)])
def test_a_clock_beyond_the_limit_is_refused(share: float, seconds: float, seed: int) -> None:
    drift = arrivals(share, seconds=seconds, seed=seed).drift()
    assert drift is not None
    assert ("fast" if share > 0 else "slow") in drift_fault(drift)


def test_nothing_is_said_of_a_clock_that_was_heard_for_too_short() -> None:
    clock = HostClock()
    assert clock.fault() == ""
    assert arrivals(0.0, seconds=0.1).drift() is None
    assert drift_fault(None) == drift_fault(Drift(2 * MOST_DRIFT, 1.5 * MOST_DRIFT)) == ""
