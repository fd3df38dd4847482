"""The principal frequency of a recorded motion: the highest peak of its spectrum, found between its lines."""

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

ABOVE_HZ = 20.0  # slower is the hand: its tremor of 8-12 Hz, its drift


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
