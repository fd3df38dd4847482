"""Tests of `engine.general.sets.memory`, and of rest under a law: what a set remembers, and what that pushes it by."""

from math import inf, nextafter
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.follow import CYCLE_PROVEN
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import Controller, read
from hknob_cli.engine.general.laws.cascade import faded, same_count, torques_apart
from hknob_cli.engine.general.laws.step import begin_past, decide
from hknob_cli.engine.general.sets import known, memory
from hknob_cli.engine.general.sets.friction_rest import resting_piece
from hknob_cli.engine.general.sets.law_search import LawSetEngine
from hknob_cli.engine.general.sets.piece import largest_norm
from hknob_cli.engine.general.sets.readings import acting
from tests.controllers.laws import EVERY
from tests.engine.general.law_runs import states_with_law
from tests.engine.sets.test_polygon import states_of

from .cells import WHOLE, centre
from .test_law_search import LATE, LONG, RUBS, cell

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
            given = (ring, head, memory.OrbitSample(points, 0, 0.0), made.knob.body)
            assert memory.memory_apart(None, before, *given, WALL) == away
            damped = WALL._replace(damping=1e-9)
            assert memory.memory_apart(None, before, *given, damped) == (away if before == -1.0 else inf)


def settled(name: str, **parts: Any) -> Any:
    """A cell, its law, the table with its one orbit, and the first of the orbit's samples that are compared with."""
    made, law, length = cell(name, **parts)
    engine = LawSetEngine(law, patience=LONG)
    one = engine.ready(made.knob.body, made.knob.wall, length)
    ends = one.known
    past, z = [0.0] * length, made.knob.start(0.02, 0.0)
    memory.begin_memory(law, acting(z[0], -inf, law.watch), past)
    row, _ = known.seek(centre(z, past), WHOLE, one)
    assert (row, ends.table[0]) == (0, CYCLE_PROVEN)
    assert ends.counts[1] > 0.0
    return made, law, ends, one, list(ends.points[2:4]), list(ends.points[4 : 4 + length])


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
    sample = memory.OrbitSample(ends.points, 0, ends.table[9])
    pushed = memory.memory_apart(law, 0.0, other, 0, sample, body, wall)
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


COUNTING = [name for name, given in EVERY.items() if given.get("velocity") != "sensor"]


@pytest.mark.parametrize("name", COUNTING)
def test_what_is_remembered_follows_from_the_readings(name: str) -> None:
    """Bit for bit, whatever the speed: all states of a set, which had the same readings, remember the same."""
    made, law, length = cell(name, **RUBS)
    chance = np.random.default_rng(4)
    one, other = [0.0] * length, [0.0] * length
    begin_past(one, 3.0, law)
    begin_past(other, 3.0, law)
    for _ in range(400):
        shown = float(chance.integers(-9, 4))
        for look in range(law.looks):
            one[law.rows + 1 + look] = other[law.rows + 1 + look] = float(chance.integers(-9, 4))
        guards = decide(shown, 0.0, one, made.knob.wall, law), decide(shown, inf, other, made.knob.wall, law)
        assert guards[0] == guards[1]
        assert one == other


@pytest.mark.parametrize(
    "name", [name for name in COUNTING if EVERY[name]["kind"] == "velocity_damping" and "detections" not in EVERY[name]]
)
def test_an_estimate_forgets_what_was_before(name: str) -> None:
    """After thirteen readings two motions count the same to the last bit; after a hundred more what fades has faded."""
    made, law, length = cell(name)
    chance = np.random.default_rng(5)
    pasts = [[0.0] * length, [0.0] * length]
    for past, first in zip(pasts, (3.0, -8.0), strict=True):
        begin_past(past, first, law)
        for _ in range(50):
            decide(float(chance.integers(-9, 4)), 0.0, past, made.knob.wall, law)
    assert not same_count(*pasts, law)
    before = 0.0
    for sample in range(113):
        if sample == 13:  # the longest window is of twelve samples
            assert same_count(*pasts, law)
            before = faded(*pasts, law)
        shown = float(chance.integers(-9, 4))
        for past in pasts:
            decide(shown, 0.0, past, made.knob.wall, law)
    assert same_count(*pasts, law)
    rounding = 100.0 * 2.0**-52 * 20.0 / (1.0 - law.fade)
    assert faded(*pasts, law) <= law.fade**100 * before + rounding


def test_an_average_that_stays_a_unit_in_the_last_place_away_is_proven_too() -> None:
    """A Kalman filter's: of the times that it averages the two come to different numbers, for ever."""
    made, law, ends, one, z, past = settled("phase, Kalman", **LATE)
    body, wall, entered = made.knob.body, made.knob.wall, ends.counts[1]
    period = int(ends.table[1])
    for row in (3, 4):
        for to in (-inf, inf):
            other = list(past)
            other[row] = nextafter(other[row], to)
            ring = list(other)
            states_with_law(made.knob, law, list(z), ring, period)
            if ring[3:7] == other[3:7] and other[3:7] != past[3:7]:
                break
        else:
            continue
        break
    else:
        pytest.fail("no other average stays")
    margin, bound = ends.table[2], ends.table[5]
    assert known.captor(z, 0.0, other, 0, 0.0, ends, body, wall) == -1
    for _ in range(2):
        assert known.seek(centre(z, other), WHOLE, one)[0] == 0
        assert (ends.counts[0], ends.counts[1]) == (1.0, 2.0 * entered)
        assert known.captor(z, 0.0, other, 0, 0.0, ends, body, wall) == 0
        assert known.captor(z, 0.0, past, 0, 0.0, ends, body, wall) == 0
    assert ends.table[2] <= margin
    assert ends.table[5] >= bound


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


@pytest.mark.one_in(9)
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
    one = LawSetEngine(law, patience=LONG).ready(made.knob.body, wall, length)
    body, ends = one.body, one.known
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
        row = resting_piece(centre([x, v], past, level=level), 1e-13, radius, corners, 4, one)
        if row < 0:
            continue
        captured += 1
        for dx, dv in states_of(corners, 4, seed):
            states = states_with_law(made.knob, law, [x + dx, v + dv], list(past), 800)
            assert {read(float(one), wall) for one in states[:, 0]} == {level}
            assert abs(states[-1, 1]) < 1e-6
            if friction == 0.0:
                assert abs(states[-1, 0] - ends.states[2 * row]) < 1e-4
    assert captured >= 5
