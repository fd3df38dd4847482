"""What docs/reference/controllers.md says before its blocks: readings, and what is known of them, in SI units."""

from math import pi
from typing import Any

import mpmath

J, B, STIFF = 1.9e-6 + 3.0e-7, 3.45e-4, 0.04
K = 0.27
SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": B, "stiffness": STIFF},
    "wall": {"stiffness": K},
    "bias": {"torque": 0.001},
}


class Page:
    """What the page says before the blocks: readings, and what is known of them."""

    def __init__(self, counts: int, rate: float, **keys: Any) -> None:
        """The variables' first values."""
        self.D, self.T = 2.0 * pi / counts, 1.0 / rate
        self.key = keys
        self.th1: float | None = None
        self.first()

    def first(self) -> None:
        """No variables."""

    def wall(self, th: float) -> float:
        return -K * th if th < 0.0 else 0.0

    def sample(self, th: float, omega: float, looks: list[float]) -> list[float]:
        """Torques held from this sample on."""
        if self.th1 is None:
            self.th1 = th
        self.th, self.w, self.looks = th, self.wall(th), looks
        self.v = omega if self.key.get("velocity") == "sensor" else (th - self.th1) / self.T
        torque = self.block()
        self.th1 = th
        return torque if isinstance(torque, list) else [torque]

    def block(self) -> Any:
        raise NotImplementedError


def exponential(stiffness: float, time: float) -> list[list[float]]:
    """exp(A t), to all digits."""
    with mpmath.workdps(40):
        a = mpmath.matrix([[0, 1, 0], [-mpmath.mpf(stiffness) / J, -mpmath.mpf(B) / J, 1 / mpmath.mpf(J)], [0, 0, 0]])
        return [[float(one) for one in row] for row in mpmath.expm(a * time).tolist()]
