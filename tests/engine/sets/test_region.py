"""Tests of `engine.sets.region` and `engine.sets.absorbing`: no state is lost, and every motion comes in, or grows.

States are moved at 60 digits and compared in exact arithmetic, so that a bound on rounding that is too small is found.
"""

from fractions import Fraction
from itertools import pairwise
from math import cos, pi, sin, sqrt

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.attractors import StoppedError
from hknob_cli.engine.loop import Loop, interval, level_of, make_loop
from hknob_cli.engine.sets import region as regions
from hknob_cli.engine.sets.absorbing import Limits, RegionFinder, pushes
from hknob_cli.engine.sets.region import (
    advance,
    area_of,
    enclose,
    farthest,
    fill_square,
    ranges_of,
    simplify,
    trace_back,
)
from hknob_cli.engine.sets.room import RegionRoom, make_region_room

from .loops import knob, zeros

Point = tuple[Fraction, Fraction]
small = settings(deadline=None, max_examples=60)
mp = mpmath.mp.clone()
mp.dps = 60


@pytest.fixture(scope="module")
def room() -> RegionRoom:
    """Work space of the interpreter."""
    return make_region_room(zeros)


def finder() -> RegionFinder:
    """In the interpreter."""
    return RegionFinder(lambda name: getattr(regions, name), make_region_room(zeros), lambda: False)


def exact(flat: list[float], count: int) -> list[Point]:
    return [(Fraction(float(flat[2 * k])), Fraction(float(flat[2 * k + 1]))) for k in range(count)]


def side(a: Point, b: Point, p: Point) -> Fraction:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def hull(points: list[Point]) -> list[Point]:
    """Convex hull, exactly (Andrew's method, in fractions)."""
    points = sorted(set(points))
    halves = []
    for some in (points, points[::-1]):
        half: list[Point] = []
        for p in some:
            while len(half) > 1 and side(half[-2], half[-1], p) <= 0:
                half.pop()
            half.append(p)
        halves += half[:-1]
    return halves


def holds(corners: list[Point], p: Point) -> bool:
    """Whether a convex polygon, in order, holds a point."""
    return all(side(a, b, p) >= 0 for a, b in pairwise([*corners, corners[0]]))


def next_state(loop: Loop, x: float, v: float, *, level: float | None = None) -> Point:
    """State one sample later at 60 digits, as a fraction."""
    level = level_of(x, loop.sense) if level is None else level
    alpha, beta = mp.mpf(loop.alpha), mp.mpf(loop.beta)
    drive = -mp.mpf(loop.gamma) - (mp.mpf(loop.kappa) * (mp.mpf(level) + mp.mpf(loop.offset)) if level < 0 else 0)
    moved = mp.expm(mp.matrix([[0, 1, 0], [-beta, -alpha, 1], [0, 0, 0]])) * mp.matrix([mp.mpf(x), mp.mpf(v), drive])
    return tuple(Fraction(int(mp.floor(value * 2**150)), 2**150) for value in moved[:2])  # type: ignore[return-value]


points = st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-3.0, 3.0)), min_size=1, max_size=25)


@small
@given(some=points, grown=st.sampled_from([(0.0, 0.0), (1e-9, 1e-6), (0.5, 0.25)]))
def test_a_hull_holds_its_points_with_the_rectangle(
    room: RegionRoom, some: list[tuple[float, float]], grown: tuple[float, float]
) -> None:
    """Every corner of the rectangle around every point, except for the rounding that the docstring states."""
    flat = [value for point in some for value in point]
    out = zeros(200)
    count = enclose(list(flat), len(some), *grown, room.chain, out)
    assert count <= len(some) + 4
    slack = 16 * len(some) * 2.3e-16
    around = hull([(x + sx, v + sv) for x, v in exact(out, count) for sx, sv in corners_of(9 * slack, 3 * slack)])
    for x, v in exact(flat, len(some)):
        for sx, sv in corners_of(*grown):
            assert len(around) > 2
            assert holds(around, (x + sx, v + sv))


