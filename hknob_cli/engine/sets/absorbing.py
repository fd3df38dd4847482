"""A region that every motion comes into, from however far: the loop with its rounding as a bounded push.

Far out a count is nothing: there the loop does to a motion ten times as large ten times as much. So one size is enough.
If all states within R are within R/2 some samples later, whatever the rounding pushes, then all within 2 R come within
R, all within 4 R within 2 R, and so on: every motion comes within R. That region is then moved on, sample by sample,
for as long as it becomes smaller; where all motions have been, they all come.
"""

import random
from collections.abc import Callable, Sequence
from itertools import pairwise
from math import ceil, inf, sqrt
from time import monotonic
from typing import Any, NamedTuple

from hknob_cli.engine.attractors import FATES, Search, StoppedError, whole
from hknob_cli.engine.budget import UNHELD
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import UNDAMPED
from hknob_cli.engine.loop import Loop, upper_edge
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.propagator import slowest_rate
from hknob_cli.engine.sets.polygon import CORNERS
from hknob_cli.engine.sets.region import Goal
from hknob_cli.engine.sets.room import RegionRoom

FEWEST_CORNERS, MOST_CORNERS = 32, 128  # of a region that moves: more where it shrinks less from sample to sample
LONGEST = 64.0  # time constants of the free plant within which a region has halved, or is taken not to
MOST_SAMPLES = 400_000
SLICE = 4096  # samples between two chances to be interrupted
TRIES = 12  # sizes, each eight times the last
SMALL = 0.01  # counts: what is smaller need not shrink
SHRINKS = 0.95  # of its area over a time constant: a region that keeps more has become as small as it will


class Limits(NamedTuple):
    """Between which a loop is pushed, beside its springs; the order is that of `region.advance`.

    ``outside``: stiffness of a spring that is to the other side what the wall's is to its own, 0 for a plain wall.
    """

    edge: float  # position where the wall begins
    least_outside: float
    most_outside: float
    least_inside: float
    most_inside: float
    outside: float = 0.0


class Region(NamedTuple):
    """A convex region that every motion comes into: x and v of its corners, flat, in order; counts, counts per sample.

    ``samples``: it took to shrink to this.
    """

    corners: tuple[float, ...]
    samples: int

    @property
    def ranges(self) -> tuple[float, float, float, float]:
        """Least and largest position, least and largest speed."""
        xs, vs = self.corners[::2], self.corners[1::2]
        return min(xs), max(xs), min(vs), max(vs)


