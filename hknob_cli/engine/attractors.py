"""What a cell's trials settle to: its attractors, each with its proof and its share of the trials."""

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine import ensemble as plain_ensemble
from hknob_cli.engine import follow
from hknob_cli.engine import orbit_cycle as plain_cycle
from hknob_cli.engine import orbit_holds as plain_trace
from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.budget import OPEN, TOO_FINE, TOO_MANY, TOO_SLOW, UNHELD, TrialBudget, prospect, unrepeated
from hknob_cli.engine.ensemble import ROW, first_sample
from hknob_cli.engine.loop import Loop
from hknob_cli.engine.orbit_cycle import CycleMeasures
from hknob_cli.engine.orbit_holds import PART
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.propagator import slowest_rate

LANES = 64  # trials side by side: 64 keep the vector units full and the block in the first cache
SLICE = 16_384  # trials between two chances to be interrupted
CAPACITY = 1024  # distinct orbits a cell keeps
PATIENCE = 20_000  # samples a trial may take in the interpreter
PAUSE_S = 0.1  # between two chances to hear that the time is over

FATES = {
    follow.CYCLE_PROVEN: (Outcome.CYCLE, Reason.NONE),
    follow.CYCLE_ON_EDGE: (Outcome.CYCLE, Reason.ON_EDGE),
    follow.CYCLE_CONTINUUM: (Outcome.CYCLE, Reason.CONTINUUM),
    follow.REST_PROVEN: (Outcome.REST, Reason.NONE),
    follow.REST_EDGE: (Outcome.REST, Reason.REST_ON_EDGE),
    follow.GREW: (Outcome.DIVERGED, Reason.GREW),
    follow.LEFT: (Outcome.DIVERGED, Reason.LEAVES),
    follow.UNSETTLED: (Outcome.UNDECIDED, Reason.NO_REPEAT),
    follow.UNDAMPED: (Outcome.UNDECIDED, Reason.NO_DAMPING),
    TOO_SLOW: (Outcome.UNDECIDED, Reason.TOO_SLOW),
    UNHELD: (Outcome.UNDECIDED, Reason.NO_STIFFNESS),
    TOO_FINE: (Outcome.UNDECIDED, Reason.TOO_FINE),
    TOO_MANY: (Outcome.UNDECIDED, Reason.TOO_MANY),
}


class Attractor(NamedTuple):
    """One attractor of a cell, dimensionless (counts, samples).

    ``trials``: that reach it; where all starts are followed at once, their share.
    ``period``: samples, 1 at rest, 0 without an orbit. ``x``, ``v``: state at its deepest sample; ``line``: levels
    under way there, oldest first. ``margin``: least distance of a sample to an edge that changes the torque; ``edge``:
    to any count edge; ``closure``: residual of the period map; ``bound``: rounding error of the orbit's positions.
    In the general loop ``line`` holds commands, ``state`` what the body has beside x and v, ``before`` the reading one
    sample earlier, and ``span`` the least and the largest position at which friction holds trials at rest.
    """

    outcome: Outcome
    reason: Reason
    trials: float
    period: int = 0
    x: float = 0.0
    v: float = 0.0
    line: tuple[float, ...] = ()
    margin: float = 0.0
    edge: float = 0.0
    closure: float = 0.0
    bound: float = 0.0
    state: tuple[float, ...] = ()
    before: float = 0.0
    span: tuple[float, float] | None = None

    @property
    def certified(self) -> bool:
        """Whether the attractor, and that its trials reach it, is proven."""
        return self.reason is Reason.NONE


class StoppedError(Exception):
    """The search was told to stop."""


class Search(NamedTuple):
    """Attractors of one cell, the most frequent first, and the trial-samples it took to find them.

    Where all starts are followed at once, ``complete`` says whether all of them are proven to end in these attractors;
    ``pieces``: sets followed to their end, the ``narrowest`` of them as a share of the starts; ``undecided``: a bound
    on the share of starts whose end is not proven, where shares are counted by other means, and ``why``, of most of
    them; ``share_error``: a bound on what rounding may have added to a share or taken from it, where shares are
    lengths. ``region``: least and largest position, least and largest speed of a region that every motion comes into,
    where all starts are meant; ``grows``: those of one outside of which every motion grows without bound.
    """

    attractors: tuple[Attractor, ...]
    samples: int
    complete: bool | None = None
    pieces: int = 0
    narrowest: float = 0.0
    undecided: float | None = None
    share_error: float | None = None
    region: tuple[float, float, float, float] | None = None
    why: Reason = Reason.NONE
    grows: tuple[float, float, float, float] | None = None


