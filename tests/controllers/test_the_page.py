"""docs/controllers.md is enough to build each controller: its blocks in plain Python, against the engine's torques.

Nothing below is from the package or from the other reference; every class is one block of the page, in SI units.
"""

from collections.abc import Callable
from math import cos, exp, pi
from typing import Any

import mpmath
import numpy as np
import pytest

from hknob_cli.controllers.batch_stepper import BatchStepper
from hknob_cli.controllers.catalogue import make_remedy
from hknob_cli.controllers.cells import make_batch
from hknob_cli.specs.controller import KEYS
from hknob_cli.specs.plan import Starts
from hknob_cli.specs.scene import SceneSpec
from tests.conftest import ROOT

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


class BoundedLag(Page):
    def first(self) -> None:
        self.m = 0.0

    def block(self) -> float:
        a = 1.0 - exp(-self.T / self.key["time_constant"])
        self.m = self.m + a * (self.w - self.m)
        d = min(max(self.w - self.m, -K * self.D), K * self.D)
        return self.w - (1.0 - self.key["keep"]) * d


class FirstOrderHold(Page):
    def first(self) -> None:
        self.w1 = self.w2 = 0.0

    def block(self) -> float:
        torque = 1.5 * self.w - 0.5 * self.w1
        if self.key.get("correct", True):
            torque = torque + 0.5 * (self.w + self.w1) - (1.5 * self.w1 - 0.5 * self.w2)
        self.w2 = self.w1
        self.w1 = self.w
        return torque


class HalfSample(Page):
    def first(self) -> None:
        self.p, self.q, self.g = exponential(STIFF, self.T / 2.0)[0]

    def block(self) -> float:
        free = self.p * self.th + self.q * self.v
        return -K * free / (1.0 + K * self.g) if free < 0.0 else 0.0


class MatchedWall(Page):
    def first(self) -> None:
        (p11, p12, g1), (p21, p22, g2) = exponential(STIFF, self.T)[:2]
        other = exponential(STIFF + K, self.T)
        product, total = exp(-B * self.T / J), other[0][0] + other[1][1]
        left = [[g1, g2], [g1 * p22 - g2 * p12, g2 * p11 - g1 * p21]]
        right = [p11 + p22 - total, p11 * p22 - p12 * p21 - product]
        self.l1, self.l2 = np.linalg.solve(left, right)

    def block(self) -> float:
        return -(self.l1 * self.th + self.l2 * self.v) if self.th < 0.0 else 0.0


class ImpulseDamping(Page):
    def first(self) -> None:
        self.w1 = 0.0

    def block(self) -> list[float]:
        n, pulse = self.key.get("detections", 1), self.key.get("pulse", 0.025)
        u = [self.w1, *(self.wall(one) for one in self.looks), self.w]
        energy = sum((u[i + 1] - u[i]) * (self.T - (i + 0.5) * self.T / n) for i in range(n))
        high = self.w + self.key.get("gain", 1.0) * energy / (pulse * self.T)
        self.w1 = self.w
        return [high, self.w] if pulse < 1.0 else [high]


class PhaseDamping(Page):
    def first(self) -> None:
        self.m = self.w1 = 0.0
        self.since, self.way = 4096, 0
        self.times = {"A": 0.0, "B": 0.0}
        self.P = {"A": 1000.0, "B": 1000.0}

    def learn(self, x: str) -> None:
        if self.since == 4096:
            return
        if self.key.get("estimate", "last") == "last":
            self.times[x] = self.since
            return
        p = self.P[x] + 0.05
        c = p / (p + 1.0 / 6.0)
        self.times[x] = self.times[x] + c * (self.since - self.times[x])
        self.P[x] = (1.0 - c) * p

    def block(self) -> float:
        m1 = self.m
        self.m = self.m + (self.w - self.m) / 64.0
        self.since = min(self.since + 1, 4096)
        entered = self.w > self.m and self.w1 <= m1
        left = self.w <= self.m and self.w1 > m1
        if self.key.get("crossings", "in") == "in":
            if entered:
                self.learn("A")
                self.way, self.since = 1, 0
            time, sign, both = self.times["A"], 1, 1.0
        else:
            if entered:
                self.learn("B")
            if left:
                self.learn("A")
            if entered:
                self.way, self.since = 1, 0
            if left:
                self.way, self.since = -1, 0
            time, sign, both = self.times["A"] if self.way > 0 else self.times["B"], self.way, 2.0
        self.w1 = self.w
        if not (time > 0.0 and self.way != 0):
            return self.w
        turn = (self.since + 0.5) / (both * time)
        if turn > self.key.get("degrees", 360.0) / 360.0:
            return self.w
        return self.w + self.key.get("height", 0.5) * K * self.D * sign * cos(2.0 * pi * turn)


class VelocityDamping(Page):
    def block(self) -> float:
        acts = self.th < 0.0 or self.key.get("everywhere", False)
        return self.w - self.key["damping"] * self.v if acts else 0.0


class Passivity(Page):
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


class Stiffening(Page):
    def block(self) -> float:
        surface = self.key.get("surface", 0.3)
        return self.w * (surface + (1.0 - surface) * min(-self.th / self.key.get("depth", 0.01), 1.0))


