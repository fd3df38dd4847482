"""What the trials of a cell settle to in the general loop; the counterpart of `engine.attractors.Engine`."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine import follow
from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import (
    FATES,
    PAUSE_S,
    Attractor,
    NeedsCompilerError,
    Runner,
    Search,
    StoppedError,
    ranked,
    time_allowed,
    unfinished,
    whole,
    why_unrepeated,
)
from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.general import ensemble, period_map, trace
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.columns import MARKS
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.corners import MOST_PARTS
from hknob_cli.engine.general.follow import CYCLE_AT_EVENT, CYCLE_EXPANDS, CYCLE_PARTS
from hknob_cli.engine.general.interval import TRIAL
from hknob_cli.engine.general.laws.law import CYCLE_AT_SWITCH, CYCLE_NOT_AFFINE, REST_NOT_PROVEN
from hknob_cli.engine.general.outlook import Outlook, make_outlook
from hknob_cli.engine.general.period_map import Space
from hknob_cli.engine.general.torque_range import torque_range
from hknob_cli.engine.outcome import Outcome, Reason

GENERAL_FATES = {
    **FATES,
    CYCLE_AT_EVENT: (Outcome.CYCLE, Reason.AT_EVENT),
    CYCLE_EXPANDS: (Outcome.CYCLE, Reason.EXPANDS),
    CYCLE_PARTS: (Outcome.CYCLE, Reason.PARTS),
    CYCLE_AT_SWITCH: (Outcome.CYCLE, Reason.AT_SWITCH),
    CYCLE_NOT_AFFINE: (Outcome.CYCLE, Reason.NOT_AFFINE),
    REST_NOT_PROVEN: (Outcome.REST, Reason.EXPANDS),
}
AT_ONCE = 2**40  # phases, of which the first is half a trillionth of a sample after the start
FIRST_SLICE = 8  # trials until the first chance to be interrupted
TRAIL = 8192  # readings of a candidate period that are kept to compare it with the next
ROWS = 256  # distinct orbits a cell keeps
FREELY = 10.0  # times that a sample of the general loop takes longer in the interpreter
MOST_PIECES = 200_000  # of a period that is measured

Array = NDArray[np.float64]


class PeriodSegments:
    """One period, piece by piece between events; ``m`` pieces, order ``n``.

    ``spans`` (m): length; ``modes`` (m): +1, -1 sliding, 0 held; with teeth that part as `flanks.kind_of`, beside
    cogging as `slopes.cog_chart` has them; ``commands`` (m): command acting; ``states`` (m + 1, n): state at the start
    of each piece and at the end.
    """

    def __init__(self, spans: Array, modes: Array, commands: Array, states: Array) -> None:
        self.spans, self.modes, self.commands, self.states = spans, modes, commands, states


def make_space(order: int, delay: int, zeros: Callable[[int], Any]) -> Space:
    """Work space of the general loop, of what ``zeros`` makes."""
    width = order + delay + 1
    return Space(
        width=width,
        pad=zeros(4 * order),
        cols=zeros(width * (width + 2)),
        marks=zeros(MARKS),
        chain=zeros((MOST_PARTS + 2) * order * order),
        matrix=zeros(2 * width * width),
        power=zeros(width * width),
        total=zeros(width * width),
        spare=zeros(width * width),
        residual=zeros(width),
        away=zeros(width),
        state=zeros(order),
        orbit=zeros(order),
        line=zeros(delay),
        orbit_line=zeros(delay),
        trail=zeros(TRAIL),
        reading=zeros(1),
    )


def as_list(wall: Controller) -> Controller:
    """The controller with lists in place of its arrays, for the interpreter, which is quicker on them."""
    wall = wall if wall.clock is None else wall._replace(clock=list(wall.clock))
    wall = wall if wall.curve is None else wall._replace(curve=wall.curve.tolist())
    return wall if wall.table is None else wall._replace(table=wall.table.tolist())


def as_arrays(body: Body) -> Body:
    """The body with arrays in place of lists, for functions that are given no controller."""
    return Body._make(np.array(value) if isinstance(value, list) else value for value in body)


def as_compiled(body: Body, wall: Controller) -> tuple[Body, Controller]:
    """Body and controller as compiled code wants them: with arrays, which are empty for what is absent beside others.

    Code is compiled for the types that it is given: once for scenes with none of cogging, a torque over the angle and
    jitter, in which nothing of them is left; and once, not for each of their combinations, for all that have any.
    """
    body = as_arrays(body)
    parts = (body.cogs, wall.table, wall.clock, wall.curve)
    if all(part is None for part in parts):
        return body, wall
    cogs, table, clock, curve = (np.zeros(0) if part is None else part for part in parts)
    return body._replace(cogs=cogs), wall._replace(table=table, clock=clock, curve=curve)


def _ends(trial: ensemble.TrialSpace, body: Body, delay_line: int, outlook: Outlook, why: Reason) -> list[Attractor]:
    """What is in the table of ends; ``why``: reason of those that do not repeat."""
    n, table = body.order, trial.table
    races = body.cogs is not None and outlook.grew is Reason.GREW
    return [
        attractor_of(
            table[FIELDS * row : FIELDS * (row + 1)],
            [float(value) for value in trial.states[row * n : (row + 1) * n]],
            [float(value) for value in trial.lines[row * delay_line : (row + 1) * delay_line]],
            why,
            Reason.RACES if races and abs(trial.states[row * n]) < outlook.far else outlook.grew,
            parts=_why_parts(body),
            keep=body.play > 0.0 or body.cogs is not None or why is Reason.JITTERS,
        )
        for row in range(int(trial.counts[0]))
    ]


class GeneralEngine(Runner):
    """The general loop, plain or compiled; one per thread."""

    def _begin(self) -> None:
        self._run_trials = self._function("general.run_trials", ensemble.run_trials)
        self._chart = self._function("general.chart_period", trace.chart_period)
        self._part = self._function("general.parting_rate", period_map.parting_rate)
        self.compiled_leak = self._functions["find_leak"] if self._functions else None

    torques = staticmethod(torque_range)  # what is commanded far out

    def _ready_for_loop(self, body: Body, wall: Controller) -> tuple[Body, Controller]:
        return as_compiled(body, wall) if self.compiled else (body, as_list(wall))

    def search(
        self,
        body: Body,
        wall: Controller,
        start: list[float],
        *,
        rate: float,
        phases: int,
        delay_line: int,
        max_samples: int | None,
        seconds: float | None = None,
        several: list[list[float]] | None = None,
    ) -> Search:
        """Run ``phases`` trials from the state ``start`` and name what they settle to.

        ``several``: as many states at a sample, a trial from each; ``start`` is then as far out as any of them.

        ``rate``: decay of the slowest mode, per sample; ``seconds``: on the clock, after which the trials that are left
        are undecided, None: as long as it takes. Raises `NeedsCompilerError` in the interpreter, where the same
        search compiled would succeed, and `StoppedError` when told to stop.
        """
        outlook = make_outlook(body, wall, self.torques(wall), start, rate, max_samples)
        if outlook.ends is not Reason.NONE:
            outcome = Outcome.UNDECIDED if outlook.ends is Reason.TOO_FINE else Outcome.DIVERGED
            return Search(attractors=(whole(outcome, outlook.ends, phases),), samples=0)
        patience = int(self.patience.samples / FREELY)
        cut = not self.compiled and outlook.budget > patience
        if cut and outlook.skip > patience:
            raise NeedsCompilerError
        jittering = wall.clock is not None
        if jittering:
            wall = wall._replace(clock=wall.clock.copy())
        ready, wall = self._ready_for_loop(body, wall)
        trial = self._room(body.order, delay_line)
        most = min(outlook.budget, patience + outlook.skip) if cut else outlook.budget
        followed = TrialBudget(outlook.skip, most, not cut, outlook.far)
        overflow = samples = 0
        first, slice_size = 0, FIRST_SLICE
        with Alarm(time_allowed(seconds, self.patience, compiled=self.compiled), ready.halt) as alarm:
            while first < phases and not alarm.over:
                if self.stopped():
                    raise StoppedError
                stop = min(first + slice_size, phases)
                begin = perf_counter()
                runs = [(one, ensemble.Batch(AT_ONCE, 0, 1)) for one in several[first:stop]] if several else None
                for k, (state, batch) in enumerate(runs or [(start, ensemble.Batch(phases, first, stop))]):
                    if jittering and runs:
                        wall.clock[TRIAL] = float(first + k)  # each start has intervals of its own
                    full, taken = self._run_trials(self.filled(state), batch, followed, trial, ready, wall)
                    overflow += full
                    samples += int(taken)
                # Compiled code does not hear an interruption. The result does not depend on the slices.
                spent, first = perf_counter() - begin, stop
                slice_size = max(1, min(4 * slice_size, int(slice_size * PAUSE_S / max(spent, 1e-6))))
        fates = [int(trial.table[FIELDS * row]) for row in range(int(trial.counts[0]))]
        if cut and any(fate in (follow.UNSETTLED, follow.UNDAMPED) for fate in fates):
            raise NeedsCompilerError
        why = Reason.JITTERS if jittering else why_unrepeated(rate, outlook.budget, held=outlook.held)
        found = _ends(trial, body, delay_line, outlook, why)
        if overflow:
            found.append(whole(Outcome.UNDECIDED, Reason.TOO_MANY, overflow))
        left = phases - overflow - sum(one.trials for one in found if one.reason is not Reason.TOO_MANY)
        if left:
            found.append(unfinished(left, seconds, self.patience, compiled=self.compiled))
        return Search(attractors=ranked(found), samples=samples)

    def _room(self, order: int, delay_line: int) -> ensemble.TrialSpace:
        """Work space of a trial, and an empty table of ends."""
        return ensemble.TrialSpace(
            z=self.zeros(order),
            ring=self.zeros(delay_line),
            check=self.zeros(order),
            check_ring=self.zeros(delay_line),
            keep=self.zeros(order),
            keep_ring=self.zeros(delay_line),
            counts=self.zeros(1),
            table=self.zeros(FIELDS * ROWS),
            states=self.zeros(order * ROWS),
            lines=self.zeros(delay_line * ROWS),
            space=make_space(order, delay_line, self.zeros),
        )

    def parting_rate(self, body: Body, wall: Controller, end: Attractor, samples: int) -> float:
        """How fast motions near the end of a trial part, per sample: see `engine.general.period_map`."""
        ready, wall = self._ready_for_loop(body, wall)
        space = make_space(body.order, len(end.line), self.zeros)
        state, line = self.filled([end.x, end.v, *end.state]), self.filled(end.line)
        return float(self._part(state, end.before, line, samples, ready, wall, space))

    def chart(self, body: Body, wall: Controller, orbit: Attractor) -> PeriodSegments | None:
        """One period of an orbit from event to event; None if it has too many pieces."""
        n = body.order
        ready, wall = self._ready_for_loop(body, wall)
        capacity = 16 * orbit.period + 64
        while capacity <= 4 * MOST_PIECES:
            state = self.filled([orbit.x, orbit.v, *orbit.state])
            pieces = trace.Pieces(
                spans=self.zeros(capacity),
                modes=self.zeros(capacity),
                commands=self.zeros(capacity),
                states=self.zeros((capacity + 1) * n),
            )
            line, pad = self.filled(orbit.line), self.zeros(2 * n)
            rows = self._chart(state, orbit.before, line, orbit.period, ready, wall, pad, pieces)
            if rows < capacity:
                spans, modes, commands = (np.array(values[:rows], dtype=np.float64) for values in pieces[:3])
                table = np.array(pieces.states[: (rows + 1) * n], dtype=np.float64).reshape(rows + 1, n)
                return PeriodSegments(spans, modes, commands, table)
            capacity *= 16
        return None


def _why_parts(body: Body) -> Reason:
    """Why a cycle is not proven whose motion is not that of one flank, or slope."""
    if body.cogs is None:
        return Reason.PARTS
    return Reason.PARTS_OR_COGS if body.play > 0.0 else Reason.COGS


def attractor_of(
    row: Any,
    state: list[float],
    line: list[float],
    unrepeated: Reason,
    grew: Reason = Reason.GREW,
    *,
    parts: Reason = Reason.PARTS,
    keep: bool = False,
) -> Attractor:
    """Attractor from a row of the kernel's tables; why one's levels never repeated, and why it went past the limit.

    ``parts``: why a cycle is not proven whose motion is not that of one flank, or slope.
    ``keep``: whether an undecided end has the state of the first trial in it, to be followed further.
    """
    fate, n, margin, edge, closure, bound, trials, least, most, before = (float(value) for value in row)
    outcome, reason = GENERAL_FATES[int(fate)]
    if reason is Reason.NO_REPEAT or (reason is Reason.EXPANDS and unrepeated is Reason.JITTERS):
        reason = unrepeated
    elif reason is Reason.GREW:
        reason = grew
    elif reason is Reason.PARTS:
        reason = parts
    if int(n) == 0:
        found = whole(outcome, reason, trials)
        if keep and outcome is Outcome.UNDECIDED:
            found = found._replace(x=state[0], v=state[1], state=tuple(state[2:]), line=tuple(line), before=before)
        return found
    rest = outcome is Outcome.REST
    x = state[0]
    return Attractor(
        outcome=outcome,
        reason=reason,
        trials=trials,
        period=int(n),
        x=x,
        v=state[1],
        line=tuple(line),
        margin=margin,
        edge=min(x % 1.0, 1.0 - x % 1.0) if rest else edge,
        closure=closure,
        bound=bound,
        state=tuple(state[2:]),
        before=before,
        span=(least, most) if rest else None,
    )
