"""Tests of `engine.general.sets.friction_search`: complete lists, the same as many trials find; honest where not."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets import box
from hknob_cli.engine.general.sets.friction_phases import fly
from hknob_cli.engine.general.sets.friction_rest import resting_piece
from hknob_cli.engine.general.sets.friction_room import can_rub, plane_of
from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
from hknob_cli.engine.general.sets.piece import largest_norm
from hknob_cli.engine.general.sets.readings import remembered
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob
from tests.engine.sets.test_polygon import states_of

from .cells import all_phases, centre

MEASURED = {"inertia": 1.9e-6, "coulomb_torque": 5.6e-4}
HALF = {"half_quantum": True}


def search_phases(one: GeneralKnob, **limits: Any) -> Any:
    """All clock phases of one start."""
    return all_phases(FrictionSetEngine(), one, **limits)


def end_of(one: GeneralKnob, phase: float) -> list[float]:
    """State of the trial of one clock phase after 600 samples."""
    z = [*fly(*one.start(0.02, 0.0)[:2], phase, plane_of(one.body)), *one.start(0.02, 0.0)[2:]]
    before, ring, head = read(z[0], one.wall), [0.0] * one.delay_line, 0
    for _ in range(600):
        before, head = advance(z, before, ring, head, one.body, one.wall, [0.0] * 6)
    return z


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "actuator",
    [
        {},
        {"delay_samples": 0.5},
        {"time_constant": 3e-4},
        {"time_constant": 5e-5, "delay_samples": 1.0, "torque_step": 1e-4},
    ],
)
def test_phases_end_where_trials_end(actuator: dict[str, Any]) -> None:
    """No trial of 48 ends on an orbit that is not listed, and shares agree as far as 48 trials can tell."""
    one = knob(455.0, 256, knob=MEASURED, bias=HALF, actuator=actuator)
    found = search_phases(one)
    assert found.complete
    assert found.why is Reason.NONE
    assert sum(each.trials for each in found.attractors) == pytest.approx(1.0, abs=1e-6)
    counted = [0] * len(found.attractors)
    for trial in range(48):
        x, v, *_ = end_of(one, (trial + 0.5) / 48)
        near = []
        for number, each in enumerate(found.attractors):
            z, before, ring, head = [each.x, each.v, *each.state], each.before, list(each.line), 0
            for _ in range(each.period):
                if abs(z[0] - x) + abs(z[1] - v) < 1e-7:
                    near.append(number)
                before, head = advance(z, before, ring, head, one.body, one.wall, [0.0] * 6)
        assert len(near) == 1
        counted[near[0]] += 1
    for each, count in zip(found.attractors, counted, strict=True):
        assert abs(each.trials - count / 48) < 8 / 48


def test_phases_that_come_to_rest_are_complete() -> None:
    """Strong friction: one rest, in whose reading all trials stand."""
    one = knob(455.0, 1024, knob={"inertia": 1.9e-6, "coulomb_torque": 1.2e-3}, bias=HALF)
    found = search_phases(one)
    assert found.complete
    assert {each.outcome for each in found.attractors} == {Outcome.REST}
    readings = {each.before for each in found.attractors if each.trials > 0.0}
    for trial in range(16):
        x, v = end_of(one, (trial + 0.5) / 16)
        assert v == 0.0
        assert read(x, one.wall) in readings


def test_too_few_samples_are_not_complete() -> None:
    """A budget within which nothing settles: said, and why."""
    found = search_phases(knob(455.0, 256, knob=MEASURED, bias=HALF), max_samples=3)
    assert not found.complete
    assert found.why is not Reason.NONE
    assert all(each.outcome is Outcome.UNDECIDED for each in found.attractors)


@pytest.mark.parametrize(
    "parts",
    [
        {"knob": {"inertia": 1.9e-6}},
        {"encoder": "none"},
        {"hand": {"inertia": 3e-7, "damping": 3.45e-4}},
    ],
)
def test_other_scenes_are_not_followed(parts: dict[str, Any]) -> None:
    """Without friction, with a continuous sensor, or where nothing holds the knob."""
    one = knob(1000.0, None if "encoder" in parts else 512, **parts)
    assert not can_rub(one.body, one.wall)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", range(12))
def test_what_is_said_to_rest_comes_to_rest_in_that_reading(seed: int) -> None:
    """Every state of a captured piece, followed by itself; and most pieces near a rest are captured."""
    chance = np.random.default_rng(seed)
    engine = FrictionSetEngine()
    captured = 0
    one = knob(1000.0, 2048, knob={"inertia": 1.9e-6, "coulomb_torque": 5.0e-4}, bias=HALF)
    cell = engine.ready(one.body, one.wall, 0)
    body, known = cell.body, cell.known
    for _ in range(40):
        x, v = chance.uniform(-3.0, 2.0), chance.choice([0.0, 1.0]) * chance.normal() * 0.01
        size = 10.0 ** chance.uniform(-4.0, -0.5)
        tall = 0.0 if v == 0.0 else 0.05 * size
        corners = [-size, -tall, size, -tall, size, tall, -size, tall]
        level = remembered(0.0, one.wall) + min(read(x, one.wall), 0.0)
        if min(read(x - size, one.wall), 0.0) != level or min(read(x + size, one.wall), 0.0) != level:
            continue
        radius = largest_norm(corners, 0, 4, body)
        row = resting_piece(centre([x, v], [], level=level), 1e-13, radius, corners, 4, cell)
        if row < 0:
            continue
        captured += 1
        readings = {known.table[10 * k + 9] for k in range(int(known.counts[0]))}
        for dx, dv in states_of(corners, 4, seed):
            z, before, head = [x + dx, v + dv], 0.0, 0
            for _ in range(400):
                before, head = advance(z, before, [], head, body, one.wall, [0.0] * 4)
                assert min(read(z[0], one.wall), 0.0) == level
            assert abs(z[1]) < 1e-9
            assert read(z[0], one.wall) in readings
    assert captured


def test_random_starts_of_ranges_rub() -> None:
    """Trials, not motions of a ball, which nothing rubs."""
    assert FrictionSetEngine().sampler(knob().wall) is box.sample_trials
