"""The proof of a cycle on its margins: an affine map of known matrix stands in for the motion over a period."""

from collections.abc import Callable
from itertools import product
from math import inf, nextafter, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general import orbit_proof, period_map, powers
from hknob_cli.engine.general.body import Body, distance, norm, stiffness
from hknob_cli.engine.general.cogging import far_apart, far_around
from hknob_cli.engine.general.columns import TURN_ROOM
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS, certify
from hknob_cli.engine.general.period_map import Space
from hknob_cli.engine.general.search import make_space
from tests.engine.general.bodies import fresh_marks

from .test_standstill_margins import FINGER, LAGGING, WALL, body

CONTINUOUS = WALL._replace(analog=1.0)
QUICK = np.array([[0.3, 0.4], [-0.2, 0.1]])
PLACE = np.array([-2.5, 0.25])


class Stage(NamedTuple):
    """What the motion over a period is made to be: w -> matrix (w - place) + place + off, with these margins."""

    matrix: np.ndarray
    place: np.ndarray
    margin: float = 0.4
    edge: float = 0.3
    reach: float = 3.0
    pace: float = 0.5
    marks: tuple[float, ...] = tuple(fresh_marks())
    off: float | np.ndarray = 0.0
    turned: int = 0  # by how much the delay line has gone on
    last: float | None = None  # reading, where it is no part of the map


class Result(NamedTuple):
    """What `certify` gives, and leaves."""

    status: int
    margin: float
    edge: float
    closure: float
    bound: float
    space: Space
    seen: list[list[float]]  # where each turn began
    scales: list[float]
    asked: list[tuple[list[float], list[float]]]  # `away` and `power` as `within` gets them
    residual: np.ndarray  # of the last turn


def prove(
    monkeypatch: pytest.MonkeyPatch,
    stage: Stage,
    z: np.ndarray | list[float],
    one: Body,
    wall: Controller = WALL,
    *,
    before: float = -3.0,
    ring: tuple[float, ...] = (),
    head: int = 0,
    period: int = 4,
    near: bool = True,
) -> Result:
    n, delay = one.order, len(ring)
    space = make_space(n, delay, lambda count: [7.0] * count)
    width = space.width
    seen: list[list[float]] = []
    scales: list[float] = []
    residual: list[float] = []
    asked: list[tuple[list[float], list[float]]] = []

    def turn(start: float, line: Any, at: int, samples: int, _: Body, __: Controller, room: Space, m: int) -> Any:
        assert (at, samples, m) == (head, period, width if wall.analog else n)
        w = np.array([*room.orbit, *room.orbit_line, start])
        seen.append(w.tolist())
        out = w.copy()
        residual.clear()
        out[:m] = stage.matrix @ (w - stage.place)[:m] + stage.place[:m] + stage.off
        for c in range(m):
            for i in range(m):
                room.cols[c * width + i] = float(stage.matrix[i, c])
        residual.extend((out - w)[:m].tolist())
        room.state[:] = out[:n].tolist()
        if wall.analog:
            room.line[:] = out[n : n + delay].tolist()
        else:
            for j in range(delay):
                room.line[(head + stage.turned + j) % delay] = room.orbit_line[(head + j) % delay]
        room.marks[:] = list(stage.marks)
        last = float(out[-1]) if wall.analog else (start if stage.last is None else stage.last)
        return stage.margin, stage.edge, stage.reach, stage.pace, last, (head + stage.turned) % max(1, delay)

    def within(start: float, line: Any, at: int, samples: int, _: Body, __: Controller, room: Space, m: int) -> Any:
        assert start == room.reading[0]
        asked.append((list(room.away), list(room.power[:m])))
        return near, 0.125

    true = orbit_proof.dissipates

    def dissipates(cols: Any, stride: int, power: Any, spare: Any, m: int, scale: float, samples: int) -> bool:
        assert samples == period
        scales.append(scale)
        return bool(true(cols, stride, power, spare, m, scale, samples))

    with monkeypatch.context() as patch:
        patch.setattr(period_map, "turn", turn)
        patch.setattr(orbit_proof, "within", within)
        patch.setattr(orbit_proof, "dissipates", dissipates)
        line = list(ring)
        found = certify([float(x) for x in z], before, line, head, period, one, wall, space)
    assert line == list(ring)
    return Result(*found, space, seen, scales, asked, np.array(residual))


def planar(stage: Stage | None = None, **more: Any) -> Stage:
    return (stage or Stage(QUICK, np.array([*PLACE, 0.0])))._replace(**more)


def errors(stage: Stage, residual: np.ndarray, period: int = 4) -> np.ndarray:
    """8 roundings a sample of all positions, of speeds 16 of the pace, and the residual, through the inverse."""
    m = len(stage.matrix)
    sizes = np.array([stage.reach + stage.pace if j % 2 == 0 else 2.0 * stage.pace for j in range(m)])
    inverse = np.linalg.inv(np.eye(m) - stage.matrix)
    return np.asarray(np.abs(inverse) @ (np.abs(residual) + 8.0 * EPSILON * period * sizes))


