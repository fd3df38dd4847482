"""Polygons of states: cutting, halving and moving lose none of them, and parts of an area add up."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.spatial import ConvexHull

from hknob_cli.controllers.sets.polygons import CORNERS, Plants, Polygons, clip, halved

Array = NDArray[np.float64]
SAME = 1e-12  # of coordinates of about 1, after some ten operations


def random_polygons(chance: np.random.Generator, some: int, points: int = 9) -> tuple[Array, NDArray[np.int64]]:
    """Convex hulls of random points."""
    corners, count = np.zeros((some, CORNERS, 2)), np.zeros(some, dtype=np.int64)
    for i in range(some):
        cloud = chance.normal(size=(points, 2))
        hull = cloud[ConvexHull(cloud).vertices]
        corners[i, : len(hull)], count[i] = hull, len(hull)
    return corners, count


def inside(corners: Array, point: Array) -> bool:
    """Whether a convex polygon, its corners in either order, holds a point."""
    to = np.roll(corners, -1, axis=0) - corners
    off = point - corners
    cross = to[:, 0] * off[:, 1] - to[:, 1] * off[:, 0]
    return bool((cross >= -SAME).all() or (cross <= SAME).all())


def within(chance: np.random.Generator, corners: Array) -> Array:
    """A random state of a polygon."""
    weight = chance.dirichlet(np.full(len(corners), 0.5))
    return np.asarray(weight @ corners)


def polygons_of(corners: Array, count: NDArray[np.int64], alpha: float, beta: float) -> Polygons:
    some = len(count)
    plants = Plants(np.array([alpha]), np.array([beta]))
    zero = np.zeros(some, dtype=np.int64)
    return Polygons(plants, zero, corners, count, zero, np.ones(some))


def test_clipping_keeps_what_lies_above_the_limit_and_nothing_else() -> None:
    """Along any direction, at limits that pass through corners too."""
    chance = np.random.default_rng(1)
    corners, count = random_polygons(chance, 300)
    direction = chance.normal(size=(300, 2))
    places = np.einsum("ikj,ij->ik", corners, direction)
    limit = np.where(chance.random(300) < 0.2, places[:, 0], chance.normal(size=300))
    kept, left = clip(corners, count, places, limit)
    cut = 0
    for i in range(300):
        cut += 0 < left[i] != count[i]
        assert left[i] <= count[i] + 1
        assert (kept[i, : left[i]] @ direction[i] >= limit[i] - SAME).all()
        for _ in range(20):
            state = within(chance, corners[i, : count[i]])
            if state @ direction[i] >= limit[i]:
                assert inside(kept[i, : left[i]], state)
    assert cut > 50


def test_a_polygon_with_too_many_corners_is_halved_without_loss() -> None:
    """Each of its states is in one of the halves, which have fewer corners."""
    chance = np.random.default_rng(2)
    turns = np.linspace(0.0, 2.0 * np.pi, CORNERS + 1, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)[None]
    corners, count, back = halved(ring.copy(), np.array([CORNERS + 1]))
    assert back.tolist() == [0, 0]
    assert (count <= CORNERS).all()
    for _ in range(200):
        state = within(chance, ring[0])
        assert any(inside(one[:n], state) for one, n in zip(corners, count, strict=True))


@pytest.mark.parametrize(("alpha", "beta"), [(0.16, 0.018), (1.6, 1.8), (0.002, 3e-5)])
def test_cutting_after_any_time_loses_no_state(alpha: float, beta: float) -> None:
    """Between edges a count apart, at a sample and within an interval; the parts of the area add up to all of it."""
    chance = np.random.default_rng(3)
    corners, count = random_polygons(chance, 100)
    polygons = polygons_of(3.0 * corners, count, alpha, beta)
    for _ in range(7):
        polygons.advance()
    plant = np.array([[0.0, 1.0], [-beta, -alpha]])
    for after in (0.0, 0.3):
        every = np.arange(100)
        low, high = polygons.extent(every, after)
        edges = np.floor(low.min()) + np.arange(int(high.max() - low.min()) + 3)
        sets = np.repeat(every, len(edges))
        least = np.tile(edges, 100)
        of, parts = polygons.cut(sets, after, least, least + 1.0)
        for one in range(0, 100, 7):
            whole = polygons.now(np.array([one]))[0][: count[one]]
            mine = np.flatnonzero(of == one)
            assert parts.weight[mine].sum() == pytest.approx(1.0, abs=1e-9)
            for _ in range(10):
                state = within(chance, whole)
                place = (expm(plant * after) @ state)[0]
                assert any(
                    inside(parts.corners[k][: parts.count[k]], state)
                    and polygons.extent(every, after)[0][one] - SAME <= place
                    for k in mine
                )


@pytest.mark.parametrize(("alpha", "beta"), [(0.16, 0.018), (1.6, 1.8), (0.002, 3e-5)])
def test_corners_move_as_free_motions_and_the_radius_bounds_them(alpha: float, beta: float) -> None:
    """Against a matrix exponential, to the blur that is stated; told from new centres they are where they were."""
    chance = np.random.default_rng(4)
    corners, count = random_polygons(chance, 20)
    polygons, every = polygons_of(corners.copy(), count, alpha, beta), np.arange(20)
    first = polygons.radius(every)
    for _ in range(60):
        polygons.advance()
    over = expm(60.0 * np.array([[0.0, 1.0], [-beta, -alpha]]))
    norm = np.array([1.0, beta**-0.5])
    blur, radius, now = polygons.blur(every), polygons.radius(every), polygons.now(every)
    shift = np.stack(polygons.recentre(every), axis=1)
    for i in range(20):
        theirs = corners[i, : count[i]] @ over.T
        assert (np.linalg.norm((now[i, : count[i]] - theirs) * norm, axis=1) <= blur[i] + 1e-13).all()
        assert (np.linalg.norm(theirs * norm, axis=1) <= radius[i]).all()
        again = polygons.corners[i, : count[i]] + shift[i]
        assert again == pytest.approx(now[i, : count[i]], rel=0.0, abs=4e-16 * abs(now[i]).max())
    assert (radius <= first * (1.0 + 1e-12)).all()