def corners_of(dx: float, dv: float) -> list[Point]:
    return [(Fraction(sx * dx), Fraction(sv * dv)) for sx in (-1, 1) for sv in (-1, 1)]


@small
@given(sides=st.integers(5, 60), most=st.integers(4, 20), flat=st.floats(1e-3, 1.0), seed=st.integers(0, 99))
def test_fewer_corners_hold_more(room: RegionRoom, sides: int, most: int, flat: float, seed: int) -> None:
    """The simpler polygon holds the other one, and its sides are as few as asked for."""
    turns = np.sort(np.random.default_rng(seed).uniform(0, 2 * pi, sides))
    given_points = [value for t in turns for value in (cos(t), flat * sin(t))]
    out = zeros(200)
    before = enclose(list(given_points), sides, 0.0, 0.0, room.chain, out)
    area = area_of(out, before)
    after = simplify(out, before, most, zeros(100))
    assert after <= max(most, 4)
    assert area_of(out, after) >= area
    around = hull(exact(out, after))
    grown = hull([(x + sx, v + sv) for x, v in around for sx, sv in corners_of(1e-14, 1e-14)])
    assert all(holds(grown, p) for p in exact(given_points, sides))


some_loops = st.builds(
    lambda alpha, beta, kappa, gamma, sense, offset: make_loop(alpha, beta, kappa, gamma, sense, offset, 0.0),
    alpha=st.floats(1e-3, 3.0),
    beta=st.floats(1e-5, 20.0),
    kappa=st.sampled_from([0.0, 0.01, 0.7, 30.0]),
    gamma=st.floats(0.0, 5.0),
    sense=st.sampled_from([1.0, -1.0]),
    offset=st.sampled_from([0.0, 0.3]),
)


def triangle(seed: int, size: float, at: float) -> list[float]:
    chance = np.random.default_rng(seed)
    return (chance.uniform(-size, size, 6) + np.array([at, 0.0] * 3)).tolist()


@small
@given(
    loop=some_loops, seed=st.integers(0, 10**6), size=st.sampled_from([1e-3, 2.0, 1e6]), at=st.sampled_from([0, -1, 50])
)
def test_no_state_leaves_the_region_in_a_sample(
    room: RegionRoom, loop: Loop, seed: int, size: float, at: float
) -> None:
    """At 60 digits: corners of the region and states in it, those at count edges among them, with either reading."""
    limits = pushes(loop)
    flat = triangle(seed, size, at)
    region = zeros(4096)
    region[:6] = flat
    count = advance(region, 3, 32, limits, room, loop)
    around = hull(exact(region, count))
    corners = [(flat[0], flat[1]), (flat[2], flat[3]), (flat[4], flat[5])]
    for x, v in corners:
        assert holds(around, next_state(loop, x, v))
    # On every whole number along a side, the state may be read as either level.
    for (ax, av), (bx, bv) in pairwise([*corners, corners[0]]):
        whole = float(round((ax + bx) / 2))
        if not min(ax, bx) < whole < max(ax, bx):
            continue
        v = av + (whole - ax) / (bx - ax) * (bv - av)
        inner = 1e-9 * size
        middle = sum(p[1] for p in corners) / 3
        v += inner if middle > v else -inner
        if holds(hull(exact(flat, 3)), (Fraction(whole), Fraction(v))):
            assert holds(around, next_state(loop, whole, v))
            assert holds(around, next_state(loop, whole, v, level=level_of(np.nextafter(whole, -1e9), loop.sense)))