def most_of(measure: Callable[[list[float], Body], float], sizes: np.ndarray | list[float], one: Body) -> float:
    """The largest of all differences whose numbers have these sizes, with one sign or the other."""
    return max(
        measure([sign * float(size) for sign, size in zip(signs, sizes, strict=True)], one)
        for signs in product((1.0, -1.0), repeat=len(sizes))
    )


def errors_of(stage: Stage, one: Body) -> np.ndarray:
    """As `errors`, without a residual; a lag's number is no speed."""
    m = len(stage.matrix)
    slow = [j % 2 == 1 and not (one.lag > 0.0 and j == m - 1) for j in range(m)]
    sizes = np.array([2.0 * stage.pace if one else stage.reach + stage.pace for one in slow])
    return np.asarray(np.abs(np.linalg.inv(np.eye(m) - stage.matrix)) @ (32.0 * EPSILON * sizes))


# Newton's method.


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_the_orbit_is_the_fixed_point(monkeypatch: pytest.MonkeyPatch, order: int) -> None:
    one = {2: body(), 3: LAGGING, 4: FINGER._replace(order=4, lag=0.0), 5: FINGER}[order]._replace(
        reach=1.0, friction=0.0
    )
    numbers = np.random.default_rng(order)
    matrix = 0.3 * numbers.normal(size=(order, order))
    matrix *= 0.5 / np.abs(np.linalg.eigvals(matrix)).max()
    place = np.array([*(-2.5 + 0.01 * numbers.normal(size=order)), 0.0])
    stage = Stage(matrix, place)
    z = place[:order] + 1e-3 * numbers.normal(size=order)
    found = prove(monkeypatch, stage, z, one)
    assert found.status == PROVEN
    np.testing.assert_allclose(found.space.orbit, place[:order], atol=1e-14)
    assert found.space.orbit == found.seen[-1][:order]
    assert found.space.reading == [-3.0]
    assert found.closure <= 4.0 * EPSILON * 3.5
    assert (found.margin, found.edge) == (0.4, 0.3)
    assert len(found.seen) <= 4


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_with_a_continuous_sensor_the_commands_and_the_reading_are_solved_for(
    monkeypatch: pytest.MonkeyPatch, delay: int
) -> None:
    numbers, width = np.random.default_rng(delay), 3 + delay
    matrix = numbers.normal(size=(width, width))
    matrix *= 0.5 / np.abs(np.linalg.eigvals(matrix)).max()
    place = -2.5 + 0.1 * numbers.normal(size=width)
    start = place + 1e-3 * numbers.normal(size=width)
    found = prove(
        monkeypatch,
        Stage(matrix, place),
        start[:2],
        body(),
        CONTINUOUS,
        before=float(start[-1]),
        ring=tuple(start[2:-1].tolist()),
    )
    assert found.status == PROVEN
    solved = [*found.space.orbit, *found.space.orbit_line, *found.space.reading]
    np.testing.assert_allclose(solved, place, atol=1e-13)
    assert solved == found.seen[-1]
    assert found.closure == pytest.approx(0.0, abs=1e-14)


