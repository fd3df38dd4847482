"""Backlash of a gear beside what else acts on the motor: controllers; against a 60-digit model in steps.

Bounds are those of `test_laws_in_the_general_loop`. The model brackets where teeth meet and part; it follows no event
that begins and ends within 1/64 of a sample, which would show as a difference.
"""

from math import pi
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.columns import CORNER_ROOM, begin_marks
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance, advance_columns
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.engine.general.search import GeneralEngine, as_arrays, make_space
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import RATTLE, GeneralMeasurer, LawMeasurer
from hknob_cli.scene.general_knob import sample_general, simulate
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY

from . import general_reference as reference
from .law_scenes import Drawn, reduce, search
from .test_laws_in_the_general_loop import CLEAR, WITHIN, check_orbit, check_trial
from .test_pulse_beside_controllers import check_pulse

GEAR: dict[str, Any] = {
    "ratio": 7.4,
    "motor_inertia": 1e-8,
    "stiffness": 10.0,
    "mesh_damping": 2e-3,
    "backlash": 0.3 * pi / 180,
}


SHORT = 6  # samples of a period that is derived again, each of 64 steps
FIRM = {"inertia": 3e-7, "damping": 5e-3, "stiffness": 0.5}


def geared(controller: str, *, push: float = 3e-4, rate_hz: float = 1000.0, **more: Any) -> Drawn:
    """The iDrive's knob with a light push, under a controller; ``more``: of the gear, or parts of the scene."""
    scene: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": push},
        "gear": {**GEAR, **{key: value for key, value in more.items() if not isinstance(value, dict)}},
        **{key: value for key, value in more.items() if isinstance(value, dict)},
    }
    if controller:
        scene["controller"] = dict(EVERY[controller])
    return Drawn(controller, ("play",), scene, rate_hz, 360)


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    "controller", ["bounded lag", "damping, sensor", "damping, differenced", "impulse, short", "speed, tracked"]
)
def test_trials_beside_a_controller(controller: str) -> None:
    """Two of three can be compared: at a light push, with a delay, and with soft teeth that ring."""
    more: list[dict[str, Any]] = [{}, {"actuator": {"delay_samples": 0.4}}, {"stiffness": 1.0, "mesh_damping": 1e-4}]
    errors = [check_trial(geared(controller, **one)) for one in more]
    assert np.isfinite(errors).sum() >= 2


@pytest.mark.long
def test_proven_cycles_beside_a_controller_on_one_flank() -> None:
    """The same with any backlash, and derived again."""
    found = []
    for backlash in (0.0, 0.005, 0.5):
        one = geared("speed, tracked", push=2e-3, mesh_damping=2e-2, hand=FIRM, backlash=backlash)
        made = reduce(one)
        engine, attractors = search(one, made)
        cycles = [end for end in attractors if end.outcome is Outcome.CYCLE and end.certified]
        measured = [LawMeasurer(made.knob, engine).measure(end) for end in cycles]
        assert all(each.mesh_least_nm > 0.0 for each in measured)
        found.append([(end.period, each.p2p_rad) for end, each in zip(cycles, measured, strict=True)])
        for end in cycles:
            if end.period <= SHORT and backlash == 0.005:
                check_orbit(one, made, end)
    assert found[0]
    for other in found[1:]:
        assert np.array(other) == pytest.approx(np.array(found[0]), rel=1e-9)


@pytest.mark.long
def test_cycles_through_the_play_beside_a_controller() -> None:
    """They close in the engine's own motion, and what the torque puts in is taken: by dampers, and teeth that relax."""
    parted = 0
    for controller in ("damping, differenced", "speed, tracked", "impulse, short"):
        for push in (1e-4, 3e-4):
            one = geared(controller, push=push, mesh_damping=2e-2, hand=FIRM)
            made = reduce(one)
            engine, attractors = search(one, made)
            for end in attractors:
                if end.outcome is not Outcome.CYCLE:
                    continue
                measured = LawMeasurer(made.knob, engine).measure(end)
                assert measured.wall_work_j == pytest.approx(measured.damping_loss_j, rel=1e-9)
                assert end.certified == (end.reason is Reason.NONE)
                parted += end.reason is Reason.PARTS
    assert parted >= 3


