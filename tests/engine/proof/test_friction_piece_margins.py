"""A piece over an interval of a knob with friction, with its motion written down: nothing is lost on the way.

What rounding may come to is counted once an interval, every set that a part of it makes is moved on, and what there is
no room for is said.
"""

from math import inf
from typing import Any

import pytest

from hknob_cli.engine.general.sets import friction_piece
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, area_of
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_piece import TINY, move_piece, part_piece
from hknob_cli.engine.general.sets.friction_step import CUT, ENCLOSED, HELD, MOST_CUTS, SLID
from hknob_cli.engine.general.sets.piece import BEFORE, COUNT, ERROR, LEVEL, SAMPLE, STATE, WEIGHT, piece_size

from .friction_work import (
    SQUARE,
    Motion,
    body_of,
    cell_of,
    centre_of,
    drift_of,
    law_of,
    room_of,
    wall_of,
    work_of,
    zeros,
)
from .test_friction_set_margins import pairs_of, ring_of, turned

LEG = [0.0, 0.5, 1.0, 2.0, 3.0, -1.0]  # of an interval: torque, span, the plant's coefficients, no look
NONE = drift_of()


class Piece:
    """One that waits in ``room`` as the one after ``at`` others."""

    def __init__(self, room: Any, at: int, delay: int = 0) -> None:
        size = piece_size(2, delay)
        one = room.stack[at * size : (at + 1) * size]
        self.state, self.ring = one[STATE : STATE + 2], one[STATE + 2 : STATE + 2 + delay]
        edges = STATE + 2 + delay
        self.corners = one[edges : edges + 2 * int(one[COUNT])]
        self.error, self.before, self.level, self.sample = one[ERROR], one[BEFORE], one[LEVEL], one[SAMPLE]
        self.weight = one[WEIGHT]
        # As its corners are told from the middle of the box around it.
        self.ends = [(self.state[0] + dx, self.state[1] + dv) for dx, dv in pairs_of(self.corners)]