def test_the_residual_is_that_of_the_orbit_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a map whose derivative is not the given one, so that each step takes off two thirds alone."""
    one, space, seen = body(), make_space(2, 0, lambda count: [7.0] * count), []

    def turn(start: float, _: Any, __: int, ___: int, ____: Body, _____: Controller, room: Space, m: int) -> Any:
        w = np.array(room.orbit)
        for c in range(2):
            for i in range(2):
                room.cols[c * room.width + i] = float(QUICK[i, c])
        residual = (np.eye(2) - QUICK) @ (PLACE - w) * (2.0 / 3.0)
        room.state[:] = (w + residual).tolist()
        room.marks[:] = [inf, inf]
        seen.append((w.tolist(), residual))
        return 0.4, 0.3, 3.0, 0.5, start, 0

    with monkeypatch.context() as patch:
        patch.setattr(period_map, "turn", turn)
        status, _, _, closure, bound = certify([-2.49, 0.25], -3.0, [], 0, 4, one, WALL, space)
    where, residual = seen[-1]
    assert (status, len(seen)) == (PROVEN, period_map.NEWTON_STEPS)
    assert space.orbit == where
    assert closure == pytest.approx(float(np.linalg.norm(residual)), rel=1e-9)
    assert bound >= (2.0 / 3.0) * abs(where[0] - PLACE[0])
    np.testing.assert_allclose(space.away[:2], errors(planar(), residual), rtol=1e-6)


def test_a_motion_that_does_not_close_is_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """A singular derivative ends the search at once: 1e-6 of reach and pace, 3.5, decides."""
    for off, found in (
        ((0.6, 0.8), NEUTRAL),
        ((0.9, 0.1), NEUTRAL),
        ((1.01, 0.0), DIFFERENT),
        ((0.0, 1.01), DIFFERENT),
        ((0.8, 0.8), DIFFERENT),
    ):
        stage = planar(matrix=np.eye(2), off=3.499e-6 * np.array(off))
        result = prove(monkeypatch, stage, PLACE, body())
        assert result.status == found
        if found == NEUTRAL:
            assert (result.margin, result.edge, result.bound) == (0.4, 0.3, 0.0)
            assert result.closure == pytest.approx(3.499e-6 * sqrt(off[0] ** 2 + off[1] ** 2), rel=1e-8)
            assert result.space.orbit == PLACE.tolist()
        else:
            assert result[1:5] == (0.0, 0.0, 0.0, 0.0)
        assert len(result.seen) == 1
    exactly = planar(matrix=np.eye(2), reach=0.5, pace=0.5, off=np.array([0.0, 0.0]))
    for closure, found in ((1e-6, DIFFERENT), (nextafter(1e-6, 0.0), NEUTRAL)):
        stage = exactly._replace(off=np.array([closure, 0.0]), place=np.zeros(3))
        assert prove(monkeypatch, stage, [0.0, 0.0], body()).status == found


def test_other_commands_under_way_make_another_orbit(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line is compared from its oldest command, wherever it begins; with counts no command is solved for."""
    stage = Stage(QUICK, np.array([*PLACE, 0.0, 0.0, 0.0, 0.0]))
    for turned in range(3):
        for head in range(3):
            assert (
                prove(monkeypatch, stage._replace(turned=turned), PLACE, body(), ring=(1.0, 2.0, 3.0), head=head).status
                == PROVEN
            )
    # A line that has not gone on as far as it says.
    original = period_map.turn

    def shifted(ring: tuple[float, ...], at: int, head: int) -> int:
        space = make_space(2, len(ring), lambda count: [7.0] * count)

        def turn(start: float, _: Any, __: int, ___: int, ____: Body, _____: Controller, room: Space, m: int) -> Any:
            for c in range(2):
                for i in range(2):
                    room.cols[c * room.width + i] = float(QUICK[i, c])
            room.state[:] = room.orbit[:]
            room.line[:] = room.orbit_line[:]
            room.marks[:] = [inf, inf]
            return 0.4, 0.3, 3.0, 0.5, start, at

        with monkeypatch.context() as patch:
            patch.setattr(period_map, "turn", turn)
            found = certify(PLACE.tolist(), -3.0, list(ring), head, 4, body(), WALL, space)
        if found[0] == DIFFERENT:
            assert found == (DIFFERENT, 0.0, 0.0, 0.0, 0.0)
        return int(found[0])

    assert period_map.turn is original
    for ring, at, head, status in (
        ((1.0, 2.0, 3.0), 0, 0, PROVEN),
        ((1.0, 2.0, 3.0), 2, 2, PROVEN),
        ((1.0, 2.0, 3.0), 1, 0, DIFFERENT),
        ((1.0, 2.0, 3.0), 0, 1, DIFFERENT),
        ((1.0, 1.0, 2.0), 1, 0, DIFFERENT),
        ((1.0, 2.0, 1.0, 2.0), 2, 0, PROVEN),
        ((1.0, 2.0, 1.0, 2.0), 3, 1, PROVEN),
        ((1.0, 2.0, 1.0, 2.0), 1, 0, DIFFERENT),
        ((1.0, 1.0), 1, 0, PROVEN),
    ):
        assert shifted(ring, at, head) == status


def test_a_damped_wall_must_come_back_to_its_last_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    damped = WALL._replace(damping=0.1)
    assert prove(monkeypatch, planar(last=-3.0), PLACE, body(), damped).status == PROVEN
    found = prove(monkeypatch, planar(last=-2.0), PLACE, body(), damped)
    assert found[:5] == (DIFFERENT, 0.0, 0.0, 0.0, 0.0)
    assert prove(monkeypatch, planar(last=-2.0), PLACE, body()).status == PROVEN
    assert prove(monkeypatch, planar(last=-2.0), PLACE, body(), WALL._replace(damping=1e-9)).status == DIFFERENT


# The bound.


@pytest.mark.parametrize("period", [1, 4, 30])
@pytest.mark.parametrize("pace", [0.0, 0.5, 20.0])
def test_the_bound_is_that_of_the_roundings_through_the_inverse(
    monkeypatch: pytest.MonkeyPatch, period: int, pace: float
) -> None:
    stage = planar(pace=pace)
    for beta in (0.01, 1.0, 4.0):
        one = body(beta=beta)
        found = prove(monkeypatch, stage, PLACE, one, period=period)
        away = errors(stage, found.residual, period)
        np.testing.assert_allclose(found.space.away[:2], away, rtol=1e-9)
        later = sqrt(away[0] ** 2 + away[1] ** 2 / beta)
        assert found.bound == pytest.approx(max(away[0], later), rel=1e-9)
    loose = prove(monkeypatch, stage, PLACE, body(beta=0.0, friction=1.0), period=period)  # nothing holds it
    assert loose.bound == pytest.approx(away[0], rel=1e-9)


