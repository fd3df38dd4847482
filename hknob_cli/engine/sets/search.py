"""All starts of a cell at once: its attractors, with their shares, and whether the list is proven to be complete."""

import random
from collections.abc import Callable
from math import inf, sqrt
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import (
    FATES,
    Attractor,
    NeedsCompilerError,
    Runner,
    Search,
    StoppedError,
    attractor_of,
    ranked,
    time_allowed,
    unfinished,
    whole,
)
from hknob_cli.engine.budget import OPEN, UNHELD, prospect
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, UNDAMPED
from hknob_cli.engine.loop import Loop
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets import arc, box, cells, polygon, region
from hknob_cli.engine.sets import ball as known_ends
from hknob_cli.engine.sets.absorbing import RegionFinder, pushes, states_in
from hknob_cli.engine.sets.ball import Scope, Start
from hknob_cli.engine.sets.cells import first_patience
from hknob_cli.engine.sets.polygon import POLYGON, WEIGHT
from hknob_cli.engine.sets.room import make_arc_room, make_known, make_polygon_room, make_region_room

SAMPLED = 4096  # random starts in a box, whose ends are counted for shares
WIDEST = 8.0  # the first lattice has so many cells across the box
SEEN = 16  # polygons of a generation whose ends are looked for
GENERATIONS = 60  # of lattices, each half as wide as the last
MAPPED = 4096  # starts of a map between two chances to be interrupted
SLICE = 250_000  # samples between two chances to be interrupted; each may be compared with thousands of states
SLICE_INTERPRETED = 50_000
LONGEST = 4_000_000_000  # samples that a cell may take


class Box(NamedTuple):
    """Every state with a position and a speed in these ranges: counts, counts per sample."""

    low_x: float
    high_x: float
    low_v: float
    high_v: float


