"""The course of a trial as it happens: when the grip is held, whether the knob buzzes, and when enough is recorded.

The knob buzzes while its torque changes `BUZZ_STEPS_PER_S` times a second or more: against a wall of counts a limit
cycle is fed by steps of torque, two or more a cycle, and the slowest buzz of Chapter 8 has some 40 cycles a second.
"""

from collections import deque
from enum import Enum

import numpy as np

from hknob_cli.hardware.port import Block
from hknob_cli.specs.campaign import Course

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
