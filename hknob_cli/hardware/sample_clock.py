"""The sample clock of a trial: its audit, whether it ran as told, and how far a device's clock may drift.

How far a device's clock may be from this computer's.

Whether a device's loop ran at the rate it was told, by the device's own times; what is too far from it is refused.

The clock that gives the times is another question, which only this computer's clock answers (`Drift`).
"""

from typing import Any, NamedTuple

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Array, Block, Counts, Drift, Settings

MOST_DRIFT = 0.01  # by which share the clocks may differ; quartz clocks differ by 1e-4 at most

PERCENTILES = (50.0, 95.0, 99.0, 99.9)
CLOCK_S = 1e-6  # the device tells whole microseconds
_AHEAD = 8  # samples among which one is in time
MOST_OFF = 0.01  # by which share a rate may be off: quartz clocks are within 1e-4, and Chapter 8's cells are far apart
LEAST_SAMPLES = 100
_LEAST_MISSED = 5  # ticks; fewer are this or that late sample


def drift_fault(drift: Drift | None) -> str:
    """What is wrong with a clock that differs so; empty if nothing is."""
    if drift is None or drift.at_least <= MOST_DRIFT:
        return ""
    how = "fast" if drift.share > 0.0 else "slow"
    return (
        f"the target's clock is {abs(drift.share):.1%} {how} by this computer's (sure to {drift.uncertainty:.1%}, "
        f"at most {MOST_DRIFT:.0%} is allowed): its times are wrong, or its loop does not run at the rate it was told"
    )


class Timing(NamedTuple):
    """How evenly a trial was sampled, by the device's own times; seconds, except for counts.

    Intervals are those between samples of consecutive index: their mean, standard deviation, least and greatest.
    ``jitter_*``: percentiles and the greatest of the distance of an interval from the period; times are told to
    `CLOCK_S`, so that a perfect clock may show as much. ``drift``: by which share a tick takes longer than the period,
    from the first sample to the last.

    ``gaps``: samples whose index is missing, in ``gap_count`` places; ``repeated``: indices that do not rise;
    ``missed_ticks``: of the clock, at which no sample was taken though none is missing; ``overruns``: samples for which
    the device says that its loop was late; ``backwards``: times that do not rise.
    """

    samples: int
    period_s: float
    interval_mean_s: float = 0.0
    interval_std_s: float = 0.0
    interval_min_s: float = 0.0
    interval_max_s: float = 0.0
    jitter_p50_s: float = 0.0
    jitter_p95_s: float = 0.0
    jitter_p99_s: float = 0.0
    jitter_p999_s: float = 0.0
    jitter_max_s: float = 0.0
    drift: float = 0.0
    gaps: int = 0
    gap_count: int = 0
    repeated: int = 0
    missed_ticks: int = 0
    overruns: int = 0
    backwards: int = 0

    @property
    def clean(self) -> bool:
        """Whether no sample is missing, late, or out of order."""
        return not (self.gaps or self.repeated or self.missed_ticks or self.overruns or self.backwards)


def audit(number: Counts, time_us: Counts, *, period_ns: int, overruns: int) -> Timing:
    """Audit samples with these indices and device times, arrays (n,), taken by a clock of ``period_ns``."""
    period = period_ns * 1e-9
    steps, intervals = np.diff(number), np.diff(time_us) * 1e-6
    following = intervals[steps == 1]
    plain = Timing(
        samples=int(number.size),
        period_s=period,
        gaps=int((steps[steps > 1] - 1).sum()),
        gap_count=int((steps > 1).sum()),
        repeated=int((steps < 1).sum()),
        overruns=int(overruns),
        backwards=int((intervals <= 0.0).sum()),
    )
    if not following.size:
        return plain
    jitter = np.abs(following - period)
    percentiles = [float(value) for value in np.percentile(jitter, PERCENTILES)]
    missed = int(missed_at(number, time_us, period_ns).sum())
    ticks = int(number[-1] - number[0]) + missed
    return plain._replace(
        interval_mean_s=float(np.clip(following.mean(), following.min(), following.max())),  # rounding aside
        interval_std_s=float(following.std()),
        interval_min_s=float(following.min()),
        interval_max_s=float(following.max()),
        jitter_p50_s=percentiles[0],
        jitter_p95_s=percentiles[1],
        jitter_p99_s=percentiles[2],
        jitter_p999_s=percentiles[3],
        jitter_max_s=float(jitter.max()),
        drift=float(time_us[-1] - time_us[0]) * 1e-6 / (ticks * period) - 1.0 if ticks > 0 else 0.0,
        missed_ticks=missed,
    )


