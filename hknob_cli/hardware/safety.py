"""The host's own watch over a trial: what is sent must be within the limits, in order, and not cease."""

import math

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block, Settings

SILENCE_S = 0.1  # without samples, after which the link is taken for dead
_SLACK = 1.01  # a limit and what is measured by a clock and an encoder are not equal to the last digit


class Watch:
    """Checks blocks as they come; ``gaps`` counts samples whose index is missing."""

    def __init__(self, settings: Settings, native_counts: int) -> None:
        self._settings = settings
        self._count_rad = 2.0 * math.pi / native_counts
        self._last: tuple[int, int, int] | None = None  # index, time and angle of the last sample
        self.gaps = 0

    def check(self, block: Block) -> None:
        """Look at a block. Raises `DeviceError` naming what is beyond its limit, and at which sample."""
        if not len(block.time_us):
            return
        limit = self._settings.torque_limit_nm
        self._refuse(~np.isfinite(block.torque_nm), block, "the torque is not a number")
        self._refuse(~np.isfinite(block.grip_n), block, "the grip force is not a number")
        what = f"the torque is beyond the limit of {limit:g} N m"
        self._refuse(np.abs(block.torque_nm) > limit * _SLACK, block, what)
        index, time_us, angle = self._last or (block.first - 1, int(block.time_us[0]), int(block.angle_counts[0]))
        self.gaps += max(0, block.first - index - 1)
        passed = np.diff(block.time_us, prepend=time_us) * 1e-6
        self._refuse(passed < 0.0, block, "the device's clock runs backwards")
        moved = np.abs(np.diff(block.angle_counts, prepend=angle)) * self._count_rad
        # A sample that is late is not told from a fast knob by its index: the speed is over the time that passed.
        most = self._settings.speed_limit_rad_s * np.maximum(passed, self._settings.interval_s)
        what = f"the knob is faster than the limit of {self._settings.speed_limit_rad_s:g} rad/s"
        self._refuse(moved > most * _SLACK + self._count_rad, block, what)
        last = block.first + len(block.time_us) - 1
        self._last = last, int(block.time_us[-1]), int(block.angle_counts[-1])

    def _refuse(self, bad: np.ndarray[tuple[int], np.dtype[np.bool_]], block: Block, what: str) -> None:
        if bad.any():
            raise DeviceError(f"{what}, at sample {block.first + int(np.argmax(bad))}")
