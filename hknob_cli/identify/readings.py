"""Runs of equal readings: what an encoder that has not moved on tells, counted once."""

import numpy as np

from hknob_cli.recordings.trial import Array


class Runs:
    """Runs of equal neighbours in a record; a run's mean is one observation, however long it lasts.

    An encoder at rest repeats its count: a thousand equal readings say that the angle is within that count, once.
    Taken as a thousand observations they would outvote the motion, and their common error would not average out.
    Where noise moves every reading, each is a run of its own.
    """

    def __init__(self, readings: Array) -> None:
        self._first = np.concatenate(([0], np.flatnonzero(np.diff(readings)) + 1))
        self._length = np.diff(np.append(self._first, len(readings)))
        self._all = len(self._first) == len(readings)

    def mean(self, values: Array) -> Array:
        """Means over each run, (runs,) or (runs, p), of values (n,) or (n, p)."""
        if self._all:
            return values
        sums = np.add.reduceat(values, self._first, axis=0)
        return np.asarray(sums / (self._length if values.ndim == 1 else self._length[:, None]))
