"""All starts beside a finger, a winding, teeth that yield or hysteresis, under controllers, too, against random starts.

The plants are matrix exponentials in SI, each from its own rates; the controllers are those of
`tests.controllers.laws`, written once more from their sources, one for each start. Neither shares code with the
package.
"""

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Attractor, Search
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.sets.law_search import LawStatesEngine
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY
from tests.controllers.reference import Rig, law_of
from tests.engine.general.law_runs import states_with_law

from .general_scenes import GRASP, RINGING, TWO_PARTS, scene
from .general_starts import matrix
from .over_angle_reference import torques

FINE = 64  # parts of a hold after which a count with hysteresis is looked at
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
    laws = [law_of(Rig(plain, rate, counts), parts.get("controller")) for _ in range(many)]
    over, maps, line = torques(parts, int(counts)), {}, [np.zeros(many)] * int(actuator.get("delay_samples", 0.0))
    step, limit = ratio * actuator.get("torque_step", 0.0), ratio * actuator.get("torque_limit", np.inf)
    half = 0.5 * parts.get("encoder", {}).get("hysteresis_counts", 0.0)
    count = np.floor(z[0] / quantum)
    fine = FINE if half > 0.0 else 1
    for _ in range(samples):
        count = np.clip(count, np.floor(z[0] / quantum - half), np.floor(z[0] / quantum + half))
        shown = count * quantum
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
                maps[span] = expm(a * span / fine)
            for _ in range(fine):
                z = maps[span] @ z
                count = np.clip(count, np.floor(z[0] / quantum - half), np.floor(z[0] / quantum + half))
    return z[0], z[1]


Orbit = Callable[[Attractor], NDArray[np.float64]]


def orbit_states(knob: Any, law: Any, one: Attractor) -> NDArray[np.float64]:
    """States of an orbit at its samples, (period, order); ``law``: of a controller, None without one."""
    z, line, before, head, states = [one.x, one.v, *one.state], list(one.line), one.before, 0, []
    if law is not None:
        return states_with_law(knob, law, z, line, one.period)
    for _ in range(one.period):
        states.append(list(z))
        before, head = advance(z, before, line, head, knob.body, knob.wall, [0.0] * (2 * knob.body.order))
    return np.array(states)


def follow_box(
    parts: dict[str, Any], rate: float, counts: int, seconds: float | None
) -> tuple[Search | None, Any, Orbit]:
    """What all starts of a box end in, the cell, and the states at the samples of one period of an orbit."""
    plain, functions = reduced(SceneSpec.model_validate(parts).plain()), compiled("general sets")
    cell: dict[str, Any] = {"sample_rate_hz": rate, "counts_per_rev": counts}
    given: dict[str, Any] = {"max_samples": None, "seconds": seconds}
    sets: GeneralSetEngine
    law: Any = None
    if "controller" in parts:
        made = make_law(plain, **cell)
        engine, knob, law = LawEngine(made.law, functions), made.knob, LawEngine(made.law).law
        sets, known = LawStatesEngine(engine.law, functions), made.law.provable
        given |= {"rate": made.rate, "delay_line": engine.past_length}
    else:
        knob, known = sample_general(plain, **cell), True
        sets = GeneralSetEngine(functions)
        given |= {"rate": knob.rate, "delay_line": knob.delay_line}
    box = Box(knob.position(-ANGLE), knob.position(ANGLE), knob.speed(-VELOCITY), knob.speed(VELOCITY))
    found = sets.search_box(knob.body, knob.wall, box, **given)
    assert found is not None or not known
    return found, knob, lambda one: orbit_states(knob, law, one)


