"""All starts of a knob under a controller beside friction, a delay or a lag, against random starts simulated apart.

The plant is that of `friction_starts`, by matrix exponentials; the controllers are those of `tests.controllers.laws`,
written once more from their sources, one for each start. Neither shares code with the package. Where a controller reads
its encoder within an interval, the plant goes from look to look.
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
from tests.controllers.laws import EVERY
from tests.controllers.reference import Rig, law_of
from tests.engine.general.law_runs import states_with_law

from .general_scenes import scene
from .lagged_starts import starts_of

ANGLE, VELOCITY, STARTS = 0.02, 2.0, 300
RUBS, SMOOTH = {"coulomb_torque": 2.0e-4}, {"coulomb_torque": 0.0}
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
    "windowed, friction, late": ("velocity, windowed", {"knob": RUBS, "actuator": {"delay_samples": 1.0}}),
    "timed, late": ("speed, timed", {"knob": SMOOTH, "actuator": {"delay_samples": 1.0}}),
    "timed, looks": ("speed, timed, filtered", {"knob": SMOOTH, "actuator": {"torque_limit": 6e-3}}),
    "adaptive, friction": ("speed, adaptive", {"knob": RUBS}),
    "adaptive, low-pass, lag": (
        "speed, adaptive, filtered",
        {"knob": SMOOTH, "actuator": {"delay_samples": 1.0, "time_constant": 1e-4}},
    ),
    "tracked, friction, late": ("speed, tracked", {"knob": RUBS, "actuator": {"delay_samples": 1.0}}),
    "angle tracked, late": ("speed and angle, tracked", {"knob": SMOOTH, "actuator": {"delay_samples": 1.0}}),
    "Kalman, friction": ("speed, Kalman", {"knob": RUBS}),
    "Kalman, lag, step": (
        "speed, Kalman",
        {"knob": SMOOTH, "actuator": {"time_constant": 2e-4, "torque_step": 1e-4}},
    ),
    "angle filtered, friction": ("angle, filtered", {"knob": RUBS, "actuator": {"torque_limit": 4e-3}}),
    "both filtered, late": ("speed and angle, filtered", {"knob": SMOOTH, "actuator": {"delay_samples": 1.0}}),
    "phase by Kalman, late": ("phase, Kalman", {"knob": SMOOTH, "actuator": {"delay_samples": 1.0}}),
}


def settle(parts: dict[str, Any], rate: float, counts: int, samples: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles and speeds of random starts after so many samples."""
    looks, chance = parts["controller"].get("detections", 1), np.random.default_rng(3)
    plant = starts_of(parts, looks * rate, counts)  # its interval is from one look to the next
    theta, omega = chance.uniform(-ANGLE, ANGLE, STARTS), chance.uniform(-VELOCITY, VELOCITY, STARTS)
    plain = {name: part for name, part in parts.items() if name not in ("controller", "actuator")}
    laws = [law_of(Rig(plain, rate, counts), parts["controller"]) for _ in range(STARTS)]
    line = [np.zeros(STARTS) for _ in range(plant.delay)]
    seen: list[NDArray[Any]] = []
    for _ in range(samples):
        shown = np.floor(theta / plant.quantum) * plant.quantum
        seen = seen or [shown] * (looks - 1)
        read = np.array(seen).reshape(looks - 1, STARTS)
        pieces = [
            law.command(float(at), float(w), [float(one) for one in between])
            for law, at, w, between in zip(laws, shown, omega, read.T, strict=True)
        ]
        torque = np.array([one[0][0] for one in pieces])
        if plant.over:
            heard = np.array([not law.silent for law in laws])
            torque += heard * plant.over(np.rint(shown / plant.quantum))
        if plant.step:
            torque = plant.step * np.floor(torque / plant.step + 0.5)
        line.append(np.clip(torque, -plant.limit, plant.limit))
        acts, seen = line.pop(0) - plant.push, []
        for look in range(looks):
            if look > 0:
                seen.append(np.floor(theta / plant.quantum) * plant.quantum)
            theta, omega = plant.hold(theta, omega, acts)
    return theta, omega


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_random_starts_end_in_the_list(name: str) -> None:
    """Each lies, when it has settled, on a listed orbit, or rests in a listed reading."""
    controller, more = CASES[name]
    made_of = scene(**more)
    parts = {**made_of, "controller": {**EVERY[controller], **made_of.get("controller", {})}}
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
        state = [one.x, one.v, *one.state]
        for at_x, at_v, *_ in states_with_law(made.knob, law, state, list(one.line), one.period):
            near |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
    assert near.all(), f"{np.count_nonzero(~near)} starts end elsewhere, the first at {x[~near][0]}, {v[~near][0]}"
