"""Convex polygons of states under a controller, many side by side, cut where a sample or a look meets a count edge.

As in `engine.sets.polygon`: the corners differ from the centre, n samples on, by Phi^n times what they differed at
first, and are computed only where they matter.
"""

import numpy as np

from hknob_cli.controllers.plant_batch import Array
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.propagator import hold_coefficients

CORNERS = 12  # that a polygon keeps; one with more is halved


class Plants:
    """Free responses of cells over whole samples, and parts of one; computed when they are first asked for."""

    def __init__(self, alpha: Array, beta: Array) -> None:
        """Plants of cells, each array (cells,)."""
        self.alpha, self.beta = alpha, beta
        self.blur = 64.0 * EPSILON * (1.0 + np.sqrt(beta) / alpha)
        self._powers = np.empty((len(alpha), 0, 3))
        self._parts: dict[float, Array] = {}

    def over(self, cell: np.ndarray, samples: np.ndarray) -> Array:
        """S, G, F of each over so many samples, (3, lanes)."""
        most = int(samples.max(initial=0)) + 1
        known = self._powers.shape[1]
        if most > known:
            more = [[self._one(i, float(n)) for n in range(known, 2 * most)] for i in range(len(self.alpha))]
            self._powers = np.concatenate([self._powers, np.array(more)], axis=1)
        return np.asarray(self._powers[cell, samples].T)

    def within(self, cell: np.ndarray, after: float) -> Array:
        """S, G, F of each over a part of a sample, (3, lanes)."""
        if after not in self._parts:
            self._parts[after] = np.array([self._one(i, after) for i in range(len(self.alpha))])
        return np.asarray(self._parts[after][cell].T)

    def _one(self, cell: int, time: float) -> tuple[float, float, float]:
        found: tuple[float, float, float] = hold_coefficients(float(self.alpha[cell]), float(self.beta[cell]), time)
        return found


class Polygons:
    """Polygons of ``corners`` (sets, K, 2), of which the first ``count`` count, told from centres, ``age`` samples ago.

    ``cell`` numbers their plants, ``weight`` is the part of all starts that each holds.
    """

    def __init__(
        self, plants: Plants, cell: np.ndarray, corners: Array, count: np.ndarray, age: np.ndarray, weight: Array
    ) -> None:
        """As they are."""
        self.plants, self.cell, self.corners, self.count, self.age = plants, cell, corners, count, age
        self.weight = weight
        self.first = _farthest(corners, count, plants.beta[cell])

    def take(self, sets: np.ndarray) -> "Polygons":
        """Some of them, by index."""
        other = object.__new__(Polygons)
        other.plants, other.first = self.plants, self.first[sets]
        other.cell, other.corners, other.count = self.cell[sets], self.corners[sets], self.count[sets]
        other.age, other.weight = self.age[sets], self.weight[sets]
        return other

    def join(self, other: "Polygons") -> "Polygons":
        """These, then others."""
        both = object.__new__(Polygons)
        both.plants = self.plants
        for name in ("cell", "corners", "count", "age", "weight", "first"):
            setattr(both, name, np.concatenate([getattr(self, name), getattr(other, name)]))
        return both

    def share(self) -> Array:
        """Their parts of all starts."""
        return self.weight

    def blur(self, sets: np.ndarray) -> Array:
        """Rounding of the free response."""
        return np.asarray(self.plants.blur[self.cell[sets]] * self.first[sets])

    def now(self, sets: np.ndarray) -> Array:
        """Corners at this sample, (sets, K, 2)."""
        s, g, f = self.plants.over(self.cell[sets], self.age[sets])[:, :, None]
        beta = self.plants.beta[self.cell[sets]][:, None]
        dx, dv = self.corners[sets, :, 0], self.corners[sets, :, 1]
        return np.stack([dx + (s * dv - beta * g * dx), f * dv - beta * s * dx], axis=2)

    def radius(self, sets: np.ndarray) -> Array:
        """Largest distance of a corner from the centre."""
        found = _farthest(self.now(sets), self.count[sets], self.plants.beta[self.cell[sets]])
        return np.asarray(np.minimum(found, self.first[sets]) + self.blur(sets))

    def _places(self, sets: np.ndarray, corners: Array, after: float) -> Array:
        """Positions of corners a part of a sample on, (sets, K)."""
        if after == 0.0:
            return np.asarray(corners[:, :, 0])
        s, g, _ = self.plants.within(self.cell[sets], after)[:, :, None]
        beta = self.plants.beta[self.cell[sets]][:, None]
        return np.asarray(corners[:, :, 0] + (s * corners[:, :, 1] - beta * g * corners[:, :, 0]))

    def extent(self, sets: np.ndarray, after: float) -> tuple[Array, Array]:
        """Least and largest position less the centre's."""
        places = self._places(sets, self.now(sets), after)
        there = _there(self.count[sets], places.shape[1])
        return np.where(there, places, np.inf).min(axis=1), np.where(there, places, -np.inf).max(axis=1)

    def cut(self, sets: np.ndarray, after: float, low: Array, high: Array) -> tuple[np.ndarray, "Polygons"]:
        """Parts between two positions; those with too many corners in halves."""
        corners, count = self.now(sets), self.count[sets]
        whole = _area(corners, count)
        for limit, sign in ((low, 1.0), (high, -1.0)):
            corners, count = clip(corners, count, sign * self._places(sets, corners, after), sign * limit)
        kept = np.flatnonzero(count > 0)
        of, corners, count, whole = sets[kept], corners[kept], count[kept], whole[kept]
        corners, count, back = halved(corners, count)
        of, whole = of[back], whole[back]
        with np.errstate(all="ignore"):
            part = np.minimum(_area(corners, count) / whole, 1.0)
        weight = self.weight[of] * np.where(whole > 0.0, part, 1.0)
        return of, Polygons(self.plants, self.cell[of], corners, count, np.zeros(len(of), dtype=np.int64), weight)

    def recentre(self, sets: np.ndarray) -> tuple[Array, Array]:
        """Tell them from the middle of the rectangle around them."""
        corners, there = self.now(sets), _there(self.count[sets], self.corners.shape[1])[:, :, None]
        low = np.where(there, corners, np.inf).min(axis=1)
        high = np.where(there, corners, -np.inf).max(axis=1)
        middle = 0.5 * (low + high)
        self.corners[sets], self.age[sets] = corners - middle[:, None, :], 0
        self.first[sets] = _farthest(self.corners[sets], self.count[sets], self.plants.beta[self.cell[sets]])
        return middle[:, 0], middle[:, 1]

    def advance(self) -> None:
        """Go on by one sample."""
        self.age = self.age + 1


