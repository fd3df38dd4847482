"""All clock phases of one start beside friction and a finger, a winding, a lag or cogging: against phases themselves.

The plants are matrix exponentials in SI (`rubbing_starts`); the controllers are those of `tests.controllers.laws`,
written once more from their sources. Neither shares code with the package.
"""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Search
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.sets.friction_arc_search import FrictionArcEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY
from tests.controllers.reference import Rig, law_of

from .general_scenes import HEAVY, RINGING, STIFF, TWO_PARTS, scene
from .over_angle_reference import torques
from .rubbing_starts import Rubbing
from .test_law_states import COIL, PUSH, orbit_states, rates

ANGLE = 0.02
PHASES = 48
LATE = {"delay_samples": 1.0}
COGS = {"torque": 3e-4, "per_revolution": 84, "centre": 0.03}
WEAK, STRONG = COGS | {"torque": 1e-4}, COGS | {"torque": 1e-3}
TURNS_BACK = {"hysteresis_counts": 0.5}


def rub(level: float, **more: Any) -> dict[str, Any]:
    """Parts of a scene whose knob has this much friction, N·m."""
    return {"knob": {"coulomb_torque": level}, **more}


CASES: dict[str, tuple[str | None, dict[str, Any], float, int]] = {
    "finger": (None, rub(5.6e-4, hand=TWO_PARTS), 464.0, 256),
    "finger, rests": (None, rub(5.6e-4, hand=TWO_PARTS), 1000.0, 4096),
    "finger, light": (None, rub(1e-4, hand=TWO_PARTS), 1000.0, 256),
    "finger, late": (None, rub(3e-4, hand=TWO_PARTS, actuator=LATE), 464.0, 256),
    "finger, lag": (None, rub(3e-4, hand=TWO_PARTS, actuator={"time_constant": 2e-4}), 464.0, 256),
    "finger, limit, step": (
        None,
        rub(2e-4, hand=TWO_PARTS, actuator={"torque_limit": 4e-3, "torque_step": 1e-4}),
        700.0,
        512,
    ),
    "finger that rings": (None, rub(1e-3, hand=RINGING), 10_000.0, 1024),
    "heavy finger": (None, rub(1e-3, hand=HEAVY), 464.0, 4096),
    "stiff finger": (None, rub(4e-4, hand=STIFF), 1000.0, 512),
    "finger, virtual damping": (None, rub(2e-4, hand=TWO_PARTS, wall={"damping": 2e-5}), 464.0, 256),
    "finger, detents": (None, rub(1e-4, hand=TWO_PARTS, detents={"per_revolution": 24, "torque": 3e-3}), 464.0, 1024),
    "coil": (None, rub(2e-4, **COIL), 1000.0, 512),
    "coil, finger": (None, rub(2e-4, hand=TWO_PARTS, **COIL), 464.0, 256),
    "bounded lag, finger": ("bounded lag", rub(2e-4, hand=TWO_PARTS), 464.0, 256),
    "bounded lag, finger, late": ("bounded lag", rub(5.6e-4, hand=TWO_PARTS, actuator=LATE), 1000.0, 512),
    "differenced, finger": ("damping, differenced", rub(2e-4, hand=TWO_PARTS), 464.0, 512),
    "tracked, finger": ("speed, tracked", rub(2e-4, hand=TWO_PARTS), 464.0, 256),
    "impulse, coil": ("impulse, short", rub(2e-4, **COIL), 464.0, 512),
    "finger, hysteresis": (None, rub(5.6e-4, hand=TWO_PARTS, encoder={"hysteresis_counts": 0.03}), 464.0, 256),
    "finger, slack": (None, rub(5.6e-4, hand=TWO_PARTS, encoder={"backlash": 0.02}), 464.0, 256),
    "finger, late, hysteresis": (None, rub(3e-4, hand=TWO_PARTS, actuator=LATE, encoder=TURNS_BACK), 464.0, 256),
    "finger, limit, step, slack": (
        None,
        rub(
            2e-4,
            hand=TWO_PARTS,
            actuator={"torque_limit": 4e-3, "torque_step": 1e-4},
            encoder={"backlash": 0.02},
        ),
        700.0,
        512,
    ),
    "finger, detents, hysteresis": (
        None,
        rub(1e-4, hand=TWO_PARTS, detents={"per_revolution": 24, "torque": 3e-3}, encoder={"hysteresis_counts": 0.03}),
        464.0,
        1024,
    ),
    "coil, finger, hysteresis": (
        None,
        rub(2e-4, hand=TWO_PARTS, encoder={"hysteresis_counts": 0.03}, **COIL),
        464.0,
        256,
    ),
    "bounded lag, finger, hysteresis": ("bounded lag", rub(2e-4, hand=TWO_PARTS, encoder=TURNS_BACK), 464.0, 256),
    "finger, virtual damping, hysteresis": (
        None,
        rub(2e-4, hand=TWO_PARTS, wall={"damping": 2e-5}, encoder=TURNS_BACK),
        464.0,
        256,
    ),
    "bounded lag, finger, virtual damping, hysteresis": (
        "bounded lag",
        rub(2e-4, hand=TWO_PARTS, wall={"damping": 2e-5}, encoder=TURNS_BACK),
        464.0,
        256,
    ),
    "cogging": (None, rub(0.0, cogging=COGS), 1000.0, 512),
    "cogging, friction": (None, rub(1e-4, cogging=COGS), 1000.0, 512),
    "cogging, much friction, that buzzes": (None, rub(5.6e-4, cogging=WEAK), 464.0, 256),
    "cogging that holds": (None, rub(5.6e-4, cogging=STRONG), 1000.0, 1024),
    "cogging, friction, rests": (None, rub(1e-4, cogging=COGS), 464.0, 2048),
    "cogging, finger, late": (None, rub(0.0, hand=TWO_PARTS, cogging=COGS, actuator=LATE), 464.0, 256),
    "cogging, lag": (None, rub(0.0, cogging=COGS, actuator={"time_constant": 2e-4}), 1000.0, 512),
    "cogging, coil": (None, rub(0.0, cogging=COGS, **COIL), 1000.0, 512),
    "cogging, friction, detents, limit": (
        None,
        rub(
            5e-5,
            cogging=COGS,
            actuator={"torque_limit": 4e-3, "torque_step": 1e-4},
            detents={"per_revolution": 24, "torque": 3e-3},
        ),
        464.0,
        1024,
    ),
    "cogging, friction, virtual damping": (None, rub(1e-4, cogging=COGS, wall={"damping": 2e-5}), 464.0, 512),
    "cogging, friction, bounded lag": ("bounded lag", rub(1e-4, cogging=COGS), 1000.0, 512),
    "cogging, friction, impulse": ("impulse, short", rub(1e-4, cogging=COGS), 1000.0, 512),
    "cogging, tracked": ("speed, tracked", rub(0.0, cogging=COGS), 1000.0, 512),
    "cogging, hysteresis": (None, rub(0.0, cogging=COGS, encoder=TURNS_BACK), 1000.0, 512),
    "cogging, hysteresis, strong": (None, rub(0.0, cogging=COGS | {"torque": 3e-3}, encoder=TURNS_BACK), 464.0, 512),
    "cogging, friction, slack": (None, rub(1e-4, cogging=COGS, encoder={"backlash": 0.02}), 464.0, 256),
    "cogging, friction, hysteresis": (None, rub(1e-4, cogging=COGS, encoder={"hysteresis_counts": 0.1}), 1000.0, 512),
    "cogging, finger, lag, hysteresis": (
        None,
        rub(0.0, hand=TWO_PARTS, cogging=COGS, actuator={"time_constant": 2e-4}, encoder={"hysteresis_counts": 0.05}),
        1000.0,
        512,
    ),
    "cogging, bounded lag, hysteresis": ("bounded lag", rub(5e-5, cogging=COGS, encoder=TURNS_BACK), 1000.0, 512),
    "cogging, virtual damping, hysteresis": (
        None,
        rub(0.0, cogging=COGS, wall={"damping": 2e-5}, encoder={"hysteresis_counts": 0.1}),
        464.0,
        512,
    ),
    "cogging, impulse, hysteresis": ("impulse, short", rub(1e-4, cogging=COGS, encoder=TURNS_BACK), 464.0, 512),
    "cogging, friction, lag": (None, rub(1e-4, cogging=COGS, actuator={"time_constant": 2e-4}), 1000.0, 512),
    "cogging, more friction, slow lag": (None, rub(5.6e-4, cogging=WEAK, actuator={"time_constant": 1e-3}), 464.0, 256),
    "cogging, friction, finger": (None, rub(1e-4, hand=TWO_PARTS, cogging=COGS), 1000.0, 512),
    "cogging, friction, finger, rests": (None, rub(5.6e-4, hand=TWO_PARTS, cogging=STRONG), 1000.0, 1024),
    "cogging, friction, coil, late": (None, rub(1e-4, cogging=COGS, **COIL, actuator=LATE), 1000.0, 512),
    "cogging, friction, finger, lag, hysteresis": (
        None,
        rub(1e-4, hand=TWO_PARTS, cogging=COGS, actuator={"time_constant": 2e-4}, encoder={"hysteresis_counts": 0.05}),
        1000.0,
        512,
    ),
    "cogging, friction, finger, bounded lag": ("bounded lag", rub(1e-4, hand=TWO_PARTS, cogging=COGS), 1000.0, 512),
    "cogging, friction, lag, impulse": (
        "impulse, short",
        rub(5e-5, cogging=COGS, actuator={"time_constant": 1e-4}),
        1000.0,
        256,
    ),
    "impulse, coil, hysteresis": ("impulse, short", rub(2e-4, encoder=TURNS_BACK, **COIL), 464.0, 512),
}


