"""Polygons cut, moved and merged: what lies on a limit is in both parts, and every rounding is carried on."""

import random
from math import cos, exp, pi, sin, sqrt

import mpmath as mp
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.loop import Loop, make_loop
from hknob_cli.engine.sets.ball import Centre, step_through
from hknob_cli.engine.sets.polygon import (
    CELL,
    COUNT,
    ERROR,
    LEVEL,
    MEMBERS,
    POLYGON,
    SAMPLE,
    WEIGHT,
    V,
    X,
    blur,
    clip,
    corner_radius,
    keep,
    move_corners,
    part,
    put,
    put_next,
    release,
    slot,
)
from hknob_cli.engine.sets.room import PolygonRoom

from .orbits import DIGITS, plant
from .rooms import small_room, waiting, zeros

LOOP = make_loop(0.3, 0.25, 0.5, 0.3, 1.0, 0.0, 0.0)
SQUARE = [-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5]
NOTHING = Centre(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


# Moving.


def test_the_stated_blur() -> None:
    """64 units, and as many for each radian that the plant rings until it has decayed."""
    assert blur(make_loop(0.25, 0.25, 1.0, 1.0, 1.0, 0.0, 0.0)) == 64.0 * EPSILON * 3.0
    assert blur(make_loop(2.0, 0.25, 1.0, 1.0, 1.0, 0.0, 0.0)) == 64.0 * EPSILON * 1.25


def test_corners_are_moved_to_within_the_blur() -> None:
    """At 60 digits, after one sample and after thousands, of the largest difference that there was."""
    chance, worst = random.Random(1), mp.mpf(0)
    with mp.workdps(DIGITS):
        for _ in range(400):
            beta = 10.0 ** chance.uniform(-5.0, 2.0)
            loop = make_loop(sqrt(beta) * 10.0 ** chance.uniform(-3.0, 1.0), beta, 1.0, 1.0, 1.0, 0.0, 0.0)
            samples, out = int(10.0 ** chance.uniform(0.0, 4.0)), [0.0, 0.0]
            dx, dv = chance.gauss(0.0, 1.0), chance.gauss(0.0, 1.0) * sqrt(beta)
            move_corners([dx, dv], 0, 1, samples, out, 0, loop)
            p, s, _, f = plant(loop, samples)
            off_x, off_v = p * dx + s * dv - out[0], -mp.mpf(beta) * s * dx + f * dv - out[1]
            first = mp.sqrt(mp.mpf(dx) ** 2 + mp.mpf(dv) ** 2 / beta)
            error = mp.sqrt(off_x**2 + off_v**2 / beta) / first
            assert error <= blur(loop)
            worst = max(worst, error / blur(loop))
    assert worst > 1.0 / 100.0


def test_the_radius_is_that_of_the_farthest_corner() -> None:
    """Speeds count twice: 0.3 and 2 * 0.2 are 0.5 apart."""
    corners = [9.0, 9.0, 0.1, 0.0, 0.3, -0.2, 0.0, 0.1]
    assert corner_radius(corners, 2, 3, LOOP) == pytest.approx(0.5, rel=1e-12)
    assert corner_radius(corners, 4, 2, LOOP) == pytest.approx(0.5, rel=1e-12)
    assert corner_radius(corners, 6, 1, LOOP) == pytest.approx(0.2, rel=1e-12)


# Cutting.


def test_a_flat_polygon_that_a_line_crosses_too_often_is_kept_whole() -> None:
    """Rounding may leave corners of an edge a last bit to either side of a line along it."""
    flat = [1.0 + bit * 2.0**-52 for bit in (0, 2, 0, 2, 0)]
    corners = [number for x, v in zip(flat, (-3.0, -2.0, -1.0, 0.0, 4.0), strict=True) for number in (x, v)]
    out = zeros(64)
    for sign in (1.0, -1.0):
        assert clip(corners, 5, 1.0 + 2.0**-52, sign, out, 4) == 5
        assert out[4:14] == corners


def test_what_lies_on_a_limit_belongs_to_both_sides() -> None:
    """An edge of the square, and a corner of a triangle."""

    def corners_of(given: list[float], limit: float, sign: float) -> set[tuple[float, float]]:
        out = zeros(64)
        kept = clip(given, len(given) // 2, limit, sign, out, 2)
        return set(zip(out[2 : 2 + 2 * kept : 2], out[3 : 3 + 2 * kept : 2], strict=True))

    triangle = [0.0, 0.0, 1.0, -0.5, 1.0, 0.5]
    tip, base = {(0.0, 0.0)}, {(1.0, -0.5), (1.0, 0.5)}
    assert corners_of(SQUARE, 1.0, 1.0) == base
    assert corners_of(SQUARE, -1.0, -1.0) == {(-1.0, -0.5), (-1.0, 0.5)}
    assert corners_of(triangle, 0.0, -1.0) == tip
    assert corners_of(triangle, -1e-300, -1.0) == set()
    assert corners_of(triangle, 0.0, 1.0) == tip | base
    assert corners_of(triangle, 0.5, 1.0) == base | {(0.5, -0.25), (0.5, 0.25)}
    assert corners_of(triangle, 0.5, -1.0) == tip | {(0.5, -0.25), (0.5, 0.25)}
    wide = [1.0, 0.0, 5.0, -1.0, 5.0, 1.0]
    assert corners_of(wide, 2.0, -1.0) == {(1.0, 0.0), (2.0, -0.25), (2.0, 0.25)}


def test_a_polygon_is_told_from_the_middle_of_its_rectangle() -> None:
    out = zeros(POLYGON + 1)
    corners = [1.0, 3.0, 4.0, 2.0, 5.0, 6.0, 2.0, 7.0]
    put(out, 1, Centre(16.0, 32.0, 0.125, -2.0, 9.0, 0.75), corners, 4)
    found = out[1:]
    assert [found[k] for k in (X, V, ERROR, LEVEL, SAMPLE, WEIGHT, COUNT)] == [19.0, 36.5, 0.125, -2.0, 9.0, 0.75, 4.0]
    assert found[7:15] == [-2.0, -1.5, 1.0, -2.5, 2.0, 1.5, -1.0, 2.5]
    put(out, 1, NOTHING, [-3.0, -1.0, -2.0, 5.0, -7.0, 2.0], 3)
    assert (found[X], out[1 + X], out[1 + V]) == (19.0, -4.5, 2.0)


def test_a_part_goes_on_one_sample_later_as_its_level() -> None:
    """Its middle as a trial, with the rounding of that sample; its corners as free motions."""
    room = small_room()
    put_next(room, 2, Centre(3.0, -1.0, 1e-9, -2.0, 7.0, 0.5), SQUARE, 4, LOOP)
    found = waiting(room, 2)
    x, v, error, _ = step_through(3.0, -1.0, 1e-9, -2.0, [], 0, LOOP)
    assert [found[k] for k in (X, V, ERROR, LEVEL, SAMPLE, WEIGHT, COUNT)] == [x, v, error, -2.0, 8.0, 0.5, 4.0]
    moved = zeros(8)
    move_corners(SQUARE, 0, 4, 1, moved, 0, LOOP)
    assert found[7:15] == moved


@pytest.mark.parametrize("reach", [0.0, 0.0625])
def test_parts_reach_beyond_their_edges_by_what_they_must(reach: float) -> None:
    """Levels -2 to 0 of a rectangle from -1.75 to 0.75, and no part of level -3."""
    room = small_room()
    rectangle = [-1.0, -0.5, 1.5, -0.5, 1.5, 0.5, -1.0, 0.5]
    assert part(room, 1, Centre(-0.75, 0.0, reach, 5.0, 3.0, 1.0), rectangle, 4, -3.0, 0.0, LOOP) == 4
    for at, (level, low, high) in enumerate(
        [(-2.0, -1.75, -1.0 + reach), (-1.0, -1.0 - reach, reach), (0.0, -reach, 0.75)], 1
    ):
        found = waiting(room, at)
        before = zeros(POLYGON)
        put(before, 0, NOTHING, [low, -0.5, high, -0.5, high, 0.5, low, 0.5], 4)
        x, v, error, _ = step_through(before[X], before[V], reach, level, [], 0, LOOP)
        assert (found[LEVEL], found[COUNT]) == (level, 4.0)
        assert found[:3] == pytest.approx([x, v, error], rel=1e-12, abs=1e-15)
    other = make_loop(0.3, 0.25, 0.5, 0.3, -1.0, 0.0, 0.0)  # of "ceil" the edges belong to the other side
    assert part(room, 0, Centre(-0.75, 0.0, reach, 5.0, 3.0, 1.0), rectangle, 4, -1.0, 0.0, other) == 2


def test_there_is_room_for_two_parts_of_each_level_or_none_is_made() -> None:
    """Three levels: six places."""
    for places, first, found in ((6, 0, 3), (5, 0, -1), (7, 1, 4), (6, 1, -1)):
        room = small_room(polygons=places)
        assert part(room, first, Centre(-1.0, 0.0, 0.0, 5.0, 0.0, 1.0), SQUARE, 4, -2.0, 0.0, LOOP) == found
    one = Centre(1.5, 0.0, 0.0, 5.0, 0.0, 1.0)
    assert part(small_room(polygons=2), 0, one, SQUARE, 4, 0.0, 0.0, LOOP) == 1


def area(found: list[float]) -> float:
    """Of a polygon, by its corners."""
    count, c = int(found[COUNT]), found[7:]
    return 0.5 * abs(
        sum(c[2 * k] * c[(2 * k + 3) % (2 * count)] - c[2 * k + 1] * c[(2 * k + 2) % (2 * count)] for k in range(count))
    )


@pytest.mark.parametrize(
    ("radius", "middle", "sizes"),
    [(0.52, -0.5, [10.0, 10.0]), (0.5, -0.49, [9.0, 10.0]), (0.49, -0.5, [16.0])],
)
def test_a_part_with_more_corners_than_are_kept_goes_on_in_halves(
    radius: float, middle: float, sizes: list[float]
) -> None:
    """One corner of 16 beyond each edge makes 18, one beyond one edge 17. The halves are the whole."""
    room = small_room()
    ring = [c for k in range(16) for c in (radius * cos(k * pi / 8), 0.5 * radius * sin(k * pi / 8))]
    total = part(room, 3, Centre(middle, 0.0, 0.0, 5.0, 7.0, 0.5), ring, 16, -2.0, 0.0, LOOP)
    found = [waiting(room, k) for k in range(3, total)]
    inside = [one for one in found if one[LEVEL] == -1.0]
    assert sorted(one[COUNT] for one in inside) == sizes
    assert all((one[SAMPLE], one[WEIGHT]) == (8.0, 0.5) for one in found)
    shrunk = exp(-LOOP.alpha)  # by Liouville
    whole = 16 * 0.25 * radius**2 * sin(pi / 8)
    assert sum(area(one) for one in found) == pytest.approx(shrunk * whole, rel=1e-9)
    assert all(room.stack[POLYGON * total + k] == 0.0 for k in range(POLYGON))


# Merging.


def test_every_cell_of_the_lattice_is_found_again() -> None:
    """In a table that is full except for one place, whatever falls together."""
    chance = random.Random(2)
    for _ in range(50):
        room, places = small_room(slots=8), {}
        cells = {(float(chance.randrange(-3, 3)), float(chance.randrange(-3, 3))) for _ in range(30)}
        for cell in list(cells)[:7]:
            at = slot(*cell, room)
            assert room.used[at] == 0.0
            assert 0 <= at < 8
            room.used[at], room.keys[2 * at], room.keys[2 * at + 1] = 1.0, *cell
            places[cell] = at
        assert all(slot(*cell, room) == at for cell, at in places.items())
        assert len(set(places.values())) == 7


def kept(room: PolygonRoom, x: float, v: float, loop: Loop = LOOP, width: float = 2.0, error: float = 0.0) -> bool:
    return keep(room, Centre(x, v, error, -1.0, 5.0, 0.5), [-0.125, 0.0, 0.125, 0.0, 0.0, 0.0625], 3, width, loop)


def test_a_cell_is_as_wide_as_the_lattice_and_velocities_count_by_the_norm() -> None:
    """Of width 2 and, with a root of the stiffness of 1/2, as high as 1."""
    for other, together in (
        ((1.99, 0.99), True),
        ((0.0, 0.0), True),
        ((2.0, 0.5), False),
        ((-0.01, 0.5), False),
        ((0.5, 1.0), False),
        ((0.5, -0.01), False),
    ):
        room = small_room()
        assert kept(room, 0.5, 0.5)
        assert kept(room, *other)
        assert room.counts[0] == (1.0 if together else 2.0)
        assert release(room, 3, LOOP) == (4 if together else 5)
        assert room.counts[0] == sum(room.used) == 0.0
        assert waiting(room, 3)[WEIGHT] == (1.0 if together else 0.5)


def test_half_the_lattice_is_used_at_most() -> None:
    room = small_room(slots=8)
    assert [kept(room, 2.0 * k, 0.0) for k in range(6)] == [True] * 4 + [False] * 2
    assert kept(room, 2.0, 0.5)  # its cell is there
    assert room.counts[0] == 4.0
    assert [room.cells[CELL * int(at) + MEMBERS] for at in room.taken[:4]] == [1.0, 2.0, 1.0, 1.0]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_merged_rectangle_holds_its_members_with_their_errors_and_roundings(sign: float) -> None:
    """Errors of 1/4 and 1/2; 4 units of the middle's place and speed. A velocity is off by half its error."""
    room, unit = small_room(), EPSILON
    assert keep(room, Centre(sign * 1024.0, sign * 512.0, 0.25, 0.0, 0.0, 1.0), [-1.0, -2.0, 1.0, 1.5], 2, 4096.0, LOOP)
    assert keep(room, Centre(sign * 1025.0, sign * 513.0, 0.5, 0.0, 0.0, 1.0), [0.0, 0.0, -0.5, 0.25], 2, 4096.0, LOOP)
    assert release(room, 2, LOOP) == 3
    found = waiting(room, 2)
    low_x = min(sign * 1024.0 - 1.0 - (0.25 + 4096.0 * unit), sign * 1025.0 - 0.5 - (0.5 + 4100.0 * unit))
    high_x = max(sign * 1024.0 + 1.0 + (0.25 + 4096.0 * unit), sign * 1025.0 + (0.5 + 4100.0 * unit))
    low_v = min(sign * 512.0 - 2.0 - (0.125 + 2048.0 * unit), sign * 513.0 - (0.25 + 2052.0 * unit))
    high_v = max(sign * 512.0 + 1.5 + (0.125 + 2048.0 * unit), sign * 513.0 + 0.25 + (0.25 + 2052.0 * unit))
    assert found[X] == 0.5 * (low_x + high_x)
    assert found[V] == 0.5 * (low_v + high_v)
    x, v = found[X], found[V]
    assert found[7:15] == [low_x - x, low_v - v, high_x - x, low_v - v, high_x - x, high_v - v, low_x - x, high_v - v]
    size = abs(low_x) + abs(high_x) + 2.0 * (abs(low_v) + abs(high_v))
    assert found[ERROR] == 4.0 * unit * size
    assert (found[LEVEL], found[SAMPLE], found[WEIGHT], found[COUNT]) == (0.0, 0.0, 2.0, 4.0)


def test_a_rectangle_around_zero_counts_both_its_sides() -> None:
    room, unit = small_room(), EPSILON
    assert keep(room, Centre(0.5, 0.25, 0.0, 0.0, 0.0, 1.0), [-3.5, -1.25, 0.5, 0.75], 2, 8.0, LOOP)
    assert keep(room, Centre(0.5, 0.25, 0.0, 0.0, 0.0, 1.0), [0.0, 0.0], 1, 8.0, LOOP)
    assert release(room, 0, LOOP) == 1
    assert waiting(room, 0)[ERROR] == pytest.approx(4.0 * unit * (3.0 + 1.0 + 2.0 * (1.0 + 1.0)), rel=1e-12)


def test_one_alone_goes_on_as_it_is() -> None:
    room, before = small_room(), zeros(POLYGON)
    assert keep(room, Centre(3.0, 0.2, 1e-9, -1.0, 5.0, 0.5), SQUARE, 4, 100.0, LOOP)
    put(before, 0, Centre(3.0, 0.2, 1e-9, -1.0, 5.0, 0.5), SQUARE, 4)
    assert release(room, 4, LOOP) == 5
    assert waiting(room, 4) == before
