"""A limit of time on a search: heard between its slices, and inside compiled code by a flag that its loops look at."""

from threading import Timer
from time import monotonic
from types import TracebackType
from typing import Any


class Alarm:
    """Sets ``halt[0]`` above 0 when ``seconds`` are over, if they are limited; ``halt`` None: there is no such flag."""

    def __init__(self, seconds: float | None, halt: Any = None) -> None:
        self._ends = None if seconds is None else monotonic() + seconds
        self._halt = halt
        self._timer: Timer | None = None
        if seconds is not None and halt is not None:
            self._timer = Timer(seconds, self._ring)
            self._timer.daemon = True

    def __enter__(self) -> "Alarm":
        if self._timer:
            self._timer.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._timer:
            self._timer.cancel()

    def _ring(self) -> None:
        self._halt[0] = 1.0

    @property
    def limited(self) -> bool:
        """Whether there is a limit."""
        return self._ends is not None

    @property
    def over(self) -> bool:
        """Whether the time is over, and a search that looks at the flag has heard it."""
        if self._halt is not None:
            return bool(self._halt[0] > 0.0)
        return self._ends is not None and monotonic() >= self._ends
