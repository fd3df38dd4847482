"""The measures of one attractor of the plain loop or under a controller, in SI units, and the harmonics of any orbit.

In the plain loop the drive is constant over each hold and the plant is a filter of second order: the drive's harmonics,
by one Fourier transform of its values, times the plant's frequency response.
"""

from collections.abc import Sequence
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.attractors import Attractor, Engine
from hknob_cli.engine.loop import Loop
from hknob_cli.engine.orbit_cycle import CycleMeasures
from hknob_cli.engine.outcome import Outcome
from hknob_cli.scene.plain_knob import SampledKnob

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MOST_HARMONICS = 200_000  # of an orbit


class Harmonics(NamedTuple):
    """The motion is the mean plus Re Σ A exp(2πi f t), t from the orbit's first sample.

    ``frequency_hz`` (n,): whole multiples of the period's; ``angle_rad`` (n,): complex amplitudes A, peak. Of a very
    long period the highest that were asked for may be missing.
    """

    frequency_hz: Array
    angle_rad: Complex

    def reach(self, hertz: float) -> bool:
        """Whether none up to a frequency are missing."""
        return len(self.frequency_hz) > 0 and bool(self.frequency_hz[-1] + self.frequency_hz[0] > hertz)

    @property
    def speed_rad_s(self) -> Array:
        """Peak speed of each harmonic, rad/s."""
        speed: Array = 2.0 * np.pi * self.frequency_hz * np.abs(self.angle_rad)
        return speed


def harmonic_count(period_samples: int, *, sample_period_s: float, highest_hz: float) -> int:
    """Number of harmonics of a period up to and with ``highest_hz``, at most `MOST_HARMONICS`."""
    return min(MOST_HARMONICS, int(highest_hz * period_samples * sample_period_s * (1.0 + 1e-12)))


def scaled(amplitudes: Complex, period_samples: int, *, sample_period_s: float, quantum_rad: float) -> Harmonics:
    """Harmonics in SI units of amplitudes in counts."""
    frequency = np.arange(1, len(amplitudes) + 1) / (period_samples * sample_period_s)
    return Harmonics(frequency, quantum_rad * amplitudes)


def of_holds(loop: Loop, older: Array, newer: Array, count: int) -> Complex:
    """Amplitudes (count,), in counts, of the period whose drives are these (n each, see `engine.orbit_holds.trace`)."""
    if loop.split > 0.0:
        return of_parts(loop, [(newer, loop.split, 1.0), (older, 0.0, loop.split)], count)
    return of_parts(loop, [(newer, 0.0, 1.0)], count)


def of_parts(loop: Loop, parts: Sequence[tuple[Array, float, float]], count: int) -> Complex:
    """Amplitudes (count,), in counts, of a period of n samples, whose drive is constant in every part of an interval.

    ``parts``: drives (n,) in counts per sample period squared, and from where to where in each interval they act.
    """
    n = len(parts[0][0])
    k = np.arange(1, count + 1)
    w: Array = np.asarray(2.0 * np.pi / n * k, dtype=np.float64)
    middle = parts[0][0].mean()  # a constant drive has no harmonics, and would only cost digits
    drive: Complex = np.zeros(count, dtype=np.complex128)
    for values, start, end in parts:
        drive = drive + np.fft.fft(values - middle)[k % n] * _hold(w, start, end)
    found: Complex = 2.0 / n * drive / (loop.beta - w * w + 1j * loop.alpha * w)
    return found


def _hold(w: Array, start: float, end: float) -> Complex:
    """Integral of exp(-iwt) over a part of an interval."""
    found: Complex = (end - start) * np.exp(-0.5j * w * (start + end)) * np.sinc(w * (end - start) / (2.0 * np.pi))
    return found


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
