"""Samples that repeat: a sensor at the end of its range, or samples that were lost, told from a motion that turns."""

import numpy as np

from hknob_cli.recordings.trial import Array

FEWEST_HELD = 10
_RUN_UP_S = 5e-4
_FEWEST_RUN_UP = 3
_FREE_FALL_S = 5e-3
_MARGIN = 4.0
_FAST = 5.0


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
