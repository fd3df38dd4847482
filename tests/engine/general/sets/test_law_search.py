"""Tests of `engine.general.sets.law_search`: complete lists under a controller, those that many trials find.

Random scenes have a controller beside friction, delay, limit, step or virtual damping, or alone.
"""

from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import LawKnob, make_law
from hknob_cli.engine.attractors import Attractor, Patience, Search
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.laws.step import begin_past
from hknob_cli.engine.general.sets.friction_phases import fly
from hknob_cli.engine.general.sets.friction_room import can_rub, plane_of
from hknob_cli.engine.general.sets.law_search import LawSetEngine, LawStatesEngine
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY
from tests.engine.general.law_runs import states_with_law

LONG = Patience(samples=10**9, seconds=300.0)
SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}
FINGER = {
    "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
COIL = {"torque_constant": 0.0234, "resistance": 2.32, "winding": "shorted", "inductance": 2.4e-4}
RUBS = {"knob": {"inertia": 1.9e-6, "coulomb_torque": 2.0e-4}}
LATE = {"actuator": {"delay_samples": 1.0}}
LAGS = {"actuator": {"delay_samples": 1.0, "time_constant": 5e-5}}
BEHIND: dict[str, Any] = {"encoder": {"hysteresis_counts": 0.4}}
CASES: list[tuple[str, dict[str, Any]]] = [
    ("bounded lag", RUBS | LATE),
    ("bounded lag", {"actuator": {"delay_samples": 0.4, "torque_step": 2e-4}}),
    ("half sample", RUBS),
    ("matched wall", {"wall": {"stiffness": 0.27, "damping": 1e-5}, "encoder": {"rounding": "nearest"}}),
    ("damping, differenced", RUBS | {"actuator": {"torque_limit": 4e-3}}),
    ("impulse, short", RUBS | {"actuator": {"delay_samples": 0.5}}),
    ("phase, 90", LATE),
    ("first-order hold", {}),
    ("first-order hold, fitted", {"encoder": {"rounding": "nearest", "offset_counts": 0.3}}),
    ("first-order hold, fitted, in steps", RUBS),
    ("bounded lag", RUBS | LAGS),
    ("half sample", {"actuator": {"time_constant": 2e-4}}),
    ("damping, differenced", RUBS | {"actuator": {"time_constant": 1e-3, "torque_limit": 4e-3}}),
    ("impulse, short", RUBS | {"actuator": {"time_constant": 1e-4}}),
    ("bounded lag", RUBS | LATE | BEHIND),
    ("half sample", RUBS | BEHIND),
    ("half sample", BEHIND),
    ("damping, differenced", RUBS | LAGS | BEHIND),
    ("speed, timed, filtered", RUBS | BEHIND),
]
# What estimates: differences over samples, times between counts, lines, a tracking filter, Kalman's, low-passes.
ESTIMATES: list[tuple[str, dict[str, Any]]] = [
    ("velocity, windowed", RUBS | LATE),
    ("velocity, filtered", RUBS),
    ("velocity, filtered, cut off", {}),
    ("speed, timed", LAGS),
    ("speed, timed, filtered", RUBS | LATE),
    ("speed, adaptive", RUBS),
    ("speed, adaptive", LATE),
    ("speed, adaptive, filtered", RUBS | LAGS),
    ("speed, tracked", LATE),
    ("speed and angle, tracked", {}),
    ("speed and angle, tracked", RUBS | {"actuator": {"torque_limit": 4e-3}}),
    ("speed, Kalman", RUBS),
    ("speed, Kalman", {"actuator": {"time_constant": 2e-4, "torque_step": 2e-4}}),
    ("angle, filtered", {"actuator": {"dead_band": 6e-4}}),
    ("speed and angle, filtered", RUBS),
    ("speed and angle, filtered", {"encoder": {"rounding": "nearest", "offset_counts": 0.3}}),
    ("phase, Kalman", RUBS),
    ("phase, Kalman", {"actuator": {"delay_samples": 0.4}}),
]
MORE_STATES: list[tuple[str, dict[str, Any]]] = [
    ("bounded lag", {"hand": FINGER}),
    ("damping, differenced", {"hand": FINGER} | LAGS),
    ("speed, tracked", {"hand": FINGER} | LATE),
    ("passivity", {"hand": FINGER, "actuator": {"torque_limit": 4e-3}}),
    ("bounded lag", {"motor": COIL}),
    ("phase, 90", {"hand": FINGER, "motor": COIL, "wall": {"stiffness": 0.27, "damping": 1e-5}}),
    ("first-order hold", {"hand": FINGER, "detents": {"per_revolution": 100, "torque": 1e-3}}),
]


# Gains beyond what is stable, against limits, dead bands and steps.
HOSTILE: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "timed, ten times too much": (
        {"velocity": "timed", "damping": 3e-3, "time_out": 0.02, "detections": 3},
        {"actuator": {"torque_limit": 3e-3}},
    ),
    "adaptive, drives": (
        {"velocity": "adaptive", "damping": -1.5e-4, "window": 6},
        RUBS | {"actuator": {"delay_samples": 1.0, "torque_limit": 4e-3}},
    ),
    "tracked, everywhere, dead band": (
        {"velocity": "tracking", "damping": 2e-3, "bandwidth": 220.0, "everywhere": True, "angle": "filtered"},
        RUBS | {"actuator": {"delay_samples": 1.0, "dead_band": 5e-4, "torque_limit": 5e-3}},
    ),
    "Kalman, steps, cut off": (
        {"velocity": "kalman", "damping": 1e-3, "acceleration": 3000.0, "cut_off": 1.5},
        {"actuator": {"delay_samples": 0.4, "torque_step": 5e-4, "torque_limit": 6e-3}},
    ),
    "filtered, late, dead band": (
        {"damping": 1e-3, "low_pass": 0.01, "angle": "filtered", "cut_off": 2.0},
        RUBS | {"actuator": {"delay_samples": 2.0, "dead_band": 4e-4, "torque_limit": 4e-3}},
    ),
}


