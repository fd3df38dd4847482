"""The measures of an attractor of the general loop: what a row of ``orbits.parquet`` says.

The work of the wall by when it is done, of a motion in arrays; what that means: `engine.orbit_cycle`.
"""

from collections.abc import Callable
from math import nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.search import GeneralEngine, PeriodSegments
from hknob_cli.engine.general.teeth import APART
from hknob_cli.engine.orbit_cycle import find_leak
from hknob_cli.engine.orbit_holds import RULE
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.forms import (
    Array,
    Integrals,
    hold_forms,
    integrate,
    piece_starts,
    regime_of,
    relaxed,
    ways,
)
from hknob_cli.measure.orbit import Harmonics, OrbitMeasures, at_rest, harmonic_count, scaled
from hknob_cli.measure.pieces import NEGLIGIBLE, extremes, knob_row, mesh_row, of_chart
from hknob_cli.scene.general_knob import GeneralKnob

RATTLE = 4096  # samples over which a motion that does not repeat is measured
_MOVING = (Reason.NO_REPEAT, Reason.TOO_SLOW, Reason.NO_STIFFNESS, Reason.NO_DAMPING)
MOST_WORK = 400_000_000  # pieces times harmonics of an orbit
BLOCK = 512  # short pieces whose numbers the processor's own memory holds
SHORT = 1.0  # time in units of the fastest mode, up to which ten nodes integrate a piece to rounding


class Leak(NamedTuple):
    """Work of the wall over one period by when it is done, in units of J (counts per sample)²."""

    entry: float
    exit: float
    staircase: float


def split_leak(
    x: Array,
    torque: Array,
    *,
    edge: float,
    kappa: float,
    offset: float,
    analog: bool = False,
    compiled: Callable[..., Any] | None = None,
) -> Leak:
    """Split the work of the wall.

    Args:
        x: Positions, counts (m + 1,).
        torque: What the wall's torque is between them, as an acceleration (m,).
        edge: Position below which a wall that answers at once would act.
        kappa: Stiffness of the wall, K T^2 / J.
        offset: Angle that an encoder level reports, less the level, counts.
        analog: Whether the sensor has no counts.
        compiled: `find_leak`, compiled; the interpreter is quicker on lists.
    """
    numbers = len(torque), 0.0, edge, kappa, offset, analog
    if compiled:
        return Leak(*compiled(np.ascontiguousarray(x), torque, *numbers))
    return Leak(*find_leak(x.tolist(), torque.tolist(), *numbers))


class Turns(NamedTuple):
    """Positions where the motion turns round, counts."""

    maxima: Array
    minima: Array


def find_turns(chart: PeriodSegments) -> Turns:
    """Local maxima and minima of a period; a stretch at which the knob is held counts once."""
    modes = ways(chart.modes)
    sliding = np.flatnonzero(modes != 0.0)
    modes, x = modes[sliding], chart.states[sliding, 0]
    turned = modes != np.roll(modes, 1)
    return Turns(maxima=x[turned & (modes < 0.0)], minima=x[turned & (modes > 0.0)])


class Totals(NamedTuple):
    """Integrals over a period: of x and x² about a reference, power of the dampers, and of the lagging torque."""

    mean: float
    square: float
    loss: float
    power: float


