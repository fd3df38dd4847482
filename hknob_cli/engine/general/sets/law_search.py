"""All starts of a cell under a controller's law at once: as with friction, which may be there or not.

A law that reads its encoder once a sample is a program of readings. So sets that had the same readings have the same
memory and torques, and go from sample to sample as those of a wall do, cut where the law tells readings apart.
"""

from collections.abc import Callable
from typing import Any

from hknob_cli.engine.attractors import USUAL, Patience
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.follow import FIELDS
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.laws.step import begin_past
from hknob_cli.engine.general.sets import box, known
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_search import LONGEST, FrictionSetEngine
from hknob_cli.engine.general.sets.piece import BEFORE, STATE, piece_size
from hknob_cli.engine.general.sets.readings import acting
from hknob_cli.engine.general.sets.room import Known
from hknob_cli.engine.sets.search import Box

PHASES = (
    LONGEST // 5
)  # samples that all phases of one start may take: some ten seconds, after which trials are followed


class LawSetEngine(FrictionSetEngine):
    """Follows sets of states of one cell under its ``law``, which is as `laws.search.LawEngine` makes it ready.

    Its searches want ``delay_line`` to be the length of what is remembered.
    """

    def __init__(
        self,
        law: Law,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; ``functions``: the compiled group "friction sets"."""
        super().__init__(functions, stopped, patience)
        self.law = law

    def longest_phases(self) -> int:
        """Samples that all clock phases of one start may take when no time is set."""
        return PHASES

    def _fill(
        self, states: Box, room: Any, delay_line: int, drift: Drift, _known: Known, body: Body, _wall: Controller
    ) -> int:
        """As that of `GeneralSetEngine`; each piece remembers what the law does before it reads the first time."""
        waiting = int(self._function(box, "fill_box")(*states, delay_line, room, drift, body, self.law.watch))
        size = piece_size(body.order, delay_line)
        past = self._zeros(delay_line)
        for k in range(waiting):
            begin_past(past, room.stack[k * size + BEFORE], self.law)
            first = k * size + STATE + body.order
            for j in range(delay_line):
                room.stack[first + j] = past[j]
        return waiting

    def sampler(self) -> Callable[..., Any]:
        """What counts the ends of single states: of a motion each, under the law."""
        seek, law = self._function(known, "seek"), self.law

        def sample(
            starts: Any,
            first: int,
            stop: int,
            _patience: int,
            budget: int,
            limit: float,
            ends: Any,
            room: Any,
            drift: Drift,
            ends_known: Known,
            body: Body,
            wall: Controller,
        ) -> tuple[int, int]:
            taken, unproven = 0, 0
            for k in range(first, stop):
                room.own_z[0], room.own_z[1] = starts[2 * k], starts[2 * k + 1]
                level = acting(room.own_z[0], drift.bottom, law.watch)
                begin_past(room.own_ring, level, law)
                row, used = seek(room.own_z, 0.0, room.own_ring, 0, budget, limit, ends_known, body, wall)
                ends[k] = row
                if row < 0:
                    unproven += 1
                else:
                    ends_known.table[int(row) * FIELDS + 6] += 1.0
                taken += int(used)
            return taken, unproven

        return sample
