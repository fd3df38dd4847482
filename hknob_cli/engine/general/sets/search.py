"""All starts of a cell of the general loop at once: its attractors, and whether the list is proven to be complete."""

import random
from collections.abc import Callable
from math import inf
from time import monotonic
from typing import Any

import numpy as np

from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import (
    USUAL,
    Attractor,
    Patience,
    Search,
    StoppedError,
    ranked,
    time_allowed,
    unfinished,
    whole,
)
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.search import as_arrays, as_compiled, as_list, make_space
from hknob_cli.engine.general.sets import arc, box, lattice
from hknob_cli.engine.general.sets.afar import look_from_afar
from hknob_cli.engine.general.sets.arc_parts import HIGH, LOW, arc_size
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.drift import Drift, make_drift
from hknob_cli.engine.general.sets.ends import ends_of, make_known, measure_left, why_not
from hknob_cli.engine.general.sets.piece import piece_size
from hknob_cli.engine.general.sets.room import (
    CELLS,
    PieceRoom,
    hash_scale,
    make_arc_room,
    make_piece_room,
    make_turn_room,
)
from hknob_cli.engine.general.sets.scope import LONGEST, Scope, can_follow, make_scope
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets import region
from hknob_cli.engine.sets.absorbing import RegionFinder
from hknob_cli.engine.sets.arc import MOST_ARCS, MOST_COVERED
from hknob_cli.engine.sets.room import make_region_room
from hknob_cli.engine.sets.search import GENERATIONS, SAMPLED, SEEN, SLICE, WIDEST, Box


