"""The harmonics of a proven orbit: its motion as a sum of sinusoids, exact, not from samples.

In the plain loop the drive is constant over each hold and the plant is a filter of second order: the drive's harmonics,
by one Fourier transform of its values, times the plant's frequency response.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.loop import Loop

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
    """Amplitudes (count,), in counts, of the period whose drives are these (n each, see `engine.trace.trace`)."""
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
