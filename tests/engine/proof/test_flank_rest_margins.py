"""Proofs beside teeth with play, on their margins: rest on a flank or in the gap, and cycles of a law on a flank."""

from math import inf, nextafter, sqrt
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NOT_CAPTURED, PROVEN
from hknob_cli.engine.general import cogging, inner_region, orbit_proof, standstill
from hknob_cli.engine.general.body import Body, norm
from hknob_cli.engine.general.cogging import far_apart, hold_stiffness, own_stiffness
from hknob_cli.engine.general.flank_rest import flank_room, flank_room_on, held_in_teeth
from hknob_cli.engine.general.laws import rest
from hknob_cli.engine.general.orbit_proof import EXPANDS, PARTS
from hknob_cli.engine.general.standstill import SETTLING, settles
from hknob_cli.engine.rest import AT_REST, MOVING
from tests.engine.general.gears import Gear, geared
from tests.engine.general.toothed import SCENES, Toothed, body_of

from .test_law_period_margins import Stage, law_of, prove
from .test_law_settling_margins import Stage as Settling
from .test_standstill_margins import FINGER, WALL

PLAYS = (5e-324, 0.5, 1.0, 3.0)
# The knob, four times the motor, on springs of 2 and 8 behind each other: 2 * 8 / (4 * 2 + 8) = 1.
MESH = FINGER._replace(order=4, lag=0.0, push=0.0, drive=0.0, friction=0.25, shift=1.5, reach=0.5)


class Room:
    """Stands in for `flank_room`; notes the torques that it is asked about."""

    def __init__(self, room: float) -> None:
        self.room, self.asked = room, list[float]()

    def __call__(self, torque: float, body: Body) -> float:
        self.asked.append(torque)
        return self.room

    def on(self, cogs: Any, torque: float, x: float, body: Body) -> float:
        """Stands in for `flank_room_on`, where there is no cogging."""
        assert cogs is None
        return self(torque, body)


@pytest.mark.parametrize("play", PLAYS)
def test_a_motor_that_friction_stops_keeps_to_its_flank_within_the_room(
    monkeypatch: pytest.MonkeyPatch, play: float
) -> None:
    """At -0.5 the mesh carries 1, the wall's. Half of a speed of 0.25, and a rounding of 64 units of 2."""
    one, reach = MESH._replace(play=play), 0.5 * 0.25 + 64.0 * EPSILON * 2.0
    for room, keeps in ((reach, False), (nextafter(reach, 1.0), True), (inf, True), (0.0, False)):
        told = Room(room)
        monkeypatch.setattr(inner_region, "flank_room", told)
        z, orbit, away = [-0.5, 0.25, 0.5, 0.25], [7.0] * 4, [7.0] * 4
        assert inner_region.keeps_reading(z, -1.0, 1.0, one, WALL, 0, orbit, away) == (keeps, 0.5)
        assert told.asked == [1.0]
        assert orbit == [-0.5, 0.0, 0.5, 0.0]
        found = inner_region.keeps_reading(z, -1.0, 1.0, one._replace(play=0.0), WALL, 0, orbit, away)
        assert (found, told.asked) == ((True, 0.5), [1.0])


@pytest.mark.parametrize("play", PLAYS)
def test_without_friction_the_way_to_its_rest_keeps_to_its_flank(monkeypatch: pytest.MonkeyPatch, play: float) -> None:
    """It rests 1 in the mesh, of 2; half of a speed of 0.25, and a rounding of a sixteenth."""
    one = MESH._replace(play=play, friction=0.0, push=-2.0, shift=-1.0)
    monkeypatch.setattr(standstill, "rest_rounding", lambda *_: 2.0**-4)
    for room, fate in ((0.125 + 2.0**-4, MOVING), (nextafter(0.125 + 2.0**-4, 1.0), AT_REST), (inf, AT_REST)):
        told = Room(room)
        monkeypatch.setattr(standstill, "flank_room", told)
        z, orbit, away = [3.0, 0.25, 1.0, 0.25], [7.0] * 4, [7.0] * 4
        assert settles(z, 0.0, 0.0, [], one, WALL, orbit, away) == (fate, 3.0)
        assert (orbit, told.asked) == ([3.0, 0.0, 1.0, 0.0], [2.0])
        assert settles(z, 0.0, 0.0, [], one._replace(play=0.0), WALL, orbit, away)[0] == AT_REST
        assert told.asked == [2.0]


