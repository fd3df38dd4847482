"""All clock phases of one start under a controller: arcs of states, cut where a sample or a look meets a count edge.

As in `engine.sets.arc`: the states n samples on differ as free motions do, D(n + phi) - D(n + middle), where D(t) is
the free motion about its rest point at the time t after the start.
"""

from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.plant_batch import Array
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.sets.arc_cut import extent, free_motion, part_within, turn_after
from hknob_cli.engine.turning import zero_spacing


class Flight(NamedTuple):
    """The free motion of a cell from its start: plant, and the start told from the rest point; ``blur`` of all that."""

    alpha: float
    beta: float
    dx: float
    dv: float
    blur: float


def make_flight(alpha: float, beta: float, gamma: float, x: float, v: float) -> Flight:
    """The flight of a start at ``x`` counts and ``v`` counts a sample, under the push alone."""
    rest, root = -gamma / beta, beta**0.5
    scale = abs(x - rest) + abs(v) / root
    return Flight(alpha, beta, x - rest, v, 64.0 * EPSILON * (1.0 + root / alpha) * (scale + abs(rest)))


class Arcs:
    """Arcs of clock phases; ``cell`` numbers their flights; told from the state of the phase ``centre`` of each."""

    def __init__(
        self, flights: list[Flight], cell: np.ndarray, low: Array, high: Array, centre: Array, samples: int
    ) -> None:
        """Arcs from ``low`` to ``high``, ``samples`` after the first one."""
        self.flights, self.cell, self.low, self.high, self.centre = flights, cell, low, high, centre
        self.samples = samples

    def _like(self, cell: np.ndarray, low: Array, high: Array, centre: Array) -> "Arcs":
        return Arcs(self.flights, cell, low, high, centre, self.samples)

    def take(self, sets: np.ndarray) -> "Arcs":
        """Some of them, by index."""
        return self._like(self.cell[sets], self.low[sets], self.high[sets], self.centre[sets])

    def join(self, other: "Arcs") -> "Arcs":
        """These, then others."""
        pairs = zip(
            (self.cell, self.low, self.high, self.centre),
            (other.cell, other.low, other.high, other.centre),
            strict=True,
        )
        return self._like(*(np.concatenate(pair) for pair in pairs))

    def share(self) -> Array:
        """Their lengths."""
        return self.high - self.low

    def blur(self, sets: np.ndarray) -> Array:
        """Rounding of the free motion."""
        return np.array([self.flights[cell].blur for cell in self.cell[sets]])

    def _begin(self, cell: int, after: float) -> tuple[float, float]:
        """The flight at the sample, of phase 0."""
        flight = self.flights[cell]
        found: tuple[float, float] = free_motion(self.samples + after, flight.dx, flight.dv, flight)
        return found

    def radius(self, sets: np.ndarray) -> Array:
        """The length on either side times the largest speed along it."""
        begin = {cell: self._begin(cell, 0.0) for cell in set(self.cell[sets].tolist())}
        found = np.empty(len(sets))
        for i, one in enumerate(sets):
            cell, low = int(self.cell[one]), float(self.low[one])
            flight = self.flights[cell]
            x, v = free_motion(low, *begin[cell], flight)
            rate = -flight.beta * x - flight.alpha * v
            length = max(float(self.high[one]) - float(self.centre[one]), float(self.centre[one]) - low)
            found[i] = length * (v * v + rate * rate / flight.beta) ** 0.5
        return found * (1.0 + 64.0 * EPSILON)

    def extent(self, sets: np.ndarray, after: float) -> tuple[Array, Array]:
        """Least and largest position less the centre's."""
        found = np.empty((2, len(sets)))
        for i, one in enumerate(sets):
            cell = int(self.cell[one])
            flight, begin = self.flights[cell], self._begin(cell, after)
            middle, _ = free_motion(float(self.centre[one]), *begin, flight)
            least, most = extent(float(self.low[one]), float(self.high[one]), *begin, flight)
            found[:, i] = least - middle, most - middle
        return found[0], found[1]

    def cut(self, sets: np.ndarray, after: float, low: Array, high: Array) -> tuple[np.ndarray, "Arcs"]:
        """Phases between two positions, in one part or several."""
        which: list[int] = []
        firsts: list[float] = []
        lasts: list[float] = []
        for one, least, most in zip(sets.tolist(), low.tolist(), high.tolist(), strict=True):
            cell = int(self.cell[one])
            flight, begin = self.flights[cell], self._begin(cell, after)
            middle, _ = free_motion(float(self.centre[one]), *begin, flight)
            at, last_phase = float(self.low[one]), float(self.high[one])
            turn, spacing = turn_after(at, *begin, flight), zero_spacing(flight.alpha, flight.beta)
            own, more = len(which), True
            while more:
                end = min(turn, last_phase)
                first, last = part_within(least, most, at, end, -middle, *begin, flight)
                if first <= last:
                    if len(which) > own and first <= lasts[-1]:
                        lasts[-1] = last
                    else:
                        which.append(one)
                        firsts.append(first)
                        lasts.append(last)
                more = end < last_phase
                at, turn = end, turn + spacing
        of = np.array(which, dtype=np.int64)
        return of, self._like(self.cell[of], np.array(firsts), np.array(lasts), self.centre[of])

    def recentre(self, sets: np.ndarray) -> tuple[Array, Array]:
        """Tell them from the phase in their middle."""
        shift = np.empty((2, len(sets)))
        for i, one in enumerate(sets):
            cell = int(self.cell[one])
            flight, begin = self.flights[cell], self._begin(cell, 0.0)
            old, new = float(self.centre[one]), 0.5 * (float(self.low[one]) + float(self.high[one]))
            from_x, from_v = free_motion(old, *begin, flight)
            to_x, to_v = free_motion(new, *begin, flight)
            shift[:, i] = to_x - from_x, to_v - from_v
            self.centre[one] = new
        return shift[0], shift[1]

    def advance(self) -> None:
        """Go on by one sample."""
        self.samples += 1