def box_polygons(plants: Plants, wide: Array, fast: Array) -> Polygons:
    """A rectangle of each cell around its centre, ``wide`` counts and ``fast`` counts a sample to either side."""
    corners = np.zeros((len(wide), CORNERS, 2))
    corners[:, :4, 0] = np.stack([-wide, wide, wide, -wide], axis=1)
    corners[:, :4, 1] = np.stack([-fast, -fast, fast, fast], axis=1)
    count = np.full(len(wide), 4)
    return Polygons(
        plants, np.arange(len(wide)), corners, count, np.zeros(len(wide), dtype=np.int64), np.ones(len(wide))
    )


def clip(corners: Array, count: np.ndarray, places: Array, limit: Array) -> tuple[Array, np.ndarray]:
    """The parts of convex polygons where ``places`` (sets, K), linear in the corners, are at least ``limit``.

    One more corner may come of it; what lies on the limit is kept.
    """
    sets, size, _ = corners.shape
    slots = np.arange(size)
    there = slots < count[:, None]
    follow = np.where(slots + 1 < count[:, None], slots + 1, 0)
    rows = np.arange(sets)[:, None]
    inside = there & (places >= limit[:, None])
    crossing = there & (inside != inside[rows, follow])
    with np.errstate(all="ignore"):
        part = (limit[:, None] - places) / (places[rows, follow] - places)
        between = corners + np.clip(part, 0.0, 1.0)[:, :, None] * (corners[rows, follow] - corners)
    found = np.empty((sets, 2 * size, 2))
    found[:, 0::2], found[:, 1::2] = corners, between
    keep = np.empty((sets, 2 * size), dtype=bool)
    keep[:, 0::2], keep[:, 1::2] = inside, crossing
    order = np.argsort(~keep, axis=1, kind="stable")[:, : size + 1]
    kept = keep.sum(axis=1)
    return np.where((np.arange(size + 1) < kept[:, None])[:, :, None], found[rows, order], 0.0), kept


def halved(corners: Array, count: np.ndarray) -> tuple[Array, np.ndarray, np.ndarray]:
    """Polygons with at most `CORNERS` corners, of which each is a part; others by a line between opposite corners."""
    many = np.flatnonzero(count > CORNERS)
    back = np.concatenate([np.arange(len(count)), many])
    if many.size == 0:
        return corners[:, :CORNERS], count, back
    other, others = np.zeros_like(corners[many]), np.empty(len(many), dtype=np.int64)
    for i, one in enumerate(many):
        n = int(count[one])
        middle = n // 2
        rest = np.concatenate([corners[one, middle:n], corners[one, :1]])
        other[i, : len(rest)], others[i] = rest, len(rest)
        corners[one, middle + 1 :], count[one] = 0.0, middle + 1
    return np.concatenate([corners, other])[:, :CORNERS], np.concatenate([count, others]), back


def _there(count: np.ndarray, size: int) -> np.ndarray:
    return np.asarray(np.arange(size) < count[:, None])


def _farthest(corners: Array, count: np.ndarray, beta: Array) -> Array:
    squares = corners[:, :, 0] ** 2 + corners[:, :, 1] ** 2 / beta[:, None]
    found = np.sqrt(np.where(_there(count, corners.shape[1]), squares, 0.0).max(axis=1, initial=0.0))
    return np.asarray(found * (1.0 + 8.0 * EPSILON))


def _area(corners: Array, count: np.ndarray) -> Array:
    """Areas, by the triangles from the first corner."""
    x, v = (corners[:, :, k] - corners[:, :1, k] for k in (0, 1))
    cross = x[:, :-1] * v[:, 1:] - x[:, 1:] * v[:, :-1]
    there = np.arange(1, corners.shape[1]) < count[:, None]
    return np.asarray(0.5 * np.abs(np.where(there, cross, 0.0).sum(axis=1)))
