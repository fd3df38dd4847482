"""One recorded trial: its keys, its torque pulse, its random numbers, and what makes it suspicious though well-formed.

The keys say of whom and when it is. Every subject, block and trial has a random stream of its own, so that leaving one
out changes no other. Whole records may be suspicious, too.
"""

import math
from collections.abc import Iterator
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

# A command is part of the pulse from this share of its peak on: a real pulse is square, zero around it.
SHARE = 0.1


class Key(NamedTuple):
    """What tells trials apart: person, experiment (grasp and knob), target of the grip force (N), block, trial."""

    subject: str
    experiment: str
    grip_target_n: float
    block: int
    trial: int


class Trial(NamedTuple):
    """Samples of one trial, all arrays of one length.

    ``time_s`` rises; ``torque_nm`` is commanded, positive as ``angle_rad``; ``measured_torque_nm`` where there is a
    torque sensor; ``grip_n`` is NaN where there is no grip cell. ``notes``: what is surprising about its numbers.
    ``source`` and ``first_row`` say where it was read (rows count from 1 below the header of a file).
    ``acceleration_rad_s2``: of an accelerometer, at each sample, before its torque acts; None if there is none.
    """

    key: Key
    time_s: Array
    torque_nm: Array
    angle_rad: Array
    grip_n: Array
    measured_torque_nm: Array | None = None
    source: str = ""
    first_row: int = 1
    notes: tuple[str, ...] = ()
    acceleration_rad_s2: Array | None = None


class Pulse(NamedTuple):
    """First pulse of a trial.

    ``onset``: first sample with torque, which acts from it on, so that the knob is still at rest there; ``end``: first
    sample after the pulse, the number of samples if it never ends; ``torque_nm``: its mean torque, with sign;
    ``others``: further pulses after it.
    """

    onset: int
    end: int
    torque_nm: float
    others: int


def find_pulse(torque_nm: Array) -> Pulse | None:
    """First pulse of a commanded torque; None if it never leaves zero."""
    size = np.abs(torque_nm)
    peak = float(size.max(initial=0.0))
    if peak == 0.0:
        return None
    edges = np.flatnonzero(np.diff(np.concatenate([[0], size > SHARE * peak, [0]]).astype(np.int8)))
    onset, end = int(edges[0]), int(edges[1])
    return Pulse(onset, end, float(torque_nm[onset:end].mean()), edges.size // 2 - 1)


class Purpose(IntEnum):
    """What a stream is for; the first number of its key. Numbers stay as they are: recordings depend on them."""

    SUBJECT = 1
    BLOCK = 2
    TRIAL = 3
    RECORDING = 4
    BENCH = 5
    DEVICE = 6
    PERSON = 7


def stream(seed: int, purpose: Purpose, *place: int) -> np.random.Generator:
    """The stream at a place, numbers >= 0 such as (experiment, subject, grip, block, trial), under a seed >= 0.

    Source: the spawn keys of NumPy's `SeedSequence`; streams of different keys are independent.
    """
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(purpose, *place))))


FEWEST_HELD = 10
_RUN_UP_S = 5e-4
_FEWEST_RUN_UP = 3
_FREE_FALL_S = 5e-3
_MARGIN = 4.0
_FAST = 5.0

FEWEST_BEFORE = 10
FEWEST_DURING = 10
FEWEST_COUNTS = 20
MOST_TORQUE_NM = 1.0
MOST_MOTION_RAD = 3.0  # of a knob, in a pulse
MOST_HELD_RAD = 1.0  # of a knob that is gripped: hands of the dissertation move by less than 0.3
WRONG_SIGN = "pulse of the wrong sign"
LONGEST_PULSE_S = 0.5  # a hand reacts long before
GAP = 1.5
REST_S = 0.02
FINER = 0.5  # of a count; an encoder of that many counts changes by whole ones, except for digits lost in a file
GRIP_SHARE = 0.2
REST_SHARE = 0.05
TORQUE_SHARE = 0.2
RATE_SHARE = 0.01


def quantum(angle_rad: Array) -> float:
    """Smallest change between samples, rad: the encoder's step where there is one; 0 if nothing changes."""
    changes = np.abs(np.diff(angle_rad))
    # Counts times a step, rounded, differ by a little where they are the same.
    changes = changes[changes > 1e-12 * float(np.abs(angle_rad).max(initial=1e-300))]
    return float(changes.min()) if changes.size else 0.0


