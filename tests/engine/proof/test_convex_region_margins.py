"""Regions moved by a sample on their margins: corners and roundings of small whole numbers, against exact ones."""

from fractions import Fraction
from itertools import pairwise, product
from math import inf, nextafter, sqrt
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.loop import Loop, interval, make_loop
from hknob_cli.engine.sets import region as regions
from hknob_cli.engine.sets.absorbing import Limits
from hknob_cli.engine.sets.region import (
    Goal,
    advance,
    area_of,
    drop_side,
    enclose,
    farthest,
    fill_square,
    ranges_of,
    shrink,
    simplify,
    simplify_hull,
    sort_points,
    trace_back,
    turn,
)
from hknob_cli.engine.sets.room import make_region_room

from .rooms import zeros

Corner = tuple[float, float]
UNIT = 2.0**-12  # of a rounding, here
LOOP = make_loop(0.338, 0.0844, 0.5696, 0.344, 1.0, 0.3, 0.0)
LIMITS = Limits(-1.0, 0.25, 0.5, -0.75, 1.5)
OTHERS = [
    Limits(-1.0, 0.25, 0.25, -9.0, 0.5), Limits(0.0, -0.5, -0.5, -0.5, -0.5), Limits(0.0, -9.0, 0.5, -1.0, 1.0),
    Limits(0.0, -1.0, 9.0, -1.0, 1.0), Limits(0.0, -1.0, 1.0, -1.0, 9.0), LIMITS._replace(outside=0.25),
    LIMITS._replace(outside=0.75),
]  # fmt: skip
NOTHING = Limits(0.0, 0.0, 0.0, 0.0, 0.0)


def side(a: Corner, b: Corner, p: Corner) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def hull(points: list[Corner]) -> list[Corner]:
    """Corners of the convex hull, from the lowest of the leftmost on, to the left."""
    points, halves = sorted(set(points)), []
    for some in (points, points[::-1]):
        half: list[Corner] = []
        for p in some:
            while len(half) > 1 and side(half[-2], half[-1], p) <= 0:
                half.pop()
            half.append(p)
        halves += half[:-1]
    return halves or points


def flat(points: list[Corner]) -> list[float]:
    return [float(value) for point in points for value in point]


def corners(out: list[float], count: int) -> list[Corner]:
    return [(out[2 * k], out[2 * k + 1]) for k in range(count)]


def some_points(seed: int) -> list[Corner]:
    numbers = np.random.default_rng(seed)
    size = int(numbers.integers(1, 7))
    drawn = numbers.integers(-size, size + 1, (int(numbers.integers(1, 16)), 2))
    return [(float(x), float(v)) for x, v in drawn]


# Hulls.


@pytest.mark.parametrize("seed", range(60))
def test_points_are_sorted_and_enclosed_exactly(seed: int) -> None:
    """Of whole numbers nothing is rounded. The hull begins at its lowest leftmost corner; grown, it is that of the
    rectangles around the points, and has four corners more at most."""
    points = some_points(seed)
    given, out = flat(points), zeros(200)
    sort_points(given, len(points))
    assert corners(given, len(points)) == sorted(points)
    plain = enclose(flat(points), len(points), 0.0, 0.0, zeros(100), out)
    assert corners(out, plain) == hull(points) * (2 if len(set(points)) == 1 else 1)
    for dx, dv in ((0.5, 0.25), (2.0**-20, 3.0)):
        count = enclose(flat(points), len(points), dx, dv, zeros(100), out)
        around = hull([(x + sx * dx, v + sv * dv) for x, v in points for sx, sv in product((-1, 1), repeat=2)])
        found = corners(out, count)
        assert hull(found) == around
        assert count <= plain + 4
        assert area_of(out, count) == sum(side(around[0], a, b) for a, b in pairwise(around)) / 2  # in order
        assert {turn(out, k, (k + 1) % count, *found[(k + 2) % count]) >= 0.0 for k in range(count)} == {True}


def test_a_turn_is_twice_an_area() -> None:
    points = flat([(1.0, 2.0), (4.0, 3.0)])
    assert turn(points, 0, 1, 2.0, 7.0) == side((1.0, 2.0), (4.0, 3.0), (2.0, 7.0)) == 14.0
    assert turn(points, 1, 0, 2.0, 7.0) == -14.0
    assert turn(points, 0, 1, 7.0, 4.0) == 0.0


