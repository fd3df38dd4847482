"""Levels in dB, the amplitudes they are told from, and how the parts of a motion add up to one."""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hknob_cli.errors import UsageError

Array = NDArray[np.float64]

# Peak amplitude of a sinusoid over what the convention names.
CONVENTIONS = {"peak": 1.0, "rms": sqrt(2.0), "peak_to_peak": 0.5}
COMBINATIONS = ("most_effective", "power_sum")


class Verdict(NamedTuple):
    """Level (dB) and which frequency (Hz) is the most effective; NaN both where there is nothing to judge."""

    level_db: Array
    frequency_hz: Array


def to_peak(amplitude: ArrayLike, convention: str) -> Array:
    """Peak amplitude (half of peak to peak) of sinusoids given as ``peak``, ``rms`` or ``peak_to_peak``.

    Raises `UsageError` for another convention and for amplitudes below 0.
    """
    if convention not in CONVENTIONS:
        raise UsageError(f"no amplitude '{convention}'; there are: {', '.join(CONVENTIONS)}")
    values = np.asarray(amplitude, dtype=np.float64)
    if (values < 0.0).any():
        raise UsageError("an amplitude must not be below 0")
    return CONVENTIONS[convention] * values


def decibels(ratio: ArrayLike) -> Array:
    """20 log10 of an amplitude ratio; -inf for 0."""
    with np.errstate(divide="ignore"):
        found: Array = 20.0 * np.log10(np.asarray(ratio, dtype=np.float64))
    return found


def combine(frequency_hz: ArrayLike, levels_db: ArrayLike, *, how: str = "most_effective") -> Verdict:
    """Level of a motion from those of its parts, along the last axis; NaN: a part that cannot be judged.

    ``most_effective``: the largest, as if each part were alone, which is all that thresholds of single sinusoids say.
    ``power_sum``: 10 log10 of the sum of 10^(L/10), for parts that one channel adds up. Raises `UsageError` for
    another ``how``.
    """
    if how not in COMBINATIONS:
        raise UsageError(f"no combination '{how}'; there are: {', '.join(COMBINATIONS)}")
    levels = np.atleast_1d(np.asarray(levels_db, dtype=np.float64))
    frequency = np.broadcast_to(np.asarray(frequency_hz, dtype=np.float64), levels.shape)
    known = np.isfinite(levels)
    shape = levels.shape[:-1]
    if levels.shape[-1] == 0:
        return Verdict(np.full(shape, np.nan), np.full(shape, np.nan))
    best = np.where(known, levels, -np.inf).argmax(axis=-1)[..., None]
    some = known.any(axis=-1)
    level = np.take_along_axis(levels, best, axis=-1)[..., 0]
    if how == "power_sum":
        # From the largest, so that no power overflows.
        rest = np.where(known, levels - np.where(some, level, 0.0)[..., None], -np.inf)
        level = level + 10.0 * np.log10(np.maximum((10.0 ** (0.1 * rest)).sum(axis=-1), 1e-300))
    which = np.take_along_axis(frequency, best, axis=-1)[..., 0]
    return Verdict(np.where(some, level, np.nan), np.where(some, which, np.nan))


def as_published(source: str) -> str:
    """The reason for a range that a source has."""
    return f"which is what is published ({source}); ask for extrapolation to go on"


def refuse_outside(values: Array, low: float, high: float, *, what: str, unit: str, why: str) -> None:
    """Raises `UsageError`, which ends in ``why``, where a value is outside a range, or is not a number."""
    outside = ~((values >= low) & (values <= high))
    if outside.any():
        given: Any = np.atleast_1d(values)[np.atleast_1d(outside)][0]
        raise UsageError(f"{what} {given:.6g} {unit} is outside {low:g} to {high:g} {unit}, {why}")