def test_what_is_left_of_a_residual_counts_in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    """A residual that no step mends: of a map that is off wherever it begins."""
    for off in ((1e-9, 0.0), (-1e-9, 0.0), (0.0, 2e-9), (0.0, -2e-9)):
        one, space = body(), make_space(2, 0, lambda count: [7.0] * count)

        def turn(
            start: float, _: Any, __: int, ___: int, ____: Body, _____: Controller, room: Space, m: int, off: Any = off
        ) -> Any:
            for c in range(2):
                for i in range(2):
                    room.cols[c * room.width + i] = float(QUICK[i, c])
            room.state[:] = [room.orbit[0] + off[0], room.orbit[1] + off[1]]
            room.marks[:] = [inf, inf]
            return 0.4, 0.3, 3.0, 0.5, start, 0

        with monkeypatch.context() as patch:
            patch.setattr(period_map, "turn", turn)
            status, _, _, closure, bound = certify(PLACE.tolist(), -3.0, [], 0, 4, one, WALL, space)
        assert (status, closure) == (PROVEN, pytest.approx(max(abs(off[0]), abs(off[1])), rel=1e-5))
        away = errors(planar(), np.array(off))
        np.testing.assert_allclose(space.away[:2], away, rtol=1e-5)
        assert bound == pytest.approx(float(np.linalg.norm(away)), rel=1e-5)


def test_with_a_continuous_sensor_the_first_sample_is_bounded_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Later ones by the derivative: `within` says; where that is not reached, the bound is the first sample's."""
    stage = Stage(np.diag([0.5, 0.5, 0.5]), np.array([-2.5, 0.25, -2.5]), margin=1e-16)
    found = prove(monkeypatch, stage, [-2.5, 0.25], body(beta=1e-6), CONTINUOUS, before=-2.5)
    assert found.status == ON_EDGE
    assert found.bound == pytest.approx(errors(stage, found.residual)[0], rel=1e-9)


@pytest.mark.parametrize(
    ("reach", "pace", "scale"), [(3.0, 1.0, 0.25), (1.0, 0.0, 1.0), (1.0, 1e-5, 1e-3), (1.0, 0.002, 0.002 / 1.002)]
)
def test_the_unit_of_speeds_is_the_pace_of_the_orbit(
    monkeypatch: pytest.MonkeyPatch, reach: float, pace: float, scale: float
) -> None:
    found = prove(monkeypatch, planar(reach=reach, pace=pace), PLACE, body())
    assert found.scales == [pytest.approx(scale, rel=1e-15)]


def test_an_error_of_a_finger_is_bounded_whatever_its_signs(monkeypatch: pytest.MonkeyPatch) -> None:
    """An error of knob and finger may go opposite ways, and then has more energy than the sizes of its numbers say."""
    for order, lag, ratio in ((4, 0.0, 4.0), (5, 0.5, 4.0), (4, 0.0, 1.0)):
        one = FINGER._replace(order=order, lag=lag, ratio=ratio, reach=1.0, friction=0.0)
        stage = Stage(np.diag([0.5] * order), np.array([*[-2.5, 0.25, 1.0, 0.25, 1.0][:order], 0.0]), pace=3.0)
        away = errors_of(stage, one)
        for beside in ({}, {"cogs": [0.25, 8.0, -3.0, 1.0, 0.5, 0.0]}, {"cogs": [0.25, 8.0, 5.0, 1.0, 0.5, 0.0]}):
            found = prove(monkeypatch, stage, stage.place[:order], one._replace(**beside))
            assert found.status == PROVEN
            np.testing.assert_allclose(found.space.away[:order], away, rtol=1e-9)

            def far(dz: list[float], body: Body) -> float:
                return float(far_apart(body.cogs, dz, -2.5, body))

            most = most_of(far, away, one._replace(**beside))
            assert most > 1.2 * far(list(away), one._replace(**beside))
            assert found.bound == pytest.approx(most, rel=1e-9, abs=0.0)


def test_an_error_beside_cogging_is_bounded_where_springs_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the slope's spring alone, too, without a hand; on a slope that does not hold the knob at its begin alone."""
    away = errors(planar(), np.zeros(2))
    free = body(beta=0.0)._replace(reach=inf)
    stable = prove(monkeypatch, planar(), PLACE, free._replace(cogs=[0.25, 8.0, -2.5, 1.0, 0.5, 0.0]))
    assert stable.status == PROVEN
    energy = sqrt(away[1] ** 2 + 0.25 * away[0] ** 2)
    assert stable.bound == pytest.approx(max(away[0], energy / 0.5), rel=1e-9, abs=0.0)
    unstable = free._replace(cogs=[0.25, 8.0, 5.5, 1.0, 0.5, 0.0])
    at_corner = fresh_marks()
    at_corner[TURN_ROOM] = -1.0
    found = prove(monkeypatch, planar(marks=tuple(at_corner)), PLACE, unstable)
    assert found.status == PARTS
    with monkeypatch.context() as patch:
        patch.setattr(orbit_proof, "goes_over", lambda _: False)
        found = prove(monkeypatch, planar(marks=tuple(at_corner)), PLACE, unstable)
    assert found.status == PARTS
    assert found.bound == pytest.approx(away[0], rel=1e-9, abs=0.0)
    assert prove(monkeypatch, planar(), PLACE, unstable).status == PROVEN


