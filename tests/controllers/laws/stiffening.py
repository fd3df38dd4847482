"""`stiffening`: Section 11: a stiffness that rises with depth."""

from typing import Any

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "stiffening": {"kind": "stiffening", "depth": 0.02},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "stiffening", "depth": 0.02},
]


class Source(Law):
    """The controller as its source has it."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        surface = self.numbers.get("surface", self.rig.number(0.3))
        part = min(-shown / self.numbers.get("depth", self.rig.number(0.01)), self.rig.number(1))
        return self.rig.spring(shown) * (surface + (1 - surface) * part)


class Block(Page):
    """The page's block."""

    def block(self) -> float:
        surface = self.key.get("surface", 0.3)
        return self.w * (surface + (1.0 - surface) * min(-self.th / self.key.get("depth", 0.01), 1.0))
