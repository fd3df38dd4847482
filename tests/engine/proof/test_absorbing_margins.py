"""The region that every motion comes into, with what moves a region written down: what makes it one, to a bit."""

from fractions import Fraction
from math import inf, nextafter, sqrt
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.loop import Loop, drive_of, level_of, make_loop
from hknob_cli.engine.sets import absorbing
from hknob_cli.engine.sets.absorbing import MOST_SAMPLES, Limits, Region, RegionFinder, pushes, states_in
from hknob_cli.engine.sets.polygon import CORNERS
from hknob_cli.engine.sets.region import enclose, ranges_of, simplify
from hknob_cli.engine.sets.room import make_region_room
from tests.engine.sets.test_region import exact, holds, hull

from .rooms import zeros

LOOP = make_loop(0.338, 0.0844, 0.5696, 0.344, 1.0, 0.3, 0.0)
NOTHING = (0.0,) * 6


class Script:
    """Regions that shrink as told: ``(corners, samples, farthest)`` of each slice; then all halves at once."""

    def __init__(self, *slices: tuple[int, int, float], areas: tuple[float, ...] = (1.0, 1.0), left: int = 5) -> None:
        self.slices, self.areas, self.left = list(slices), list(areas), left
        self.ranges = (-3.0, 5.0, -2.0, 4.0)
        self.squares: list[float] = []
        self.shrunk: list[Any] = []
        self.grown: list[tuple[int, float, float]] = []

    def function(self, name: str) -> Any:
        return getattr(self, name)

    def fill_square(self, region: Any, radius: float, loop: Loop) -> int:
        self.squares.append(radius)
        return 4

    def shrink(
        self, region: Any, count: int, most: int, goal: Any, limits: Any, back: bool, room: Any, loop: Loop
    ) -> tuple[int, int, float]:
        self.shrunk.append((count, *goal, limits, back, loop))
        self.most = most
        return self.slices.pop(0) if self.slices else (6, min(10, goal.samples), goal.target)

    def area_of(self, region: Any, count: int) -> float:
        return self.areas.pop(0)

    def ranges_of(self, region: Any, count: int) -> tuple[float, float, float, float]:
        return self.ranges

    def enclose(self, region: Any, count: int, dx: float, dv: float, chain: Any, out: Any) -> int:
        self.grown.append((count, dx, dv))
        return count + 4

    def simplify(self, out: Any, count: int, most: int, areas: Any) -> int:
        assert (count, most) == (self.grown[-1][0] + 4, CORNERS)
        out[: 2 * self.left] = [float(k) for k in range(2 * self.left)]
        return self.left

    def find(self, way: str = "find", *, loop: Loop = LOOP, limits: Limits | None = None, **more: Any) -> Region | None:
        finder = RegionFinder(self.function, make_region_room(zeros), lambda: False)
        found: Region | None = getattr(finder, way)(loop, limits or pushes(loop), **more)
        return found


def test_a_region_is_one_where_all_within_its_size_come_within_half_of_it() -> None:
    """Under every push and none; eight times as large where they do not."""
    for far, tried in ((0.5, 1), (nextafter(0.5, 0.0), 1), (nextafter(0.5, 1.0), 2), (0.75, 2), (1.0, 2), (inf, 2)):
        plain = Script()
        plain.find()
        radius = plain.squares[1]
        script = Script((4, 10, 0.5), (4, 104, far * radius))
        assert script.find() is not None
        assert script.squares == [1.0, radius, 8.0 * radius][: tried + 1]
        for k in range(tried):
            count, _, target, ceiling, _, back, loop = script.shrunk[1 + k]
            size = 8.0**k * radius
            assert (count, target, ceiling, back, loop) == (4, 0.5 * size, 1e6 * size, False, LOOP)


def test_no_size_is_tried_for_ever() -> None:
    script = Script((4, 10, 0.5), *[(4, 80, inf)] * 100)
    assert script.find() is None
    assert len(script.squares) == 1 + absorbing.TRIES
    assert script.grown == []


