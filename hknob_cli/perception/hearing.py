"""How loud pure tones are, by ISO 226, and what steady noise makes of the threshold, by ISO/PAS 20065:2016.

ISO 226 has parameters at 29 frequencies and says nothing of those between; here the three parameters are linear
over the logarithm of frequency.

The noise in the critical band about a tone masks it up to a level that is known: the band's level less 2 dB at low
frequencies, less 6 dB at the highest (Formulae 2, 4, 5, 12 and 13, which are those of DIN 45681:2005). At that level
half of the persons of normal hearing hear the tone. ISO/PAS 20065 is for tones of 50 Hz and more, and was not validated
below. It was read in programs: github.com/jmrplens/phonometry, whose tests have its Annex E and DIN 45681's tables.
"""

from collections.abc import Sequence
from math import log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hknob_cli.errors import UsageError
from hknob_cli.perception.level import Array, Verdict, columns, combine, decibels, published, refuse_outside
from hknob_cli.specs.perception import Background

REFERENCE_PA = 20e-6  # of sound pressure levels
_SQUARE = 4e-10  # of the reference pressure, as the formulae write it


class Parameters(NamedTuple):
    """Exponent, transfer magnitude L_U (dB) and threshold T_f (dB) at given frequencies."""

    alpha: Array
    transfer_db: Array
    threshold_db: Array


def parameters(frequency_hz: ArrayLike, *, edition: int | None = None) -> Parameters:
    """Parameters of an edition (2003, 2023; by default the later), at any shape of frequencies (Hz).

    Raises `UsageError` outside 20 Hz to 12.5 kHz, where the standard has nothing, and for another edition.
    """
    data = published("hearing")
    edition = edition or data["default"]
    if edition not in data["editions"]:
        raise UsageError(f"no edition {edition} of ISO 226; there are: {', '.join(map(str, data['editions']))}")
    table = columns(data["editions"][edition]["file"])
    low, high = data["range_hz"]
    frequency = np.asarray(frequency_hz, dtype=np.float64)
    refuse_outside(frequency, low, high, what="a frequency of", unit="Hz", why="which ISO 226 is for")
    at, where = np.log(table["frequency_hz"]), np.log(frequency)
    return Parameters(*(np.interp(where, at, table[name]) for name in Parameters._fields))


def in_range(frequency_hz: ArrayLike) -> NDArray[np.bool_]:
    """Whether frequencies are within those of the standard."""
    low, high = published("hearing")["range_hz"]
    frequency = np.asarray(frequency_hz, dtype=np.float64)
    inside: NDArray[np.bool_] = (frequency >= low) & (frequency <= high)
    return inside


def is_specified(frequency_hz: ArrayLike, phon: ArrayLike) -> NDArray[np.bool_]:
    """Whether tones are within the loudness levels that the standard is for; they broadcast, NaN is not."""
    frequency, loudness = np.asarray(frequency_hz, dtype=np.float64), np.asarray(phon, dtype=np.float64)
    low, high = _least_and_most(frequency)
    # A level that the formula gives for exactly 20 or 90 phon is within, whatever it is rounded to.
    inside: NDArray[np.bool_] = np.asarray((loudness >= low - 1e-9) & (loudness <= high + 1e-9))
    return inside


def hearing_threshold(frequency_hz: ArrayLike, *, edition: int | None = None) -> Array:
    """Threshold of hearing, dB re 20 µPa. Raises `UsageError` as `parameters`."""
    return parameters(frequency_hz, edition=edition).threshold_db


def sound_pressure_level(
    frequency_hz: ArrayLike, phon: ArrayLike, *, edition: int | None = None, extrapolate: bool = False
) -> Array:
    """Level of pure tones (dB re 20 µPa) of given loudness levels (phon): ISO 226, Formula (1). They broadcast.

    Raises `UsageError` outside 20 to 90 phon (80 above 4 kHz), unless ``extrapolate``; the standard calls what is
    beyond informative.
    """
    frequency, loudness = np.broadcast_arrays(
        np.asarray(frequency_hz, dtype=np.float64), np.asarray(phon, dtype=np.float64)
    )
    p = parameters(frequency, edition=edition)
    if not extrapolate:
        _refuse_loudness(frequency, loudness)
    alpha, lift, threshold = p
    if (edition or published("hearing")["default"]) == 2003:
        a = 4.47e-3 * (10.0 ** (0.025 * loudness) - 1.15) + (0.4 * 10.0 ** ((threshold + lift) / 10.0 - 9.0)) ** alpha
        return _levels(10.0 / alpha * _log10(a) - lift + 94.0)
    a = _SQUARE ** (0.3 - alpha) * (10.0 ** (0.03 * loudness) - 10.0**0.072) + 10.0 ** (
        alpha * (threshold + lift) / 10.0
    )
    return _levels(10.0 / alpha * _log10(a) - lift)


