"""How fast nearby motions part: against two motions, and against maps whose exponent is known."""

from math import inf, log, sqrt
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general import period_map
from hknob_cli.engine.general.controller import Controller, read_after
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.laws import sensed as with_law
from hknob_cli.engine.general.laws.law import LOOK, PIECE, TORQUE
from hknob_cli.engine.general.laws.sensed import parting_with_law, slope_columns
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.engine.general.period_map import Space, normalise, parting_rate
from hknob_cli.engine.general.search import make_space

from .gears import geared
from .test_laws import made

WALL = Controller(2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0)


def zeros(count: int) -> list[float]:
    return [7.0] * count


@pytest.mark.parametrize(("m", "width"), [(1, 1), (2, 3), (3, 5)])
def test_columns_are_brought_back_to_length_one(m: int, width: int) -> None:
    """All of them together; what is beside them is left alone."""
    cols = np.random.default_rng(m).normal(size=width * width + 3).tolist()
    before = list(cols)
    inside = [c * width + i for c in range(m) for i in range(m)]
    size = sqrt(sum(before[k] ** 2 for k in inside))
    assert normalise(cols, width, m) == pytest.approx(size, rel=1e-15)
    for k, value in enumerate(before):
        assert cols[k] == (pytest.approx(value / size, rel=1e-14) if k in inside else value)
    nothing = [0.0] * (width * width)
    assert normalise(nothing, width, m) == 0.0
    assert nothing == [0.0] * (width * width)


COUNTED = SimpleNamespace(analog=0.0)  # a wall that reads counts


class Map:
    """An interval that multiplies every column by a matrix, and counts."""

    def __init__(self, matrix: list[list[float]]) -> None:
        self.matrix, self.seen = np.array(matrix), list[Any]()

    def advance(
        self, z: Any, before: float, ring: Any, head: int, body: Any, wall: Any, space: Space, count: int
    ) -> tuple[float, int]:
        cols, width = space.cols, space.width
        if not self.seen:
            assert [cols[c * width + i] for c in range(count) for i in range(width)] == np.eye(
                count, width
            ).ravel().tolist()
        self.seen.append((list(z), before, head))
        for c in range(count):
            cols[c * width : c * width + count] = (self.matrix @ cols[c * width : c * width + count]).tolist()
        z[0] += 1.0
        return before - 1.0, head + 1


