"""One trial's pulse on a uniform grid with the onset at a known sample, the angle from rest."""

from typing import NamedTuple

import numpy as np

from hknob_cli.errors import ComputationError
from hknob_cli.recordings.pulse import Pulse, find_pulse
from hknob_cli.recordings.trial import Array, Trial

REST_S = 0.02
EVEN = 0.01  # times within this share of the interval are taken as they stand
WIDEST_GAP = 3.0  # intervals; interpolation across a wider gap would be invention
FEWEST = 4  # samples after the onset


class UnusableError(ComputationError):
    """A trial that cannot be made a motion, and why."""


class Aligned(NamedTuple):
    """A trial on a uniform grid; the torque sets in at sample ``onset``, where the angle is still at rest, 0.

    ``torque_nm`` acts from sample i to i + 1. ``noise_rad``: standard deviation of the angle before the pulse, None
    with fewer than eight samples there. ``scatter_rad``, of a mean: standard deviation of its trials at each sample,
    scaled to one pulse.
    """

    onset: int
    torque_nm: Array
    angle_rad: Array
    noise_rad: float | None
    scatter_rad: Array | None = None


def interval(trial: Trial) -> float:
    """Typical interval between samples, s. Raises `UnusableError` for fewer than four samples."""
    if trial.time_s.size < 4:
        raise UnusableError(f"{trial.time_s.size} samples are too few")
    steps = np.diff(trial.time_s)
    usual = steps[np.abs(steps - np.median(steps)) <= 0.5 * np.median(steps)]
    return float(usual.mean())


def align(trial: Trial, *, dt_s: float, before_s: float, after_s: float) -> Aligned:
    """Cut the pulse out, from ``before_s`` or what there is before its onset to ``after_s`` or what there is after it.

    Where times are not on the grid of ``dt_s`` through the onset, the angle is interpolated linearly, and the torque
    averaged over each interval, which keeps its impulse. The rest angle is the mean of the 20 ms up to the onset.
    Raises `UnusableError` without a pulse, without samples before it, with too few after it, or with a gap of over
    three intervals.
    """
    pulse = find_pulse(trial.torque_nm)
    if pulse is None:
        raise UnusableError("no pulse")
    if pulse.onset == 0:
        raise UnusableError("the pulse has begun before the recording")
    time = trial.time_s - trial.time_s[pulse.onset]
    first = int(np.searchsorted(time, -before_s - 0.5 * dt_s))
    last = int(np.searchsorted(time, after_s + 0.5 * dt_s)) - 1
    if last - first < FEWEST or last - int(np.searchsorted(time, 0.0)) < FEWEST:
        raise UnusableError(f"samples {dt_s:.3g} s apart are too few for a window of {after_s:.3g} s after the onset")
    widest = float(np.diff(time[first : last + 1]).max())
    if widest > WIDEST_GAP * dt_s:
        raise UnusableError(f"gap of {widest:.3g} s in time, over {WIDEST_GAP:g} intervals of {dt_s:.3g} s")
    rest = trial.angle_rad[_rest(time, pulse)]
    begin, end = int(np.ceil(time[first] / dt_s - EVEN)), int(np.floor(time[last] / dt_s + EVEN))
    grid: Array = dt_s * np.arange(begin, end + 1, dtype=np.float64)
    if grid.size == last + 1 - first and np.abs(time[first : last + 1] - grid).max() <= EVEN * dt_s:
        torque, angle = trial.torque_nm[first : last + 1], trial.angle_rad[first : last + 1]
    else:
        torque, angle = _averaged(time, trial.torque_nm, grid, dt_s), np.interp(grid, time, trial.angle_rad)
    noise = float(rest.std(ddof=1)) if rest.size >= 8 else None
    return Aligned(-begin, torque.astype(np.float64), angle - rest.mean(), noise)


def _rest(time: Array, pulse: Pulse) -> slice:
    """Samples at rest: 20 ms, the last of them the onset, at which the torque has not yet moved the knob."""
    return slice(int(np.searchsorted(time, -REST_S)), pulse.onset + 1)


def _averaged(time: Array, torque: Array, grid: Array, dt_s: float) -> Array:
    """Mean over each interval of the grid of a torque that is held from sample to sample."""
    impulse = np.concatenate([[0.0], np.cumsum(torque[:-1] * np.diff(time))])
    ends = np.append(grid, grid[-1] + dt_s)
    past = np.maximum(ends - time[-1], 0.0) * torque[-1]
    mean: Array = np.diff(np.interp(ends, time, impulse) + past) / dt_s
    return mean
