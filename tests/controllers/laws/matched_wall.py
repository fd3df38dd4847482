"""`matched_wall`: Full state feedback that puts the poles where those of the continuous wall are, sampled."""

from math import exp
from typing import Any

import numpy as np

from tests import digits as mp
from tests.controllers.page_blocks import STIFF, B, J, K, Page, exponential
from tests.controllers.reference import Law, Rig

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "matched wall": {"kind": "matched_wall"},
    "matched wall, sensor": {"kind": "matched_wall", "velocity": "sensor"},
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "matched_wall"},
    {"kind": "matched_wall", "velocity": "sensor"},
]


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        rig = self.rig
        exact = Rig(rig.scene, rig.rate_hz, rig.counts, mp.mpf, rig.braked)
        (p11, p12, g1), (p21, p22, g2) = exact.hold(exact.period)[:2]
        half = exact.damping / (2 * exact.inertia)
        root = mp.sqrt(mp.mpc(half**2 - (exact.stiffness + exact.wall) / exact.inertia))
        z1, z2 = (mp.exp(s * exact.period) for s in (-half + root, -half - root))
        trace, product = mp.re(z1 + z2), mp.re(z1 * z2)
        # det(zI - Phi + Gamma l): the trace and the determinant of Phi - Gamma l, both linear in l
        left = mp.matrix([[g1, g2], [g1 * p22 - g2 * p12, g2 * p11 - g1 * p21]])
        right = mp.matrix([p11 + p22 - trace, p11 * p22 - p12 * p21 - product])
        self.gains = [rig.number(one) for one in mp.lu_solve(left, right)]

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        return -(self.gains[0] * shown + self.gains[1] * speed) if shown < 0 else self.zero


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        (p11, p12, g1), (p21, p22, g2) = exponential(STIFF, self.T)[:2]
        other = exponential(STIFF + K, self.T)
        product, total = exp(-B * self.T / J), other[0][0] + other[1][1]
        left = [[g1, g2], [g1 * p22 - g2 * p12, g2 * p11 - g1 * p21]]
        right = [p11 + p22 - total, p11 * p22 - p12 * p21 - product]
        self.l1, self.l2 = np.linalg.solve(left, right)

    def block(self) -> float:
        return -(self.l1 * self.th + self.l2 * self.v) if self.th < 0.0 else 0.0
