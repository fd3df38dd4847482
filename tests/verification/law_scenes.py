"""Random scenes under a controller, each with three features or more, and what the package finds in them."""

from typing import Any, NamedTuple

import numpy as np

from hknob_cli.controllers.scalar_law import LawKnob, make_law
from hknob_cli.engine.attractors import Attractor, Patience
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY

from .general_scenes import GRASP, TWO_PARTS, scene

FOR_EVER = Patience(samples=2**50)

FEATURES = ("friction", "viscous", "finger", "delay", "lag", "limit", "step", "virtual damping", "rounding", "offset")


class Drawn(NamedTuple):
    """A scene with its clock; ``features``: what it has beside the controller."""

    controller: str
    features: tuple[str, ...]
    scene: dict[str, Any]
    rate_hz: float
    counts: int


def draw(numbers: np.random.Generator, controller: str) -> Drawn:
    """A scene with three to six features, of which friction, delay, lag or finger is one."""
    few = set(numbers.choice(["friction", "delay", "lag", "finger"], 1))
    few |= set(numbers.choice(FEATURES, int(numbers.integers(2, 6)), replace=False))
    while len(few) < 3:
        few.add(str(numbers.choice(FEATURES)))
    knob: dict[str, Any] = {"inertia": 1.98e-6, "damping": 0.0}
    actuator: dict[str, Any] = {}
    encoder: dict[str, Any] = {}
    wall: dict[str, Any] = {"stiffness": 0.27}
    if "friction" in few:
        knob["coulomb_torque"] = float(10.0 ** numbers.uniform(-5.5, -3.0))
    if "viscous" in few:
        knob["damping"] = float(10.0 ** numbers.uniform(-6.0, -4.5))
    if "delay" in few:
        actuator["delay_samples"] = float(numbers.choice([0.3, 0.5, 1.0, 1.4, 2.0]))
    if "lag" in few:
        actuator["time_constant"] = float(10.0 ** numbers.uniform(-4.5, -3.3))
    if "limit" in few:
        actuator["torque_limit"] = float(numbers.uniform(0.0015, 0.006))
    if "step" in few:
        actuator["torque_step"] = float(10.0 ** numbers.uniform(-5.0, -3.7))
    if "virtual damping" in few:
        wall["damping"] = float(10.0 ** numbers.uniform(-6.0, -4.7))
    if "rounding" in few:
        encoder["rounding"] = str(numbers.choice(["nearest", "ceil", "truncate"]))
    if "offset" in few:
        encoder["offset_counts"] = float(numbers.uniform(0.0, 0.99))
    made = scene(
        knob=knob,
        hand=TWO_PARTS if "finger" in few else GRASP,
        wall=wall,
        actuator=actuator,
        encoder=encoder or None,
        bias={"half_quantum": True} if numbers.random() < 0.3 else {"torque": 0.001},
    )
    made["controller"] = dict(EVERY[controller])
    rate, counts = float(numbers.choice([464.0, 1000.0, 2154.0])), int(numbers.choice([256, 512, 1024, 2048]))
    return Drawn(controller, tuple(sorted(few)), made, rate, counts)


def reduce(one: Drawn) -> LawKnob:
    """The cell of a drawn scene."""
    plain = reduced(SceneSpec.model_validate(one.scene).plain())
    return make_law(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)


def search(
    one: Drawn, made: LawKnob, phases: int = 4, *, in_code: bool = True
) -> tuple[LawEngine, tuple[Attractor, ...]]:
    """What trials from 20 mrad settle to, and the engine that found it; ``in_code``: a compiled one."""
    engine = LawEngine(made.law, compiled("laws") if in_code else None, patience=FOR_EVER)
    found = engine.search(
        made.knob.body,
        made.knob.wall,
        made.knob.start(0.02, 0.0),
        rate=made.rate,
        phases=phases,
        delay_line=engine.past_length,
        max_samples=2**16,
    )
    return engine, found.attractors
