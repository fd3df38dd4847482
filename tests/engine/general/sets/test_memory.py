"""Tests of `engine.general.sets.memory`, and of rest under a law: what a set remembers, and what that pushes it by."""

from math import inf, nextafter
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.follow import CYCLE_PROVEN
from hknob_cli.engine.general.controller import Controller, read
from hknob_cli.engine.general.follow import FIELDS
from hknob_cli.engine.general.laws.cascade import torques_apart
from hknob_cli.engine.general.sets import known, memory
from hknob_cli.engine.general.sets.friction_rest import resting_piece
from hknob_cli.engine.general.sets.law_search import LawSetEngine
from hknob_cli.engine.general.sets.piece import largest_norm
from hknob_cli.engine.general.sets.readings import acting
from tests.engine.sets.test_polygon import states_of

from .test_law_search import LONG, RUBS, cell, run

WALL = Controller(1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0)


def test_without_a_law_commands_under_way_are_all_that_is_remembered() -> None:
    """Oldest first; the older command of an interval and the newer are those at both ends of the line."""
    made, _, _ = cell("bounded lag")
    for delay, torques, line in ((0, [3.0, 3.0], []), (1, [7.0, 3.0], [3.0]), (3, [7.0, 8.0], [3.0, 8.0, 9.0])):
        ring, out = [7.0, 8.0, 9.0][:delay], [0.0, 0.0]
        head, largest = memory.command_all(None, -3.0, 0.0, ring, WALL, out)
        assert (out, largest, ring) == (torques, max(torques), line)
        assert head == (1 % delay if delay else 0)
    assert memory.command_all(None, -3.0, 0.0, [-9.0], WALL, [0.0, 0.0])[1] == 9.0
    assert memory.watched(None, WALL) is WALL
    ring = [1.0, 2.0]
    memory.begin_memory(None, -2.0, ring)
    assert ring == [0.0, 0.0]
    points = [0.0, -1.0, 0.5, 0.5, 4.0, 5.0]
    for head, ring, away in ((0, [4.0, 5.0], 0.0), (1, [5.0, 4.0], 0.0), (0, [5.0, 4.0], inf), (0, [4.0, 6.0], inf)):
        for before in (-1.0, 0.0):
            given = (ring, head, points, 0, 0.0, made.knob.body)
            assert memory.memory_apart(None, before, *given, WALL) == away
            damped = WALL._replace(damping=1e-9)
            assert memory.memory_apart(None, before, *given, damped) == (away if before == -1.0 else inf)


def settled(name: str, **parts: Any) -> Any:
    """A cell, its law, the table with its one orbit, and the first of the orbit's samples that are compared with."""
    made, law, length = cell(name, **parts)
    engine = LawSetEngine(law, patience=LONG)
    body, drift, ends = engine.ready(made.knob.body, made.knob.wall, length)
    past, z = [0.0] * length, made.knob.start(0.02, 0.0)
    memory.begin_memory(law, acting(z[0], -inf, law.watch), past)
    row, _ = known.seek(z, 0.0, past, 0, 100_000, 1e9, ends, body, made.knob.wall)
    assert (row, ends.table[0]) == (0, CYCLE_PROVEN)
    assert ends.counts[1] > 0.0
    return made, law, ends, drift, list(ends.points[2:4]), list(ends.points[4 : 4 + length])


@pytest.mark.parametrize("parts", [{}, RUBS, {"actuator": {"delay_samples": 2.0}}])
def test_a_set_is_captured_below_the_margin_less_what_its_memory_pushes(parts: dict[str, Any]) -> None:
    """A lag's mean that is off by d changes the torques by a known sum; what is counted must be the same."""
    made, law, ends, _, z, past = settled("bounded lag", **parts)
    body, wall = made.knob.body, made.knob.wall
    margin = ends.table[2] - ends.table[5]
    other = list(past)
    other[law.fading] += 0.3 * margin / body.reach * (1.0 - law.fade) / law.weight
    left = torques_apart(other, past, law)
    assert left == pytest.approx(0.3 * margin / body.reach)
    pushed = memory.memory_apart(law, 0.0, other, 0, ends.points, 0, ends.table[9], body, wall)
    assert pushed == body.reach * left
    for reach, row in ((0.69, 0), (0.71, -1)):
        assert known.captor(z, 0.0, other, 0, reach * margin / body.reach, ends, body, wall) == row
        assert known.captor(z, 0.0, past, 0, reach * margin / body.reach, ends, body, wall) == 0
    assert known.captor([z[0] + 0.5 * margin, z[1]], 0.0, other, 0, 0.19 * margin / body.reach, ends, body, wall) == 0
    assert known.captor([z[0] + 0.5 * margin, z[1]], 0.0, other, 0, 0.21 * margin / body.reach, ends, body, wall) == -1
    counted = list(past)
    counted[law.rows] -= 1.0
    assert known.captor(z, 0.0, counted, 0, 0.0, ends, body, wall) == -1
    if law.ages > 2:  # a torque under way counts by what it is off by
        late = list(past)
        late[law.line + law.parts] += 0.5 * margin / body.reach
        assert known.captor(z, 0.0, late, 0, 0.49 * margin / body.reach, ends, body, wall) == 0
        assert known.captor(z, 0.0, late, 0, 0.51 * margin / body.reach, ends, body, wall) == -1


