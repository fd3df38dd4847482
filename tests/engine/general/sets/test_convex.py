"""Tests of `engine.general.sets.convex`: nothing is lost when a polygon is cut, widened or made simpler."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.sets.convex import (
    MOST_CORNERS,
    drop_edge,
    hull,
    keep_side,
    radius_of,
    recentre,
    widen,
)
from tests.engine.sets.loops import zeros
from tests.engine.sets.test_polygon import convex, states_of

from .test_friction_step import inside_of, shapes

quick = settings(deadline=None, max_examples=60)


def area_of(corners: list[float]) -> float:
    """Of a polygon with its corners counterclockwise."""
    c = np.array(corners).reshape(-1, 2)
    return float(0.5 * np.sum(c[:, 0] * np.roll(c[:, 1], -1) - c[:, 1] * np.roll(c[:, 0], -1)))


@quick
@given(corners=shapes(), a=st.floats(-1, 1), b=st.floats(-1, 1), c=st.floats(-0.5, 0.5), seed=st.integers(0, 99))
def test_both_sides_of_a_line_hold_all(corners: list[float], a: float, b: float, c: float, seed: int) -> None:
    """Each state lies in the part on its side, and no part has more than one corner more."""
    count = len(corners) // 2
    size = max(1e-300, radius_of(corners, count, 1.0))
    sides = []
    for sign in (1.0, -1.0):
        out = zeros(2 * count + 4)
        kept = keep_side(corners, count, sign * a, sign * b, sign * c * size, out)
        assert kept <= count + 1
        assert all(
            sign * (a * x + b * v - c * size) >= -1e-9 * size
            for x, v in zip(out[: 2 * kept : 2], out[1 : 2 * kept : 2], strict=True)
        )
        sides.append(out[: 2 * kept])
    for x, v in states_of(corners, 8, seed):
        side = sides[0] if a * x + b * v >= c * size else sides[1]
        assert side
        assert inside_of(x, v, side, 1e-9 * size)


def test_a_line_that_crosses_more_than_twice_by_rounding_leaves_the_whole() -> None:
    """Along the upper side of a flat polygon, whose middle corner is a rounding too low."""
    flat = [0.0, 0.0, 4.0, 0.0, 4.0, 1.0, 3.0, 1.0 - 2e-16, 2.0, 1.0, 1.0, 1.0 - 2e-16, 0.0, 1.0]
    out = zeros(2 * 8)
    for sign in (1.0, -1.0):
        assert keep_side(flat, 7, 0.0, sign, sign * (1.0 - 1e-16), out) == 7
        assert out[:14] == flat
    assert keep_side(flat, 7, 0.0, 1.0, 0.5, out) == 7  # and with two crossings, what is above
    assert min(out[1:14:2]) == 0.5


@quick
@given(corners=shapes(), more=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), seed=st.integers(0, 99))
def test_a_wider_polygon_holds_every_state_with_what_is_added(
    corners: list[float], more: tuple[float, float], seed: int
) -> None:
    """And keeps few corners."""
    count = len(corners) // 2
    size = radius_of(corners, count, 1.0) + sum(more)
    assume(size > 1e-100)  # below, the products of the test itself underflow
    work = corners + zeros(8 * count + 8)
    kept = widen(work, count, *more, zeros(8 * count + 8))
    assert kept <= MOST_CORNERS
    chance = np.random.default_rng(seed)
    for x, v in states_of(corners, 8, seed):
        dx, dv = chance.uniform(-1.0, 1.0, 2) * more
        assert inside_of(x + dx, v + dv, work[: 2 * kept], 1e-12 * size)


def test_a_square_grows_by_what_is_added() -> None:
    """A rectangle of known sides."""
    work = [-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, *zeros(40)]
    kept = widen(work, 4, 0.5, 0.25, zeros(40))
    assert kept == 4
    assert area_of(work[:8]) == pytest.approx(3.0 * 2.5)


def test_a_point_and_a_standing_segment_stay_what_they_are() -> None:
    """Widened along the positions alone, neither gets a velocity."""
    work = [0.0] * 20
    assert widen(work, 1, 0.5, 0.0, zeros(20)) == 2
    assert sorted(work[:4:2]) == [-0.5, 0.5]
    assert work[1:4:2] == [0.0, 0.0]
    work = [-1.0, 0.0, 1.0, 0.0, *zeros(20)]
    assert widen(work, 2, 0.25, 0.0, zeros(20)) == 2
    assert sorted(work[:4:2]) == [-1.25, 1.25]


def test_an_edge_fewer_adds_the_least_area() -> None:
    """A square with one corner cut off is the square again."""
    work = [-1.0, -1.0, 1.0, -1.0, 1.0, 0.9, 0.9, 1.0, -1.0, 1.0]
    assert drop_edge(work, 5) == 4
    assert area_of(work[:8]) == pytest.approx(4.0)


@quick
@given(seed=st.integers(0, 999), count=st.integers(5, 20))
def test_a_simpler_polygon_holds_the_old_one(seed: int, count: int) -> None:
    """With one corner fewer, or as a rectangle."""
    angles = np.sort(np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count))
    corners = convex(np.column_stack([np.cos(angles), 0.1 * np.sin(angles)]))
    work, given_count = list(corners), len(corners) // 2
    if given_count < 5:
        return
    kept = drop_edge(work, given_count)
    assert kept == given_count - 1 or kept == 4
    for x, v in states_of(corners, 8, seed):
        assert inside_of(x, v, work[: 2 * kept], 1e-10)


@quick
@given(seed=st.integers(0, 999))
def test_the_hull_is_that_of_scipy(seed: int) -> None:
    """The same area, and counterclockwise."""
    points = np.random.default_rng(seed).normal(size=(12, 2))
    out = zeros(30)
    kept = hull(points.ravel().tolist(), 12, out)
    assert area_of(out[: 2 * kept]) == pytest.approx(abs(area_of(convex(points))))
    assert area_of(out[: 2 * kept]) > 0.0


def test_the_middle_of_the_rectangle_is_the_centre() -> None:
    """And where it has moved is told."""
    work = [0.0, 0.0, 2.0, 0.0, 2.0, 1.0]
    assert recentre(work, 3) == (1.0, 0.5)
    assert work == [-1.0, -0.5, 1.0, -0.5, 1.0, 0.5]
