"""The measures of what a trial under a controller settles to."""

from collections.abc import Sequence
from math import fsum, nan

import numpy as np

from hknob_cli.controllers.search import Settled
from hknob_cli.engine.orbit.cycle import measure_holds
from hknob_cli.engine.orbit.holds import PART, fill_part
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.harmonics import Harmonics, harmonic_count, of_parts, scaled
from hknob_cli.measure.orbit import OrbitMeasures, at_rest
from hknob_cli.scene.sampled_knob import SampledKnob


def measure_settled(knob: SampledKnob, parts: Sequence[float], settled: Settled) -> OrbitMeasures:
    """Measures of an orbit, of rest, or of the window of a motion that does not repeat.

    ``parts``: lengths of the parts of a sample interval.
    """
    if settled.outcome is Outcome.REST:
        theta = knob.angle_rad(float(settled.x[0]))
        return at_rest(theta, theta)
    if len(settled.drive) == 0:
        return OrbitMeasures()
    loop, kinds = knob.loop, len(parts)
    numbers = [0.0] * (kinds * PART)
    for kind, length in enumerate(parts):
        fill_part(numbers, kind, loop.alpha, loop.beta, length)
    samples = len(settled.drive) // kinds
    x, v, drive = settled.x.tolist(), settled.v.tolist(), settled.drive.tolist()
    cycles, swing, lowest, highest, rms, work, loss = measure_holds(
        x, v, drive, samples, numbers, kinds, loop.alpha, loop.beta, fsum(x[:-1]), fsum(drive)
    )
    if cycles == 0:
        return OrbitMeasures()
    quantum, repeats = knob.quantum_rad, settled.outcome is Outcome.CYCLE
    return OrbitMeasures(
        cycles=cycles if repeats else 0,
        p2p_rad=swing * quantum,
        min_rad=knob.angle_rad(lowest),
        max_rad=knob.angle_rad(highest),
        rms_rad=rms * quantum,
        frequency_hz=cycles / (samples * knob.period_s),
        wall_work_j=work * knob.energy_j if repeats else nan,
        damping_loss_j=loss * knob.energy_j if repeats else nan,
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
