"""A limit of time on a search: heard between its slices, and inside compiled code by a flag that its loops look at.

Time in which the engine is compiled does not count: the same search has it once, and not the next day.
"""

from threading import Timer
from time import monotonic
from types import TracebackType
from typing import Any

from hknob_cli.engine.compiling import compiling_s


class Alarm:
    """Sets ``halt[0]`` above 0 when ``seconds`` are over, if they are limited; ``halt`` None: there is no such flag."""

    def __init__(self, seconds: float | None, halt: Any = None) -> None:
        self._ends = None if seconds is None else monotonic() - compiling_s() + seconds
        self._halt = halt
        self._timer: Timer | None = None
        if seconds is not None and halt is not None:
            self._timer = self._timer_of(seconds)

    def _timer_of(self, seconds: float) -> Timer:
        timer = Timer(seconds, self._ring)
        timer.daemon = True
        return timer

    def __enter__(self) -> "Alarm":
        if self._timer and self._left > 0.0:
            self._timer.start()
        elif self._timer:
            self._halt[0] = 1.0  # a thread might be heard only after a short search is done
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._timer:
            self._timer.cancel()

    def _ring(self) -> None:
        if self._left <= 0.0:
            self._halt[0] = 1.0
            return
        mine, again = self._timer, self._timer_of(self._left)
        self._timer = again
        again.start()
        if mine is None or mine.finished.is_set():  # the search has ended meanwhile
            again.cancel()

    @property
    def _left(self) -> float:
        """Seconds until it rings, if nothing more is compiled."""
        return 0.0 if self._ends is None else self._ends - (monotonic() - compiling_s())

    @property
    def limited(self) -> bool:
        """Whether there is a limit."""
        return self._ends is not None

    @property
    def over(self) -> bool:
        """Whether the time is over, and a search that looks at the flag has heard it."""
        if self._halt is not None:
            return bool(self._halt[0] > 0.0)
        return self._ends is not None and self._left <= 0.0