@pytest.mark.parametrize("play", PLAYS)
def test_a_rest_under_a_law_is_on_one_flank_within_the_room(monkeypatch: pytest.MonkeyPatch, play: float) -> None:
    """Without friction behind torques under way, which move it by 2^-6, and a rounding of a sixteenth."""
    one = MESH._replace(play=play, friction=0.0)
    for room, fate in ((0.125 + 2.0**-4, MOVING), (nextafter(0.125 + 2.0**-4, 1.0), AT_REST), (inf, AT_REST)):
        at, told = Settling(monkeypatch), Room(room)
        at.apart = 0.125 - 2.0**-6
        monkeypatch.setattr(rest, "flank_room", told)
        monkeypatch.setattr(rest, "pushed_apart", lambda left, x, one: left)
        assert at.fate([-0.5, 0.0, 0.5, 0.0], one, late=2.0**-6) == fate
        assert told.asked == [1.0]
        assert at.fate([-0.5, 0.0, 0.5, 0.0], one._replace(play=0.0), late=2.0**-6) == AT_REST
        assert told.asked == [1.0]


@pytest.mark.parametrize("play", PLAYS)
def test_a_motor_that_friction_stops_under_a_law_keeps_to_its_flank(
    monkeypatch: pytest.MonkeyPatch, play: float
) -> None:
    """In the middle of its zone, where the springs carry a quarter of a count; an eighth off it, and two units more."""
    reach = 0.125 + 2.0**-10 * 2.0
    for room, fate in ((0.0, MOVING), (reach, MOVING), (nextafter(reach, 1.0), SETTLING), (inf, SETTLING)):
        at, told = Settling(monkeypatch), Room(room)
        at.apart = 0.125
        monkeypatch.setattr(rest, "flank_room", told)
        assert at.fate([-0.5, 0.5, 0.75, 0.25], MESH._replace(play=play)) == fate
        assert told.asked == [0.25]
        assert at.fate([-0.5, 0.5, 0.75, 0.25], MESH._replace(play=0.0)) == SETTLING
        assert told.asked == [0.25]


@pytest.mark.parametrize("play", PLAYS)
def test_a_cycle_under_a_law_is_proven_as_far_as_its_teeth_do_not_part(
    monkeypatch: pytest.MonkeyPatch, play: float
) -> None:
    """The room of the teeth bounds the margin. No proof: an error that may part them, and a map that grows."""
    one = MESH._replace(play=play, friction=0.0)
    matrix = np.diag([0.5, -0.25, 0.25, 0.5])
    stage = Stage(matrix, (-2.5, 0.25, 0.5, 0.5), marks=(inf, inf, 0.375, inf))

    def told(stage: Stage, room: float, law: Any = None, one: Body = one, z: Any = None) -> Any:
        asked = Room(room)
        monkeypatch.setattr(orbit_proof, "flank_room_on", asked.on)
        found = prove(stage, law or law_of(), one=one, z=z)
        assert asked.asked == ([0.375] if one.play > 0.0 else [])
        return found

    free = told(stage, inf)
    assert (free.status, free.margin) == (PROVEN, 1e9)
    assert told(stage, 0.0, one=one._replace(play=0.0)).status == PROVEN
    bound = free.bound
    for room, status, margin in (
        (0.125, PROVEN, 0.125),
        (2e9, PROVEN, 1e9),
        (nextafter(bound, 1.0), PROVEN, nextafter(bound, 1.0)),
        (bound, PARTS, 1e9),
        (0.0, PARTS, 1e9),
    ):
        found = told(stage, room)
        assert (found.status, found.margin, found.bound) == (status, margin, bound)
    off = [-2.5, 0.25 + 0.125, 0.5, 0.5]  # by an eighth of speed, and of the finger's
    reach = 0.5 * norm([0.0, 0.125, 0.0, 0.0], one)
    for room, status in ((reach, NOT_CAPTURED), (reach + 2.0 * bound, PROVEN)):
        assert told(stage, room, z=off).status == status
    grows = stage._replace(matrix=np.diag([1.5, -0.25, 0.25, 0.5]))
    still = law_of(drifts=-1)
    for room, status in ((inf, EXPANDS), (0.0, DIFFERENT)):
        assert told(grows, room, still).status == status
    for room in (inf, 0.0):
        assert told(grows._replace(anchored=False), room, law_of(anchor=3)).status == EXPANDS
        assert told(stage._replace(anchored=False), room, law_of(anchor=3)).status == EXPANDS


