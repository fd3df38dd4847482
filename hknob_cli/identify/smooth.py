"""Smoothing by filtered decimation and interpolation, and differentiation (Hasser, Section 4.2.3)."""

import numpy as np

from hknob_cli.recordings.trial import Array

# A Butterworth low-pass of fourth order, forwards and backwards: no phase, gain 1/(1 + (f/cutoff)^8), so that every
# polynomial up to degree 7 passes unchanged. Its cutoff, in shares of the Nyquist frequency that decimation leaves.
ORDER = 4
CUTOFF = 0.8


def low_pass(signal: Array, factor: int) -> Array:
    """Signal without what decimation by ``factor`` would fold: no phase, gain 1/(1 + (f/cutoff)^8).

    The cutoff is 0.8/(2 factor) of the sample rate. At the ends, where the signal is continued oddly, straight lines
    pass unchanged, other motion only from about two periods of the cutoff on. ``signal`` is returned if factor is 1.
    """
    if factor == 1:
        return signal
    from scipy.signal import butter, sosfiltfilt

    sections = butter(ORDER, CUTOFF / factor, output="sos")
    smooth: Array = sosfiltfilt(sections, signal, padlen=min(signal.size - 1, 10 * factor))
    return smooth


def smooth(signal: Array, factor: int) -> Array:
    """Signal after `low_pass`, decimation by ``factor`` and a cubic spline back to all samples; not-a-knot ends.

    A sine of frequency f keeps its phase, and its amplitude but for a share of (f/cutoff)^8 + 5/384 (2 pi f h)^4, h
    the decimated interval: the filter's gain, and the bound of Hall and Meyer (1976) of the spline's error.
    """
    if factor == 1:
        return signal
    from scipy.interpolate import CubicSpline

    times = np.arange(signal.size)
    knots = np.union1d(times[::factor], times[-1:])
    spline: Array = CubicSpline(knots, low_pass(signal, factor)[knots])(times)
    return spline


def differentiate(signal: Array, dt_s: float) -> Array:
    """Rate of change per second, by central differences, at the ends by one-sided ones of second order.

    Exact for quadratics. Needs three samples.
    """
    rate: Array = np.gradient(signal, dt_s, edge_order=2)
    return rate