BLOCKS: dict[str, Callable[..., Page]] = {
    "bounded_lag": BoundedLag,
    "first_order_hold": FirstOrderHold,
    "half_sample": HalfSample,
    "impulse_damping": ImpulseDamping,
    "matched_wall": MatchedWall,
    "passivity": Passivity,
    "phase_damping": PhaseDamping,
    "stiffening": Stiffening,
    "velocity_damping": VelocityDamping,
}
VARIANTS: list[dict[str, Any]] = [
    {"kind": "bounded_lag", "keep": 0.15, "time_constant": 0.02},
    {"kind": "first_order_hold"},
    {"kind": "first_order_hold", "correct": False},
    {"kind": "half_sample"},
    {"kind": "half_sample", "velocity": "sensor"},
    {"kind": "matched_wall"},
    {"kind": "matched_wall", "velocity": "sensor"},
    {"kind": "impulse_damping"},
    {"kind": "impulse_damping", "pulse": 1.0},
    {"kind": "impulse_damping", "detections": 20, "gain": 0.7},
    {"kind": "phase_damping"},
    {"kind": "phase_damping", "degrees": 180.0, "crossings": "both"},
    {"kind": "phase_damping", "degrees": 90.0, "crossings": "both", "estimate": "kalman", "height": 0.8},
    {"kind": "velocity_damping", "damping": 3.0e-4},
    {"kind": "velocity_damping", "damping": 1.0e-3, "velocity": "sensor"},
    {"kind": "velocity_damping", "damping": -1.0e-4, "velocity": "sensor", "everywhere": True},
    {"kind": "passivity", "damping": 3.0e-4},
    {"kind": "passivity", "damping": 1.0e-3, "reset": False},
    {"kind": "stiffening", "depth": 0.02},
]
CELLS = [(1000.0, 360, 0.0), (1000.0, 2650, -0.4), (3000.0, 1024, -1.0)]
SAMPLES = 400


@pytest.mark.parametrize("cell", CELLS, ids=str)
@pytest.mark.parametrize("controller", VARIANTS, ids=lambda one: " ".join(map(str, one.values())))
def test_a_controller_built_from_the_page_gives_the_engines_torques(
    controller: dict[str, Any], cell: tuple[float, int, float]
) -> None:
    rate, counts, velocity = cell
    plan = SceneSpec.model_validate({**SCENE, "controller": controller}).plain()
    assert plan.controller
    remedy = make_remedy(plan.controller)
    key = {"sample_rate_hz": rate, "counts_per_rev": counts}
    batch = make_batch(plan, [key], Starts(angle=0.02, velocity=velocity, phases=1))
    mover = BatchStepper(remedy, batch.lanes)
    state = mover.start(batch.x, batch.v)
    page = BLOCKS[controller["kind"]](counts, rate, **{name: one for name, one in controller.items() if name != "kind"})
    count = 2.0 * pi / counts
    acts = 0
    for k in range(SAMPLES):
        angle = float(np.floor(state.x[0])) * count
        omega = float(state.v[0]) * count * rate
        looks = [] if state.seen is None else [float(one) * count for one in state.seen[:, 0]]
        step = mover.step(state)
        ours = [float((one[0] + batch.lanes.gamma[0]) / batch.lanes.kappa[0]) * K * count for one in step.drives]
        theirs = page.sample(angle, omega, looks)
        # A torque is a sum of at most a few dozen products, each rounded; the terms are at most as large as the wall's
        # torque and a count's, or as the velocity with the gain that acts on it.
        gain = abs(getattr(page, "l2", 0.0)) + abs(controller.get("damping", 0.0)) + K / rate
        size = K * (abs(angle) + count) * 40.0 + gain * (abs(page.v) + abs(omega))
        bound = 200 * np.finfo(float).eps * size
        assert len(ours) == len(theirs)
        for one, other in zip(ours, theirs, strict=True):
            assert abs(one - other) <= bound, (k, one, other)
        acts += any(abs(one - page.w) > 1e-9 for one in theirs)
        state = step.state
    assert acts > 10, "says little of a controller that never differs from the plain wall"


def test_the_page_has_a_block_for_every_kind() -> None:
    text = (ROOT / "docs" / "controllers.md").read_text()
    assert set(BLOCKS) == set(KEYS)
    for kind, keys in KEYS.items():
        block = text.partition(f"### {kind}\n```text\n")[2].partition("```")[0]
        assert block, kind
        said = block.replace("velocity", "") + (" velocity" if " v" in block else "")
        for key in keys:
            assert key in said, (kind, key)


def test_the_energy_sum_begins_anew_only_outside_and_with_no_count_moved() -> None:
    """What the page says in words, of the engine itself: debt is kept while the free knob moves, and damped there."""
    plan = SceneSpec.model_validate({**SCENE, "controller": {"kind": "passivity", "damping": 3.0e-4}}).plain()
    assert plan.controller
    remedy = make_remedy(plan.controller)
    key = {"sample_rate_hz": 1000.0, "counts_per_rev": 1024}
    lanes = make_batch(plan, [key], Starts(angle=0.02, velocity=0.0, phases=1)).lanes
    fixed = remedy.constants(lanes)

    def act(count: float, memory: Any) -> Any:
        from hknob_cli.controllers.controller import Reading

        return remedy.act(Reading(np.array([count]), np.array([max(0.0, -count)]), None, None), memory, fixed)

    owed = np.array([[1.0], [0.0], [-0.5]])  # at count 1, no torque held, half a step times a count owed
    moving = act(2.0, owed)
    assert moving.torques[0][0] < 0.0  # against the motion, outside the wall
    assert moving.memory[2][0] == -0.5
    still = act(1.0, owed)
    assert still.torques[0][0] == 0.0
    assert still.memory[2][0] == 0.0
    inside = act(-2.0, np.array([[-2.0], [0.0], [-0.5]]))
    assert inside.memory[2][0] == -0.5