def cell(name: str, rate: float = 464.2, counts: int = 256, **parts: Any) -> tuple[LawKnob, Law, int]:
    """A cell under a controller, its law in lists, and how much is remembered."""
    return cell_of(EVERY[name], rate, counts, **parts)


def cell_of(controller: dict[str, Any], rate: float, counts: int, **parts: Any) -> tuple[LawKnob, Law, int]:
    """The same of a controller as a spec has it."""
    plain = reduced(SceneSpec.model_validate({**SCENE, **parts, "controller": controller}).plain())
    made = make_law(plain, sample_rate_hz=rate, counts_per_rev=counts)
    engine = LawEngine(made.law, patience=LONG)
    return made, engine.law, engine.past_length


def search(
    made: LawKnob, law: Law, length: int, engine: type[GeneralSetEngine] | None = None, **limits: Any
) -> Search | None:
    """All clock phases of the start at 20 mrad; by the engine of more states where the body has them."""
    knob, given = made.knob, {"rate": made.rate, "delay_line": length, "max_samples": None, **limits}
    kind: Any = engine or (LawStatesEngine if knob.body.ratio + knob.body.coil > 0.0 else LawSetEngine)
    found: Search | None = kind(law, patience=LONG).search_phases(knob.body, knob.wall, knob.start(0.02, 0.0), **given)
    return found


def first_state(made: LawKnob, phase: float) -> list[float]:
    """State at the first sample of a clock phase: no torque acts before it."""
    start = made.knob.start(0.02, 0.0)
    if made.knob.body.ratio + made.knob.body.coil > 0.0:
        advance_span(start, 0.0, phase, made.knob.body, [0.0] * (2 * made.knob.body.order))
        return start
    return [*fly(*start[:2], phase, plane_of(made.knob.body)), *start[2:]]


def on_list(found: tuple[Attractor, ...], made: LawKnob, law: Law, z: list[float]) -> list[int]:
    """Which attractors a state that has settled is on, or rests in the reading of."""
    numbers = []
    for number, one in enumerate(found):
        states = states_with_law(made.knob, law, [one.x, one.v, *one.state], list(one.line), one.period)
        near = np.abs(states - np.array(z)).max(axis=1).min() < 1e-6
        same = one.outcome is Outcome.REST and read(z[0], made.knob.wall) == read(one.x, made.knob.wall)
        if near or (same and made.knob.body.friction > 0.0 and abs(z[1]) < 1e-6):
            numbers.append(number)
    return numbers