def saturation(time_s: Array, angle_rad: Array, onset: int, step_rad: float) -> int:
    """Samples for which the angle is held at its largest value by the end of a sensor's range; 0 if it just turns.

    A motion that turns is held, too, while it stays within one step. It then came in slowly: with a deceleration a,
    velocity v stops within v^2/(2a). Where the velocity of the last half millisecond would need more than four steps
    to stop, with twice the acceleration that the pulse gave the knob in its first five milliseconds, it did not stop
    by itself. Twice: a hand's spring turns back at most twice the torque that wound it up.
    """
    at = onset + int(np.argmax(angle_rad[onset:]))
    held = angle_rad[at:] == angle_rad[at]
    length = int(held.size if held.all() else np.argmin(held))
    if length < FEWEST_HELD or at <= onset + _FEWEST_RUN_UP:
        return 0
    back = min(int(np.searchsorted(time_s, time_s[at] - _RUN_UP_S)), at - _FEWEST_RUN_UP)
    early = min(int(np.searchsorted(time_s, time_s[onset] + _FREE_FALL_S)), at)
    velocity = (angle_rad[at] - angle_rad[back]) / (time_s[at] - time_s[back])
    push = 2.0 * (angle_rad[early] - angle_rad[onset]) / (time_s[early] - time_s[onset]) ** 2
    return length if velocity**2 > 2.0 * (2.0 * max(push, 0.0)) * _MARGIN * step_rad else 0


def stuck(angle_rad: Array) -> int:
    """Times that two changes or more are zero and the next makes up for them, moving over five steps a sample."""
    changes = np.diff(angle_rad)
    step = quantum(angle_rad)
    zero = np.concatenate([[False], changes == 0.0, [False]])
    starts = np.flatnonzero(~zero[:-1] & zero[1:])
    ends = np.flatnonzero(zero[:-1] & ~zero[1:])
    found = 0
    for start, end in zip(starts, ends, strict=True):
        if end - start < 2 or start < 3 or end + 4 > changes.size:
            continue
        around = np.concatenate([changes[start - 3 : start], changes[end + 1 : end + 4]])
        usual = float(around.mean())
        even = bool((around / usual > 0.3).all()) if usual else False  # no noise that happens to repeat itself
        if even and abs(usual) > _FAST * step and changes[end] / usual > 0.5 * (end - start + 1):
            found += 1
    return found


def flags(trial: Trial, *, counts_per_rev: float | None = None, sample_rate_hz: float | None = None) -> tuple[str, ...]:
    """What is suspicious about a trial, a short sentence each with the number found; none if nothing is.

    ``counts_per_rev``: encoder counts per revolution, by default guessed from the smallest step of the angle;
    ``sample_rate_hz``: the rate it should have been sampled at.
    """
    pulse = find_pulse(trial.torque_nm)
    found = [*clock_flags(trial, sample_rate_hz)]
    if pulse is None:
        return (*found, "no pulse: the commanded torque is zero throughout")
    found += _pulse(trial, pulse)
    if pulse.onset and trial.time_s.size > 2:
        found += _motion(trial, pulse, counts_per_rev)
    return tuple(found)


def clock_flags(trial: Trial, sample_rate_hz: float | None) -> Iterator[str]:
    """Gaps in time, and another rate than stated."""
    steps = np.diff(trial.time_s)
    if not steps.size:
        return
    median = float(np.median(steps))
    gaps = steps[steps > GAP * median]
    if gaps.size:
        yield f"{_times(gaps.size, 'gap')} in time, the longest {gaps.max():.3g} s, of samples {median:.3g} s apart"
    if sample_rate_hz is not None and abs(median * sample_rate_hz - 1.0) > RATE_SHARE:
        yield f"sampled at {1.0 / median:.4g} Hz, not at {sample_rate_hz:.4g} Hz"


