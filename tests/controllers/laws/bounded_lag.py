"""`bounded_lag`: the wall, and of its distance to its running mean, up to one count's step, only a part."""

from math import exp
from typing import Any

import numpy as np

from tests import digits as mp
from tests.controllers.page_blocks import K, Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "bounded lag": {"kind": "bounded_lag", "keep": 0.15, "time_constant": 0.02},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "bounded_lag", "keep": 0.15, "time_constant": 0.02},
]


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        self.mean = self.zero

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        now, step = self.rig.spring(shown), self.rig.wall * self.rig.quantum
        ratio = self.rig.period / self.numbers.get("time_constant", self.rig.number(0.2))
        self.mean += (now - self.mean) * (-mp.expm1(-ratio) if self.rig.number is mp.mpf else -np.expm1(-ratio))
        late = min(max(now - self.mean, -step), step)
        return now - (1 - self.numbers.get("keep", self.rig.number(0.2))) * late


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.m = 0.0

    def block(self) -> float:
        a = 1.0 - exp(-self.T / self.key["time_constant"])
        self.m = self.m + a * (self.w - self.m)
        d = min(max(self.w - self.m, -K * self.D), K * self.D)
        return self.w - (1.0 - self.key["keep"]) * d
