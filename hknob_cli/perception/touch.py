"""What a hand feels of a knob: vibration of the skin at the rim, and torque steps, against published thresholds.

Vibration is a displacement of the skin. The torque step is what is felt as a count is crossed inside the wall, K·Δθ.
"""

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hknob_cli.errors import UsageError
from hknob_cli.perception.level import (
    Array,
    Verdict,
    as_published,
    combine,
    decibels,
    published,
    refuse_outside,
    threshold_set,
    to_peak,
)

# Where thresholds are extrapolated to: vibration is felt up to about 1 kHz (Tan et al. 1994, sec. 2).
FELT_HZ = (1.0, 1000.0)


class Thresholds(NamedTuple):
    """A published set: ``points`` (n, 2) of frequency (Hz) and peak displacement (m), its range, and its source."""

    name: str
    points: Array
    low_hz: float
    high_hz: float
    source: str


def thresholds(name: str | None = None) -> Thresholds:
    """A set by its name in ``touch.yaml``, the default where None. Raises `UsageError` if there is none."""
    found = threshold_set("touch", name)
    low, high = found["range_hz"]
    points = np.array(found["points"], dtype=np.float64)
    return Thresholds(name or str(published("touch")["default"]), points, float(low), float(high), found["source"])


def skin_displacement(angle_rad: ArrayLike, *, knob_radius_m: float) -> Array:
    """Displacement of the skin along the rim, m, of any convention: the angle's times the radius of the knob."""
    return np.asarray(angle_rad, dtype=np.float64) * knob_radius_m


def in_range(frequency_hz: ArrayLike, *, name: str | None = None) -> NDArray[np.bool_]:
    """Whether frequencies are where the set was published."""
    found, frequency = thresholds(name), np.asarray(frequency_hz, dtype=np.float64)
    inside: NDArray[np.bool_] = (frequency >= found.low_hz) & (frequency <= found.high_hz)
    return inside


def detection_threshold(frequency_hz: ArrayLike, *, name: str | None = None, extrapolate: bool = False) -> Array:
    """Least displacement detected, m, peak, at any shape of frequencies (Hz).

    Level over the logarithm of frequency is linear between the published points and, where ``extrapolate``, beyond
    them, from 1 Hz to 1 kHz; there it is a guess: above about 300 Hz thresholds rise again, which no set here has.
    Raises `UsageError` outside the range.
    """
    found, frequency = thresholds(name), np.asarray(frequency_hz, dtype=np.float64)
    if not extrapolate:
        why = as_published(found.source)
        refuse_outside(frequency, found.low_hz, found.high_hz, what="a frequency of", unit="Hz", why=why)
    else:
        refuse_outside(frequency, *FELT_HZ, what="a frequency of", unit="Hz", why="where vibration can be felt")
    at, level = np.log(found.points[:, 0]), np.log(found.points[:, 1])
    where = np.log(frequency)
    inner = np.interp(where, at, level)
    first = (level[1] - level[0]) / (at[1] - at[0])
    last = (level[-1] - level[-2]) / (at[-1] - at[-2])
    beyond = np.minimum(where - at[0], 0.0) * first + np.maximum(where - at[-1], 0.0) * last
    least: Array = np.exp(inner + beyond)
    return least


def sensation_level(
    frequency_hz: ArrayLike,
    displacement_m: ArrayLike,
    *,
    name: str | None = None,
    convention: str = "peak",
    extrapolate: bool = False,
) -> Array:
    """Level above the detection threshold, dB: 20 log10 of displacement over threshold; -inf where nothing moves.

    Frequencies (Hz) and displacements (m, by ``convention`` peak, rms or peak_to_peak) broadcast; each pair is a
    sinusoid. Raises `UsageError` outside the range of the set, unless ``extrapolate``.
    """
    least = detection_threshold(frequency_hz, name=name, extrapolate=extrapolate)
    return decibels(to_peak(displacement_m, convention) / least)


def judge(
    frequency_hz: ArrayLike,
    displacement_m: ArrayLike,
    *,
    name: str | None = None,
    convention: str = "peak",
    how: str = "most_effective",
    extrapolate: bool = False,
) -> Verdict:
    """Level of motions that are sums of sinusoids: frequencies (n,), displacements (..., n).

    Parts outside the range of the set are left out, unless ``extrapolate``: the level is then that of the others, and
    NaN where there are none. ``how``: see `level.combine`.
    """
    frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))
    displacement = to_peak(displacement_m, convention)
    some = in_range(frequency, name=name)
    if extrapolate:
        some = (frequency >= FELT_HZ[0]) & (frequency <= FELT_HZ[1])
    levels = sensation_level(frequency[some], displacement[..., some], name=name, extrapolate=extrapolate)
    return combine(frequency[some], levels, how=how)


def torque_step(stiffness_nm_per_rad: ArrayLike, counts_per_rev: ArrayLike) -> Array:
    """Height of the step, N·m: wall stiffness (N·m/rad) times the angle of a count; they broadcast."""
    counts = np.asarray(counts_per_rev, dtype=np.float64)
    stiffness = np.asarray(stiffness_nm_per_rad, dtype=np.float64)
    if (counts <= 0.0).any() or (stiffness < 0.0).any():
        raise UsageError("counts per revolution must be above 0, and the wall's stiffness not below 0")
    step: Array = stiffness * 2.0 * pi / counts
    return step


def step_in_range(counts_per_rev: ArrayLike, *, name: str | None = None) -> NDArray[np.bool_]:
    """Whether steps that far apart are within the spatial periods of the experiment."""
    low, high = threshold_set("torque", name)["period_deg"]
    period = 360.0 / np.asarray(counts_per_rev, dtype=np.float64)
    inside: NDArray[np.bool_] = (period >= low) & (period <= high)
    return inside


def step_level(
    torque_nm: ArrayLike, counts_per_rev: ArrayLike, *, name: str | None = None, extrapolate: bool = False
) -> Array:
    """Level of torque steps, dB: 20 log10 of the step over the least torque variation that was detected.

    The experiment varied the torque as a sinusoid over the angle, on top of a constant one; a staircase whose steps are
    as far apart as its periods is taken to be as noticeable as the sinusoid whose torque variation is the step. The
    threshold is the least over all periods, so that for the other periods the level is an upper bound. Steps (N·m)
    and counts broadcast. Raises `UsageError` where a count is not within the periods of the experiment, unless
    ``extrapolate``.
    """
    found = threshold_set("torque", name)
    counts, torque = np.asarray(counts_per_rev, dtype=np.float64), np.asarray(torque_nm, dtype=np.float64)
    if (torque < 0.0).any():
        raise UsageError("a torque step must not be below 0")
    if not extrapolate:
        low, high = found["period_deg"]
        why = as_published(found["source"])
        refuse_outside(360.0 / counts, low, high, what="a count of", unit="degrees", why=why)
    return decibels(torque / found["torque_nm"] + 0.0 * counts)
