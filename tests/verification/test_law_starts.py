"""All starts of a knob under a controller beside friction or a delay, against random starts simulated apart.

The plant is that of `friction_starts`, by matrix exponentials; the controllers are those of `tests.controllers.laws`,
written once more from their sources, one for each start. Neither shares code with the package.
"""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.sets.law_search import LawSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import CONTROLLERS
from tests.controllers.reference import Rig, law_of
from tests.engine.general.law_runs import states_with_law

from .friction_starts import FrictionStarts
from .general_scenes import scene

ANGLE, VELOCITY, STARTS = 0.02, 2.0, 300
RUBS = {"coulomb_torque": 2.0e-4}
DETENTS = {"per_revolution": 24, "torque": 3e-3}
NO_WALL = {
    "knob": {"coulomb_torque": 0.0},
    "wall": {"stiffness": 0.0},
    "detents": DETENTS,
    "controller": {"everywhere": True},
}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "lag, friction, late": ("bounded lag", {"knob": RUBS, "actuator": {"delay_samples": 1.0}}),
    "lag, late": ("bounded lag", {"knob": {"coulomb_torque": 0.0}, "actuator": {"delay_samples": 2.0}}),
    "half sample, friction": ("half sample", {"knob": RUBS}),
    "matched wall, late": ("matched wall", {"knob": {"coulomb_torque": 0.0}, "actuator": {"delay_samples": 1.0}}),
    "hold, friction, limit": ("first-order hold", {"knob": RUBS, "actuator": {"torque_limit": 4e-3}}),
    "damping, friction, step": ("damping, differenced", {"knob": RUBS, "actuator": {"torque_step": 1e-4}}),
    "lag, detents": ("bounded lag", {"knob": RUBS, "detents": DETENTS}),
    "damping on detents, late": ("damping, differenced", {**NO_WALL, "actuator": {"delay_samples": 1.0}}),
    "damping on detents, friction": ("damping, differenced", {**NO_WALL, "knob": RUBS}),
}


def settle(parts: dict[str, Any], rate: float, counts: int, samples: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles and speeds of random starts after so many samples."""
    plant, chance = FrictionStarts(parts, rate, counts), np.random.default_rng(3)
    theta, omega = chance.uniform(-ANGLE, ANGLE, STARTS), chance.uniform(-VELOCITY, VELOCITY, STARTS)
    plain = {name: part for name, part in parts.items() if name not in ("controller", "actuator")}
    laws = [law_of(Rig(plain, rate, counts), parts["controller"]) for _ in range(STARTS)]
    line = [np.zeros(STARTS) for _ in range(plant.delay)]
    for _ in range(samples):
        shown = np.floor(theta / plant.quantum) * plant.quantum
        pieces = [law.command(float(at), float(w), []) for law, at, w in zip(laws, shown, omega, strict=True)]
        torque = np.array([one[0][0] for one in pieces])
        if plant.over:
            heard = np.array([not law.silent for law in laws])
            torque += heard * plant.over(np.rint(shown / plant.quantum))
        if plant.step:
            torque = plant.step * np.floor(torque / plant.step + 0.5)
        line.append(np.clip(torque, -plant.limit, plant.limit))
        theta, omega = plant.hold(theta, omega, line.pop(0) - plant.push)
    return theta, omega


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_random_starts_end_in_the_list(name: str) -> None:
    """Each lies, when it has settled, on a listed orbit, or rests in a listed reading."""
    controller, more = CASES[name]
    made_of = scene(**more)
    parts = {**made_of, "controller": {**CONTROLLERS[controller], **made_of.get("controller", {})}}
    rate, counts = 464.0, 256
    made = make_law(SceneSpec.model_validate(parts).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    functions, knob = compiled("friction sets"), made.knob
    engine = LawEngine(made.law, functions)
    box = Box(knob.position(-ANGLE), knob.position(ANGLE), knob.speed(-VELOCITY), knob.speed(VELOCITY))
    found = LawSetEngine(engine.law, functions).search_box(
        knob.body, knob.wall, box, rate=made.rate, delay_line=engine.past_length, max_samples=None
    )
    assert found is not None
    assert found.complete
    theta, omega = settle(parts, rate, counts, int(40.0 / made.rate) + 200)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    near, law = np.zeros(STARTS, dtype=bool), LawEngine(made.law).law
    for one in found.attractors:
        if one.outcome is Outcome.REST:
            near |= (np.abs(v) < 1e-6) & (np.floor(x) == np.floor(one.x))
            continue
        for at_x, at_v in states_with_law(made.knob, law, [one.x, one.v], list(one.line), one.period):
            near |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
    assert near.all(), f"{np.count_nonzero(~near)} starts end elsewhere, the first at {x[~near][0]}, {v[~near][0]}"
