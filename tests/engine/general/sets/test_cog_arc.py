"""Tests of `engine.general.sets.cog_arc` and `cog_stop`: no state leaves its arc from corner to corner of cogging.

The states of an arc are followed by themselves, from any place of its line and of its ball, through random holds: near
corners, near turning points, and where friction is about to hold the knob or to let it go.
"""

from math import exp, inf
from random import Random
from typing import Any

import pytest

from hknob_cli.engine.general.body import stiffness
from hknob_cli.engine.general.cogging import CENTRE, LENGTH, ROOT, SLOPE, size_at, slope_at, unit_reach
from hknob_cli.engine.general.controller import read_after
from hknob_cli.engine.general.corners import growth_rate
from hknob_cli.engine.general.hysteresis import turn_and_count
from hknob_cli.engine.general.sets.cog_arc import begin_rolling, roll_arc, time_beside
from hknob_cli.engine.general.sets.cog_stop import Spread, stop_on_slope
from hknob_cli.engine.general.sets.friction_arc import (
    BALL,
    COUNT,
    COUNT_TO,
    ERROR,
    HIGH,
    LOW,
    STANDS,
    STATE,
    ball_of,
    begin_ball,
    beside_of,
)
from hknob_cli.engine.general.sets.friction_arc_counts import begin_counts, count_turns, keep_start, tells_counts
from hknob_cli.engine.general.sets.friction_arc_rest import stay_held
from hknob_cli.engine.general.sets.friction_arc_search import FrictionArcEngine, can_rub_arcs, make_rub_room, rub_drift
from hknob_cli.engine.general.slopes import cog_acceleration, cog_many
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import TWO_PARTS, scene

from .cells import zeros

LAG = {"time_constant": 3e-4}
WEAK = {"inertia": 3e-7, "damping": 1e-5, "stiffness": 1e-3}
WIDER = 1.0 + 1e-6  # than a ball are the columns that span it, for their rounding


def cell(friction: float, torque: float, places: int, rate: float = 1000.0, **more: Any) -> GeneralKnob:
    """A cell whose knob has cogging with so many places of rest in a turn."""
    cogging = {"torque": torque, "per_revolution": places, "centre": 0.03}
    parts = scene(knob={"coulomb_torque": friction}, cogging=cogging, **more)
    plain = reduced(SceneSpec.model_validate(parts).plain())
    return sample_general(plain, sample_rate_hz=rate, counts_per_rev=1024)


