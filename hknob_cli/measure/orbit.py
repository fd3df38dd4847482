"""The measures of one attractor of the plain loop or under a controller, in SI units: a row of ``orbits.parquet``."""

from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.engine.attractors import Attractor, Engine
from hknob_cli.engine.orbit.cycle import CycleMeasures
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.harmonics import Harmonics, harmonic_count, of_holds, scaled
from hknob_cli.scene.sampled_knob import SampledKnob

if TYPE_CHECKING:
    pass


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
    knob_p2p_rad: float = nan
    mesh_least_nm: float = nan
    mesh_most_nm: float = nan
    rattle_p2p_rad: float = nan
    parting_per_s: float = nan
    jitter_p2p_rad: float = nan
    jitter_range_rad: float = nan
    jitter_frequency_hz: float = nan


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
        knob_p2p_rad=0.0,
    )


def of_cycle(knob: SampledKnob, period: int, found: CycleMeasures) -> OrbitMeasures:
    """Measures of a cycle of ``period`` samples in SI; knob, period and measures may be arrays, one entry an orbit."""
    quantum, energy = knob.quantum_rad, knob.energy_j
    return OrbitMeasures(
        cycles=found.cycles,
        p2p_rad=found.swing * quantum,
        min_rad=knob.angle_rad(found.lowest),
        max_rad=knob.angle_rad(found.highest),
        rms_rad=found.rms * quantum,
        frequency_hz=found.cycles / (period * knob.period_s),
        wall_work_j=found.wall_work * energy,
        damping_loss_j=found.damping_loss * energy,
        late_entry_j=found.late_entry * energy,
        late_exit_j=found.late_exit * energy,
        staircase_j=found.staircase * energy,
    )


class Measurer:
    """Measures the attractors of one cell; integrals over a hold are computed once, and only if there is a cycle."""

    def __init__(self, knob: SampledKnob, engine: Engine) -> None:
        self.knob = knob
        self.engine = engine
        self._parts: Any = None

    def harmonics(self, attractor: Attractor, highest_hz: float) -> Harmonics:
        """Harmonics of a cycle up to ``highest_hz``."""
        loop, period_s = self.knob.loop, self.knob.period_s
        count = harmonic_count(attractor.period, sample_period_s=period_s, highest_hz=highest_hz)
        _, _, older, newer = self.engine.trace(loop, attractor)
        amplitudes = of_holds(loop, older, newer, count)
        return scaled(amplitudes, attractor.period, sample_period_s=period_s, quantum_rad=self.knob.quantum_rad)

    def measure(self, attractor: Attractor) -> OrbitMeasures:
        """Measures of ``attractor``; NaN also where nothing turns but by rounding."""
        if attractor.outcome is Outcome.REST:
            theta = self.knob.angle_rad(attractor.x)
            return at_rest(theta, theta)
        if attractor.outcome is not Outcome.CYCLE:
            return OrbitMeasures()
        if self._parts is None:
            self._parts = self.engine.hold_space()
        found = self.engine.measure(self.knob.loop, attractor, self._parts)
        return of_cycle(self.knob, attractor.period, found) if found.cycles else OrbitMeasures()