def missed_at(number: Counts, time_us: Counts, period_ns: int) -> Counts:
    """Ticks without a sample before each sample but the first, array (n - 1,).

    That is how often the earliest of the next samples falls behind by a period more.

    One late sample does not move the earliest; the clock that goes on without samples does. Some parts in 10⁴ by which
    two clocks differ do not add up to a period over so few samples.
    """
    behind = time_us * 1000 - number * period_ns
    ahead = np.concatenate([behind, np.full(_AHEAD - 1, behind[-1])])
    earliest = np.lib.stride_tricks.sliding_window_view(ahead, _AHEAD).min(axis=1)
    return np.asarray(np.maximum(0, np.rint(np.diff(earliest) / period_ns)), dtype=np.int64)


def jitter_of(number: Counts, time_us: Counts, *, period_ns: int) -> Array:
    """By how much (s) each interval between samples of consecutive index is longer than the period, array."""
    found = (np.diff(time_us) * 1000 - period_ns)[np.diff(number) == 1] * 1e-9
    return np.asarray(found, dtype=np.float64)


def histogram(jitter_s: Array, *, bins: int = 61) -> tuple[Array, np.ndarray[Any, np.dtype[np.int64]]]:
    """Edges (bins + 1,), in seconds, and how often (bins,): symmetric about 0, all values inside.

    Edges lie on whole multiples of the clock's resolution, between which times have nothing to say, so that no bin gets
    more of them than its neighbour. ``bins`` is odd.
    """
    if bins < 1 or bins % 2 == 0:
        raise ValueError(f"bins must be odd, got {bins}")
    reach = float(np.abs(jitter_s).max()) if jitter_s.size else 0.0
    # One width more than needed: jitter on the outermost edge is inside, however it was rounded.
    width = CLOCK_S * np.ceil((reach + CLOCK_S) / (0.5 * bins) / CLOCK_S)
    edges = width * (np.arange(bins + 1) - 0.5 * bins)
    counts, _ = np.histogram(jitter_s, edges)
    return edges, counts.astype(np.int64)


class SampleClock:
    """Takes the blocks of a trial, and judges their times as soon as there are enough, and at the end."""

    def __init__(self, settings: Settings, *, simulated: bool) -> None:
        """``simulated``: the knob moves by one period from sample to sample, however late the loop is."""
        self._settings = settings
        self._simulated = simulated
        self._numbers: list[Counts] = []
        self._times: list[Counts] = []
        self._taken = 0
        self._overruns = 0
        self._judged = False

    def take(self, block: Block) -> None:
        """The next block. Raises `DeviceError` once, where the first `LEAST_SAMPLES` show a wrong rate."""
        count = len(block.time_us)
        self._numbers.append(np.arange(block.first, block.first + count, dtype=np.int64))
        self._times.append(block.time_us)
        self._overruns = block.overruns
        self._taken += count
        if not self._judged and self._taken >= LEAST_SAMPLES:
            self._judged = True
            self.judge()

    def judge(self) -> None:
        """Raise `DeviceError` where all samples so far are not of the rate that was told."""
        if self._taken >= LEAST_SAMPLES:
            number, time_us = np.concatenate(self._numbers), np.concatenate(self._times)
            said = fault_of(number, time_us, self._settings, overruns=self._overruns, simulated=self._simulated)
            if said:
                raise DeviceError(said)


def fault_of(number: Counts, time_us: Counts, settings: Settings, *, overruns: int, simulated: bool) -> str:
    """What is wrong with the rate of samples (n,), n >= 2; empty if nothing is."""
    period_ns = settings.period_ns
    rate = 1e9 / period_ns
    missed = missed_at(number, time_us, period_ns)
    ticks = number - number[0] + np.concatenate([[0], np.cumsum(missed)])
    apart = number.size // 2
    # Slopes over half the samples, and of these the median: late samples move few of them.
    slopes = (time_us[apart:] - time_us[:-apart]) * 1e3 / ((ticks[apart:] - ticks[:-apart]) * float(period_ns)) - 1.0
    off = float(np.median(slopes))
    if abs(off) > MOST_OFF:
        asked = period_ns * 1e-3
        return (
            f"the device's clock is wrong, or not the one that was asked for: its times rise by "
            f"{asked * (1 + off):.5g} us from sample to sample, where a period is {asked:.5g} us: {abs(off):.1%} too "
            f"{'much' if off > 0 else 'little'} (at most {MOST_OFF:.0%})"
        )
    left_out = int(missed.sum())
    if left_out <= max(_LEAST_MISSED, MOST_OFF * float(ticks[-1])):
        return ""
    said = overruns >= int((missed > 0).sum())
    if simulated and said:
        return ""
    taken = int(number[-1] - number[0])
    how = "and says so" if said else "and does not say so"
    return (
        f"the loop did not run at {rate:g} Hz: it took {taken} samples in {ticks[-1]} periods, which is "
        f"{rate * taken / ticks[-1]:.4g} Hz, {how} (at most {MOST_OFF:.0%} may be left out)"
    )
