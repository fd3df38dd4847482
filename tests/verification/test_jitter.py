"""A sample clock that jitters, against the 60-digit model with intervals drawn by whole numbers.

Compared are every sample of a trial, the recording of one, and that trials which are proven to rest do so, whatever the
intervals are.
"""

from collections.abc import Iterator
from itertools import islice
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.interval import begin_clock, next_span
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import RATTLE, GeneralMeasurer
from hknob_cli.scene.general_knob import GeneralKnob, follow_knob, sample_general
from hknob_cli.specs.plan import Record
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.record import record_trial
from tests import digits as mp

from . import general_reference as reference
from .general_scenes import LIGHT, RUBBING, TWO_PARTS, scene
from .law_scenes import FOR_EVER

SAMPLES = 150
CLEAR = 1e-6  # counts from an edge within which rounding may decide
WITHIN = 1e-9  # of a position, by the largest and a count
WITHIN_TEETH = 1e-6  # neighbours part tenfold in 10 to 29 ms where teeth part, and so do roundings
CASES: dict[str, dict[str, Any]] = {
    "alone": scene(),
    "friction": scene(knob=LIGHT),
    "much friction": scene(knob=RUBBING),
    "finger": scene(hand=TWO_PARTS),
    "finger, friction, lag": scene(hand=TWO_PARTS, knob=LIGHT, actuator={"time_constant": 3e-4}),
    "virtual damping": scene(wall={"damping": 3e-5}),
    "delay": scene(actuator={"delay_samples": 2.0}),
    "delay, steps, limit, dead band": scene(
        actuator={"delay_samples": 1.0, "torque_step": 3e-4, "torque_limit": 4e-3, "dead_band": 1e-3}
    ),
    "rounding, offset": scene(encoder={"rounding": "nearest", "offset_counts": 0.3}),
    "detents": scene(detents={"per_revolution": 60, "torque": 2e-3}),
    "winding": scene(
        motor={"torque_constant": 0.0234, "resistance": 2.32, "inductance": 2.38e-4, "winding": "shorted"}
    ),
}
COGGING = {"per_revolution": 84, "torque": 2e-3, "centre": 0.01}
GEAR = {"ratio": 7.4, "motor_inertia": 1e-8, "stiffness": 10.0, "mesh_damping": 2e-4, "backlash": 5e-3}
LIGHT_PUSH = {"torque": 3e-4}
THROUGH_PLAY = 60  # samples; the model steps through each of them
PASSED = {
    "hysteresis": scene(encoder={"hysteresis_counts": 0.7}),
    "slack": scene(encoder={"backlash": 2e-3}),
    "hysteresis, friction": scene(encoder={"hysteresis_counts": 1.3}, knob=LIGHT),
    "hysteresis, finger, lag": scene(
        encoder={"hysteresis_counts": 0.4}, hand=TWO_PARTS, actuator={"time_constant": 3e-4}
    ),
    "slack, delay": scene(encoder={"backlash": 1e-3}, actuator={"delay_samples": 1.0}),
    "cogging": scene(cogging=COGGING),
    "cogging, hysteresis, friction": scene(cogging=COGGING, encoder={"hysteresis_counts": 0.6}, knob=LIGHT),
    "backlash": scene(bias=LIGHT_PUSH, gear=GEAR),
    "backlash, friction of the motor": scene(bias=LIGHT_PUSH, gear={**GEAR, "motor_coulomb_torque": 6e-6}),
    "backlash, hysteresis": scene(bias=LIGHT_PUSH, gear=GEAR, encoder={"hysteresis_counts": 1.2}),
    "backlash, delay": scene(bias=LIGHT_PUSH, gear={**GEAR, "backlash": 2e-2}, actuator={"delay_samples": 1.0}),
}
JITTERS = {"small": 0.02, "a third": 0.33, "most": 0.9}


def intervals(jitter: float, seed: int, trial: int) -> Iterator[Any]:
    """Lengths of sample intervals, in periods: Park & Miller's numbers as whole numbers."""
    modulus = 2**31 - 1
    state = (65539 * seed + 30269 * trial) % (modulus - 1) + 1
    for _ in range(8):
        state = state * 16807 % modulus
    share = mp.mpf(jitter)
    while True:
        state = state * 16807 % modulus
        yield 1 - share + 2 * share * mp.mpf(state) / modulus


def knob_of(parts: dict[str, Any], rate: float = 1000.0, counts: int = 1024) -> GeneralKnob:
    """The cell of a scene."""
    from hknob_cli.specs.drive import reduced

    return sample_general(reduced(SceneSpec.model_validate(parts).plain()), sample_rate_hz=rate, counts_per_rev=counts)


def with_clock(parts: dict[str, Any], jitter: float, seed: int = 0) -> dict[str, Any]:
    """A scene whose clock jitters."""
    return {**parts, "clock": {"jitter": jitter, "seed": seed}}


