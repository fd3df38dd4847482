"""A bound on what a knob does under every clock whose intervals lie between two lengths: cells, made finer and finer.

`clock_cells` has the proof. All motions from a start are followed on one grid; what may go on for ever is then covered
by cells half as wide, and trimmed again, as long as that pays.
"""

from collections.abc import Callable, Sequence
from math import ceil, floor, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.clock_cells import HOLD, LEVELS, THERE, Cells, Joined, rounded
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.interval import SHORTEST
from hknob_cli.engine.propagator import hold_coefficients

MOST_CELLS = 4_000_000  # of a grid, with those in which nothing is
MOST_VISITS = 60_000_000  # of successors, in one pass
GROWS = 6  # times as many visits, about, with cells half as wide
START_PARTS = 2048  # of the time to the first sample
ROOM = 1.5  # times as far as motions begin, at first
TRIES = 3  # regions, each twice as wide

Array = NDArray[np.float64]


class Region(NamedTuple):
    """Positions and speeds between two of each, in counts and longest intervals."""

    left: float
    right: float
    low: float
    high: float


def is_bounded(body: Body, wall: Controller, delay: int) -> bool:
    """Whether every clock can be followed at once: the state is angle and speed, and the torque that of a reading."""
    plain = body.order == 2 and body.friction == 0.0 and body.alpha > 0.0 and body.beta > 0.0 and body.cogs is None
    return plain and delay == 0 and wall.hysteresis == 0.0 and wall.damping == 0.0 and wall.analog == 0.0


def parts_of(body: Body, shortest: float) -> Array:
    """S, G and F as `Cells.parts` has them."""
    times = [shortest + (1.0 - shortest) * (i + 0.5) / 2**level for level in range(LEVELS) for i in range(2**level)] + [
        (i + 0.5) / HOLD for i in range(HOLD)
    ]
    return np.array([hold_coefficients(body.alpha, body.beta, t) for t in times]).ravel()


def start_regions(body: Body, start: Sequence[float]) -> list[Region]:
    """Where the first sample may be, anywhere from the start to an interval later; no torque is commanded yet."""
    x, v = start[0], start[1]
    y = body.drive - body.beta * x
    fast = abs(v) + abs(y)
    hard = abs(y) + (body.alpha + body.beta) * fast
    half, found = 0.5 / START_PARTS, []
    for i in range(START_PARTS):
        s, g, f = hold_coefficients(body.alpha, body.beta, (i + 0.5) / START_PARTS)
        at, pace = x + s * v + g * y, f * v + s * y
        wide = rounded(x, fast, hard, 0.0, body)
        off_x, off_v = half * (abs(pace) + half * hard) + wide, half * hard + wide
        found.append(Region(at - off_x, at + off_x, pace - off_v, pace + off_v))
    return found


def start_region(starts: Sequence[Sequence[float]]) -> list[Region]:
    """The least that has all of some states at the first sample."""
    (left, low), (right, high) = (tuple(end(one[i] for one in starts) for i in (0, 1)) for end in (min, max))
    return [Region(left, right, low, high)]


class _Covered(NamedTuple):
    """A grid, what is in its cells, and those that are left: (filled,)."""

    cells: Cells
    state: Any
    queue: Any
    filled: int