@pytest.mark.long
@pytest.mark.one_in(2)
@pytest.mark.parametrize(("controller", "push"), [("speed, tracked", 1e-4), ("damping, sensor", 3e-4)])
def test_chaos_beside_a_controller_is_what_two_motions_do(controller: str, push: float) -> None:
    """As `test_backlash` has it, with the same bound; a sensed speed makes torques of a neighbour others."""
    one = geared(controller, push=push, mesh_damping=2e-4)
    made = reduce(one)
    engine, attractors = search(one, made, phases=1)
    (end,) = attractors
    assert end.reason is Reason.NO_REPEAT
    measured = LawMeasurer(made.knob, engine).measure(end)
    assert measured.rattle_p2p_rad > 0.0
    advance, body, pad = compiled("laws")["general.laws.advance_with_law"], as_arrays(made.knob.body), np.zeros(8)
    n, past = 4, np.array(end.line)
    z = np.array([end.x, end.v, *end.state])
    other, beside, total = past.copy(), z + 5e-10, 0.0
    for _ in range(RATTLE):
        advance(z, past, body, made.knob.wall, engine.law, pad)
        advance(beside, other, body, made.knob.wall, engine.law, pad)
        assert (other[: made.law.line] == past[: made.law.line]).all() or made.law.fading >= 0
        off = float(np.linalg.norm(beside - z))
        total += np.log(off / 1e-9)
        beside = z + (beside - z) * (1e-9 / off)
        other[made.law.line :] = past[made.law.line :] + (other[made.law.line :] - past[made.law.line :]) * (1e-9 / off)
    assert n == made.knob.body.order
    assert total / RATTLE * 1000.0 == pytest.approx(
        measured.parting_per_s, abs=2.5 + 0.01 * abs(measured.parting_per_s)
    )


def rubbed(level: float, *, push: float = 3e-4, rate_hz: float = 1000.0, **more: Any) -> Drawn:
    """As `geared` without a controller, with friction of the motor, N·m at its shaft."""
    return geared("", push=push, rate_hz=rate_hz, motor_coulomb_torque=level, **more)


RUBBED = [
    rubbed(2e-5),
    rubbed(1e-4, push=2e-3),
    rubbed(5e-6, mesh_damping=2e-4),
    rubbed(3e-5, mesh_damping=0.0, actuator={"time_constant": 2e-4}),
    rubbed(2e-5, stiffness=1.0, actuator={"delay_samples": 0.4}),
    rubbed(2e-5, hand=FIRM, rate_hz=500.0),
]


PARTED = [True, False, True, True, True, False]


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("one", "parts"), list(zip(RUBBED, PARTED, strict=True)))
def test_trials_beside_friction(one: Drawn, parts: bool) -> None:
    """The motor turns round or sticks in all of them, and teeth part in most."""
    expected, found = both(one)
    friction = expected.friction
    assert (friction.parted > 0) == parts
    assert friction.stops > 0
    angles = np.array([float(sample.angle) for sample in expected.samples])
    assert np.abs(found - angles).max() <= WITHIN * np.abs(angles).max()


HYSTERESIS = [
    rubbed(0.0, encoder={"hysteresis_counts": 0.5}),
    rubbed(2e-5, encoder={"hysteresis_counts": 1.3}),
    rubbed(0.0, encoder={"backlash": 0.003}, stiffness=1.0, mesh_damping=1e-4),
    rubbed(1e-5, encoder={"hysteresis_counts": 0.3}, actuator={"delay_samples": 0.4, "time_constant": 2e-4}),
    rubbed(0.0, encoder={"hysteresis_counts": 0.5}, wall={"stiffness": 0.27, "damping": 1e-5}),
]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("one", HYSTERESIS, ids=lambda one: str(HYSTERESIS.index(one)))
def test_trials_beside_hysteresis(one: Drawn) -> None:
    """The count goes by the motor's turning points, on any flank and on none."""
    expected, found = both(one)
    assert expected.relays is not None
    assert expected.friction.parted > 0
    assert sum(turn for _, turn, _, _ in expected.relays.log) >= 3
    angles = np.array([float(sample.angle) for sample in expected.samples])
    assert np.abs(found - angles).max() <= WITHIN * np.abs(angles).max()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("controller", ["bounded lag", "damping, sensor", "impulse, short"])
def test_trials_beside_hysteresis_and_a_controller(controller: str) -> None:
    """With friction of the motor, too."""
    errors = []
    for k, level in enumerate((0.0, 1e-5)):
        one = geared(controller, motor_coulomb_torque=level, encoder={"hysteresis_counts": 0.4 + 0.7 * k})
        errors.append(check_trial(one))
    assert np.isfinite(errors).any()


def both(one: Drawn, samples: int = 60) -> tuple[Any, np.ndarray]:
    """A trial of the model, and the package's angles at its samples; no sample is near an edge."""
    arguments = {"sample_rate_hz": one.rate_hz, "counts_per_rev": one.counts, "angle_rad": 0.02, "phase": 0.37}
    expected = reference.simulate(one.scene, **arguments, velocity_rad_s=-0.5, samples=samples)
    assert expected.edge > CLEAR * float(expected.control.quantum)
    assert expected.friction.closest > 1e-9
    plain = reduced(SceneSpec.model_validate(one.scene).plain())
    if one.scene.get("encoder") and one.scene["wall"].get("damping"):
        made = reduce(one)
        z, past = made.knob.start(0.02, -0.5), [0.0] * len(made.law.beside)
        advance_span(z, 0.0, 0.37, made.knob.body, [0.0] * 8)
        begin_past(past, read(z[0], made.knob.wall), made.law)
        places = [z[0]]
        for _ in range(samples):
            advance_with_law(z, past, made.knob.body, made.knob.wall, made.law, [0.0] * 8)
            places.append(z[0])
        return expected, np.array([made.knob.angle_rad(x) for x in places])
    return expected, simulate(plain, **arguments, velocity_rad_s=-0.5, samples=samples).angle_rad