class RegionFinder:
    """Looks for the absorbing region of a loop, plain or compiled."""

    def __init__(self, function: Callable[[str], Any], room: RegionRoom, stopped: Callable[[], bool]) -> None:
        """Make ready; ``function``: of `sets.region` by name; ``stopped``: asked whether to give up."""
        self._function = function
        self._room = room
        self._stopped = stopped
        self._until = inf
        self._back = False

    def find(self, loop: Loop, limits: Limits, until: float = inf) -> Region | None:
        """The region, or None if none is found, or none before the monotonic clock says ``until``.

        ``limits``: of the pushes, `pushes` for a plain wall. Raises `StoppedError` when told to stop.
        """
        if loop.alpha == 0.0 or loop.beta == 0.0:
            return None
        return self._find(loop, limits, until, back=False)

    def find_growth(self, loop: Loop, limits: Limits, until: float = inf) -> Region | None:
        """A region outside of which every motion grows without bound, or None, as `find`.

        It is found as the other one, backward in time: where all that is within R later has been within R/2, what is
        beyond R/2 is beyond R later, and so on.
        """
        return self._find(loop, limits, until, back=True)

    def why_none(self, loop: Loop, limits: Limits, until: float) -> Search:
        """Why motions of a loop need not come into any region, and from where on they are proven not to.

        Raises `StoppedError` when told to stop.
        """
        if loop.alpha == 0.0 or loop.beta == 0.0:
            end = whole(*FATES[UNDAMPED if loop.alpha == 0.0 else UNHELD], 1.0)
        elif grows := self.find_growth(loop, limits, until):
            end = whole(Outcome.DIVERGED, Reason.NONE, 1.0)
            return Search((end,), 0, complete=False, undecided=1.0, why=Reason.LEAVES, grows=grows.ranges)
        else:
            end = whole(Outcome.UNDECIDED, Reason.TIME_LIMIT if monotonic() >= until else Reason.NO_REGION, 1.0)
        return Search((end,), 0, complete=False, undecided=1.0)

    def _find(self, loop: Loop, limits: Limits, until: float, *, back: bool) -> Region | None:
        self._until = until
        self._back = back
        rate = slowest_rate(loop.alpha, loop.beta)
        if not rate > 0.0:
            return None
        most = int(min(max(12.0 * rate ** (-1.0 / 3.0), FEWEST_CORNERS), MOST_CORNERS))
        longest = int(min(LONGEST / rate + 64.0, MOST_SAMPLES))
        unpushed = Limits(0.0, 0.0, 0.0, 0.0, 0.0, limits.outside)
        _, first, far = self._shrink(self._square(1.0, loop), most, longest, 0.5, 1e6, unpushed, loop)
        if far > 0.5:
            return None
        # The wall's torque bends at 0 here. Where it begins at -1, it is off between: by no more than a count's, too.
        least, most_push = min(0.0, *limits[1:5]), max(0.0, *limits[1:5])
        any_push = Limits(0.0, least, most_push, least, most_push, limits.outside)
        step = abs(loop.g2) + abs(loop.s2) / sqrt(loop.beta)
        radius = max(8.0 * first * max(-least, most_push) * step, SMALL)
        for _ in range(TRIES):
            count, used, far = self._shrink(
                self._square(radius, loop), most, 4 * first + 64, 0.5 * radius, 1e6 * radius, any_push, loop
            )
            if far <= 0.5 * radius:
                return self._tighten(count, used, most, rate, limits, loop)
            radius *= 8.0
        return None

    def _tighten(self, count: int, used: int, most: int, rate: float, limits: Limits, loop: Loop) -> Region | None:
        """Move the region on, with the pushes as they are, for as long as that makes it smaller."""
        region, room = self._room.region, self._room
        area_of, ranges_of = self._function("area_of"), self._function("ranges_of")
        stride, area = max(8, ceil(1.0 / rate)), inf
        low_x, high_x, low_v, high_v = ranges_of(region, count)
        while (now := area_of(region, count)) < SHRINKS * area and used < MOST_SAMPLES:
            if high_x - low_x + (high_v - low_v) / sqrt(loop.beta) < SMALL or monotonic() > self._until:
                break
            area = now
            count, more, _ = self._shrink(count, most, stride, 0.0, inf, limits, loop)
            if count == 0:
                return None
            low_x, high_x, low_v, high_v = ranges_of(region, count)
            used += more
        # Grown by the rounding of the last hull and of the corners dropped from it, as `region.advance` has it.
        rounding = 64.0 * count * EPSILON
        grow_x, grow_v = rounding * max(-low_x, high_x), rounding * max(-low_v, high_v)
        count = self._function("enclose")(region, count, grow_x, grow_v, room.chain, room.rough)
        count = self._function("simplify")(room.rough, count, CORNERS, room.chain)
        corners = tuple(float(room.rough[k]) for k in range(2 * count))
        if not 3 <= count <= CORNERS:
            corners = (low_x, low_v, high_x, low_v, high_x, high_v, low_x, high_v)
        return Region(corners, used)

    def _square(self, radius: float, loop: Loop) -> int:
        count: int = self._function("fill_square")(self._room.region, radius, loop)
        return count

    def _shrink(
        self,
        count: int,
        most: int,
        samples: int,
        target: float,
        ceiling: float,
        limits: Limits,
        loop: Loop,
    ) -> tuple[int, int, float]:
        """`region.shrink` in slices."""
        shrink, room, used, far = self._function("shrink"), self._room, 0, inf
        while used < samples and monotonic() < self._until:
            if self._stopped():
                raise StoppedError
            goal = Goal(min(SLICE, samples - used), target, ceiling)
            count, taken, far = shrink(room.region, count, most, goal, limits, self._back, room, loop)
            used += int(taken)
            if not target < far < ceiling:
                break
        return int(count), used, float(far)


def pushes(loop: Loop, slack: float = 0.0) -> Limits:
    """What rounding, the encoder's offset and the bias add to the torque of a wall that knows the angle.

    ``slack``: by which the torque inside the wall may be more or less than that of the count.
    """
    shift = loop.offset if loop.sense > 0.0 else 1.0 + loop.offset  # the most that a level and its offset are above x
    least = -loop.gamma - loop.kappa * shift
    return Limits(upper_edge(-1.0, loop.sense), -loop.gamma, -loop.gamma, least - slack, least + loop.kappa + slack)


def states_in(corners: Sequence[float], count: int) -> list[float]:
    """Random states of a convex region, evenly spread and always the same: x and v of each, flat."""
    chance = random.Random(0)
    last = len(corners) // 2 - 1
    x, v = corners[0], corners[1]
    sides = [(corners[2 * k] - x, corners[2 * k + 1] - v) for k in range(1, last + 1)]
    areas = [abs(ax * bv - av * bx) for (ax, av), (bx, bv) in pairwise(sides)]
    states = []
    if not sum(areas) > 0.0:  # a point or a line
        return [x, v] * count
    for k in chance.choices(range(last - 1), areas, k=count):
        a, b = chance.random(), chance.random()
        if a + b > 1.0:
            a, b = 1.0 - a, 1.0 - b
        (ax, av), (bx, bv) = sides[k], sides[k + 1]
        states += [x + a * ax + b * bx, v + a * av + b * bv]
    return states
