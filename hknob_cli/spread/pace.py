"""How many items to hand out at once: by what the last ones took."""

from math import ceil

SECONDS = 6.0  # that a piece of work should take: long beside its handing over, short beside the whole
MOST = 65_536  # items in a piece, which bounds the memory that it takes
GROWTH = 4.0  # from one piece to the next, at most


class Pace:
    """Sizes of pieces by measured cost."""

    def __init__(self, *, first: int = 8, most: int = MOST) -> None:
        self._size = float(first)
        self._most = most

    def learn(self, items: int, seconds: float) -> None:
        """A piece of so many items took so long."""
        wanted = items * SECONDS / max(seconds, 1e-6)
        self._size = min(max(1.0, wanted), GROWTH * max(self._size, 1.0), float(self._most))

    def size(self, left: int, workers: int) -> int:
        """Items for the next piece: fewer towards the end, so that all workers end together."""
        return max(1, min(int(self._size), ceil(left / (2 * workers))))