class SetEngine(Runner):
    """Follows arcs and polygons of states, plain or compiled (group "sets"); its work space is used again."""

    def _begin(self) -> None:
        self._polygons: Any = None
        self._regions: Any = None

    def _of(self, module: Any, name: str) -> Callable[..., Any]:
        return self._function(f"sets.{name}", getattr(module, name))

    def search_phases(
        self, loop: Loop, *, x: float, v: float, delay_line: int, max_samples: int | None, seconds: float | None = None
    ) -> Search | None:
        """What every clock phase of the start (``x`` counts, ``v`` counts per sample) settles to.

        ``seconds``: on the clock, after which the phases that are left are undecided. None where arcs cannot be
        followed: nothing damps or holds the knob, or they meet too many edges at once.

        Raises `NeedsCompilerError` in the interpreter, where the same search compiled would succeed, and `StoppedError`
        when told to stop.
        """
        known, room = make_known(self.zeros, delay_line), make_arc_room(self.zeros, delay_line)
        follow, progress = self._of(cells, "follow_cell"), room.progress
        tries, size = (0, SLICE) if self.compiled else (self.patience.samples, SLICE_INTERPRETED)
        alarm = Alarm(time_allowed(seconds, self.patience, compiled=self.compiled))
        start, state = Start(x, v, delay_line), 0
        while state == 0 and not alarm.over:
            if self.stopped():
                raise StoppedError
            state, _ = follow(loop, start, max_samples or 0, tries, size, room, known)
        if state == 0:
            waiting = range(int(progress[arc.WAITING]))
            left = sum(room.stack[arc.ARC * k + 1] - room.stack[arc.ARC * k] for k in waiting) or 1.0
        else:
            left = 0.0
        late = unfinished(left, seconds, self.patience, compiled=self.compiled) if left > 0.0 else None
        if tries and progress[arc.SPENT] > 0.0 and tries < prospect(x, v, max_samples or 0, loop)[1]:
            raise NeedsCompilerError("sets")
        if state < 0:
            return None
        found, rows = _ends(known, delay_line), int(known.counts[0])
        lost = cells.lost_share(known.table, rows, progress)
        if lost > 0.0:
            found.append(whole(Outcome.UNDECIDED, Reason.NO_REPEAT, float(lost)))
        if late:
            found.append(late)
        return Search(
            ranked(found),
            int(progress[arc.TAKEN]),
            complete=progress[arc.UNDECIDED] == 0.0 and late is None,
            pieces=int(progress[arc.DONE]),
            narrowest=progress[arc.SHORTEST],
            share_error=float(cells.share_error(progress)),
        )

    def search_box(self, loop: Loop, states: Box, *, max_samples: int | None, seconds: float | None = None) -> Search:
        """What every state of a box settles to, no command under way; ``seconds``: on the clock, if they are limited.

        Raises `StoppedError` when told to stop.
        """

        def fill() -> None:
            self._of(box, "fill_box")(*states, self._polygons, loop)

        chance = random.Random(0)
        starts = self.zeros(2 * SAMPLED)
        for k in range(SAMPLED):
            starts[2 * k] = chance.uniform(states.low_x, states.high_x)
            starts[2 * k + 1] = chance.uniform(states.low_v, states.high_v)
        return self._search(loop, states, starts, fill, max_samples, seconds)

    def search_anywhere(self, loop: Loop, *, max_samples: int | None, seconds: float | None = None) -> Search:
        """What every state settles to, however far, no command under way; shares are of the region that all come into.

        Raises `StoppedError` when told to stop.
        """
        until = inf if seconds is None else monotonic() + seconds
        if self._regions is None:
            room = make_region_room(self.zeros)
            self._regions = RegionFinder(lambda name: self._of(region, name), room, self.stopped)
        limits = pushes(loop)
        found = self._regions.find(loop, limits, until)
        if found is None:
            why: Search = self._regions.why_none(loop, limits, until)
            return why
        states, corners = Box(*found.ranges), self.filled(found.corners)

        def fill() -> None:
            self._of(box, "fill_polygon")(corners, len(corners) // 2, self._polygons, loop)

        starts = self.filled(states_in(found.corners, SAMPLED))
        left = None if seconds is None else until - monotonic()
        return self._search(loop, states, starts, fill, max_samples, left)._replace(region=found.ranges)

    def _search(
        self,
        loop: Loop,
        states: Box,
        starts: Any,
        fill: Callable[[], None],
        max_samples: int | None,
        seconds: float | None,
    ) -> Search:
        """What the polygon that ``fill`` lets wait settles to; it and the ``starts`` of trials lie in ``states``."""
        until = inf if seconds is None else monotonic() + seconds
        far_x, far_v = max(abs(states.low_x), abs(states.high_x)), max(abs(states.low_v), abs(states.high_v))
        fate, most, skip, limit = prospect(far_x, far_v, max_samples or 0, loop)
        if fate != OPEN or not loop.alpha > 0.0 or not loop.beta > 0.0:
            if fate == OPEN:
                fate = UNDAMPED if loop.alpha == 0.0 else UNHELD
            return Search((whole(*FATES[fate], 1.0),), 0, complete=False, undecided=1.0)
        if self._polygons is None:
            self._polygons = make_polygon_room(self.zeros)
        room, known = self._polygons, make_known(self.zeros, 0)
        single, together = Scope(skip, most, limit), Scope(first_patience(skip), most, limit)
        sample, ends = self._of(box, "sample_box"), self.zeros(SAMPLED)
        taken, unproven, followed, chunk = 0, 0, 0, max(1, SLICE // max(skip, 1))
        while followed < SAMPLED and monotonic() < until:
            if self.stopped():
                raise StoppedError
            stop = min(followed + chunk, SAMPLED)
            used, lost = sample(starts, followed, stop, single, room.ring, ends, known, loop)
            taken, unproven, followed = taken + used, unproven + lost, stop
        if followed < SAMPLED:
            return self._boxed(known, int(taken), 0, 1.0, unproven, Reason.TIME_LIMIT, SAMPLED - followed)
        follow, seek_some = self._of(box, "follow_generation"), self._of(box, "seek_some")
        release = self._of(polygon, "release")
        fill()
        across = max(states.high_x - states.low_x, (states.high_v - states.low_v) / sqrt(loop.beta))
        width, waiting, pieces, undecided = across / WIDEST, 1, 0, 0.0
        for generation in range(GENERATIONS):
            while waiting:
                if self.stopped():
                    raise StoppedError
                waiting, ended, lost, used = follow(room, waiting, width, SLICE, together, known, loop)
                pieces, undecided, taken = pieces + ended, undecided + lost, taken + used
                if taken > LONGEST or monotonic() > until:
                    why = Reason.WORK_LIMIT if taken > LONGEST else Reason.TIME_LIMIT
                    return self._boxed(known, int(taken), pieces, 1.0, unproven, why)
            if not room.counts[0]:
                return self._boxed(known, int(taken), pieces, min(1.0, undecided), unproven)
            waiting = int(release(room, 0, loop))
            width *= 0.5
            if generation + 1 < GENERATIONS:
                taken += seek_some(room, waiting, SEEN, single, known, loop)
        left = sum(room.stack[k * POLYGON + WEIGHT] for k in range(waiting))
        why = Reason.WORK_LIMIT if left > undecided else Reason.NONE
        return self._boxed(known, int(taken), pieces, min(1.0, undecided + left), unproven, why)

    def map_starts(
        self, loop: Loop, starts: NDArray[np.float64], attractors: tuple[Attractor, ...], *, max_samples: int | None
    ) -> NDArray[np.int64]:
        """Which of the ``attractors``, proven ones, each start ends in; -1 for none of them.

        ``starts``: (n, 2), counts and counts per sample, no command under way. Raises `StoppedError` when told to stop.
        """
        far = np.abs(starts).max(axis=0)
        _, most, skip, limit = prospect(float(far[0]), float(far[1]), max_samples or 0, loop)
        known, none, scope = make_known(self.zeros, 0), self.zeros(0), Scope(skip, most, limit)
        add, sample = self._of(known_ends, "add_end"), self._of(box, "sample_box")
        numbers = []
        for one in attractors:
            fate = CYCLE_PROVEN if one.outcome is Outcome.CYCLE else REST_PROVEN
            numbers.append(add(fate, one.period, one.x, one.v, none, 0, known, loop) if one.certified else -1)
        ends, flat = np.zeros(len(starts)), np.ascontiguousarray(starts, dtype=np.float64).ravel()
        for first in range(0, len(starts), MAPPED):
            if self.stopped():
                raise StoppedError
            sample(flat, first, min(first + MAPPED, len(starts)), scope, none, ends, known, loop)
        found = np.full(len(starts), -1)
        for number, row in enumerate(numbers):
            if row >= 0:
                found[ends == row] = number
        return found

    def _boxed(
        self,
        known: Any,
        taken: int,
        pieces: int,
        undecided: float,
        unproven: int,
        why: Reason = Reason.NONE,
        unfollowed: int = 0,
    ) -> Search:
        found = _ends(known, 0)
        if unfollowed:
            found.append(whole(Outcome.UNDECIDED, Reason.TIME_LIMIT, float(unfollowed)))
        if unproven:
            found.append(whole(Outcome.UNDECIDED, Reason.NO_REPEAT, float(unproven)))
        return Search(ranked(found), taken, complete=undecided == 0.0, pieces=pieces, undecided=undecided, why=why)


def _ends(known: Any, delay_line: int) -> list[Attractor]:
    return [
        attractor_of(
            known.table[10 * row : 10 * row + 10],
            known.lines[row * delay_line : (row + 1) * delay_line],
            Reason.NO_REPEAT,
        )
        for row in range(int(known.counts[0]))
    ]
