"""All starts under a controller beside a finger, a shorted winding or teeth that yield, against random starts apart.

The plants are matrix exponentials in SI, each from its own rates; the controllers are those of
`tests.controllers.laws`, written once more from their sources, one for each start. Neither shares code with the
package.
"""

import random
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Search
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.sets.law_search import LawStatesEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets.search import Box
from hknob_cli.specs.electrical import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY
from tests.controllers.reference import Rig, law_of
from tests.engine.general.law_runs import states_with_law

from .general_scenes import GRASP, RINGING, TWO_PARTS, scene
from .general_starts import matrix
from .over_angle_reference import torques

ANGLE, VELOCITY = 0.02, 2.0  # of starts, to either side
PUSH = 1e-3
COIL = {"motor": {"torque_constant": 0.0234, "resistance": 2.32, "winding": "shorted", "inductance": 2.4e-4}}
TEETH = {"gear": {"ratio": 2.0, "motor_inertia": 1e-7, "stiffness": 3.0, "mesh_damping": 4e-4}, "hand": GRASP}
FINGER = {"hand": TWO_PARTS}
LATE = {"delay_samples": 1.0}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "finger": ("bounded lag", FINGER),
    "finger, late, limit": ("bounded lag", {**FINGER, "actuator": {**LATE, "torque_limit": 4e-3}}),
    "finger that rings": ("bounded lag", {"hand": RINGING}),
    "finger, lag": ("damping, differenced", {**FINGER, "actuator": {"time_constant": 2e-4}}),
    "finger, impulse": ("impulse, short", FINGER),
    "finger, passivity": ("passivity", FINGER),
    "finger, predicted, step": ("half sample", {**FINGER, "actuator": {"torque_step": 1e-4}}),
    "finger, matched wall, late": ("matched wall", {**FINGER, "actuator": LATE}),
    "finger, tracked": ("speed and angle, tracked", FINGER),
    "finger, Kalman, late": ("speed, Kalman", {**FINGER, "actuator": LATE}),
    "finger, detents": ("bounded lag", {**FINGER, "detents": {"per_revolution": 24, "torque": 3e-3}}),
    "coil": ("bounded lag", COIL),
    "coil, filtered": ("velocity, filtered", COIL),
    "coil, finger": ("phase, 90", {**COIL, **FINGER}),
    "teeth": ("bounded lag", TEETH),
    "teeth, adaptive": ("speed, adaptive", TEETH),
    "teeth, late": ("first-order hold", {**TEETH, "actuator": LATE}),
}


def rates(parts: dict[str, Any]) -> NDArray[np.float64]:
    """Rates of (angle that is measured, its speed, others, command, 1), SI at the knob."""
    if "gear" in parts:
        gear, hand, ratio = parts["gear"], parts["hand"], parts["gear"]["ratio"]
        motor, knob = gear["motor_inertia"] * ratio**2, parts["knob"]["inertia"] + hand["inertia"]
        a = np.zeros((6, 6))
        a[0, 1] = a[2, 3] = 1.0
        a[1, :4] = np.array([-1.0, 0.0, 1.0, 0.0]) * gear["stiffness"] / motor
        a[1, :4] += np.array([0.0, -1.0, 0.0, 1.0]) * gear["mesh_damping"] / motor
        a[3, :4] = -a[1, :4] * motor / knob
        a[3, 2] -= hand["stiffness"] / knob
        a[3, 3] -= (parts["knob"]["damping"] + hand["damping"]) / knob
        a[3, 5], a[1, 4] = -PUSH / knob, 1.0 / motor
        return a
    a = matrix(parts, PUSH)
    if "motor" in parts:
        motor, at = parts["motor"], len(a) - 2
        inertia = parts["knob"]["inertia"] + parts["hand"].get("inertia", 0.0)
        a = np.insert(np.insert(a, at, 0.0, axis=0), at, 0.0, axis=1)
        a[1, at] = -motor["torque_constant"] / inertia  # by the current, A
        a[at, 1], a[at, at] = motor["torque_constant"] / motor["inductance"], -motor["resistance"] / motor["inductance"]
    return a


