"""`phase_damping`: a cosine of the time since the edge was crossed, against the velocity guessed (Section 11.3)."""

from math import cos, pi
from typing import Any

import numpy as np

from tests import digits as mp
from tests.controllers.page_blocks import K, Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "phase, 360": {"kind": "phase_damping"},
    "phase, 90": {"kind": "phase_damping", "degrees": 90.0, "height": 0.8},
    "phase, both": {"kind": "phase_damping", "degrees": 90.0, "crossings": "both"},
    "phase, Kalman": {"kind": "phase_damping", "degrees": 90.0, "crossings": "both", "estimate": "kalman"},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "phase_damping"},
    {"kind": "phase_damping", "degrees": 180.0, "crossings": "both"},
    {"kind": "phase_damping", "degrees": 90.0, "crossings": "both", "estimate": "kalman", "height": 0.8},
]


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        self.mean = self.zero
        self.sample = -1
        self.crossed: dict[bool, int] = {}  # sample of the last way in (True) and out
        self.last: bool | None = None
        self.times: dict[bool, Any] = {}
        self.spread: dict[bool, Any] = {}
        self.was_in = False

    def learn(self, side: bool, time: int) -> None:
        """A time as it is, or into a Kalman filter of a constant that drifts: in information, not in variance."""
        if self.numbers.get("estimate", "last") == "last":
            self.times[side] = time
            return
        one = self.rig.number(1)
        known = one / (self.spread.get(side, 1000 * one) + one / 20)  # of what was predicted
        more = known + 6 * one  # a time between samples is uniform to within one: a sixth
        self.times[side] = (known * self.times.get(side, self.zero) + 6 * time) / more
        self.spread[side] = one / more

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        both = self.numbers.get("crossings", "in") == "both"
        self.sample += 1
        now = self.rig.spring(shown)
        self.mean += (now - self.mean) / 64
        is_in = now > self.mean
        if is_in != self.was_in and (is_in or both):
            if both and self.last is not None:
                self.learn(not is_in, self.sample - self.crossed[self.last])  # time spent on the side that is left
            elif not both and is_in in self.crossed:
                self.learn(is_in, self.sample - self.crossed[is_in])
            self.crossed[is_in], self.last = self.sample, is_in
        self.was_in = is_in
        if self.last is None or self.last not in self.times:
            return now
        since = self.sample - self.crossed[self.last] + self.rig.number(1) / 2
        turn = since / self.times[self.last] / (2 if both else 1)
        if turn > self.numbers.get("degrees", 360.0) / 360:
            return now
        wave = mp.cos(2 * mp.pi * turn) if self.rig.number is mp.mpf else np.cos(2 * np.pi * turn)
        height = self.numbers.get("height", self.rig.number(0.5)) * self.rig.wall * self.rig.quantum
        return now + height * wave * (1 if self.last else -1)


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.m = self.w1 = 0.0
        self.since, self.way = 4096, 0
        self.times = {"A": 0.0, "B": 0.0}
        self.P = {"A": 1000.0, "B": 1000.0}

    def learn(self, x: str) -> None:
        if self.since == 4096:
            return
        if self.key.get("estimate", "last") == "last":
            self.times[x] = self.since
            return
        p = self.P[x] + 0.05
        c = p / (p + 1.0 / 6.0)
        self.times[x] = self.times[x] + c * (self.since - self.times[x])
        self.P[x] = (1.0 - c) * p

    def block(self) -> float:
        m1 = self.m
        self.m = self.m + (self.w - self.m) / 64.0
        self.since = min(self.since + 1, 4096)
        entered = self.w > self.m and self.w1 <= m1
        left = self.w <= self.m and self.w1 > m1
        if self.key.get("crossings", "in") == "in":
            if entered:
                self.learn("A")
                self.way, self.since = 1, 0
            time, sign, both = self.times["A"], 1, 1.0
        else:
            if entered:
                self.learn("B")
            if left:
                self.learn("A")
            if entered:
                self.way, self.since = 1, 0
            if left:
                self.way, self.since = -1, 0
            time, sign, both = self.times["A"] if self.way > 0 else self.times["B"], self.way, 2.0
        self.w1 = self.w
        if not (time > 0.0 and self.way != 0):
            return self.w
        turn = (self.since + 0.5) / (both * time)
        if turn > self.key.get("degrees", 360.0) / 360.0:
            return self.w
        return self.w + self.key.get("height", 0.5) * K * self.D * sign * cos(2.0 * pi * turn)
