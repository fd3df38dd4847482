"""The harmonics of a recorded cycle: of a motion known row by row, with a period that is known."""

import numpy as np
from numpy.typing import ArrayLike

from hknob_cli.errors import UsageError
from hknob_cli.measure.harmonics import Harmonics


def recorded_harmonics(time_s: ArrayLike, velocity_rad_s: ArrayLike, *, highest_hz: float) -> Harmonics:
    """Harmonics of one period of a recording, up to and with ``highest_hz``.

    ``time_s``, ``velocity_rad_s`` (n,): rows from one end of the period to the other, both there, with the ends of
    every hold among them. Velocity is taken as straight between rows: that leaves out what damping and stiffness
    bend it by, and makes the integrals over a period exact. Raises `UsageError` for fewer than three rows, or times
    that do not increase.
    """
    time = np.asarray(time_s, dtype=np.float64)
    speed = np.asarray(velocity_rad_s, dtype=np.float64)
    spans = np.diff(time)
    if len(time) < 3 or not (spans > 0.0).all():
        raise UsageError("a recorded period has three rows or more, at times that increase")
    period = float(time[-1] - time[0])
    frequency = np.arange(1, int(highest_hz * period * (1.0 + 1e-12)) + 1) / period
    turn = 2j * np.pi * frequency
    # By parts, twice: the velocity is continuous, and its slope constant from row to row.
    slope = np.diff(speed) / spans
    jumps = np.diff(slope, prepend=slope[-1])
    waves = np.exp(-np.outer(turn, time[:-1] - time[0]))
    velocity = 2.0 / period * (waves * jumps).sum(axis=1) / turn**2
    return Harmonics(frequency, velocity / turn)
