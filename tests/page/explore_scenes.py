"""Random knobs for the engine of the explore page, and the program's own trial of each, by the interpreter."""

import json
import random
from math import exp, log
from typing import Any

from hknob_cli.engine.attractors import Patience
from hknob_cli.engine.propagator import slowest_rate
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load_text
from hknob_cli.specs.plan import COUNTS, RATE, SweepPlan, scene_at
from hknob_cli.stages.sweep.cell import CellFinder, CellResult

Scene = dict[str, Any]
RADIUS_M = 8.9e-3
FOR_EVER = Patience(samples=2**50)
CONTROLLERS = ("bounded_lag", "first_order_hold", "half_sample", "matched_wall", "stiffening", "velocity_damping")
OTHERS = ("plain", "virtual damping", "rounding", "delay", "amplifier")


def _controller(kind: str, chance: random.Random, scene: Scene) -> dict[str, Any]:
    period = 1.0 / scene["rate"]
    numbers: dict[str, Any] = {
        "bounded_lag": {"keep": chance.uniform(0.1, 0.9), "time_constant": spread(chance, 0.02, 0.3)},
        "first_order_hold": {"correct": chance.random() < 0.5},
        "half_sample": {},
        "matched_wall": {},
        "stiffening": {"surface": chance.uniform(0.1, 0.9), "depth": spread(chance, 0.002, 0.05)},
        "velocity_damping": {
            "damping": scene["stiffness"] * period * chance.uniform(0.1, 1.0),
            "window": chance.choice([1, 1, 3]),
            "low_pass": chance.choice([0.0, spread(chance, 1.0, 20.0) * period]),
            "everywhere": chance.random() < 0.3,
        },
    }
    return {"kind": kind, **numbers[kind]}


def spread(chance: random.Random, low: float, high: float) -> float:
    """Evenly over the logarithm."""
    return low * exp(chance.random() * log(high / low))


def random_scene(chance: random.Random, remedy: str) -> Scene:
    """A knob, light to heavy, soft to stiff, with or without hand and friction, as the page has it."""
    held = chance.random() < 0.85
    scene: Scene = {
        "inertia": spread(chance, 5e-7, 5e-5),
        "damping": 0.0 if held and chance.random() < 0.5 else spread(chance, 2e-5, 5e-4),
        "friction": spread(chance, 2e-5, 5e-4) if chance.random() < 0.3 else 0.0,
        "hand": None,
        "stiffness": spread(chance, 0.05, 5.0),
        "wallDamping": 0.0,
        "push": spread(chance, 2e-4, 5e-3),
        "halfQuantum": chance.random() < 0.1,
        "rate": round(spread(chance, 200, 10000)),
        "counts": round(spread(chance, 128, 8192)),
        "rounding": "floor",
        "offset": 0.0,
        "delay": 0.0,
        "limit": None,
        "step": 0.0,
        "band": 0.0,
        "controller": None,
        "start": {
            "angle": chance.uniform(-0.02, 0.04),
            "velocity": chance.choice([0.0, chance.uniform(-1, 1)]),
            "phase": 0.5,
        },
    }
    if held:
        scene["hand"] = {
            "inertia": spread(chance, 1e-7, 1e-6),
            "damping": spread(chance, 1e-4, 2e-3),
            "stiffness": spread(chance, 0.01, 0.3),
        }
    if remedy in CONTROLLERS:
        scene["controller"] = _controller(remedy, chance, scene)
    elif remedy == "virtual damping":
        scene["wallDamping"] = scene["stiffness"] / scene["rate"] * chance.uniform(0.1, 1.0)
    elif remedy == "rounding":
        scene["rounding"] = chance.choice(["nearest", "ceil", "truncate"])
        scene["offset"] = chance.choice([0.0, 0.99 * chance.random()])
    elif remedy == "delay":
        scene["delay"] = chance.choice([0.5, 1.0, 1.25, 2.0])
    elif remedy == "amplifier":
        scene["limit"], scene["step"] = spread(chance, 2e-3, 2e-2), chance.choice([0.0, 1e-4])
        scene["band"] = chance.choice([0.0, 2e-4])
    return scene


def spec_of(scene: Scene) -> dict[str, Any]:
    """The sweep of one trial from the same start at the same phase."""
    parts: dict[str, Any] = {
        "knob": {"inertia": scene["inertia"], "damping": scene["damping"], "coulomb_torque": scene["friction"]},
        "wall": {"stiffness": scene["stiffness"], "damping": scene["wallDamping"]},
        "bias": {"half_quantum": True} if scene["halfQuantum"] else {"torque": scene["push"]},
        "encoder": {"rounding": scene["rounding"], "offset_counts": scene["offset"]},
        "actuator": {
            "delay_samples": scene["delay"],
            "torque_limit": scene["limit"],
            "torque_step": scene["step"],
            "dead_band": scene["band"],
        },
        **({"hand": scene["hand"]} if scene["hand"] else {}),
        **({"controller": scene["controller"]} if scene["controller"] else {}),
    }
    start = scene["start"]
    return {
        "kind": "sweep",
        "name": "one",
        "scene": parts,
        "grid": {"sample_rate_hz": scene["rate"], "counts_per_rev": scene["counts"]},
        "starts": {"angle": start["angle"], "velocity": start["velocity"], "phases": 1},
        "perceive": {"knob_radius": RADIUS_M},
    }


def plan_of(scene: Scene) -> SweepPlan:
    plan = load_text(json.dumps(spec_of(scene)), "scene")
    assert isinstance(plan, SweepPlan)
    return plan


def trial_of(plan: SweepPlan) -> CellResult:
    """The program's own trial, interpreted: nothing is compiled."""
    return CellFinder({}, patience=lambda _group: FOR_EVER).find(plan, next(iter(cells_of(plan))))


def is_quick(plan: SweepPlan) -> bool:
    """Whether its slowest mode has settled in 300 samples, so that the interpreter follows it in no time."""
    cell = next(iter(cells_of(plan)))
    loop = sample_knob(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS])).loop
    control = plan.scene.controller
    lasting = max(control.time_constant, control.low_pass) * cell[RATE] if control else 0.0
    return slowest_rate(loop.alpha, loop.beta) > 0.03 and lasting < 100.0