def test_a_guard_must_clear_what_fades() -> None:
    """Phase damping acts otherwise where its mean crosses the torque: only nearer than that is a set captured."""
    made, law, ends, _, z, past = settled("phase, 90", counts=512)
    room = ends.table[FIELDS - 1]
    assert law.guarded
    assert room > 0.0
    for part, row in ((0.999, 0), (1.001, -1)):
        other = list(past)
        other[law.fading] += part * room
        assert known.captor(z, 0.0, other, 0, 0.0, ends, made.knob.body, made.knob.wall) == row


def test_readings_outside_that_no_law_tells_apart_are_one() -> None:
    made, law, length = cell("bounded lag")
    past, out = [float(k + 1) for k in range(length)], [0.0] * length
    memory.store_memory(law, past, 0, out, 0)
    assert out[law.rows] == 0.0
    assert [one for k, one in enumerate(out) if k != law.rows] == [one for k, one in enumerate(past) if k != law.rows]
    past[law.rows] = -2.0
    memory.store_memory(law, past, 0, out, 0)
    assert out[law.rows] == -2.0
    told = law._replace(watch=law.watch._replace(damping=1.0))
    past[law.rows] = 3.0
    memory.store_memory(told, past, 0, out, 0)
    assert out[law.rows] == 3.0
    wall = made.knob.wall
    for x, level, same in ((-0.5, -1.0, True), (-1.5, -1.0, False), (3.5, 0.0, True), (-0.5, 0.0, False)):
        assert memory.keeps_torque(law, x, level, 0.0, wall) == same
    assert memory.keeps_torque(None, -1.5, 0.0, 2.0, WALL)
    assert not memory.keeps_torque(None, -1.5, 0.0, nextafter(2.0, 3.0), WALL)


@pytest.mark.parametrize("friction", [0.0, 5.0e-4])
@pytest.mark.parametrize("seed", range(4))
def test_what_is_said_to_rest_under_a_law_rests_in_that_reading(seed: int, friction: float) -> None:
    """Every state of a captured piece, followed by itself with what the lag remembers, which may still be far off."""
    chance = np.random.default_rng(seed)
    knob = {"inertia": 1.9e-6, "coulomb_torque": friction}
    # The wall's torque of three counts and the hand's of two and a half hold this push.
    bias = {"torque": (3.0 * 0.27 + 2.5 * 0.04) * 2.0 * np.pi / 2048}
    made, law, length = cell("bounded lag", 1000.0, 2048, knob=knob, bias=bias, actuator={"delay_samples": 1.0})
    wall = made.knob.wall
    body, drift, ends = LawSetEngine(law, patience=LONG).ready(made.knob.body, wall, length)
    captured = 0
    for _ in range(60):
        level = float(chance.choice([-4.0, -3.0, -3.0, -2.0]))
        middle = (-wall.kappa * level + body.drive) / body.beta
        x = min(max(middle, level + 0.1), level + 0.9) + chance.normal() * 0.05
        v = chance.choice([0.0, 1.0]) * chance.normal() * 0.01
        size = 10.0 ** chance.uniform(-4.0, -1.0)
        tall = 0.0 if v == 0.0 else 0.05 * size
        corners = [-size, -tall, size, -tall, size, tall, -size, tall]
        if read(x - size, wall) != level or read(x + size, wall) != level or level >= 0.0:
            continue
        past = [0.0] * length
        memory.begin_memory(law, level, past)
        past[0] = -level + chance.choice([0.0, 1.0]) * chance.normal() * 10.0 ** chance.uniform(-4.0, 0.0)
        torques = [0.0] * length
        for _ in range(3):
            memory.command_all(law, level, 0.0, past, wall, torques)
        radius = largest_norm(corners, 0, 4, body)
        row = resting_piece([x, v], 0.0, past, 1e-13, radius, level, corners, 4, ends, drift, body, wall)
        if row < 0:
            continue
        captured += 1
        for dx, dv in states_of(corners, 4, seed):
            states = run(made, law, [x + dx, v + dv], list(past), 800)
            assert {read(float(one), wall) for one in states[:, 0]} == {level}
            assert abs(states[-1, 1]) < 1e-6
            if friction == 0.0:
                assert abs(states[-1, 0] - ends.states[2 * row]) < 1e-4
    assert captured >= 5
