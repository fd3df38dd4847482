"""One recorded trial: the keys that say of whom and when it is, its torque pulse, and its stream of random numbers.

Every subject, block and trial has a random stream of its own, so that leaving one out changes no other.
"""

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
    ``acceleration_rad_s2``: of an accelerometer, at each sample, before its torque acts; None where there is none.
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