def _pulse(trial: Trial, pulse: Pulse) -> Iterator[str]:
    """Too few samples, further pulses, torque that was not what was commanded, grip off its target."""
    if abs(pulse.torque_nm) > MOST_TORQUE_NM:
        yield f"a pulse of {pulse.torque_nm:.3g} N*m, more than fingers hold on a knob: is it in mN*m?"
    during = pulse.end - pulse.onset
    if pulse.onset < FEWEST_BEFORE:
        yield f"{_times(pulse.onset, 'sample')} before the pulse, fewer than {FEWEST_BEFORE}"
    if pulse.end >= trial.time_s.size:
        yield "the recording ends before the pulse does"
    if during < FEWEST_DURING:
        yield f"{_times(during, 'sample')} during the pulse, fewer than {FEWEST_DURING}"
    lasts = float(trial.time_s[min(pulse.end, trial.time_s.size - 1)] - trial.time_s[pulse.onset])
    if lasts > LONGEST_PULSE_S:
        yield f"pulse of {lasts:.3g} s, longer than {LONGEST_PULSE_S:g} s: is time in ms?"
    if pulse.others:
        more = _times(pulse.others, "further pulse")
        yield f"{more} after the first, which alone is used (excitation: continuous uses all)"
    inside = slice(pulse.onset, pulse.end)
    if trial.measured_torque_nm is not None and during > 2:
        middle = slice(pulse.onset + during // 4, pulse.end - during // 4)
        measured = float(trial.measured_torque_nm[middle].mean() / trial.torque_nm[middle].mean())
        if abs(measured - 1.0) > TORQUE_SHARE:
            yield f"measured torque is {measured:.0%} of the commanded: is the actuator at its limit?"
    grip, target = float(trial.grip_n[inside].mean()), trial.key.grip_target_n
    if target > 0.0 and math.isfinite(grip) and abs(grip - target) > GRIP_SHARE * target:
        yield f"grip of {grip:.3g} N at the pulse, {grip / target - 1.0:+.0%} off its target of {target:g} N"


def _motion(trial: Trial, pulse: Pulse, counts_per_rev: float | None) -> Iterator[str]:
    """Angle in finer steps than counts, not at rest before, moving the wrong way, at its end, stuck, or coarse."""
    sign = math.copysign(1.0, pulse.torque_nm)
    finest = quantum(trial.angle_rad)
    step = finest if counts_per_rev is None else 2.0 * math.pi / counts_per_rev
    if 0.0 < finest < FINER * step:
        yield f"the angle changes by {finest:.2g} rad, less than a count of {step:.2g} rad: is counts_per_rev right?"
    begin = int(np.searchsorted(trial.time_s, trial.time_s[pulse.onset] - REST_S))
    before = trial.angle_rad[min(begin, pulse.onset - 1) : pulse.onset + 1]
    after = sign * (trial.angle_rad[pulse.onset : pulse.end + 1] - before.mean())
    noise = float(before.std())
    least = max(3.0 * noise, step)
    motion = float(after[np.argmax(np.abs(after))])
    if abs(motion) <= least:
        yield f"the angle does not move in the pulse: {abs(motion):.2g} rad, noise and step are {least:.2g} rad"
        return
    if abs(motion) > (MOST_HELD_RAD if trial.key.grip_target_n > 0.0 else MOST_MOTION_RAD):
        yield f"the angle moves by {abs(motion):.3g} rad in the pulse, more than a hand turns: is it in degrees?"
    if motion < 0.0:
        yield f"{WRONG_SIGN}: the angle moves by {motion:.3g} rad against the torque"
    wander = float(np.ptp([part.mean() for part in np.array_split(before, min(4, before.size))]))
    if wander > max(REST_SHARE * abs(motion), 2.0 * step):
        share = wander / abs(motion)
        yield f"angle not at rest before the pulse: it moves by {wander:.2g} rad, {share:.0%} of the motion"
    if step > 0.0 and abs(motion) / step < FEWEST_COUNTS:
        yield f"encoder too coarse: the motion is {abs(motion) / step:.1f} counts, fewer than {FEWEST_COUNTS}"
    way = math.copysign(1.0, motion) * sign
    held = saturation(trial.time_s, way * trial.angle_rad, pulse.onset, step)
    if held:
        end = way * float(np.max(way * trial.angle_rad[pulse.onset :]))
        yield f"angle at the end of its range, {end:.4g} rad, for {_times(held, 'sample')}: it stops short there"
    freezes = stuck(trial.angle_rad[pulse.onset :])
    if freezes:
        yield f"angle repeats itself during motion {_times(freezes, 'time')}, then jumps: samples were lost"


def _times(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def running_flags(trial: Trial, *, counts_per_rev: float | None = None) -> tuple[str, ...]:
    """What is suspicious about a record, a short sentence each; none if nothing is. As `flags` of a pulse."""
    return (*clock_flags(trial, None), *_sizes(trial, counts_per_rev))


def _sizes(trial: Trial, counts_per_rev: float | None) -> Iterator[str]:
    if not np.any(trial.torque_nm):
        yield "the torque is zero throughout"
    elif np.ptp(trial.torque_nm) == 0.0:
        yield "the torque never changes: inertia shows only where the motion begins"
    moved = float(np.ptp(trial.angle_rad))
    if moved == 0.0:
        yield "the angle never changes"
        return
    finest = quantum(trial.angle_rad)
    step = finest if counts_per_rev is None else 2.0 * math.pi / counts_per_rev
    if 0.0 < finest < FINER * step:
        yield f"the angle changes by {finest:.2g} rad, less than a count of {step:.2g} rad: is counts_per_rev right?"
    if step > 0.0 and moved / step < FEWEST_COUNTS:
        yield f"encoder too coarse: the motion is {moved / step:.1f} counts, fewer than {FEWEST_COUNTS}"