def modelled(parts: dict[str, Any], jitter: float, seed: int, samples: int, **start: float) -> reference.Trial:
    """The model's run of a trial; ``start``: what of it is not as usual, the phase a part of the longest interval."""
    begins = {"velocity": -0.5, "phase": 0.37, "trial": 0, **start}
    return reference.simulate(
        parts,
        sample_rate_hz=1000.0,
        counts_per_rev=1024,
        angle_rad=0.02,
        velocity_rad_s=begins["velocity"],
        phase=mp.mpf(begins["phase"]) * (1 + mp.mpf(jitter)),
        samples=samples,
        intervals=list(islice(intervals(jitter, seed, int(begins["trial"])), samples)),
    )


@pytest.mark.parametrize("seed", [0, 7, 2**31 - 2])
@pytest.mark.parametrize("trial", [0, 1, 255])
def test_intervals_are_those_of_whole_numbers(seed: int, trial: int) -> None:
    """To the rounding of a double, and of their mean and least, as drawn evenly."""
    clock = knob_of(with_clock(scene(), 0.25, seed)).wall.clock
    begin_clock(clock, float(trial))
    drawn = [1.25 * next_span(clock) for _ in range(4000)]
    exact = [float(one) for one in islice(intervals(0.25, seed, trial), 4000)]
    np.testing.assert_allclose(drawn, exact, rtol=1e-15)
    assert abs(np.mean(drawn) - 1.0) < 5 * 0.25 / np.sqrt(3.0 * 4000)
    assert 0.75 <= min(drawn) < 0.752
    assert 1.248 < max(drawn) <= 1.25


@pytest.mark.one_in(9)
@pytest.mark.parametrize("jitter", JITTERS)
@pytest.mark.parametrize("name", CASES)
def test_every_sample(name: str, jitter: str) -> None:
    share, seed = JITTERS[jitter], Random(f"{name} {jitter}").randrange(1000)
    parts = with_clock(CASES[name], share, seed)
    knob = knob_of(parts)
    numbers: dict[str, Any] = {"angle_rad": 0.02, "velocity_rad_s": -0.5, "phase": 0.37, "samples": SAMPLES}
    got = follow_knob(knob, **numbers)
    model = modelled(CASES[name], share, seed, SAMPLES)
    size = 1.0 + float(np.abs(got.angle_rad).max()) / knob.quantum_rad
    clear, compared = min(model.edge / knob.quantum_rad, model.step / (0.27 * knob.quantum_rad)), 0
    assert clear > CLEAR, "rounding may decide: choose another seed"
    for i, sample in enumerate(model.samples):
        assert abs(float((sample.angle - mp.mpf(float(got.angle_rad[i]))) / knob.quantum_rad)) <= WITHIN * size
        assert got.time_s[i] == pytest.approx(float(sample.time), rel=1e-12)
        compared += 1
    assert compared == SAMPLES + 1


@pytest.mark.one_in(11)
@pytest.mark.parametrize("jitter", ["a third", "most"])
@pytest.mark.parametrize("name", PASSED)
def test_every_sample_past_turning_points_and_teeth(name: str, jitter: str) -> None:
    """What happens between samples, in intervals of any length."""
    share, seed = JITTERS[jitter], Random(f"{name} {jitter}").randrange(1000)
    knob = knob_of(with_clock(PASSED[name], share, seed))
    samples = THROUGH_PLAY if "backlash" in name else SAMPLES
    numbers: dict[str, Any] = {"angle_rad": 0.02, "velocity_rad_s": -0.5, "phase": 0.37, "samples": samples}
    got = follow_knob(knob, **numbers)
    model = modelled(PASSED[name], share, seed, samples)
    size = 1.0 + float(np.abs(got.angle_rad).max()) / knob.quantum_rad
    assert model.edge / knob.quantum_rad > CLEAR, "rounding may decide: choose another seed"
    assert len(model.levels) > 2
    if "backlash" in name:
        assert model.friction.parted > 0
    within = WITHIN_TEETH if "backlash" in name else WITHIN
    for i, sample in enumerate(model.samples):
        assert abs(float((sample.angle - mp.mpf(float(got.angle_rad[i]))) / knob.quantum_rad)) <= within * size


