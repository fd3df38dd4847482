"""The measures of Chapter 8 of one recorded trial: sustained or not, how large, how fast, how firmly held."""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.measure.buzz import LEAST_S, PAUSE_S, SETTLE_S, find_buzz
from hknob_cli.measure.principal_frequency import principal_frequency
from hknob_cli.measure.swing import find_swing

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]


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
    noise_rad: float | None = None,
    pause_s: float = PAUSE_S,
    least_s: float = LEAST_S,
    settle_s: float = SETTLE_S,
) -> TrialMeasures:
    """Measure a trial of n samples, arrays (n,).

    ``angle_rad`` by the device's own encoder, whose step is ``step_rad``; ``running``: where the wall was on.
    ``grip_n`` before the start is the cell's zero; one that was subtracted before is 0 there. ``noise_rad``: rms of the
    encoder's noise, by default what it shows before the start, where the knob rests but for a touch. The others: see
    `find_buzz`.

    p2p is at best good to ``step_rad`` and to what `find_swing` says of peaks between samples.
    """
    on = np.flatnonzero(running)
    rest = slice(0, int(on[0]) if on.size else time_s.size)
    zero = float(grip_n[rest].mean()) if rest.stop else 0.0
    if noise_rad is None:
        noise_rad = _noise(angle_rad[rest])
    if not on.size:
        return _at_rest((0, 0), time_s, torque_nm, grip_n, zero)
    first, last = int(on[0]), int(on[-1])
    whole = slice(first, last + 1)
    buzz = find_buzz(time_s[whole], torque_nm[whole], pause_s=pause_s, least_s=least_s, settle_s=settle_s)
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
