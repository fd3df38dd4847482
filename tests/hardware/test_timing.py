"""The audit of sample times: what a perfect clock shows, and every fault put in by hand."""

import numpy as np
import pytest

from hknob_cli.hardware.nuisances import LATEST, Nuisances
from hknob_cli.hardware.timing import CLOCK_S, audit, histogram, jitter_of
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
    # Every tick of the clock has a sample, or is missed; but for the last sample, which may be late.
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