def test_a_loop_that_does_not_come_in_without_a_push_has_none() -> None:
    for far, found in ((0.5, True), (nextafter(0.5, 1.0), False), (2e6, False), (inf, False)):
        script = Script(*[(4, MOST_SAMPLES, far)] * 1)
        assert (script.find() is not None) is found
        assert script.shrunk[0][2:6] == (0.5, 1e6, NOTHING, False)
        assert len(script.shrunk) == 1 or found
    for nothing in ("alpha", "beta"):
        script = Script()
        assert script.find(loop=LOOP._replace(**{nothing: 0.0})) is None
        assert script.shrunk == []


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("gamma", [0.344, -3.0, -0.7])
def test_far_out_any_push_between_all_of_them_and_none_may_act(sense: float, gamma: float) -> None:
    """With the wall from 0 on; the region that has halved is moved on with the pushes as they are."""
    loop = LOOP._replace(gamma=gamma, sense=sense)
    edge, outside, _, low, high, _ = pushes(loop)
    script = Script(areas=(1.0, 0.5, 0.5))
    script.find(loop=loop)
    least, most = min(0.0, outside, low), max(0.0, outside, high)
    assert [one[4] for one in script.shrunk] == [
        NOTHING, (0.0, least, most, least, most, 0.0), *[(edge, outside, outside, low, high, 0.0)] * 2,
    ]  # fmt: skip
    assert [one[2:4] for one in script.shrunk[2:]] == [(0.0, inf)] * 2
    assert [one[0] for one in script.shrunk] == [4, 4, 6, 6]
    assert not any(one[5] for one in script.shrunk)
    assert {one[6] for one in script.shrunk} == {loop}


def test_a_limited_torque_is_any_push_between_two() -> None:
    for least, most in ((-0.2, 0.5), (0.1, 0.5), (-0.5, -0.1)):
        script = Script()
        script.find(limits=Limits(0.0, least, most, least, most, 0.0))
        low, high = min(0.0, least), max(0.0, most)
        assert [one[4] for one in script.shrunk] == [
            NOTHING, (0.0, low, high, low, high, 0.0), (0.0, least, most, least, most, 0.0),
        ]  # fmt: skip
        assert not any(one[5] for one in script.shrunk)


def test_growth_is_the_same_backward() -> None:
    script = Script()
    script.find("find_growth")
    edge, outside, _, low, high, _ = pushes(LOOP)
    assert script.shrunk[2][4] == (edge, outside, outside, low, high, 0.0)
    assert all(one[5] for one in script.shrunk)


def test_a_region_that_gets_lost_is_none() -> None:
    """No corners: not known. It is asked no further."""
    for ways in ("find", "find_growth"):
        script = Script((4, 10, 0.5), (4, 10, 0.0), (0, 3, inf))
        assert script.find(ways) is None
        assert len(script.shrunk) == 3
        assert script.grown == []


