"""The measures of what a trial under a controller settles to."""

from collections.abc import Sequence
from math import nan

import numpy as np

from hknob_cli.engine.loop import Loop
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.measure.energy import damping_loss, wall_work
from hknob_cli.measure.extrema import find_extrema
from hknob_cli.measure.harmonics import Harmonics, harmonic_count, of_parts, scaled
from hknob_cli.measure.moments import find_moments, hold_forms
from hknob_cli.measure.orbit import OrbitMeasures, at_rest
from hknob_cli.measure.period import Period
from hknob_cli.remedies.search import Settled
from hknob_cli.scene.sampled_knob import SampledKnob


def measure_settled(knob: SampledKnob, parts: Sequence[float], settled: Settled) -> OrbitMeasures:
    """Measures of an orbit, of rest, or of the window of a motion that does not repeat.

    ``parts``: lengths of the parts of a sample interval, of at most two kinds.
    """
    if settled.outcome is Outcome.REST:
        theta = knob.angle_rad(float(settled.x[0]))
        return at_rest(theta, theta)
    if len(settled.drive) == 0:
        return OrbitMeasures()
    period = _period(knob.loop, parts, settled)
    extrema = find_extrema(period)
    cycles = len(extrema.maxima)
    if cycles == 0 or len(extrema.minima) == 0:
        return OrbitMeasures()
    forms = {kind: hold_forms(knob.loop.alpha, knob.loop.beta, kind) for kind in period.kinds}
    moments = find_moments(period, forms, extrema.reference)
    quantum, repeats = knob.quantum_rad, settled.outcome is Outcome.CYCLE
    return OrbitMeasures(
        cycles=cycles if repeats else 0,
        p2p_rad=float(np.mean(extrema.maxima) - np.mean(extrema.minima)) * quantum,
        min_rad=knob.angle_rad(extrema.reference + float(extrema.minima.min())),
        max_rad=knob.angle_rad(extrema.reference + float(extrema.maxima.max())),
        rms_rad=moments.rms * quantum,
        frequency_hz=cycles / (period.samples * knob.period_s),
        wall_work_j=wall_work(period) * knob.energy_j if repeats else nan,
        damping_loss_j=damping_loss(period, moments) * knob.energy_j if repeats else nan,
    )


def settled_harmonics(knob: SampledKnob, parts: Sequence[float], settled: Settled, highest_hz: float) -> Harmonics:
    """Harmonics of an orbit up to ``highest_hz``, exact; ``parts`` as in `measure_settled`."""
    samples = len(settled.drive) // len(parts)
    count = harmonic_count(samples, sample_period_s=knob.period_s, highest_hz=highest_hz)
    drive = settled.drive.reshape(samples, len(parts))
    ends = np.cumsum(parts)
    held = [(drive[:, i], float(ends[i] - part), float(ends[i])) for i, part in enumerate(parts)]
    amplitudes = of_parts(knob.loop, held, count)
    return scaled(amplitudes, samples, sample_period_s=knob.period_s, quantum_rad=knob.quantum_rad)


def _period(plant: Loop, parts: Sequence[float], settled: Settled) -> Period:
    samples = len(settled.drive) // len(parts)
    first, last = parts[0], parts[-1]
    loop = plant._replace(
        split=first if first != last else 0.0,
        **dict(zip(("s1", "g1", "f1"), hold_coefficients(plant.alpha, plant.beta, first), strict=True)),
        **dict(zip(("s2", "g2", "f2"), hold_coefficients(plant.alpha, plant.beta, last), strict=True)),
    )
    return Period(
        loop=loop,
        samples=samples,
        x=settled.x,
        v=settled.v,
        drive=settled.drive,
        duration=np.tile(np.asarray(parts), samples),
        kinds=tuple(dict.fromkeys(parts)),
    )
