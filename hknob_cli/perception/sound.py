"""A cycle's motion as a clip to listen to: its harmonics below half the clip's sample rate, faded in and out.

What sounds is the knob's speed or acceleration, not the sound of a device, whose own gain over frequency is unknown
here; pitch and timbre of the motion are right, loudness is not. The factor from motion to sample is said, and may be
fixed, so that clips can be compared.
"""

import io
import wave
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hknob_cli.errors import UsageError
from hknob_cli.perception.level import Array

RATE_HZ = 44100
FADE_S = 0.02
HEADROOM = 0.5  # of full scale, the peak of a clip that is normalised by itself
FULL_SCALE = 32767
QUANTITIES = {"speed": ("rad/s", 1), "acceleration": ("rad/s^2", 2)}
_BLOCK = 1 << 20  # numbers worked on at once


class Clip(NamedTuple):
    """Samples of full scale 1 at ``rate_hz``; ``factor``: samples per rad/s or rad/s², which ``unit`` says."""

    samples: Array
    rate_hz: int
    factor: float
    unit: str


def clip(
    frequency_hz: ArrayLike,
    angle_rad: ArrayLike,
    *,
    quantity: str = "speed",
    duration_s: float = 2.0,
    rate_hz: int = RATE_HZ,
    factor: float | None = None,
) -> Clip:
    """Clip of a motion θ(t) = Re Σ A exp(2πi f t): frequencies f (n,) in Hz, complex amplitudes A (n,) in rad, peak.

    ``quantity``: speed or acceleration; ``factor``: samples per unit of it, by default what brings the largest sample
    to half of full scale. Parts at 0 and from half of ``rate_hz`` on are left out. The same input gives the same
    samples. Raises `UsageError` for a motion without another part, a clip of no length or above ten minutes, and a
    factor that leads beyond full scale.
    """
    if quantity not in QUANTITIES:
        raise UsageError(f"no quantity '{quantity}'; there are: {', '.join(QUANTITIES)}")
    if not 0.0 < duration_s <= 600.0:
        raise UsageError(f"a clip lasts between 0 and 600 s, not {duration_s:g} s")
    unit, order = QUANTITIES[quantity]
    frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))
    amplitude = np.atleast_1d(np.asarray(angle_rad, dtype=np.complex128))
    below = (frequency > 0.0) & (frequency < 0.5 * rate_hz) & (amplitude != 0.0)
    if not below.any():
        raise UsageError(f"the motion has no part between 0 and {0.5 * rate_hz:g} Hz, so there is nothing to hear")
    turn = 2j * np.pi * frequency[below]
    wanted = _synthesise(turn, amplitude[below] * turn**order, round(duration_s * rate_hz), rate_hz)
    fade = max(1, min(round(FADE_S * rate_hz), len(wanted) // 2))
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(fade) / fade)
    wanted[:fade] *= ramp
    wanted[len(wanted) - fade :] *= ramp[::-1]
    largest = float(np.abs(wanted).max(initial=0.0))
    if factor is None:
        factor = HEADROOM / largest if largest > 0.0 else 1.0
    if factor * largest > 1.0:
        raise UsageError(f"a factor of {factor:g} clips: the largest {quantity} is {largest:g} {unit}")
    return Clip(factor * wanted, rate_hz, factor, unit)


def wav_bytes(sound: Clip) -> bytes:
    """The clip as a WAV file, one channel of 16 bits, rounded to the nearest step; always the same bytes."""
    stream = io.BytesIO()
    with wave.open(stream, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(sound.rate_hz)
        out.writeframes(np.rint(FULL_SCALE * sound.samples).astype("<i2").tobytes())
    return stream.getvalue()


def _synthesise(turn: Array, amplitude: Array, count: int, rate_hz: int) -> Array:
    """Real part of the sum of the parts at ``count`` sample times."""
    found = np.zeros(count)
    block = max(1, _BLOCK // len(turn))
    for first in range(0, count, block):
        # Summed by numpy, not by a matrix product, whose last digit depends on the number of threads.
        times = np.arange(first, min(first + block, count)) / rate_hz
        found[first : first + len(times)] = (np.exp(np.outer(times, turn)) * amplitude).real.sum(axis=1)
    return found
