"""Every clock phase of one start at once, with friction and more than angle and speed, or beside cogging.

`friction_arcs` and `cog_arc`, made ready.
"""

from collections.abc import Callable
from functools import partial
from math import inf
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.engine.attractors import USUAL, Patience, Search
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_HELD,
    ENTRY,
    HALVES,
    HALVES_HELD,
    HALVINGS,
    HELD,
    RATES,
    Body,
)
from hknob_cli.engine.general.cogging import COGGED, COGGED_HALVES, LENGTH, SLOPE, size_at
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.sets import friction_arcs
from hknob_cli.engine.general.sets.drift import MARGIN, Drift, halves, largest_entries, off
from hknob_cli.engine.general.sets.ends import Known
from hknob_cli.engine.general.sets.friction_arc import STATE
from hknob_cli.engine.general.sets.friction_arc_parts import ARCS, INTERVAL
from hknob_cli.engine.general.sets.friction_room import holds_of
from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
from hknob_cli.engine.general.sets.readings import deepest_level
from hknob_cli.engine.general.sets.scope import Scope
from hknob_cli.engine.general.slide_many import NIL
from hknob_cli.engine.outcome import Reason

LONGEST = 1_000_000  # samples that all clock phases of one start may take: some seconds
INTERVALS = 4096  # of phases that wait
ROUNDED = 1e-6  # relative, of what is told of norms


class RubRoom(NamedTuple):
    """Work space of `friction_arcs`.

    ``course``: holds of an interval, `friction_arcs.HOLD` numbers each; ``torques``: of one; ``spans``: how far each
    number may go where the norm of its rate, which never grows, is 1; ``unit``, ``fast``: `differences`; ``stack``:
    arcs that wait; ``told``: readings of an interval, at its sample and within it. The others: of one arc, and, with
    ``own``, as it was at the sample.
    """

    course: Any
    torques: Any
    spans: Any
    unit: Any
    fast: Any
    stack: Any
    told: Any
    arc: Any
    z: Any
    columns: Any
    ring: Any
    own: Any
    own_z: Any
    own_columns: Any
    own_line: Any
    own_ring: Any
    spare: Any
    first: Any
    begun: Any
    stop: Any
    turning: Any
    ahead: Any
    line: Any
    pad: Any


def can_rub_arcs(body: Body, wall: Controller, law: Law | None = None) -> bool:
    """Whether arcs of states can be followed: an energy of differences bounds them, and grows by cogging alone.

    The scene has more than angle and speed, or cogging, reads counts, and a law is proven and feels no speed.
    """
    known = law is None or (law.provable and not law.senses)
    plain = body.play == 0.0 and wall.analog == 0.0 and body.damped and body.reach < inf
    return plain and known and (body.cogs is not None or body.order > 2)


def _modes_of(body: Body) -> list[tuple[int, int, int, float]]:
    """Where the matrices of each mode are: of rates and of halves; its constant torques, and friction."""
    modes = [(RATES, HALVES, CONSTANT, body.friction)]
    if body.cogs is not None:
        modes = [(COGGED + k, COGGED_HALVES + k * HALVINGS, CONSTANT, body.friction) for k in range(2)]
    if body.friction > 0.0 and body.order > 2:
        modes.append((HELD, HALVES_HELD, CONSTANT_HELD, 0.0))
    return modes


def rub_drift(body: Body, wall: Controller, law: Law | None = None) -> Drift:
    """Bounds on the roundings of one step of a slide, or of a knob that is held, as `drift.Drift` has them, in lists.

    A step takes any of the times of `body.HALVES`: the largest bound is that of all. An event is late by half of the
    last bit of a sample period, and a knob that friction holds nearly may slide by as much.
    """
    n = body.order
    units = [size_at(body.cogs, [float(i == j) for j in range(n)], 0, body) for i in range(n)]
    once = [0.0] * (n + 2)
    spring = constant_pull = 0.0
    if body.cogs is not None:
        # Its torque is added to the rates, by the distance from the middle of the slope, which is rounded, too.
        spring, constant_pull = 2.0 * body.cogs[SLOPE], body.cogs[SLOPE] * body.cogs[LENGTH]
    for rates, integrals, constant, friction in _modes_of(body):
        rate = []  # bounds on the terms of each rate: by 1, by the command, and by each number of the state
        for i in range(n):
            enters = abs(body.vectors[ENTRY * n + i]) if rates != HELD else 0.0
            command = enters if body.lag == 0.0 else (body.lag if i == n - 1 else 0.0)
            row = [abs(body.matrices[rates * n * n + i * n + j]) for j in range(n)]
            row[0] += enters * spring
            rate.append([abs(body.vectors[constant * n + i]) + enters * (friction + constant_pull), command, *row])
        late = [sum(units[i] * rate[i][k] for i in range(n)) for k in range(n + 2)]
        for half, exact in enumerate(halves(body, rates)):
            at = (integrals + half) * n * n
            most = [0.0] * (n + 2)
            for i in range(n):
                held = [abs(body.matrices[at + i * n + j]) for j in range(n)]
                wrong = [off(body.matrices[at + i * n + j], exact[i][j]) for j in range(n)]
                for k in range(n + 2):
                    own = 1.0 if k == 2 + i else 0.0
                    size = own + sum(held[j] * rate[j][k] for j in range(n))
                    wide = sum(wrong[j] * rate[j][k] for j in range(n))
                    most[k] += units[i] * (wide + (2 * n + 6) * EPSILON * size)
            once = [max(one, other + 4.0 * EPSILON * more) for one, other, more in zip(once, most, late, strict=True)]
    once[0] += 4.0 * NIL * body.friction
    return Drift(
        powers=[0.0],
        once=[MARGIN * value for value in once],
        units=units,
        blur=0.0,
        coast=0.0,
        bottom=deepest_level(wall) if law is None else -inf,
    )


