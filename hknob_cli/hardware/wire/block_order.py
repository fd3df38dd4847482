"""Blocks of a run put in order: each handed on once, none missing, samples that follow on each other.

No clock and no port: the caller says what time it is, in seconds of any clock.
"""

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.wire.answers import Samples

ASK_EVERY_S = 0.02
GAP_PATIENCE_S = 0.1
# What may be held while a gap is being filled; what is further ahead is asked for later.
MOST_AHEAD = 256


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
        self._seen = 0
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
        last = self._seen if self.total is None else self.total
        return (self.expected, last - self.expected) if self.expected < last else None

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
        self._seen = max(self._seen, self.expected)
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
