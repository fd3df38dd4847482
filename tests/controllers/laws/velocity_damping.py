"""`velocity_damping`: virtual damping beside the spring."""

from typing import Any

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "damping, differenced": {"kind": "velocity_damping", "damping": 3.0e-4},
    "damping, sensor": {"kind": "velocity_damping", "damping": 1.0e-3, "velocity": "sensor"},
    "damping, negative": {"kind": "velocity_damping", "damping": -1.0e-4, "velocity": "sensor", "everywhere": True},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "velocity_damping", "damping": 3.0e-4},
    {"kind": "velocity_damping", "damping": 1.0e-3, "velocity": "sensor"},
    {"kind": "velocity_damping", "damping": -1.0e-4, "velocity": "sensor", "everywhere": True},
]


class Source(Law):
    """The controller as its source has it."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        acts = shown < 0 or self.numbers.get("everywhere", False)
        return self.rig.spring(shown) - (self.numbers["damping"] * speed if acts else self.zero)


class Block(Page):
    """The page's block."""

    def block(self) -> float:
        acts = self.th < 0.0 or self.key.get("everywhere", False)
        return self.w - self.key["damping"] * self.v if acts else 0.0