OFF_SLOPE = [0.25, 8.0, 5.5, 1.0, 0.5, 0.0]  # cogging whose unstable slope is where the cycle is


def over_corners(
    monkeypatch: pytest.MonkeyPatch,
    room: float,
    one: Body,
    *,
    by: tuple[float, float] = (0.0, 0.0),
    wall: Controller = WALL,
    bound: float = 0.0625,
    **more: Any,
) -> tuple[Result, list[Any]]:
    """The proof of a cycle over corners where `room_over_corners` is what it is said to be; what that is asked with."""
    asked: list[Any] = []

    def stand_in(*given: Any) -> tuple[float, float, float]:
        asked.append(given)
        return room, bound, 4.0

    more = {"marks": (inf, inf, inf, -1.0)} | more
    with monkeypatch.context() as patch:
        patch.setattr(orbit_proof, "room_over_corners", stand_in)
        z, ring = PLACE + np.array(by), (0.0,) * 0
        return prove(monkeypatch, planar(**more), z, one, wall, ring=ring), asked


def test_a_cycle_over_corners_is_proven_where_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above 0, and with all that is asked about it; the trial's distance is that around such an orbit."""
    one = body(beta=0.0)._replace(reach=inf, cogs=OFF_SLOPE)
    for room, status in ((0.25, PROVEN), (2.0**-40, PROVEN), (0.0, PARTS), (-1.0, PARTS)):
        found, asked = over_corners(monkeypatch, room, one)
        assert (found.status, found.edge, len(asked)) == (status, 0.3, 1)
        if status == PROVEN:
            assert (found.margin, found.bound) == (room + 0.0625, 0.0625)
        else:
            assert found.margin == 0.4
            assert found.bound < 1e-12
        ((fast, slow, margin, late, period, body_asked, space, scale),) = asked
        assert (fast, slow) == (32.0 * EPSILON * 3.5, 32.0 * EPSILON * 1.0)
        assert (margin, late, period, body_asked, space, scale) == (0.4, 0.0, 4, one, found.space, 0.5 / 3.5)
    # On a slope that holds it, too, where it passes a corner.
    stable = one._replace(cogs=[0.25, 8.0, -2.5, 1.0, 0.5, 0.0])
    assert over_corners(monkeypatch, 0.25, stable)[0].status == PROVEN
    kept, asked = over_corners(monkeypatch, 0.25, stable, marks=(inf, inf, inf, 3.0))
    assert (kept.status, kept.margin, asked) == (PROVEN, 0.4, [])


def test_a_cycle_over_corners_is_of_some_bodies_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """And not of a continuous sensor, nor of a motion that does not contract or is at an edge."""
    one = body(beta=1.0)._replace(cogs=OFF_SLOPE)
    for changed, status in (({}, PROVEN), ({"friction": 1.0}, PROVEN), ({"play": 1.0}, PARTS)):
        marks = (inf, inf, -1.0 if "play" in changed else inf, -1.0)
        with monkeypatch.context() as patch:
            patch.setattr(orbit_proof, "flank_room_on", lambda *_: -1.0)
            found, asked = over_corners(monkeypatch, 0.25, one._replace(**changed), marks=marks)
        assert (found.status, len(asked)) == (status, status == PROVEN)
    for more, status in (({"matrix": np.eye(2) * 1.5}, DIFFERENT), ({"margin": 1e-30}, ON_EDGE)):
        found, asked = over_corners(monkeypatch, 0.25, one, **more)
        assert (found.status, asked) == (status, [])
    stage = following(np.array([[0.3, 0.9, 0.0], [-0.4, 0.2, 0.3], [1.0, 0.0, 0.0]]))._replace(
        marks=(inf, inf, inf, -1.0)
    )
    found = prove(monkeypatch, stage, stage.place[:2], one, CONTINUOUS, before=float(stage.place[-1]))
    assert found.status == PARTS