class GeneralMeasurer:
    """Measures the attractors of one cell; integrals over a whole hold are computed once."""

    def __init__(self, knob: GeneralKnob, engine: GeneralEngine) -> None:
        self.knob = knob
        self.engine = engine
        self._charted: tuple[Attractor, PeriodSegments | None] | None = None
        self._usual: set[float] = set()  # lengths of pieces of which an orbit had many
        self._integrals: dict[tuple[float, int], Integrals] = {}

    def harmonics(self, attractor: Attractor, highest_hz: float) -> Harmonics:
        """Harmonics of a cycle up to ``highest_hz``; none of one with too many pieces to chart."""
        body, period_s = self.knob.body, self.knob.period_s
        count = harmonic_count(attractor.period, sample_period_s=period_s, highest_hz=highest_hz)
        chart = self._chart(attractor)
        amplitudes = np.zeros(0, complex)
        if chart is not None:
            count = min(count, MOST_WORK // len(chart.spans))
            amplitudes = of_chart(body, chart, attractor.period, count, behind=self.knob.behind)
        return scaled(amplitudes, attractor.period, sample_period_s=period_s, quantum_rad=self.knob.quantum_rad)

    def measure(self, attractor: Attractor) -> OrbitMeasures:
        """Measures of ``attractor``."""
        if attractor.outcome is Outcome.REST:
            least, most = attractor.span or (attractor.x, attractor.x)
            return at_rest(self.knob.angle_rad(least), self.knob.angle_rad(most))
        if attractor.outcome is not Outcome.CYCLE:
            return self._jitter(attractor) if attractor.reason is Reason.JITTERS else self._rattle(attractor)
        chart = self._chart(attractor)
        return OrbitMeasures() if chart is None else self._cycle(attractor, chart)

    def _chart(self, attractor: Attractor) -> PeriodSegments | None:
        """One period of an orbit, charted once for its measures and its harmonics."""
        if self._charted is None or self._charted[0] is not attractor:
            self._charted = attractor, self.engine.chart(self.knob.body, self.knob.wall, attractor)
        return self._charted[1]

    def _cycle(self, attractor: Attractor, chart: PeriodSegments) -> OrbitMeasures:
        knob, body, wall = self.knob, self.knob.body, self.knob.wall
        turns = find_turns(chart)
        cycles = len(turns.maxima)
        if cycles == 0:  # there are as many minima
            return OrbitMeasures()
        x = chart.states[:, 0]
        reference = float(x[:-1].mean())
        closed = body.order == 2 and body.cogs is None
        totals = self._few_states(chart, reference) if closed else self._many_states(chart, reference)
        mean = totals.mean / attractor.period
        rms = sqrt(max(totals.square / attractor.period - mean * mean, 0.0))
        travel = float(np.abs(np.diff(x))[chart.modes != 0.0].sum())
        lagging = body.lag > 0.0
        work = totals.power if lagging else float(((chart.commands - chart.commands.mean()) * np.diff(x)).sum())
        shaped = wall.table is not None or wall.curve is not None
        leak = None if lagging or shaped or wall.hysteresis > 0.0 else self._leak(x, chart.commands)
        energy = knob.energy_j
        return OrbitMeasures(
            cycles=cycles,
            p2p_rad=float(turns.maxima.mean() - turns.minima.mean()) * knob.quantum_rad,
            min_rad=knob.angle_rad(float(turns.minima.min())),
            max_rad=knob.angle_rad(float(turns.maxima.max())),
            rms_rad=rms * knob.quantum_rad,
            frequency_hz=cycles / (attractor.period * knob.period_s),
            wall_work_j=work * energy,
            damping_loss_j=totals.loss * energy,
            friction_loss_j=body.friction * travel * energy if body.friction > 0.0 else nan,
            late_entry_j=leak.entry * energy if leak else nan,
            late_exit_j=leak.exit * energy if leak else nan,
            staircase_j=leak.staircase * energy if leak else nan,
            **self._behind(chart),
        )

    def _behind(self, chart: PeriodSegments) -> dict[str, float]:
        """Swing of a knob behind a gear that yields, rad, and what its mesh carries, N·m; nothing without one."""
        knob, body = self.knob, self.knob.body
        if not knob.behind:
            return {}
        least, most = extremes(body, chart, knob_row)
        lightest, heaviest = extremes(body, chart, mesh_row)
        return {
            "knob_p2p_rad": (most - least) * knob.quantum_rad,
            "mesh_least_nm": lightest * knob.torque_nm,
            "mesh_most_nm": heaviest * knob.torque_nm,
        }

    def _rattle(self, attractor: Attractor) -> OrbitMeasures:
        """Trials that do not repeat, by teeth that part or by cogging: swing and chaos of one after its last sample."""
        knob, body = self.knob, self.knob.body
        cogged = body.cogs is not None and attractor.reason in _MOVING
        if not (body.play > 0.0 and attractor.state) and not cogged:
            return OrbitMeasures()
        chart = self.engine.chart(body, knob.wall, attractor._replace(period=RATTLE))
        if chart is None:
            return OrbitMeasures()
        least, most = extremes(body, chart, knob_row) if knob.behind else (0.0, float(np.ptp(chart.states[:, 0])))
        rate = self.engine.parting_rate(body, knob.wall, attractor, RATTLE)
        return OrbitMeasures(rattle_p2p_rad=(most - least) * knob.quantum_rad, parting_per_s=rate / knob.period_s)

    def _jitter(self, attractor: Attractor) -> OrbitMeasures:
        """Where the sample clock jitters: swing and pitch of one trial after its last sample."""
        knob = self.knob
        charts = (self.engine.chart(knob.body, knob.wall, attractor._replace(period=n)) for n in (RATTLE, RATTLE // 4))
        chart = next((one for one in charts if one is not None), None)
        if chart is None:
            return OrbitMeasures()
        turns, x = find_turns(chart), chart.states[:, 0]
        found = OrbitMeasures(
            cycles=0, jitter_p2p_rad=0.0, jitter_range_rad=float(np.ptp(x)) * knob.quantum_rad, **self._behind(chart)
        )
        if len(turns.maxima) == 0 or len(turns.minima) == 0:
            return found
        return found._replace(
            jitter_p2p_rad=float(turns.maxima.mean() - turns.minima.mean()) * knob.quantum_rad,
            jitter_frequency_hz=len(turns.maxima) / (float(chart.spans.sum()) * knob.period_s),
        )

    def _leak(self, x: Array, commands: Array) -> Leak:
        wall = self.knob.wall
        edge = 0.0 if wall.sense > 0.0 or wall.analog > 0.0 else -1.0
        analog, compiled = wall.analog > 0.0, self.engine.compiled_leak
        return split_leak(
            x, commands, edge=edge, kappa=wall.kappa, offset=wall.offset, analog=analog, compiled=compiled
        )

    def _few_states(self, chart: PeriodSegments, reference: float) -> Totals:
        """Second order: whole holds by their forms, pieces between events by quadrature."""
        body = self.knob.body
        pace = max(body.alpha, sqrt(body.beta))
        y = chart.commands + body.drive - chart.modes * body.friction - body.beta * reference
        z = np.stack([chart.states[:-1, 0] - reference, chart.states[:-1, 1], y])
        z[2, chart.modes == 0.0] = body.beta * z[0, chart.modes == 0.0]
        spans, which, counts = np.unique(chart.spans, return_inverse=True, return_counts=True)
        whole = (pace * spans > SHORT) | (counts >= 4) | np.isin(spans, list(self._usual))
        short = np.flatnonzero(~whole[which])
        parts = [_quadrature(z[:, short], chart.spans[short], body.alpha, body.beta)]
        for k in np.flatnonzero(whole):
            span, part = float(spans[k]), z[:, which == k]
            form = hold_forms(body.alpha, body.beta, span)
            if counts[k] >= 4:
                self._usual.add(span)
            sums = (form.mean @ part).sum(), (part * (form.square @ part)).sum(), (part * (form.speed @ part)).sum()
            parts.append(np.array(sums)[:, None])
        # One after another from the shortest piece on: the last digit does not depend on how they are grouped.
        order = np.argsort(np.concatenate([which[short], np.flatnonzero(whole)]), kind="stable")
        mean, square, speed = (float(row[-1]) for row in np.cumsum(np.concatenate(parts, axis=1)[:, order], axis=1))
        return Totals(mean=mean, square=square, loss=body.alpha * speed, power=nan)

    def _many_states(self, chart: PeriodSegments, reference: float) -> Totals:
        """More states, or cogging: every piece by the integrals over its length."""
        body, starts = self.knob.body, piece_starts(self.knob.body, chart)
        total = np.zeros(4)
        for i, (span, mode) in enumerate(zip(chart.spans, chart.modes, strict=True)):
            key = float(span), int(abs(mode))
            held, teeth, slope = regime_of(key[1])
            found = self._integrals.get(key) or integrate(body, key[0], held=held, teeth=teeth, slope=slope)
            if key[0] in (1.0, self.knob.wall.split, 1.0 - self.knob.wall.split):
                self._integrals[key] = found
            zeta = starts[i]
            mean = float(found.mean @ zeta)
            square = float(zeta @ found.square @ zeta) - 2.0 * reference * mean + reference * reference * key[0]
            total += (mean - reference * key[0], square, zeta @ found.loss @ zeta, zeta @ found.power @ zeta)
            if teeth == APART:
                total[2] += relaxed(body, float(chart.states[i, 2]), float(chart.states[i + 1, 2]))
        return Totals(*(float(value) for value in total))


class LawMeasurer(GeneralMeasurer):
    """As `GeneralMeasurer`, under a controller; what a late edge gives out is known of the plain wall alone."""

    def _leak(self, x: Array, commands: Array) -> Leak:
        del x, commands
        return Leak(nan, nan, nan)


def _quadrature(start: Array, spans: Array, alpha: float, beta: float) -> Array:
    """Integrals of x, x² and v² (3, m) over short pieces of lengths ``spans`` (m,) from (x, v, drive), (3, m)."""
    total = np.zeros((3, len(spans)))
    nodes, weights = np.array(RULE).T[:, :, None]
    for first in range(0, len(spans), BLOCK):
        some = slice(first, first + BLOCK)
        x, v, drive = start[:, some]
        y = drive - beta * x
        s, g, f = _short_coefficients(alpha, beta, 0.5 * spans[some] * (nodes + 1.0))
        at, pace, part = x + (s * v + g * y), f * v + s * y, 0.5 * spans[some] * weights
        for node in np.stack([part * at, part * at * at, part * pace * pace], axis=1):
            total[:, some] += node
    return total


def _short_coefficients(alpha: float, beta: float, t: Array) -> tuple[Array, Array, Array]:
    """(S, G, F) over times ``t`` (any shape) up to `SHORT` of the fastest mode; see `propagator.hold_coefficients`."""
    a, c = alpha * t, beta * t * t
    before, term = np.zeros_like(t), np.full_like(t, 0.5)
    g, s = term.copy(), np.ones_like(t)
    for n in range(2, 2 + _terms(float(a.max(initial=0.0)), float(c.max(initial=0.0)))):
        before *= c
        before += a * n * term
        before *= -1.0 / ((n + 1) * n)
        before, term = term, before
        g += term
        s += (n + 1) * term
    return s * t, g * t * t, 1.0 - c * g - a * s


def _terms(a: float, c: float) -> int:
    """Terms of the series of `_short_coefficients` until none is left that changes a digit, for up to these numbers."""
    before, term, n = 0.0, 0.5, 2
    while term + before > NEGLIGIBLE:
        before, term = term, (a * n * term + c * before) / ((n + 1) * n)
        n += 1
    return n - 2
