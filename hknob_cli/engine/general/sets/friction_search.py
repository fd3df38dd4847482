"""All starts of a cell with Coulomb friction at once: its attractors, and whether the list is proven to be complete."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import Search, StoppedError, ranked, time_allowed, whole
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.sets import box, friction_box, friction_phases
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.ends import Known, ends_of, why_not
from hknob_cli.engine.general.sets.friction_phases import FIRST, HALVINGS
from hknob_cli.engine.general.sets.friction_room import can_rub, friction_drift, make_friction_room, plane_of
from hknob_cli.engine.general.sets.friction_set import LEAST_WEIGHT
from hknob_cli.engine.general.sets.scope import Scope, make_scope
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets.search import SLICE

LONGEST = 20_000_000  # samples that a cell may take: a minute or two
SLICE_INTERPRETED = 2000  # samples between two chances to be interrupted


class FrictionSetEngine(GeneralSetEngine):
    """Follows sets of states of knob and hand with friction, plain or compiled. One per thread."""

    def able(self, body: Body, wall: Controller) -> bool:
        """Whether this engine follows sets of states of a cell."""
        return can_rub(body, wall, self.law)

    def longest(self, _body: Body) -> int:
        """Samples that a cell may take when no time is set."""
        return LONGEST

    def longest_phases(self, _body: Body) -> int:
        """The same of all clock phases of one start."""
        return LONGEST

    def follower(self, _body: Body, _wall: Controller, _delay_line: int) -> Callable[..., Any]:
        """What follows the pieces that wait, `friction_box.follow_friction`."""
        work = make_friction_room(self._zeros, self._filled, _delay_line, _body, _wall, self.law)
        follow = self._function(friction_box, "follow_friction")
        return lambda room, *rest: follow(room, work, *rest)

    def sampler(self, _wall: Controller) -> Callable[..., Any]:
        """As that of `GeneralSetEngine`: trials are followed, which friction may stop."""
        return self._function(box, "sample_trials")

    def drift(self, body: Body, wall: Controller) -> Drift:
        """As that of `GeneralSetEngine`."""
        return friction_drift(body, wall, self.law)

    def intervals(self) -> tuple[int, int]:
        """Numbers of an interval of phases that waits, and how many may, as each is halved before the next."""
        return 2, FIRST + HALVINGS + 2

    def plane(self, body: Body) -> Body:
        """As that of `GeneralSetEngine`: a torque that lags is the same for all states of a piece."""
        return plane_of(body)

    def _filled(self, values: list[float]) -> Any:
        return np.array(values, dtype=np.float64) if self.compiled else list(values)

    def phase_follower(
        self, body: Body, wall: Controller, start: list[float], delay_line: int, scope: Scope
    ) -> tuple[Callable[..., Any], Known]:
        """What follows the intervals of phases that wait, called with them, and the ends that it enters."""
        room = self.room(body, delay_line)
        work = make_friction_room(self._zeros, self._filled, delay_line, body, wall, self.law)
        cell = self.ready(body, wall, delay_line)
        follow = partial(self._function(friction_phases, "follow_phases"), (start[0], start[1]))
        return lambda *some: follow(*some, scope, room, work, cell), cell.known

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
        """As `GeneralSetEngine.search_phases`; shares are exact to `friction_phases.NARROWEST` for each boundary.

        Without friction they are exact to `friction_phases.STRAIGHT`.
        """
        if not self.able(body, wall):
            return None
        scope = make_scope(body, wall, start[0], start[1], rate, max_samples)
        if not scope.fine:
            return None
        size, many = self.intervals()
        stack = self._zeros(size * many)
        for k in range(FIRST):
            for j in range(0, size, 2):
                stack[size * k + j], stack[size * k + j + 1] = (FIRST - 1 - k) / FIRST, (FIRST - k) / FIRST
        follow, known = self.phase_follower(body, wall, start, delay_line, scope)
        waiting, pieces, undecided, narrowest, taken = FIRST, 0, 0.0, 1.0, 0
        with Alarm(time_allowed(seconds, self.patience, compiled=self.compiled), body.halt) as alarm:
            while waiting and not alarm.over and taken <= self.longest_phases(body):
                if self.stopped():
                    raise StoppedError
                waiting, ended, lost, shortest, used = follow(
                    waiting, SLICE if self.compiled else SLICE_INTERPRETED, stack
                )
                pieces, undecided, taken = pieces + int(ended), undecided + float(lost), taken + int(used)
                narrowest = min(narrowest, float(shortest))
        left = float(sum(stack[size * k + size - 1] - stack[size * k + size - 2] for k in range(int(waiting))))
        found, why = ends_of(known, body.order, delay_line), why_not(known)
        if self.by_area(body):  # a piece holds more than its interval: its middle may end where no phase does
            found = [one for one in found if one.trials > 0.0]
        if waiting:  # also what lies beyond an edge by what rounding may move it, which counts no phases
            given_up = self._given_up(max(left, LEAST_WEIGHT), seconds, over=taken > self.longest_phases(body))
            found.append(given_up)
            why = given_up.reason
        if undecided > 0.0:
            found.append(whole(Outcome.UNDECIDED, why_not(known), undecided))
        complete = undecided == 0.0 and not waiting
        why = Reason.NONE if complete else why
        return Search(ranked(found), taken, complete=complete, pieces=pieces, narrowest=narrowest, why=why)