def every_start(
    controller: str | None, more: dict[str, Any], rate: float, counts: int, starts: int, seconds: float | None = None
) -> Search | None:
    """What all starts of a box end in; random ones lie, when they have settled, on an orbit of it, or rest."""
    parts = scene(**more)
    if controller:
        parts["controller"] = EVERY[controller]
    turns = parts.get("gear", {}).get("ratio", 1.0)
    found, knob, orbit = follow_box(parts, rate, int(counts / turns), seconds)
    if found is None or not found.complete:
        return found
    assert all(one.certified for one in found.attractors)
    chance = np.random.default_rng(3)
    begun = np.column_stack([chance.uniform(-ANGLE, ANGLE, starts), chance.uniform(-VELOCITY, VELOCITY, starts)])
    theta, omega = settle(parts, rate, counts, int(40.0 / knob.rate) + 1500, begun)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    near = np.zeros(starts, dtype=bool)
    for one in found.attractors:
        if one.outcome is Outcome.REST:
            near |= (np.abs(v) < 1e-6) & (np.abs(x - one.x) < 1e-6)
            continue
        for at_x, at_v, *_ in orbit(one):
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


def behind(width: float, **more: Any) -> dict[str, Any]:
    """With an encoder of so much hysteresis, in counts."""
    return {"encoder": {"hysteresis_counts": width}, **more}


HYSTERESIS: dict[str, tuple[str | None, dict[str, Any], float, int]] = {
    "narrow": (None, behind(0.1), 1000.0, 1024),
    "half a count": (None, behind(0.5), 464.0, 256),
    "one count, fast": (None, behind(1.0), 4641.0, 512),
    "wide": (None, behind(2.3), 1000.0, 512),
    "late": (None, behind(0.5, actuator=LATE), 464.0, 512),
    "limit, step": (None, behind(0.3, actuator={"torque_limit": 4e-3, "torque_step": 1e-4}), 700.0, 512),
    "finger": (None, behind(0.5, hand=TWO_PARTS), 464.0, 256),
    "finger, wide": (None, behind(1.5, hand=TWO_PARTS), 1000.0, 256),
    "coil": (None, behind(0.2, **COIL), 1000.0, 512),
    "detents": (None, behind(0.4, detents={"per_revolution": 24, "torque": 3e-3}), 464.0, 256),
    "bounded lag": ("bounded lag", behind(0.5), 464.0, 256),
    "differenced, late": ("damping, differenced", behind(0.2, actuator=LATE), 1000.0, 512),
    "impulse": ("impulse, short", behind(0.3), 464.0, 512),
    "tracked, finger": ("speed, tracked", behind(0.4, hand=TWO_PARTS), 464.0, 256),
    "Kalman": ("speed, Kalman", behind(1.2), 464.0, 512),
}


@pytest.mark.long
@pytest.mark.parametrize("name", HYSTERESIS)
def test_random_starts_behind_hysteresis_end_in_the_list(name: str) -> None:
    """Each of 100; the reference looks at the count 64 times in a hold."""
    found = every_start(*HYSTERESIS[name], 100)
    assert found
    assert found.complete


def random_case(seed: int) -> tuple[str | None, dict[str, Any], float, int]:
    """A controller, or none, beside a finger, a winding, teeth or hysteresis, and more; rate and counts."""
    chance = random.Random(seed)
    names = [
        name
        for name, one in EVERY.items()
        if one.get("velocity") != "sensor" and one.get("detections", 1) == 1 and "filtered, in steps" not in name
    ]
    controller, kind = chance.choice(names), chance.choice(["finger", "coil", "both", "teeth", "encoder"])

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
    if kind == "encoder" or chance.random() < 0.3:
        more["encoder"] = {"hysteresis_counts": near(0.5, 0.7)}
    return (
        controller if chance.random() < 0.8 else None,
        more,
        float(round(near(600.0))),
        chance.choice([128, 256, 512, 1024]),
    )


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("seed", range(24))
def test_random_starts_of_random_scenes(seed: int) -> None:
    """Where a list is complete none of 60 ends elsewhere; it is not where the knob diverges, or work is at its end."""
    found = every_start(*random_case(seed), 60, seconds=20.0)
    assert found is None or found.complete == (found.why is Reason.NONE)