def test_the_rate_is_the_mean_logarithm_of_a_growth(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all samples but that all columns together begin longer than one: by their first length, once."""
    for matrix, rate in (([[2.0, 0.0], [0.0, 0.5]], log(2.0)), ([[0.25, 0.0], [0.0, 0.25]], log(0.25))):
        one, space = Map(matrix), make_space(2, 3, zeros)
        monkeypatch.setattr(period_map, "advance_columns", one.advance)
        z = [5.0, 6.0]
        found = parting_rate(z, -3.0, [1.0, 2.0, 3.0], 40, SimpleNamespace(order=2), COUNTED, space)
        true = np.linalg.norm(np.linalg.matrix_power(one.matrix, 40))
        assert found == pytest.approx(log(true) / 40.0, rel=1e-12)
        assert found == pytest.approx(rate, abs=0.01)
        assert z == [45.0, 6.0]
        assert [(seen[1], seen[2]) for seen in one.seen] == [(-3.0 - k, k) for k in range(40)]
    one = Map([[0.0, 1.0], [0.0, 0.0]])
    monkeypatch.setattr(period_map, "advance_columns", one.advance)
    two = SimpleNamespace(order=2)
    assert parting_rate([5.0, 6.0], -3.0, [], 40, two, COUNTED, make_space(2, 0, zeros)) == -inf
    assert len(one.seen) == 2


@pytest.mark.parametrize("friction", [0.0, 5e-6])
def test_motions_through_the_play_part_as_their_neighbours_do(friction: float) -> None:
    """The derivative's own size after 20 samples, by differences of motions 1e-6 apart; it begins as of length 1."""
    body, pad, samples = geared(friction), [0.0] * 8, 20
    ends = []
    for c in range(4):
        pair = []
        for nudge in (1e-6, -1e-6):
            z, before, readings = [-3.6, 0.5, 0.25, 0.125], -4.0, []
            z[c] += nudge
            for _ in range(samples):
                before, _ = advance(z, before, [], 0, body, WALL, pad)
                readings.append(before)
            pair.append((np.array(z), readings))
        assert pair[0][1] == pair[1][1]
        ends.append((pair[0][0] - pair[1][0]) / 2e-6)
    z = [-3.6, 0.5, 0.25, 0.125]
    found = parting_rate(z, -4.0, [], samples, body, WALL, make_space(4, 0, zeros))
    assert found * samples == pytest.approx(log(float(np.linalg.norm(ends))), abs=1e-4)


# Under a law.


def test_the_slope_of_the_newest_torque_moves_in() -> None:
    """Torques move on by one; the newest goes by the speed."""
    width, n, ages = 6, 2, 3
    space = SimpleNamespace(width=width, cols=[float(k) for k in range(width * width)])
    before = list(space.cols)
    slope_columns(0.5, SimpleNamespace(order=n), SimpleNamespace(ages=ages), space, 5)
    for c in range(width):
        one = before[c * width : (c + 1) * width]
        after = [*one[:2], one[3], one[4], 0.5 * one[1], one[5]]
        assert space.cols[c * width : (c + 1) * width] == (after if c < 5 else one)


@pytest.mark.parametrize("look", [0, 1])
@pytest.mark.parametrize("senses", [False, True])
@pytest.mark.parametrize("width", [0.0, 0.5, 1.5])
def test_an_interval_under_a_law_is_that_of_its_trial(
    monkeypatch: pytest.MonkeyPatch, senses: bool, width: float, look: int
) -> None:
    """Decided at the sample, then piece by piece; a torque's own columns are those that move it."""
    wall, line, ages = WALL._replace(hysteresis=width), 3, 2
    law = SimpleNamespace(
        senses=senses, line=line, ages=ages, parts=1, pieces=2, out=[1.0, 0.25], sched=[0.0] * (2 * PIECE)
    )
    for piece, torque in ((0, line), (1, line + 1)):
        law.sched[piece * PIECE + TORQUE], law.sched[piece * PIECE + LOOK] = (
            float(torque),
            (float(look) if piece else -1.0),
        )
    script = [[-2.5, 0.25], [-1.75, 0.25], [-0.625, 0.5], [-1.25, 0.0], [-2.125, -0.5]]
    moves, counted, shown, m = list[int](), list[Any](), list[float](), 2 + (ages if senses else 0)

    def move(past: Any, at: int, body: Any, _: Any, room: Any, count: int) -> None:
        assert (at, count) == (len(moves) % 2 * PIECE, m)
        own = 2 + (0 if at == 0 else 1)
        for c in range(m):
            expected = room.cols[c * room.width + own] if senses else 0.0
            assert room.cols[room.width * room.width + c] == expected
        for c in range(m):
            for i in range(m):
                room.cols[c * room.width + i] *= 2.0 if at == 0 else 0.75
        moves.append(at)
        room.state[:] = script[len(moves)]

    def count(z: Any, past: Any, piece: int, body: Any, one: Any, _: Any, pad: Any) -> float:
        assert list(z)[:2] == script[len(moves)]
        z[0] = 99.0
        counted.append(piece)
        past[line - 1] -= 1.0
        return 9.0

    monkeypatch.setattr(with_law, "decide", lambda what, speed, *_: shown.append((what, speed)))
    monkeypatch.setattr(with_law, "move_piece_columns", move)
    monkeypatch.setattr(with_law, "count_piece", count)
    space = make_space(2, 4, zeros)
    z, past = list(script[0]), [7.0, 8.0, -3.0, 0.5, 0.25]
    rate = parting_with_law(z, past, 2, SimpleNamespace(order=2), wall, law, space)
    assert z == script[4]
    assert counted == ([0, 1, 0, 1] if width else [])
    last = -3.0
    for k in range(2):
        read_now = read_after(script[2 * k][0], last, wall)
        assert shown[k] == (read_now, script[2 * k][1])
        last = read_now - 2.0 if width else last
    expected = [7.0, 8.0, last, 0.5, 0.25]
    expected[look] = read_after(script[4][0], last, wall)
    assert past == expected
    if not senses:
        assert rate == pytest.approx(0.5 * (log(1.5 * sqrt(2.0)) + log(1.5)), rel=1e-12)


def test_what_is_no_longer_told_apart_parts_by_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    _, cell = made({"kind": "bounded_lag", "time_constant": 0.01})
    law = cell.law
    past = [0.0] * len(law.beside)
    begin_past(past, -1.0, law)

    def move(past: Any, at: int, body: Any, _: Any, room: Any, count: int) -> None:
        for k in range(room.width * count):
            room.cols[k] = 0.0

    monkeypatch.setattr(with_law, "move_piece_columns", move)
    space = make_space(2, law.ages, zeros)
    assert parting_with_law([-0.5, 0.0], past, 5, cell.knob.body, cell.knob.wall, law, space) == -inf


def neighbours(step: Any, z: list[float], beside: list[float], samples: int) -> float:
    """Mean logarithm of how two motions part that get the same readings, brought back to 1e-7 every sample."""
    total = 0.0
    for _ in range(samples):
        step(z, beside)
        off = np.array(beside) - np.array(z)
        size = float(np.linalg.norm(off))
        total += log(size / 1e-7)
        beside[:] = (np.array(z) + off * (1e-7 / size)).tolist()
    return total / samples


@pytest.mark.parametrize(
    "law",
    [
        {"kind": "bounded_lag", "time_constant": 0.01},
        {"kind": "velocity_damping", "velocity": "sensor", "damping": 2e-4},
    ],
)
def test_motions_under_a_law_part_as_two_neighbours_do(law: dict[str, Any]) -> None:
    """A stable cycle's come nearer; a sensed speed makes torques of a neighbour others."""
    _, cell = made(law)
    one, body, wall, pad, samples = cell.law, cell.knob.body, cell.knob.wall, [0.0] * 4, 80
    z = [-0.4, 0.125]
    past = [0.0] * len(one.beside)
    begin_past(past, -1.0, one)
    start, memory, other = list(z), list(past), list(past)

    def step(z: list[float], beside: list[float]) -> None:
        advance_with_law(z, past, body, wall, one, pad)
        advance_with_law(beside, other, body, wall, one, pad)

    rate = neighbours(step, list(z), (np.array(z) + 0.7e-7).tolist(), samples)
    found = parting_with_law(start, memory, samples, body, wall, one, make_space(2, max(4, one.ages), zeros))
    assert found == pytest.approx(rate, abs=(log(2.0) + 1.0) / samples)
