"""Torques that are under way to the motor: how long they take, and when in a sample interval each goes out.

`firmware/line.c` has the same operations in the same order.
"""

from collections import deque
from collections.abc import Sequence
from math import floor
from typing import NamedTuple

MOST = 1024  # torques that a target has room for


class Slot(NamedTuple):
    """When in an interval a torque goes out, in parts of it: that of a ``part``, of ``age`` samples ago."""

    begins: float
    age: int
    part: int


def slots_of(begins: Sequence[float], delay_samples: float) -> list[Slot]:
    """The torques of an interval in their order, the first from its begin on; ``begins`` of its parts, from 0."""
    whole = floor(delay_samples)
    split = delay_samples - whole
    found = []
    for late in (1, 0):  # the parts of older torques go on until those of the newer begin
        for i, begin in enumerate(begins):
            at, end = begin + split - late, (begins[i + 1] if i + 1 < len(begins) else 1.0) + split - late
            if at < 1.0 and end > 0.0:
                found.append(Slot(max(at, 0.0), whole + late, i))
    return found


def room_of(parts: int, delay_samples: float) -> int:
    """How many torques a target keeps for such a delay."""
    return (floor(delay_samples) + 2) * parts


class TorqueLine:
    """Torques under way in a trial, none at first."""

    def __init__(self, begins: Sequence[float], delay_samples: float) -> None:
        self._slots = slots_of(begins, delay_samples)
        self.begins = tuple(slot.begins for slot in self._slots)
        rows = floor(delay_samples) + 2
        self._rows: deque[Sequence[float]] = deque([(0.0,) * len(begins)] * rows, maxlen=rows)

    def put(self, torques: Sequence[float]) -> list[float]:
        """Take the torques of a sample, one a part; those that go out until the next, one a slot."""
        self._rows.appendleft(torques)
        return [self._rows[slot.age][slot.part] for slot in self._slots]
