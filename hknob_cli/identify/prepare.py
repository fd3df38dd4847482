"""From trials to motions, each step optional: average, smooth, differentiate, cut (Hasser, Section 4.2.3)."""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.motion import (
    Aligned,
    Motion,
    UnusableError,
    align,
    differentiate,
    encoder_step,
    even,
    interval,
    smooth,
)
from hknob_cli.recordings.trial import Array, Trial, flags, running_flags

SMOOTHED_RATE_HZ = 1000.0
_MARGIN_S = 0.02


class Preparation(NamedTuple):
    """How trials become motions; the defaults are the dissertation's, as far as it says.

    ``average`` the trials of a condition in a block, aligned at the onset. ``decimate``: factor of the filtered
    decimation, 1 for no smoothing; by default what comes closest to 1 kHz, 10 at the dissertation's 10 kHz, which
    prints no factor. ``interpolate`` back to the recorded rate; otherwise the motion stays decimated, its torque
    averaged over the longer intervals. ``smooth_torque`` by the filter of the angle, which the dissertation does not
    mention: for an estimator that sets torque against acceleration sample by sample, which is biased otherwise, for a
    square pulse has edges and smoothed acceleration none; the torque is then that at the samples, and of no use to an
    estimator that simulates. ``differentiate``: give velocity and
    acceleration. ``window_s``: what is kept before and after the onset: 2 ms, and 30 ms, for stretch reflexes set in
    20 to 30 ms after it and are no part of a passive hand.

    ``continuous``: each trial is a motion of its own, from any state, of which ``span_s`` is kept (seconds from its
    first sample, None: all). ``torque``: measured or commanded, None: measured where all trials have one. ``ramps``:
    the torque runs straight between samples. ``free_start``: the motion may begin moving.
    """

    average: bool = True
    decimate: int | None = None
    interpolate: bool = True
    smooth_torque: bool = False
    differentiate: bool = True
    window_s: tuple[float, float] = (0.002, 0.030)
    continuous: bool = False
    span_s: tuple[float, float] | None = None
    torque: str | None = None
    ramps: bool = False
    free_start: bool = False


class Condition(NamedTuple):
    """Trials that differ in nothing but their number."""

    subject: str
    experiment: str
    grip_target_n: float
    block: int


class Prepared(NamedTuple):
    """A motion, of which condition and of which trials; ``flags`` say what is suspicious, each with its trial.

    ``motion`` is None where no trial can be used, which a flag explains.
    """

    condition: Condition
    trials: tuple[int, ...]
    motion: Motion | None
    flags: tuple[str, ...]


def conditions(
    trials: Iterable[Trial], preparation: Preparation | None = None, *, counts_per_rev: float | None = None
) -> list[Prepared]:
    """Motions of all conditions in the order of their first trials; one per trial where nothing is averaged.

    ``counts_per_rev``: encoder counts per revolution, for the noise and the flags.
    """
    preparation = preparation or Preparation()
    groups: dict[tuple[Condition, int | None], list[Trial]] = {}
    for trial in trials:
        alone = None if preparation.average and not preparation.continuous else trial.key.trial
        groups.setdefault((Condition(*trial.key[:4]), alone), []).append(trial)
    return [_prepared(key[0], group, preparation, counts_per_rev) for key, group in groups.items()]


def _prepared(condition: Condition, trials: list[Trial], how: Preparation, counts: float | None) -> Prepared:
    acting, measured, notes = _with_torque(trials, how.torque)
    cuts: list[Aligned] = []
    used: list[int] = []
    dt_s: float | None = None
    for trial, used_as in zip(trials, acting, strict=True):
        number = trial.key.trial
        said = running_flags(trial, counts_per_rev=counts) if how.continuous else flags(trial, counts_per_rev=counts)
        notes += [f"trial {number}: {flag}" for flag in (*trial.notes, *said)]
        try:
            dt_s = interval(trial) if dt_s is None else dt_s
            if how.continuous:
                cuts.append(even(used_as, dt_s=dt_s, span_s=how.span_s, ramps=how.ramps))
            else:
                cuts.append(_cut(used_as, dt_s, how, commanded=trial.torque_nm if measured else None))
            used.append(number)
        except UnusableError as error:
            notes.append(f"trial {number} left out: {error}")
    if not cuts or dt_s is None:
        return Prepared(condition, (), None, tuple(notes))
    motion = _motion(_mean(cuts), len(cuts), dt_s, how, counts)
    motion = motion._replace(pulsed=not how.continuous, free_start=how.free_start, ramps=how.ramps, measured=measured)
    if how.continuous and motion.noise_rad is None and (step := encoder_step(motion)):
        motion = motion._replace(noise_rad=step / math.sqrt(12.0))
    return Prepared(condition, tuple(used), motion, tuple(notes))


def _with_torque(trials: list[Trial], wanted: str | None) -> tuple[list[Trial], bool, list[str]]:
    """Trials with the torque that is used as their own; whether it is measured; and why not, where it was wanted."""
    sensed = [trial.measured_torque_nm is not None for trial in trials]
    if wanted == "commanded" or not any(sensed):
        lacking = ["no measured torque: the commanded one is used"] if wanted == "measured" else []
        return trials, False, lacking
    if not all(sensed):
        return trials, False, [f"measured torque in {sum(sensed)} of {len(sensed)} trials: the commanded one is used"]
    used = [(trial, trial.measured_torque_nm) for trial in trials]
    return [one._replace(torque_nm=torque) for one, torque in used if torque is not None], True, []