def settle(
    parts: dict[str, Any], rate: float, counts: float, samples: int, starts: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles and speeds of starts, (n, 2), after so many samples: those that are measured, in turns of the knob."""
    quantum, actuator, many = 2.0 * np.pi / counts, parts.get("actuator", {}), len(starts)
    a = rates(parts)
    z = np.zeros((len(a), many))
    z[0], z[1], z[-1] = starts[:, 0], starts[:, 1], 1.0
    if "gear" in parts or "finger" in parts["hand"]:
        z[2:4] = z[:2]
    plain = {name: part for name, part in parts.items() if name not in ("controller", "actuator", "motor", "gear")}
    ratio = 1.0
    if "gear" in parts:  # what the controller's model has is the motor
        ratio = parts["gear"]["ratio"]
        plain |= {"knob": {"inertia": parts["gear"]["motor_inertia"] * ratio**2}, "hand": {}}
    laws = [law_of(Rig(plain, rate, counts), parts["controller"]) for _ in range(many)]
    over, maps, line = torques(parts, int(counts)), {}, [np.zeros(many)] * int(actuator.get("delay_samples", 0.0))
    step, limit = ratio * actuator.get("torque_step", 0.0), ratio * actuator.get("torque_limit", np.inf)
    for _ in range(samples):
        shown = np.floor(z[0] / quantum) * quantum
        pieces = [law.command(float(at), float(w), []) for law, at, w in zip(laws, shown, z[1], strict=True)]
        assert not line or len(pieces[0]) == 1
        for part, (_, span) in enumerate(pieces[0]):
            torque = np.array([one[part][0] for one in pieces])
            if over:
                torque += np.array([not law.silent for law in laws]) * over(np.rint(shown / quantum))
            if step > 0.0:
                torque = step * np.floor(torque / step + 0.5)
            line.append(np.clip(torque, -limit, limit))
            z[-2] = line.pop(0)
            if span not in maps:
                maps[span] = expm(a * span)
            z = maps[span] @ z
    return z[0], z[1]


def every_start(
    controller: str, more: dict[str, Any], rate: float, counts: int, starts: int, seconds: float | None = None
) -> Search | None:
    """What all starts of a box end in; random ones lie, when they have settled, on an orbit of it, or rest."""
    parts = {**scene(**more), "controller": EVERY[controller]}
    turns = parts.get("gear", {}).get("ratio", 1.0)
    made = make_law(
        reduced(SceneSpec.model_validate(parts).plain()), sample_rate_hz=rate, counts_per_rev=int(counts / turns)
    )
    functions, knob = compiled("general sets"), made.knob
    engine = LawEngine(made.law, functions)
    box = Box(knob.position(-ANGLE), knob.position(ANGLE), knob.speed(-VELOCITY), knob.speed(VELOCITY))
    found = LawStatesEngine(engine.law, functions).search_box(
        *(knob.body, knob.wall, box),
        rate=made.rate,
        delay_line=engine.past_length,
        max_samples=None,
        seconds=seconds,
    )
    if found is None:
        assert not made.law.provable
        return found
    if not found.complete:
        return found
    assert all(one.certified for one in found.attractors)
    chance = np.random.default_rng(3)
    begun = np.column_stack([chance.uniform(-ANGLE, ANGLE, starts), chance.uniform(-VELOCITY, VELOCITY, starts)])
    theta, omega = settle(parts, rate, counts, int(40.0 / made.rate) + 200, begun)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    near, law = np.zeros(starts, dtype=bool), LawEngine(made.law).law
    for one in found.attractors:
        if one.outcome is Outcome.REST:
            near |= (np.abs(v) < 1e-6) & (np.floor(x) == np.floor(one.x))
            continue
        state = [one.x, one.v, *one.state]
        for at_x, at_v, *_ in states_with_law(knob, law, state, list(one.line), one.period):
            near |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
    assert near.all(), f"{np.count_nonzero(~near)} starts end elsewhere, the first at {x[~near][0]}, {v[~near][0]}"
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_random_starts_end_in_the_list(name: str) -> None:
    """Each of 200, and the list is complete."""
    found = every_start(*CASES[name], 464.0, 256, 200)
    assert found
    assert found.complete


def random_case(seed: int) -> tuple[str, dict[str, Any], float, int]:
    """A controller beside a finger, a winding, both, or teeth, and what else there may be: rate and counts, too."""
    chance = random.Random(seed)
    names = [
        name
        for name, one in EVERY.items()
        if one.get("velocity") != "sensor" and one.get("detections", 1) == 1 and "filtered, in steps" not in name
    ]
    controller, kind = chance.choice(names), chance.choice(["finger", "finger", "coil", "both", "teeth"])

    def near(value: float, decades: float = 0.5) -> float:
        return float(value * 10.0 ** chance.uniform(-decades, decades))

    more: dict[str, Any] = {"wall": {"stiffness": near(0.27)}}
    if kind in ("finger", "both"):
        more["hand"] = {
            part: {key: near(value) for key, value in numbers.items()} for part, numbers in TWO_PARTS.items()
        }
    if kind in ("coil", "both"):
        motor = COIL["motor"]
        more["motor"] = {**motor, "torque_constant": near(0.02), "inductance": near(2.4e-4, 1.0)}
    if kind == "teeth":
        gear = TEETH["gear"]
        more["gear"] = {**gear, "motor_inertia": near(1e-7), "stiffness": near(3.0), "mesh_damping": near(4e-4)}
    multirate = "in steps" in controller or "impulse" in controller
    actuator: dict[str, float] = {}
    if chance.random() < 0.4 and not multirate:
        actuator["delay_samples"] = float(chance.randint(1, 2))
    if chance.random() < 0.3:
        actuator["torque_limit"] = near(4e-3, 0.3)
    if chance.random() < 0.2:
        actuator["torque_step"] = near(1e-4, 0.3)
    if actuator:
        more["actuator"] = actuator
    return controller, more, float(round(near(600.0))), chance.choice([128, 256, 512, 1024])


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("seed", range(24))
def test_random_starts_of_random_scenes(seed: int) -> None:
    """Where a list is complete none of 60 ends elsewhere; it is not where the knob diverges, or work is at its end."""
    found = every_start(*random_case(seed), 60, seconds=20.0)
    assert found is None or found.complete == (found.why is Reason.NONE)