# Fewer corners.

BLUNT = [(0.0, 0.0), (4.0, 0.0), (5.0, 1.0), (5.0, 4.0), (2.0, 6.0), (0.0, 4.0)]


def meeting(points: list[Corner], k: int) -> tuple[float, float, float]:
    """Where the sides beside side k meet, a billionth farther along, exactly."""
    n = len(points)
    a, b, c, d = ([Fraction(x) for x in points[(k + j) % n]] for j in (-1, 0, 1, 2))
    u, w = [b[0] - a[0], b[1] - a[1]], [c[0] - d[0], c[1] - d[1]]
    across = u[0] * w[1] - u[1] * w[0]
    if across >= 0:
        return inf, 0.0, 0.0
    along = ((c[0] - b[0]) * w[1] - (c[1] - b[1]) * w[0]) / across * (1 + Fraction(1, 10**9))
    x, v = b[0] + along * u[0], b[1] + along * u[1]
    return float(abs((c[0] - b[0]) * (v - b[1]) - (c[1] - b[1]) * (x - b[0]))), float(x), float(v)


@pytest.mark.parametrize("turns", range(4))
def test_a_side_is_dropped_where_its_neighbours_meet(turns: int) -> None:
    """In every direction, and from every corner on."""
    points = BLUNT
    for _ in range(turns):
        points = [(-v, x) for x, v in points]
    for by in range(6):
        some = points[by:] + points[:by]
        for k in range(6):
            found = drop_side(flat(some), 6, k)
            assert found == pytest.approx(meeting(some, k), rel=1e-14, abs=1e-14)
            assert (found[0] == inf) is (meeting(some, k)[0] == inf)
    shifted = [(x + 7.0, v - 11.0) for x, v in points]
    for k in range(6):
        assert drop_side(flat(shifted), 6, k) == pytest.approx(meeting(shifted, k), rel=1e-13, abs=1e-13)