def _cut(trial: Trial, dt_s: float, how: Preparation, *, commanded: Array | None) -> Aligned:
    """A trial's window, with a margin that takes up the ends of the filter."""
    before, after = how.window_s
    around = {"before_s": before + _MARGIN_S, "after_s": after + _MARGIN_S}
    found = align(trial, dt_s=dt_s, commanded=commanded, **around)
    left = (found.angle_rad.size - 1 - found.onset) * dt_s
    if left < after - 0.5 * dt_s:
        raise UnusableError(f"it ends {left:.3g} s after the onset, the window needs {after:g} s")
    return found


def _mean(cuts: list[Aligned]) -> Aligned:
    """Mean of trials aligned at the onset, where all have samples; its noise is that of the mean."""
    if len(cuts) == 1:
        return cuts[0]
    before = min(cut.onset for cut in cuts)
    after = min(cut.angle_rad.size - cut.onset for cut in cuts)
    torque = np.mean([cut.torque_nm[cut.onset - before : cut.onset + after] for cut in cuts], axis=0)
    angle = np.mean([cut.angle_rad[cut.onset - before : cut.onset + after] for cut in cuts], axis=0)
    noise = _of_mean([cut.noise_rad for cut in cuts])
    sensor = _of_mean([cut.torque_noise_nm for cut in cuts])
    impulses = [float(cut.torque_nm.sum()) for cut in cuts]
    usual = float(torque.sum())
    # Of pulses of one size: a larger one moves the same hand further.
    scaled = [
        cut.angle_rad[cut.onset - before : cut.onset + after] * (usual / impulse if impulse and usual else 1.0)
        for cut, impulse in zip(cuts, impulses, strict=True)
    ]
    scatter = np.std(scaled, axis=0, ddof=1)
    senses = [cut.felt_rad_s2[cut.onset - before : cut.onset + after] for cut in cuts if cut.felt_rad_s2 is not None]
    felt = np.mean(senses, axis=0) if len(senses) == len(cuts) else None
    return Aligned(before, torque, angle, noise, scatter, sensor, felt)


def _of_mean(noises: list[float | None]) -> float | None:
    """Noise of the mean of signals with these; None where none is known."""
    known = [value for value in noises if value is not None]
    return math.sqrt(sum(value**2 for value in known) / len(known) / len(noises)) if known else None


def _motion(mean: Aligned, count: int, dt_s: float, how: Preparation, counts: float | None) -> Motion:
    """Smoothed, differentiated, cut.

    Velocity is of the smoothed angle and smoothed again before its own derivative, unless the torque is smoothed: then
    all terms of the equation of motion pass the same filter, once.
    """
    factor = how.decimate if how.decimate is not None else max(1, round(1.0 / (dt_s * SMOOTHED_RATE_HZ)))
    angle = smooth(mean.angle_rad, factor)
    sampled = mean.torque_nm if how.ramps else _at_samples(mean.torque_nm)
    torque = smooth(sampled, factor) if how.smooth_torque else mean.torque_nm
    velocity = acceleration = None
    if how.differentiate:
        velocity = differentiate(angle, dt_s)
        if not how.smooth_torque:
            velocity = smooth(velocity, factor)
        acceleration = differentiate(velocity, dt_s)
    stride = 1 if how.interpolate else factor
    if how.continuous:
        start, stop = 0, mean.angle_rad.size
    else:
        before = min(math.floor(how.window_s[0] / dt_s + 0.5), mean.onset)
        start = mean.onset - before // stride * stride
        stop = mean.onset + math.floor(how.window_s[1] / dt_s + 0.5) + 1
    kept = slice(start, stop, stride)
    return Motion(
        dt_s=dt_s * stride,
        torque_nm=torque[kept] if how.smooth_torque else _held(torque[start:], stride)[: len(angle[kept])],
        angle_rad=angle[kept],
        velocity_rad_s=None if velocity is None else velocity[kept],
        acceleration_rad_s2=None if acceleration is None else acceleration[kept],
        noise_rad=_noise(mean.noise_rad, count, counts),
        averaged=count,
        scatter_rad=_scatter(mean, slice(mean.onset, stop), count, counts),
        torque_noise_nm=mean.torque_noise_nm,
        felt_rad_s2=None if mean.felt_rad_s2 is None else mean.felt_rad_s2[kept],
        begins=None if mean.torque_noise_nm is None else (mean.onset - start) // stride,
    )


def _scatter(mean: Aligned, kept: slice, count: int, counts: float | None) -> float | None:
    """Standard deviation of the trials about their mean, rms over the motion, what noise makes of it taken off."""
    if mean.scatter_rad is None:
        return None
    noise = (_noise(mean.noise_rad, count, counts) or 0.0) * math.sqrt(count)
    return math.sqrt(max(float(np.mean(mean.scatter_rad[kept] ** 2)) - noise**2, 0.0))


def _at_samples(torque: Array) -> Array:
    """Torque at the samples, of one held between them: the mean of the intervals before and after."""
    mean: Array = 0.5 * (torque + np.concatenate([torque[:1], torque[:-1]]))
    return mean


def _held(torque: Array, stride: int) -> Array:
    """Mean of a held torque over intervals of ``stride`` samples, the last one over what there is."""
    whole = torque.size // stride * stride
    means = torque[:whole].reshape(-1, stride).mean(axis=1)
    return means if whole == torque.size else np.append(means, torque[whole:].mean())


def _noise(at_rest: float | None, count: int, counts: float | None) -> float | None:
    """Noise of the averaged angle before smoothing: as at rest, but no less than what the encoder's steps make.

    A step q makes an error of q/sqrt(12) in motion, where each sample falls anywhere in a step; at rest it may not
    show at all. It is independent between trials, and averages out with them.
    """
    step = 0.0 if counts is None else 2.0 * math.pi / counts / math.sqrt(12.0 * count)
    noise = max(at_rest or 0.0, step)
    return noise if noise > 0.0 else None