@small
@given(loop=some_loops, seed=st.integers(0, 10**6), size=st.sampled_from([0.5, 20.0]))
def test_no_state_that_comes_into_a_region_is_left_out_of_where_it_was(
    room: RegionRoom, loop: Loop, seed: int, size: float
) -> None:
    """Backward: the region around where states go holds, one sample earlier, the states."""
    limits = pushes(loop)
    chance = np.random.default_rng(seed)
    states = [(x, v) for x, v in chance.uniform(-size, size, (8, 2)).tolist()]
    after = [next_state(loop, x, v) for x, v in states]
    region, flat = zeros(4096), [float(value) for point in after for value in point]
    wide = max(abs(value) for value in flat)
    slack = 1.2e-16 * wide  # what a state loses by becoming a double
    count = enclose(flat, 8, slack, slack, room.chain, region)
    count = trace_back(region, count, 32, limits, room, loop)
    if count == 0:
        spring = loop.beta + loop.kappa
        assert abs(loop.f2 * (1.0 - loop.g2 * spring) + loop.s2**2 * spring) < 1e-5 * (1.0 + spring)
        return
    around = hull(exact(region, count))
    for x, v in states:
        assert holds(around, (Fraction(x), Fraction(v)))


@small
@given(loop=some_loops, spring=st.floats(0.0, 0.5), seed=st.integers(0, 10**6), size=st.sampled_from([0.5, 20.0, 1e6]))
def test_a_spring_outside_pulls_as_the_wall_does_inside(
    room: RegionRoom, loop: Loop, spring: float, seed: int, size: float
) -> None:
    """States on both sides of the edge, under either push: where they go, and where they came from."""
    limits = Limits(0.0, -0.2, 0.3, -0.4, 0.1, spring)
    flat = triangle(seed, size, 0.0)
    corners = list(zip(flat[::2], flat[1::2], strict=True))
    weights = np.random.default_rng(seed).dirichlet(np.ones(3), 20)
    states = [tuple(float(one) for one in weight @ np.array(corners)) for weight in weights]
    after = []
    for x, v in states:
        stiffness, pushed = (spring, limits[1:3]) if x >= 0.0 else (loop.kappa, limits[3:5])
        after += [interval(x, v, 0.0, push - stiffness * x, loop) for push in pushed]
    region = zeros(4096)
    region[:6] = flat
    count = advance(region, 3, 32, limits, room, loop)
    around = hull(exact(region, count))
    assert all(holds(around, (Fraction(x), Fraction(v))) for x, v in after)
    cloud, slack = [float(one) for state in after for one in state], 1e-15 * size
    count = enclose(cloud, len(after), slack, slack, room.chain, region)
    count = trace_back(region, count, 32, limits, room, loop)
    if count:
        around = hull(exact(region, count))
        assert all(holds(around, (Fraction(x), Fraction(v))) for x, v in states)


def test_every_motion_comes_into_the_region() -> None:
    """From a thousand times as far, and a million times."""
    for loop in (knob(), knob(-1.0), knob(1.0, 0.3), make_loop(2.5, 0.1, 0.5, 0.3, 1.0, 0.0, 0.0)):
        found = finder().find(loop, pushes(loop))
        assert found is not None
        low_x, high_x, low_v, high_v = found.ranges
        assert high_x - low_x < 20.0
        corners = hull(
            [(Fraction(x), Fraction(v)) for x, v in zip(found.corners[::2], found.corners[1::2], strict=True)]
        )
        for seed in range(20):
            chance = np.random.default_rng(seed)
            x, v = chance.uniform(-1.0, 1.0, 2) * 10.0 ** chance.uniform(0.0, 6.0) * [high_x - low_x, high_v - low_v]
            for _ in range(400):
                if holds(corners, (Fraction(float(x)), Fraction(float(v)))):
                    break
                x, v = interval(x, v, 0.0, drive(x, loop), loop)
            else:
                pytest.fail(f"{seed} of {loop} did not come into {found}")


def drive(x: float, loop: Loop) -> float:
    from hknob_cli.engine.loop import drive_of

    return drive_of(level_of(x, loop.sense), loop)