class ClockBound:
    """Finds the bound of one cell by compiled functions."""

    def __init__(self, functions: dict[str, Callable[..., Any]], body: Body, wall: Controller) -> None:
        """``body``: with arrays; ``wall``: with a clock."""
        self._reach = functions["general.reach_cells"]
        self._trim = functions["general.trim_cells"]
        self._widest = functions["general.widest_range"]
        self._body, self._wall = body, wall
        self._shortest = float(wall.clock[SHORTEST])
        self._parts = parts_of(body, self._shortest)
        self._boxes = np.zeros(4 * 2 ** (LEVELS - 1), np.int64)
        self.visits = 0

    def range(self, starts: Sequence[Region]) -> float | None:
        """Widest range of positions, counts, of a motion in the end; 0: all come to rest; None: none is found.

        None, too, once ``halt`` of the body is above 0.

        ``starts``: where the first sample may be.
        """
        body, wall = self._body, self._wall
        far = ROOM * max(2.0, *(max(-one.left, one.right) for one in starts), body.push / (body.beta + wall.kappa))
        fast = ROOM * (max(max(-one.low, one.high) for one in starts) + far * sqrt(body.beta + wall.kappa))
        for _ in range(TRIES):
            covered = self._covered(starts, far, fast)
            if covered is not None or self._body.halt[0] > 0.0:
                return self._refined(covered)
            far, fast = 2.0 * far, 2.0 * fast
        return None

    def _grid(self, fineness: int, box: tuple[int, int, int, int], *, whole: bool) -> Cells:
        """Cells a part of a count wide; ``box``: first column and row, and numbers of them."""
        left, low, columns, rows = box
        width = 1.0 / fineness
        return Cells(
            width=width,
            height=width * sqrt(self._body.beta),
            left=left,
            low=low,
            columns=columns,
            rows=rows,
            shortest=self._shortest,
            whole=whole,
            parts=self._parts,
            boxes=self._boxes,
        )

    def _covered(self, starts: Sequence[Region], far: float, fast: float) -> _Covered | None:
        """What motions from the starts may come into, as fine as the number of cells allows."""
        fineness, height = 1, sqrt(self._body.beta)
        while 16.0 * far * fast * fineness * fineness / height < MOST_CELLS:
            fineness *= 2
        columns, rows = ceil(far * fineness), ceil(fast * fineness / height)
        if 4 * columns * rows > MOST_CELLS:
            return None
        cells = self._grid(fineness, (-columns, -rows, 2 * columns, 2 * rows), whole=True)
        state, queue = np.zeros(4 * columns * rows, np.int8), np.zeros(8 * columns * rows, np.int64)
        for one in starts:
            # A state on a count's edge may have the command of either side, as the encoder rounds.
            first, last = ceil(one.left / cells.width) - 1 + columns, floor(one.right / cells.width) + columns
            under, over = (floor(v / cells.height) + rows for v in (one.low, one.high))
            state.reshape(2 * columns, 2 * rows)[first : last + 1, under : over + 1] = THERE
        begun = np.flatnonzero(state)
        queue[: len(begun)] = begun
        filled, visits = self._reach(state, queue, len(begun), MOST_VISITS, cells, self._body, self._wall)
        self.visits += visits
        return _Covered(cells, state, queue, filled) if filled >= 0 else None

    def _refined(self, covered: _Covered | None) -> float | None:
        """The range, of cells that are halved as often as the work allows; None once halted."""
        best = None
        while covered is not None:
            cells, state, queue, filled = covered
            degree = np.zeros(len(state), np.int64)
            filled, visits = self._trim(state, queue, filled, degree, cells, self._body, self._wall)
            self.visits += visits
            if filled <= 0:
                return 0.0 if filled == 0 else None
            joined = Joined(np.zeros(len(state), np.int64), degree, np.zeros(filled), np.zeros(filled))
            found = self._widest(state, queue, filled, joined, cells, self._body, self._wall)
            best = found if best is None else min(best, found)
            covered = self._halved(cells, queue[:filled]) if GROWS * visits <= MOST_VISITS else None
        return best

    def _halved(self, cells: Cells, left: Any) -> _Covered | None:
        """The cells that are left, each as four; None where the grid about them has too many."""
        column, row = left // cells.rows + cells.left, left % cells.rows + cells.low
        first, under = int(column.min()), int(row.min())
        columns, rows = 2 * (int(column.max()) - first + 1), 2 * (int(row.max()) - under + 1)
        if columns * rows > MOST_CELLS:
            return None
        fine = self._grid(round(2.0 / cells.width), (2 * first, 2 * under, columns, rows), whole=False)
        state = np.zeros(columns * rows, np.int8)
        at = (2 * (column - first)) * rows + 2 * (row - under)
        for one in (at, at + 1, at + rows, at + rows + 1):
            state[one] = THERE
        there = np.flatnonzero(state)
        queue = np.zeros(2 * len(there), np.int64)
        queue[: len(there)] = there
        return _Covered(fine, state, queue, len(there))
