"""The target's clock against this computer's: when blocks arrived, and what time their last samples say it was.

A block may be late on its way, never early, so that the earliest arrivals tell the clocks apart from the delays.
"""

import numpy as np

from hknob_cli.hardware.clock_drift import drift_fault
from hknob_cli.hardware.port import Array, Drift

LATENESS_S = 0.01  # by which the earliest arrivals at both ends of a trial may differ in delay
_LEAST_BLOCKS = 12
_FIRST_S, _THEN = 0.4, 1.25  # of the target's time: when to look first, and by how much later each time after


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
        if told[-1] <= told[0] or arrived[-1] <= arrived[0]:
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