class GeneralSetEngine:
    """Follows sets of states of the general loop, plain or compiled; its work space is used again. One per thread.

    ``law``: of a controller, as `laws.law` has it, in the engine's own arrays or lists; None without one.
    """

    law: Any = None

    def __init__(
        self,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; ``functions``: the compiled group "general sets"; ``stopped``: asked whether to give up."""
        self.stopped = stopped
        self.patience = patience
        self.compiled = functions is not None
        self._functions = functions
        self._rooms: dict[tuple[int, int], PieceRoom] = {}
        self._regions: RegionFinder | None = None

    def _function(self, module: Any, name: str) -> Callable[..., Any]:
        found: Callable[..., Any] = (
            self._functions[f"general.sets.{name}"] if self._functions else getattr(module, name)
        )
        return found

    def _zeros(self, count: int) -> Any:
        return np.zeros(count) if self._functions else [0.0] * count

    def able(self, body: Body, wall: Controller) -> bool:
        """Whether this engine follows sets of states of a cell."""
        return can_follow(body, wall, self.law)

    def longest(self, body: Body) -> int:
        """Samples that a cell may take when no time is set."""
        return LONGEST[min(body.order, 3)]

    def follower(self, _body: Body, _wall: Controller, _delay_line: int) -> Callable[..., Any]:
        """What follows the pieces that wait, `box.follow_generation`."""
        return self._function(box, "follow_generation")

    def sampler(self, _wall: Controller) -> Callable[..., Any]:
        """What counts the ends of single states, `box.sample_box`."""
        return self._function(box, "sample_box")

    def by_area(self, _body: Body) -> bool:
        """Whether shares of a box are those of its area, whose pieces are not merged, and not of random starts."""
        return False

    def merges(self, body: Body) -> bool:
        """Whether pieces are merged: those that differ in two numbers."""
        return self.plane(body).order == 2 and not self.by_area(body)

    def plane(self, body: Body) -> Body:
        """The body with the numbers in which the states of a piece may differ: all."""
        return body

    def room(self, body: Body, delay_line: int) -> PieceRoom:
        """Work space for the pieces of a cell."""
        key = body.order, delay_line
        if key not in self._rooms:
            cells = CELLS if self.plane(body).order == 2 else 1
            self._rooms = {key: make_piece_room(self._zeros, *key, lattice=cells)}
        return self._rooms[key]

    def drift(self, body: Body, wall: Controller) -> Drift:
        """Bounds on roundings, in lists."""
        return make_drift(body, wall, self.law)

    def ready(self, body: Body, wall: Controller, delay_line: int) -> Cell:
        """A cell as the functions of this engine want it, its tables empty."""
        n, drift = body.order, self.drift(body, wall)
        known = make_known(self._zeros, n, delay_line, make_space(n, delay_line, self._zeros), self.law)
        known = known._replace(turns=make_turn_room(self._zeros, self.plane(body).order, delay_line, wall, self.law))
        if not self.compiled:
            return Cell(drift, known, body, as_list(wall))
        arrays = Drift._make(np.array(v) if isinstance(v, list) else v for v in drift)
        if body.cogs is None:
            return Cell(arrays, known, as_arrays(body), wall)
        return Cell(arrays, known, *as_compiled(body, wall))

    def search_phases(
        self,
        body: Body,
        wall: Controller,
        start: list[float],
        *,
        rate: float,
        delay_line: int,
        max_samples: int | None,
        seconds: float | None = None,
    ) -> Search | None:
        """What every clock phase of one start, the state ``start``, settles to.

        None where arcs cannot be followed: nothing damps or holds the knob, or they meet too many edges at once. Raises
        `StoppedError` when told to stop, and `NeedsCompilerError` in the interpreter where it takes too long.
        """
        if not self.able(body, wall):
            return None
        scope = make_scope(body, wall, start[0], start[1], rate, max_samples)
        if not scope.fine:
            return None
        cell = self.ready(body, wall, delay_line)
        body, known, room = cell.body, cell.known, make_arc_room(self._zeros, body.order, delay_line)
        totals = self._zeros(4)
        totals[2] = 1.0
        begin = np.array(start) if self.compiled else list(start)
        slack = self._function(arc, "fill_arcs")(begin, room, cell.drift, body)
        follow = self._function(arc, "follow_arcs")
        waiting, taken = 1, 0
        with Alarm(time_allowed(seconds, self.patience, compiled=self.compiled), body.halt) as alarm:
            while waiting > 0 and not alarm.over and taken <= self.longest(body) and not _endless(totals):
                if self.stopped():
                    raise StoppedError
                waiting, used = follow(waiting, slack, SLICE, totals, scope, room, cell)
                taken += int(used)
        if waiting < 0:
            return None
        size = arc_size(body.order, delay_line)
        left = float(sum(room.stack[k * size + HIGH] - room.stack[k * size + LOW] for k in range(waiting)))
        found = ends_of(known, body.order, delay_line)
        # Arcs overlap by what rounding may move their ends: shares are of their lengths together.
        covered = float(totals[3]) + left
        found = [one._replace(trials=one.trials / covered) for one in found]
        lost = 1.0 - left / covered - sum(one.trials for one in found)
        why = why_not(known)
        if left > 0.0:
            over = taken > self.longest(body) or _endless(totals)
            given_up = self._given_up(left / covered, seconds, over=over)
            found.append(given_up)
            why = given_up.reason
        if totals[1] > 0.0 and lost > 1e-9:
            found.append(whole(Outcome.UNDECIDED, why_not(known), lost))
        complete = bool(totals[1] == 0.0 and waiting == 0)
        return Search(
            ranked(found),
            taken,
            complete=complete,
            pieces=int(totals[0]),
            narrowest=float(totals[2]),
            why=Reason.NONE if complete else why,
            share_error=max(covered - 1.0, 0.0) + EPSILON * (float(totals[0]) + 1.0),
        )

    def _given_up(self, share: float, seconds: float | None, *, over: bool) -> Attractor:
        """The starts that were still under way when the time, or all work that a cell may take, was over."""
        if over:
            return whole(Outcome.UNDECIDED, Reason.WORK_LIMIT, share)
        return unfinished(share, seconds, self.patience, compiled=self.compiled)

    def search_box(
        self,
        body: Body,
        wall: Controller,
        states: Box,
        *,
        rate: float,
        delay_line: int,
        max_samples: int | None,
        seconds: float | None = None,
    ) -> Search | None:
        """What every state of a box settles to: knob angle and speed in it, no torque under way, the finger with it.

        None where sets of states cannot be followed: nothing damps or holds the knob, or its motions are too fine.
        ``rate``: decay of the slowest mode, per sample; ``seconds``: on the clock, if they are limited. Raises
        `StoppedError` when told to stop.
        """
        far_x, far_v = max(abs(states.low_x), abs(states.high_x)), max(abs(states.low_v), abs(states.high_v))
        if not self.able(body, wall):
            return None
        scope = make_scope(body, wall, far_x, far_v, rate, max_samples)
        if not scope.fine:
            return None
        cell = self.ready(body, wall, delay_line)
        body, known = cell.body, cell.known
        n, room = body.order, self.room(body, delay_line)
        room.scale[0] = hash_scale(wall)
        with Alarm(time_allowed(seconds, self.patience, compiled=self.compiled), body.halt) as alarm:
            taken, unproven, followed = self._sample(states, scope, room, cell, alarm)
            pieces, undecided, why = 0, 0.0, Reason.NONE
            follow, release = self.follower(body, wall, delay_line), self._function(lattice, "release")
            waiting = self._fill(states, room, cell)
            if waiting < 0:
                waiting, undecided, why = 0, 1.0, Reason.TOO_MANY
            across = max(states.high_x - states.low_x, (states.high_v - states.low_v) * body.reach)
            width = across / WIDEST if self.merges(body) else 0.0
            for generation in range(GENERATIONS):
                while waiting and not alarm.over and taken <= self.longest(body):
                    if self.stopped():
                        raise StoppedError
                    waiting, ended, lost, used = follow(room, waiting, width, SLICE, scope, cell)
                    pieces, undecided, taken = pieces + int(ended), undecided + float(lost), taken + int(used)
                if waiting or not room.counts[0] or generation + 1 == GENERATIONS:
                    break
                waiting = int(release(room, 0, delay_line, cell.drift))
                width *= 0.5
                taken += self._function(box, "seek_some")(room, waiting, SEEN, scope, cell)
            left = measure_left(room, waiting, piece_size(n, delay_line))
            over = taken > self.longest(body) or not alarm.over
        found, by_area = ends_of(known, n, delay_line), self.by_area(body)
        if followed < SAMPLED:
            found.append(self._given_up(float(SAMPLED - followed), seconds, over=False))
        if unproven:
            found.append(whole(Outcome.UNDECIDED, Reason.NO_REPEAT, float(unproven)))
        if left > 0.0:
            why = self._given_up(left, seconds, over=over).reason
        elif undecided > 0.0 and why is Reason.NONE:
            why = why_not(known)
        undecided = min(1.0, undecided + left)
        if by_area:
            found = [one for one in found if one.trials > 0.0]
            found += [whole(Outcome.UNDECIDED, why, undecided)] if undecided > 0.0 else []
        return Search(ranked(found), int(taken), complete=undecided == 0.0, pieces=pieces, undecided=undecided, why=why)

    def search_anywhere(
        self,
        body: Body,
        wall: Controller,
        *,
        rate: float,
        delay_line: int,
        max_samples: int | None,
        seconds: float | None = None,
    ) -> Search:
        """What every state settles to, however far; shares are of the box around the region that all come into.

        Of bodies of second order without friction, and of walls without memory: no delay, no damping of their own.
        Raises `StoppedError` when told to stop.
        """
        until = inf if seconds is None else monotonic() + seconds
        afar = look_from_afar(body, wall)
        if self._regions is None:
            room = make_region_room(self._zeros)
            self._regions = RegionFinder(self._region_function, room, self.stopped)
        found = self._regions.find(*afar, until)
        if found is None:
            return self._regions.why_none(*afar, until)
        limits: dict[str, Any] = {
            "max_samples": max_samples,
            "seconds": None if seconds is None else until - monotonic(),
        }
        search = self.search_box(body, wall, Box(*found.ranges), rate=rate, delay_line=delay_line, **limits)
        if search is None:
            end = whole(Outcome.UNDECIDED, Reason.TOO_FINE, 1.0)
            search = Search((end,), 0, complete=False, undecided=1.0, why=Reason.TOO_FINE)
        return search._replace(region=found.ranges)

    def _region_function(self, name: str) -> Callable[..., Any]:
        found: Callable[..., Any] = self._functions[f"sets.{name}"] if self._functions else getattr(region, name)
        return found

    def _fill(self, states: Box, room: Any, cell: Cell) -> int:
        """Let a box be all that waits; how many pieces, -1 where there is no room."""
        wall = cell.wall if self.law is None else self.law.watch
        fill = self._function(box, "fill_box")
        return int(fill(tuple(states), room, cell.known.turns, cell.drift, self.plane(cell.body), wall))

    def _sample(self, states: Box, scope: Scope, room: Any, cell: Cell, alarm: Alarm) -> tuple[int, int, int]:
        """Follow random starts, as many as there is time for: samples, starts without a proven end, starts."""
        chance = random.Random(0)
        starts, ends = self._zeros(2 * SAMPLED), self._zeros(SAMPLED)
        for k in range(SAMPLED):
            starts[2 * k] = chance.uniform(states.low_x, states.high_x)
            starts[2 * k + 1] = chance.uniform(states.low_v, states.high_v)
        sample = self.sampler(cell.wall)
        taken, unproven, followed, chunk = 0, 0, 0, max(1, SLICE // max(scope.skip, 1))
        while followed < SAMPLED and not alarm.over:
            if self.stopped():
                raise StoppedError
            stop = min(followed + chunk, SAMPLED)
            used, lost = sample(starts, followed, stop, ends, scope, room, cell)
            taken, unproven, followed = taken + int(used), unproven + int(lost), stop
        return taken, unproven, followed


def _endless(totals: Any) -> bool:
    """Whether the arcs of a start are too many, or overlap as only those do that lie within rounding of an edge."""
    return bool(totals[0] >= MOST_ARCS or totals[3] > MOST_COVERED)
