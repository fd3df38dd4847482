"""What steady noise makes of the threshold of hearing: tones in a critical band, by ISO/PAS 20065:2016.

The noise in the critical band about a tone masks it up to a level that is known: the band's level less 2 dB at low
frequencies, less 6 dB at the highest (Formulae 2, 4, 5, 12 and 13, which are those of DIN 45681:2005). At that level
half of the persons of normal hearing hear the tone. The standard is for tones of 50 Hz and more, and was not validated
below. It was read in programs: github.com/jmrplens/phonometry, whose tests have its Annex E and DIN 45681's tables.
"""

from math import log

import numpy as np
from numpy.typing import ArrayLike

from hknob_cli.perception.level import Array
from hknob_cli.specs.perception import Background

LEAST_HZ = 50.0
NOISE_HZ = (20.0, 20e3)  # between which the level of a background is


def critical_bandwidth(frequency_hz: ArrayLike) -> Array:
    """Width (Hz) of the critical band about tones: ISO/PAS 20065, Formula (2), after Zwicker & Terhardt (1980)."""
    khz = np.asarray(frequency_hz, dtype=np.float64) / 1000.0
    found: Array = 25.0 + 75.0 * (1.0 + 1.4 * khz * khz) ** 0.69
    return found


def critical_band(frequency_hz: ArrayLike) -> tuple[Array, Array]:
    """Lower and upper edge (Hz) of that band, with the tone at their geometric mean: Formulae (4) and (5)."""
    frequency, width = np.asarray(frequency_hz, dtype=np.float64), critical_bandwidth(frequency_hz)
    low: Array = 0.5 * (np.sqrt(width * width + 4.0 * frequency * frequency) - width)
    return low, low + width


def masking_index(frequency_hz: ArrayLike) -> Array:
    """Level (dB) of a tone that is just heard over that of the noise in its critical band: Formula (13)."""
    found: Array = -2.0 - np.log10(1.0 + (np.asarray(frequency_hz, dtype=np.float64) / 502.0) ** 2.5)
    return found


def band_level(frequency_hz: ArrayLike, background: Background) -> Array:
    """Level (dB re 20 µPa) of a background in the critical bands about tones.

    ``white``: equal power per Hz, ``pink``: per octave, from 20 Hz to 20 kHz; what of a band lies outside is silent.
    """
    least, most = NOISE_HZ
    low, high = (np.clip(edge, least, most) for edge in critical_band(frequency_hz))
    white = background.spectrum == "white"
    share = (high - low) / (most - least) if white else np.log(high / low) / log(most / least)
    with np.errstate(divide="ignore"):
        found: Array = background.level_db + 10.0 * np.log10(share)
    return found


def masked_threshold(frequency_hz: ArrayLike, background: Background, *, extrapolate: bool = False) -> Array:
    """Level (dB re 20 µPa) from which tones are heard in a background, however quiet they are in silence.

    NaN below 50 Hz, unless ``extrapolate``.
    """
    frequency = np.asarray(frequency_hz, dtype=np.float64)
    found: Array = band_level(frequency, background) + masking_index(frequency)
    return found if extrapolate else np.where(frequency >= LEAST_HZ, found, np.nan)