class NeedsCompilerError(Exception):
    """A trial is too long for the interpreter; ``group``: the functions to compile."""

    def __init__(self, group: str = "plain") -> None:
        super().__init__(group)
        self.group = group


class Patience(NamedTuple):
    """How much the interpreter tries before it asks to be compiled: samples of a trial, and seconds of a search."""

    samples: int = PATIENCE
    seconds: float | None = None


USUAL = Patience()


def time_allowed(seconds: float | None, patience: Patience, *, compiled: bool) -> float | None:
    """Seconds until a search ends: those of its cell, or, in the interpreter, of its patience; None: any."""
    if compiled or patience.seconds is None:
        return seconds
    return patience.seconds if seconds is None else min(seconds, patience.seconds)


def unfinished(trials: float, seconds: float | None, patience: Patience, *, compiled: bool) -> Attractor:
    """The trials that a search had no time for. Raises `NeedsCompilerError` where it was the patience that ended."""
    if not compiled and seconds != time_allowed(seconds, patience, compiled=False):
        raise NeedsCompilerError
    return whole(Outcome.UNDECIDED, Reason.TIME_LIMIT, trials)


class Runner:
    """What runs engine functions, plain or compiled; one per thread."""

    def __init__(
        self,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; ``functions``: compiled, by name; ``stopped``: asked between slices whether to give up."""
        self.stopped = stopped
        self.patience = patience
        self.compiled = functions is not None
        self._functions = functions
        self._begin()

    def _begin(self) -> None:
        """Choose the functions, and make the work space that lasts; nothing by itself."""

    def _function(self, name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        """The compiled function of a name, or the plain one."""
        return self._functions[name] if self._functions else plain

    def zeros(self, count: int) -> Any:
        """Work space: an array for compiled code, a list for the interpreter, which is quicker on it."""
        return np.zeros(count) if self.compiled else [0.0] * count

    def filled(self, values: Sequence[float]) -> Any:
        """Work space with these values."""
        return np.array(values, dtype=np.float64) if self.compiled else list(values)


class Engine(Runner):
    """The ensemble kernel, what its orbits are measured by, and work space."""

    def _begin(self) -> None:
        self._ensemble = self._function("ensemble", plain_ensemble.ensemble)
        self._trace = self._function("trace", plain_trace.trace)
        self._measure = self._function("measure_cycle", plain_cycle.measure_cycle)

    def search(
        self,
        loop: Loop,
        *,
        x: float,
        v: float,
        phases: int,
        delay_line: int,
        max_samples: int | None,
        seconds: float | None = None,
    ) -> Search:
        """Run ``phases`` trials from (``x`` counts, ``v`` counts per sample) and name what they settle to.

        ``seconds``: on the clock, after which the trials that are left are undecided; None: as long as it takes.

        Raises `NeedsCompilerError` in the interpreter, where the same search compiled would succeed, and `StoppedError`
        when told to stop.
        """
        fate, most, skip, limit = prospect(x, v, max_samples or 0, loop)
        if fate != OPEN:
            return Search(attractors=(whole(*FATES[fate], phases),), samples=0)
        patience = self.patience.samples
        cut = not self.compiled and most > patience
        width = min(LANES, phases)
        room = plain_ensemble.TrialRoom(
            x=self.zeros(width),
            v=self.zeros(width),
            line=self.zeros(width * delay_line),
            ring=self.zeros(delay_line),
            table=self.zeros(ROW * CAPACITY),
            lines=self.zeros(CAPACITY * delay_line),
        )
        budget = TrialBudget(skip, min(most, patience + skip) if cut else most, not cut, limit)
        rows, overflow, samples = 0, 0, 0
        at = first_sample(x, v, phases, loop)
        alarm = Alarm(time_allowed(seconds, self.patience, compiled=self.compiled))
        start, size = 0, 1 if alarm.limited else SLICE
        while start < phases and not alarm.over:  # compiled code does not hear an interruption
            if self.stopped():
                raise StoppedError
            stop, begin = min(start + size, phases), perf_counter()
            rows, full, taken, at = self._ensemble(at, phases, start, stop, budget, rows, room, loop)
            overflow += full
            samples += int(taken)
            start = stop
            if alarm.limited:
                spent = max(perf_counter() - begin, 1e-6)
                size = max(1, min(4 * size, int(size * PAUSE_S / spent), SLICE))
        if cut and any(room.table[ROW * row] in (follow.UNSETTLED, follow.UNDAMPED) for row in range(rows)):
            raise NeedsCompilerError
        why = why_unrepeated(slowest_rate(loop.alpha, loop.beta), most, held=loop.beta > 0.0)
        found = [
            attractor_of(
                room.table[ROW * row : ROW * row + ROW], room.lines[row * delay_line : (row + 1) * delay_line], why
            )
            for row in range(rows)
        ]
        if overflow:
            found.append(whole(Outcome.UNDECIDED, Reason.TOO_MANY, overflow))
        if start < phases:
            found.append(unfinished(phases - start, seconds, self.patience, compiled=self.compiled))
        return Search(attractors=ranked(found), samples=samples)

    def trace(self, loop: Loop, orbit: Attractor) -> tuple[NDArray[np.float64], ...]:
        """One period of an orbit: states at its samples (n + 1 each), older and newer drives (n each)."""
        xs, vs, drive = self.holds(loop, orbit)
        kinds = plain_trace.holds_per_sample(loop)
        return xs[::kinds], vs[::kinds], drive[::kinds], drive[kinds - 1 :: kinds]

    def holds(self, loop: Loop, orbit: Attractor) -> tuple[NDArray[np.float64], ...]:
        """One period of an orbit: states at the start of its holds and at its end (m + 1 each), drives in them (m)."""
        room = self._room(loop, orbit)
        self._trace(orbit.x, orbit.v, self._ring(orbit), 0, orbit.period, loop, room)
        return tuple(np.asarray(values) for values in room)

    def measure(self, loop: Loop, orbit: Attractor, parts: Any = None) -> CycleMeasures:
        """Measures of a cycle; ``parts``: what `hold_space` gave for this loop, so that it is filled in once."""
        parts = self.hold_space() if parts is None else parts
        room = self._room(loop, orbit)
        return CycleMeasures(*self._measure(orbit.x, orbit.v, self._ring(orbit), 0, orbit.period, loop, parts, room))

    def hold_space(self) -> Any:
        """Room for the numbers of the holds of a loop."""
        return self.zeros(2 * PART)

    def _room(self, loop: Loop, orbit: Attractor) -> plain_trace.Holds:
        """Room for one period: states and drives of its holds."""
        count = orbit.period * plain_trace.holds_per_sample(loop)
        return plain_trace.Holds(self.zeros(count + 1), self.zeros(count + 1), self.zeros(count))

    def _ring(self, orbit: Attractor) -> Any:
        return self.filled(orbit.line)


def whole(outcome: Outcome, reason: Reason, trials: float) -> Attractor:
    """An end without an orbit."""
    return Attractor(outcome=outcome, reason=reason, trials=trials)


def ranked(found: list[Attractor]) -> tuple[Attractor, ...]:
    """Attractors, the most frequent first."""
    return tuple(sorted(found, key=lambda one: (-one.trials, one.outcome, one.period, one.x)))


def why_unrepeated(rate: float, budget: int, *, held: bool) -> Reason:
    """Why a trial found no repeating levels within ``budget`` samples; ``held``: whether a spring holds the knob."""
    return FATES[unrepeated(rate, budget, held)][1]


def attractor_of(row: Any, line: Any, unrepeated: Reason) -> Attractor:
    """Attractor from a row of the kernel's table; ``unrepeated``: the reason for one whose levels never repeated."""
    fate, n, x, v, margin, edge, closure, bound, trials, _ = (float(value) for value in row)
    outcome, reason = FATES[int(fate)]
    if reason is Reason.NO_REPEAT:
        reason = unrepeated
    if int(n) == 0:
        return whole(outcome, reason, trials)
    if outcome is Outcome.REST:
        edge = min(x % 1.0, 1.0 - x % 1.0)
    return Attractor(
        outcome=outcome,
        reason=reason,
        trials=trials,
        period=int(n),
        x=x,
        v=v,
        line=tuple(float(level) for level in line),
        margin=margin,
        edge=edge,
        closure=closure,
        bound=bound,
    )
