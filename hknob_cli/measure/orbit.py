"""The measures of one attractor, in SI units: what a row of ``orbits.parquet`` says."""

from math import nan
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.attractors import Attractor, Engine
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.energy import damping_loss, wall_work
from hknob_cli.measure.extrema import find_extrema
from hknob_cli.measure.harmonics import Harmonics, harmonic_count, of_holds, scaled
from hknob_cli.measure.leak import split_leak
from hknob_cli.measure.moments import Forms, find_moments, hold_forms
from hknob_cli.measure.period import split_holds
from hknob_cli.scene.sampled_knob import SampledKnob


class OrbitMeasures(NamedTuple):
    """Peak-to-peak is peak minus trough, not half of it. NaN where the outcome has no orbit."""

    cycles: int = 0
    p2p_rad: float = nan
    min_rad: float = nan
    max_rad: float = nan
    rms_rad: float = nan
    frequency_hz: float = nan
    wall_work_j: float = nan
    damping_loss_j: float = nan
    friction_loss_j: float = nan
    late_entry_j: float = nan
    late_exit_j: float = nan
    staircase_j: float = nan


def at_rest(least_rad: float, most_rad: float) -> OrbitMeasures:
    """Measures of a rest point, or of the range in which friction holds trials."""
    return OrbitMeasures(
        p2p_rad=0.0,
        min_rad=least_rad,
        max_rad=most_rad,
        rms_rad=0.0,
        frequency_hz=0.0,
        wall_work_j=0.0,
        damping_loss_j=0.0,
        friction_loss_j=0.0,
        late_entry_j=0.0,
        late_exit_j=0.0,
        staircase_j=0.0,
    )


class Measurer:
    """Measures the attractors of one cell; integrals over a hold are computed once, and only if there is a cycle."""

    def __init__(self, knob: SampledKnob, engine: Engine) -> None:
        self.knob = knob
        self.engine = engine
        self._forms: dict[float, Forms] = {}

    def harmonics(self, attractor: Attractor, highest_hz: float) -> Harmonics:
        """Harmonics of a cycle up to ``highest_hz``."""
        loop, period_s = self.knob.loop, self.knob.period_s
        count = harmonic_count(attractor.period, sample_period_s=period_s, highest_hz=highest_hz)
        _, _, older, newer = self.engine.trace(loop, attractor)
        amplitudes = of_holds(loop, older, newer, count)
        return scaled(amplitudes, attractor.period, sample_period_s=period_s, quantum_rad=self.knob.quantum_rad)

    def measure(self, attractor: Attractor) -> OrbitMeasures:
        """Measures of ``attractor``."""
        if attractor.outcome is Outcome.REST:
            theta = self.knob.angle_rad(attractor.x)
            return at_rest(theta, theta)
        if attractor.outcome is not Outcome.CYCLE:
            return OrbitMeasures()
        knob, loop = self.knob, self.knob.loop
        period = split_holds(loop, *self.engine.trace(loop, attractor))
        for kind in period.kinds:
            if kind not in self._forms:
                self._forms[kind] = hold_forms(loop.alpha, loop.beta, kind)
        extrema = find_extrema(period)
        moments = find_moments(period, {kind: self._forms[kind] for kind in period.kinds}, extrema.reference)
        cycles = len(extrema.maxima)
        leak = split_leak(
            period.x,
            period.drive + loop.gamma,
            edge=0.0 if loop.sense > 0.0 else -1.0,
            kappa=loop.kappa,
            offset=loop.offset,
        )
        quantum = knob.quantum_rad
        return OrbitMeasures(
            cycles=cycles,
            p2p_rad=float(np.mean(extrema.maxima) - np.mean(extrema.minima)) * quantum,
            min_rad=knob.angle_rad(extrema.reference + float(extrema.minima.min())),
            max_rad=knob.angle_rad(extrema.reference + float(extrema.maxima.max())),
            rms_rad=moments.rms * quantum,
            frequency_hz=cycles / (period.samples * knob.period_s),
            wall_work_j=wall_work(period) * knob.energy_j,
            damping_loss_j=damping_loss(period, moments) * knob.energy_j,
            late_entry_j=leak.entry * knob.energy_j,
            late_exit_j=leak.exit * knob.energy_j,
            staircase_j=leak.staircase * knob.energy_j,
        )