class Arc:
    """A random arc, and states of it."""

    def __init__(self, knob: GeneralKnob, chance: Random) -> None:
        self.body, self.chance, n = knob.body, chance, knob.body.order
        self.room = make_rub_room(zeros, list, self.body, knob.wall, 0, None)
        self.drift, self.away = rub_drift(self.body, knob.wall), self.body.cogs[LENGTH]
        room, size = self.room, self.away * 10.0 ** chance.uniform(-5.0, -0.5)
        self.line = [chance.gauss(0.0, size) for _ in range(n)]
        if self.body.lag > 0.0:
            self.line[-1] = 0.0
        room.z[:] = [chance.gauss(0.0, 1.0) for _ in range(n)]
        room.z[0] = chance.uniform(-1.0, 3.0) * self.away
        room.z[1] *= self.away * 10.0 ** chance.uniform(-5.0, 0.0)
        if chance.random() < 0.4:  # beside a corner
            slope = slope_at(room.z[0], self.body.cogs)
            room.z[0] = self.body.cogs[CENTRE] + (slope + 0.5) * self.away + chance.gauss(0.0, size)
        stands = self.body.friction > 0.0 and chance.random() < 0.4
        if stands:
            self.line[1] = room.z[1] = 0.0
        room.columns[:n] = self.line
        room.arc[:] = zeros(STATE)
        room.arc[STANDS] = float(stands)
        radius = size_at(self.body.cogs, self.line, 0, self.body) * 10.0 ** chance.uniform(-5.0, 0.0)
        begin_ball(room, radius, self.body)
        self.states = [self.state(stands) for _ in range(8)]

    def state(self, stands: bool) -> tuple[float, list[float]]:
        """One of the arc: where on its line, from -1 to 1, and its numbers."""
        n, room = self.body.order, self.room
        at, m = self.chance.choice([-1.0, 1.0, self.chance.uniform(-1.0, 1.0)]), len(room.unit) // n
        part = [self.chance.gauss(0.0, 1.0) for _ in range(m)]
        length = sum(one * one for one in part) ** 0.5 * WIDER * WIDER
        beside = [sum(part[k] / length * room.columns[(1 + k) * n + j] for k in range(m)) for j in range(n)]
        z = [room.z[j] + at * self.line[j] + beside[j] for j in range(n)]
        if stands:
            z[1] = 0.0
        return at, z

    def aim(self, hysteresis: float) -> tuple[float, float, float]:
        """Let it turn round about where its count changes, inside the wall: the count before, a torque, and a time."""
        chance, z, body = self.chance, self.room.z, self.body
        edge, span, way = chance.randint(-9, -1), chance.uniform(0.1, 1.0), chance.choice([-1.0, 1.0])
        z[1] = way * 10.0 ** chance.uniform(-3.0, -0.5)
        turn = chance.uniform(0.2, 0.8) * span
        z[0] = edge + way * 0.5 * hysteresis - 0.5 * turn * z[1] + chance.gauss(0.0, 2.0 * abs(self.line[0]))
        self.room.arc[STANDS] = 0.0
        u = way * body.friction - z[1] / turn - float(cog_acceleration(z, 0.0, slope_at(z[0], body.cogs), body))
        if body.lag > 0.0:
            z[-1] += u
        return edge - (way > 0.0), u, span

    def torque(self) -> float:
        """A command: any, or one near which friction holds the centre just so."""
        body, z = self.body, self.room.z
        if self.chance.random() < 0.6:
            return self.chance.gauss(0.0, self.away) * 10.0 ** self.chance.uniform(-3.0, 0.0)
        level = self.chance.choice([-1.0, 1.0]) * body.friction * self.chance.uniform(0.9, 1.1)
        return level - float(cog_acceleration(z, 0.0, slope_at(z[0], body.cogs), body))

    def move(self) -> bool:
        """Over a hold; whether its states are said to do alike in it."""
        u, span = self.torque(), self.chance.choice([1.0, self.chance.uniform(0.05, 1.0)])
        alike = bool(roll_arc(self.room, self.room.z, u, span, self.drift, self.body))
        for _, z in self.states:
            cog_many(self.body.cogs, z, u, span, self.body, [0.0] * (2 * self.body.order))
        return alike

    def check(self) -> None:
        """That all are in it, and stand where it says so."""
        room, body = self.room, self.body
        for at, z in self.states:
            beside = [z[j] - room.z[j] - at * room.columns[j] for j in range(body.order)]
            assert size_at(body.cogs, beside, 0, body) <= ball_of(room, body) + room.arc[ERROR]
            assert abs(beside[0]) <= beside_of(room, body)
            assert z[1] == 0.0 or not room.arc[STANDS] > 0.0


CELLS: dict[str, dict[str, Any]] = {
    "nothing rubs": {"friction": 0.0, "torque": 3e-4, "places": 84},
    "many corners": {"friction": 0.0, "torque": 1e-3, "places": 2000},
    "strong": {"friction": 0.0, "torque": 1e-2, "places": 132, "rate": 464.0},
    "finger": {"friction": 0.0, "torque": 1e-3, "places": 84, "hand": TWO_PARTS},
    "finger, lag": {"friction": 0.0, "torque": 1e-3, "places": 84, "hand": TWO_PARTS, "actuator": LAG},
    "friction": {"friction": 1e-4, "torque": 3e-4, "places": 84},
    "much friction": {"friction": 5.6e-4, "torque": 1e-3, "places": 84, "rate": 464.0},
    "friction, many corners": {"friction": 1e-4, "torque": 1e-3, "places": 2000},
}


