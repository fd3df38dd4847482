"""All starts of a cell under a controller's law at once: as with friction, which may be there or not.

A law that reads an encoder is a program of readings. So sets that had the same readings have the same memory and
torques, and go from sample to sample as those of a wall do, cut where the law tells readings apart: at samples, and at
its looks into an interval. Without friction pieces are not merged, so that each has its own area of starts.

The program has no error, because a law is the function that is called, in double precision, and gets the readings and
its memory alone. So one memory, computed once, is that of all states of a piece, to the last bit. This holds for every
estimate of the velocity. Differences, times between counts and the longest line are functions of a known number of
readings: after as many samples two motions that read the same remember the same. A low-pass and a tracking filter never
come back to the last bit. Their difference in two motions shrinks by a known factor a sample (`laws.cascade`), and a
proven orbit captures a piece by what is left of it, and of all torques that it can still change. A filter for which no
such factor is known is not followed (`Law.provable`). An average of times, as of a Kalman filter with whole samples,
comes to a number that no longer changes, but to another from other starts, by a unit in the last place; the orbit is
then proven with each (`known.add_memory`).
"""

from collections.abc import Callable
from typing import Any

from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import USUAL, Patience
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.laws.step import begin_past
from hknob_cli.engine.general.sets import box
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.friction_search import LONGEST, FrictionSetEngine
from hknob_cli.engine.general.sets.piece import BEFORE, STATE
from hknob_cli.engine.general.sets.scope import Scope
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.sets.search import SAMPLED, Box

PHASES = LONGEST // 5  # samples that all phases of one start may take beside friction: some ten seconds
PHASES_ALONE = LONGEST // 2  # without friction, after which trials are followed, too


class _UnderLaw(GeneralSetEngine):
    """What sets of states under a ``law`` have in common; it is as `laws.search.LawEngine` makes it ready.

    Searches want ``delay_line`` to be the length of what is remembered.
    """

    def __init__(
        self,
        law: Law,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; ``functions``: the compiled group of the engine."""
        super().__init__(functions, stopped, patience)
        self.law = law

    def _fill(self, states: Box, room: Any, cell: Cell) -> int:
        """As that of `GeneralSetEngine`; each piece remembers what the law does before it reads the first time."""
        waiting, body, delay_line = super()._fill(states, room, cell), cell.body, len(room.own_ring)
        size = len(room.own)
        past = self._zeros(delay_line)
        for k in range(waiting):
            begin_past(past, room.stack[k * size + BEFORE], self.law)
            first = k * size + STATE + body.order
            for j in range(delay_line):
                room.stack[first + j] = past[j]
        return waiting

    def sampler(self, _wall: Controller) -> Callable[..., Any]:
        """What counts the ends of single states, `box.sample_trials`."""
        return self._function(box, "sample_trials")


class LawSetEngine(_UnderLaw, FrictionSetEngine):
    """Follows sets of states of knob and hand under a law, beside friction or without; the group "friction sets"."""

    def longest_phases(self, body: Body) -> int:
        """Samples that all clock phases of one start may take when no time is set."""
        return PHASES if body.friction > 0.0 else PHASES_ALONE

    def by_area(self, body: Body) -> bool:
        """Whether shares of ranges are areas, which friction does not keep; behind hysteresis parts overlap."""
        return body.friction == 0.0 and self.law.watch.hysteresis == 0.0

    def merges(self, body: Body) -> bool:
        """As that of `GeneralSetEngine`; without friction measures are areas, which a merged piece does not tell."""
        return body.friction > 0.0

    def _sample(self, states: Box, scope: Scope, room: Any, cell: Cell, alarm: Alarm) -> tuple[int, int, int]:
        """As that of `GeneralSetEngine`. Where shares are areas, random starts only find ends to compare with."""
        taken, unproven, followed = super()._sample(states, scope, room, cell, alarm)
        known = cell.known
        if not self.by_area(cell.body):
            return taken, unproven, followed
        for row in range(int(known.counts[0])):
            known.table[row * FIELDS + 6] = 0.0
        return taken, 0, SAMPLED


class LawStatesEngine(_UnderLaw):
    """Follows sets of more states under a law, without friction, as beside a finger; the group "general sets"."""

    def longest(self, _body: Body) -> int:
        """As that of `FrictionSetEngine`."""
        return LONGEST