@pytest.mark.long
def test_a_wall_too_stiff_for_its_rate_throws_every_motion_farther() -> None:
    """No region takes them in; from beyond the other region all that is tried grows."""
    loop = make_loop(0.00321, 0.00345, 0.219, 0.1, 1.0, 0.0, 0.0)
    assert finder().find(loop, pushes(loop)) is None
    found = finder().find_growth(loop, pushes(loop))
    assert found is not None
    low_x, high_x, low_v, high_v = found.ranges
    for seed in range(30):
        turn = 2 * pi * seed / 30
        x, v = 2.0 * max(-low_x, high_x) * cos(turn), 2.0 * max(-low_v, high_v) * sin(turn)
        if low_x <= x <= high_x and low_v <= v <= high_v:
            continue
        first = sqrt(x * x + v * v / loop.beta)
        for _ in range(6000):
            x, v = interval(x, v, 0.0, drive(x, loop), loop)
        assert sqrt(x * x + v * v / loop.beta) > 100.0 * first


def test_a_motion_that_all_come_to_does_not_grow() -> None:
    """The same loop has one region or the other, never both."""
    assert finder().find_growth(knob(), pushes(knob())) is None


def test_without_a_wall_the_region_is_the_rest_point() -> None:
    """Pushed against the hand's spring alone."""
    loop = make_loop(0.3, 0.1, 0.0, 0.05, 1.0, 0.0, 0.0)
    found = finder().find(loop, pushes(loop))
    assert found is not None
    low_x, high_x, low_v, high_v = found.ranges
    assert low_x < -0.5 < high_x
    assert low_v < 0.0 < high_v
    assert high_x - low_x < 0.02


def test_a_limited_torque_holds_every_motion() -> None:
    """Any push between two bounds, the worst for the angle and for the speed among them, and motions from far away."""
    loop = knob()._replace(kappa=0.0)
    found = finder().find(loop, Limits(0.0, -0.2, 0.5, -0.2, 0.5))
    assert found is not None
    around = hull(exact(list(found.corners), len(found.corners) // 2))
    chance = np.random.default_rng(4)
    for seed in range(40):
        x, v = chance.uniform(-1e4, 1e4, 2)
        came = False
        for _ in range(300):
            came = came or holds(around, (Fraction(float(x)), Fraction(float(v))))
            push = (0.5 if v > 0 else -0.2) if seed % 2 else float(chance.choice([-0.2, 0.5]))
            x, v = interval(x, v, 0.0, push, loop)
        assert came
    # At rest under either push, and no larger than the response to the worst of pushes.
    for push in (-0.2, 0.5):
        assert holds(around, (Fraction(push / loop.beta), Fraction(0)))
    gain = sum(abs(one) for one in free_positions(loop, 400))
    low_x, high_x, _, _ = found.ranges
    assert high_x - low_x < 1.1 * 0.7 * gain


def free_positions(loop: Loop, samples: int) -> list[float]:
    """Positions after a push of 1 for one sample."""
    x, v = interval(0.0, 0.0, 0.0, 1.0, loop)
    positions = []
    for _ in range(samples):
        positions.append(x)
        x, v = interval(x, v, 0.0, 0.0, loop)
    return positions


def test_no_time_and_an_interruption() -> None:
    """None before any time; told to stop, it stops."""
    assert finder().find(knob(), pushes(knob()), until=0.0) is None
    with pytest.raises(StoppedError):
        RegionFinder(lambda name: getattr(regions, name), make_region_room(zeros), lambda: True).find(
            knob(), pushes(knob())
        )


def test_measures_of_a_region() -> None:
    """The square in the norm, its area, its ranges and its farthest corner."""
    square = zeros(8)
    assert fill_square(square, 3.0, knob()) == 4
    high = 3.0 * sqrt(knob().beta)
    assert ranges_of(square, 4) == (-3.0, 3.0, -high, high)
    assert area_of(square, 4) == pytest.approx(12.0 * high)
    assert farthest(square, 4, knob()) == pytest.approx(3.0 * sqrt(2.0))