@pytest.mark.long
@pytest.mark.drawn(7)
@pytest.mark.parametrize("jitter", JITTERS)
@pytest.mark.parametrize("name", [*CASES, *PASSED])
def test_compiled_to_the_last_bit(name: str, jitter: str) -> None:
    share, seed = JITTERS[jitter], Random(f"{name} {jitter}").randrange(1000)
    knob = knob_of(with_clock({**CASES, **PASSED}[name], share, seed))
    numbers: dict[str, Any] = {"angle_rad": 0.02, "velocity_rad_s": -0.5, "phase": 0.37, "samples": SAMPLES}
    for one, other in zip(follow_knob(knob, **numbers), follow_knob(knob, **numbers, compiled=True), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("parts", [CASES["delay"], PASSED["slack, delay"]])
def test_a_recording_has_the_samples_of_the_trial(parts: dict[str, Any]) -> None:
    knob = knob_of(with_clock(parts, 0.3, 5))
    rows = list(record_trial(knob, Record(0.1, 1e-3, 1), angle=0.02, velocity=-0.5, phase=0.37))
    sampled = [row for row in rows if row.event == "sample"]
    trial = follow_knob(knob, angle_rad=0.02, velocity_rad_s=-0.5, phase=0.37, samples=len(sampled) - 1)
    np.testing.assert_allclose([row.time for row in sampled], trial.time_s, rtol=1e-12)
    np.testing.assert_allclose([row.angle for row in sampled], trial.angle_rad, rtol=0.0, atol=1e-12)
    assert np.ptp(np.diff(trial.time_s)) > 3e-4
    other = [
        row.time
        for row in record_trial(knob, Record(0.1, 1e-3, 1), angle=0.02, velocity=-0.5, phase=0.37, trial=1)
        if row.event == "sample"
    ]
    assert other[1:5] != [row.time for row in sampled][1:5]


def search(parts: dict[str, Any], phases: int = 8, counts: int = 1024, *, in_code: bool = False) -> Any:
    """Ends of trials, and the knob; ``in_code``: of longer trials, by compiled code, which few do not repay."""
    knob = knob_of(parts, counts=counts)
    found = (GeneralEngine(compiled("general")) if in_code else GeneralEngine(patience=FOR_EVER)).search(
        knob.body,
        knob.wall,
        knob.start(0.02, 0.0),
        rate=knob.rate,
        phases=phases,
        delay_line=knob.delay_line,
        max_samples=2**15 if in_code else 2**10,
    )
    return knob, found.attractors


@pytest.mark.parametrize("in_code", [False, pytest.param(True, marks=pytest.mark.long)])
@pytest.mark.parametrize("jitter", [0.05, 0.5])
def test_trials_that_are_proven_to_rest_do_so_in_the_model(jitter: float, in_code: bool) -> None:
    """Each by its own intervals, where the package says; friction holds them in a range."""
    parts = scene(knob={"coulomb_torque": 8e-4})
    knob, ends = search(with_clock(parts, jitter), phases=4, in_code=in_code)
    (rest,) = ends
    assert (rest.outcome, rest.certified, rest.trials) == (Outcome.REST, True, 4.0)
    low, high = rest.span or (rest.x, rest.x)
    found = []
    for trial in range(4):
        last = modelled(parts, jitter, 0, 300, velocity=0.0, phase=(trial + 0.5) / 4, trial=trial).samples[-1]
        assert last.velocity == 0
        found.append(float(last.angle / mp.mpf(knob.quantum_rad)) - knob.shift)
    assert [min(found), max(found)] == pytest.approx([low, high], abs=1e-9)
    assert high - low > 0.01


@pytest.mark.parametrize("in_code", [False, pytest.param(True, marks=pytest.mark.long)])
def test_what_does_not_rest_is_measured_and_not_proven(in_code: bool) -> None:
    knob, ends = search(with_clock(CASES["alone"], 0.2, 3), in_code=in_code)
    (one,) = ends
    assert (one.outcome, one.reason, one.trials) == (Outcome.UNDECIDED, Reason.JITTERS, 8.0)
    for functions in (None, *([compiled("general")] if in_code else [])):
        found = GeneralMeasurer(knob, GeneralEngine(functions)).measure(one)
        assert found.cycles == 0
        assert not found.p2p_rad > 0.0
        assert 1e-3 < found.jitter_p2p_rad < found.jitter_range_rad < 1e-2
        assert 50.0 < found.jitter_frequency_hz < 200.0
        assert found.jitter_frequency_hz * RATTLE / 1000.0 > 100.0


def test_no_jitter_is_no_clock() -> None:
    """To the last bit: the trials of a scene without one."""
    assert knob_of(with_clock(scene(), 0.0)).wall.clock is None
    assert knob_of(with_clock(scene(), 0.0)) == knob_of(scene())


@pytest.mark.parametrize("in_code", [False, pytest.param(True, marks=pytest.mark.long)])
def test_a_knob_behind_a_gear_has_its_own_swing(in_code: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside that of the motor, which the encoder is on, and whether teeth part; interpreted, of fewer samples."""
    if not in_code:
        monkeypatch.setattr("hknob_cli.measure.general_orbit.RATTLE", RATTLE // 8)
    knob, ends = search(with_clock(PASSED["backlash"], 0.2, 3), phases=2 if in_code else 1, counts=360, in_code=in_code)
    (one,) = ends
    assert one.reason is Reason.JITTERS
    found = GeneralMeasurer(knob, GeneralEngine(compiled("general") if in_code else None)).measure(one)
    assert 0.0 < found.jitter_range_rad < 0.1
    assert 0.0 < found.knob_p2p_rad < 0.1
    assert found.knob_p2p_rad != found.jitter_range_rad
    assert found.mesh_least_nm <= 0.0 < found.mesh_most_nm
