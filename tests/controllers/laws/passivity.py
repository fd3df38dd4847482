"""`passivity`: Hannaford & Ryu: energy observed, and a damper that takes back what the wall has given out."""

from typing import Any

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "passivity": {"kind": "passivity", "damping": 3.0e-4},
    "passivity, no reset": {"kind": "passivity", "damping": 1.0e-3, "reset": False},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "passivity", "damping": 3.0e-4},
    {"kind": "passivity", "damping": 1.0e-3, "reset": False},
]


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        self.energy = self.zero
        self.held = self.zero

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        torque = self.rig.spring(shown)
        still = shown == before
        self.energy -= self.held * (shown - before)
        if self.energy < 0 and not still:
            speed = (shown - before) / self.rig.period
            damper = min(-self.energy / (speed * speed * self.rig.period), self.numbers["damping"])
            torque -= damper * speed
        if self.numbers.get("reset", True) and still and shown >= 0:
            self.energy = self.zero
        self.held = torque
        return torque


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.E = self.held = 0.0

    def block(self) -> float:
        assert self.th1 is not None
        travel = self.th - self.th1
        self.E = self.E - self.held * travel
        torque = self.w
        if self.E < 0.0 and travel != 0.0:
            damper = min(self.key["damping"], -self.E * self.T / travel**2)
            torque = self.w - damper * travel / self.T
        if self.key.get("reset", True) and self.th >= 0.0 and travel == 0.0:
            self.E = 0.0
        self.held = torque
        return torque
