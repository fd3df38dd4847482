"""A motion as the estimators take it: aligned at its onset, smoothed and differentiated, or as an encoder's readings.

A pulse is put on a uniform grid with its onset at a known sample, the angle from rest. Smoothing is by filtered
decimation and interpolation, and differentiation (Hasser, Section 4.2.3).

Within a count an encoder's error hangs on where the knob is. While the knob crosses counts the errors average out;
where it turns or rests, a thousand readings share one error. Taken as a thousand observations they would outvote the
motion, and no covariance of their neighbours would show it. Where noise exceeds half a count it dithers the count
away, and every reading is an observation of its own.
"""

from typing import NamedTuple

import numpy as np

from hknob_cli.errors import ComputationError
from hknob_cli.recordings.trial import Array, Pulse, Trial, find_pulse

# A Butterworth low-pass of fourth order, forwards and backwards: no phase, gain 1/(1 + (f/cutoff)^8), so that every
# polynomial up to degree 7 passes unchanged. Its cutoff, in shares of the Nyquist frequency that decimation leaves.
ORDER = 4
CUTOFF = 0.8


class Motion(NamedTuple):
    """Torque and angle at a uniform interval ``dt_s``, the angle from its rest value before the pulse.

    ``velocity_rad_s`` and ``acceleration_rad_s2`` where differentiation was asked for. ``torque_nm`` is what acts from
    sample i to i + 1 (zero-order hold). ``noise_rad``: standard deviation of the angle's noise, from the part before
    the pulse and the encoder's step; None if unknown. ``averaged``: trials that were averaged into it.
    ``scatter_rad``: root mean square over time of the trials' standard deviation about it, what noise makes taken off;
    None of a single trial.

    ``pulsed`` False: the torque goes on as it likes, and the angle is from its first sample. ``free_start``: the first
    angle and velocity are not those of rest, but unknown. ``ramps``: the torque runs straight from sample to sample.
    ``measured``: the torque is a sensor's, so that no lag is between it and the knob. ``torque_noise_nm``: standard
    deviation of its noise, independent between samples, from the part before the pulse; None if unknown. ``begins``:
    the onset, where a sensor's noise hides it. ``felt_rad_s2``: an accelerometer's, just before each sample's torque.
    """

    dt_s: float
    torque_nm: Array
    angle_rad: Array
    velocity_rad_s: Array | None = None
    acceleration_rad_s2: Array | None = None
    noise_rad: float | None = None
    averaged: int = 1
    scatter_rad: float | None = None
    pulsed: bool = True
    free_start: bool = False
    ramps: bool = False
    measured: bool = False
    torque_noise_nm: float | None = None
    begins: int | None = None
    felt_rad_s2: Array | None = None

    @property
    def onset(self) -> int:
        """First sample with torque, before which nothing moves; 0 where that is not known."""
        if self.begins is not None and not self.free_start:
            return self.begins
        return int(np.flatnonzero(self.torque_nm)[0]) if self.pulsed and not self.free_start else 0

    @property
    def blend_rad(self) -> float:
        """What trials that differ leave between their mean and any one motion, rad rms: scatter squared over the peak.

        The mean of motions with parameters spread by a share s is the motion with their mean except for s² of it.
        """
        return (self.scatter_rad or 0.0) * (self.trials_differ or 0.0)

    @property
    def trials_differ(self) -> float | None:
        """Share of the peak angle by which the averaged trials scatter beyond noise; None of a single trial."""
        peak = float(np.max(np.abs(self.angle_rad)))
        return None if self.scatter_rad is None or not peak > 0.0 else self.scatter_rad / peak


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

    A sine of frequency f keeps its phase, and its amplitude except for a share of (f/cutoff)^8 + 5/384 (2 pi f h)^4, h
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