@pytest.mark.parametrize("reach", [inf, 1.0])
def test_a_trial_is_captured_within_the_room_over_corners(monkeypatch: pytest.MonkeyPatch, reach: float) -> None:
    """And where it is not, though it is as near as roundings let it come, nothing is proven of the cycle."""
    one = body(beta=0.0 if reach == inf else 1.0)._replace(reach=reach, cogs=OFF_SLOPE)
    for direction in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.6, -0.8)):
        away = far_around(OFF_SLOPE, list(direction), PLACE[0], one)
        for part, status in ((0.999, PROVEN), (1.001, NOT_CAPTURED)):
            by = (part * 0.25 / away * direction[0], part * 0.25 / away * direction[1])
            assert over_corners(monkeypatch, 0.25, one, by=by)[0].status == status
    found, _ = over_corners(monkeypatch, 1e-300, one)
    off = found.space.residual[:2]
    away = far_around(OFF_SLOPE, [abs(x) for x in off], PLACE[0], one)
    assert found.status == (PARTS if away + 0.0625 >= 1e-300 + 0.0625 else PROVEN)
    # Nothing is left beside the orbit's own error.
    for part, status in ((0.9, PARTS), (1.1, NOT_CAPTURED)):
        far = part * 1e-13 * 3.5 / far_around(OFF_SLOPE, [1.0, 0.0], PLACE[0], one)
        assert over_corners(monkeypatch, 2.0**-60, one, by=(far, 0.0), bound=0.0)[0].status == status


# What refuses a proof.


@pytest.mark.parametrize(
    "one", [body(friction=1.0), body(beta=0.25, alpha=3.0, friction=1.0)], ids=["beta 1", "beta 1/4"]
)
def test_a_standstill_within_the_error_is_not_decided(monkeypatch: pytest.MonkeyPatch, one: Body) -> None:
    """A torque that the error may change twice over, and a speed that it may turn round."""
    away = errors(planar(), np.zeros(2))
    speed = sqrt(away[1] ** 2 + one.beta * away[0] ** 2)
    torque = 2.0 * stiffness(one) * speed
    assert stiffness(one) == one.alpha + sqrt(one.beta)
    for marks, status in (
        ((1.001 * torque, 1.001 * speed), PROVEN),
        ((0.999 * torque, 1.001 * speed), AT_EVENT),
        ((1.001 * torque, 0.999 * speed), AT_EVENT),
        ((0.999 * torque, 0.999 * speed), AT_EVENT),
        ((0.0, inf), AT_EVENT),
        ((inf, 0.0), AT_EVENT),
        ((inf, inf), PROVEN),
    ):
        found = prove(monkeypatch, planar(marks=marks), PLACE, one)
        assert found.status == status
        assert found.bound == pytest.approx(max(away[0], speed / sqrt(one.beta)), rel=1e-9)
        assert prove(monkeypatch, planar(marks=marks), PLACE, one._replace(friction=0.0)).status == PROVEN
        assert prove(monkeypatch, planar(marks=marks), PLACE, one._replace(friction=1e-9)).status == status
        assert (found.margin, found.edge) == (0.4, 0.3)


def test_the_error_of_a_lag_may_still_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    one = LAGGING._replace(reach=1.0)
    matrix = np.array([[0.3, 0.4, 0.1], [-0.2, 0.1, 0.2], [0.0, 0.1, 0.2]])
    stage = Stage(matrix, np.array([-2.5, 0.25, 1.0, 0.0]))
    away = errors(stage, np.zeros(3))
    speed = sqrt(away[1] ** 2 + one.beta * away[0] ** 2) + away[2] / one.lag
    torque = 2.0 * (stiffness(one) * speed + away[2])
    for part, status in ((1.001, PROVEN), (0.999, AT_EVENT)):
        found = prove(monkeypatch, stage._replace(marks=(part * torque, inf)), [-2.5, 0.25, 1.0], one)
        assert found.status == status
        found = prove(monkeypatch, stage._replace(marks=(inf, part * speed)), [-2.5, 0.25, 1.0], one)
        assert found.status == status
    other = FINGER._replace(order=4, lag=0.0, reach=1.0, friction=1.0)  # its last entry is a speed, and is not late
    matrix = np.diag([0.5, 0.5, 0.5, 0.5])
    stage = Stage(matrix, np.array([-2.5, 0.25, 1.0, 0.25, 0.0]), pace=3.0)
    away = errors(stage, np.zeros(4))
    tip, finger = away[0] + away[2], away[1] + away[3]  # where both go opposite ways
    square = away[1] ** 2 + other.pad_stiffness * away[2] ** 2
    speed = sqrt(square + (finger**2 + other.finger_stiffness * tip**2) / other.ratio)
    assert speed == pytest.approx(most_of(norm, away, other), rel=1e-12, abs=0.0)
    for part, status in ((1.001, PROVEN), (0.999, AT_EVENT)):
        marks = (part * 2.0 * stiffness(other) * speed, inf)
        assert prove(monkeypatch, stage._replace(marks=marks), stage.place[:4], other).status == status


