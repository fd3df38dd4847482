"""The torque step that a hand feels as a count is crossed inside the wall, K·Δθ, against published detection."""

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hknob_cli.errors import UsageError
from hknob_cli.perception.level import Array, as_published, decibels, refuse_outside, threshold_set


def torque_step(stiffness_nm_per_rad: ArrayLike, counts_per_rev: ArrayLike) -> Array:
    """Height of the step, N·m: wall stiffness (N·m/rad) times the angle of a count; they broadcast."""
    counts = np.asarray(counts_per_rev, dtype=np.float64)
    stiffness = np.asarray(stiffness_nm_per_rad, dtype=np.float64)
    if (counts <= 0.0).any() or (stiffness < 0.0).any():
        raise UsageError("counts per revolution must be above 0, and the wall's stiffness not below 0")
    step: Array = stiffness * 2.0 * pi / counts
    return step


def in_range(counts_per_rev: ArrayLike, *, name: str | None = None) -> NDArray[np.bool_]:
    """Whether steps that far apart are within the spatial periods of the experiment."""
    low, high = threshold_set("torque", name)["period_deg"]
    period = 360.0 / np.asarray(counts_per_rev, dtype=np.float64)
    inside: NDArray[np.bool_] = (period >= low) & (period <= high)
    return inside


def level(
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
