"""Samples of proven orbits, and which sets of states each captures.

The proof of an orbit (`remedies.proof`) says how far a motion may be from it, memory included, and stay with it for
ever. A set is captured where its centre's distance, what its radius amounts to, and all roundings are less than that.
"""

from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, take
from hknob_cli.controllers.plant_batch import Array
from hknob_cli.controllers.proof import Hold, prove
from hknob_cli.controllers.search import alike
from hknob_cli.controllers.sets.counting import Counting

SURE = 0.999  # of an orbit's reach
POINTS = 8  # samples of an orbit that are compared with, where the count falls
LONG = 1024  # samples of a period, from which on only two are


class Point(NamedTuple):
    """A sample of an orbit: the ``end`` of its cell that it is; ``rows``, ``scale`` (rows,), ``form`` (rows, rows).

    ``seen`` (looks,); ``frozen`` (rows,); ``reach`` as in `proof.Hold`; ``stretch``: the most that the distance there
    is, of a difference of position and velocity alone with a distance of 1 in the free plant's norm; ``near``: the
    largest difference of position within reach; ``deeper``: whether the count falls there.
    """

    end: int
    rows: Array
    scale: Array
    form: Array
    seen: Array | None
    frozen: np.ndarray
    reach: float
    stretch: float
    near: float
    deeper: bool


class Captors:
    """What is known of each of some cells; ``beta``: hand stiffness of each."""

    def __init__(self, beta: Array, counting: Counting) -> None:
        """None is known yet."""
        self.beta, self.counting = beta, counting
        self.points: list[list[Point]] = [[] for _ in beta]
        self._tables: dict[bool, tuple[Array, Array]] = {}

    def enter(self, cell: int, point: Point) -> None:
        """A point more of a cell."""
        self.points[cell].append(point)
        self._tables = {}

    def _table(self, deeper: bool) -> tuple[Array, Array]:
        """Positions and widths of the points of a kind, (cells, most points of one); absent ones are at infinity."""
        if deeper not in self._tables:
            most = max(len(some) for some in self.points)
            x, near = np.full((len(self.points), most), np.inf), np.zeros((len(self.points), most))
            for cell, some in enumerate(self.points):
                for k, point in enumerate(some):
                    if point.deeper == deeper:
                        x[cell, k], near[cell, k] = point.rows[0], point.near
            self._tables[deeper] = x, near
        return self._tables[deeper]

    def capture(self, cell: np.ndarray, state: State, reach: Array, sets: np.ndarray, deeper: bool) -> Array:
        """Of ``sets``, by index, the end of its cell that captures each; -1 for none.

        ``cell`` and ``reach``, radius and error together, of all sets. ``deeper``: where their counts fall.
        """
        found = np.full(len(sets), -1)
        x, near = self._table(deeper)
        if x.shape[1] == 0 or len(sets) == 0:
            return found
        of = cell[sets]
        for i, k in zip(*np.nonzero(np.abs(state.x[sets][:, None] - x[of]) <= near[of]), strict=True):
            if found[i] < 0 and self._holds(self.points[of[i]][k], state, int(sets[i]), float(reach[sets[i]])):
                found[i] = self.points[of[i]][k].end
        return found

    def _holds(self, point: Point, state: State, one: int, reach: float) -> bool:
        if not reach * point.stretch < point.reach:
            return False
        if state.seen is not None and point.seen is not None:
            told = self.counting.told
            if (told(state.seen[:, one]) != told(point.seen)).any():
                return False
        off = np.concatenate([[state.x[one], state.v[one]], state.memory[:, one]]) - point.rows
        if (off[point.frozen] != 0.0).any():
            return False
        off /= point.scale
        return bool(max(0.0, float(off @ point.form @ off)) ** 0.5 + reach * point.stretch < point.reach)


def make_points(
    mover: BatchStepper, begin: State, period: np.ndarray, ends: np.ndarray, beta: Array, counting: Counting
) -> list[tuple[int, Point]]:
    """Points of orbits of ``period`` samples, one a lane, whose periods ``begin`` so, that are proven: lane and point.

    Where a count falls, a few of each; of what never falls its beginning. ``ends``: what orbits are called.
    """
    lanes: list[int] = []
    states: list[State] = []
    falls: list[bool] = []
    for lane, (at, falling) in enumerate(_samples(mover, begin, period, counting)):
        lanes += [lane] * len(at)
        states += at
        falls += [falling] * len(at)
    every = State(
        np.array([one.x for one in states]),
        np.array([one.v for one in states]),
        np.stack([one.memory for one in states], axis=1),
        None if begin.seen is None else np.stack([one.seen for one in states if one.seen is not None], axis=1),
    )
    of = np.array(lanes)
    found = []
    for part in alike(period[of], (len(every.memory) + 3) * (len(mover.remedy.looks) + 5)):
        some = take(every, part)
        orbits = prove(mover.take(of[part]), some, period[of[part]])
        for i, k in enumerate(part):
            if orbits.proven[i]:
                lane, seen = int(of[k]), None if some.seen is None else some.seen[:, i]
                found.append((lane, _point(int(ends[lane]), orbits.hold, i, seen, float(beta[lane]), falls[k])))
    return found


def _samples(
    mover: BatchStepper, state: State, period: np.ndarray, counting: Counting
) -> list[tuple[list[State], bool]]:
    """Of each orbit, states at some samples at which its count falls, and True; its beginning and False without any."""
    begin, lanes = state, np.arange(len(state.x))
    falls: list[list[State]] = [[] for _ in lanes]
    counts = [counting.at(state.x)]
    for i in range(1, int(period.max()) + 1):
        state = mover.step(state).state
        counts.append(counting.at(state.x))
        for lane in np.flatnonzero((counts[-1] < counts[-2]) & (i <= period)).tolist():
            falls[lane].append(take(state, lane))
    found = []
    for lane, some in enumerate(falls):
        if not some:
            found.append(([take(begin, lane)], False))
            continue
        number = min(2 if period[lane] >= LONG else POINTS, len(some))
        found.append(([some[k * len(some) // number] for k in range(number)], True))
    return found


def _point(end: int, hold: Hold, i: int, seen: Array | None, beta: float, deeper: bool) -> Point:
    form, scale = hold.form[i], hold.scale[:, i]
    unit = np.array([1.0, np.sqrt(beta)]) / scale[:2]
    stretch = float(np.sqrt(np.linalg.eigvalsh(form[:2, :2] * np.outer(unit, unit)).max())) * (1.0 + 1e-9)
    reach = max(0.0, SURE * float(hold.reach[i]))
    near = reach * float(np.sqrt(np.linalg.inv(form)[0, 0])) * float(scale[0]) * (1.0 + 1e-9)
    return Point(
        end,
        hold.rows[:, i].copy(),
        scale.copy(),
        form.copy(),
        seen,
        hold.frozen[i].copy(),
        reach,
        stretch,
        near,
        deeper,
    )
