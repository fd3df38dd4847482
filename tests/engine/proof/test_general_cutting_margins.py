"""Polygons of the general loop cut, moved and merged: what lies on an edge is in both parts, every rounding is kept."""

import random
from math import cos, inf, pi, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.sets.ball import step_through
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.lattice import CELL, KEY, MEMBERS, keep, put_box, release, slot
from hknob_cli.engine.general.sets.parts import part
from hknob_cli.engine.general.sets.piece import (
    BEFORE,
    CORNERS,
    COUNT,
    ERROR,
    LEVEL,
    SAMPLE,
    SPREAD,
    STATE,
    WEIGHT,
    clip,
    find_middle,
    halve,
    largest_norm,
    move_corners,
    move_piece,
    piece_size,
    power_of,
    put,
    within,
)
from hknob_cli.engine.general.sets.room import PieceRoom, make_piece_room
from tests.engine.general.sets.cells import centre

from .test_general_capture_margins import body_of, wall_of

UNIT = EPSILON
BODY = body_of(0.5, 4.0, 1.0)
PHI = [1.0, 0.5, -0.25, 0.75]  # of no body: exact
SQUARE = [-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5]


def zeros(count: int) -> list[float]:
    return [0.0] * count


def drift_of(bottom: float = -inf) -> Drift:
    """Exact powers of a matrix that is quickly told; no rounding in an interval but a stated one."""
    powers, phi = [], np.array(PHI).reshape(2, 2)
    for _ in range(8):
        powers += phi.ravel().tolist()
        phi = phi @ phi
    return Drift(powers=powers, once=[0.125, 0.0, 0.0, 0.0], units=[2.0, 1.0], blur=0.0, coast=0.0, bottom=bottom)


def cell_of(wall: Any, drift: Drift | None = None) -> Cell:
    """Without a law and without hysteresis of its encoder."""
    return Cell(drift or drift_of(), SimpleNamespace(law=None, turns=None), BODY, wall)


def small_room(delay: int = 0, pieces: int = 32, slots: int = 16, order: int = 2) -> PieceRoom:
    room = make_piece_room(zeros, order, delay, lattice=slots, deep=8)
    return room._replace(stack=zeros(piece_size(order, delay) * pieces))


def waiting(room: PieceRoom, at: int, delay: int = 0) -> list[float]:
    size = piece_size(2, delay)
    return room.stack[size * at : size * (at + 1)]


# Moving.


@pytest.mark.parametrize("samples", [0, 1, 2, 3, 5, 6, 13, 64, 100])
def test_powers_of_the_plant(samples: int) -> None:
    """By repeated products, as whole numbers over a power of 2: without a rounding for few samples."""
    matrix, spare = zeros(4), zeros(4)
    power_of(samples, drift_of(), 2, matrix, spare)
    exact = np.linalg.matrix_power(np.array(PHI).reshape(2, 2), samples)
    assert matrix == pytest.approx(exact.ravel().tolist(), rel=1e-12)
    out, room = zeros(6), SimpleNamespace(matrix=matrix, spare=spare)
    move_corners([9.0, 2.0, -3.0, 1.0, 5.0], 1, 2, samples, out, drift_of(), 2, room)
    moved = (exact @ np.array([[2.0, 1.0], [-3.0, 5.0]])).T.ravel().tolist()
    assert out == [*(pytest.approx(one, rel=1e-12) for one in moved), 0.0, 0.0]


def test_the_radius_is_that_of_the_farthest_corner() -> None:
    """Positions count twice: 0.4 and 2 * 0.15 are 0.5 apart."""
    corners = [9.0, 9.0, 0.0, 0.1, -0.15, 0.4, 0.05, 0.0]
    assert largest_norm(corners, 2, 3, BODY) == pytest.approx(0.5, rel=1e-12)
    assert largest_norm(corners, 6, 1, BODY) == pytest.approx(0.1, rel=1e-12)
    assert largest_norm(corners, 4, 1, BODY) == norm([-0.15, 0.4], BODY)
    assert largest_norm(corners, 0, 0, BODY) == 0.0


# Cutting.


