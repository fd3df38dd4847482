"""The course of a trial as it happens: at the wall until enough is recorded, or from pulse to pulse.

The knob buzzes while its torque changes `BUZZ_STEPS_PER_S` times a second or more: against a wall of counts a limit
cycle is fed by steps of torque, two or more a cycle, and the slowest buzz of Chapter 8 has some 40 cycles a second.

Of pulses the host follows the same state machine as the device (`control`), on what the device told, and holds the
device to it: a pulse that comes at another sample, or is of another torque or width, is a fault of the device.
"""

from collections import deque
from enum import Enum

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import GripTrigger
from hknob_cli.hardware.control import Phase as PulsePhase
from hknob_cli.hardware.port import Block, PulseOrder
from hknob_cli.specs.campaign import Course
from hknob_cli.specs.pulses import Pulses

BUZZ_STEPS_PER_S = 20.0
WINDOW_S = 0.2


class Phase(str, Enum):
    """What a trial is at."""

    ZERO = "zero"
    GRIP = "grip"
    BUZZ = "buzz"
    REST = "rest"


class Ended(str, Enum):
    """Why a trial ended."""

    BUZZ = "buzz"
    REST = "rest"
    LONGEST = "longest"
    OPERATOR = "operator"
    OVER = "over"
    RELEASED = "released"  # of a pulse: it came, and the hand relaxed
    GRIPPING = "gripping"  # it came, and the hand did not relax
    UNFIRED = "unfired"  # it did not come


class TrialPhases:
    """Follows a trial block by block; nothing in it depends on when the blocks arrive."""

    def __init__(self, plan: Course, interval_s: float) -> None:
        """``interval_s`` from sample to sample."""
        self._plan = plan
        self._interval_s = interval_s
        self._zero_sum, self._zero_count = 0.0, 0
        self._held_s = self._stay_s = 0.0
        self._recent: deque[tuple[float, int]] = deque()
        self._torque = 0.0
        self.phase = Phase.ZERO
        self.running_s = 0.0
        self.settled_sample: int | None = None
        self.grip_n = 0.0
        self.torque_nm = 0.0

    @property
    def zero_n(self) -> float:
        """Mean of the grip cell before the start."""
        return self._zero_sum / self._zero_count if self._zero_count else 0.0

    @property
    def phase_s(self) -> float:
        """Time for which it has buzzed, or rested."""
        return self._stay_s

    @property
    def zeroed(self) -> bool:
        """Whether the grip cell was read for long enough."""
        return self._zero_count * self._interval_s >= self._plan.zero

    def follow(self, block: Block) -> Ended | None:
        """Take the next block; why the trial has ended, None if it has not."""
        on = block.running
        self._zero_sum += float(block.grip_n[~on].sum()) if self.running_s == 0.0 else 0.0
        self._zero_count += int((~on).sum()) if self.running_s == 0.0 else 0
        if not on.any():
            return None
        span = int(on.sum()) * self._interval_s
        self.running_s += span
        self.torque_nm = float(block.torque_nm[-1])
        steps = int((np.diff(block.torque_nm[on], prepend=self._torque) != 0.0).sum())
        self._torque = self.torque_nm
        self._note_steps(span, steps)
        self.grip_n = float(block.grip_n[on].mean()) - self.zero_n
        if self.settled_sample is None:
            held = self._plan.is_held(self.grip_n)
            self._held_s = self._held_s + span if held else 0.0
            self.phase = Phase.GRIP
            if held and self._held_s >= self._plan.settle:
                self.settled_sample = block.first + on.size
        else:
            self._stay(span)
        return self._ended()

    def _note_steps(self, span: float, steps: int) -> None:
        self._recent.append((span, steps))
        while sum(one for one, _ in self._recent) - self._recent[0][0] >= WINDOW_S:
            self._recent.popleft()

    def _stay(self, span: float) -> None:
        """Go on in the phase, or change it."""
        steps = sum(count for _, count in self._recent) / sum(one for one, _ in self._recent)
        phase = Phase.BUZZ if steps >= BUZZ_STEPS_PER_S else Phase.REST
        self._stay_s = self._stay_s + span if phase is self.phase else span
        self.phase = phase

    def _ended(self) -> Ended | None:
        least, most = self._plan.buzz
        if self.phase is Phase.BUZZ and self._stay_s >= most:
            return Ended.BUZZ
        if self.phase is Phase.REST and self._stay_s >= least:
            return Ended.REST
        return Ended.LONGEST if self.running_s >= self._plan.longest else None


_SHARE = 1e-6  # by which a torque told in single precision may differ


class PulsePhases:
    """Follows a trial; ``settled_sample`` is the first sample of the pulse, None if there is none."""

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
    def phase(self) -> PulsePhase:
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
        if self.phase is PulsePhase.DONE and self._stay_s > self._pulses.window.after + self._interval_s:
            return Ended.RELEASED
        return Ended.GRIPPING if self._stay_s >= self._pulses.timeout else None
