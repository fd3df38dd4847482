"""`first_order_hold`: mean of the torque and the next one, extrapolated; the last error is added (Ellis et al.)."""

from itertools import pairwise
from typing import Any

import numpy as np

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "first-order hold": {"kind": "first_order_hold", "correct": False},
    "first-order hold, corrected": {"kind": "first_order_hold"},
    "first-order hold, fitted": {"kind": "first_order_hold", "detections": 4},
    "first-order hold, in steps": {"kind": "first_order_hold", "correct": False, "steps": 3},
    "first-order hold, fitted, in steps": {"kind": "first_order_hold", "detections": 3, "steps": 2},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "first_order_hold"},
    {"kind": "first_order_hold", "correct": False},
    {"kind": "first_order_hold", "detections": 4},
    {"kind": "first_order_hold", "detections": 3, "steps": 2},
    {"kind": "first_order_hold", "correct": False, "steps": 3},
]


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        self.promised = self.zero  # mean of the last interval, as it was foretold

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        period, count, steps = self.rig.period, self.detections, self.numbers.get("steps", 1)
        torques = [self.torques[0], *(self.rig.spring(one) for one in looks), self.rig.spring(shown)]
        times = [self.rig.number(k) * period / count for k in range(count + 1)]
        now, anticipated = torques[-1], best_line(times, torques, 2 * period)
        wrong = self.zero
        if self.numbers.get("correct", True):
            area = sum((a + b) / 2 * period / count for a, b in pairwise(torques))
            wrong = area / period - self.promised
        self.promised = (now + anticipated) / 2
        middles = [self.rig.number(2 * k + 1) / (2 * steps) for k in range(steps)]
        return [(now + (anticipated - now) * one + wrong, period / steps) for one in middles]


def best_line(times: list[Any], values: list[Any], at: Any) -> Any:
    """The least-squares line through points, by its normal equations, at a time."""
    n, t, y = len(times), sum(times), sum(values)
    tt, ty = sum(one * one for one in times), sum(a * b for a, b in zip(times, values, strict=True))
    slope = (n * ty - t * y) / (n * tt - t * t)
    return (y - slope * t) / n + slope * at


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.w1 = self.m1 = 0.0

    def block(self) -> list[float]:
        n, steps = self.key.get("detections", 1), self.key.get("steps", 1)
        u = [self.w1, *(self.wall(one) for one in self.looks), self.w]
        ahead = float(np.polyval(np.polyfit(range(n + 1), u, 1), 2 * n))
        m = 0.5 * (self.w + ahead)
        e = sum(0.5 * (u[i] + u[i + 1]) for i in range(n)) / n - self.m1 if self.key.get("correct", True) else 0.0
        self.w1, self.m1 = self.w, m
        return [self.w + (k + 0.5) / steps * (ahead - self.w) + e for k in range(steps)]