@pytest.mark.parametrize("name", CELLS)
def test_no_state_leaves_its_arc(name: str) -> None:
    alike = 0
    for number in range(60):
        arc = Arc(cell(**CELLS[name]), Random(number))
        for _ in range(4):
            alike += arc.move()
            arc.check()
    assert alike >= 48  # of 240: else the line told nothing


@pytest.mark.long
@pytest.mark.parametrize("name", CELLS)
def test_no_state_of_many_leaves_its_arc(name: str) -> None:
    for number in range(60, 660):
        arc = Arc(cell(**CELLS[name]), Random(number))
        for _ in range(4):
            arc.move()
            arc.check()


def count_states(knob: GeneralKnob, number: int) -> tuple[int, int]:
    """States of a random arc that turn round near an edge: how many change their count, and of how many it is told.

    A count may be that of the last turning point, or of any place on the way from there: both show the same here.
    """
    arc, wall, body = Arc(knob, Random(number)), knob.wall, knob.body
    room, (level, u, span) = arc.room, arc.aim(wall.hysteresis)
    states = [z for z in (arc.state(stands=False)[1] for _ in range(8)) if read_after(z[0], level, wall) == level]
    begin_counts(True, level, room.arc)
    size = keep_start(True, room, body)
    alike = roll_arc(room, room.z, u, span, arc.drift, body)
    count_turns(True, room, u, span, alike, size, body, wall)
    changes = told = 0
    for z in states:
        count = turn_and_count(z, u, span, level, body, wall, [0.0] * (2 * body.order))[0]
        shown, low, high = (read_after(z[0], one, wall) for one in (count, room.arc[COUNT], room.arc[COUNT_TO]))
        assert low <= shown <= high
        changes += count != level
        told += bool(tells_counts(True, room.arc))
    return changes, told


def count_many(name: str, numbers: range) -> tuple[int, int]:
    """That of random arcs of these numbers, behind little hysteresis and behind much."""
    knobs = [cell(**CELLS[name], encoder={"hysteresis_counts": width}) for width in (0.05, 1.5)]
    found = [count_states(knobs[number % 2], number) for number in numbers]
    return sum(changes for changes, _ in found), sum(told for _, told in found)


@pytest.mark.parametrize("name", CELLS)
def test_no_state_counts_otherwise_behind_hysteresis(name: str) -> None:
    changes, told = count_many(name, range(80))
    assert changes > 20
    assert told > 30  # of up to 640


@pytest.mark.long
@pytest.mark.parametrize("name", CELLS)
def test_no_state_of_many_counts_otherwise(name: str) -> None:
    count_many(name, range(80, 1080))


@pytest.mark.parametrize("friction", [0.0, 1e-4, 2e-3])
def test_phases_of_a_start_are_in_the_first_arc(friction: float) -> None:
    """Also where friction stops the motion at one of them, or holds it from the first on."""
    knob = cell(friction, 1e-3, 84)
    for number in range(40):
        chance = Random(number)
        room, body = make_rub_room(zeros, list, knob.body, knob.wall, 0, None), knob.body
        speed = 0.0 if number % 8 == 0 else 10.0 ** chance.uniform(-4.0, 1.0)
        start = [chance.uniform(-10.0, 10.0), chance.choice([-1.0, 1.0]) * speed]
        low = chance.uniform(0.0, 0.9)
        room.arc[LOW], room.arc[HIGH] = low, low + (1.0 - low) * 10.0 ** chance.uniform(-4.0, 0.0)
        begin_rolling(start, room, rub_drift(body, knob.wall), body)
        middle, half = 0.5 * (room.arc[LOW] + room.arc[HIGH]), 0.5 * (room.arc[HIGH] - room.arc[LOW])
        for k in range(9):
            at, z = -1.0 + 0.25 * k, list(start)
            cog_many(body.cogs, z, 0.0, middle + at * half, body, [0.0] * 4)
            beside = [z[j] - room.z[j] - at * room.columns[j] for j in range(2)]
            assert size_at(body.cogs, beside, 0, body) <= (ball_of(room, body) + room.arc[ERROR]) * WIDER


