"""Random streams: one of its own for every subject, block and trial, so that leaving one out changes no other."""

from enum import IntEnum

import numpy as np


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