def test_at_the_very_limit_nothing_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    one = body(friction=1.0)
    found = prove(monkeypatch, planar(), PLACE, one)
    speed = norm(found.space.away, one)
    torque = 2.0 * (stiffness(one) * speed)
    for marks, status in (
        ((torque, inf), AT_EVENT),
        ((nextafter(torque, inf), inf), PROVEN),
        ((inf, speed), AT_EVENT),
        ((inf, nextafter(speed, inf)), PROVEN),
    ):
        assert prove(monkeypatch, planar(marks=marks), PLACE, one).status == status
    z = PLACE + np.array([0.125, 0.0])
    found = prove(monkeypatch, planar(), z, one)
    limit = distance([float(z[0]) - found.space.orbit[0], float(z[1]) - found.space.orbit[1]], one) + found.bound
    for margin, status in ((limit, NOT_CAPTURED), (nextafter(limit, 1.0), PROVEN)):
        assert prove(monkeypatch, planar(margin=margin), z, one).status == status


def test_an_orbit_at_an_edge_is_not_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    bound = prove(monkeypatch, planar(), PLACE + np.array([1e-3, 0.0]), body()).bound
    for margin, status in (
        (0.999 * bound, ON_EDGE),
        (bound, ON_EDGE),
        (0.0, ON_EDGE),
        (-1.0, ON_EDGE),
        (1.001 * bound, NOT_CAPTURED),
    ):
        found = prove(monkeypatch, planar(margin=margin), PLACE + np.array([1e-3, 0.0]), body())
        assert found.status == status
        assert found[1:3] == (margin, 0.3)
        assert found.bound == bound


def test_a_map_that_does_not_contract_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    for matrix, status in ((turn, EXPANDS), (1.5 * turn, EXPANDS), (0.99 * turn, PROVEN)):
        found = prove(monkeypatch, planar(matrix=matrix), PLACE, body())
        assert (found.status, found.margin, found.edge) == (status, 0.4, 0.3)
        assert found.bound > 0.0
    with_reading = np.zeros((3, 3))
    with_reading[:2, :2] = 1.5 * turn
    stage = Stage(with_reading, np.array([-2.5, 0.25, -2.5]))
    assert prove(monkeypatch, stage, [-2.5, 0.25], body(), CONTINUOUS, before=-2.5).status == DIFFERENT


@pytest.mark.parametrize("beta", [0.25, 4.0])
def test_a_trial_is_captured_within_the_margin(monkeypatch: pytest.MonkeyPatch, beta: float) -> None:
    one = body(beta=beta)
    for direction in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.6, -0.8)):
        size = sqrt(direction[0] ** 2 + direction[1] ** 2 / beta)
        for part, status in ((0.999, PROVEN), (1.001, NOT_CAPTURED)):
            off = np.array(direction) * part * 0.4 / size
            found = prove(monkeypatch, planar(), PLACE + off, one)
            assert (found.status, found.margin, found.edge) == (status, 0.4, 0.3)
    # The bound counts, too: of an orbit of slow decay far out.
    slow = planar(matrix=(1.0 - 1e-9) * np.eye(2), reach=3e4)
    bound = prove(monkeypatch, slow, PLACE, one).bound
    assert bound > 1e-3
    for part, status in ((0.99, PROVEN), (1.01, NOT_CAPTURED)):
        off = np.array([part * (0.4 - bound), 0.0])
        # The fixed point is known to a billionth of what the motion is off.
        assert prove(monkeypatch, slow, PLACE + off, one).status == status


# A continuous sensor: how far a difference can grow.


def following(matrix: np.ndarray) -> Stage:
    return Stage(matrix, np.array([-2.5, 0.25, *(-2.5 - 0.1 * k for k in range(len(matrix) - 2))]))


