"""A proven orbit holds what its proof says it holds, and a trial ends where the search says.

Where the encoder has counts, a motion nearer to the orbit than its margin, in the energy norm, has the orbit's readings
for ever and returns to it. Trials of 20,000 samples from the phases of the search, run without any of its tests for an
end, are on one of its orbits at their end, in its proportions.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.search import GeneralEngine, as_arrays, as_compiled
from hknob_cli.engine.general.trace import Rows
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec

from .general_scenes import EVERYTHING, LIGHT, RUBBING, TWO_PARTS, scene

LONG = 20_000
PHASES = 8
SCENES: dict[str, tuple[dict[str, Any], float, int | None]] = {
    "friction": (scene(knob=LIGHT), 1000.0, 512),
    "friction that sticks": (scene(knob=RUBBING), 1000.0, 512),
    "finger": (scene(hand=TWO_PARTS), 1000.0, 1024),
    "lag": (scene(actuator={"time_constant": 3.0e-4}), 1000.0, 512),
    "limit": (scene(actuator={"torque_limit": 0.0021}), 1000.0, 512),
    "torque step": (scene(actuator={"torque_step": 2.3e-4}), 1000.0, 512),
    "virtual damping": (scene(wall={"damping": 4.0e-5}), 1000.0, 512),
    "delay": (scene(actuator={"delay_samples": 1.5}), 1000.0, 1024),
    "friction and finger": (scene(knob=LIGHT, hand=TWO_PARTS), 1000.0, 512),
    "everything": (scene(**{**EVERYTHING, "knob": LIGHT}), 1000.0, 512),
    "rest": (scene(knob={"coulomb_torque": 8.0e-4}), 1000.0, 4096),
    "no encoder": (scene(encoder="none"), 215.0, None),
    "no encoder, delay": (scene(encoder="none", actuator={"delay_samples": 2.0}), 215.0, None),
    "no encoder, damping, limit": (
        scene(encoder="none", wall={"damping": 5.0e-5}, actuator={"torque_limit": 0.002}),
        100.0,
        None,
    ),
}


@cache
def search(name: str) -> tuple[GeneralKnob, tuple[Attractor, ...]]:
    """The loop of one of `SCENES`, and its attractors."""
    parts, rate_hz, counts = SCENES[name]
    plain = SceneSpec.model_validate(parts).plain()
    knob = sample_general(plain, sample_rate_hz=rate_hz, counts_per_rev=counts)
    found = GeneralEngine(compiled("general")).search(
        knob.body,
        knob.wall,
        knob.start(0.02, 0.0),
        rate=knob.rate,
        phases=PHASES,
        delay_line=knob.delay_line,
        max_samples=None,
    )
    return knob, found.attractors


def run(knob: GeneralKnob, state: Any, before: float, line: Any, samples: int) -> np.ndarray:
    """States at samples, (samples + 1, n)."""
    through: Any = compiled("general")["general.run"]
    n = knob.body.order
    rows = Rows(np.zeros((samples + 1) * n), np.zeros(samples + 1))
    work = np.array(state, dtype=np.float64), np.array(line, dtype=np.float64)
    through(work[0], before, work[1], 0, *as_compiled(knob.body, knob.wall), np.zeros(2 * n), rows)
    return np.asarray(rows.states).reshape(samples + 1, n)


@pytest.mark.parametrize("name", [name for name in SCENES if SCENES[name][2] and name != "rest"])
def test_nearer_than_the_margin_returns(name: str) -> None:
    knob, attractors = search(name)
    numbers, n = np.random.default_rng(5), knob.body.order
    for one in attractors:
        assert one.certified, one
        turns = 1 + LONG // one.period
        state = np.array([one.x, one.v, *one.state])
        orbit = run(knob, state, one.before, one.line, one.period)
        for share in (0.999, 0.5, 0.999, 0.05):
            way = numbers.normal(size=n) * [1.0, *[np.std(orbit[:, j]) for j in range(1, n)]]
            size = knob.body.reach * norm(list(way), knob.body)
            away = state + way * ((one.margin - one.bound) * share / size)
            ended = run(knob, away, one.before, one.line, turns * one.period)[-1]
            back = np.abs(ended - state).max() <= 1e-9 * (1.0 + np.abs(orbit).max())
            assert back, f"left from {share} of the margin: {one}"


@pytest.mark.parametrize("name", SCENES)
def test_long_trials_end_on_the_orbits_found(name: str) -> None:
    knob, attractors = search(name)
    assert all(one.certified for one in attractors)
    begin: Any = compiled("general")["general.begin"]
    n, seen = knob.body.order, [0] * len(attractors)
    orbits = [
        run(knob, [one.x, one.v, *one.state], one.before, one.line, one.period - 1)[:, :2]
        for one in attractors
        if one.outcome is Outcome.CYCLE
    ]
    for trial in range(PHASES):
        state = np.zeros(n)
        begin(state, np.array(knob.start(0.02, 0.0)), (trial + 0.5) / PHASES, as_arrays(knob.body), np.zeros(2 * n))
        shown = state[0] if knob.wall.analog else knob.wall.sense * np.floor(knob.wall.sense * state[0])
        end = run(knob, state, shown, [0.0] * knob.delay_line, LONG)[-1]
        on = []
        for k, one in enumerate(attractors):
            if one.outcome is Outcome.CYCLE:
                on.append(np.abs(orbits[k] - end[:2]).max(axis=1).min() <= 1e-9 * (1.0 + np.abs(orbits[k]).max()))
            else:
                assert one.span is not None
                on.append(end[1] == 0.0 and one.span[0] - 1e-9 <= end[0] <= one.span[1] + 1e-9)
        assert sum(on) == 1, f"phase {trial} is on {sum(on)} orbits"
        seen[on.index(True)] += 1
    assert seen == [one.trials for one in attractors]
