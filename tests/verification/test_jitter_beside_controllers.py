"""Controllers under a sample clock that jitters, against the 60-digit model of each law with the same intervals.

A law reckons with the period that is meant, its readings and torques within an interval are longer or shorter with it,
and what it senses of the speed is the speed itself.
"""

from itertools import islice
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import LawKnob, make_law
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.ensemble import begin
from hknob_cli.engine.general.interval import begin_clock
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.laws.step import advance_jittering_with_law, begin_past
from hknob_cli.engine.general.search import as_list
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import LawMeasurer
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.law_record import follow_law
from tests import digits as mp
from tests.controllers.laws import EVERY

from .general_scenes import LIGHT, TWO_PARTS, scene
from .law_reference import simulate_law
from .test_jitter import CLEAR, WITHIN, intervals, with_clock

SAMPLES = 60
PHASE = 0.37
# What else the scenes have, one after another through the controllers.
BESIDE: list[dict[str, Any]] = [
    {"actuator": {"delay_samples": 1.0}},
    {"knob": LIGHT, "wall": {"damping": 3e-6}},
    {"hand": TWO_PARTS, "actuator": {"time_constant": 2e-4}},
    {"encoder": {"hysteresis_counts": 0.6}},
    {"encoder": {"backlash": 2e-3}, "knob": LIGHT},
    {"actuator": {"delay_samples": 2.0, "torque_limit": 4e-3, "torque_step": 1e-4}},
]


def made_of(parts: dict[str, Any]) -> LawKnob:
    """The cell of a scene under its controller."""
    plain = reduced(SceneSpec.model_validate(parts).plain())
    return make_law(plain, sample_rate_hz=1000.0, counts_per_rev=1024)


def run(made: LawKnob, samples: int = SAMPLES) -> np.ndarray:
    """Positions at the samples of a trial from 20 mrad; interpreted, as so few do not repay a compiler."""
    knob, law = made.knob, made.law
    body, wall = knob.body, as_list(knob.wall)
    z, past, pad = [0.0] * body.order, [0.0] * len(law.beside), [0.0] * (2 * body.order)
    begin(z, knob.start(0.02, -0.5), PHASE, body, pad)
    begin_past(past, read(z[0], wall), law)
    begin_clock(wall.clock, 0.0)
    found = []
    for _ in range(samples):
        found.append(z[0])
        advance_jittering_with_law(z, past, body, wall, law, pad)
    return np.array(found)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("jitter", [0.1, 0.9])
@pytest.mark.parametrize("name", EVERY)
def test_every_sample(name: str, jitter: float) -> None:
    at = list(EVERY).index(name)
    seed = Random(f"{name} {jitter}").randrange(1000)
    parts = {**scene(**BESIDE[at % len(BESIDE)]), "controller": dict(EVERY[name])}
    made = made_of(with_clock(parts, jitter, seed))
    knob, found = made.knob, run(made)
    phase = mp.mpf(PHASE) * (1 + mp.mpf(jitter))
    trial = simulate_law(
        parts, 1000.0, 1024, angle=0.02, velocity=-0.5, phase=phase, intervals=intervals(jitter, seed, 0)
    )
    size, compared = 1.0 + float(np.abs(found).max()), 0
    for x, (theta, _, clear) in zip(found, islice(trial, SAMPLES), strict=True):
        if clear < CLEAR:
            break
        assert abs(float(theta / mp.mpf(knob.quantum_rad)) - knob.shift - x) <= WITHIN * size
        compared += 1
    assert compared >= SAMPLES // 2, "rounding may decide: choose another seed"


@pytest.mark.parametrize("name", ["impulse, timed", "first-order hold, in steps", "damping, differenced"])
def test_a_recording_has_the_samples_of_the_trial(name: str) -> None:
    parts = {**scene(encoder={"hysteresis_counts": 0.6}), "controller": dict(EVERY[name])}
    made = made_of(with_clock(parts, 0.4, 11))
    rows = list(follow_law(made, made.knob.start(0.02, -0.5), phase=PHASE, until=SAMPLES * 0.6, every=0.25))
    sampled = [row for row in rows if row.event == "sample"]
    assert len(sampled) > SAMPLES // 2
    np.testing.assert_allclose([row.state[0] for row in sampled], run(made, len(sampled)), rtol=0.0, atol=1e-9)
    lengths = [float(one) / 1.4 for one in islice(intervals(0.4, 11, 0), len(sampled) - 1)]
    np.testing.assert_allclose(np.diff([row.time for row in sampled]), lengths, rtol=1e-9)
    commands = [row.time for row in rows if row.event == "command"]
    parts_of = len(made.law.sched) // 7 if name == "first-order hold, in steps" else 1
    assert len(commands) >= (parts_of - 1) * (len(sampled) - 1)