def differences(body: Body) -> tuple[list[float], list[float]]:
    """Columns that span all differences of norm 1, (order) each, and how fast differences change, in `body.norm`.

    Torques that lag are the same for all states. The rates are that of a unit of speed of the knob, and the largest of
    norm 1, sliding and held; beside cogging in `cogging.size_at`, on whichever slope it is more.
    """
    n = body.order - (body.lag > 0.0)
    unit = [[float(i == j) for j in range(body.order)] for i in range(n)]
    square = [size_at(body.cogs, one, 0, body) ** 2 for one in unit]
    energy = np.diag(square)
    for i in range(n):
        for j in range(i):
            both = size_at(body.cogs, [p + q for p, q in zip(unit[i], unit[j], strict=True)], 0, body) ** 2
            energy[i, j] = energy[j, i] = 0.5 * (both - square[i] - square[j])
    half = np.linalg.cholesky(energy).T
    back = np.linalg.inv(half)
    matrices = np.array(body.matrices).reshape(-1, body.order, body.order)[:, :n, :n]
    entry = np.array(body.vectors[ENTRY * body.order : ENTRY * body.order + n])
    slides = (RATES,) if body.cogs is None else (COGGED, COGGED + 1)
    rates = [max(np.linalg.norm(half @ matrices[which] @ entry) for which in slides)]
    rates += [max(np.linalg.norm(half @ matrices[which] @ back, 2) for which in ways) for ways in (slides, (HELD,))]
    columns = np.zeros((n, body.order))
    columns[:, :n] = back.T
    return [(1.0 + ROUNDED) * value for value in columns.ravel()], [(1.0 + ROUNDED) * float(one) for one in rates]


def make_rub_room(
    zeros: Callable[[int], Any],
    filled: Callable[[list[float]], Any],
    body: Body,
    wall: Controller,
    delay: int,
    law: Law | None,
) -> RubRoom:
    """Work space for a cell with ``delay`` commands under way, or numbers that the law remembers."""
    n = body.order
    unit, fast = differences(body)
    wide = len(unit) + n + len(unit) // n + 1
    told = 1 + (0 if law is None else law.looks)
    return RubRoom(
        course=filled([number for hold in holds_of(wall, law) for number in hold]),
        torques=zeros(max(2, delay)),
        spans=filled(largest_entries(body)),
        unit=filled(unit),
        fast=filled(fast),
        stack=zeros(ARCS * (STATE + n + wide + delay + told)),
        told=zeros(told),
        arc=zeros(STATE),
        z=zeros(n),
        columns=zeros(wide),
        ring=zeros(delay),
        own=zeros(STATE),
        own_z=zeros(n),
        own_columns=zeros(wide),
        own_line=zeros(n),
        own_ring=zeros(delay),
        spare=zeros(delay),
        first=zeros(n),
        begun=zeros(n),
        stop=zeros(2),
        turning=zeros(n),
        ahead=zeros(n),
        line=zeros(n + 1),
        pad=zeros(2 * n),
    )


class FrictionArcEngine(FrictionSetEngine):
    """Follows all clock phases of one start as arcs; the group "friction arcs". One per thread."""

    def __init__(
        self,
        law: Law | None = None,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; ``functions``: the compiled group; ``law``: of a controller, as `LawSetEngine` has it."""
        super().__init__(functions, stopped, patience)
        self.law = law

    def able(self, body: Body, wall: Controller) -> bool:
        """Whether this engine follows the phases of a cell."""
        return can_rub_arcs(body, wall, self.law)

    def longest_phases(self, _body: Body) -> int:
        """As that of `FrictionSetEngine`."""
        return LONGEST

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
        """As that of `FrictionSetEngine`; None, too, where arcs take more work than a cell may.

        Trials then tell more than arcs that are given up.
        """
        limits: dict[str, Any] = {"max_samples": max_samples, "seconds": seconds}
        found = super().search_phases(body, wall, start, rate=rate, delay_line=delay_line, **limits)
        return None if found is not None and found.why is Reason.WORK_LIMIT else found

    def by_area(self, _body: Body) -> bool:
        """An arc holds more than its phases: what its centre ends in may be the end of none, and counts not then."""
        return True

    def intervals(self) -> tuple[int, int]:
        """Numbers of an interval of phases that waits, and how many may."""
        return INTERVAL, INTERVALS

    def drift(self, body: Body, wall: Controller) -> Drift:
        """As that of `GeneralSetEngine`, of one step of a slide."""
        return rub_drift(body, wall, self.law)

    def phase_follower(
        self, body: Body, wall: Controller, start: list[float], delay_line: int, scope: Scope
    ) -> tuple[Callable[..., Any], Known]:
        """What follows the intervals of phases that wait, called with them, and the ends that it enters."""
        room = make_rub_room(self._zeros, self._filled, body, wall, delay_line, self.law)
        cell = self.ready(body, wall, delay_line)
        follow = partial(self._function(friction_arcs, "follow_friction_arcs"), self._filled(start))
        return lambda *some: follow(*some, scope, room, cell), cell.known
