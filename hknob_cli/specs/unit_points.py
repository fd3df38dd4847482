"""A design, and its points in the unit cube, by number: any run of them, the same however the runs are cut.

Sobol and Halton sequences and the Latin hypercube are scipy.stats.qmc's, scrambled by the seed; random points are those
of numpy's PCG64. Point i of a sequence does not depend on how many points follow it.
"""

from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from numpy.typing import NDArray

SOBOL, HALTON, LATIN, RANDOM = "sobol", "halton", "latin_hypercube", "random"
# There are 2**30 points of a Sobol sequence; a Latin hypercube is kept whole; a sweep may span as many as the others.
MOST_POINTS = {SOBOL: 10**9, HALTON: 10**13, LATIN: 1_000_000, RANDOM: 10**13}


class Points(NamedTuple):
    """A design: ``number`` points by a ``method`` (sobol, halton, latin_hypercube, random) and its ``seed``.

    ``scales``: log or lin, by the name of each axis that is a range; the axis then holds its two ends.
    """

    method: str
    number: int
    seed: int
    scales: dict[str, str]


@lru_cache(maxsize=4)
def unit_points(method: str, *, count: int, dimensions: int, seed: int) -> "UnitPoints":
    """The points of a design, the same object for all who ask: where it stands, the next run begins at once."""
    return UnitPoints(method, count=count, dimensions=dimensions, seed=seed)


class UnitPoints:
    """A design of ``count`` points in ``dimensions`` dimensions."""

    def __init__(self, method: str, *, count: int, dimensions: int, seed: int) -> None:
        self.method = method
        self.count = count
        self.dimensions = dimensions
        self.seed = seed
        # Sequences that stand somewhere, each used by one thread at a time; a Sobol sequence only goes forward.
        self._parked: list[tuple[int, Any]] = []
        self._whole: NDArray[Any] | None = None

    def run(self, start: int, stop: int) -> "NDArray[Any]":
        """Points ``start`` to ``stop``: (stop - start, dimensions), each number in [0, 1)."""
        import numpy as np

        if stop <= start or self.dimensions == 0:
            return np.empty((max(0, stop - start), self.dimensions))
        if self.method == RANDOM:
            bits = np.random.PCG64(self.seed).advance(start * self.dimensions)  # a number takes one step
            return np.random.Generator(bits).random((stop - start, self.dimensions))
        from scipy.stats import qmc

        if self.method == LATIN:
            if self._whole is None:
                self._whole = np.asarray(qmc.LatinHypercube(self.dimensions, rng=self.seed).random(self.count))
            return self._whole[start:stop]
        if self.method == HALTON:
            engine = qmc.Halton(self.dimensions, rng=self.seed)
            engine.num_generated = start  # its fast_forward makes all points before
            return np.asarray(engine.random(stop - start))
        return self._sobol(start, stop)

    def _sobol(self, start: int, stop: int) -> "NDArray[Any]":
        import numpy as np
        from scipy.stats import qmc

        try:
            at, engine = self._parked.pop()
        except IndexError:
            at, engine = start + 1, None
        if at > start:
            at, engine = 0, qmc.Sobol(self.dimensions, rng=self.seed)
        if at < start:
            engine.fast_forward(start - at)
        # The first point alone: scipy warns of a first draw that is no power of two, as if there were no more to come.
        first = [engine.random(1)] if start == 0 else []
        rest = stop - start - len(first)
        found = np.concatenate([*first, *([engine.random(rest)] if rest else [])])
        self._parked.append((stop, engine))
        return found

    def __getstate__(self) -> dict[str, Any]:
        """What another process needs: not where sequences stand here."""
        return {**self.__dict__, "_parked": [], "_whole": None}