def triangle(cogging: dict[str, float] | None, inertia: float) -> tuple[float, float, float]:
    """Spring, way from corner to corner, and a place of rest of a triangle wave with ``per_revolution`` periods."""
    if not cogging:
        return 0.0, np.inf, 0.0
    per = cogging["per_revolution"]
    return 2.0 * cogging["torque"] * per / np.pi / inertia, np.pi / per, cogging["centre"]


def settle(
    parts: dict[str, Any], rate: float, counts: int, samples: int, starts: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Angles and speeds, (2, phases), of the middle phases of a start at `ANGLE` after so many samples.

    ``starts``: angles and speeds at a sample, of which those are instead.
    """
    quantum, actuator = 2.0 * np.pi / counts, parts.get("actuator", {})
    many = PHASES if starts is None else starts.shape[1]
    a = rates(parts)
    inertia = parts["knob"]["inertia"] + parts["hand"].get("inertia", 0.0)
    encoder = parts.get("encoder", {})
    half, count = 0.5 * (encoder.get("hysteresis_counts", 0.0) + encoder.get("backlash", 0.0) / quantum), np.zeros(many)

    def read_after(count: Any, theta: Any) -> Any:
        """Counts of angles: edges are passed half of the hysteresis later, on the way up and on the way down."""
        return np.clip(count, np.floor(theta / quantum - half), np.floor(theta / quantum + half))

    def stop(which: NDArray[np.int64], theta: NDArray[np.float64]) -> None:
        if half > 0.0:
            count[which] = read_after(count[which], theta)

    body = Rubbing(a, parts["knob"]["coulomb_torque"] / inertia, stop, triangle(parts.get("cogging"), inertia))
    z = np.zeros((len(a), many))
    z[0], z[-1] = ANGLE, 1.0
    if "finger" in parts["hand"]:
        z[2] = ANGLE
    if starts is not None:
        z[:2] = starts
    for k in range(many if starts is None else 0):  # a flight of its own for each phase
        z[:, k : k + 1] = body.hold(z[:, k : k + 1], (k + 0.5) / many / rate)
    plain = {name: part for name, part in parts.items() if name not in ("controller", "actuator", "motor")}
    laws = [law_of(Rig(plain, rate, counts), parts.get("controller")) for _ in range(many)]
    over, line = torques(parts, counts), [np.zeros(many)] * int(actuator.get("delay_samples", 0.0))
    step, limit = actuator.get("torque_step", 0.0), actuator.get("torque_limit", np.inf)
    count = np.floor(z[0] / quantum)
    before = count * quantum
    for _ in range(samples):
        count = read_after(count, z[0])
        shown = count * quantum
        brake = np.where(shown < 0.0, parts["wall"].get("damping", 0.0) * rate * (shown - before), 0.0)
        before = shown
        pieces = [law.command(float(at), float(w), []) for law, at, w in zip(laws, shown, z[1], strict=True)]
        for part, (_, span) in enumerate(pieces[0]):
            torque = np.array([one[part][0] for one in pieces]) - brake
            if over:
                torque += np.array([not law.silent for law in laws]) * over(np.rint(shown / quantum))
            if step > 0.0:
                torque = step * np.floor(torque / step + 0.5)
            line.append(np.clip(torque, -limit, limit))
            z[-2] = line.pop(0)
            z = body.hold(z, span)
    return z[:2]


def follow(parts: dict[str, Any], rate: float, counts: int) -> tuple[Search | None, Any, Any]:
    """What all phases end in, the cell, and what gives the states of an orbit at its samples."""
    plain, functions = reduced(SceneSpec.model_validate(parts).plain()), compiled("friction arcs")
    cell: dict[str, Any] = {"sample_rate_hz": rate, "counts_per_rev": counts}
    law = None
    two_counts = "encoder" in parts and "damping" in parts["wall"]  # to remember: a law does
    if "controller" in parts or two_counts:
        made = make_law(plain, **cell)
        engine, knob, law = LawEngine(made.law, functions), made.knob, LawEngine(made.law).law
        arcs = FrictionArcEngine(engine.law, functions)
        given: dict[str, Any] = {"rate": made.rate, "delay_line": engine.past_length}
    else:
        knob = sample_general(plain, **cell)
        arcs = FrictionArcEngine(None, functions)
        given = {"rate": knob.rate, "delay_line": knob.delay_line}
    found = arcs.search_phases(knob.body, knob.wall, knob.start(ANGLE, 0.0), max_samples=None, **given)
    return found, knob, lambda one: orbit_states(knob, law, one)


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_phases_end_in_the_list_and_as_often(name: str) -> None:
    """Each of 48 lies, when it has settled, on an orbit that is listed, or rests in its reading."""
    controller, more, rate, counts = CASES[name]
    parts = scene(**more)
    if controller:
        parts["controller"] = EVERY[controller]
    found, knob, orbit = follow(parts, rate, counts)
    assert found
    assert found.complete
    assert all(one.certified for one in found.attractors)
    assert sum(one.trials for one in found.attractors) == pytest.approx(1.0, abs=1e-6)
    theta, omega = settle(parts, rate, counts, int(20.0 / knob.rate) + 500)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    counted, back = [], 0.5 * knob.wall.hysteresis + 1e-9
    for one in found.attractors:
        if one.outcome is Outcome.REST:
            near = (np.abs(v) < 1e-6) & (np.floor(x - back) <= np.floor(one.x + back))
            near &= np.floor(one.x - back) <= np.floor(x + back)
        else:
            near = np.zeros(PHASES, dtype=bool)
            for at_x, at_v, *_ in orbit(one):
                near |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
        counted.append(near)
    ends = np.any(counted, axis=0)
    assert ends.all(), f"{np.count_nonzero(~ends)} phases end elsewhere, the first at {x[~ends][0]}, {v[~ends][0]}"
    # Phases are evenly spaced: an attractor whose phases are m intervals has its share to within m of them.
    for one, near in zip(found.attractors, counted, strict=True):
        assert abs(one.trials - np.count_nonzero(near) / PHASES) < 8.0 / PHASES
    assert parts["bias"]["torque"] == PUSH
