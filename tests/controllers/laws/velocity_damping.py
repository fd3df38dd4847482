"""`velocity_damping`: virtual damping beside the spring, on a velocity as firmware has it."""

from math import exp
from typing import Any

import numpy as np

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law, mp

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "damping, differenced": {"kind": "velocity_damping", "damping": 3.0e-4},
    "damping, sensor": {"kind": "velocity_damping", "damping": 1.0e-3, "velocity": "sensor"},
    "damping, negative": {"kind": "velocity_damping", "damping": -1.0e-4, "velocity": "sensor", "everywhere": True},
    "velocity, cut off": {"kind": "velocity_damping", "damping": 1.0e-4, "window": 2, "cut_off": 2.0},
    "velocity, filtered": {"kind": "velocity_damping", "damping": 2.0e-4, "low_pass": 0.004, "everywhere": True},
    "velocity, filtered, cut off": {
        "kind": "velocity_damping",
        "damping": 2.0e-4,
        "window": 3,
        "low_pass": 0.01,
        "cut_off": 2.0,
    },
    "velocity, windowed": {"kind": "velocity_damping", "damping": 3.0e-4, "window": 5},
}
VARIANTS: list[dict[str, Any]] = list(CONTROLLERS.values())


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        self.filtered = self.zero
        self.seen: list[Any] = []

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        window = self.numbers.get("window", 1)
        self.seen = [*(self.seen or [shown] * window), shown][-window - 1 :]
        if window > 1:
            speed = (shown - self.seen[0]) / (window * self.rig.period)
        if "low_pass" in self.numbers:
            whole = mp.exp if self.rig.number is mp.mpf else np.exp
            r = whole(-self.rig.period / self.numbers["low_pass"])
            speed = self.filtered = r * self.filtered + (1 - r) * speed
        if "cut_off" in self.numbers and abs(speed) > self.numbers["cut_off"]:
            return self.zero
        acts = shown < 0 or self.numbers.get("everywhere", False)
        return self.rig.spring(shown) - (self.numbers["damping"] * speed if acts else self.zero)


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.y = 0.0
        self.places: list[float] = []

    def block(self) -> float:
        n = self.key.get("window", 1)
        if not self.places:
            self.places = [self.th] * n
        x = self.v if self.key.get("velocity") == "sensor" else (self.th - self.places[-n]) / (n * self.T)
        self.places.append(self.th)
        if "low_pass" in self.key:
            self.y = self.y + (1.0 - exp(-self.T / self.key["low_pass"])) * (x - self.y)
            x = self.y
        torque = self.w
        if self.th < 0.0 or self.key.get("everywhere", False):
            torque = self.w - self.key["damping"] * x
        return 0.0 if abs(x) > self.key.get("cut_off", float("inf")) else torque