def test_a_side_between_others_that_do_not_meet_stays() -> None:
    """Of a rectangle; where they meet a million times as far as the side before is long; where it is rounded."""
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    for k in range(4):
        assert drop_side(flat(square), 4, k) == (inf, 0.0, 0.0)
    for far, drops in (
        (1e6, False),
        (nextafter(1e6, 0.0), True),
        (0.0, True),
        (-1e-9, False),
        (-1.0, False),
        (2.0, True),
    ):
        # The side before ends at 0, and is 1 long; the line through (0, 1) and (-far, 2) meets it at far.
        leaning = [(-1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (-far, 2.0)]
        area, x, v = drop_side(flat(leaning), 4, 1)
        assert (area < inf) is drops
        assert (x, v) == (pytest.approx(far if drops else 0.0, rel=2e-9), 0.0)
    # Where rounding has put the corner that it makes so that the far one lies outside: next to none is added.
    for some in (
        [-6.577813818518708, -8.348275742581885, -8.600715558165422, -7.9096175343756485, -8.273842775727623,
         -9.45724565074665, -7.541549864663124, -12.924396051371527],
        [-2.008474532987592, -3.071813105342607, -2.855652166476087, -4.455452803553442, -0.9426267953738114,
         -4.939352899243452, 2.644822503860256, -5.846798814705706],
    ):  # fmt: skip
        assert drop_side(some, 4, 1) == (inf, 0.0, 0.0)
    # Backward along the side before: not a convex polygon, and nothing that rounding may make of one is dropped.
    dent = [(0.0, 0.0), (2.0, 0.0), (1.0, -1.0), (3.0, -2.0)]
    assert drop_side(flat(dent), 4, 1) == (inf, 0.0, 0.0)


def naive(points: list[Corner], most: int) -> list[Corner]:
    """All areas anew for each side that is dropped."""
    points = list(points)
    while len(points) > most:
        found = [drop_side(flat(points), len(points), k) for k in range(len(points))]
        at = min(range(len(points)), key=lambda k: found[k][0])
        if found[at][0] == inf:
            break
        points[at] = found[at][1:]
        del points[(at + 1) % len(points)]
    return points


@pytest.mark.parametrize("seed", range(30))
def test_the_side_that_adds_least_goes_first(seed: int) -> None:
    numbers = np.random.default_rng(seed)
    count = int(numbers.integers(5, 14))
    angles = np.sort(numbers.uniform(0.0, 2.0 * np.pi, count))
    points = [(float(3.0 * np.cos(t) + 1.0), float(np.sin(t) - 2.0)) for t in angles]
    for most in (3, 4, 6, 20):
        out = flat(points)
        left = simplify(out, count, most, zeros(50))
        expected = naive(points, most)
        assert set(corners(out, left)) == set(expected)
        assert left == len(expected)
        if count > most > 3:
            assert area_of(out, left) > area_of(flat(points), count)
        hulled, out = flat(points), zeros(100)
        assert simplify_hull(hulled, count, most, zeros(50), out) == len(naive(hull(points), most))
        assert set(corners(out, left)) == set(naive(hull(points), most))


@pytest.mark.parametrize("by", range(12))
def test_what_a_side_would_add_is_known_of_the_corners_that_are_left(by: int) -> None:
    """Whichever side is the first: one whose area is out of date might be dropped where it cannot be."""
    numbers = np.random.default_rng(7)
    for _ in range(4):
        angles = np.roll(np.sort(numbers.uniform(0.0, 2.0 * np.pi, 12)), by)
        points = [(float(3.0 * np.cos(t) + 1.0), float(np.sin(t) - 2.0)) for t in angles]
        for most in (11, 10, 7):
            out, areas = flat(points), zeros(12)
            assert simplify(out, 12, most, areas) == most
            assert areas[:most] == [drop_side(out, most, k)[0] for k in range(most)]


def test_sides_that_cannot_be_dropped_stay() -> None:
    square = flat([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    assert simplify(square, 4, 3, zeros(8)) == 4


# A sample on, and back.


class Caught(Exception):
    """What `enclose` is given at the end."""


def caught(
    monkeypatch: pytest.MonkeyPatch, points: list[Corner], loop: Loop, limits: Limits, *, back: bool, unit: float = UNIT
) -> Any:
    """Points that the next region is to hold, how far it is to be grown, and the most corners asked for."""
    room, kept = make_region_room(zeros), {}
    room.region[: 2 * len(points)] = flat(points)
    real = regions.enclose

    def simplified(cloud: Any, count: int, most: int, chain: Any, out: Any) -> int:
        kept["points"], kept["most"] = corners(cloud, count), most
        out[: 2 * count] = cloud[: 2 * count]
        return count

    def last(some: Any, count: int, dx: float, dv: float, chain: Any, out: Any) -> int:
        if "points" not in kept:
            return int(real(some, count, dx, dv, chain, out))
        kept["grown"] = (dx, dv)
        assert corners(some, count) == kept["points"]
        assert out is room.region
        return 77

    with monkeypatch.context() as patch:
        patch.setattr(regions, "EPSILON", unit)
        patch.setattr(regions, "simplify_hull", simplified)
        patch.setattr(regions, "enclose", last)
        count = (trace_back if back else advance)(room.region, len(points), 9, limits, room, loop)
    return count, kept.get("points"), kept.get("grown"), kept.get("most")


SHAPES = [
    [(-3.0, 0.5), (-2.0, -1.0), (1.0, -0.5), (2.0, 1.5)],
    [(-9.0, -4.0), (-8.0, -4.5), (-7.0, 6.0)],
    [(0.5, 0.0), (5.0, -1.0), (4.0, 2.0)],
    [(-0.25, 0.5), (0.125, -4.0), (0.5, 1.0)],
]


@pytest.mark.parametrize("limits", [LIMITS, *OTHERS, NOTHING])
@pytest.mark.parametrize("shape", range(4))
def test_each_part_of_a_region_moves_under_both_ends_of_its_pushes(
    monkeypatch: pytest.MonkeyPatch, shape: int, limits: Limits
) -> None:
    """What is as near to the wall's edge as 64 roundings a corner, of all places, goes both ways."""
    points = SHAPES[shape]
    count, found, grown, most = caught(monkeypatch, points, LOOP, limits, back=False)
    assert (count, most) == (77, 9)
    far, fast = max(abs(limits[0]), *(abs(x) for x, _ in points)), max(abs(v) for _, v in points)
    reach = 64.0 * UNIT * len(points) * far
    expected = []
    for sign, stiffness, pushes in ((1.0, limits.outside, limits[1:3]), (-1.0, LOOP.kappa, limits[3:5])):
        cut = limits[0] - sign * reach
        part: list[Corner] = []
        for a, b in pairwise([*points, points[0]]):
            if sign * (a[0] - cut) >= 0.0:
                part.append(a)
            if (sign * (a[0] - cut) >= 0.0) != (sign * (b[0] - cut) >= 0.0):
                part.append((cut, a[1] + (cut - a[0]) / (b[0] - a[0]) * (b[1] - a[1])))
        expected += [interval(x, v, 0.0, push - stiffness * x, LOOP) for x, v in part for push in sorted(set(pushes))]
    assert np.array(found) == pytest.approx(np.array(expected), rel=1e-13, abs=1e-13)
    pull = max(abs(one) for one in limits[1:5]) + (max(LOOP.kappa, limits.outside) + LOOP.beta) * far
    next_far, next_fast = (max(abs(one[k]) for one in expected) for k in (0, 1))
    both = 48.0 * (fast + pull)
    assert grown == pytest.approx(
        (
            UNIT * (8.0 * far + both + 64.0 * len(expected) * next_far),
            UNIT * (both + 64.0 * len(expected) * next_fast),
        ),
        rel=1e-13,
    )


@pytest.mark.parametrize("limits", [LIMITS, *OTHERS])
@pytest.mark.parametrize("shape", range(4))
def test_a_region_is_found_back_by_the_inverse_of_either_part(
    monkeypatch: pytest.MonkeyPatch, shape: int, limits: Limits
) -> None:
    """Of all corners under both ends of the pushes; then it is cut, and grown by what the inverse may be wrong by."""
    signs = set()
    for alpha, beta, kappa in (
        (0.338, 0.0844, 0.5696),
        (0.3, 2.0, 0.9),
        (0.3, 5.0, 3.0),
        (0.3, 20.0, 1.0),
        (1.0, 40.0, 200.0),
    ):
        loop, points = make_loop(alpha, beta, kappa, 0.1, 1.0, 0.0, 0.0), SHAPES[shape]
        count, found, grown, most = caught(monkeypatch, points, loop, limits, back=True)
        g, s, f = loop.g2, loop.s2, loop.f2
        push = max(abs(one) for one in limits[1:5])
        far = max(abs(x) for x, _ in points) + abs(g) * push
        fast = max(abs(v) for _, v in points) + abs(s) * push
        expected: list[Corner] = []
        errors = []
        springs = loop.beta + limits.outside, loop.beta + loop.kappa
        for sign, spring, pushes in ((1.0, springs[0], limits[1:3]), (-1.0, springs[1], limits[3:5])):
            matrix = np.array([[1.0 - g * spring, s], [-s * spring, f]])
            before = [
                tuple((np.linalg.inv(matrix) @ [x - g * push, v - s * push]).tolist())
                for x, v in points
                for push in pushes
            ]
            det = np.linalg.det(matrix)
            signs |= {("s", s > 0.0), ("f", f > 0.0), ("det", det > 0.0)}
            size = abs(f) * (1.0 + g * spring) + s * s * spring
            lost = 64.0 * UNIT * (1.0 + size / abs(det)) / abs(det)
            errors.append(
                (lost * (abs(f) * far + abs(s) * fast), lost * (abs(s) * spring * far + (1.0 + g * spring) * fast))
            )
            wide = max(abs(x) for x, _ in before)
            reach = errors[-1][0] + 64.0 * UNIT * len(before) * (wide + abs(limits[0]))
            cut, around = limits[0] - sign * reach, hull(before)
            for a, b in pairwise([*around, around[0]]):
                if sign * (a[0] - cut) >= 0.0:
                    expected.append(a)
                if (sign * (a[0] - cut) >= 0.0) != (sign * (b[0] - cut) >= 0.0):
                    expected.append((cut, a[1] + (cut - a[0]) / (b[0] - a[0]) * (b[1] - a[1])))
        assert (count, most) == ((77, 9) if expected else (0, None))
        if not expected:
            continue
        assert np.array(sorted(found)) == pytest.approx(np.array(sorted(expected)), rel=1e-9, abs=1e-9)
        for k in range(2):
            size = max(abs(one[k]) for one in expected)
            error = max(one[k] for one in errors) + 64.0 * UNIT * len(expected) * size
            assert grown[k] == pytest.approx(2.0 * error, rel=1e-9)
    assert len(signs) == 6


def test_a_map_that_can_hardly_be_inverted_is_not() -> None:
    """A millionth of the size of its determinant's terms decides, on either side of the wall's edge."""
    room = make_region_room(zeros)
    for kappa, part, f in product((0.0, 1.0), (0.999e-6, 1.001e-6), (0.5, 64.0)):
        # f (1 - g spring) + s s spring, with s = 0: a part of f (1 + g spring).
        g = (1.0 - part) / (1.0 + part) / (0.5 + kappa)
        room.region[:8] = flat(SHAPES[0])
        loop = LOOP._replace(beta=0.5, kappa=kappa, s2=0.0, f2=f, g2=g)
        count = trace_back(room.region, 4, 9, NOTHING, room, loop)
        assert count > 0 if part > 1e-6 else count == 0


def test_where_no_state_comes_from_nothing_is_known() -> None:
    """Without the wall it would have been inside, and with it outside."""
    room = make_region_room(zeros)
    room.region[:6] = flat([(-7.0, 6.0), (-6.99, 6.0), (-7.0, 6.01)])
    assert trace_back(room.region, 3, 9, NOTHING, room, make_loop(1.0, 40.0, 200.0, 0.1, 1.0, 0.0, 0.0)) == 0


# Many samples.


def test_a_region_moves_on_until_it_is_within_or_beyond(monkeypatch: pytest.MonkeyPatch) -> None:
    room = make_region_room(zeros)
    for back in (False, True):
        for sizes, samples, expected in (
            ([0.9, 0.8, 0.5], 9, (2, 0.5)), ([0.9, nextafter(0.5, 1.0), 0.4], 9, (2, 0.4)), ([0.5], 9, (0, 0.5)),
            ([4.0], 9, (0, 4.0)), ([0.9, 4.0], 9, (1, 4.0)), ([0.9, 3.9, 0.8, 0.7], 3, (3, 0.7)), ([0.9], 0, (0, 0.9)),
        ):  # fmt: skip
            left, calls = list(sizes), []

            def move(region: Any, count: int, *_: Any, calls: Any = calls) -> int:
                calls.append(count)
                return count + 1

            with monkeypatch.context() as patch:
                patch.setattr(regions, "farthest", lambda *_, left=left: left.pop(0))
                patch.setattr(regions, "trace_back" if back else "advance", move)
                patch.setattr(regions, "advance" if back else "trace_back", None)
                count, used, far = shrink(room.region, 4, 9, Goal(samples, 0.5, 4.0), LIMITS, back, room, LOOP)
            assert (count, used, far) == (4 + expected[0], *expected)
            assert calls == list(range(4, 4 + expected[0]))
    with monkeypatch.context() as patch:
        patch.setattr(regions, "farthest", lambda *_: 1.0)
        patch.setattr(regions, "trace_back", lambda *_: 0)
        assert shrink(room.region, 4, 9, Goal(9, 0.5, 4.0), LIMITS, True, room, LOOP) == (0, 0, inf)


def test_sizes_of_a_region() -> None:
    four = [(3.0, -1.0), (4.0, 2.0), (-5.0, 3.0), (-2.0, -7.0)]
    for by in range(4):
        some = flat(four[by:] + four[:by])
        assert ranges_of(some, 4) == (-5.0, 4.0, -7.0, 3.0)
        sizes = [sqrt(x * x + v * v / LOOP.beta) for x, v in corners(some, 4)]
        assert farthest(some, 4, LOOP) == pytest.approx(max(sizes), rel=1e-14)
    assert farthest([0.25, 0.0], 1, LOOP) == pytest.approx(0.25, rel=1e-14)
    out, high = zeros(10), 3.0 * sqrt(LOOP.beta)
    assert fill_square(out, 3.0, LOOP) == 4
    assert corners(out, 5) == [(-3.0, -high), (3.0, -high), (3.0, high), (-3.0, high), (0.0, 0.0)]
    assert farthest(some[:2], 1, LOOP) == pytest.approx(sizes[0], rel=1e-14)
    three = flat([(1.0, 1.0), (4.0, 2.0), (3.0, 5.0)])
    assert area_of(three, 3) == 5.0
    assert area_of(flat(BLUNT), 6) == 24.5
    assert area_of(flat(BLUNT[::-1]), 6) == 24.5