def moved(
    monkeypatch: pytest.MonkeyPatch, motion: Motion, *, course: list[float] | None = None, looks: int = 0,
    friction: float = 0.0, sets: int = 32, pieces: int = 32, waiting: int = 0, drift: Drift = NONE, error: float = 0.0,
    ring: list[float] | None = None, head: int = 0, level: float = -2.0, z: tuple[float, float] = (-1.5, 0.25),
    corners: list[float] | None = None, least: float = 0.125, damping: float = 0.0, before: float = 0.0,
) -> tuple[int, list[Piece], Any]:  # fmt: skip
    """Move a piece over an interval: how many wait then, those that are new, and the work space."""
    monkeypatch.setattr(friction_piece, "move_set", motion)
    given = corners or SQUARE
    delay = max(len(ring or []), 2 + looks if looks else 0)
    line = list(ring or zeros(delay))
    room = room_of(pieces, delay)
    work = work_of(sets, delay, looks, course or LEG, least=[least])
    wall, body = wall_of(damping=damping), body_of(friction)
    where = list(z)
    room.corners[: len(given)] = given
    told = centre_of(where, line, before, head=head, error=error, level=level, sample=7.0, weight=0.5)
    cell = cell_of(body, drift, wall, law_of(looks) if looks else None)
    found = move_piece(room, work, waiting, told, len(given) // 2, cell)
    # left alone
    assert (where, room.corners[: len(given)], line) == (list(z), given, list(ring or zeros(delay)))
    assert not any(room.stack[: waiting * piece_size(2, delay)])
    return found, [Piece(room, k, delay) for k in range(waiting, max(found, waiting))], work


def test_all_parts_of_an_interval_move_a_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """One after the other, each under its own torque, for its own time: what is told is where it ends."""
    course = [1.0, 0.5, 1.0, 2.0, 3.0, -1.0, 0.0, 0.25, 4.0, 5.0, 6.0, -1.0, 1.0, 0.125, 7.0, 8.0, 9.0, -1.0]
    motion = Motion((SLID, None), (ENCLOSED, [0.0, 0.0, 2.0, 0.0, 2.0, 2.0]))
    waiting, found, _ = moved(monkeypatch, motion, course=course, ring=[3.0, 5.0], head=1, waiting=3)
    # Under way are 5, the older, and 3: it acts as -2 with a stiffness of 1, so that 2 is commanded.
    assert waiting == 4
    assert [one[:7] for one in motion.told] == [
        (-1.5, 0.25, 3.0, 0.5, 1.0, 2.0, 3.0),
        (-0.5, 16.25, 5.0, 0.25, 4.0, 5.0, 6.0),
        (0.5, 32.25, 3.0, 0.125, 7.0, 8.0, 9.0),
    ]
    assert [one[7] for one in motion.told] == [SQUARE, SQUARE, [0.0, 0.0, 2.0, 0.0, 2.0, 2.0]]
    one = found[0]
    assert (one.level, one.sample, one.weight, one.before, one.error) == (-2.0, 8.0, 0.5, 0.0, 0.0)
    assert one.ring == [3.0, 2.0]
    assert one.state == [2.5, 49.25]  # the middle of what it became
    assert one.corners == [-1.0, -1.0, 1.0, -1.0, 1.0, 1.0]


def test_roundings_of_an_interval_are_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what always acts, of the largest torque, of position, of velocity, and of the corners: each by itself."""
    for once, blur, z, ring, added in (
        ((0.5, 0.0, 0.0, 0.0), 0.0, (-1.5, 0.25), [], 0.5),
        ((0.0, 0.5, 0.0, 0.0), 0.0, (-1.5, 0.25), [], 1.0),
        ((0.0, 0.5, 0.0, 0.0), 0.0, (-1.5, 0.25), [-9.0, 4.0], 4.5),
        ((0.0, 0.5, 0.0, 0.0), 0.0, (-1.5, 0.25), [1.0, -12.0], 6.0),
        ((0.0, 0.0, 0.5, 0.0), 0.0, (-1.5, 0.25), [], 0.75),
        ((0.0, 0.0, 0.5, 0.0), 0.0, (5.0, 0.25), [], 2.5),
        ((0.0, 0.0, 0.0, 0.5), 0.0, (-1.5, 0.25), [], 0.125),
        ((0.0, 0.0, 0.0, 0.5), 0.0, (-1.5, -3.0), [], 1.5),
        ((0.0, 0.0, 0.0, 0.0), 0.5, (-1.5, 0.25), [], 0.5 * 0.5**0.5),  # sqrt(v^2 + x^2 / 4) of a corner
        ((1.0, 2.0, 4.0, 8.0), 0.0, (-1.5, 0.25), [], 13.0),
    ):  # fmt: skip
        drift = drift_of(once, blur)
        for error in (0.0, 0.25):
            _, found, _ = moved(monkeypatch, Motion(), course=3 * LEG, drift=drift, error=error, z=z, ring=ring)
            assert found[0].error == pytest.approx(error + added, rel=1e-15)


def test_with_damping_what_it_read_is_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    """And what it had read before is what the difference is from."""
    for damping, before, u, remembers in ((0.0, 0.0, 2.0, 0.0), (0.5, -4.0, 1.0, -2.0), (0.5, -2.0, 2.0, -2.0)):
        motion = Motion()
        _, found, _ = moved(monkeypatch, motion, damping=damping, before=before)
        assert motion.told[0][2] == u
        assert found[0].before == remembers


# Cut by a line.


def test_a_set_that_is_to_be_cut_is_followed_on_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    """From where it was, in the same part of the interval; then over the parts that are left."""
    motion = Motion((CUT, None))
    waiting, found, _ = moved(monkeypatch, motion, course=2 * LEG)
    assert waiting == 2
    assert [one[0] for one in motion.told] == [-1.5, -1.5, -0.5, -1.5, -0.5]
    spans = sorted((min(x for x, _ in one.ends), max(x for x, _ in one.ends)) for one in found)
    assert spans == [(-0.5, 0.5), (0.5, 1.5)]
    assert [one.weight for one in found] == [0.5, 0.5]


class Halved(Motion):
    """One that asks for a cut through the middle, if it may."""

    def __call__(self, *given: Any) -> tuple[int, float, float, int]:
        (_, _, corners, count), least = given[0], given[3]
        xs = corners[: 2 * count : 2]
        self.line, self.script = (1.0, 0.0, 0.5 * (min(xs) + max(xs))), [(CUT if least < inf else ENCLOSED, None)]
        return super().__call__(*given)


def test_a_set_is_cut_only_so_often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then its enclosure is taken as it is: no radius is large enough to be cut."""
    motion = Halved()
    waiting, found, _ = moved(monkeypatch, motion, pieces=300)
    asked = [one[8] for one in motion.told]
    assert (waiting, asked.count(0.125), asked.count(inf)) == (2**MOST_CUTS, 2**MOST_CUTS - 1, 2**MOST_CUTS)
    lows = sorted(min(x for x, _ in one.ends) for one in found)
    assert lows == [-1.5 + k * 2.0**-7 for k in range(256)]


def test_what_has_no_room_for_both_sides_is_not_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two sets that wait, and the one that is cut, both sides need room."""
    for sets, least in ((4, [0.125] * 2), (2, [0.125, inf])):
        motion = Motion((CUT, None), (SLID, None))
        moved(monkeypatch, motion, sets=sets)
        assert [one[8] for one in motion.told][:2] == least
    motion = Motion((SLID, None))
    moved(monkeypatch, motion, sets=2)
    assert motion.told[0][8] == 0.125
    tight = Motion()
    moved(monkeypatch, tight, sets=1)
    assert tight.told[0][8] == inf


def test_a_line_beside_the_set_does_not_stop_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is moved once more, without a cut: that enclosure is what goes on."""
    shape = [0.0, 0.0, 4.0, 0.0, 4.0, 4.0]
    motion = Motion((CUT, None), (ENCLOSED, shape), line=(1.0, 0.0, 9.0))
    waiting, found, _ = moved(monkeypatch, motion)
    assert waiting == 1
    assert [one[8] for one in motion.told] == [0.125, inf]
    assert motion.told[0][:7] == motion.told[1][:7]
    assert motion.told[1][7] == SQUARE
    assert found[0].ends == [(-0.5, 16.25), (3.5, 16.25), (3.5, 20.25)]


# What becomes of its corners.


@pytest.mark.parametrize("friction", [1e-300, 0.5, 2.0])
def test_a_set_of_many_corners_is_simpler_with_friction(friction: float, monkeypatch: pytest.MonkeyPatch) -> None:
    _, found, _ = moved(monkeypatch, Motion((ENCLOSED, ring_of(17))), friction=friction)
    assert len(found) == 1
    assert len(found[0].corners) == 2 * MOST_CORNERS
    _, found, _ = moved(monkeypatch, Motion((ENCLOSED, ring_of(MOST_CORNERS))), friction=friction)
    assert found[0].ends == [(x - 0.5, v + 16.25) for x, v in pairs_of(ring_of(MOST_CORNERS))]


def test_a_set_of_many_corners_is_in_two_where_nothing_rubs(monkeypatch: pytest.MonkeyPatch) -> None:
    """With their shares: areas are kept."""
    waiting, found, _ = moved(monkeypatch, Motion((SLID, ring_of(17))))
    assert waiting == 2
    areas = [area_of(one.corners, len(one.corners) // 2) for one in found]
    assert sum(areas) == area_of(ring_of(17), 17)
    for one, area in zip(found, areas, strict=True):
        assert one.weight == pytest.approx(0.5 * area / sum(areas), rel=1e-15)


@pytest.mark.parametrize("v", [0.0, 0.5, -0.75])
def test_only_what_friction_holds_has_no_velocity(v: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """What has none by chance gets one, however little: the next interval is not to take it as held."""
    line = [-1.0, -v, 1.0, -v]
    for fate in (SLID, ENCLOSED, HELD):
        motion = Motion((fate, line))
        motion.step = (1.0, v - 0.25)
        moved(monkeypatch, motion, course=2 * LEG, friction=0.5)
        _, at, *_, corners, _ = motion.told[1]
        speeds = {at + dv for dv in corners[1::2]}
        if fate == HELD:
            assert corners == line
            assert speeds == {0.0}
        else:
            assert min(speeds) < 0.0 < max(speeds) or v == 0.0
            assert max(abs(one) for one in speeds) <= TINY + 2.0**-52
            assert speeds - {0.0}
            assert {dx for dx, _ in pairs_of(corners)} == {-1.0, 1.0}


# A look within the interval.


def test_a_look_tells_a_set_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """After its part of the interval: each part remembers what it read, and moves on from there."""
    monkeypatch.setattr(friction_piece, "command_all", lambda *given: (0, 3.0))
    motion = Motion()
    motion.step = (1.25, 16.0)
    course = [*LEG[:5], 0.0, *LEG[:5], 1.0]
    waiting, found, _ = moved(monkeypatch, motion, course=course, looks=2, z=(-2.15, 0.25), ring=[5.0, 6.0, 7.0, 8.0])
    assert law_of(2).rows + 1 == 2  # where its looks are remembered
    # From -1.9 to 0.1 at the first look, from -0.65 to 1.35 at the second.
    right = {(-2.0, -1.0): 0.65, (-2.0, 0.0): 0.25, (-1.0, 0.0): 1.0, (0.0, 0.0): 0.1}
    assert waiting == len(right)
    assert {(one.ring[2], one.ring[3]): one.weight for one in found} == pytest.approx(
        {looks: 0.25 * wide for looks, wide in right.items()}, abs=1e-13
    )
    assert {one.level for one in found} == {-2.0}
    assert {one.sample for one in found} == {8.0}


def test_a_look_without_room_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(friction_piece, "command_all", lambda *given: (0, 3.0))
    for sets, found in ((32, 2), (3, 2), (2, -1)):
        ends, _, _ = moved(
            monkeypatch, Motion(), course=[*LEG[:5], 0.0], looks=1, z=(-2.0, 0.25), sets=sets,
            corners=[0.25 * one for one in SQUARE],
        )  # fmt: skip
        assert ends == found


def test_a_look_is_at_a_set_of_few_corners(monkeypatch: pytest.MonkeyPatch) -> None:
    """With friction: the room in which it is cut is for those. What it leaves nothing of is no want of room."""
    told = []

    def looked(*given: Any) -> int:
        told.append(given[4])
        return 0

    monkeypatch.setattr(friction_piece, "command_all", lambda *given: (0, 3.0))
    monkeypatch.setattr(friction_piece, "look_at_set", looked)
    for friction in (1e-300, 0.5, 2.0):
        motion = Motion((ENCLOSED, ring_of(17)))
        assert moved(monkeypatch, motion, course=[*LEG[:5], 0.0], looks=1, friction=friction)[0] == 0
    assert told == [MOST_CORNERS] * 3


# No room.


def test_pieces_for_which_there_is_no_room_are_not_lost_silently(monkeypatch: pytest.MonkeyPatch) -> None:
    for pieces, waiting, found in ((3, 2, 3), (2, 2, -1), (3, 1, 2), (1, 0, 1)):
        assert moved(monkeypatch, Motion(), pieces=pieces, waiting=waiting)[0] == found
    assert moved(monkeypatch, Motion((CUT, None)), pieces=3, waiting=2)[0] == -1
    assert moved(monkeypatch, Motion((CUT, None)), pieces=4, waiting=2)[0] == 4


def test_sets_for_which_there_is_no_room_are_not_lost_silently(monkeypatch: pytest.MonkeyPatch) -> None:
    """A set may be in two halves after any part."""
    for sets, found in ((3, 1), (2, 1), (1, -1)):
        assert moved(monkeypatch, Motion(), sets=sets)[0] == found
    for sets, found in ((4, 2), (3, 2), (2, -1)):
        assert moved(monkeypatch, Motion((CUT, None)), sets=sets)[0] == found


# Cut at a sample.


def parted(
    x: float, corners: list[float], levels: tuple[float, float], reach: float, *, friction: float = 0.0,
    pieces: int = 32, waiting: int = 2, bottom: float = -inf,
) -> tuple[int, list[Piece]]:  # fmt: skip
    room, drift = room_of(pieces, 2), drift_of(bottom=bottom)
    room.corners[: len(corners)] = corners
    told = centre_of([x, 0.25], [3.0, 5.0], -9.0, head=1, error=0.0625, sample=7.0, weight=0.5)
    cell = cell_of(body_of(friction), drift, wall_of())
    found = part_piece(room, waiting, told, len(corners) // 2, *levels, reach, cell)
    assert not any(room.stack[: waiting * piece_size(2, 2)])
    return found, [Piece(room, k, 2) for k in range(waiting, max(found, waiting))]


@pytest.mark.parametrize("by", range(4))
@pytest.mark.parametrize("reach", [0.0, 0.125])
def test_parts_go_beyond_their_edges(by: int, reach: float) -> None:
    """How each acts is settled: half a sample more says so. Nothing else of it changes but its share."""
    found, parts = parted(-0.75, turned(SQUARE, by), (-2.0, 0.0), reach)
    assert found == 5
    lows, highs = [-1.75, -1.0 - reach, -reach], [-1.0 + reach, reach, 0.25]
    for level, low, high, one in zip((-2.0, -1.0, 0.0), lows, highs, parts, strict=True):
        assert (one.level, one.sample, one.error, one.before, one.ring) == (level, 7.5, 0.0625, -9.0, [5.0, 3.0])
        assert (min(x for x, _ in one.ends), max(x for x, _ in one.ends)) == (low, high)
        assert one.weight == 0.5 * (high - low) / 2.0
    found, parts = parted(-0.75, turned(SQUARE, by), (-2.0, 0.0), reach, friction=0.5)
    assert [one.weight for one in parts] == [0.5] * 3


def test_a_part_of_one_state_is_a_part_and_one_of_none_is_not() -> None:
    found, parts = parted(-1.0, [0.0, 0.0], (-3.0, 0.0), 0.0)
    assert (found, [one.level for one in parts]) == (4, [-2.0, -1.0])
    found, parts = parted(-0.75, SQUARE, (-5.0, -4.0), 0.0)
    assert (found, parts) == (2, [])
    found, parts = parted(-3.75, SQUARE, (-4.0, -3.0), 0.0, bottom=-4.0)
    assert [len(one.corners) for one in parts] == [8, 8]
    assert min(x for x, _ in parts[0].ends) == -4.75


def test_parts_for_which_there_is_no_room_are_not_lost_silently() -> None:
    for pieces, found in ((6, 5), (5, 5), (4, -1), (2, -1)):
        assert parted(-0.75, SQUARE, (-2.0, 0.0), 0.0, pieces=pieces)[0] == found
    assert parted(-0.75, SQUARE, (-5.0, -4.0), 0.0, pieces=2)[0] == 2
