"""How many items to hand out at once: by what the last ones took."""

from math import ceil

SECONDS = 6.0  # that a piece of work should take: long beside its handing over, short beside the whole
SHORTEST = 0.05  # s that its last pieces should take: beside that, what it costs to hand one over is still little
MOST = 65_536  # items in a piece, which bounds the memory that it takes
GROWTH = 4.0  # from one piece to the next, at most


class Pace:
    """Sizes of pieces by measured cost."""

    def __init__(self, *, first: int = 8, most: int = MOST) -> None:
        self._size = float(first)
        self._most = most
        self._least = 0  # items that take the shortest time at the slowest rate so far, once a piece tells

    def learn(self, items: int, seconds: float) -> None:
        """A piece of so many items took so long."""
        rate = items / max(seconds, 1e-6)
        self._size = min(max(1.0, rate * SECONDS), GROWTH * max(self._size, 1.0), float(self._most))
        if seconds >= SHORTEST:
            least = max(1, int(rate * SHORTEST))
            self._least = min(self._least or least, least)

    def size(self, left: int, workers: int) -> int:
        """Items for the next piece: fewer towards the end, so that all workers end together."""
        return max(1, min(int(self._size), max(self._least, ceil(left / (2 * workers)))))
