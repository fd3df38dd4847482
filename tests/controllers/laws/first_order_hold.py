"""`first_order_hold`: mean of the torque and the next one, extrapolated; the last error is added (Ellis et al.)."""

from typing import Any

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "first-order hold": {"kind": "first_order_hold", "correct": False},
    "first-order hold, corrected": {"kind": "first_order_hold"},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "first_order_hold"},
    {"kind": "first_order_hold", "correct": False},
]


class Source(Law):
    """The controller as its source has it."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        now, (last, earlier) = self.rig.spring(shown), self.torques
        anticipated = now + (now - last)
        torque = (now + anticipated) / 2
        if self.numbers.get("correct", True):
            was_anticipated = last + (last - earlier)
            torque += (last + now) / 2 - (last + was_anticipated) / 2
        return torque


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.w1 = self.w2 = 0.0

    def block(self) -> float:
        torque = 1.5 * self.w - 0.5 * self.w1
        if self.key.get("correct", True):
            torque = torque + 0.5 * (self.w + self.w1) - (1.5 * self.w1 - 0.5 * self.w2)
        self.w2 = self.w1
        self.w1 = self.w
        return torque
