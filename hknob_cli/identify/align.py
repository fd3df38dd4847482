"""One trial's pulse on a uniform grid with the onset at a known sample, the angle from rest."""

from typing import NamedTuple

import numpy as np

from hknob_cli.errors import ComputationError
from hknob_cli.recordings.trial import Array, Pulse, Trial, find_pulse

REST_S = 0.02
EVEN = 0.01  # times within this share of the interval are taken as they stand
WIDEST_GAP = 3.0  # intervals; interpolation across a wider gap would be invention
FEWEST = 4  # samples after the onset
FEWEST_RUNNING = 20  # samples of a record without a pulse


class UnusableError(ComputationError):
    """A trial that cannot be made a motion, and why."""


class Aligned(NamedTuple):
    """A trial on a uniform grid; the torque sets in at sample ``onset``, where the angle is still at rest, 0.

    ``torque_nm`` acts from sample i to i + 1. ``noise_rad``: standard deviation of the angle before the pulse, None
    with fewer than eight samples there. ``scatter_rad``, of a mean: standard deviation of its trials at each sample,
    scaled to one pulse. ``torque_noise_nm``: as ``noise_rad``, of a measured torque. ``felt_rad_s2``:
    of an accelerometer.
    """

    onset: int
    torque_nm: Array
    angle_rad: Array
    noise_rad: float | None
    scatter_rad: Array | None = None
    torque_noise_nm: float | None = None
    felt_rad_s2: Array | None = None


def interval(trial: Trial) -> float:
    """Typical interval between samples, s. Raises `UnusableError` for fewer than four samples."""
    if trial.time_s.size < 4:
        raise UnusableError(f"{trial.time_s.size} samples are too few")
    steps = np.diff(trial.time_s)
    usual = steps[np.abs(steps - np.median(steps)) <= 0.5 * np.median(steps)]
    return float(usual.mean())


def align(trial: Trial, *, dt_s: float, before_s: float, after_s: float, commanded: Array | None = None) -> Aligned:
    """Cut the pulse out, from ``before_s`` or what there is before its onset to ``after_s`` or what there is after it.

    Where times are not on the grid of ``dt_s`` through the onset, the angle is interpolated linearly, and the torque
    averaged over each interval, which keeps its impulse. The rest angle is the mean of the 20 ms up to the onset.
    ``commanded``: the torque that says where the pulse is, if the trial's own is a sensor's.
    Raises `UnusableError` without a pulse, without samples before it, with too few after it, or with a gap of over
    three intervals.
    """
    pulse = find_pulse(trial.torque_nm if commanded is None else commanded)
    if pulse is None:
        raise UnusableError("no pulse")
    if pulse.onset == 0:
        raise UnusableError("the pulse has begun before the recording (excitation: continuous would take it)")
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
    sensed = trial.torque_nm[_rest(time, pulse)][:-1] if commanded is not None else np.empty(0)
    sensor = float(sensed.std(ddof=1)) if sensed.size >= 8 else None
    felt = None if trial.acceleration_rad_s2 is None else np.interp(grid, time, trial.acceleration_rad_s2)
    return Aligned(
        -begin, torque.astype(np.float64), angle - rest.mean(), noise, torque_noise_nm=sensor, felt_rad_s2=felt
    )


def even(trial: Trial, *, dt_s: float, span_s: tuple[float, float] | None, ramps: bool) -> Aligned:
    """A record on a uniform grid, the angle from its first sample; ``span_s``: what is kept, None for all.

    Where times are not on the grid, the angle is interpolated, and the torque averaged over each interval, or
    interpolated where it ``ramps``. Its noise is not known. Raises `UnusableError` with too few samples or a wide gap.
    """
    time = trial.time_s - trial.time_s[0]
    first, last = 0, time.size - 1
    if span_s is not None:
        first = int(np.searchsorted(time, span_s[0] - 0.5 * dt_s))
        last = int(np.searchsorted(time, span_s[1] + 0.5 * dt_s)) - 1
    if last - first < FEWEST_RUNNING:
        where = "in it" if span_s is None else f"from {span_s[0]:g} to {span_s[1]:g} s, of {time[-1]:.3g} s in it"
        raise UnusableError(f"{max(last - first + 1, 0)} samples {where} are too few")
    kept = slice(first, last + 1)
    steps = np.diff(time[kept])
    widest = int(np.argmax(steps))
    if steps[widest] > WIDEST_GAP * dt_s:
        raise UnusableError(
            f"gap of {steps[widest]:.3g} s in time at {time[first + widest]:.4g} s, over {WIDEST_GAP:g} intervals of "
            f"{dt_s:.3g} s (prepare: {{span: [...]}} keeps a part of a record)"
        )
    time, torque, angle = time[kept] - time[first], trial.torque_nm[kept], trial.angle_rad[kept]
    grid: Array = dt_s * np.arange(int(np.floor(time[-1] / dt_s + EVEN)) + 1, dtype=np.float64)
    if grid.size != time.size or np.abs(time - grid).max() > EVEN * dt_s:
        torque = np.interp(grid, time, torque) if ramps else _averaged(time, torque, grid, dt_s)
        angle = np.interp(grid, time, angle)
    felt = None if trial.acceleration_rad_s2 is None else np.interp(grid, time, trial.acceleration_rad_s2[kept])
    return Aligned(0, torque.astype(np.float64), angle - angle[0], None, felt_rad_s2=felt)


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
