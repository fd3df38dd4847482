"""An encoder's readings as observations: what it repeats while the knob hardly moves is told once.

Within a count an encoder's error hangs on where the knob is. While the knob crosses counts the errors average out;
where it turns or rests, a thousand readings share one error. Taken as a thousand observations they would outvote the
motion, and no covariance of their neighbours would show it. Where noise exceeds half a count it dithers the count
away, and every reading is an observation of its own.
"""

import numpy as np

from hknob_cli.identify.motion import Motion
from hknob_cli.recordings.trial import Array

DITHER = 0.58  # of a count: rms of (half a count of noise, and rounding), beyond which the count's own error is gone


class Observations:
    """Stretches of a record, each one observation: their first samples (s,), and the roots of their weights (s,)."""

    def __init__(self, first: np.ndarray, count: int, root: Array | None = None) -> None:
        self._first, self._root = first, root
        self._length = np.diff(np.append(first, count))
        self._all = len(first) == count

    def take(self, values: Array) -> Array:
        """Means over each stretch times the root of its weight: (s,) or (s, p) of values (n,) or (n, p)."""
        if not self._all:
            sums = np.add.reduceat(values, self._first, axis=0)
            values = sums / (self._length if values.ndim == 1 else self._length[:, None])
        if self._root is None:
            return values
        return np.asarray(values * (self._root if values.ndim == 1 else self._root[:, None]))


def runs(readings: Array) -> Observations:
    """Runs of equal neighbours, all of one weight."""
    return Observations(np.concatenate(([0], np.flatnonzero(np.diff(readings)) + 1)), len(readings))


def stays(modelled: Array, step_rad: float, rms_rad: float, averaged: int, rest: int) -> Observations:
    """Stretches in which the modelled motion travels one encoder count, weighted by what the count leaves open.

    ``rms_rad``: of the residuals; ``averaged``: trials, each with a phase of its own within the count; ``rest``:
    samples before the torque. The error of a stretch of length l and range r has the variance
    (step^2 / 12 averaged)(1 - r/step)^2 + rms^2 / l.
    """
    travelled = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(modelled)))))
    which = np.floor(travelled / step_rad)
    which[:rest] = -1.0
    first = np.concatenate(([0], np.flatnonzero(np.diff(which)) + 1))
    length = np.diff(np.append(first, len(modelled)))
    reach = np.maximum.reduceat(modelled, first) - np.minimum.reduceat(modelled, first)
    # A stretch of one sample is a fast one: the knob crosses counts from sample to sample.
    across = np.where(
        (length == 1) & (first > rest), 1.0, np.minimum(reach / step_rad * length / np.maximum(length - 1, 1), 1.0)
    )
    variance = step_rad**2 / (12.0 * averaged) * (1.0 - across) ** 2 + rms_rad**2 / length
    return Observations(first, len(modelled), np.where(first < rest, 0.0, rms_rad / np.sqrt(variance)))


def encoder_step(motion: Motion) -> float:
    """The encoder's count in rad as the readings show it: they, or sums of ``averaged`` trials, lie on a lattice.

    0 where they do not: noise of a finer kind was added, or they were smoothed.
    """
    gaps = np.diff(np.unique(motion.angle_rad))
    gaps = gaps[gaps > 1e-9 * np.ptp(motion.angle_rad)]
    if len(gaps) == 0:
        return 0.0
    steps = gaps / np.min(gaps)
    if np.any(np.abs(steps - np.round(steps)) > 0.02):
        return 0.0
    return float(np.min(gaps)) * motion.averaged
