"""All starts of a cell with Coulomb friction at once: its attractors, and whether the list is proven to be complete."""

from math import inf
from time import monotonic
from typing import Any

import numpy as np

from hknob_cli.engine.attractors import Search, StoppedError, ranked, whole
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.search import as_arrays, make_space
from hknob_cli.engine.general.sets import box, friction_box, friction_phases, lattice
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_phases import FIRST
from hknob_cli.engine.general.sets.friction_room import can_rub, friction_drift, make_friction_room
from hknob_cli.engine.general.sets.room import Known, make_known, make_piece_room
from hknob_cli.engine.general.sets.search import GeneralSetEngine, _boxed, ends_of, make_scope
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets.search import GENERATIONS, LONGEST, SAMPLED, SEEN, SLICE, WIDEST, Box


class FrictionSetEngine(GeneralSetEngine):
    """Follows sets of states of a knob with friction, plain or compiled. One per thread."""

    def ready(self, body: Body, wall: Controller, delay_line: int) -> tuple[Body, Drift, Known]:
        """Body, bounds and empty tables as the functions of this engine want them."""
        drift = friction_drift(body, wall)
        known = make_known(self._zeros, 2, delay_line, make_space(2, delay_line, self._zeros))
        if self.compiled:
            return as_arrays(body), Drift._make(np.array(v) if isinstance(v, list) else v for v in drift), known
        return body, drift, known

    def _filled(self, values: list[float]) -> Any:
        return np.array(values, dtype=np.float64) if self.compiled else list(values)

    def _space(self, body: Body, wall: Controller, delay_line: int) -> tuple[Any, Any]:
        if (2, delay_line) not in self._rooms:
            self._rooms = {(2, delay_line): make_piece_room(self._zeros, 2, delay_line)}
        room = self._rooms[2, delay_line]
        room.scale[0] = 8.0 / wall.kappa if wall.kappa > 0.0 else 1.0
        room.counts[0] = 0.0
        return room, make_friction_room(self._zeros, self._filled, delay_line, body, wall)

    def search_phases(
        self,
        body: Body,
        wall: Controller,
        x: float,
        v: float,
        *,
        rate: float,
        delay_line: int,
        max_samples: int | None,
        seconds: float | None = None,
    ) -> Search | None:
        """What every clock phase of a start settles to. None where it cannot be followed."""
        until = inf if seconds is None else monotonic() + seconds
        scope = make_scope(body, wall, x, v, rate, max_samples)
        if not can_rub(body, wall) or not scope.fine:
            return None
        room, work = self._space(body, wall, delay_line)
        body, drift, known = self.ready(body, wall, delay_line)
        stack = self._zeros(2 * (FIRST + 64))
        for k in range(FIRST):
            stack[2 * k], stack[2 * k + 1] = (FIRST - 1 - k) / FIRST, (FIRST - k) / FIRST
        waiting, pieces, undecided, narrowest, taken = FIRST, 0, 0.0, 1.0, 0
        while waiting:
            if self.stopped():
                raise StoppedError
            waiting, ended, lost, shortest, used = self._function(friction_phases, "follow_phases")(
                x, v, waiting, SLICE, stack, scope.patience, scope.budget, scope.limit, room, work, drift, known, body, wall
            )
            pieces, undecided, taken = pieces + ended, undecided + lost, taken + used
            narrowest = min(narrowest, shortest)
            if taken > LONGEST or monotonic() > until:
                break
        undecided += sum(stack[2 * k + 1] - stack[2 * k] for k in range(waiting))
        found = ends_of(known, 2, delay_line)
        if undecided > 0.0:
            found.append(whole(Outcome.UNDECIDED, Reason.NO_REPEAT, float(undecided)))
        return Search(ranked(found), int(taken), complete=undecided == 0.0, pieces=int(pieces), narrowest=narrowest)

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
    ) -> Search:
        """As `GeneralSetEngine.search_box`."""
        until = inf if seconds is None else monotonic() + seconds
        far_x, far_v = max(abs(states.low_x), abs(states.high_x)), max(abs(states.low_v), abs(states.high_v))
        scope = make_scope(body, wall, far_x, far_v, rate, max_samples)
        room, work = self._space(body, wall, delay_line)
        body, drift, known = self.ready(body, wall, delay_line)
        rest = scope.budget, scope.limit
        cell = drift, known, body, wall
        taken, unproven, followed = self._sample(states, scope, room, cell, until)
        if followed < SAMPLED:
            return _boxed(known, 2, delay_line, taken, 0, 1.0, unproven, SAMPLED - followed)
        follow, release = self._function(friction_box, "follow_friction"), self._function(lattice, "release")
        waiting = int(self._function(box, "fill_box")(*states, delay_line, room, drift, body, wall))
        if waiting < 0:
            return _boxed(known, 2, delay_line, taken, 0, 1.0, unproven)
        across = max(states.high_x - states.low_x, (states.high_v - states.low_v) * body.reach)
        width, pieces, undecided = across / WIDEST, 0, 0.0
        for generation in range(GENERATIONS):
            while waiting:
                if self.stopped():
                    raise StoppedError
                waiting, ended, lost, used = follow(
                    room, work, waiting, delay_line, width, scope.patience, *rest, SLICE, *cell
                )
                pieces, undecided, taken = pieces + ended, undecided + lost, taken + used
                if taken > LONGEST or monotonic() > until:
                    left = self._left(room, waiting, 2, delay_line)
                    return _boxed(known, 2, delay_line, int(taken), pieces, min(1.0, undecided + left), unproven)
            if not room.counts[0]:
                break
            waiting = int(release(room, 0, delay_line, drift))
            width *= 0.5
            if generation + 1 < GENERATIONS:
                taken += self._function(box, "seek_some")(room, waiting, delay_line, SEEN, *rest, known, body, wall)
        left = self._left(room, waiting, 2, delay_line)
        return _boxed(known, 2, delay_line, int(taken), pieces, min(1.0, undecided + left), unproven)