def loudness_level(
    frequency_hz: ArrayLike, spl_db: ArrayLike, *, edition: int | None = None, extrapolate: bool = False
) -> Array:
    """Loudness level (phon) of pure tones by their level (dB re 20 µPa): the inverse of `sound_pressure_level`.

    They broadcast; NaN below the threshold of hearing, where nothing is heard. Raises `UsageError` outside 20 to 90
    phon (80 above 4 kHz), inaudible tones too, unless ``extrapolate``.
    """
    frequency, level = np.broadcast_arrays(
        np.asarray(frequency_hz, dtype=np.float64), np.asarray(spl_db, dtype=np.float64)
    )
    alpha, lift, threshold = parameters(frequency, edition=edition)
    shown = np.where(level >= threshold, level, np.nan)
    if (edition or published("hearing")["default"]) == 2003:
        # Formula (1) solved for the loudness; the standard prints an inverse that is off by up to 0.04 phon.
        power = 10.0 ** (alpha * (shown + lift - 94.0) / 10.0)
        quiet = (0.4 * 10.0 ** ((threshold + lift) / 10.0 - 9.0)) ** alpha
        loudness = 40.0 * _log10((power - quiet) / 4.47e-3 + 1.15)
    else:
        power = 10.0 ** (alpha * (shown + lift) / 10.0) - 10.0 ** (alpha * (threshold + lift) / 10.0)
        loudness = 100.0 / 3.0 * _log10(power / _SQUARE ** (0.3 - alpha) + 10.0**0.072)
    if not extrapolate:
        _refuse_loudness(frequency, loudness)
    return _levels(loudness)


def sensation_level(frequency_hz: ArrayLike, spl_db: ArrayLike, *, edition: int | None = None) -> Array:
    """Level of pure tones above the threshold of hearing, dB; below 0 they are not heard. They broadcast."""
    return np.asarray(spl_db, dtype=np.float64) - hearing_threshold(frequency_hz, edition=edition)


def heard_level(speed_rad_s: ArrayLike, *, gain_pa_s_per_rad: ArrayLike) -> Array:
    """Sound pressure level (dB re 20 µPa) of sinusoids by their peak speed (rad/s) and the device's gain.

    The gain is sound pressure per speed of the knob, Pa/(rad/s), both of the same convention; it belongs to the device,
    to where the ear is, and to how the device is mounted, so that only who has measured it can give it. It may be of
    each sinusoid (`response`); they broadcast, and where it is NaN so is the level.
    """
    gain = np.asarray(gain_pa_s_per_rad, dtype=np.float64)
    if (gain <= 0.0).any():
        raise UsageError(f"the sound gain must be above 0, got {gain.min():g}")
    return decibels(np.asarray(speed_rad_s, dtype=np.float64) * (gain / (sqrt(2.0) * REFERENCE_PA)))


def response(frequency_hz: ArrayLike, points: Sequence[tuple[float, float]], *, extrapolate: bool = False) -> Array:
    """A device's gain at frequencies (Hz): through ``points`` of frequency and gain, both logarithmic between them.

    NaN below the first and above the last; with ``extrapolate`` the gain of the nearest point.
    """
    at, gain = np.log(np.array(points, dtype=np.float64)).T
    frequency = np.asarray(frequency_hz, dtype=np.float64)
    with np.errstate(divide="ignore"):
        where = np.log(frequency)
    beyond = None if extrapolate else np.nan
    found: Array = np.exp(np.interp(where, at, gain, left=beyond, right=beyond))
    return found


def judge(
    frequency_hz: ArrayLike, spl_db: ArrayLike, *, edition: int | None = None, masked_db: ArrayLike | None = None
) -> Verdict:
    """Level above threshold of sums of tones, frequencies (n,) and levels (..., n): that of the most audible one.

    ``masked_db`` (n,): threshold in noise, which holds where it is the higher one; a tone whose is NaN is left out.
    Tones outside 20 Hz to 12.5 kHz are left out; NaN where there are no others. What tones do together, masking each
    other and the loudness of several, ISO 226 does not say.
    """
    frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))
    some = in_range(frequency)
    levels = np.asarray(spl_db, dtype=np.float64)[..., some]
    above = sensation_level(frequency[some], levels, edition=edition)
    if masked_db is not None:
        above = np.minimum(above, levels - np.asarray(masked_db, dtype=np.float64)[some])
    return combine(frequency[some], above)


def _refuse_loudness(frequency: Array, phon: Array) -> None:
    outside = ~is_specified(frequency, phon)
    if outside.any():
        at = np.unravel_index(int(np.argmax(outside)), outside.shape)
        given = "below threshold" if np.isnan(phon[at]) else f"{phon[at]:.4g} phon"
        low, high = _least_and_most(frequency[at])
        raise UsageError(
            f"a tone of {frequency[at]:g} Hz at {given} is outside {low:g} to {high:g} phon, "
            f"which ISO 226 is for; ask for extrapolation to go on"
        )


def _least_and_most(frequency: Array) -> tuple[float, Array]:
    """Loudness levels between which the standard is for tones, phon."""
    data = published("hearing")
    (low, high), above = data["range_phon"], data["above"]
    return float(low), np.where(frequency > above["hz"], float(above["phon"]), float(high))


def _log10(values: Array) -> Array:
    """Logarithm; NaN where there is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        found: Array = np.log10(values)
    return found


def _levels(values: Array) -> Array:
    return np.asarray(values, dtype=np.float64)


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
