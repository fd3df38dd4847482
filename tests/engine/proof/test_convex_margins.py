"""Polygons about a centre on their margins: of small whole numbers, of which nothing is rounded, against exact ones."""

from fractions import Fraction
from itertools import product
from math import inf, sqrt

import numpy as np
import pytest

from hknob_cli.engine.general.sets.convex import (
    MOST_CORNERS,
    append,
    drop_edge,
    extent,
    hull,
    keep_side,
    radius_of,
    recentre,
    sort_points,
    turns_left,
    widen,
)

from .rooms import zeros
from .test_convex_region_margins import BLUNT, Corner, corners, flat, meeting, side, some_points
from .test_convex_region_margins import hull as exact_hull


def test_sizes_of_a_polygon() -> None:
    four = [(3.0, -1.0), (4.0, 2.0), (-5.0, 3.0), (-2.0, -7.0)]
    for by in range(4):
        some = flat(four[by:] + four[:by])
        assert extent(some, 4) == (-5.0, 4.0, -7.0, 3.0)
        for beta in (0.25, 1.0, 100.0):
            assert radius_of(some, 4, beta) == pytest.approx(
                max(sqrt(x * x + v * v / beta) for x, v in four), rel=1e-15
            )
        assert recentre(some, 4) == (-0.5, -2.0)
        assert extent(some, 4) == (-4.5, 4.5, -5.0, 5.0)
        assert corners(some, 4)[-by % 4] == (3.5, 1.0)
        assert recentre(some, 4) == (0.0, 0.0)
    assert radius_of([0.25, 0.0], 1, 4.0) == 0.25
    for moved in ((2.0, 0.0), (0.0, 2.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        one = list(moved)
        assert recentre(one, 1) == moved
        assert one == [0.0, 0.0]


def test_a_corner_is_entered_once() -> None:
    out = [1.0, 2.0, 3.0, 4.0, 7.0, 7.0]
    assert append(out, 2, 3.0, 4.0) == 2
    assert out[4:] == [7.0, 7.0]
    for other in ((3.0, 5.0), (5.0, 4.0), (1.0, 2.0)):
        assert append(out, 2, *other) == 3
        assert out[4:] == list(other)
    assert append(out, 1, 1.0, 2.0) == 1
    assert append(out, 0, 9.0, 8.0) == 1
    assert out[:4] == [9.0, 8.0, 3.0, 4.0]
    out[-2:] = [0.5, 0.25]  # no corner comes before the first: these numbers are none
    assert append(out, 0, 0.5, 0.25) == 1
    assert out[:2] == [0.5, 0.25]


def kept(points: list[Corner], a: int, b: int, c: float) -> list[Corner]:
    """Corners on the line's side or on it, and where the outline crosses it, exactly."""
    found: list[Corner] = []
    for k, (px, pv) in enumerate(points):
        qx, qv = points[(k + 1) % len(points)]
        here, there = Fraction(a * px + b * pv - c), Fraction(a * qx + b * qv - c)
        if here >= 0:
            found.append((px, pv))
        if here * there < 0:
            part = here / (here - there)
            found.append((float(px + part * Fraction(qx - px)), float(pv + part * Fraction(qv - pv))))
    return found


@pytest.mark.parametrize("seed", range(25))
def test_a_polygon_is_cut_by_any_line(seed: int) -> None:
    """Points and segments are polygons, too. What lies on the line is kept."""
    points = exact_hull(some_points(seed))
    for a, b, c in product((-1, 0, 2), (-2, 0, 1), (-3, 0, 1, 0.5, -0.5)):
        out = zeros(60)
        count = keep_side(flat(points), len(points), a, b, c, out)
        expected = kept(points, a, b, c)
        if len(points) == 2 and len(expected) > 2:
            expected = list(dict.fromkeys(expected))
        assert np.array(corners(out, count)).ravel() == pytest.approx(np.array(expected).ravel(), rel=1e-15, abs=1e-15)


def test_an_outline_that_crosses_more_than_twice_is_kept_whole() -> None:
    """Rounding may make such an outline. A last corner that equals the first is not entered again."""
    zigzag = [(-2.0, 0.0), (-1.0, 2.0), (0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (0.0, -3.0)]
    for by in range(6):
        some, out = flat(zigzag[by:] + zigzag[:by]), zeros(40)
        assert keep_side(some, 6, 0.0, 1.0, 1.0, out) == 6
        assert out[:12] == some
        assert keep_side(some, 6, 0.0, 1.0, -1.0, out) == 7
    again, out = flat([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 0.0)]), zeros(20)
    assert keep_side(again, 4, 1.0, 0.0, -1.0, out) == 3
    assert keep_side([1.0, 2.0], 1, 1.0, 0.0, 0.0, out) == 1
    near = flat([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)])  # one number the same is another corner
    assert keep_side(near, 4, 1.0, 0.0, -1.0, out) == 4
    assert keep_side(flat([(0.0, 0.0), (2.0, 1.0), (1.0, 0.0)]), 3, 1.0, 0.0, -1.0, out) == 3


@pytest.mark.parametrize("seed", range(40))
def test_the_hull_is_exact(seed: int) -> None:
    points = some_points(seed)
    given, out = flat(points), zeros(100)
    sort_points(given, len(points))
    assert corners(given, len(points)) == sorted(points)
    count = hull(flat(points), len(points), out)
    assert corners(out, count) == exact_hull(points)
    (a, b, c) = [*points, *points, *points][:3]
    assert turns_left(flat([(9.0, 9.0), a, b]), 3, *c) is (side(a, b, c) > 0.0)


@pytest.mark.parametrize("seed", range(40))
def test_a_rectangle_is_added_to_every_state(seed: int) -> None:
    points = exact_hull(some_points(seed))
    for more_x, more_v in ((0.5, 0.25), (0.0, 0.5), (0.25, 0.0), (0.0, 0.0), (1.0, 1.0)):
        out = flat(points) + zeros(200)
        count = widen(out, len(points), more_x, more_v, zeros(200))
        around = exact_hull(
            [(x + i * more_x, v + j * more_v) for x, v in points for i, j in product((-1, 1), repeat=2)]
        )
        assert count == min(len(around), MOST_CORNERS)
        if len(around) <= MOST_CORNERS:
            assert corners(out, count) == around


def plain_meeting(points: list[Corner], k: int) -> tuple[float, float, float]:
    """`meeting`, at the very place."""
    n = len(points)
    (ax, av), (bx, bv), (cx, cv), (dx, dv) = ([Fraction(x) for x in points[(k + j) % n]] for j in (-1, 0, 1, 2))
    cross = (bx - ax) * (cv - dv) - (bv - av) * (cx - dx)
    if cross >= 0:
        return inf, 0.0, 0.0
    t = ((cx - bx) * (cv - dv) - (cv - bv) * (cx - dx)) / cross
    if t < 0:
        return inf, 0.0, 0.0
    x, v = bx + t * (bx - ax), bv + t * (bv - av)
    return float(abs((cx - bx) * (v - bv) - (cv - bv) * (x - bx))), float(x), float(v)


def test_as_many_corners_as_are_kept_are_kept() -> None:
    for count, left in ((11, 11), (12, 12), (13, 12)):
        turns = 2.0 * np.pi * np.arange(count) / count
        out = np.column_stack([np.cos(turns), np.sin(turns)]).ravel().tolist() + zeros(30)
        assert widen(out, count, 0.0, 0.0, zeros(200)) == left


LONG = [(0.0, 0.0), (6.0, -1.0), (9.0, 0.0), (10.0, 3.0), (8.0, 7.0), (3.0, 8.0), (-1.0, 5.0)]


HOUSE = [(0.0, 0.0), (4.0, 0.0), (5.0, 1.0), (5.0, 4.0), (0.0, 4.0)]  # with walls that never meet
TINY = [(x / 16.0, v / 16.0) for x, v in HOUSE]


@pytest.mark.parametrize("shape", [BLUNT, LONG, BLUNT[:5], HOUSE, TINY])
def test_the_edge_that_adds_least_is_left_out(shape: list[Corner]) -> None:
    n = len(shape)
    for by, turns in product(range(n), range(4)):
        points = shape[by:] + shape[:by]
        for _ in range(turns):
            points = [(-v - 3.0, x + 2.0) for x, v in points]
        found = [plain_meeting(points, k) for k in range(n)]
        least = min(range(n), key=lambda k: found[k][0])
        assert found[least][0] < inf
        expected = list(points)
        expected[least] = found[least][1:]
        del expected[(least + 1) % n]
        out = flat(points)
        assert drop_edge(out, n) == n - 1
        assert np.array(corners(out, n - 1)) == pytest.approx(np.array(expected), rel=1e-13, abs=1e-13)
        assert meeting(points, least)[1:] == pytest.approx(found[least][1:], rel=1e-8)


def test_where_no_edges_meet_the_rectangle_takes_the_place() -> None:
    """Of an outline that is no polygon: a star turned round, five corners and each side across the others."""
    star = [(0.0, 3.0), (-2.0, -2.0), (3.0, 1.0), (-3.0, 1.0), (2.0, -2.0)]
    assert all(plain_meeting(star[::-1], k)[0] == inf for k in range(5))
    out = flat(star[::-1])
    assert drop_edge(out, 5) == 4
    assert corners(out, 4) == [(-3.0, -2.0), (3.0, -2.0), (3.0, 3.0), (-3.0, 3.0)]
