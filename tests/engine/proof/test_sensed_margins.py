"""The proof of a cycle under a law that senses the velocity, on its margins: a known map stands in for the motion.

What an interval rounds is compared with the law and the motion at 60 digits.
"""

from itertools import product
from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any, NamedTuple

import mpmath as mp
import numpy as np
import pytest

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import count_gap, edge_gap, read
from hknob_cli.engine.general.laws import sensed
from hknob_cli.engine.general.laws.law import AT_SWITCH, PIECE, SPAN, TORQUE
from hknob_cli.engine.general.laws.step import advance_with_law, decide
from hknob_cli.engine.general.orbit_proof import EXPANDS
from hknob_cli.engine.general.period_map import NEWTON_STEPS
from hknob_cli.engine.general.search import make_space
from tests.engine.general.test_sensed import PARTS, certified, found

from .orbits import DIGITS
from .test_standstill_margins import LAGGING, WALL, body

UNIT = 2.0**-20  # of a rounding, here
# A number that is counted, one more, the last reading, and the torques of three samples.
LINE, AGES = 3, 3
UNDER_WAY = LINE + 1
PAST = [4.0, 1.5, -3.0, 9.0, 0.75, -1.25]
QUICK = np.array([[0.3, 0.4, 0.1, 0.0], [-0.2, 0.1, 0.0, 0.2], [0.0, 0.1, 0.2, -0.1], [0.1, -0.3, 0.0, 0.1]])
PLACE = (-2.5, 0.25, 0.75, -1.25)


def law_of(m: int = 4, **more: Any) -> Any:
    one = {
        "unit": 1.0,
        "line": LINE, "parts": 1, "ages": AGES, "pieces": 2, "coarse": 2.0, "fading": -1, "drifts": -1, "pair": [],
        "watch": WALL, "out": [7.0, 7.0], "beside": [7.0] * len(PAST), "periodic": [7.0] * len(PAST),
        "affine": [7.0] * ((m + 1) * m), "slopes": [7.0] * sensed.BLOCK, "noise": [7.0] * (4 * m), "sched": [],
    }  # fmt: skip
    return SimpleNamespace(**(one | more))


def space_of(order: int = 2) -> Any:
    return make_space(order, len(PAST), lambda count: [7.0] * count)


# Derivatives.


def test_columns_begin_as_the_state_by_itself() -> None:
    space = space_of()
    sensed.begin_columns(space, 3)
    width = space.width
    for c in range(3):
        assert space.cols[c * width : (c + 1) * width] == [1.0 if i == c else 0.0 for i in range(width)]
    assert space.cols[3 * width :] == [7.0] * (len(space.cols) - 3 * width)


def test_a_torque_has_the_slope_of_the_speed_where_it_is_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    """In every column; of a wall that watches outside, the edges are its own."""
    wall, watch = WALL, WALL._replace(damping=0.5)
    law, space, past = law_of(watch=watch), space_of(), list(PAST)
    space.state[:] = [1.25, -1.5]

    def act(shown: float, speed: float, memory: Any, given: Any, _: Any) -> float:
        assert (shown, speed, memory, given) == (1.0, -1.5, PAST, wall)
        law.out[1] = -0.5
        return 0.375

    monkeypatch.setattr(sensed, "decide", act)
    for c in range(3):
        space.cols[c * space.width : (c + 1) * space.width] = [10.0 + c, 2.0 * c - 1.0, *[7.0] * (space.width - 2)]
    assert sensed.sense(past, wall, law, space, 3) == (0.25, count_gap(1.25, wall), 0.375, -0.5)
    assert edge_gap(1.25, 1.0, 1.0, watch) == 0.25 < edge_gap(1.25, 1.0, 1.0, wall)
    for c in range(3):
        assert space.cols[c * space.width : c * space.width + 4] == [10.0 + c, 2.0 * c - 1.0, 7.0, 0.5 - c]