PULSED = [
    geared("", backlash=0.0),
    rubbed(2e-5, backlash=0.0),
    geared(""),
    rubbed(2e-5, encoder={"hysteresis_counts": 0.5}),
    geared("bounded lag", actuator={"delay_samples": 0.4}),
    rubbed(1e-5, actuator={"time_constant": 2e-4}),
]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("one", PULSED, ids=lambda one: str(PULSED.index(one)))
def test_a_pulse_pushes_the_knob_behind_the_mesh(one: Drawn) -> None:
    """The motor follows when the teeth meet."""
    for torque in (0.01, -0.006):
        samples, moved = check_pulse(one, {"torque": torque, "duration": 3.2 / one.rate_hz})
        assert samples > 10
        assert moved > 1e-3


def general(one: Drawn, **more: Any) -> tuple[Any, GeneralEngine, Any]:
    """Cell, engine and ends of a scene without a controller."""
    plain = reduced(SceneSpec.model_validate(one.scene).plain())
    knob = sample_general(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
    engine = GeneralEngine(compiled("general"))
    start = knob.start(0.02, 0.0)
    found = engine.search(
        *(knob.body, knob.wall, start), rate=knob.rate, phases=6, delay_line=knob.delay_line, max_samples=2**14, **more
    )
    return knob, engine, found.attractors


def test_what_a_motor_that_rubs_comes_to() -> None:
    """Energy balances in cycles through the play and on one flank; a rest is one in which no torque is too large."""
    reasons, rests = set(), 0
    for level, width in ((1e-6, 0.0), (1e-5, 0.0), (5e-5, 0.0), (1e-6, 0.4)):
        for push in (1e-4, 1e-3):
            one = rubbed(level, push=push, mesh_damping=2e-2, encoder={"hysteresis_counts": width})
            knob, engine, ends = general(one)
            for end in ends:
                rests += end.outcome is Outcome.REST and end.certified
                if end.outcome is not Outcome.CYCLE:
                    continue
                measured = GeneralMeasurer(knob, engine).measure(end)
                reasons.add(end.reason)
                lost = measured.damping_loss_j + measured.friction_loss_j
                assert measured.wall_work_j == pytest.approx(lost, rel=1e-9)
                assert measured.friction_loss_j > 0.0
    assert {Reason.PARTS, Reason.NONE} <= reasons
    assert rests


def test_friction_on_one_flank_is_that_of_the_gear_without_backlash() -> None:
    found = []
    for backlash in (0.0, 0.005, 0.5):
        knob, engine, ends = general(rubbed(1e-5, push=2e-3, mesh_damping=2e-2, backlash=backlash))
        cycles = [end for end in ends if end.outcome is Outcome.CYCLE and end.certified]
        measured = [GeneralMeasurer(knob, engine).measure(end) for end in cycles]
        found.append([(end.period, each.p2p_rad) for end, each in zip(cycles, measured, strict=True)])
    assert found[0]
    for other in found[1:]:
        assert np.array(other) == pytest.approx(np.array(found[0]), rel=1e-9)


def check_derivative(one: Drawn) -> int:
    """Over 60 samples, against central differences of states 1e-6 apart; in how many a corner of cogging is passed.

    The error of a difference is some 1e-6 of a derivative of a few samples.
    """
    plain = reduced(SceneSpec.model_validate(one.scene).plain())
    knob = sample_general(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
    body, pad, compared, asked = knob.body, [0.0] * 8, 0, 0
    corners = 0
    space = make_space(4, 0, lambda count: [0.0] * count)
    z, before = knob.start(0.02, -0.5), read(knob.start(0.02, -0.5)[0], knob.wall)
    for _ in range(60):
        state, now = list(z), before
        for c in range(4):
            for i in range(space.width):
                space.cols[c * space.width + i] = float(i == c)
        begin_marks(space.marks)
        before, _ = advance_columns(z, now, [], 0, body, knob.wall, space, 4)
        corners += space.marks[CORNER_ROOM] < 0.0
        slopes = np.array([[space.cols[c * space.width + i] for c in range(4)] for i in range(4)])
        ends = []
        for c in range(4):
            pair = []
            for nudge in (1e-6, -1e-6):
                other = list(state)
                other[c] += nudge
                advance(other, now, [], 0, body, knob.wall, pad)
                pair.append(np.array(other))
            ends.append((pair[0] - pair[1]) / 2e-6)
        if state[1] != 0.0 and min(space.marks[:2]) > 1e-4:  # else a neighbour may stick where this one turns
            compared += np.abs(np.array(ends).T - slopes).max() < 1e-4 * np.abs(slopes).max()
            asked += 1
    assert compared >= asked - 2  # a neighbour may meet a flank, or pass a corner, that this motion just misses
    assert asked >= 30
    return corners


@pytest.mark.parametrize("level", [0.0, 5e-6, 2e-5])
def test_the_derivative_goes_through_every_event(level: float) -> None:
    check_derivative(rubbed(level, mesh_damping=2e-3))
