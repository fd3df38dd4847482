"""The samples of one trial as they were received, all blocks in one."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hknob_cli.hardware.port import Array, Block, Counts, Flags


class Samples(NamedTuple):
    """Samples of a trial, arrays (n,) as in a `Block`; ``number`` of each since arming, ``overruns`` in all."""

    number: Counts
    time_us: Counts
    angle_counts: Counts
    torque_nm: Array
    grip_n: Array
    running: Flags
    overruns: int

    def angle_rad(self, native_counts: int) -> Array:
        """Angle by the device's own encoder, rad."""
        return np.asarray(self.angle_counts * (2.0 * math.pi / native_counts), dtype=np.float64)


def joined(blocks: Sequence[Block]) -> Samples:
    """All blocks in one."""
    whole = [np.arange(block.first, block.first + len(block.time_us), dtype=np.int64) for block in blocks]
    return Samples(
        number=np.concatenate([np.empty(0, dtype=np.int64), *whole]),
        time_us=np.concatenate([np.empty(0, dtype=np.int64), *(block.time_us for block in blocks)]),
        angle_counts=np.concatenate([np.empty(0, dtype=np.int64), *(block.angle_counts for block in blocks)]),
        torque_nm=np.concatenate([np.empty(0), *(block.torque_nm for block in blocks)]),
        grip_n=np.concatenate([np.empty(0), *(block.grip_n for block in blocks)]),
        running=np.concatenate([np.empty(0, dtype=bool), *(block.running for block in blocks)]),
        overruns=max((block.overruns for block in blocks), default=0),
    )
