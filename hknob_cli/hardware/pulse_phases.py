"""The course of a trial of a pulse as the host sees it, block by block; nothing in it depends on when blocks arrive.

The host follows the same state machine as the device (`grip_trigger`), on what the device told, and holds the device
to it: a pulse that comes at another sample, or is of another torque or width, is a fault of the device.
"""

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.grip_trigger import GripTrigger, Phase
from hknob_cli.hardware.port import Block, PulseOrder
from hknob_cli.hardware.trial_phases import Ended
from hknob_cli.specs.pulses import Pulses

_SHARE = 1e-6  # by which a torque told in single precision may differ


class PulsePhases:
    """Follows a trial; ``settled_sample`` is the first sample of the pulse, None where there is none."""

    def __init__(self, pulses: Pulses, order: PulseOrder, interval_s: float) -> None:
        """``interval_s`` from sample to sample."""
        self._pulses, self._order, self._interval_s = pulses, order, interval_s
        self._trigger = GripTrigger(order, interval_s)
        self._count = 0
        self._stay_s = 0.0
        self.running_s = 0.0
        self.settled_sample: int | None = None
        self.grip_n = 0.0
        self.torque_nm = 0.0

    @property
    def phase(self) -> Phase:
        """What the trial is at."""
        return self._trigger.phase

    @property
    def phase_s(self) -> float:
        """Time since the pulse fired, or since the start."""
        return self._stay_s

    @property
    def zeroed(self) -> bool:
        """Whether the grip cell was read for long enough."""
        return self._count * self._interval_s >= self._pulses.zero

    def follow(self, block: Block) -> Ended | None:
        """Take the next block; why the trial has ended, None if it has not. Raises `DeviceError`."""
        expected = self._trigger.follow(block.grip_n, block.running)
        self._agree(block, expected)
        self._count += int((~block.running).sum())
        if not block.running.any():
            return None
        span = int(block.running.sum()) * self._interval_s
        self.running_s += span
        self.torque_nm = float(block.torque_nm[-1])
        self.grip_n = float(block.grip_n[block.running].mean()) - self._trigger.zero_n
        if self.settled_sample is None and expected.any():
            self.settled_sample = block.first + int(np.argmax(expected != 0.0))
            self._stay_s = 0.0
        self._stay_s += span
        return self._ended()

    def _agree(self, block: Block, expected: np.ndarray) -> None:
        """Raise `DeviceError` where the torque is not that of the state machine."""
        tripped = ~block.running[-1:] & (self.running_s > 0.0)  # the last sample of a trip has no torque
        checked = slice(0, len(expected) - int(tripped.sum()))
        off = np.abs(block.torque_nm - expected)[checked] > _SHARE * self._order.torque_nm
        if off.any():
            i = int(np.argmax(off))
            raise DeviceError(
                f"the torque is not that of the pulse: {block.torque_nm[i] * 1e3:.4g} mN m, where the grip that the "
                f"device told calls for {expected[i] * 1e3:.4g}, at sample {block.first + i}"
            )

    def _ended(self) -> Ended | None:
        if self.settled_sample is None:
            return Ended.UNFIRED if self.running_s >= self._pulses.timeout else None
        if self.phase is Phase.DONE and self._stay_s > self._pulses.window.after + self._interval_s:
            return Ended.RELEASED
        return Ended.GRIPPING if self._stay_s >= self._pulses.timeout else None
