"""Blocks of a run: put in order, none missing, and their clock held against this computer's.

No clock and no port: the caller says what time it is, in seconds of any clock.

The target's clock against this computer's: when blocks arrived, and what time their last samples say it was.

A block may be late on its way, never early, so that the earliest arrivals tell the clocks apart from the delays.
"""

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Array, Block, Drift
from hknob_cli.hardware.sample_clock import drift_fault
from hknob_cli.hardware.wire.answers import Samples

LATENESS_S = 0.01  # by which the earliest arrivals at both ends of a trial may differ in delay
_LEAST_BLOCKS = 12
_FIRST_S, _THEN = 0.4, 1.25  # of the target's time: when to look first, and by how much later each time after

ASK_EVERY_S = 0.02
GAP_PATIENCE_S = 0.1
# What may be held while a gap is being filled; what is further ahead is asked for later.
MOST_AHEAD = 256


class HostClock:
    """Arrivals of the blocks of one trial."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float]] = []
        self._next_s = _FIRST_S

    def note(self, *, arrived_s: float, told_s: float) -> None:
        """A block arrived for the first time, in its place; its last sample was taken at ``told_s`` by the target."""
        self._points.append((arrived_s, told_s))

    def drift(self) -> Drift | None:
        """By how much the target's clock is fast; None before there is enough to tell."""
        if len(self._points) < _LEAST_BLOCKS:
            return None
        arrived, told = np.array(self._points).T
        if arrived[-1] <= arrived[0]:
            return None
        late = arrived - told
        third = len(late) // 3
        (begin, least, spread), (end, last, more) = (
            _earliest(told[p], late[p]) for p in (slice(third), slice(-third, None))
        )
        if end <= begin:
            return None
        slower = (last - least) / (end - begin)  # seconds of this computer's beyond one of the target's
        if slower <= -1.0:
            return None
        return Drift(float(1.0 / (1.0 + slower) - 1.0), float((spread + more + LATENESS_S) / (end - begin)))

    def fault(self) -> str:
        """What is wrong with the target's clock, looked for now and then; empty if nothing is."""
        if not self._points or self._points[-1][1] - self._points[0][1] < self._next_s:
            return ""
        self._next_s = _THEN * (self._points[-1][1] - self._points[0][1])
        return drift_fault(self.drift())


def _earliest(told: Array, late: Array) -> tuple[float, float, float]:
    """When the least late block was taken, how late it was, and how much later than that the next tenth were."""
    i = int(np.argmin(late))
    return float(told[i]), float(late[i]), float(np.percentile(late, 10.0) - late[i])


class BlockOrder:
    """Order of the blocks of one run; ``expected`` is the next block to be handed on."""

    def __init__(self, *, boot: int, run: int, patience_s: float = GAP_PATIENCE_S) -> None:
        self.boot = boot
        self.run = run
        self.patience_s = patience_s
        self.expected = 0
        self.total: int | None = None
        self.dropped = 0
        self._ahead: dict[int, Block] = {}
        self._sample = 0
        self._time_us = 0
        self._gap_since: float | None = None
        self._asked = -ASK_EVERY_S

    @property
    def complete(self) -> bool:
        """Whether the run has ended and all its blocks were handed on."""
        return self.total is not None and self.expected >= self.total

    @property
    def gap(self) -> tuple[int, int] | None:
        """First block that is missing, and how many are up to the next one held, or to the last made."""
        if self._ahead:
            return self.expected, min(self._ahead) - self.expected
        if self.total is None or self.complete:
            return None
        return self.expected, self.total - self.expected

    def take(self, message: Samples, *, now: float) -> list[Block]:
        """Blocks that can be handed on now. Raises DeviceError if their samples do not follow on each other."""
        number = message.block
        other = (message.boot, message.run) != (self.boot, self.run)
        if other or self.is_beyond(message) or number < self.expected or number in self._ahead:
            self.dropped += 1
            return []
        if number < self.expected + MOST_AHEAD:
            self._ahead[number] = message.samples
        ordered = []
        while self.expected in self._ahead:
            block = self._ahead.pop(self.expected)
            self._follow(block)
            ordered.append(block)
            self.expected += 1
        self._time_gap(now, progress=bool(ordered))
        return ordered

    def is_beyond(self, message: Samples) -> bool:
        """Whether a block is of this run, and of more than the target said it had made when it ended."""
        ours = (message.boot, message.run) == (self.boot, self.run)
        return ours and self.total is not None and message.block >= self.total

    def end(self, total: int, *, now: float) -> None:
        """The target has made ``total`` blocks, and will make no more."""
        self.total = total
        self._time_gap(now, progress=False)

    def ask(self, now: float) -> tuple[int, int] | None:
        """First block and number of blocks to ask for again, or None if there is no need now."""
        gap = self.gap
        if gap is None or now - self._asked < ASK_EVERY_S:
            return None
        self._asked = now
        return gap[0], min(gap[1], MOST_AHEAD)

    def is_overdue(self, now: float) -> bool:
        """Whether a gap has stayed for so long that it will not be filled."""
        return self._gap_since is not None and now - self._gap_since > self.patience_s

    def _time_gap(self, now: float, *, progress: bool) -> None:
        if self.gap is None:
            self._gap_since = None
        elif self._gap_since is None or progress:
            self._gap_since = now

    def _follow(self, block: Block) -> None:
        if block.first != self._sample:
            raise DeviceError(f"a block begins with sample {block.first}, where sample {self._sample} follows")
        times = block.time_us
        if times[0] < self._time_us or (times[1:] < times[:-1]).any():
            raise DeviceError(f"the target's clock runs backwards near sample {block.first}")
        if (np.diff(times) == 0).any() or (self._sample and times[0] == self._time_us):
            raise DeviceError(
                f"two samples have the same time near sample {block.first}: the target must tell times to 1 us, and a "
                "clock of 1 ms is too coarse"
            )
        self._sample += len(times)
        self._time_us = int(times[-1])