def test_time_beside_a_corner_by_hand() -> None:
    # A corner passed at a speed of 2, without acceleration: beyond it for 0.01/2, by half of 0.01 on average.
    assert time_beside(0.0, -2.0, True, 0.0, 0.01, 1.0) == 0.0025
    # It slows down by 50: over 0.01 from 2 to the root of 4 - 2 * 50 * 0.01.
    assert time_beside(0.0, 2.0, True, 50.0, 0.01, 1.0) == pytest.approx(0.005 / 3.0**0.5)
    assert time_beside(0.011, 0.0, False, 1.0, 0.01, 1.0) == 0.0
    # It comes near, not to it: there and back at most, twice as long as it is near.
    assert time_beside(0.009, 2.0, False, 0.0, 0.01, 1.0) == 0.01
    assert time_beside(0.009, 1e-3, False, 1.0, 0.01, 0.7) == 0.7  # it may turn round there
    assert time_beside(0.0, 2.0, True, 0.0, 10.0, 0.3) == 0.3


def test_a_stop_is_alike_as_long_as_all_stop_on_one_slope() -> None:
    knob = cell(1e-3, 1e-4, 84)
    body, room = knob.body, make_rub_room(zeros, list, knob.body, knob.wall, 0, None)
    z = [body.cogs[CENTRE], 0.0]
    slope = slope_at(z[0], body.cogs)
    far = small = 1e-6
    u = -float(cog_acceleration(z, 0.0, slope, body))  # nothing but friction slows it down
    alike, window, then, jump, more = stop_on_slope(room, z, u, slope, 1, 0.5, Spread(small, far, 0.0), body)
    assert alike
    assert window == pytest.approx(2.0 * small / body.friction)
    assert (then, jump) == (0, -1.0)  # it is held, and no difference of speeds is left
    assert 0.0 < more < small
    _, _, then, jump, _ = stop_on_slope(room, z, u - 3.0 * body.friction, slope, 1, 0.5, Spread(small, far, 0.0), body)
    assert (then, jump) == (-1, pytest.approx(-0.5))  # from four times friction to twice as much
    # Where it is on the level at which friction holds, or states are as far apart as it is slow.
    assert not stop_on_slope(room, z, u - body.friction, slope, 1, 0.5, Spread(small, far, 0.0), body)[0]
    assert not stop_on_slope(room, z, u, slope, 1, 0.5, Spread(0.5 * body.friction, far, 0.0), body)[0]
    z[0] += 0.5 * body.cogs[LENGTH] - 0.5 * far  # beside a corner
    u = -float(cog_acceleration(z, 0.0, slope, body))
    assert not stop_on_slope(room, z, u, slope, 1, 0.5, Spread(small, far, 0.0), body)[0]


def test_a_ball_grows_on_an_unstable_slope_alone() -> None:
    """By no more than the rate of `growth_rate`, and by rounding elsewhere."""
    body = cell(0.0, 1e-3, 84).body
    for slope, most in ((0.0, 1.0), (1.0, exp(growth_rate(body)))):
        room = make_rub_room(zeros, list, body, cell(0.0, 1e-3, 84).wall, 0, None)
        room.z[:] = [body.cogs[CENTRE] + slope * body.cogs[LENGTH], 0.0]
        begin_ball(room, 1e-9, body)
        roll_arc(room, room.z, 0.0, 1.0, rub_drift(body, cell(0.0, 1e-3, 84).wall), body)
        assert room.arc[BALL] == pytest.approx(1e-9 * most, rel=1e-9)


