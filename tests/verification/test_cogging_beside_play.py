"""Cogging of a motor behind teeth with play: against a 60-digit model of both, the gear without play, and long runs.

The model has a matrix for each flank and slope, and brackets each end; it shares no formula with the package. What is
proven stays on one flank and one slope, and is there what it is with any backlash.
"""

from functools import cache
from math import floor, pi
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.search import as_compiled
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import follow_knob, sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec

from .general_orbits import solve
from .law_scenes import Drawn
from .test_backlash_beside_more import FIRM, WITHIN, both, check_derivative, geared, general, rubbed
from .test_laws_in_the_general_loop import check_trial

WEAK = {"torque": 1e-5, "per_revolution": 84, "centre": 0.01}  # of the motor, behind 1:7.4
STRONG = {"torque": 3e-4, "per_revolution": 84, "centre": 0.4}
DENSE = {"torque": 2e-4, "per_revolution": 500, "centre": 0.0}

TRIALS = [
    rubbed(0.0, cogging=WEAK),
    rubbed(0.0, cogging=STRONG, stiffness=1.0, mesh_damping=1e-4),
    rubbed(0.0, cogging=DENSE, actuator={"delay_samples": 0.4}),
    rubbed(2e-5, cogging=STRONG),
    rubbed(5e-6, cogging=DENSE, actuator={"time_constant": 2e-4}),
    rubbed(1e-4, cogging=STRONG, push=2e-3),
    rubbed(0.0, cogging=STRONG, encoder={"hysteresis_counts": 0.5}),
    rubbed(1e-5, cogging=WEAK, encoder={"hysteresis_counts": 1.3}),
    rubbed(1e-5, cogging=DENSE, encoder={"backlash": 0.003}, actuator={"delay_samples": 1.4}),
]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("one", TRIALS, ids=lambda one: str(TRIALS.index(one)))
def test_every_sample_at_60_digits(one: Drawn) -> None:
    """Teeth part, or corners are passed, in all of them."""
    expected, found = both(one)
    assert expected.friction.parted >= 3
    angles = np.array([float(sample.angle) for sample in expected.samples])
    assert np.abs(found - angles).max() <= WITHIN * np.abs(angles).max()


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("one", TRIALS, ids=lambda one: str(TRIALS.index(one)))
def test_compiled_to_the_last_bit(one: Drawn) -> None:
    knob = knob_of(one)
    numbers: dict[str, Any] = {"angle_rad": 0.02, "velocity_rad_s": -0.5, "phase": 0.37, "samples": 60}
    for plain, fast in zip(follow_knob(knob, **numbers), follow_knob(knob, **numbers, compiled=True), strict=True):
        assert np.array_equal(plain, fast)


@pytest.mark.long
@pytest.mark.drawn(4)
@pytest.mark.parametrize("controller", ["bounded lag", "damping, sensor", "impulse, short", "speed, tracked"])
def test_trials_beside_a_controller(controller: str) -> None:
    errors = [
        check_trial(geared(controller, cogging=cogging, motor_coulomb_torque=level))
        for cogging, level in ((WEAK, 0.0), (STRONG, 0.0), (DENSE, 1e-5))
    ]
    assert np.isfinite(errors).sum() >= 2


def knob_of(one: Drawn) -> Any:
    plain = reduced(SceneSpec.model_validate(one.scene).plain())
    return sample_general(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)


@pytest.mark.parametrize("level", [0.0, 5e-6, 2e-5])
def test_the_derivative_goes_through_every_event(level: float) -> None:
    assert check_derivative(rubbed(level, mesh_damping=2e-3, cogging=DENSE)) >= 5


FIRMLY: dict[str, Any] = {"mesh_damping": 2e-2, "hand": FIRM}


@cache
def cells() -> tuple[tuple[Drawn, Any, Any, Any], ...]:
    """Scenes with what is found: light pushes, whose teeth part, and firm ones, beside cogging from weak to strong."""
    found = []
    for torque in (3e-6, 3e-5, 3e-4):
        for often, centre in ((84, 0.0), (84, 0.03), (84, 0.06), (500, 0.0)):
            for push in (3e-4, 2e-3, 8e-3):
                for level in (0.0, 1e-5):
                    cogging = {"torque": torque, "per_revolution": often, "centre": centre}
                    one = rubbed(level, push=push, cogging=cogging, rate_hz=1000.0 if often < 500 else 300.0, **FIRMLY)
                    found.append((one, *general(one)))
    return tuple(found)


