"""The pitch and the harmonics of a recorded motion.

The pitch of a recorded buzz, in cycles per second, as a sweep counts them.

How often the wall's torque rises: the pitch of a buzz that is too small for the encoder to show its maxima.

The harmonics of a recorded cycle: of a motion known row by row, with a period that is known.
"""

from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hknob_cli.errors import UsageError
from hknob_cli.measure.orbit import Harmonics

Array = np.ndarray[Any, np.dtype[np.float64]]

ABOVE_HZ = 20.0  # slower is the hand: its tremor of 8-12 Hz, its drift

LEAST_COUNTS = 10.0  # of the device's own encoder: of a smaller swing it misses maxima


def principal_frequency(time_s: Array, angle_rad: Array, *, above_hz: float = ABOVE_HZ) -> float:
    """Frequency (Hz) of the highest peak above ``above_hz``; 0 if there is none, as at rest. Arrays (n,).

    Times may be uneven by jitter and gaps: the motion is read at as many even ones, along straight lines. A Hann window
    keeps a steady tone out of its neighbours; its peak is found by a parabola through three logarithms, which is off by
    less than 0.02 of a line, 1 / duration, for a tone of more than four cycles.

    Source: the Gaussian interpolation of Gasior & Gonzalez 2004, AIP Conf. Proc. 732, 276-285.
    """
    count = time_s.size
    if count < 8:
        return 0.0
    duration = float(time_s[-1] - time_s[0]) * count / (count - 1)
    even = np.interp(np.linspace(time_s[0], time_s[-1], count), time_s, angle_rad)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(count) + 0.5) / count)
    power = np.abs(np.fft.rfft((even - np.average(even, weights=window)) * window, 4 * count))
    first = max(1, int(np.ceil(4.0 * above_hz * duration)))
    if first >= power.size - 1:
        return 0.0
    # A line that is only the flank of what is slower is no peak.
    inner = power[first:-1]
    is_peak = (inner > power[first - 1 : -2]) & (inner >= power[first + 1 :])
    if not is_peak.any():
        return 0.0
    at = first + int(np.where(is_peak, inner, 0.0).argmax())
    if power[at] <= 1e-12 * max(1e-300, float(np.abs(angle_rad).max())) * count:  # rounding, of a knob at rest
        return 0.0
    low, mid, high = np.log(np.maximum(power[at - 1 : at + 2], 1e-300))
    bend = low - 2.0 * mid + high
    shift = 0.5 * (low - high) / bend if bend < 0.0 else 0.0
    return float((at + shift) / (4.0 * duration))


def pitch_hz(
    *, p2p_rad: float, cycle_hz: float, torque_hz: float, native_counts: int, counts_per_rev: int | float
) -> float:
    """Local maxima per second, or, of a swing too small to show them all, rises of the torque per second.

    So small a swing crosses one edge of the wall's encoder, if that is the coarser, and so raises the torque once a
    cycle. ``native_counts``: per revolution of the device's own encoder; ``counts_per_rev``: of the wall's.
    """
    own = 2.0 * pi / native_counts
    small = p2p_rad < LEAST_COUNTS * own < 2.0 * pi / counts_per_rev
    return torque_hz if small else cycle_hz


def torque_rises_hz(time_s: Array, torque_nm: Array) -> float:
    """Rises of the commanded torque per second of some samples, arrays (n,), n >= 2 where there is any; 0 without one.

    A swing below one count of the wall's encoder crosses one edge of it, so that each cycle switches the torque on
    once: then it is cycles per second, however small they are. A wider swing has several rises a cycle. Counted from
    the first rise to the last.
    """
    rises = np.flatnonzero(np.diff(torque_nm) > 0.0) + 1
    if rises.size < 2:
        return 0.0
    return float((rises.size - 1) / (time_s[rises[-1]] - time_s[rises[0]]))


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