def test_a_size_has_the_spring_of_a_stable_slope() -> None:
    body = cell(0.0, 1e-3, 84).body
    own = 1.0 / body.reach**2 + body.cogs[SLOPE]
    assert size_at(body.cogs, [2.0, 0.0], 0, body) == pytest.approx(2.0 * own**0.5)
    assert size_at(body.cogs, [0.0, 3.0], 0, body) == 3.0
    assert unit_reach(body) == pytest.approx(own**-0.5)


def test_what_arcs_are_followed_of() -> None:
    """Beside cogging of a knob of angle and speed, too; of none that nothing holds."""
    for knob, able in (
        (cell(0.0, 1e-3, 84), True),
        (cell(1e-4, 1e-3, 84), True),
        (cell(0.0, 1e-3, 84, hand=TWO_PARTS), True),
        (cell(1e-4, 1e-3, 84, hand=TWO_PARTS), True),
        (cell(0.0, 1e-3, 84, encoder={"hysteresis_counts": 0.5}), True),
        (cell(0.0, 1e-3, 84, hand={"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.0}), False),
    ):
        assert can_rub_arcs(knob.body, knob.wall) == able
        assert FrictionArcEngine(None).able(knob.body, knob.wall) == able
        assert knob.body.reach < inf or not able


def test_a_centre_that_hardly_moves_is_not_followed_from_rounding_to_rounding() -> None:
    """Near a balance beside a corner a torque that is off by a rounding turned it round every 2^-52 of a sample."""
    knob = cell(0.0, 1e-3, 84)
    body, cogs = knob.body, knob.body.cogs
    room = make_rub_room(zeros, list, body, knob.wall, 0, None)
    for k in range(200):
        x = cogs[CENTRE] + (-0.45 + 0.0045 * k) * cogs[LENGTH]
        u = -float(cog_acceleration([x, 0.0], 0.0, slope_at(x, cogs), body)) * (1.0 + 2.3e-16)
        room.arc[:], room.columns[:] = zeros(STATE), zeros(len(room.columns))
        room.z[:], room.columns[0] = [x, 0.0], 0.6 * cogs[LENGTH]
        begin_ball(room, 0.0, body)
        assert roll_arc(room, room.z, u, 1.0, rub_drift(body, knob.wall), body)
        assert room.z[0] == pytest.approx(x, abs=1e-12)


def test_a_state_that_stands_is_let_go_while_a_lag_and_a_winding_decay() -> None:
    """Its centre stays held, and both were so at the end of a hold; so all of the arc rests only in a smaller one."""
    winding = {"torque_constant": 3e-4, "resistance": 2.32, "inductance": 8e-5, "winding": "shorted"}
    knob = cell(1.4e-3, 1e-3, 200, 2500.0, motor=winding, actuator={"time_constant": 0.04}, hand=WEAK)
    body = knob.body
    stiff, push = stiffness(body) + body.cogs[ROOT] + body.lag, stiffness(body) + body.cogs[ROOT]
    reach = 0.1 * body.friction / stiff
    turn, late = 0.5 * stiff * reach * 1.001, push * reach * 1.001
    at = body.cogs[CENTRE] + 0.1 * body.cogs[LENGTH]
    pull = float(cog_acceleration([at, 0.0, 0.0, 0.0], 0.0, slope_at(at, body.cogs), body))
    u = body.friction * (1.0 - 1e-9) - turn - late - pull
    centre = [at, 0.0, turn / body.coil, u + late]
    assert body.friction - abs(cog_acceleration(centre, u, slope_at(at, body.cogs), body)) > stiff * reach
    other = [at - 0.999 * reach * unit_reach(body), *centre[1:]]
    for z, moves in ((list(centre), False), (list(other), True)):
        begun = z[0]
        for _ in range(4):
            cog_many(body.cogs, z, u, 1.0, body, zeros(8))
        assert (z[0] != begun) == moves
    assert stay_held(centre, u, 0.0, body)
    assert not stay_held(centre, u, push * reach, body)