def test_a_region_is_moved_on_while_it_becomes_smaller() -> None:
    """By a twentieth of its area at least; until it is small."""
    for areas, moved in (
        ((1.0, 0.95), 1), ((1.0, nextafter(0.95, 0.0), 1.0), 2), ((1.0, 1.0), 1), ((1.0, 0.9, 0.8, 0.7, 0.7), 4),
    ):  # fmt: skip
        script = Script(areas=areas)
        found = script.find()
        assert found is not None
        assert len(script.shrunk) == 2 + moved
        stride = script.shrunk[2][1]
        assert stride == max(8, -int(-1.0 // (0.5 * LOOP.alpha)))
        assert found == Region(tuple(float(k) for k in range(10)), 10 + moved * min(10, stride))
        assert script.grown == [(6, 64.0 * 6 * EPSILON * 5.0, 64.0 * 6 * EPSILON * 4.0)]
    for wide, fast, moved in ((0.02, 0.0, 1), (0.0, 0.0, 0), (0.009, 0.0, 0), (0.0, 0.009, 0), (0.0, 0.011, 1)):
        script = Script()
        script.ranges = (1.0 - wide, 1.0, 2.0 - fast * sqrt(LOOP.beta), 2.0)
        script.find()
        assert len(script.shrunk) == 2 + moved


@pytest.mark.parametrize("left", [0, 2, 3, CORNERS, CORNERS + 1])
def test_a_region_of_too_few_corners_or_too_many_is_its_rectangle(left: int) -> None:
    script = Script(left=left)
    script.ranges = (-1.0, 5.0, -2.0, 4.0)
    found = script.find()
    assert found is not None
    if 3 <= left <= CORNERS:
        assert found.corners == tuple(float(k) for k in range(2 * left))
    else:
        assert found.corners == (-1.0, -2.0, 5.0, -2.0, 5.0, 4.0, -1.0, 4.0)
        assert found.ranges == script.ranges


@pytest.mark.parametrize(
    ("ranges", "far", "fast"), [((-7.0, 5.0, -2.0, 4.0), 7.0, 4.0), ((1.0, 5.0, -9.0, 4.0), 5.0, 9.0)]
)
def test_a_region_is_grown_by_the_rounding_of_its_last_hull(
    ranges: tuple[float, float, float, float], far: float, fast: float
) -> None:
    script = Script()
    script.ranges = ranges
    script.find()
    assert script.grown == [(6, 64.0 * 6 * EPSILON * far, 64.0 * 6 * EPSILON * fast)]


class Drawn(Script):
    """A region of random corners, with its last hull as it is."""

    def __init__(self, corners: np.ndarray) -> None:
        super().__init__((4, 10, 0.0), (4, 10, 0.0))
        self.corners = corners

    def shrink(self, region: Any, count: int, *rest: Any) -> tuple[int, int, float]:
        region[: self.corners.size] = self.corners.ravel()
        super().shrink(region, count, *rest)
        return len(self.corners), 10, 0.0

    def enclose(self, *given: Any) -> Any:
        return enclose(*given)

    def simplify(self, *given: Any) -> Any:
        return simplify(*given)

    def ranges_of(self, region: Any, count: int) -> tuple[float, float, float, float]:
        return ranges_of(region, count)


@pytest.mark.parametrize("seed", range(12))
def test_a_region_holds_all_that_it_is_made_from(seed: int) -> None:
    """In fractions: corners on an ellipse, many almost on one line, wherever it lies and however flat it is."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(3, 128))))
    shape = np.array([[1.0, rng.normal()], [0.0, 10.0 ** rng.uniform(-6.0, 0.0)]])
    corners = np.column_stack([np.cos(angle), np.sin(angle)]) @ shape * 10.0 ** rng.uniform(0.0, 4.0) + rng.normal(2)
    found = Drawn(corners).find()
    assert found is not None
    around = exact(list(found.corners), len(found.corners) // 2)
    assert all(holds(around, corner) for corner in exact(corners.ravel().tolist(), len(corners)))


def test_slices_go_on_from_each_other() -> None:
    """Until there, or too far out, or out of samples."""
    script = Script((5, 4096, 0.9), (7, 100, 0.8), (8, 50, 0.4))
    finder = RegionFinder(script.function, make_region_room(zeros), lambda: False)
    assert finder._shrink(4, 32, 8000, 0.5, 1e6, NOTHING, LOOP) == (8, 4246, 0.4)
    assert [one[:2] for one in script.shrunk] == [(4, 4096), (5, 3904), (7, 3804)]
    for far, slices in ((0.5, 1), (1e6, 1), (inf, 1), (nextafter(0.5, 1.0), 2), (nextafter(1e6, 0.0), 2)):
        script = Script((5, 10, far), (5, 10, 0.1))
        finder = RegionFinder(script.function, make_region_room(zeros), lambda: False)
        finder._shrink(4, 32, 9000, 0.5, 1e6, NOTHING, LOOP)
        assert len(script.shrunk) == slices
    script = Script((5, 10, 0.9))
    finder = RegionFinder(script.function, make_region_room(zeros), lambda: False)
    assert finder._shrink(4, 32, 10, 0.5, 1e6, NOTHING, LOOP) == (5, 10, 0.9)
    lost = Script((0, 3, inf))
    finder = RegionFinder(lost.function, make_region_room(zeros), lambda: False)
    assert finder._shrink(4, 32, 10, 0.0, inf, NOTHING, LOOP) == (0, 3, inf)
    assert finder._shrink(4, 32, 0, 0.5, 1e6, NOTHING, LOOP) == (4, 0, inf)


def test_no_more_samples_than_there_are() -> None:
    """Of a region that would become smaller for ever."""
    script = Script((4, 10, 0.5), (4, MOST_SAMPLES, 0.0))
    assert script.find() is not None
    assert len(script.shrunk) == 2


# How long one is looked for, and in how much room.


@pytest.mark.parametrize(
    ("alpha", "corners", "samples", "stride"),
    [(2e-5, 128, 400_000, 100_000), (0.02, 55, 6464, 100), (0.25, 32, 576, 8), (0.2, 32, 704, 10)],
)
def test_the_slower_a_loop_the_longer_it_is_looked_at(alpha: float, corners: int, samples: int, stride: int) -> None:
    """Corners go by the third root of the rate, between 32 and 128; samples are those of 64 time constants."""
    loop = make_loop(alpha, 4.0, 0.5, 0.1, 1.0, 0.0, 0.0)  # it rings: its rate is half of alpha
    script = Script(*[(4, 4096, 0.9)] * (samples // 4096), (4, samples % 4096, 0.9))
    assert script.find(loop=loop) is None
    assert sum(min(4096, one[1]) for one in script.shrunk) == samples
    script = Script()
    script.find(loop=loop)
    assert script.most == corners
    assert script.shrunk[2][1] == min(4096, stride)


def test_the_first_size_is_that_of_all_pushes_while_a_motion_halves() -> None:
    for gamma, sense in ((0.344, 1.0), (-3.0, 1.0), (-3.0, -1.0), (9.0, -1.0)):
        loop = LOOP._replace(gamma=gamma, sense=sense)
        _, outside, _, low, high, _ = pushes(loop)
        largest = max(-min(0.0, outside, low), max(0.0, outside, high))
        script = Script((4, 12, 0.5))
        script.find(loop=loop)
        step = loop.g2 + loop.s2 / sqrt(loop.beta)
        assert script.squares == [1.0, pytest.approx(8.0 * 12 * largest * step, rel=1e-12)]
        script = Script((4, 12, 0.5), (4, 100, 1e9))
        script.find(loop=loop)
        assert script.shrunk[1][1] == 4 * 12 + 64
    free = make_loop(0.3, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0)
    script = Script()
    script.find(loop=free)
    assert script.squares[1] == 0.01


class Timed(Script):
    """It is 9 s in ``now`` while the slice after ``late`` others is made, and 0 s in each other."""

    def __init__(self, now: list[float], late: int) -> None:
        super().__init__(areas=(1.0, 0.9, 0.8, 0.8))
        self.now, self.late = now, late

    def shrink(self, *given: Any) -> tuple[int, int, float]:
        self.now[0] = 9.0 if len(self.shrunk) == self.late else 0.0
        return super().shrink(*given)


def test_no_time_is_no_region(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that is there by then is moved on no more."""
    now = [0.0]
    monkeypatch.setattr(absorbing, "monotonic", lambda: now[0])
    late = Script()
    now[0] = 5.0
    assert late.find(until=5.0) is None
    assert late.shrunk == []
    for at, slices in ((1, 2), (2, 3), (99, 5)):
        script = Timed(now, at)
        now[0] = 0.0
        assert (script.find(until=5.0) is not None) is (at >= 1)
        assert len(script.shrunk) == slices


# Pushes, and states of a region.


def test_the_pushes_are_all_that_rounding_adds() -> None:
    """A wall that knows the angle, and a push within the bounds, is the wall with its encoder."""
    for sense in (1.0, -1.0):
        for offset in (0.0, 0.4):
            loop = make_loop(0.3, 0.08, 0.5, 0.2, sense, offset, 0.0)
            edge, outside, _, low, high, _ = pushes(loop)
            inside = np.append(np.linspace(edge - 5.0, edge, 4001)[:-1], [np.nextafter(edge, -9.0)])
            beside = [drive_of(level_of(x, sense), loop) + loop.kappa * x for x in inside]
            assert low - 1e-12 <= min(beside) < low + 2e-3
            assert high - 2e-3 < max(beside) <= high + 1e-12
            assert drive_of(level_of(edge + 1e-9, sense), loop) == outside
            assert drive_of(level_of(edge - 1e-9, sense), loop) != outside or offset == 0.0


def test_a_torque_that_is_not_quite_that_of_the_count_widens_the_pushes_inside() -> None:
    loop = make_loop(0.3, 0.08, 0.5, 0.2, 1.0, 0.4, 0.0)
    edge, least, most, low, high, outside = pushes(loop)
    assert pushes(loop, slack=0.25) == (edge, least, most, low - 0.25, high + 0.25, outside)


def test_random_states_of_a_region_fill_it_evenly() -> None:
    """All lie in it, and half of them in the half of it."""
    corners = (1.0, 3.0, 5.0, 3.0, 5.0, 4.0, 3.0, 5.0, 1.0, 4.0)
    states = np.array(states_in(corners, 4000)).reshape(-1, 2)
    around = hull(exact(list(corners), 5))
    assert all(holds(around, (Fraction(x), Fraction(v))) for x, v in states[:200].tolist())
    assert np.mean(states[:, 0] < 3.0) == pytest.approx(0.5, abs=0.04)
    assert np.mean(states[:, 1] < 4.0) == pytest.approx(4.0 / 6.0, abs=0.04)
    assert Region(corners, 0).ranges == (1.0, 5.0, 3.0, 5.0)
    back = [value for k in range(4, -1, -1) for value in corners[2 * k : 2 * k + 2]]
    turned = np.array(states_in(back, 4000)).reshape(-1, 2)
    assert np.mean(turned[:, 0] < 3.0) == pytest.approx(0.5, abs=0.04)
    small = np.array(states_in([0.01 * value for value in corners], 4000)).reshape(-1, 2)
    np.testing.assert_allclose(small, 0.01 * states, rtol=1e-12)
    assert states_in([2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 3) == [2.0, 3.0] * 3  # a line has no area
