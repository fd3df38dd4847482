"""`impulse_damping`: Section 11.2: the torque-time integral that was wrong since a crossing, given back in a pulse."""

from typing import Any

from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "impulse, whole": {"kind": "impulse_damping", "pulse": 1.0},
    "impulse, short": {"kind": "impulse_damping"},
    "impulse, timed": {"kind": "impulse_damping", "detections": 20, "gain": 0.7},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "impulse_damping"},
    {"kind": "impulse_damping", "pulse": 1.0},
    {"kind": "impulse_damping", "detections": 20, "gain": 0.7},
]


class Source(Law):
    """The controller as its source has it."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        period, count = self.rig.period, self.detections
        now = self.rig.spring(shown)
        torques = [self.torques[0], *(self.rig.spring(one) for one in looks), now]
        wrong = self.zero
        for i in range(count):
            crossed = (i + self.rig.number(1) / 2) * period / count  # on average, before it is seen
            wrong += (torques[i + 1] - torques[i]) * (period - crossed)
        pulse = self.numbers.get("pulse", self.rig.number(0.025)) * period
        high = now + self.numbers.get("gain", 1) * wrong / pulse
        return [(high, pulse), (now, period - pulse)] if pulse < period else high


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.w1 = 0.0

    def block(self) -> list[float]:
        n, pulse = self.key.get("detections", 1), self.key.get("pulse", 0.025)
        u = [self.w1, *(self.wall(one) for one in self.looks), self.w]
        energy = sum((u[i + 1] - u[i]) * (self.T - (i + 0.5) * self.T / n) for i in range(n))
        high = self.w + self.key.get("gain", 1.0) * energy / (pulse * self.T)
        self.w1 = self.w
        return [high, self.w] if pulse < 1.0 else [high]