def follow_trials(made: LawKnob, law: Law, length: int, trials: int) -> None:
    """Find all phases, whose list must be complete; no trial ends elsewhere, and shares agree as so many can tell."""
    found = search(made, law, length)
    assert found is not None
    assert found.complete
    assert found.why is Reason.NONE
    assert all(one.certified for one in found.attractors)
    assert sum(one.trials for one in found.attractors) == pytest.approx(1.0, abs=1e-6)
    knob, counted = made.knob, [0] * len(found.attractors)
    for trial in range(trials):
        z = first_state(made, (trial + 0.5) / trials)
        past = [0.0] * length
        begin_past(past, read(z[0], knob.wall), law)
        states_with_law(made.knob, law, z, past, int(45.0 / made.rate) + 200)
        (number,) = on_list(found.attractors, made, law, z)
        counted[number] += 1
    for one, count in zip(found.attractors, counted, strict=True):
        assert abs(one.trials - count / trials) < 6 / 24


@pytest.mark.one_in(16)
@pytest.mark.parametrize(("name", "parts"), CASES + ESTIMATES)
def test_phases_end_where_trials_end(name: str, parts: dict[str, Any]) -> None:
    """Of 24 trials, each on an orbit or in a rest that is listed."""
    follow_trials(*cell(name, **parts), trials=24)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("name", "parts"), MORE_STATES)
def test_phases_of_more_states_end_where_trials_end(name: str, parts: dict[str, Any]) -> None:
    """Beside a finger, a winding, and teeth that yield: of 24 trials."""
    follow_trials(*cell(name, **parts), trials=24)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["half sample", "bounded lag", "impulse, short", "speed, Kalman", "angle, filtered"])
def test_both_engines_find_the_same(name: str) -> None:
    """Arcs, and phases followed as thin pieces, with a torque that lags: the same list, shares to 2^-16 a boundary."""
    made = cell(name, actuator={"time_constant": 2e-4})
    one, other = search(*made), search(*made, LawStatesEngine)
    assert one is not None
    assert other is not None
    assert one.complete
    assert other.complete
    listed = [
        {(end.outcome, end.period, round(end.x, 6), round(end.v, 6)): end.trials for end in found.attractors}
        for found in (one, other)
    ]
    assert listed[0].keys() == listed[1].keys()
    for key, share in listed[0].items():
        assert share == pytest.approx(listed[1][key], abs=2.0**-16 * other.pieces)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", HOSTILE)
def test_phases_end_where_trials_end_however_hostile_the_gains(name: str) -> None:
    """Of 24 trials."""
    controller, parts = HOSTILE[name]
    made = cell_of({"kind": "velocity_damping", **controller}, 464.2, 256, **parts)
    follow_trials(*made, trials=24)


def test_what_is_not_followed() -> None:
    """What reads a velocity sensor; a filter that no norm is known for; and without a hand's spring."""
    made, law, length = cell("speed, tracked", rate=215.0)  # its bandwidth is half the sample rate
    assert not law.provable
    assert search(made, law, length) is None
    made, law, length = cell("half sample, sensor")
    assert not can_rub(made.knob.body, made.knob.wall, law)
    assert search(made, law, length) is None
    made, law, length = cell("bounded lag", hand={"inertia": 3e-7, "damping": 3.45e-4})
    assert search(made, law, length) is None
    for name in ("half sample, sensor", "impulse, timed"):
        assert search(*cell(name, hand=FINGER)) is None


def test_too_few_samples_are_not_complete() -> None:
    made, law, length = cell("bounded lag", **RUBS)
    found = search(made, law, length, max_samples=5)
    assert found is not None
    assert not found.complete
    assert found.why is not Reason.NONE


def test_a_stiff_friction_holds_the_knob_under_a_lag() -> None:
    """All trials come to rest, in readings that are listed."""
    made, law, length = cell(
        "bounded lag", rate=1000.0, counts=1024, knob={"inertia": 1.9e-6, "coulomb_torque": 1.5e-3}
    )
    found = search(made, law, length)
    assert found is not None
    assert found.complete
    assert {one.outcome for one in found.attractors} == {Outcome.REST}
    for trial in range(8):
        z = first_state(made, (trial + 0.5) / 8)
        past = [0.0] * length
        begin_past(past, read(z[0], made.knob.wall), law)
        states_with_law(made.knob, law, z, past, 2000)
        assert on_list(found.attractors, made, law, z)
