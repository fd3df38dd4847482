"""Tests of `engine.general.sets.friction_arc` and `friction_arcs`: no phase leaves its arc, whatever friction does."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.advance import rub_many
from hknob_cli.engine.general.body import acceleration, norm, stiffness
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.friction_arc import (
    ERROR,
    FROM,
    HIGH,
    LOW,
    STANDS,
    STATE,
    TO,
    ball_of,
    begin_arc,
    begin_ball,
    rub_arc,
    start_rate,
    stop_bound,
)
from hknob_cli.engine.general.sets.friction_arc_rest import stay_held
from hknob_cli.engine.general.sets.friction_arc_search import (
    FrictionArcEngine,
    can_rub_arcs,
    make_rub_room,
    rub_drift,
)
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.engine.general.bodies import knob
from tests.verification.general_scenes import HEAVY, RINGING, STIFF, TWO_PARTS

from .cells import all_phases, zeros

COIL = {"torque_constant": 0.0234, "resistance": 2.32, "winding": "shorted", "inductance": 2.4e-4}
GRASP = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}
MESH = {"ratio": 2.0, "motor_inertia": 1e-7, "stiffness": 3.0, "mesh_damping": 4e-4}
KINDS: dict[str, dict[str, Any]] = {
    "finger": {"hand": TWO_PARTS},
    "finger that rings": {"hand": RINGING},
    "heavy finger": {"hand": HEAVY},
    "stiff finger": {"hand": STIFF},
    "winding": {"motor": COIL, "hand": GRASP},
    "teeth": {"gear": MESH, "hand": GRASP},
    "finger, lag": {"hand": TWO_PARTS, "actuator": {"time_constant": 2e-4}},
    "winding, finger, lag": {"motor": COIL, "hand": TWO_PARTS, "actuator": {"time_constant": 5e-5}},
}
LEVELS = (0.0, 1e-5, 1e-4, 5.6e-4, 2e-3)


def rubbing(kind: str, level: float, rate: float, **more: Any) -> GeneralKnob:
    """A cell of this kind, its knob with so much friction, N·m, and with ``more`` parts of a scene."""
    scene = {
        "knob": {"inertia": 1.9e-6, "coulomb_torque": level},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
        **KINDS[kind],
        **more,
    }
    plain = reduced(SceneSpec.model_validate(scene).plain())
    return sample_general(plain, sample_rate_hz=rate, counts_per_rev=1024)


PHASES_OF_ARCS = {
    "kind": st.sampled_from(sorted(KINDS)),
    "level": st.sampled_from(LEVELS),
    "rate": st.sampled_from([100.0, 464.2, 2154.0, 10000.0]),
    "seed": st.integers(0, 2**32 - 1),
    "length": st.floats(-7.0, 0.0),
}


@settings(deadline=None, max_examples=8)
@given(**PHASES_OF_ARCS)
def test_no_phase_leaves_its_arc(kind: str, level: float, rate: float, seed: int, length: float) -> None:
    """Each of 9, moved by itself, is in the ball beside the line after every hold, and stands where all of it does."""
    one, chance = rubbing(kind, level, rate), np.random.default_rng(seed)
    body, n = one.body, one.body.order
    drift, room = rub_drift(body, one.wall), make_rub_room(zeros, list, body, one.wall, 0, None)
    low = float(chance.uniform(0.0, 1.0 - 10.0**length)) if length < 0.0 else 0.0
    width = min(10.0**length, 1.0 - low)
    for j in range(STATE):
        room.arc[j] = 0.0
    room.arc[LOW], room.arc[HIGH] = low, low + width
    start = one.start(float(chance.choice([0.0, 0.02, -0.01])), float(chance.choice([0.0, 0.0, 1.0, -0.3])))
    begin_arc(start, start_rate(start, body, room.pad), room, drift, body)
    parts = np.linspace(-1.0, 1.0, 9)
    states = []
    for part in parts:
        z = list(start)
        rub_many(z, 0.0, low + 0.5 * width * (1.0 + float(part)), body, zeros(2 * n))
        states.append(z)
    follow_holds(one, room, drift, parts, states, chance)


@pytest.mark.long
@settings(deadline=None, max_examples=20)
@given(**PHASES_OF_ARCS)
def test_no_phase_leaves_its_arc_of_more(**drawn: Any) -> None:
    test_no_phase_leaves_its_arc.hypothesis.inner_test(**drawn)


def follow_holds(one: GeneralKnob, room: Any, drift: Any, parts: Any, states: list[Any], chance: Any) -> None:
    """States at these parts of the line stay beside it, and stand where all of the arc does, over holds at random."""
    body, n = one.body, one.body.order
    scale, u = one.wall.kappa * 3.0 + body.friction, 0.0
    for _ in range(24):
        if chance.random() < 0.5:
            u = float(scale * chance.normal())
        if chance.random() < 0.3:  # about as much as friction can hold
            u = float(chance.uniform(-1.3, 1.3) * body.friction) - acceleration(room.z, 0.0, body)
        span = float(chance.choice([1.0, 0.5, chance.uniform(0.01, 1.0)]))
        stood = room.arc[STANDS] > 0.0
        before = [z[0] for z in states]
        rub_arc(room, room.z, u, span, drift, body)
        for part, z, was in zip(parts, states, before, strict=True):
            rub_many(z, u, span, body, zeros(2 * n))
            beside = [z[j] - room.z[j] - float(part) * room.columns[j] for j in range(n)]
            own = 64.0 * EPSILON * norm([abs(at) + 1.0 for at in z], body)  # that of the motion compared with
            assert norm(beside, body) <= (ball_of(room, body) + room.arc[ERROR]) * (1.0 + 1e-9) + own
            if room.arc[STANDS] > 0.0:
                assert z[1] == 0.0
                assert not stood or z[0] == was


STRAIGHT_ARCS = {
    "kind": st.sampled_from(sorted(KINDS)),
    "level": st.sampled_from(LEVELS[1:]),
    "rate": st.sampled_from([100.0, 464.2, 2154.0, 10000.0]),
    "seed": st.integers(0, 2**32 - 1),
    "length": st.floats(-6.0, 0.0),
    "round_": st.sampled_from([0.0, 0.0, 0.1]),
}


@settings(deadline=None, max_examples=8)
@given(**STRAIGHT_ARCS)
def test_no_state_of_a_straight_arc_leaves_it(
    kind: str, level: float, rate: float, seed: int, length: float, round_: float
) -> None:
    """Nothing is beside the line, or states are up to so much of its length: stops add what they do, and no less."""
    one, chance = rubbing(kind, level, rate), np.random.default_rng(seed)
    body, n = one.body, one.body.order
    drift, room = rub_drift(body, one.wall), make_rub_room(zeros, list, body, one.wall, 0, None)
    free = n - (body.lag > 0.0)
    spans = np.array(list(room.spans))[:free]
    size = 10.0**length

    def some() -> list[float]:
        """A difference of norm 1 in what states may differ in."""
        away = [*(spans * chance.normal(size=free)).tolist(), *([0.0] * (n - free))]
        return [value / norm(away, body) for value in away]

    speed = float(chance.choice([1.0, 0.1, 0.01])) * (1.0 + size)
    centre, line = [3.0 * speed * value for value in some()], [size * value for value in some()]
    if chance.random() < 0.4:
        centre[1] = 0.0
    for j in range(n):
        room.z[j], room.columns[j] = centre[j], line[j]
    room.arc[ERROR] = 8.0 * EPSILON * norm([abs(value) for value in centre], body)
    begin_ball(room, round_ * size, body)
    parts, states = np.linspace(-1.0, 1.0, 9), []
    for part in parts:
        more = some()
        states.append([centre[j] + float(part) * line[j] + round_ * size * more[j] for j in range(n)])
    follow_holds(one, room, drift, parts, states, chance)


@pytest.mark.long
@settings(deadline=None, max_examples=25)
@given(**STRAIGHT_ARCS)
def test_no_state_of_a_straight_arc_leaves_it_of_more(**drawn: Any) -> None:
    test_no_state_of_a_straight_arc_leaves_it.hypothesis.inner_test(**drawn)


def phases_of(one: GeneralKnob, **limits: Any) -> Any:
    """All clock phases of one start."""
    return all_phases(FrictionArcEngine(), one, **limits)


def end_of(one: GeneralKnob, phase: float) -> list[float]:
    """State of the trial of one clock phase after 600 samples."""
    z, pad = one.start(0.02, 0.0), zeros(2 * one.body.order)
    rub_many(z, 0.0, phase, one.body, pad)
    before, ring, head = read(z[0], one.wall), zeros(one.delay_line), 0
    for _ in range(600):
        before, head = advance(z, before, ring, head, one.body, one.wall, pad)
    return z


@pytest.mark.parametrize(
    ("kind", "level", "rate"),
    [
        pytest.param("finger", 5.6e-4, 464.2, marks=pytest.mark.long),
        pytest.param("winding", 2e-4, 464.2, marks=pytest.mark.long),
        pytest.param("finger, lag", 1e-4, 464.2, marks=pytest.mark.long),
        ("stiff finger", 1e-3, 1000.0),
    ],
)
def test_phases_end_where_trials_end(kind: str, level: float, rate: float) -> None:
    """No trial of 24 ends on an orbit that is not listed, and shares agree as far as 24 trials can tell."""
    one = rubbing(kind, level, rate)
    found = phases_of(one)
    assert (found.complete, found.why) == (True, Reason.NONE)
    assert sum(each.trials for each in found.attractors) == pytest.approx(1.0, abs=1e-9)
    counted = [0] * len(found.attractors)
    for trial in range(24):
        x, v, *_ = end_of(one, (trial + 0.5) / 24)
        near = []
        for number, each in enumerate(found.attractors):
            if each.outcome is Outcome.REST:
                if abs(v) < 1e-9 and read(x, one.wall) == read(each.x, one.wall):
                    near.append(number)
                continue
            z, before, ring, head = [each.x, each.v, *each.state], each.before, list(each.line), 0
            for _ in range(each.period):
                if abs(z[0] - x) + abs(z[1] - v) < 1e-7:
                    near.append(number)
                before, head = advance(z, before, ring, head, one.body, one.wall, zeros(2 * one.body.order))
        assert len(near) == 1
        counted[near[0]] += 1
    for each, count in zip(found.attractors, counted, strict=True):
        assert abs(each.trials - count / 24) < 4 / 24


def test_too_few_samples_are_not_complete() -> None:
    """A budget within which nothing settles: said, and why."""
    found = phases_of(rubbing("finger", 5.6e-4, 464.2), max_samples=3)
    assert not found.complete
    assert found.why is not Reason.NONE
    assert all(each.outcome is Outcome.UNDECIDED for each in found.attractors)


@pytest.mark.parametrize(
    "parts",
    [
        {"encoder": "none", "hand": TWO_PARTS},
        {},
        {"hand": {**TWO_PARTS, "finger": {**TWO_PARTS["finger"], "stiffness": 0.0}}},
    ],
)
def test_other_scenes_are_not_followed(parts: dict[str, Any]) -> None:
    """With a continuous sensor, angle and speed alone, or where nothing holds the finger."""
    one = knob(1000.0, None if parts.get("encoder") == "none" else 512, **parts)
    assert not can_rub_arcs(one.body, one.wall)
    assert phases_of(one) is None


def test_a_cell_that_is_too_much_work_is_left_to_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FrictionArcEngine, "longest_phases", lambda *_: 10)
    monkeypatch.setattr("hknob_cli.engine.general.sets.friction_search.SLICE_INTERPRETED", 1)
    assert phases_of(rubbing("finger", 1e-4, 2154.0)) is None


class Waits(FrictionArcEngine):
    """After all the work of a cell an interval waits that counts no phases: what an edge may hide of its neighbour."""

    def phase_follower(self, body: Any, wall: Any, _start: Any, delay_line: int, _scope: Any) -> Any:
        def follow(_waiting: int, _samples: int, stack: Any) -> tuple[int, int, float, float, int]:
            stack[FROM] = stack[TO]
            return 1, 15, 0.0, 1.0, self.longest_phases(body) + 1

        return follow, self.ready(body, wall, delay_line).known


def test_nothing_is_complete_while_an_interval_waits() -> None:
    """Not even one that counts no phases."""
    assert all_phases(Waits(), rubbing("finger", 5.6e-4, 464.2)) is None


def test_what_a_stop_adds_is_of_the_second_order() -> None:
    """Half of the size, a quarter of it; none of a stop at a rate that does not jump is left to the jump."""
    one = rubbing("finger", 5.6e-4, 464.2)
    room = make_rub_room(zeros, list, one.body, one.wall, 0, None)
    for slope in (-1.0, 0.3):
        whole, half = (stop_bound(0.7, 0.5, 0.0, slope, s, 2.0 * s / 0.7, room, one.body) for s in (1e-3, 5e-4))
        assert half == pytest.approx(0.25 * whole, rel=1e-3)
    assert stop_bound(0.7, 0.0, 0.1, -1.0, 1e-3, 3e-3, room, one.body) == 0.0


def arc_of(one: GeneralKnob, centre: list[float], line: list[float]) -> tuple[Any, Any]:
    """A straight arc, with nothing beside its line, and the bounds of its cell."""
    drift, room = rub_drift(one.body, one.wall), make_rub_room(zeros, list, one.body, one.wall, 0, None)
    for j in range(one.body.order):
        room.z[j], room.columns[j] = centre[j], line[j]
    begin_ball(room, 0.0, one.body)
    return room, drift


def held_by(one: GeneralKnob, pull: float) -> float:
    """Torque that leaves so much of a pull on a knob at 0."""
    return pull - acceleration([0.0] * one.body.order, 0.0, one.body)


@pytest.mark.parametrize(("part", "stand"), [(0.5, False), (1.5, True)])
def test_states_beside_a_knob_that_stands_are_given_time_to_stop(part: float, stand: bool) -> None:
    """They stop within the hold where friction takes their speed in it, and no pull between them and it is more."""
    one = rubbing("finger", 5.6e-4, 10_000.0)
    body, speed = one.body, 1e-4
    line = [0.0, speed, 0.0, speed]  # the finger stands: it is told by its motion against the knob
    room, drift = arc_of(one, [0.0] * 4, line)
    apart = norm(line, body)
    grip = stiffness(body) * apart + part * apart
    u = held_by(one, body.friction - grip)
    member = list(line)
    rub_arc(room, room.z, u, 1.0, drift, body)
    rub_many(member, u, 1.0, body, zeros(8))
    assert (room.arc[STANDS] > 0.0, member[1] == 0.0) == (stand, stand)


@pytest.mark.parametrize(("late", "stand"), [(0.8, True), (0.98, False)])
def test_all_states_have_stopped_before_a_hold_is_over(late: float, stand: bool) -> None:
    """The centre stops at ``late``; some of them stop 1/25 of a hold after it."""
    one = rubbing("finger", 5.6e-4, 10_000.0)
    body = one.body
    centre, line = [0.0, late * body.friction, 0.0, 0.0], [0.0, 0.04 * body.friction, 0.0, 0.0]
    centre[3] = centre[1]
    line[3] = line[1]
    room, drift = arc_of(one, centre, line)
    u, member = held_by(one, 0.0), [p + q for p, q in zip(centre, line, strict=True)]
    rub_arc(room, room.z, u, 1.0, drift, body)
    rub_many(member, u, 1.0, body, zeros(8))
    assert room.z[1] == 0.0
    assert (room.arc[STANDS] > 0.0, member[1] == 0.0) == (stand, stand)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("other", "stay"), [(0.05, True), (0.2, False)])
def test_a_torque_that_lags_holds_all_states_only_if_it_does_on_its_way(sign: float, other: float, stay: bool) -> None:
    """It is 9/10 of the level, and goes to half of it: states by 1/5 of the level beside that are let go now."""
    body = rubbing("winding", 5.6e-4, 1000.0, actuator={"time_constant": 2e-4}).body
    still = [0.0] * body.order
    pull = acceleration(still, 0.0, body)
    still[-1] = sign * 0.9 * body.friction - pull
    kept = list(still)
    assert stay_held(still, sign * 0.5 * body.friction - pull, other * body.friction, body) is stay
    assert still == kept
