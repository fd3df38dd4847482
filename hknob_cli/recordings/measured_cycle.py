"""The measures of Chapter 8 of one recorded trial: sustained or not, how large, how fast, how firmly held.

Peaks and troughs of a motion that is known at samples only, and in steps of an encoder.

Whether a recorded trial buzzes, and over which part it does so steadily.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.recordings.spectrum import principal_frequency

Array = np.ndarray[Any, np.dtype[np.float64]]

PAUSE_S = 0.05  # a buzz is no slower than 20 Hz, above a hand's tremor of 8-12 Hz
LEAST_S = 1.0  # "After 1-3 seconds of sustained buzzing" (Hasser, sec. 8.2)
SETTLE_S = 0.5  # first contact, and a grip that is still rising
Flags = np.ndarray[Any, np.dtype[np.bool_]]


class Swing(NamedTuple):
    """Angles (rad) and times (s) of local maxima and minima, in turn; arrays."""

    maxima: Array
    minima: Array
    maxima_s: Array
    minima_s: Array

    @property
    def p2p(self) -> float:
        """Mean local maximum minus mean local minimum; 0 without either."""
        return float(self.maxima.mean() - self.minima.mean()) if self.maxima.size and self.minima.size else 0.0

    @property
    def cycle_hz(self) -> float:
        """Cycles per second, from the first maximum to the last; 0 with fewer than two."""
        if self.maxima.size < 2:
            return 0.0
        return float((self.maxima.size - 1) / (self.maxima_s[-1] - self.maxima_s[0]))


def find_swing(
    time_s: Array, angle_rad: Array, *, step_rad: float, noise_rad: float = 0.0, between: bool = True
) -> Swing:
    """Turning points of the samples, or, ``between`` them, of the cubic spline through them; arrays (n,), n >= 4.

    A maximum counts where the angle then falls by more than 1.5 ``step_rad`` of the encoder, or 6 times ``noise_rad``,
    its rms, if that is more; a minimum likewise. So a step of the encoder to and fro is no cycle, nor is noise.

    A true peak lies between two samples. The samples alone miss about (pi / n)^2 / 6 of a sine's height with n samples
    a cycle, 1.1 % with 12 and 5 % with 5.5; a limit cycle keeps step with the samples, so that this does not average
    out. The spline needs no model of hand and knob. Where the torque on the knob jumps by D, at a sample or between
    two, it is off by at most 0.03 D T^2 / J next to the jump, a quarter of that an interval further, and so on.

    Measured on the proven orbits of Chapter 8's cells, with and without friction: off by -2.4 to +0.5 % of the swing
    from 6.5 samples a cycle on (the samples alone: -0.0 to -10 %), and by -6 % (-15 %) at 3.5 samples a cycle.
    """
    if not between:
        return _alternate(time_s, angle_rad, max(1.5 * step_rad, 6.0 * noise_rad))
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(time_s, angle_rad)
    turns = spline.derivative().roots(discontinuity=False, extrapolate=False)
    turns = np.concatenate([time_s[:1], turns[np.isfinite(turns)], time_s[-1:]])
    return _alternate(turns, spline(turns), max(1.5 * step_rad, 6.0 * noise_rad))


def _alternate(times: Array, values: Array, least: float) -> Swing:
    """Maxima and minima in turn, each more than ``least`` from the next; what the ends cut off is left out."""
    found: list[tuple[int, bool]] = []
    high = low = 0
    falling: bool | None = None
    for i, value in enumerate(values.tolist()):
        if value > values[high]:
            high = i
        if value < values[low]:
            low = i
        if falling is not True and values[high] - value > least:
            if falling is not None:
                found.append((high, True))
            falling, low = True, i
        elif falling is not False and value - values[low] > least:
            if falling is not None:
                found.append((low, False))
            falling, high = False, i
    tops = np.array([i for i, is_top in found if is_top], dtype=np.int64)
    lows = np.array([i for i, is_top in found if not is_top], dtype=np.int64)
    return Swing(values[tops], values[lows], times[tops], times[lows])


class Buzz(NamedTuple):
    """The longest stretch in which the wall's torque never kept still for longer than a pause.

    ``first``, ``last``: samples of its first and its last change of torque; ``begin``: first sample of the steady part,
    which ends with ``last``. ``sustained``: whether the stretch is long enough. All 0 and False without a change.
    """

    first: int = 0
    begin: int = 0
    last: int = 0
    sustained: bool = False


def find_buzz(
    time_s: Array,
    torque_nm: Array,
    *,
    least_s: float = LEAST_S,
    settle_s: float = SETTLE_S,
) -> Buzz:
    """Find the longest buzz in samples of the part of a trial in which the wall was on, arrays (n,).

    ``torque_nm``: commanded, which changes when the knob crosses an edge of the wall's encoder. A trial is *sustained*
    if it changed at least every `PAUSE_S` for ``least_s`` without a break, anywhere before the end: a person may let
    go before the trial is stopped. The steady part leaves out the first ``settle_s`` of it.
    """
    changes = np.flatnonzero(np.diff(torque_nm) != 0.0) + 1
    if not changes.size:
        return Buzz()
    breaks = np.flatnonzero(np.diff(time_s[changes]) > PAUSE_S) + 1
    starts = np.concatenate([[0], breaks])
    ends = np.concatenate([breaks, [changes.size]]) - 1
    lengths = time_s[changes[ends]] - time_s[changes[starts]]
    longest = int(lengths.argmax())
    first, last = int(changes[starts[longest]]), int(changes[ends[longest]])
    begin = first + int(np.searchsorted(time_s[first : last + 1], time_s[first] + settle_s))
    sustained = bool(lengths[longest] >= least_s) and last - begin >= 4
    return Buzz(first, min(begin, last), last, sustained)


class TrialMeasures(NamedTuple):
    """What a trial amounts to. Without a sustained buzz p2p, RMS and frequency are 0, for it is taken as rest.

    ``steady``: first and last sample of the steady part, counted from the first sample of the trial; without a
    sustained buzz the last second in which the wall was on. ``p2p_rad``: mean local maximum minus mean local minimum,
    peaks between samples by a spline; ``p2p_samples_rad``: of the samples alone; ``rms_rad`` about the mean;
    ``spectral_hz``: highest peak of the spectrum; ``cycle_hz``: local maxima per second; ``grip_zero_n``: what the
    grip cell showed before the start, subtracted from its mean; ``wall_torque_nm``: mean torque of the wall, which is
    what person and hand push, on average.
    """

    sustained: bool
    steady: tuple[int, int]
    steady_s: float
    cycles: int
    p2p_rad: float
    p2p_samples_rad: float
    rms_rad: float
    spectral_hz: float
    cycle_hz: float
    grip_mean_n: float
    grip_std_n: float
    grip_zero_n: float
    wall_torque_nm: float


def measure_trial(
    time_s: Array,
    angle_rad: Array,
    torque_nm: Array,
    grip_n: Array,
    running: Flags,
    *,
    step_rad: float,
    least_s: float = LEAST_S,
    settle_s: float = SETTLE_S,
) -> TrialMeasures:
    """Measure a trial of n samples, arrays (n,).

    ``angle_rad`` by the device's own encoder, whose step is ``step_rad``; ``running``: where the wall was on.
    ``grip_n`` before the start is the cell's zero; one that was subtracted before is 0 there. The
    encoder's rms noise is taken from before the start, where the knob hardly moves. The others: see `find_buzz`.

    p2p is at best good to ``step_rad`` and to what `find_swing` says of peaks between samples.
    """
    on = np.flatnonzero(running)
    rest = slice(0, int(on[0]) if on.size else time_s.size)
    zero = float(grip_n[rest].mean()) if rest.stop else 0.0
    noise_rad = _noise(angle_rad[rest])
    if not on.size:
        return _at_rest((0, 0), time_s, torque_nm, grip_n, zero)
    first, last = int(on[0]), int(on[-1])
    whole = slice(first, last + 1)
    buzz = find_buzz(time_s[whole], torque_nm[whole], least_s=least_s, settle_s=settle_s)
    if not buzz.sustained:
        begin = int(np.searchsorted(time_s[whole], time_s[last] - 1.0))
        return _at_rest((first + begin, last), time_s, torque_nm, grip_n, zero)
    steady = first + buzz.begin, first + buzz.last
    part = slice(steady[0], steady[1] + 1)
    time, angle = time_s[part], angle_rad[part]
    swing = find_swing(time, angle, step_rad=step_rad, noise_rad=noise_rad)
    samples = find_swing(time, angle, step_rad=step_rad, noise_rad=noise_rad, between=False)
    cycles = max(0, swing.maxima.size - 1)
    # About the mean of whole cycles, where there are any.
    if cycles:
        inside = (time >= swing.maxima_s[0]) & (time < swing.maxima_s[-1])
        angle = angle[inside] if inside.any() else angle
    return TrialMeasures(
        sustained=True,
        steady=steady,
        steady_s=float(time[-1] - time[0]),
        cycles=cycles,
        p2p_rad=swing.p2p,
        p2p_samples_rad=samples.p2p,
        rms_rad=float(angle.std()),
        spectral_hz=principal_frequency(time, angle_rad[part]),
        cycle_hz=swing.cycle_hz,
        grip_mean_n=float(grip_n[part].mean()) - zero,
        grip_std_n=float(grip_n[part].std()),
        grip_zero_n=zero,
        wall_torque_nm=float(torque_nm[part].mean()),
    )


def _noise(angle_rad: Array) -> float:
    """Rms of the noise from sample to sample, by that of 68.27 % of the steps: a knob that is touched adds none."""
    if angle_rad.size < 2:
        return 0.0
    return float(np.percentile(np.abs(np.diff(angle_rad)), 68.27)) / sqrt(2.0)


def _at_rest(part: tuple[int, int], time_s: Array, torque_nm: Array, grip_n: Array, zero: float) -> TrialMeasures:
    held = slice(part[0], part[1] + 1)
    return TrialMeasures(
        sustained=False,
        steady=part,
        steady_s=float(time_s[part[1]] - time_s[part[0]]) if time_s.size else 0.0,
        cycles=0,
        p2p_rad=0.0,
        p2p_samples_rad=0.0,
        rms_rad=0.0,
        spectral_hz=0.0,
        cycle_hz=0.0,
        grip_mean_n=float(grip_n[held].mean()) - zero if time_s.size else 0.0,
        grip_std_n=float(grip_n[held].std()) if time_s.size else 0.0,
        grip_zero_n=zero,
        wall_torque_nm=float(torque_nm[held].mean()) if time_s.size else 0.0,
    )