# Beside cogging.


def test_beside_cogging_the_room_goes_by_the_springs_of_the_slope(monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs of 4; a slope of 12 makes four times of them, and a place has twice the energy's root.

    On an unstable slope a difference has less energy for its size, and the same room; where nothing holds, none.
    """
    monkeypatch.setattr(cogging, "SPRINGS", 0.0)
    assert own_stiffness(MESH) == 4.0
    stable, unstable = -2.5, 5.5
    for torque in (2.0, 0.5):
        room = flank_room(torque, MESH)
        assert flank_room_on(None, torque, stable, MESH) == flank_room_on([], torque, stable, MESH) == room > 0.0
        for slope, x, part in (
            (12.0, stable, 0.5),
            (12.0, unstable, 0.0),
            (5.0, stable, 2.0 / 3.0),
            (3.0, unstable, 1.0),
            (3.875, unstable, 1.0),
            (4.0, unstable, 0.0),
            (5.0, unstable, 0.0),
        ):
            cogs = [slope, 8.0, -2.5, 4.0 * slope, sqrt(slope), 8.0]
            assert flank_room_on(cogs, torque, x, MESH) == pytest.approx(part * room, rel=1e-15)
            assert flank_room_on(cogs, -torque, x, MESH) == flank_room_on(cogs, 0.0, x, MESH) == 0.0


@pytest.mark.parametrize("name", SCENES)
def test_no_difference_within_the_room_takes_more_of_the_teeths_torque(name: str) -> None:
    """By spring and damper, of any state; one takes a third of it."""
    body = body_of(name)
    k, c, length = body.pad_stiffness, body.pad_damping, body.cogs[cogging.LENGTH]
    chance, seen = np.random.default_rng(3), 0
    for x in (body.cogs[cogging.CENTRE] + 0.25 * length, body.cogs[cogging.CENTRE] + 1.25 * length):
        if not hold_stiffness(body.cogs, x, body) > 0.0:
            assert flank_room_on(body.cogs, 1.0, x, body) == 0.0
            continue
        room, most = flank_room_on(body.cogs, 1.0, x, body), 0.0
        for _ in range(3000):
            dz = chance.normal(size=body.order) * np.exp(chance.normal(size=body.order) * 2.0)
            dz[0] += dz[2] * chance.choice([0.0, 1.0])  # as a knob that stands
            most = max(most, abs(k * dz[2] + c * dz[3]) * room / far_apart(body.cogs, dz.tolist(), x, body))
        assert 0.3 < most <= 1.0
        seen += 1
    assert seen >= 1


@pytest.mark.parametrize("seed", range(4))
def test_beside_cogging_what_is_said_to_be_held_is_held(seed: int) -> None:
    """By the motion of the knob beside it; what cogging pulls is the triangle wave's, and a torque like any other.

    A friction that is less than what pulls the motor at its begin holds nothing.
    """
    chance, asked = Random(seed), 0
    one = body_of(list(SCENES)[seed])
    one = one if one.friction > 0.0 else body_of("rubs")
    gear = Toothed(one)
    stiff = one.ratio * one.pad_stiffness + one.finger_stiffness
    for k in range(12):
        where = (1.0, -one.play - 1.0, -0.5 * one.play)[k % 3]
        x = where * (stiff if k % 3 != 2 else one.finger_stiffness) / one.finger_stiffness - one.shift
        if k % 3 == 1:
            x += one.ratio * one.pad_stiffness * one.play / one.finger_stiffness
        size = 10.0 ** chance.uniform(-1.5, 0.0)
        z = [x, 0.0, where + size * chance.gauss(0, 1), size * chance.gauss(0, sqrt(stiff))]
        u = chance.gauss(0, 1.0) + (one.pad_stiffness * (1.0, -1.0, 0.0)[k % 3])
        gear.begin(z)
        pull = float((gear.pulls[0] - gear.bare[1][0]) @ np.array([*z, 1.0, u]))
        for friction in (0.125, 0.5, 2.0, 8.0, 32.0):
            rubs = one._replace(friction=friction)
            assert held_in_teeth(z, u, rubs, pull) == held_in_teeth(z, u + pull, rubs)
            gear.body = rubs
            if held_in_teeth(z, u, rubs, pull):
                _, events = gear.move(z, u, 128)
                assert events == []
                assert gear.most <= friction * (1.0 + 1e-12)
                asked += 1
                break
    assert asked >= 4


# A motor that friction holds for ever.


def still(drive: float, pull: float, **more: Any) -> Body:
    """A motor that stands: constants of the knob behind it, with the motor at 0, and of the motor."""
    one = MESH._replace(play=3.0, shift=0.0, friction=99.0, **more)
    n = one.order
    vectors = [0.0] * (4 * n)
    vectors[n + 1], vectors[3 * n + 3] = pull, drive
    return one._replace(vectors=vectors)


def held(z: list[float], u: float, one: Body, most: float) -> None:
    """Friction of ``most`` is the least that holds it."""
    assert held_in_teeth(z, u, one._replace(friction=most))
    assert not held_in_teeth(z, u, one._replace(friction=nextafter(most, 0.0)))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("ratio", "pad", "finger"), [(4.0, 2.0, 8.0), (0.25, 4.0, 3.0)])
def test_teeth_that_press_hold_what_they_carry_and_what_swings(
    side: float, ratio: float, pad: float, finger: float
) -> None:
    """The knob is off its rest by 0.25 at a speed of 0.75, or by 0.125 at 0.1875: a root of energy of 0.625."""
    stiff = ratio * pad + finger
    away, w = (0.25, 0.75) if ratio == 4.0 else (0.125, 0.1875)
    swing = (0.25 * sqrt(ratio) + pad * sqrt(ratio / stiff)) * 0.625
    deep = 1.0 if side > 0.0 else -4.0  # the flanks are 3 apart
    pressed = stiff * deep + (ratio * pad * 3.0 if side < 0.0 else 0.0)
    one = still(pressed - 1.5 * finger, -0.5, ratio=ratio, pad_stiffness=pad, finger_stiffness=finger)
    for off, rate in ((away, w), (-away, w), (away, -w), (-away, -w)):
        z = [1.5, 0.0, deep + off, rate]
        for u in (side * (pad + 1.5) + 0.5, side * (pad - 1.5) + 0.5):
            held(z, u, one, 1.5 + swing)
        late = one._replace(order=5, lag=0.5, vectors=still(0.0, 0.0, order=5).vectors)
        late.vectors[6], late.vectors[18] = one.vectors[5], one.vectors[15]
        u = side * (pad + 1.5) + 0.5
        held([*z, u + 0.75], u, late, 1.5 + swing + 0.75)
        held([*z, u - 0.75], u, late, 1.5 + swing + 0.75)
        held([*z, u], u, late, 1.5 + swing)
        held([*z, -0.25], u, late._replace(lag=0.0, coil=0.5), 1.5 + swing + 0.125)
        assert not held_in_teeth(z, u, one._replace(pad_damping=0.0))
        assert held_in_teeth(z, u, one._replace(pad_damping=0.0, finger_damping=0.25))
        assert held_in_teeth(z, u, one._replace(finger_damping=0.25))
    unsprung = one._replace(pad_stiffness=0.0, finger_stiffness=0.0)  # its damper alone presses
    assert not held_in_teeth([1.5, 0.0, deep, side], 0.0, unsprung)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_teeth_whose_torque_may_swing_to_nothing_hold_nothing(side: float) -> None:
    """Off by 0.5 at 1.5: a root of 1.25, which is 1.875 of the torque."""
    for torque, holds in ((1.875, False), (1.876, True), (1.5, False), (2.0, True)):
        deep = 0.5 * torque if side > 0.0 else -3.0 - 0.5 * torque
        drive = 16.0 * deep + (24.0 if side < 0.0 else 0.0)
        for off in (0.5, -0.5):
            assert held_in_teeth([0.0, 0.0, deep + off, side * 1.5], side, still(drive, 0.0)) is holds


def test_a_knob_in_the_gap_must_not_come_to_a_flank() -> None:
    """At -1.5, off by 0.75 at a speed of 2 on a spring of 4: 1.25 to either side. The motor bears its own torque."""
    one = still(4.0 * -1.5 - 2.0 * 4.0, -0.5, finger_stiffness=4.0, finger_damping=0.25)
    for off, rate in ((0.75, 2.0), (-0.75, 2.0), (0.75, -2.0), (-0.75, -2.0)):
        z = [2.0, 0.0, -1.5 + off, rate]
        for u in (2.0, -1.0):
            held(z, u, one, 1.5)
        for play, stays in ((2.75, False), (nextafter(2.75, 3.0), True), (2.6, False), (9.0, True)):
            assert held_in_teeth(z, 2.0, one._replace(play=play)) is stays
        assert not held_in_teeth(z, 2.0, one._replace(finger_damping=0.0))
        for place, stays in ((-1.25, False), (-1.251, True), (-1.0, False)):
            drive = 4.0 * place - 8.0
            there = one._replace(vectors=still(drive, -0.5).vectors)
            assert held_in_teeth([2.0, 0.0, place + off, rate], 2.0, there) is stays
    loose = one._replace(finger_stiffness=0.0)
    assert not held_in_teeth([2.0, 0.0, -1.5, 0.0], 2.0, loose)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_said_to_be_held_is_held(seed: int) -> None:
    """By the motion of the knob beside it, for as long as its swing lasts; teeth stay where they are."""
    chance, asked = Random(seed), 0
    one = geared(1e-5, mesh_damping=2e-3 * seed, lag=2e-4 * (seed % 2))
    gear = Gear(one)
    stiff = one.ratio * one.pad_stiffness + one.finger_stiffness
    for k in range(12):
        where = (1.0, -one.play - 1.0, -0.5 * one.play)[k % 3]
        x = where * (stiff if k % 3 != 2 else one.finger_stiffness) / one.finger_stiffness - one.shift
        if k % 3 == 1:
            x += one.ratio * one.pad_stiffness * one.play / one.finger_stiffness
        size = 10.0 ** chance.uniform(-1.0, 0.0)
        z = [x, 0.0, where + size * chance.gauss(0, 1), size * chance.gauss(0, sqrt(stiff))]
        u = chance.gauss(0, 1.0) + (one.pad_stiffness * (1.0, -1.0, 0.0)[k % 3])
        z += [u + 0.3 * chance.gauss(0, 1)] * (one.lag > 0.0)
        for friction in (0.5, 2.0, 8.0, 32.0):
            rubs = one._replace(friction=friction)
            if held_in_teeth(z, u, rubs):
                gear.body = rubs
                _, events = gear.move(z, u, 128)
                assert events == []
                assert gear.most <= friction * (1.0 + 1e-12)
                asked += 1
                break
    assert asked >= 4
