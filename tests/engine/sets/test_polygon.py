"""Tests of `engine.sets.polygon` and `engine.sets.polygon`: no state is lost by cutting, moving and merging."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.loop import Loop, level_of, lower_edge, upper_edge
from hknob_cli.engine.sets.ball import Centre, step_through
from hknob_cli.engine.sets.polygon import (
    CORNERS,
    COUNT,
    ERROR,
    LEVEL,
    POLYGON,
    SAMPLE,
    WEIGHT,
    V,
    X,
    clip,
    corner_radius,
    keep,
    move_corners,
    part,
    put,
    release,
)
from hknob_cli.engine.sets.room import PolygonRoom, make_polygon_room

from .loops import free_response, loops, zeros

small = settings(deadline=None)


@pytest.fixture(scope="module")
def room() -> PolygonRoom:
    """Work space of the interpreter."""
    return make_polygon_room(zeros)


def convex(points: np.ndarray) -> list[float]:
    """Corners of the hull of points, in order, flat."""
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points).vertices].ravel().tolist()


@st.composite
def polygons(draw: st.DrawFn, most: int = CORNERS) -> list[float]:
    """A convex polygon about 0 with at most so many corners, not thin."""
    count = draw(st.integers(3, most))
    seed = draw(st.integers(0, 2**32 - 1))
    chance = np.random.default_rng(seed)
    angles = np.sort(chance.uniform(0, 2 * np.pi, count))
    radius = draw(st.floats(0.01, 4.0))
    return convex(radius * np.column_stack([np.cos(angles), np.sin(angles)]) * [1.0, chance.uniform(0.05, 1.0)])


def inside(x: float, v: float, corners: list[float], slack: float) -> bool:
    """Whether a point lies in a convex polygon, or no farther than ``slack`` from it in each of its half planes."""
    points = np.array(corners).reshape(-1, 2)
    following = np.roll(points, -1, axis=0)
    edges = following - points
    lengths = np.hypot(*edges.T)
    area = 0.5 * np.sum(points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0])
    side = edges[:, 0] * (v - points[:, 1]) - edges[:, 1] * (x - points[:, 0])
    return bool(np.all(np.sign(area or 1.0) * side >= -slack * (lengths + 1e-300)))


def states_of(corners: list[float], count: int, seed: int) -> np.ndarray:
    """Random states of a polygon, its corners among them."""
    points = np.array(corners).reshape(-1, 2)
    shares = np.random.default_rng(seed).dirichlet(np.full(len(points), 0.4), count)
    return np.vstack([points, shares @ points])


@small
@given(corners=polygons(), limit=st.floats(-4.0, 4.0), sign=st.sampled_from([1.0, -1.0]))
def test_clipping_keeps_one_side(corners: list[float], limit: float, sign: float) -> None:
    """Every state of that side, and no state of the other."""
    out = zeros(64)
    kept = clip(corners, len(corners) // 2, limit, sign, out, 4)
    found = out[4 : 4 + 2 * kept]
    assert kept <= len(corners) // 2 + 1
    assert all(sign * (x - limit) >= -1e-12 for x in found[::2])
    for x, v in states_of(corners, 30, 1):
        if sign * (x - limit) > 1e-9:
            assert kept > 0
            assert inside(x, v, found, 1e-9)


@small
@given(loop=loops, corners=polygons(), samples=st.integers(0, 40))
def test_corners_move_as_the_plant_does(loop: Loop, corners: list[float], samples: int) -> None:
    """By a matrix exponential; and in the norm of the radius they never move apart."""
    count = len(corners) // 2
    out = zeros(80)
    move_corners([0.0, 0.0, 0.0, *corners], 3, count, samples, out, 2, loop)
    expected = np.array(corners).reshape(-1, 2) @ free_response(loop, float(samples)).T
    scale = corner_radius(corners, 0, count, loop) * (1.0 + sqrt(loop.beta))
    assert np.array(out[2 : 2 + 2 * count]) == pytest.approx(expected.ravel(), abs=1e-11 * (1.0 + scale))
    assert corner_radius(out, 2, count, loop) <= corner_radius(corners, 0, count, loop) * (1.0 + 1e-9) + 1e-12 * scale


@small
@given(loop=loops, corners=polygons())
def test_no_state_is_farther_than_the_radius(loop: Loop, corners: list[float]) -> None:
    """In the norm of `certificate.distance`."""
    radius = corner_radius(corners, 0, len(corners) // 2, loop)
    apart = [sqrt(x * x + v * v / loop.beta) for x, v in states_of(corners, 50, 2)]
    assert max(apart) == pytest.approx(radius, rel=1e-9)


@settings(deadline=None, max_examples=200)
@given(
    loop=loops,
    corners=polygons(),
    x=st.floats(-5.0, 3.0),
    v=st.floats(-2.0, 2.0),
    reach=st.sampled_from([0.0, 1e-9, 0.03]),
)
def test_every_state_goes_on_in_a_part_of_its_level(
    room: PolygonRoom, loop: Loop, corners: list[float], x: float, v: float, reach: float
) -> None:
    """One sample later each state lies in a part, whichever level it acts as of those within reach of it."""
    count = len(corners) // 2
    low = level_of(x + min(corners[::2]) - reach, loop.sense)
    high = level_of(x + max(corners[::2]) + reach, loop.sense)
    waiting = part(room, 0, Centre(x, v, reach, 5.0, 7.0, 0.25), corners, count, low, high, loop)
    assert waiting >= 1
    found = [room.stack[POLYGON * k : POLYGON * (k + 1)] for k in range(waiting)]
    assert all(p[COUNT] <= CORNERS and p[SAMPLE] == 8.0 and p[WEIGHT] == 0.25 and p[ERROR] >= reach for p in found)
    scale = 1.0 + loop.kappa * 10.0 + loop.beta * 10.0
    for dx, dv in states_of(corners, 12, 3):
        for near in {level_of(x + dx + side * 0.999 * reach, loop.sense) for side in (-1.0, 0.0, 1.0)}:
            if min(abs(x + dx - lower_edge(near, loop.sense)), abs(x + dx - upper_edge(near, loop.sense))) < 1e-9:
                continue
            at_x, at_v, _, _ = step_through(x + dx, v + dv, 0.0, near, [], 0, loop)
            hulls = [p for p in found if p[LEVEL] == near]
            corner_lists = [
                [c + (p[X] if k % 2 == 0 else p[V]) for k, c in enumerate(p[7 : 7 + 2 * int(p[COUNT])])] for p in hulls
            ]
            assert any(inside(at_x, at_v, hull, 1e-9 * scale) for hull in corner_lists)


def test_parts_lie_within_their_level_but_for_the_reach(room: PolygonRoom) -> None:
    """A square over three edges: parts of one count each, grown by the reach, one sample on."""
    from .loops import knob

    loop = knob()
    square = [-1.5, -0.1, 1.5, -0.1, 1.5, 0.1, -1.5, 0.1]
    assert part(room, 0, Centre(-0.2, 0.0, 0.01, 5.0, 0.0, 1.0), square, 4, -2.0, 0.0, loop) == 3
    found = [room.stack[POLYGON * k : POLYGON * (k + 1)] for k in range(3)]
    assert [p[LEVEL] for p in found] == [-2.0, -1.0, 0.0]
    area = [
        0.5 * abs(np.sum(c[:, 0] * np.roll(c[:, 1], -1) - c[:, 1] * np.roll(c[:, 0], -1)))
        for c in (np.array(p[7 : 7 + 2 * int(p[COUNT])]).reshape(-1, 2) for p in found)
    ]
    shrunk = np.linalg.det(free_response(loop, 1.0))
    assert area == pytest.approx([shrunk * 0.2 * width for width in (0.71, 1.02, 1.31)], rel=1e-9)


def test_a_polygon_with_too_many_corners_is_halved(room: PolygonRoom) -> None:
    """Nothing is added to it: both halves have the area of the whole."""
    from .loops import knob

    loop = knob()
    angles = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False) + 0.1
    corners = (0.4 * np.column_stack([np.cos(angles), np.sin(angles)])).ravel().tolist()
    waiting = part(room, 0, Centre(-0.02, 0.0, 0.0, 5.0, 0.0, 1.0), corners, CORNERS, -1.0, 0.0, loop)
    total = 0.0
    for k in range(waiting):
        p = room.stack[POLYGON * k : POLYGON * (k + 1)]
        assert 3 <= p[COUNT] <= CORNERS
        c = np.array(p[7 : 7 + 2 * int(p[COUNT])]).reshape(-1, 2)
        total += 0.5 * abs(np.sum(c[:, 0] * np.roll(c[:, 1], -1) - c[:, 1] * np.roll(c[:, 0], -1)))
    whole = 0.5 * CORNERS * 0.16 * np.sin(2.0 * np.pi / CORNERS)
    assert total == pytest.approx(whole * np.linalg.det(free_response(loop, 1.0)), rel=1e-9)


def test_no_part_is_left_out_for_lack_of_room() -> None:
    """It is said instead."""
    from .loops import knob

    narrow = make_polygon_room(zeros)._replace(stack=zeros(3 * POLYGON))
    square = [-5.5, -0.1, 5.5, -0.1, 5.5, 0.1, -5.5, 0.1]
    assert part(narrow, 0, Centre(-3.0, 0.0, 0.0, 5.0, 0.0, 1.0), square, 4, -9.0, 0.0, knob()) == -1


@small
@given(loop=loops, shapes=st.lists(polygons(most=6), min_size=1, max_size=4), width=st.floats(0.5, 4.0))
def test_merged_polygons_hold_all_their_states(
    room: PolygonRoom, loop: Loop, shapes: list[list[float]], width: float
) -> None:
    """Those in one cell of the lattice lie, with their errors, in the rectangle that goes on for them."""
    kept = []
    for k, corners in enumerate(shapes):
        x, v, error = 0.3 * k, 0.1 * k, 1e-3 * (k + 1)
        assert keep(room, Centre(x, v, error, -1.0, 5.0, 0.5), corners, len(corners) // 2, width, loop)
        kept.append((x, v, error, corners))
    waiting = int(release(room, 0, loop))
    assert room.counts[0] == 0.0
    found = [room.stack[POLYGON * k : POLYGON * (k + 1)] for k in range(waiting)]
    assert sum(p[WEIGHT] for p in found) == pytest.approx(0.5 * len(shapes))
    for x, v, error, corners in kept:
        for dx, dv in states_of(corners, 8, 4):
            for side in (-1.0, 1.0):
                at_x, at_v = x + dx + side * 0.999 * error, v + dv + side * 0.999 * error * sqrt(loop.beta)
                assert any(
                    min(p[7 : 7 + 2 * int(p[COUNT]) : 2]) - p[ERROR] - 1e-12 <= at_x - p[X]
                    and at_x - p[X] <= max(p[7 : 7 + 2 * int(p[COUNT]) : 2]) + p[ERROR] + 1e-12
                    and min(p[8 : 7 + 2 * int(p[COUNT]) : 2]) - p[ERROR] * sqrt(loop.beta) - 1e-12 <= at_v - p[V]
                    and at_v - p[V] <= max(p[8 : 7 + 2 * int(p[COUNT]) : 2]) + p[ERROR] * sqrt(loop.beta) + 1e-12
                    for p in found
                )


def test_a_polygon_alone_in_its_cell_goes_on_as_it_is(room: PolygonRoom) -> None:
    """Only what is merged grows."""
    from .loops import knob

    corners = [-0.1, 0.0, 0.1, -0.02, 0.05, 0.03]
    before = zeros(POLYGON)
    put(before, 0, Centre(3.0, 0.2, 1e-9, -1.0, 5.0, 0.0), corners, 3)
    assert keep(room, Centre(3.0, 0.2, 1e-9, -1.0, 5.0, 0.5), corners, 3, 1.0, knob())
    assert release(room, 0, knob()) == 1
    before[WEIGHT] = 0.5
    assert room.stack[:POLYGON] == before


def test_what_a_search_cut_short_leaves_in_the_lattice_is_forgotten(room: PolygonRoom) -> None:
    """Else a polygon of the next search joins a cell that is never released, and its starts are lost."""
    from hknob_cli.engine.sets.box import fill_box, fill_polygon

    from .loops import knob

    loop, square = knob(), [-0.1, -0.1, 0.1, -0.1, 0.1, 0.1, -0.1, 0.1]
    for fill in (lambda: fill_box(-1.0, 1.0, -1.0, 1.0, room, loop), lambda: fill_polygon(square, 4, room, loop)):
        assert keep(room, Centre(0.3, 0.2, 0.0, 0.0, 1.0, 0.5), square, 4, 1.0, loop)
        fill()
        assert not any(room.used)
        assert keep(room, Centre(0.3, 0.2, 0.0, 0.0, 1.0, 0.5), square, 4, 1.0, loop)
        assert release(room, 0, loop) == 1
        assert room.stack[WEIGHT] == 0.5