def grows(matrix: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Sum of absolute powers until rows are below a thousandth, and the units."""
    m = len(matrix)
    units = np.array([scale if i % 2 else 1.0 for i in range(m)])
    power, total = np.eye(m), np.zeros((m, m))
    while True:
        total += np.abs(power)
        if (np.abs(power) * units[None, :] / units[:, None]).sum(axis=1).max() < 1e-3:
            return total, units
        power = power @ matrix


@pytest.mark.parametrize("off", [(0.1, 0.0, 0.0), (0.0, -0.05, 0.0), (0.0, 0.0, 0.3), (-0.1, 0.02, -0.3)])
def test_a_difference_grows_by_no_more_than_the_sum_of_the_powers(
    monkeypatch: pytest.MonkeyPatch, off: tuple[float, float, float]
) -> None:
    """And no part of it counts for less than a thousandth of the largest, which the powers leave."""
    stage = following(np.array([[0.3, 0.9, 0.0], [-0.4, 0.2, 0.3], [1.0, 0.0, 0.0]]))
    start = stage.place + off
    for near, status in ((True, PROVEN), (False, NOT_CAPTURED)):
        found = prove(monkeypatch, stage, start[:2], body(), CONTINUOUS, before=float(start[-1]), near=near)
        assert (found.status, found.margin, found.edge, found.bound) == (status, 0.4, 0.3, 0.125)
        scale = 0.5 / 3.5
        total, units = grows(stage.matrix, scale)
        error = errors(stage, found.residual)
        residual = np.maximum(np.abs(off), 1e-3 * np.max(np.abs(off) / units) * units)
        ((away, power),) = found.asked
        np.testing.assert_allclose(away, total @ residual, rtol=1e-6)
        np.testing.assert_allclose(power, error, rtol=1e-9)


def test_a_trial_on_its_orbit_may_still_grow_by_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    stage = following(np.array([[0.3, 0.9, 0.0], [-0.4, 0.2, 0.3], [1.0, 0.0, 0.0]]))
    found = prove(monkeypatch, stage, stage.place[:2], body(), CONTINUOUS, before=float(stage.place[-1]))
    total, units = grows(stage.matrix, 0.5 / 3.5)
    error = errors(stage, found.residual)
    left = np.abs(stage.place - found.seen[-1])  # by roundings
    residual = np.maximum(error + left, 1e-3 * np.max((error + left) / units) * units)
    ((away, power),) = found.asked
    assert (np.array(away) >= (error + total @ error) * (1.0 - 1e-12)).all()
    np.testing.assert_allclose(away, error + total @ residual, rtol=0.1)
    np.testing.assert_allclose(power, error, rtol=1e-9)
    late = following(np.diag([0.5, 0.5, 0.5, 0.5]))
    late.matrix[1, 2] = 0.25  # by which it is seen
    moved = late.place + np.array([0.0, 0.0, 0.2, 0.0])
    found = prove(monkeypatch, late, moved[:2], body(), CONTINUOUS, before=float(moved[-1]), ring=(float(moved[2]),))
    ((away, _),) = found.asked
    np.testing.assert_allclose(away, grows(late.matrix, 0.5 / 3.5)[0] @ [2e-4, 2e-4 / 7.0, 0.2, 2e-4 / 7.0], rtol=1e-9)
    late.matrix[1, 3] = 0.25
    moved = late.place + np.array([0.0, 0.0, 0.0, 0.2])  # the last reading, which counts as a speed here
    found = prove(monkeypatch, late, moved[:2], body(), CONTINUOUS, before=float(moved[-1]), ring=(float(moved[2]),))
    ((away, _),) = found.asked
    np.testing.assert_allclose(away, grows(late.matrix, 0.5 / 3.5)[0] @ [1.4e-3, 2e-4, 1.4e-3, 0.2], rtol=1e-9)


def test_a_slow_decay_is_bounded_by_an_ellipse(monkeypatch: pytest.MonkeyPatch) -> None:
    """4096 powers are not enough: one mode of 0.9999, and the ellipse of Lyapunov's equation."""
    linalg = pytest.importorskip("scipy.linalg")
    stage = following(np.array([[0.9999, 0.4, 0.0], [0.0, 0.2, 0.0], [0.5, 0.0, 0.0]]))
    off = np.array([0.01, -0.02, 0.005])
    start = stage.place + off
    found = prove(monkeypatch, stage, start[:2], body(), CONTINUOUS, before=float(start[-1]))
    assert found.status == PROVEN
    scale = 0.5 / 3.5
    units = np.array([1.0, scale, 1.0])
    p = linalg.solve_discrete_lyapunov((stage.matrix * units[None, :] / units[:, None]).T, np.eye(3))
    error = errors(stage, found.residual)
    size = sqrt((off / units) @ p @ (off / units))
    ((away, power),) = found.asked
    np.testing.assert_allclose(away, size * units * np.sqrt(np.diag(np.linalg.inv(p))), rtol=1e-5)
    np.testing.assert_allclose(power, error, rtol=1e-6)
    for keeps in (1.0 - 1e-14,):
        slower = following(np.array([[0.5, 0.0, 0.0], [0.0, keeps, 0.0], [0.5, 0.0, 0.0]]))
        found = prove(monkeypatch, slower, slower.place[:2], body(), CONTINUOUS, before=float(slower.place[-1]))
        assert found.status in (DIFFERENT, NEUTRAL, ON_EDGE, EXPANDS)


def test_a_continuous_sensor_with_friction_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    stage = following(0.5 * np.eye(3))
    for friction, status in ((0.0, PROVEN), (1e-9, EXPANDS)):
        one = body(friction=friction)
        found = prove(monkeypatch, stage, stage.place[:2], one, CONTINUOUS, before=float(stage.place[-1]))
        assert found.status == status
        assert len(found.asked) == (status == PROVEN)


def test_without_an_ellipse_nothing_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    stage = following(np.diag([0.9999, 0.5, 0.5]))
    refuse: Callable[..., bool] = lambda *_: False  # noqa: E731
    monkeypatch.setattr(powers, "ellipse_bound", refuse)
    found = prove(monkeypatch, stage, stage.place[:2], body(), CONTINUOUS, before=float(stage.place[-1]))
    assert (found.status, found.margin, found.edge, found.asked) == (EXPANDS, 0.4, 0.3, [])
    assert found.bound == pytest.approx(errors(stage, found.residual)[0], rel=1e-6)