def search(parts: dict[str, Any], *, in_code: bool = False, samples: int = 2**14) -> Any:
    """What trials from 20 mrad settle to: the cell, its engine, and the ends."""
    made = made_of(parts)
    engine = LawEngine(made.law, compiled("laws") if in_code else None)
    knob = made.knob
    start = knob.start(0.02, 0.0)
    ends = engine.search(
        knob.body,
        knob.wall,
        start,
        rate=made.rate,
        phases=4,
        delay_line=engine.past_length,
        max_samples=samples,
    ).attractors
    return made, engine, ends


RESTING: dict[str, dict[str, Any]] = {
    "bounded lag": {"knob": {"coulomb_torque": 8e-4}},
    "stiffening": {},
    "passivity": {"knob": {"coulomb_torque": 8e-4}, "encoder": {"hysteresis_counts": 0.6}},
    "velocity, filtered": {"knob": {"coulomb_torque": 9e-4}},
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("jitter", [0.05, 0.6])
@pytest.mark.parametrize("name", RESTING)
def test_trials_that_are_proven_to_rest_do_so_in_the_model(name: str, jitter: float) -> None:
    parts = {**scene(**RESTING[name]), "controller": dict(EVERY[name])}
    made, _, ends = search(with_clock(parts, jitter))
    assert sum(one.trials for one in ends if one.outcome is Outcome.REST and one.certified) == 4.0
    knob, found = made.knob, []
    for trial in range(4):
        phase = mp.mpf((trial + 0.5) / 4) * (1 + mp.mpf(jitter))
        motion = simulate_law(
            parts, 1000.0, 1024, angle=0.02, velocity=0.0, phase=phase, intervals=intervals(jitter, 0, trial)
        )
        *_, (theta, omega, _) = islice(motion, 600)
        assert abs(omega) < 1e-6
        found.append(float(theta / mp.mpf(knob.quantum_rad)) - knob.shift)
    spans = [one.span or (one.x, one.x) for one in ends]
    low, high = min(one[0] for one in spans), max(one[1] for one in spans)
    assert [min(found), max(found)] == pytest.approx([low, high], abs=1e-3)


def test_a_sensed_speed_rests_without_a_proof() -> None:
    """Deep friction holds the knob; a law that reads the speed is no cascade, so that rest is seen and labelled."""
    parts = {**scene(knob={"coulomb_torque": 1.2e-3}), "controller": dict(EVERY["damping, sensor"])}
    _, _, ends = search(with_clock(parts, 0.3))
    assert {(one.outcome, one.reason) for one in ends} == {(Outcome.REST, Reason.JITTERS)}


def measured(name: str, *, in_code: bool) -> str:
    """What is said of a motion that does not rest."""
    parts = {**scene(), "controller": dict(EVERY[name])}
    made, engine, ends = search(with_clock(parts, 0.2, 3), in_code=in_code, samples=400)
    (one,) = ends
    assert (one.outcome, one.reason, one.trials) == (Outcome.UNDECIDED, Reason.JITTERS, 4.0)
    found = LawMeasurer(made.knob, engine).measure(one)
    assert 1e-4 < found.jitter_p2p_rad < found.jitter_range_rad < 2e-2
    return repr((one, found))


@pytest.mark.parametrize("name", ["bounded lag", "impulse, timed"])
def test_what_does_not_rest_is_measured_and_not_proven(name: str) -> None:
    """With many readings an interval, over a quarter of the time."""
    measured(name, in_code=False)


@pytest.mark.long
@pytest.mark.parametrize("name", ["bounded lag", "impulse, timed"])
def test_compiled_code_measures_it_to_the_last_bit(name: str) -> None:
    assert measured(name, in_code=True) == measured(name, in_code=False)


def test_no_jitter_is_no_clock() -> None:
    """To the last bit: a law's numbers are those of a scene without a clock."""
    for name in EVERY:
        parts = {**scene(), "controller": dict(EVERY[name])}
        one, other = made_of(with_clock(parts, 0.0)), made_of(parts)
        assert one == other
