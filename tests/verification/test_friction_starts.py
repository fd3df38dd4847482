"""All starts of a knob with friction: the list is compared with the ends of random starts, simulated independently."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec

from .general_scenes import scene
from .lagged_starts import starts_of

ANGLE, VELOCITY = 0.03, 3.0
FREE = {"stiffness": 0.0}


def states_of(knob: GeneralKnob, one: Attractor) -> NDArray[np.float64]:
    """States of an orbit at its samples, (period, 2)."""
    z, ring, before, head = [one.x, one.v, *one.state], list(one.line), one.before, 0
    found = []
    for _ in range(one.period):
        found.append(tuple(z[:2]))
        before, head = advance(z, before, ring, head, knob.body, knob.wall, [0.0] * (2 * knob.body.order))
    return np.array(found)


def listed(knob: GeneralKnob, found: tuple[Attractor, ...], x: Any, v: Any) -> NDArray[np.bool_]:
    """Whether each state lies on a listed orbit, or at rest in a reading of a listed rest."""
    near = np.zeros(len(x), dtype=bool)
    half = 0.5 * knob.wall.hysteresis
    for one in found:
        if one.outcome is Outcome.REST and half > 0.0:  # counts outside the wall are told as one
            top = np.inf if one.before >= 0.0 else one.before + 1.0 + half
            near |= (np.abs(v) < 1e-6) & (x > one.before - half) & (x < top)
        elif one.outcome is Outcome.REST:
            near |= (v == 0.0) & (np.floor(x) == np.floor(one.x))
            # What creeps to the end of the zone of rest has the reading, too, and hardly any speed.
            near |= (np.abs(v) < 1e-6) & (np.floor(x) == np.floor(one.x))
        elif one.outcome is Outcome.CYCLE:
            for at_x, at_v in states_of(knob, one):
                near |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
    return near


SCENES = {
    "light": (scene(knob={"coulomb_torque": 1.0e-5}), 464.0, 256),
    "measured friction": (scene(knob={"coulomb_torque": 5.6e-4}), 455.0, 256),
    "rest and cycles": (scene(knob={"coulomb_torque": 4.0e-4}), 1000.0, 512),
    "one cycle": (scene(knob={"coulomb_torque": 9.0e-4}), 464.0, 256),
    "delay": (scene(knob={"coulomb_torque": 2.0e-4}, actuator={"delay_samples": 1.0}), 464.0, 256),
    "limit and step": (
        scene(knob={"coulomb_torque": 2.0e-4}, actuator={"torque_limit": 0.02, "torque_step": 1e-4}),
        464.0,
        256,
    ),
    "dead band": (scene(knob={"coulomb_torque": 1.0e-4}, actuator={"dead_band": 3.0e-3}), 464.0, 256),
    "detents": (
        scene(knob={"coulomb_torque": 1.0e-4}, wall=FREE, detents={"per_revolution": 64, "torque": 4e-3}),
        464.0,
        1024,
    ),
    "end stops, late": (
        scene(
            knob={"coulomb_torque": 1.0e-4},
            wall=FREE,
            end_stops={"low": -0.01, "high": 0.012, "stiffness": 0.15},
            actuator={"delay_samples": 1.0},
        ),
        1000.0,
        512,
    ),
    "dead zone": (
        scene(knob={"coulomb_torque": 5.0e-5}, dead_zone={"width": 0.03, "stiffness": 0.3}),
        464.0,
        256,
    ),
    "virtual damping": (scene(knob={"coulomb_torque": 2.0e-4}, wall={"damping": 2.0e-5}), 464.0, 256),
    "fast lag, late": (
        scene(knob={"coulomb_torque": 5.6e-4}, actuator={"delay_samples": 1.0, "time_constant": 5e-5}),
        1000.0,
        512,
    ),
    "slow lag": (scene(knob={"coulomb_torque": 2.0e-4}, actuator={"time_constant": 2e-3}), 464.0, 256),
    "hysteresis": (scene(knob={"coulomb_torque": 1.0e-4}, encoder={"hysteresis_counts": 0.4}), 1000.0, 1024),
    "hysteresis, late": (
        scene(knob={"coulomb_torque": 5.6e-4}, encoder={"hysteresis_counts": 0.1}, actuator={"delay_samples": 1.0}),
        455.0,
        256,
    ),
    "hysteresis that rests": (scene(knob={"coulomb_torque": 9.0e-4}, encoder={"hysteresis_counts": 0.3}), 464.0, 256),
    "slack on detents": (
        scene(
            knob={"coulomb_torque": 1.0e-4},
            wall=FREE,
            detents={"per_revolution": 64, "torque": 4e-3},
            encoder={"backlash": 1e-3},
        ),
        464.0,
        1024,
    ),
    "hysteresis and lag": (
        scene(knob={"coulomb_torque": 3.0e-4}, encoder={"hysteresis_counts": 0.5}, actuator={"time_constant": 3e-4}),
        1000.0,
        512,
    ),
    "lag, step, limit": (
        scene(
            knob={"coulomb_torque": 3.0e-4},
            actuator={"time_constant": 3e-4, "torque_step": 1e-4, "torque_limit": 0.02},
        ),
        1000.0,
        512,
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_random_starts_end_in_the_list(name: str) -> None:
    """Each of 4000 (400 with a lag), when it has settled, lies on a listed orbit or rests in a listed reading."""
    parts, rate, counts = SCENES[name]
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    box = Box(knob.position(-ANGLE), knob.position(ANGLE), knob.speed(-VELOCITY), knob.speed(VELOCITY))
    engine = FrictionSetEngine(compiled("friction sets"))
    found = engine.search_box(knob.body, knob.wall, box, rate=knob.rate, delay_line=knob.delay_line, max_samples=None)
    assert found.complete
    chance = np.random.default_rng(2)
    starts = 400 if knob.body.lag > 0.0 else 4000  # events under a torque that changes take long to find
    theta, omega = chance.uniform(-ANGLE, ANGLE, starts), chance.uniform(-VELOCITY, VELOCITY, starts)
    theta, omega, _ = starts_of(parts, rate, counts).run(theta, omega, int(40.0 / knob.rate) + 200)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    near = listed(knob, found.attractors, x, v)
    assert near.all(), f"{np.count_nonzero(~near)} starts end elsewhere, the first at {x[~near][0]}, {v[~near][0]}"