def test_a_map_of_an_interval_is_that_of_every_column_and_of_the_torque(monkeypatch: pytest.MonkeyPatch) -> None:
    law, space = law_of(3), space_of()
    space.orbit[:] = [1.5, -0.25]

    def move(past: Any, one: Any, given: Any, room: Any, count: int) -> None:
        assert (past, one, given, count) == (PAST, BODY, law, 4)
        assert room.state == [1.5, -0.25]
        for c in range(count):
            assert room.cols[c * room.width : (c + 1) * room.width] == [float(i == c) for i in range(room.width)]
            room.cols[c * room.width : (c + 1) * room.width] = [10.0 * c + i for i in range(room.width)]
        assert room.cols[count * room.width :] == [7.0] * (len(room.cols) - count * room.width)

    monkeypatch.setattr(sensed, "move_columns", move)
    sensed.chart_interval(PAST, BODY, law, space, 3)
    assert law.affine == [10.0 * c + i for c in range(4) for i in range(3)]


@pytest.mark.parametrize("seed", range(8))
def test_a_turn_sees_every_sample(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    """Least gaps, and largest position, way, speed and torque, of a scripted motion, each where it is."""
    numbers, period = np.random.default_rng(seed), 4
    script = numbers.uniform(-3.0, 3.0, (period + 1, 2)) * ([1.0, 0.2] if seed % 3 else [0.3, 5.0])
    gaps, torques = numbers.uniform(0.1, 1.0, (period, 2)), numbers.normal(size=period)
    law, space, past = law_of(), space_of(), list(PAST)
    space.orbit[:] = script[0].tolist()
    calls: list[str] = []

    def sense(memory: Any, wall: Any, _: Any, room: Any, m: int) -> Any:
        k = len(calls) // 2
        calls.append("sense")
        assert (room.state, m) == (script[k].tolist(), 4)
        if k == 0:
            assert [room.cols[c * room.width + i] for c, i in product(range(4), range(4))] == np.eye(4).ravel().tolist()
        memory[LINE + AGES - 1] = float(torques[k])
        return (*map(float, gaps[k]), 0.0, 0.0)

    def move(memory: Any, _: Any, __: Any, room: Any, m: int) -> None:
        calls.append("move")
        assert m == 4
        room.state[:] = script[len(calls) // 2].tolist()

    monkeypatch.setattr(sensed, "sense", sense)
    monkeypatch.setattr(sensed, "move_columns", move)
    found_ = sensed.turn_sensed(past, period, BODY, WALL, law, space, 4)
    assert calls == ["sense", "move"] * period
    ways = np.abs(np.diff(script[:, 0]))
    assert found_ == (
        gaps[:, 0].min(),
        gaps[:, 1].min(),
        np.abs(script[:-1, 0]).max(),
        max(np.abs(script[:-1, 1]).max(), ways.max()),
        np.abs(torques).max(),
    )


# What rounding comes to.


@pytest.mark.parametrize("seed", range(6))
def test_what_rounding_adds_goes_through_every_later_interval(seed: int) -> None:
    """Each by its own slope, in the speed's column alone; in every entry, without a sign."""
    numbers, m, count = np.random.default_rng(seed), 4, 3
    law, plant, torque = law_of(), numbers.normal(size=(4, 4)), numbers.normal(size=4)
    slopes, noise, first = numbers.normal(size=count), numbers.uniform(0.1, 1.0, m), numbers.uniform(0.1, 1.0, m)
    law.affine[:] = [*plant.T.ravel(), *torque]
    law.slopes[:count] = slopes
    law.noise[: 2 * m] = [*noise, *first]
    maps = [plant + slope * np.outer(torque, np.eye(m)[1]) for slope in slopes]

    def after(begin: int, there: np.ndarray) -> np.ndarray:
        """From what there was ``begin`` intervals into the block."""
        total, through = np.zeros(m), np.eye(m)
        for one in reversed(maps[begin:]):
            total += np.abs(through) @ noise
            through = through @ one
        return np.asarray(total + np.abs(through) @ there)

    row, total = [9.0] * (2 * m), after(0, first)
    for begin in range(count + 1):
        there = numbers.uniform(0.1, 1.0, m)
        law.noise[3 * m :] = there
        found_ = [sensed.carried(i, begin, 3 * m, count, law, m, row) for i in range(m)]
        assert found_ == pytest.approx(after(begin, there).tolist(), rel=1e-12)
    assert [sensed.carried(i, 0, m, 0, law, m, row) for i in range(m)] == pytest.approx(first.tolist(), rel=1e-15)
    for start in (3 * m, m):  # of a stop, and of the next block
        before = list(law.noise)
        sensed.sum_block(start, count, law, m, row)
        assert law.noise[start : start + m] == pytest.approx(total.tolist(), rel=1e-12)
        before[2 * m : 3 * m], before[start : start + m] = law.noise[2 * m : 3 * m], law.noise[start : start + m]
        assert law.noise == before


def test_a_sum_that_goes_on_from_a_stop_bounds_that_of_the_whole_block() -> None:
    """It is no smaller, and equal where nothing cancels."""
    numbers, m, count = np.random.default_rng(7), 4, 6
    for signs in (True, False):
        law, row = law_of(), [9.0] * (2 * m)
        law.slopes[:count] = numbers.uniform(0.1, 1.0, count)
        law.affine[:] = numbers.normal(size=(m + 1) * m) if signs else numbers.uniform(0.1, 1.0, (m + 1) * m)
        law.noise[: 2 * m] = numbers.uniform(0.1, 1.0, 2 * m)
        for stop in range(count):
            sensed.sum_block(3 * m, stop, law, m, row)
            for entry in range(m):
                whole = sensed.carried(entry, 0, m, count, law, m, row)
                on = sensed.carried(entry, stop, 3 * m, count, law, m, row)
                assert on >= whole * (1.0 - 1e-12)
                assert signs or on == pytest.approx(whole, rel=1e-12)


class Within(NamedTuple):
    """A period of 9 samples in blocks of 4 with a stop at every other, whose derivatives and roundings are known."""

    place: list[float]  # by the orbit's error, of each sample
    speed: list[float]
    far: list[float]  # by a difference of the trial's
    fast: list[float]
    found: Any
    closed: list[tuple[int, int, list[float]]]  # where a sum is left, of how many samples, and their slopes


POWER, AWAY = [0.25, 0.5, 0.125], [1.0, 0.5, 2.0]


def run_within(patch: pytest.MonkeyPatch, gaps: list[float] | None = None, guards: list[float] | None = None) -> Within:
    numbers, period, m = np.random.default_rng(4), 9, 3
    law, space, past = law_of(3), space_of(), list(PAST)
    scripts = [np.eye(m), *(numbers.integers(-8, 8, (m, m)) / 8.0 for _ in range(period))]
    errors = numbers.permutation(2 * period).reshape(period, 2) / 16.0
    space.orbit[:], space.power[:m], space.away[:m] = [1.5, -0.25], POWER, AWAY
    samples: list[int] = []
    closed: list[tuple[int, int, list[float]]] = []

    def sense(memory: Any, wall: Any, _: Any, room: Any, count: int) -> Any:
        k = len(samples)
        assert (memory, wall, count) == (past, WALL, m)
        if k == 0:
            assert room.state == [1.5, -0.25]
            assert law.noise[m : 2 * m] == [0.0] * m
        samples.append(k)
        return (gaps or [9.0] * period)[k], 7.0, (guards or [9.0] * period)[k], k + 0.5

    def move(memory: Any, one: Any, _: Any, room: Any, count: int) -> None:
        assert (memory, one, count) == (past, BODY, m)
        for c in range(m):
            for i in range(m):
                room.cols[c * room.width + i] = float(scripts[len(samples)][i, c])

    def carried(entry: int, begin: int, start: int, count: int, given: Any, size: int, row: Any) -> float:
        at = (len(samples) - 1) % 4
        assert (begin, start, count, size) == (at - at % 2, 3 * m, at, m)
        assert closed[-1][:2] == (3 * m, begin)
        return float(errors[len(samples) - 1][entry])

    def close(start: int, count: int, given: Any, size: int, row: Any) -> None:
        assert size == m
        closed.append((start, count, list(given.slopes[:count])))

    patch.setattr(sensed, "BLOCK", 4)
    patch.setattr(sensed, "STOP", 2)
    for name, one in (("sense", sense), ("move_columns", move), ("carried", carried), ("sum_block", close)):
        patch.setattr(sensed, name, one)
    result = sensed.within(past, period, BODY, WALL, law, space, m)
    sizes = np.abs(np.array(scripts[:-1]))
    near, wide = sizes[:, :2] @ np.array(POWER), sizes[:, :2] @ np.array(AWAY)
    lists = (*(errors + near).T.tolist(), *(errors + wide).T.tolist())
    whole = list(closed)
    closed.clear()
    samples.clear()
    assert sensed.chart_rounding(past, period, BODY, WALL, law, space, m) is None
    assert closed == [one for one in whole if one[0] == m] + [(m, 1, [8.5])]
    assert [space.cols[c * space.width + i] for i in range(m) for c in range(m)] == scripts[-1].ravel().tolist()
    return Within(*lists, result, whole)


def test_every_sample_keeps_its_reading_and_its_guard_or_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each at its very margin, one sample after another: by the orbit's error, and by the difference of the trial."""
    told = run_within(monkeypatch)
    assert told.found == (True, True, True, max(told.place))
    assert told.place[-1] < max(told.place) > told.place[0]
    one, two, stop, block = [0.5, 1.5, 2.5, 3.5], [4.5, 5.5, 6.5, 7.5], 9, 3
    assert told.closed == [
        (stop, 0, []), (stop, 2, one[:2]), (block, 4, one),
        (stop, 0, []), (stop, 2, two[:2]), (block, 4, two), (stop, 0, []),
    ]  # fmt: skip
    for k in range(9):
        for which, sizes in product(("gaps", "guards"), (told.place, told.speed, told.far, told.fast)):
            for size in (sizes[k], nextafter(sizes[k], inf)):
                margins = [9.0] * 9
                margins[k] = size
                edges, guards, near, bound = run_within(monkeypatch, **{which: margins}).found
                first, wide = (told.place, told.far) if which == "gaps" else (told.speed, told.fast)
                assert edges == (which == "guards" or first[k] < size)
                assert guards == (which == "gaps" or first[k] < size)
                assert near == (wide[k] < size)
                assert bound == max(told.place)


# The proof.


BODY = body()
BODIES = {
    "planar": BODY,
    "pushed": body(push=3.0),
    "stiff": body(beta=9.0, push=-3.0),
    "pad": LAGGING._replace(order=3, beta=0.5, pad_stiffness=2.0, drive=-1.0),
}


class Stage(NamedTuple):
    """What a period is made to be: w -> w + (1 - matrix) (place - w) + off, of the state and the torques under way."""

    matrix: np.ndarray = QUICK
    place: tuple[float, ...] = PLACE
    off: tuple[float, ...] = ()
    margin: float = 1e9
    reach: float = 3.0
    pace: float = 0.5
    strength: float = 5.0
    solves: float = 1.0  # part of its way that a step goes
    counted: float = 0.0
    errors: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)  # what rounding has come to at the end of a period
    grows: bool = False
    within: tuple[bool, bool, bool] = (True, True, True)


class Result(NamedTuple):
    """What `certify_sensed` gives, and leaves."""

    status: int
    margin: float
    edge: float
    closure: float
    bound: float
    space: Any
    seen: list[list[float]]  # where each turn began
    residual: np.ndarray  # of the last turn
    asked: list[float]  # scale that `dissipates` is asked with
    away: list[float]  # error of the orbit
    off: list[float]  # difference of the trial


def prove(
    stage: Stage,
    law: Any,
    *,
    one: Body = BODY,
    wall: Any = WALL,
    z: Any = None,
    past: list[float] | None = None,
    unit: float = UNIT,
) -> Result:
    n, m, period = one.order, len(stage.matrix), 4
    space, place = space_of(n), np.array(stage.place)
    seen: list[list[float]] = []
    asked: list[float] = []
    residual: list[float] = []
    errs: list[float] = []
    offs: list[float] = []
    begun: list[int] = []

    def state(memory: Any, room: Any) -> np.ndarray:
        return np.array([*room[:n], *memory[UNDER_WAY : UNDER_WAY + m - n]])

    def turn(beside: Any, samples: int, given: Any, w: Any, of: Any, room: Any, count: int) -> Any:
        assert (samples, given, w, of, count) == (period, one, wall, law, m)
        assert beside == law.periodic
        assert beside is law.beside
        at = state(law.periodic, room.orbit)
        seen.append(at.tolist())
        out = at + stage.solves * (np.eye(m) - stage.matrix) @ (place - at) + (np.array(stage.off) if stage.off else 0)
        for c, i in product(range(m), range(m)):
            room.cols[c * room.width + i] = float(stage.matrix[i, c])
        residual[:] = (out - at).tolist()
        room.state[:] = out[:n].tolist()
        beside[UNDER_WAY : UNDER_WAY + m - n] = out[n:].tolist()
        beside[0] += stage.counted
        return stage.margin, 0.3, stage.reach, stage.pace, stage.strength

    def chart(memory: Any, given: Any, of: Any, room: Any, count: int) -> None:
        assert (memory is law.beside, given, of, count) == (True, one, law, m)
        begun.append(0)

    def round_off(beside: Any, samples: int, given: Any, w: Any, of: Any, room: Any, count: int) -> None:
        assert (beside is law.beside, samples, given, w, of, count) == (True, period, one, wall, law, m)
        assert beside == law.periodic
        begun.append(1)
        law.noise[m : 2 * m] = list(stage.errors)[:m]

    def within(beside: Any, samples: int, given: Any, w: Any, of: Any, room: Any, count: int) -> Any:
        assert (beside is law.beside, samples, given, w, of, count) == (True, period, one, wall, law, m)
        assert beside == law.periodic
        assert begun == [0, 1]
        assert (room.power[:m], room.away[:m]) == ([11.0] * m, [13.0] * m)
        return (*stage.within, 0.0625)

    def dissipates(cols: Any, stride: int, power: Any, spare: Any, size: int, scale: float, samples: int) -> bool:
        assert (cols, stride, size, samples) == (space.cols, space.width, m, period)
        asked.append(scale)
        errs[:] = space.away[:m]
        return bool(true(cols, stride, power, spare, size, scale, samples))

    def grow(room: Any, size: int, scale: float, samples: int) -> bool:
        assert (size, scale, samples) == (m, asked[-1], period)
        assert room.power[:m] == room.away[:m] == errs
        offs[:] = room.residual[:m]
        room.power[:m], room.away[:m] = [11.0] * m, [13.0] * m
        return not stage.grows

    true = sensed.dissipates
    memory, start = list(past or PAST), [float(x) for x in (stage.place[:n] if z is None else z)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sensed, "EPSILON", unit)
        for name, stand in (
            ("turn_sensed", turn), ("chart_interval", chart), ("within", within), ("dissipates", dissipates),
            ("bound_growth", grow), ("chart_rounding", round_off),
        ):  # fmt: skip
            patch.setattr(sensed, name, stand)
        result = sensed.certify_sensed(list(start), memory, period, one, wall, law, space)
    assert memory == (past or PAST)
    return Result(*result, space, seen, np.array(residual), asked, errs, offs)


def of_order(n: int, ages: int = AGES) -> tuple[Stage, Any]:
    """A map of this many numbers, and its law."""
    m = n + ages - 1
    matrix = 0.3 * np.random.default_rng(m).normal(size=(m, m))
    matrix[:4, :4] = QUICK[:m, :m]
    place = (*PLACE[:2], *([0.5] * (n - 2)), *PAST[UNDER_WAY : UNDER_WAY + ages - 1])
    return Stage(matrix, place, errors=(0.0,) * m), law_of(m, ages=ages)


@pytest.mark.parametrize("name", BODIES)
def test_an_interval_rounds_its_torque_and_every_entry_of_the_state(name: str) -> None:
    """In full: a torque by its size, the depth and all springs; places by reach and pace, speeds by twice the pace."""
    one, wall = BODIES[name], WALL
    for reach, pace, strength, coarse, pieces in ((3.0, 0.5, 5.0, 2.0, 2), (0.25, 1.5, 0.5, 64.0, 3)):
        stage, law = of_order(one.order)
        law.coarse, law.pieces, law.unit = coarse, pieces, 0.25
        prove(stage._replace(reach=reach, pace=pace, strength=strength), law, one=one, wall=wall)
        pull = abs(one.drive) + (one.beta + one.pad_stiffness) * reach
        wrong = 16.0 * UNIT * (coarse * (strength + 0.25 * (1.0 + reach + pace)) + pull)
        each = 8.0 * UNIT * pieces
        state = [each * (reach + pace if j % 2 == 0 else 2.0 * pace) for j in range(one.order)]
        expected = [wrong + part for part in (*state, 0.0, 0.0)]
        assert law.noise[: len(expected)] == pytest.approx(expected, rel=1e-14)


def test_the_errors_of_a_period_go_through_the_inverse() -> None:
    """What is left of a residual, and what rounding has come to; in full, whatever their signs."""
    inverse = np.abs(np.linalg.inv(np.eye(4) - QUICK))
    for off, errors in product(
        ((0.0,) * 4, (1e-6, 0.0, 0.0, 0.0), (0.0, -2e-6, 0.0, 1e-6), (-1e-6, 1e-6, -5e-7, -1e-6)),
        ((0.0,) * 4, (1e-7, 2e-7, 4e-7, 8e-7)),
    ):
        found_ = prove(Stage(off=off, errors=errors), law_of())
        assert found_.closure == pytest.approx(sqrt(sum(x * x for x in off)), rel=1e-8)
        np.testing.assert_allclose(found_.away, inverse @ (np.abs(off) + errors), rtol=1e-8)


@pytest.mark.parametrize(
    ("reach", "pace", "scale"),
    [(3.0, 1.0, 0.25), (1.0, 0.0, 1.0), (1.0, 1e-5, 1e-3), (1.0, 0.002, 0.002 / 1.002), (0.5, 2.0, 0.8)],
)
def test_the_unit_of_speeds_is_the_pace_of_the_orbit(reach: float, pace: float, scale: float) -> None:
    assert prove(Stage(reach=reach, pace=pace), law_of()).asked == [pytest.approx(scale, rel=1e-15)]


@pytest.mark.parametrize(("order", "ages"), [(2, 3), (3, 3), (2, 1), (2, 2)])
def test_the_orbit_is_the_fixed_point_and_so_are_the_torques_under_way(order: int, ages: int) -> None:
    stage, law = of_order(order, ages)
    numbers, m = np.random.default_rng(3), order + ages - 1
    start = np.array(stage.place) + 1e-3 * numbers.normal(size=m)
    past = list(PAST)
    past[UNDER_WAY : UNDER_WAY + ages - 1] = start[order:].tolist()
    one = BODY if order == 2 else LAGGING
    found_ = prove(stage, law, one=one, z=start[:order], past=past, unit=EPSILON)
    assert (found_.status, found_.margin, found_.edge, found_.bound) == (PROVEN, 1e9, 0.3, 0.0625)
    np.testing.assert_allclose(found_.space.orbit, stage.place[:order], atol=1e-14)
    np.testing.assert_allclose(law.periodic[UNDER_WAY : UNDER_WAY + ages - 1], stage.place[order:], atol=1e-14)
    assert [*law.periodic[:UNDER_WAY], *law.periodic[UNDER_WAY + ages - 1 :]] == [
        *PAST[:UNDER_WAY], *PAST[UNDER_WAY + ages - 1 :]
    ]  # fmt: skip
    assert 2 <= len(found_.seen) <= 4
    assert found_.closure <= 4.0 * EPSILON * 3.5
    np.testing.assert_allclose(found_.off, start - np.array(stage.place), atol=1e-13)


def test_the_residual_is_that_of_the_orbit_that_is_left() -> None:
    """Of a map whose derivative is not the given one, so that each step takes off two thirds alone."""
    law = law_of()
    found_ = prove(Stage(solves=2.0 / 3.0), law, z=[-2.49, 0.25], unit=EPSILON)
    assert (found_.status, len(found_.seen)) == (PROVEN, NEWTON_STEPS)
    assert [*found_.space.orbit, *law.periodic[UNDER_WAY : UNDER_WAY + 2]] == found_.seen[-1]
    assert found_.closure == pytest.approx(float(np.linalg.norm(found_.residual)), rel=1e-9)
    inverse = np.linalg.inv(np.eye(4) - QUICK)
    np.testing.assert_allclose(found_.away, np.abs(inverse) @ np.abs(found_.residual), rtol=1e-6)


def test_a_step_that_takes_off_less_than_half_is_the_last() -> None:
    for part, turns in ((0.4, 2), (0.5, 2), (0.501, NEWTON_STEPS), (0.6, NEWTON_STEPS)):
        stage = Stage(np.zeros((4, 4)), place=(0.0,) * 4, solves=part)
        past = [*PAST[:UNDER_WAY], 0.0, 0.0]
        assert len(prove(stage, law_of(), z=[2.0**-10, 0.0], past=past, unit=2.0**-60).seen) == turns


def test_no_step_is_made_where_rounding_is_all_that_is_left() -> None:
    """4 units of reach and pace."""
    for size, turns in ((14.0 * UNIT, 1), (nextafter(14.0 * UNIT, 1.0), 2)):
        stage = Stage(np.zeros((4, 4)), place=(0.0,) * 4)
        past = [*PAST[:UNDER_WAY], 0.0, 0.0]
        assert len(prove(stage._replace(reach=3.0, pace=0.5), law_of(), z=[size, 0.0], past=past).seen) == turns


def test_a_motion_that_does_not_close_is_another() -> None:
    """A singular derivative ends the search at once: 1e-6 of reach and pace decides."""
    for off, status in (
        ((0.6, 0.0, 0.0, 0.8), NEUTRAL), ((-0.9, 0.0, -0.1, 0.0), NEUTRAL), ((0.0, 0.0, 0.999, 0.0), NEUTRAL),
        ((1.01, 0.0, 0.0, 0.0), DIFFERENT), ((0.0, 0.0, 0.0, -1.01), DIFFERENT), ((0.8, 0.0, 0.8, 0.0), DIFFERENT),
    ):  # fmt: skip
        found_ = prove(Stage(np.eye(4), off=tuple(3.499e-6 * x for x in off)), law_of(), unit=EPSILON)
        assert found_.status == status
        assert len(found_.seen) == 1
        if status == NEUTRAL:
            assert found_.closure == pytest.approx(3.499e-6 * sqrt(sum(x * x for x in off)), rel=1e-8)
            assert (found_.margin, found_.edge, found_.bound) == (1e9, 0.3, 0.0)
        else:
            assert found_[1:5] == (0.0, 0.0, 0.0, 0.0)
    for closure, status in ((1e-6, DIFFERENT), (nextafter(1e-6, 0.0), NEUTRAL)):
        stage = Stage(np.eye(4), place=(0.0,) * 4, off=(closure, 0.0, 0.0, 0.0), reach=0.5)
        past = [*PAST[:UNDER_WAY], 0.0, 0.0]
        assert prove(stage, law_of(), past=past, unit=EPSILON).status == status


def test_counts_that_do_not_come_back_are_no_orbit() -> None:
    assert prove(Stage(counted=1.0), law_of())[:5] == (DIFFERENT, 0.0, 0.0, 0.0, 0.0)


def test_what_grows_and_what_does_not_stay_is_not_proven() -> None:
    growing = prove(Stage(1.5 * np.eye(4), errors=(1e-6,) * 4), law_of())
    assert growing[:4] == (EXPANDS, 1e9, 0.3, 0.0)
    assert growing.bound == growing.away[0] == pytest.approx(2e-6, rel=1e-12)
    kept = prove(Stage(grows=True, errors=(1e-6,) * 4), law_of())
    assert kept[:5] == (EXPANDS, 1e9, 0.3, 0.0, kept.away[0])
    assert kept.away[0] > 0.0
    for flags, status in (
        ((True, True, True), PROVEN), ((True, True, False), NOT_CAPTURED), ((False, True, True), ON_EDGE),
        ((True, False, True), AT_SWITCH), ((False, False, False), ON_EDGE), ((True, False, False), AT_SWITCH),
    ):  # fmt: skip
        assert prove(Stage(within=flags), law_of())[:5] == (status, 1e9, 0.3, 0.0, 0.0625)


# The roundings of an interval, from below.


def truly(z: list[float], torques: dict[int, Any], one: Body, law: Any) -> list[Any]:
    """A state of second order after an interval under these torques, at the digits of the moment."""
    x, v = mp.mpf(z[0]), mp.mpf(z[1])
    for piece in range(law.pieces):
        at = piece * PIECE
        rates = mp.matrix([
            [0, 1, 0],
            [-mp.mpf(one.beta), -mp.mpf(one.alpha), mp.mpf(one.drive) + mp.mpf(torques[int(law.sched[at + TORQUE])])],
            [0, 0, 0],
        ])  # fmt: skip
        x, v, _ = mp.expm(rates * mp.mpf(law.sched[at + SPAN])) * mp.matrix([x, v, 1])
    return [x, v]


@pytest.mark.parametrize("parts", ["alone", "delay"])
@pytest.mark.parametrize("name", ["damping, sensor", "half sample, sensor", "matched wall, sensor"])
def test_no_interval_of_an_orbit_rounds_more_than_is_said(name: str, parts: str) -> None:
    """Torque, place and speed at 60 digits, sample by sample."""
    cell, law, orbit = found(name, **PARTS[parts])
    one, wall = cell.knob.body, cell.knob.wall
    z, past = [orbit.x, orbit.v], list(orbit.line)
    status, _ = certified(cell, law, z, past, orbit.period)
    assert status == PROVEN
    noise = list(law.noise[: 2 + law.ages - 1])
    newest = law.line + law.ages - 1
    for _ in range(min(orbit.period, 25)):
        with mp.workdps(DIGITS):
            shown = read(z[0], wall)
            exact: list[Any] = [mp.mpf(value) for value in past]
            decide(mp.mpf(shown), mp.mpf(z[1]), exact, wall, law)
            decided = exact[newest]
        before = list(z)
        advance_with_law(z, past, one, wall, law, [0.0] * 4)
        with mp.workdps(DIGITS):
            assert abs(mp.mpf(past[newest]) - decided) < noise[-1] if law.ages > 1 else True
            torques = dict(enumerate(past)) | {newest: decided}
            for entry, true in enumerate(truly(before, torques, one, law)):
                assert abs(mp.mpf(z[entry]) - true) < noise[entry]