def corners_passed(one: Drawn, measured: Any) -> int:
    """How many corners lie between a cycle's extremes; of the motor's own angle."""
    cogging, ratio = one.scene["cogging"], one.scene["gear"]["ratio"]
    low, high = (
        floor((ratio * angle - cogging["centre"]) * cogging["per_revolution"] / pi + 0.5)
        for angle in (measured.min_rad, measured.max_rad)
    )
    return high - low


@pytest.mark.long
def test_energy_balances_and_only_one_flank_and_one_slope_are_proven() -> None:
    """The wall's work is what dampers, friction and teeth that relax take, to 1e-9, over flanks and corners."""
    proven = parted = passed = rests = missed = 0
    for one, knob, engine, ends in cells():
        for end in ends:
            rests += end.outcome is Outcome.REST and end.certified
            if end.outcome is not Outcome.CYCLE:
                continue
            measured = GeneralMeasurer(knob, engine).measure(end)
            lost = measured.damping_loss_j + (measured.friction_loss_j if knob.body.friction else 0.0)
            assert measured.wall_work_j == pytest.approx(lost, rel=1e-9)
            assert end.reason in (Reason.NONE, Reason.PARTS_OR_COGS, Reason.AT_EVENT, Reason.NOT_AFFINE)
            apart, over = measured.mesh_least_nm <= 0.0, corners_passed(one, measured) > 0
            assert not (end.certified and (apart or over))
            missed += not (apart or over or end.certified or end.reason is Reason.AT_EVENT)
            proven, parted, passed = proven + end.certified, parted + apart, passed + over
    assert proven >= 8
    assert parted >= 2
    assert passed >= 2
    assert rests >= 4


@pytest.mark.long
def test_proven_cycles_are_those_of_the_gear_without_play() -> None:
    """Beside the same cogging, and again at 60 digits within the bound that each was given."""
    checked = solved = 0
    for one, knob, engine, ends in cells():
        proven = [end for end in ends if end.outcome is Outcome.CYCLE and end.certified]
        if not proven:
            continue
        tight = one._replace(scene={**one.scene, "gear": {**one.scene["gear"], "backlash": 0.0}})
        other, its, closed = general(tight)
        sizes = {
            (end.period, float(f"{GeneralMeasurer(other, its).measure(end).p2p_rad:.9g}"))
            for end in closed
            if end.outcome is Outcome.CYCLE
        }
        for end in proven:
            measured = GeneralMeasurer(knob, engine).measure(end)
            if measured.mesh_least_nm > 0.0:
                assert (end.period, float(f"{measured.p2p_rad:.9g}")) in sizes
                checked += 1
            if end.period <= 6 and solved < 3:
                again = solve(tight.scene, one.rate_hz, one.counts, other, end)
                assert again.closes
                x = again.run.states[0][0] / again.control.quantum - knob.shift
                assert abs(float(x) - end.x) <= end.bound + 1e-12 * abs(end.x)
                solved += 1
    assert checked >= 6


@pytest.mark.long
def test_what_is_proven_draws_what_is_said_to_come_to_it() -> None:
    """From states within the margin, by the energy of the difference with the slope's spring: none leaves the cycle."""
    chance, checked = Random(1), 0
    step = compiled("general")["general.advance"]
    for _, knob, _, ends in cells():
        body, wall = as_compiled(knob.body, knob.wall)
        for end in ends:
            if not end.certified or end.period > 60 or checked == 40:
                continue
            if end.outcome is Outcome.REST and body.friction:
                continue  # of a motor that is held: the knob may still settle
            turn = chance.uniform(0.0, 2.0 * pi)
            stiff = 1.0 / (body.reach * body.reach) + abs(body.cogs[0])
            reach = 0.999 * (end.margin - end.bound) if end.outcome is Outcome.CYCLE else 0.0
            off = reach * np.array([np.cos(turn), np.sqrt(stiff) * np.sin(turn) * 0.5, 0.0, 0.0])
            off[0] *= 1.0 / np.sqrt(1.0 + abs(body.cogs[0]) * body.reach * body.reach)  # whatever the slope
            z, before, pad, line = np.array([end.x, end.v, *end.state]) + off, end.before, np.zeros(8), np.zeros(0)
            place = np.array([end.x, end.v, *end.state])
            for _ in range(200 * end.period):
                before, _ = step(z, before, line, 0, body, wall, pad)
            if end.outcome is Outcome.REST:
                assert abs(z[0] - place[0]) <= 1e-9 * (1.0 + abs(place[0]))
            elif body.friction:
                assert abs(z[0] - place[0]) <= reach
            else:
                assert np.abs(z - place).max() < 1e-2 * np.abs(off).max() + 1e-8
            checked += 1
    assert checked >= 15
