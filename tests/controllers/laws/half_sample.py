"""`half_sample`: the wall's torque where the model is half an interval ahead (Gillespie & Cutkosky)."""

from typing import Any

from tests.controllers.page_blocks import STIFF, K, Page, exponential
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "half sample": {"kind": "half_sample"},
    "half sample, sensor": {"kind": "half_sample", "velocity": "sensor"},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "half_sample"},
    {"kind": "half_sample", "velocity": "sensor"},
]


class Source(Law):
    """The controller as its source has it."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        row = self.rig.hold(self.rig.period / 2)[0]
        free = row[0] * shown + row[1] * speed
        # torque u = -K (free + row[2] u) inside
        return -self.rig.wall * free / (1 + self.rig.wall * row[2]) if free < 0 else self.zero


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.p, self.q, self.g = exponential(STIFF, self.T / 2.0)[0]

    def block(self) -> float:
        free = self.p * self.th + self.q * self.v
        return -K * free / (1.0 + K * self.g) if free < 0.0 else 0.0