def cut(given: list[float], limit: float, sign: float, n: int = 2) -> set[tuple[float, ...]]:
    out = zeros(64)
    kept = clip(given, len(given) // n, limit, sign, out, 2, n)
    return {tuple(out[2 + k * n : 2 + (k + 1) * n]) for k in range(kept)}


def test_what_lies_on_a_limit_belongs_to_both_sides() -> None:
    """An edge of the square, and a corner of a triangle."""
    triangle = [0.0, 0.0, 1.0, -0.5, 1.0, 0.5]
    tip, base = {(0.0, 0.0)}, {(1.0, -0.5), (1.0, 0.5)}
    assert cut(SQUARE, 1.0, 1.0) == base
    assert cut(SQUARE, -1.0, -1.0) == {(-1.0, -0.5), (-1.0, 0.5)}
    assert cut(triangle, 0.0, -1.0) == tip
    assert cut(triangle, -1e-300, -1.0) == set()
    assert cut(triangle, 0.0, 1.0) == tip | base
    assert cut(triangle, 0.5, 1.0) == base | {(0.5, -0.25), (0.5, 0.25)}
    assert cut(triangle, 0.5, -1.0) == tip | {(0.5, -0.25), (0.5, 0.25)}
    assert cut([1.0, 0.0, 5.0, -1.0, 5.0, 1.0], 2.0, -1.0) == {(1.0, 0.0), (2.0, -0.25), (2.0, 0.25)}


def test_a_chord_is_cut_once() -> None:
    """Two corners have one edge, not two."""
    out = zeros(16)
    assert clip([0.0, 0.0, 4.0, 2.0], 2, 1.0, 1.0, out, 0, 2) == 2
    assert out[:4] == [1.0, 0.5, 4.0, 2.0]
    assert clip([0.0, 0.0, 4.0, 2.0], 2, 1.0, -1.0, out, 0, 2) == 2
    assert out[:4] == [0.0, 0.0, 1.0, 0.5]
    long = [0.0, 1.0, -2.0, 4.0, 4.0, 3.0, -6.0, 8.0]  # of four numbers a state
    assert clip(long, 2, 1.0, 1.0, out, 0, 4) == 2
    assert out[:8] == [1.0, 1.5, -3.0, 5.0, 4.0, 3.0, -6.0, 8.0]


def test_the_middle_of_the_box_around_a_polygon() -> None:
    for corners, found in (
        ([1.0, 3.0, 4.0, 2.0, 5.0, 6.0, 2.0, 7.0], [3.0, 4.5]),
        ([-3.0, -1.0, -2.0, 5.0, -7.0, 2.0], [-4.5, 2.0]),
        ([8.0, -2.0], [8.0, -2.0]),
    ):
        middle = zeros(2)
        find_middle(corners, len(corners) // 2, 2, middle)
        assert middle == found


def test_a_piece_is_told_from_the_middle_of_its_box_with_its_memory() -> None:
    """And with what that rounds: four units of both places, by the norm."""
    room, out = small_room(2), zeros(piece_size(2, 2) + 1)
    corners = [1.0, 3.0, 4.0, 2.0, 5.0, 6.0, 2.0, 7.0]
    for head, line in ((0, [7.0, 8.0]), (1, [8.0, 7.0])):
        told = centre([-16.0, 32.0], line, -5.0, head=head, level=-2.0, sample=9.0, weight=0.75)
        put(out, 1, told, corners, 4, room.middle, drift_of(), 2)
        found = out[1:]
        assert [found[k] for k in (BEFORE, LEVEL, SAMPLE, WEIGHT, COUNT)] == [-5.0, -2.0, 9.0, 0.75, 4.0]
        assert found[STATE : STATE + 4] == [-13.0, 36.5, 7.0, 8.0]
        assert found[STATE + 4 : STATE + 12] == [-2.0, -1.5, 1.0, -2.5, 2.0, 1.5, -1.0, 2.5]
        assert found[ERROR] == 4.0 * UNIT * (2.0 * (13.0 + 3.0) + 36.5 + 4.5)
    told = centre([0.0, 0.0], [0.0, 0.0], error=1.0, weight=0.0)
    put(out, 1, told, [-8.0, -4.0], 1, room.middle, drift_of(), 2)
    assert out[1 + ERROR] == 1.0 + 4.0 * UNIT * (2.0 * 16.0 + 8.0)


@pytest.mark.parametrize(("order", "delay"), [(2, 0), (2, 3), (5, 2)])
def test_a_piece_of_most_corners_fills_its_place_and_no_more(order: int, delay: int) -> None:
    size, middle = piece_size(order, delay), zeros(order)
    out, drift = zeros(size + 9), drift_of()._replace(units=[1.0] * order)
    corners = [2.0**k + j for k in range(CORNERS) for j in range(order)]
    told = centre([1e9] * order, [1.0] * delay, 1.0, error=1.0, level=1.0, sample=1.0)
    put(out, 0, told, corners, CORNERS, middle, drift, order)
    assert all(number or k == SPREAD for k, number in enumerate(out[:size]))
    assert not any(out[size:])


@pytest.mark.parametrize("delay", [0, 2])
def test_a_piece_goes_on_one_sample_later_as_its_level(delay: int) -> None:
    """Its middle as a trial, with the rounding of that sample; its corners by the plant, from that middle."""
    cell = cell_of(wall_of(0.5))
    room, ring = small_room(delay), [1.0, 2.0][:delay]
    z, given = [3.0, -1.0], list(ring)
    corners = [value + shift for value, shift in zip(SQUARE, [0.5, 0.25] * 4, strict=True)]
    head = 1 if delay else 0
    told = centre(z, ring, -1.0, head=head, error=0.25, level=-2.0, sample=7.0, weight=0.5)
    assert move_piece(room, 2, told, corners, 4, 0.0, cell) == 3
    assert (z, ring) == ([3.0, -1.0], given)
    found = waiting(room, 2, delay)
    state, line = [3.5, -0.75], [ring[(head + k) % 2] for k in range(delay)]
    one = step_through(centre(state, line, -1.0, error=0.25, level=-2.0), 0.0, cell, zeros(4))
    assert found[STATE : STATE + 2] == state
    assert found[STATE + 2 : STATE + 2 + delay] == [line[(one.head + k) % 2] for k in range(delay)]
    assert [found[k] for k in (BEFORE, LEVEL, SAMPLE, WEIGHT, COUNT)] == [one.before, -2.0, 8.0, 0.5, 4.0]
    assert found[ERROR] == 0.375 + 4.0 * UNIT * (2.0 * 4.0 + 1.0)
    moved = [(dx + 0.5 * dv, -0.25 * dx + 0.75 * dv) for dx, dv in zip(SQUARE[::2], SQUARE[1::2], strict=True)]
    first = STATE + 2 + delay
    assert found[first : first + 8] == [value for one in moved for value in one]


@pytest.mark.parametrize("delay", [0, 1])
def test_a_part_keeps_the_last_reading_where_it_is_remembered(delay: int) -> None:
    cell = cell_of(wall_of(0.5, damping=0.25))
    room = small_room(delay)
    move_piece(room, 0, centre([-1.5, 0.0], [0.0] * delay, -4.0, level=-2.0), SQUARE, 4, 0.0, cell)
    assert waiting(room, 0, delay)[BEFORE] == -2.0


def test_a_polygon_between_two_edges() -> None:
    for low, high, found in (
        (-inf, inf, {(-1.0, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.0, 0.5)}),
        (0.0, inf, {(0.0, -0.5), (1.0, -0.5), (1.0, 0.5), (0.0, 0.5)}),
        (-inf, 0.5, {(-1.0, -0.5), (0.5, -0.5), (0.5, 0.5), (-1.0, 0.5)}),
        (-0.5, 0.5, {(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)}),
        (1.0, 2.0, {(1.0, -0.5), (1.0, 0.5)}),
        (-2.0, -1.0, {(-1.0, -0.5), (-1.0, 0.5)}),
        (1.5, 2.0, set()),
        (-3.0, -1.5, set()),
    ):
        room = small_room()
        kept = within(room, SQUARE, 4, low, high, 2)
        assert {(room.halves[2 * k], room.halves[2 * k + 1]) for k in range(kept)} == found
        assert kept >= len(found)


def test_both_halves_are_the_whole() -> None:
    """Cut by one line between corners: they share two, and both are convex. Of 5 corners one has 3 and one 4."""
    for count, sizes in ((4, (3, 3)), (5, (3, 4)), (6, (4, 4)), (18, (10, 10))):
        room = small_room()
        ring = [c for k in range(count) for c in (cos(2 * pi * k / count), sin(2 * pi * k / count))]
        room.halves[: 2 * count] = ring
        assert halve(room, count, 2) == sizes
        one = {tuple(room.halves[2 * k : 2 * k + 2]) for k in range(sizes[0])}
        other = {tuple(room.parts[2 * k : 2 * k + 2]) for k in range(sizes[1])}
        corners = {tuple(ring[2 * k : 2 * k + 2]) for k in range(count)}
        assert one | other == corners
        assert len(one & other) == 2


def parted(room: PieceRoom, at: int, x: float, corners: list[float], span: tuple[float, float], **more: Any) -> int:
    """How many pieces wait when one around ``x``, of these readings, is parted."""
    reach, cell = more.pop("reach", 0.0), cell_of(more.pop("wall", wall_of()), more.pop("drift", None))
    room.corners[: len(corners)] = corners
    return part(room, at, centre([x, 0.0], [], **more), len(corners) // 2, *span, reach, cell)


def parts(room: PieceRoom, first: int, total: int, delay: int = 0) -> list[tuple[float, float, float]]:
    """Level, width and height before the move of pieces that wait; rounded."""
    back = np.linalg.inv(np.array(PHI).reshape(2, 2))
    found = []
    for k in range(first, total):
        one = waiting(room, k, delay)
        base = STATE + 2 + delay
        corners = (back @ np.array(one[base : base + 2 * int(one[COUNT])]).reshape(-1, 2).T).T
        left, right = corners[:, 0].min(), corners[:, 0].max()
        found.append((one[LEVEL], round(float(right - left), 9), round(float(np.ptp(corners[:, 1])), 9)))
    return found


@pytest.mark.parametrize("reach", [0.0, 0.0625])
def test_parts_reach_beyond_their_edges_by_what_they_must(reach: float) -> None:
    """Readings -2 to 0 of a rectangle from -1.75 to 0.75, and no part of reading -3."""
    room, cell = small_room(), cell_of(wall_of())
    rectangle = [-1.0, -0.5, 1.5, -0.5, 1.5, 0.5, -1.0, 0.5]
    more = {"error": 0.25, "reach": reach, "sample": 3.0, "weight": 0.5}
    assert parted(room, 1, -0.75, rectangle, (-3.0, 0.0), **more) == 4
    assert parts(room, 1, 4) == [
        (-2.0, 0.75 + reach, 1.0),
        (-1.0, 1.0 + 2.0 * reach, 1.0),
        (0.0, 0.75 + reach, 1.0),
    ]
    for at, (level, low, high) in enumerate(
        [(-2.0, -1.75, -1.0 + reach), (-1.0, -1.0 - reach, reach), (0.0, -reach, 0.75)], 1
    ):
        found, state = waiting(room, at), [0.5 * (low + high), 0.0]
        error = step_through(centre(state, [], error=0.25, level=level), 0.0, cell, zeros(4)).error
        assert (found[SAMPLE], found[WEIGHT], found[COUNT]) == (4.0, 0.5, 4.0)
        assert found[STATE : STATE + 2] == pytest.approx(state, abs=1e-14)
        assert found[ERROR] == pytest.approx(error, rel=1e-9)
    # With saturation all below an edge act alike, and are one part.
    assert parted(room, 0, -0.75, rectangle, (-1.0, 0.0), drift=drift_of(-1.0), **more) == 2
    assert parts(room, 0, 2) == [(-1.0, 1.75 + reach, 1.0), (0.0, 0.75 + reach, 1.0)]


def test_a_single_state_is_in_the_part_of_its_reading_alone() -> None:
    room = small_room()
    assert parted(room, 0, -1.5, [0.0, 0.0], (-3.0, -1.0)) == 1
    assert (waiting(room, 0)[LEVEL], waiting(room, 0)[COUNT]) == (-2.0, 1.0)
    assert within(room, [0.5, 0.0], 1, -1.0, 0.0, 2) == 0
    assert within(room, [0.5, 0.0], 1, -1.0, 1.0, 2) == 1


def test_there_is_room_for_two_parts_of_each_reading_or_none_is_made() -> None:
    """Three readings: six places."""
    for places, first, found in ((6, 0, 3), (5, 0, -1), (7, 1, 4), (6, 1, -1)):
        room = small_room(pieces=places)
        assert parted(room, first, -1.0, SQUARE, (-2.0, 0.0)) == found


@pytest.mark.parametrize(
    ("radius", "middle", "sizes"), [(0.52, -0.5, [10.0, 10.0]), (0.5, -0.49, [9.0, 10.0]), (0.49, -0.5, [16.0])]
)
def test_a_part_with_more_corners_than_are_kept_goes_on_in_halves(
    radius: float, middle: float, sizes: list[float]
) -> None:
    """One corner of 16 beyond each edge makes 18, one beyond one edge 17. The halves are the whole."""
    room = small_room()
    ring = [c for k in range(16) for c in (radius * cos(k * pi / 8), 0.5 * radius * sin(k * pi / 8))]
    total = parted(room, 3, middle, ring, (-2.0, 0.0), error=0.25, sample=7.0, weight=0.5)
    found = [waiting(room, k) for k in range(3, total)]
    inside = [one for one in found if one[LEVEL] == -1.0]
    assert sorted(one[COUNT] for one in inside) == sizes
    assert all((one[SAMPLE], one[WEIGHT]) == (8.0, 0.5) for one in found)
    assert all(one[ERROR] == pytest.approx(0.375, abs=1e-12) for one in found)

    def area(one: list[float]) -> float:
        c = np.array(one[STATE + 2 :][: 2 * int(one[COUNT])]).reshape(-1, 2)
        return 0.5 * abs(float(np.sum(c[:, 0] * np.roll(c[:, 1], -1) - c[:, 1] * np.roll(c[:, 0], -1))))

    whole = 16 * 0.25 * radius**2 * sin(pi / 8) * 0.875  # the determinant of the plant
    assert sum(area(one) for one in found) == pytest.approx(whole, rel=1e-9)


# Merging.


@pytest.mark.parametrize("delay", [0, 2])
def test_every_cell_of_the_lattice_is_found_again(delay: int) -> None:
    """With its last reading, its torque and its commands, in a table that is full except for one place."""
    chance = random.Random(2)
    for _ in range(40):
        room, places = small_room(delay, slots=8), {}
        width = KEY + delay
        cells = {
            tuple(float(chance.randrange(-2, 2)) for _ in range(KEY))
            + tuple(0.5 * chance.randrange(3) for _ in range(delay))
            for _ in range(30)
        }
        for one in list(cells)[:7]:
            head = chance.randrange(2) if delay else 0
            ring = [one[KEY + (k - head) % 2] for k in range(delay)]
            at = slot(*one[:4], ring, head, room)
            assert room.used[at] == 0.0
            assert 0 <= at < 8
            room.used[at], room.keys[width * at : width * (at + 1)] = 1.0, list(one)
            places[one] = at
        assert all(slot(*one[:4], list(one[KEY:]), 0, room) == at for one, at in places.items())
        assert len(set(places.values())) == 7


def kept(room: PieceRoom, x: float, v: float, before: float = 0.0, ring: tuple[float, ...] = (), head: int = 0) -> bool:
    corners = [-0.125, 0.0, 0.125, 0.0, 0.0, 0.0625]
    told = centre([x, v], list(ring), before, head=head, level=-1.0, sample=5.0, weight=0.5)
    return keep(room, told, corners, 3, 2.0, drift_of(), BODY)


def test_a_cell_is_as_wide_as_the_lattice_and_velocities_count_by_the_norm() -> None:
    """Of width 2 and, with a root of the stiffness of 2, as high as 4."""
    for other, together in (
        ((1.99, 3.99), True),
        ((0.0, 0.0), True),
        ((2.0, 0.5), False),
        ((-0.01, 0.5), False),
        ((0.5, 4.0), False),
        ((0.5, -0.01), False),
    ):
        room = small_room()
        assert kept(room, 0.5, 0.5)
        assert kept(room, *other)
        assert room.counts[0] == (1.0 if together else 2.0)
        assert release(room, 3, 0, drift_of()) == (4 if together else 5)
        assert room.counts[0] == sum(room.used) == 0.0
        assert waiting(room, 3)[WEIGHT] == (1.0 if together else 0.5)


def test_only_pieces_with_one_memory_are_merged() -> None:
    for before, ring, head, together in (
        (-1.0, (1.0, 2.0), 0, True),
        (-1.0, (2.0, 1.0), 1, True),
        (0.0, (1.0, 2.0), 0, False),
        (-1.0, (1.0, 2.5), 0, False),
        (-1.0, (1.5, 2.0), 0, False),
        (-1.0, (1.0, 2.0), 1, False),
    ):
        room = small_room(2)
        room.scale[0] = 8.0
        assert kept(room, 0.5, 0.5, -1.0, (1.0, 2.0))
        assert kept(room, 0.5, 0.5, before, ring, head)
        assert release(room, 0, 2, drift_of()) == (1 if together else 2)
        found = waiting(room, 0, 2)
        assert (found[BEFORE], found[STATE + 2 : STATE + 4]) == (-1.0, [1.0, 2.0])
        assert found[WEIGHT] == (1.0 if together else 0.5)


def test_half_the_lattice_is_used_at_most() -> None:
    room = small_room(slots=8)
    assert [kept(room, 2.0 * k, 0.0) for k in range(6)] == [True] * 4 + [False] * 2
    assert kept(room, 2.0, 0.5)  # its cell is there
    assert room.counts[0] == 4.0
    assert [room.cells[CELL * int(at) + MEMBERS] for at in room.taken[:4]] == [1.0, 2.0, 1.0, 1.0]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_merged_rectangle_holds_its_members_with_their_errors_and_roundings(sign: float) -> None:
    """Errors of 1/4 and 1/2; 4 units of the middle's place and speed. A position is off by half its error."""
    room, rest = small_room(), (4096.0, drift_of(), BODY)
    pair = [-1.0, -2.0, 1.0, 1.5], [0.0, 0.0, -0.5, 0.25]
    for k, (error, corners) in enumerate(zip((0.25, 0.5), pair, strict=True)):
        z = [sign * (1024.0 + k), sign * (512.0 + k)]
        assert keep(room, centre(z, [], error=error, level=-7.0, sample=9.0), corners, 2, *rest)
    assert release(room, 2, 0, drift_of()) == 3
    found = waiting(room, 2)
    low_x = min(sign * 1024.0 - 1.0 - (0.125 + 4096.0 * UNIT), sign * 1025.0 - 0.5 - (0.25 + 4100.0 * UNIT))
    high_x = max(sign * 1024.0 + 1.0 + (0.125 + 4096.0 * UNIT), sign * 1025.0 + (0.25 + 4100.0 * UNIT))
    low_v = min(sign * 512.0 - 2.0 - (0.25 + 2048.0 * UNIT), sign * 513.0 - (0.5 + 2052.0 * UNIT))
    high_v = max(sign * 512.0 + 1.5 + (0.25 + 2048.0 * UNIT), sign * 513.0 + 0.25 + (0.5 + 2052.0 * UNIT))
    assert found[STATE : STATE + 2] == [0.5 * (low_x + high_x), 0.5 * (low_v + high_v)]
    x, v = found[STATE], found[STATE + 1]
    box = [low_x - x, low_v - v, high_x - x, low_v - v, high_x - x, high_v - v, low_x - x, high_v - v]
    assert found[STATE + 2 : STATE + 10] == box
    assert found[ERROR] == 4.0 * UNIT * (2.0 * (abs(low_x) + abs(high_x)) + abs(low_v) + abs(high_v))
    assert [found[k] for k in (BEFORE, LEVEL, SAMPLE, WEIGHT, COUNT)] == [0.0, 0.0, 0.0, 2.0, 4.0]


def test_a_rectangle_around_zero_counts_both_its_sides() -> None:
    room, rest, told = small_room(), (8.0, drift_of(), BODY), centre([0.5, 0.25], [])
    assert keep(room, told, [-3.5, -1.25, 0.5, 0.75], 2, *rest)
    assert keep(room, told, [0.0, 0.0], 1, *rest)
    assert release(room, 0, 0, drift_of()) == 1
    assert waiting(room, 0)[ERROR] == pytest.approx(4.0 * UNIT * (2.0 * (3.0 + 1.0) + 1.0 + 1.0), rel=1e-12)


def test_a_box_is_told_corner_by_corner() -> None:
    out = zeros(9)
    put_box(out, 1, 1.0, 2.0, 3.0, 4.0)
    assert out == [0.0, 1.0, 3.0, 2.0, 3.0, 2.0, 4.0, 1.0, 4.0]


@pytest.mark.parametrize("delay", [0, 2])
def test_one_alone_goes_on_as_it_is(delay: int) -> None:
    """A cell that was used before counts its members anew."""
    room, ring = small_room(delay), [1.0, 2.0][:delay]
    before = zeros(piece_size(2, delay))
    told = centre([3.0, 0.2], ring, -4.0, error=1e-9, level=-1.0, sample=5.0, weight=0.5)
    for _ in range(2):
        assert keep(room, told, SQUARE, 4, 100.0, drift_of(), BODY)
        put(before, 0, told, SQUARE, 4, room.middle, drift_of(), 2)
        assert release(room, 4, delay, drift_of()) == 5
        assert waiting(room, 4, delay) == before
