"""Whether a device's loop ran at the rate it was told, by the device's own times; what is too far from it is refused.

The clock that gives the times is another question, which only this computer's clock answers (`Drift`).
"""

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block, Counts, Settings
from hknob_cli.hardware.timing import missed_at

MOST_OFF = 0.01  # by which share a rate may be off: quartz clocks are within 1e-4, and Chapter 8's cells are far apart
LEAST_SAMPLES = 100
_LEAST_MISSED = 5  # ticks; fewer are this or that late sample


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
    apart = max(1, number.size // 2)
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
