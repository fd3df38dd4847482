"""Cells with a controller whose sets of starts tests follow."""

from typing import Any

import numpy as np

from hknob_cli.controllers.controller import ControlLaw, make_control_law
from hknob_cli.specs.plan import Starts
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.batches import Batch, make_batch
from tests.controllers.laws import CONTROLLERS

SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}
PHASES = Starts(angle=0.02, velocity=-0.3, phases=1, sampled=False)
BOX = Starts(angle=0.0, velocity=0.0, phases=1, sampled=False, span=(-0.02, 0.02, -1.0, 1.0))
# Controllers whose memory is a function of the counts alone, and piecewise affine.
COUNTING = [
    name for name, one in CONTROLLERS.items() if one.get("velocity") != "sensor" and one.get("estimate") != "kalman"
]
# Encoders and limits under which they are tried.
CHANGES: list[dict[str, Any]] = [
    {},
    {"encoder": {"rounding": "nearest", "offset_counts": 0.3}, "actuator": {"torque_limit": 0.004}},
    {"encoder": {"rounding": "ceil"}, "bias": {"half_quantum": True}},
    {"encoder": {"rounding": "truncate"}},
]


def make_cell(
    name: str,
    starts: Starts = PHASES,
    *,
    rate: float = 1000.0,
    counts: int = 1024,
    change: dict[str, Any] | None = None,
) -> tuple[ControlLaw, Batch, dict[str, Any]]:
    """A controller of `reference.CONTROLLERS`, a cell with it, one lane, and its scene as a spec has it."""
    scene = {**SCENE, **(change or {}), "controller": CONTROLLERS[name]}
    plan = SceneSpec.model_validate(scene).plain()
    assert plan.controller
    cell = {"sample_rate_hz": rate, "counts_per_rev": counts}
    return make_control_law(plan.controller), make_batch(plan, [cell], starts), scene


def phases_of(some: int, seed: int) -> np.ndarray:
    """Random clock phases, and both ends of an interval."""
    return np.concatenate([np.random.default_rng(seed).random(some - 2), [1e-12, 1.0 - 1e-12]])
