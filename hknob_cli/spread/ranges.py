"""What is left to do of numbered items: ranges, from which work is cut in order."""

from collections.abc import Iterable
from typing import NamedTuple


class Range(NamedTuple):
    """Items ``start`` to ``stop``; ``deaths``: how often the worker that had them was lost."""

    start: int
    stop: int
    deaths: int = 0

    @property
    def items(self) -> int:
        """How many they are."""
        return self.stop - self.start


class Ranges:
    """Ranges in order; no piece cut from them crosses a multiple of ``part``, and cuts are at multiples of ``unit``."""

    def __init__(
        self, total: int, *, done: Iterable[tuple[int, int]] = (), part: int | None = None, unit: int = 1
    ) -> None:
        """All of ``total`` items but those that are ``done``."""
        self.part = part or max(1, total)
        self.unit = unit
        self._left: list[Range] = []  # the lowest last
        begin = 0
        for start, stop in [*sorted(done), (total, total)]:
            if start > begin:
                self._left.append(Range(begin, start))
            begin = max(begin, stop)
        self._left.reverse()

    def __len__(self) -> int:
        """Number of items left."""
        return sum(one.items for one in self._left)

    @property
    def deaths(self) -> int:
        """How often workers that had the lowest items were lost; 0 if none are left."""
        return self._left[-1].deaths if self._left else 0

    def take(self, most: int) -> Range:
        """The lowest items, at most ``most`` of them, or twice as many where that leaves none of a part.

        Raises `IndexError` if none are left.
        """
        first = self._left.pop()
        stop = min(first.stop, (first.start // self.part + 1) * self.part)
        if 2 * most < stop - first.start:
            stop = min(stop, (first.start // self.unit + max(1, most // self.unit)) * self.unit)
        if stop < first.stop:
            self._left.append(first._replace(start=stop))
        return first._replace(stop=stop)

    def put_back(self, gone: Iterable[Range]) -> None:
        """Items that nobody is at any more, for no fault of theirs."""
        self._left += gone
        self._left.sort(reverse=True)

    def give_back(self, lost: Iterable[Range]) -> None:
        """Items whose worker was lost, to be done again in halves: they may have been too many for its memory."""
        for one in lost:
            units = -(-one.items // self.unit)
            middle = min(one.stop, one.start + (units + 1) // 2 * self.unit)
            halves = [Range(one.start, middle, one.deaths + 1), Range(middle, one.stop, one.deaths + 1)]
            self._left += [half for half in halves if half.items]
        self._left.sort(reverse=True)
