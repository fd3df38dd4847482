"""Whether a recorded trial buzzes, and over which part it does so steadily."""

from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

PAUSE_S = 0.05  # a buzz is no slower than 20 Hz, above a hand's tremor of 8-12 Hz
LEAST_S = 1.0  # "After 1-3 seconds of sustained buzzing" (Hasser, sec. 8.2)
SETTLE_S = 0.5  # first contact, and a grip that is still rising


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
    pause_s: float = PAUSE_S,
    least_s: float = LEAST_S,
    settle_s: float = SETTLE_S,
) -> Buzz:
    """Find the longest buzz in samples of the part of a trial in which the wall was on, arrays (n,).

    ``torque_nm``: commanded, which changes when the knob crosses an edge of the wall's encoder. A trial is *sustained*
    if it changed at least every ``pause_s`` for ``least_s`` without a break, anywhere before the end: a person may let
    go before the trial is stopped. The steady part leaves out the first ``settle_s`` of it.
    """
    changes = np.flatnonzero(np.diff(torque_nm) != 0.0) + 1
    if not changes.size:
        return Buzz()
    breaks = np.flatnonzero(np.diff(time_s[changes]) > pause_s) + 1
    starts = np.concatenate([[0], breaks])
    ends = np.concatenate([breaks, [changes.size]]) - 1
    lengths = time_s[changes[ends]] - time_s[changes[starts]]
    longest = int(lengths.argmax())
    first, last = int(changes[starts[longest]]), int(changes[ends[longest]])
    begin = first + int(np.searchsorted(time_s[first : last + 1], time_s[first] + settle_s))
    sustained = bool(lengths[longest] >= least_s) and last - begin >= 4
    return Buzz(first, min(begin, last), last, sustained)
