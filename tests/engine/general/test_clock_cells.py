"""Cells of states under every clock: successors hold every motion, and the graph is trimmed as another way does."""

from collections.abc import Iterator
from fractions import Fraction
from math import floor, sqrt
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.engine.general import clock_cells, every_clock
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.clock_cells import (
    CAPTURED,
    HOLD,
    LEAVES,
    LEVELS,
    RESTS,
    SLACK,
    THERE,
    UNSEEN,
    Cells,
    Joined,
    hold_range,
    reach_cells,
    rests,
    rounded,
    successors,
    trim_cells,
    widest_range,
)
from hknob_cli.engine.general.controller import Controller, command, edge_gap, read
from hknob_cli.engine.general.interval import SHORTEST
from hknob_cli.engine.general.search import as_list
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.general_knob import GeneralKnob
from tests.verification.general_scenes import scene
from tests.verification.test_jitter import knob_of, with_clock

BOXES = 4 * 2 ** (LEVELS - 1)


class Still(NamedTuple):
    """What cells need of a body; ``halt`` never rings."""

    beta: float
    drive: float
    alpha: float = 0.0
    halt: tuple[float, ...] = (0.0,)

    @property
    def reach(self) -> float:
        """Position of a unit root of energy."""
        return 1.0 / sqrt(self.beta)


def grid_of(body: Body, wall: Controller, fineness: int, far: int = 6, *, whole: bool = True) -> Cells:
    """A grid about the origin, ``far`` counts each way, in lists."""
    width = 1.0 / fineness
    height = width * sqrt(body.beta)
    rows = round(2.0 / height)
    shortest = float(wall.clock[SHORTEST])
    parts = every_clock.parts_of(body, shortest).tolist()
    box = (-far * fineness, -rows, 2 * far * fineness, 2 * rows)
    return Cells(width, height, *box, shortest, whole, parts, [0] * BOXES)


def middle(at: int, cells: Cells) -> tuple[float, float]:
    """Position and speed in the middle of a cell."""
    column, row = divmod(at, cells.rows)
    return (cells.left + column + 0.5) * cells.width, (cells.low + row + 0.5) * cells.height


def reached(count: int, cells: Cells) -> set[int]:
    """All cells of the boxes that `successors` has left."""
    found: set[int] = set()
    for i in range(count):
        first, last, under, over = cells.boxes[4 * i : 4 * i + 4]
        found |= {column * cells.rows + row for column in range(first, last + 1) for row in range(under, over + 1)}
    return found


def scenes(count: int) -> Iterator[tuple[Random, GeneralKnob]]:
    """Knobs of many kinds: ringing and creeping, fast and slow, with steps, limits, detents and other roundings."""
    for number in range(count):
        chance = Random(f"cells {number}")
        hand = {
            "inertia": 3e-7,
            "damping": 10.0 ** chance.uniform(-4.3, -2),
            "stiffness": 10.0 ** chance.uniform(-2, 0),
        }
        parts: dict[str, Any] = {"hand": hand, "wall": {"stiffness": chance.uniform(0.05, 2.0)}}
        if number % 3 == 0:
            parts["encoder"] = {"rounding": chance.choice(["ceil", "truncate", "nearest"]), "offset_counts": 0.3}
        if number % 4 == 1:
            parts["actuator"] = {"torque_limit": 3e-3, "torque_step": 2e-4}
        if number % 5 == 2:
            parts["detents"] = {"per_revolution": 60, "torque": 2e-3}
        jitter, rate = chance.choice([0.02, 0.3, 0.9]), chance.choice([150.0, 1000.0, 5000.0])
        yield chance, knob_of(with_clock(scene(**parts), jitter), rate, 512)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("fineness", [1, 8, 64])
def test_successors_hold_the_next_state_of_every_motion(fineness: int) -> None:
    """From corners, sides and within, after the shortest, the longest and other intervals; where a hold goes, too."""
    tried = 0
    for chance, knob in scenes(40):
        body, wall = knob.body, as_list(knob.wall)
        cells = grid_of(body, wall, fineness, far=400, whole=False)._replace(rows=2 * round(60.0 * fineness))
        cells = cells._replace(low=-cells.rows // 2)
        for _ in range(12):
            x = chance.uniform(-4.0, 4.0)
            v = chance.uniform(-20.0, 20.0) * cells.height
            column, row = round(x / cells.width) - cells.left, round(v / cells.height) - cells.low
            at = column * cells.rows + row
            x, v = middle(at, cells)
            shown = read(x, wall)
            u = command(shown, shown, wall)
            least, most = hold_range(at, cells, body, wall)
            count = successors(at, cells, body, wall)
            if count == CAPTURED:
                continue
            there = reached(count, cells)
            for _ in range(20):
                across, up = chance.choice([-0.5, 0.5, chance.uniform(-0.5, 0.5)]), chance.choice([-0.5, 0.5, 0.0])
                begin, pace = x + across * cells.width, v + up * cells.height
                t = chance.choice([cells.shortest, 1.0, chance.uniform(cells.shortest, 1.0)])
                s, g, f = hold_coefficients(body.alpha, body.beta, t)
                y = u + body.drive - body.beta * begin
                then = begin + s * pace + g * y
                speed = f * pace + s * y
                assert least <= then <= most
                columns = int(np.floor(then / cells.width)) - cells.left
                rows = int(np.floor(speed / cells.height)) - cells.low
                if 0 <= columns < cells.columns and 0 <= rows < cells.rows:
                    assert columns * cells.rows + rows in there
                    tried += 1
    assert tried > 3000


def test_successors_are_not_much_more_than_that() -> None:
    """Area of all boxes, over that of a fine net of states: roundings out are a few cells."""
    knob = knob_of(with_clock(scene(), 0.3))
    body, wall = knob.body, as_list(knob.wall)
    cells = grid_of(body, wall, 32)
    at = (round(-0.7 / cells.width) - cells.left) * cells.rows + round(0.2 / cells.height) - cells.low
    there = reached(successors(at, cells, body, wall), cells)
    x, v = middle(at, cells)
    y = command(-1.0, -1.0, wall) + body.drive - body.beta * x
    seen = set()
    for t in np.linspace(cells.shortest, 1.0, 4000):
        s, g, f = hold_coefficients(body.alpha, body.beta, float(t))
        then, speed = x + s * v + g * y, f * v + s * y
        seen.add((int(then // cells.width) - cells.left) * cells.rows + int(speed // cells.height) - cells.low)
    assert seen <= there
    assert len(there) <= 8 * len(seen)


def test_a_box_rests_where_its_farthest_corner_is_within_the_gap() -> None:
    """And not where it is beyond it by a thousandth."""
    hand = {"inertia": 3e-7, "damping": 3e-3, "stiffness": 0.3}
    knob = knob_of(with_clock(scene(bias={"torque": 2e-3}, hand=hand), 0.3))
    body, wall = knob.body, as_list(knob.wall)
    found = 0
    for level in range(-8, 0):
        shown = float(level)
        u = command(shown, shown, wall)
        rest = (u + body.drive) / body.beta
        gap = edge_gap(rest, shown, shown, wall)
        if gap <= 0.0:
            continue
        found += 1
        for rx, rv in ((0.0, 0.0), (0.1 * gap, 0.0), (0.05 * gap, 0.1 * gap * sqrt(body.beta))):
            for share in (0.2, 0.7):
                x = rest - share * gap
                far = share * gap + rx
                v = sqrt(body.beta * max(0.0, (0.999 * gap) ** 2 - far * far)) - rv
                if v <= 0.0:
                    continue
                assert rests(x, v, rx, rv, u, shown, body, wall)
                v = sqrt(body.beta * ((1.001 * gap) ** 2 - far * far)) - rv
                assert not rests(x, v, rx, rv, u, shown, body, wall)
                assert not rests(x, -v, rx, rv, u, shown, body, wall)
    assert found > 0


def test_roundings_are_bounded_by_the_size_of_all_terms() -> None:
    """So large as is written, in numbers that a double holds."""
    assert rounded(-2.0, 4.0, 8.0, -16.0, Still(1.0, -32.0)) == SLACK * 63.0
    # A rest at -1/2 in the count below 0, and a state at rest beside it: the gap is 1/2.
    wall = as_list(knob_of(with_clock(scene(), 0.3)).wall)
    one, two, four = (1.0, -0.5, 0.0, 2.0), (1.0, -1.5, 1.0, 4.0), (0.5, -1.25, 1.0, 6.0)
    for beta, u, drive, size in (one, two, four, (1.0, 0.5, -1.0, 3.0)):
        for part, found in ((0.98, False), (1.02, True)):
            x = -1.0 + part * size * SLACK
            assert rests(x, 0.0, 0.0, 0.0, u, -1.0, Still(beta, drive), wall) == found


def test_a_box_whose_motions_may_come_to_the_edge_does_not_rest() -> None:
    """In exact numbers: a gap of 1/2, of which all but ``2 SLACK`` is the way, and that what roundings may add."""
    wall = as_list(knob_of(with_clock(scene(), 0.3)).wall)
    still, u = Still(1.0, SLACK), -0.5 - SLACK
    for more, found in ((0.0, False), (2.0**-50, True)):
        assert rests(-1.0 + 2.0 * SLACK + more, 0.0, 0.0, 0.0, u, -1.0, still, wall) == found


def test_a_box_that_stays_comes_into_those_beside_it() -> None:
    """Its sides are theirs, and a rounding decides: a state on a side is in both."""
    wall = as_list(knob_of(with_clock(scene(), 0.3)).wall)._replace(kappa=0.0)
    parts = [0.0, 0.0, 1.0] * (2**LEVELS - 1 + HOLD)
    cells = Cells(0.25, 0.25, -8, -8, 16, 16, 1.0, True, parts, [0] * BOXES)
    for at in (5 * 16 + 6, 16 + 1, 14 * 16 + 14):  # up to the first and the last of a grid that no motion leaves
        assert reached(successors(at, cells, Still(1.0, 0.0), wall), cells) == {
            at + column * 16 + row for column in (-1, 0, 1) for row in (-1, 0, 1)
        }
    for side in (5, 5 * 16, 5 * 16 + 15, 15 * 16 + 6):
        assert successors(side, cells, Still(1.0, 0.0), wall) == LEAVES
        inside = cells._replace(whole=False)
        there = reached(successors(side, inside, Still(1.0, 0.0), wall), inside)
        assert there <= set(range(16 * 16))
        assert len(there) == 6


class Hand(NamedTuple):
    """A box, and what moves it: numbers that a double and a fraction both hold."""

    width: float
    height: float
    v: float  # in the middle of the box
    alpha: float
    beta: float
    drive: float
    shortest: float


HANDS = (
    # Boxes that are wide, and low: what positions add to speeds is seen to a 2^-24th. Then high and narrow ones.
    Hand(1.0, 2.0**-24, 5.0, 4.0, 2.0, -2.0, 0.5),
    Hand(1.0, 2.0**-24, -5.0, 0.5, 4.0, -7.0, 0.75),
    Hand(2.0**-24, 1.0, 2.5, 3.0, 2.0, -1.0, 0.5),
    Hand(2.0**-24, 1.0, -1.5, 2.0, 0.5, -6.0, 0.25),
    # As few parts as will do: of the speed, and of its rate.
    Hand(0.25, 1.0, 0.5, 0.25, 0.5, -2.5, 0.5),
    Hand(1.0, 0.25, 0.125, 0.25, 0.5, -2.5, 0.5),
    Hand(1.0, 1.0, 0.5, 0.25, 0.5, -2.5, 0.75),
    Hand(1.0, 1.0, 6.5, 0.125, 0.125, -2.125, 0.5),  # 4 parts to the bit: half an interval at a speed of 8
)


def hull_in_fractions(hand: Hand, x: float, u: float, parts: list[float]) -> tuple[list[Any], tuple[Any, Any]]:
    """In exact numbers: bounds on position and speed in each part of the interval, and on the position in a hold.

    A state in the box is ``dx`` and ``dv`` from its middle. Within a hold the speed never exceeds that of the energy:
    |f| and |s| are 1 at most. Taylor's formula about the middle of a part, with the second derivative's bound, holds
    over half the part's length.
    """
    alpha, beta, v = Fraction(hand.alpha), Fraction(hand.beta), Fraction(hand.v)
    dx, dv, at = Fraction(hand.width) / 2, Fraction(hand.height) / 2, Fraction(x)
    force = Fraction(u) + Fraction(hand.drive)
    y = force - beta * at
    fast = abs(v) + dv + abs(y) + beta * dx
    hard = abs(y) + beta * dx + (alpha + beta) * fast
    jerk = beta * fast + alpha * hard
    wide = (1 + abs(at) + fast + hard + abs(Fraction(u)) + abs(Fraction(hand.drive))) / 2**32
    free = 1 - Fraction(hand.shortest)
    need = free * max(fast / Fraction(hand.width), hard / Fraction(hand.height))
    count = next(2**level for level in range(LEVELS) if 2**level >= need or level == LEVELS - 1)
    found = []
    for i in range(count):
        s, g, f = map(Fraction, parts[3 * (count - 1 + i) : 3 * (count + i)])
        half = free / count / 2
        place, pace = at + s * v + g * y, f * v + s * y
        off, more = abs(1 - beta * g) * dx + abs(s) * dv, beta * abs(s) * dx + abs(f) * dv
        off += half * (abs(pace) + more) + half * half * hard
        more += half * (abs(force - beta * place - alpha * pace) + beta * off + alpha * more) + half * half * jerk
        found.append((place - off - wide, place + off + wide, pace - more - wide, pace + more + wide))
    least, most, half = at - dx, at + dx, Fraction(1, 2 * HOLD)
    for i in range(HOLD):
        s, g, f = map(Fraction, parts[3 * (2**LEVELS - 1 + i) : 3 * (2**LEVELS + i)])
        off = abs(1 - beta * g) * dx + abs(s) * dv + wide + half * half * hard
        off += half * (abs(f * v + s * y) + beta * abs(s) * dx + abs(f) * dv)
        least, most = min(least, at + s * v + g * y - off), max(most, at + s * v + g * y + off)
    return found, (least, most)


@pytest.mark.parametrize("hand", HANDS)
@pytest.mark.parametrize("seed", range(3))
def test_bounds_are_those_of_exact_numbers(hand: Hand, seed: int) -> None:
    """Of any S, G and F: the boxes to the last, and where a hold goes."""
    chance = Random(seed)
    parts = [chance.randrange(-16, 17) / 16.0 for _ in range(3 * (2**LEVELS - 1 + HOLD))]
    wall = as_list(knob_of(with_clock(scene(), 0.3)).wall)._replace(kappa=3.0)
    left, low, rows = -(2**30), -(2**30), 2**31
    cells = Cells(hand.width, hand.height, left, low, 2**31, rows, hand.shortest, False, parts, [0] * BOXES)
    at = (floor(-0.5 / hand.width) - left) * rows + floor(hand.v / hand.height) - low
    x, v = middle(at, cells)
    body = Still(hand.beta, hand.drive, hand.alpha)
    bounds, hold = hull_in_fractions(hand._replace(v=v), x, 3.0, parts)
    assert successors(at, cells, body, wall) == len(bounds)
    for i, (least, most, slowest, fastest) in enumerate(bounds):
        assert cells.boxes[4 * i : 4 * i + 4] == [
            floor(least / Fraction(hand.width)) - left,
            floor(most / Fraction(hand.width)) - left,
            floor(slowest / Fraction(hand.height)) - low,
            floor(fastest / Fraction(hand.height)) - low,
        ]
    assert hold_range(at, cells, body, wall) == pytest.approx(tuple(map(float, hold)), rel=2.0**-49)


@pytest.mark.parametrize("v", [0.5, -0.5])
def test_a_hold_begins_in_its_box(v: float) -> None:
    """One that comes out of it on one side at once: the other side is the box's own."""
    parts = [2.0, 1.0, 1.0] * (2**LEVELS - 1 + HOLD)
    cells = Cells(0.25, 0.25, -8, -8, 16, 16, 1.0, True, parts, [0] * BOXES)
    at = 5 * 16 + floor(v / 0.25) + 8
    x, _ = middle(at, cells)
    wall = as_list(knob_of(with_clock(scene(), 0.3)).wall)._replace(kappa=0.0)
    low, high = hold_range(at, cells, Still(1.0, x), wall)  # nothing pulls in the middle of the box
    assert (low if v > 0.0 else high) == (x - 0.125 if v > 0.0 else x + 0.125)
    assert low + 0.5 < high


def made(graph: dict[int, list[int]], monkeypatch: pytest.MonkeyPatch) -> Cells:
    """A row of ten boxes with these successors."""
    cells = Cells(1.0, 1.0, 0, 0, 10, 1, 1.0, True, [], [0] * BOXES)

    def follow(at: int, cells: Cells, body: Any, wall: Any) -> int:
        for i, then in enumerate(graph[at]):
            cells.boxes[4 * i : 4 * i + 4] = [then, then, 0, 0]
        return len(graph[at])

    monkeypatch.setattr(clock_cells, "successors", follow)
    return cells


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("queue", "spans", "widest"),
    [
        # Two circles, 1 and 2, 5 and 6, which lead to 3, where nothing stays: they are not connected.
        ([1, 2, 5, 6], {1: (0.0, 0.5), 2: (-0.25, 0.25), 5: (10.0, 10.5), 6: (10.125, 10.375)}, 0.75),
        ([1, 2, 5, 6], {1: (0.0, 5.0), 2: (-3.0, 2.0), 5: (10.0, 13.0), 6: (11.0, 12.0)}, 8.0),
        ([5, 6, 1, 2], {1: (0.0, 1.0), 2: (0.5, 2.0), 5: (10.0, 13.0), 6: (11.0, 12.0)}, 3.0),
    ],
)
def test_the_widest_range_is_that_of_what_is_connected(
    queue: list[int],
    spans: dict[int, tuple[float, float]],
    widest: float,
    *,
    turned: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cells = made({1: [2, 3], 2: [1, 3], 5: [6, 3], 6: [3, 5]}, monkeypatch)
    if turned:
        spans = {at: (-high, -low) for at, (low, high) in spans.items()}
    monkeypatch.setattr(clock_cells, "hold_range", lambda at, *_: spans[at])
    for order in (queue, queue[::-1], [queue[1], queue[0], *queue[2:]]):
        state = [THERE if at in queue else UNSEEN for at in range(10)]
        joined = Joined([0] * 10, [0] * 10, [0.0] * 4, [0.0] * 4)
        assert widest_range(state, order, 4, joined, cells, None, None) == widest


def test_what_a_motion_has_left_takes_nothing_along(monkeypatch: pytest.MonkeyPatch) -> None:
    """1 leads to 3, which is no cell of motions that go on, and so is not asked where it leads: 5 and 6 are left."""
    for outside in (UNSEEN, RESTS):
        cells = made({1: [3], 3: [5], 5: [6], 6: [5]}, monkeypatch)
        state = [outside if at == 3 else THERE if at in (1, 5, 6) else UNSEEN for at in range(10)]
        queue: list[Any] = [1, 5, 6, *[9] * 3]
        still: Any = Still(1.0, 0.0)
        assert trim_cells(state, queue, 3, [0] * 10, cells, still, None) == (2, 4)
        assert queue[:2] == [5, 6]
        assert [at for at in range(10) if state[at] == THERE] == [5, 6]


def graph_of(knob: GeneralKnob, cells: Cells, begun: list[int]) -> dict[int, set[int]]:
    """All cells that are reached, and the successors of those from which a motion need not rest."""
    edges: dict[int, set[int]] = {}
    left = list(begun)
    while left:
        at = left.pop()
        if at in edges:
            continue
        count = successors(at, cells, knob.body, knob.wall)
        assert count != LEAVES
        edges[at] = set() if count == CAPTURED else reached(count, cells)
        left += edges[at]
    return edges


def recurrent(edges: dict[int, set[int]]) -> set[int]:
    """Cells to which a circle leads: those that are left when all without a predecessor are taken away, in rounds."""
    there = set(edges)
    while True:
        after = {then for at in there for then in edges[at]} & there
        if after == there:
            return there
        there = after


def ringed(bias: float) -> tuple[GeneralKnob, Cells, list[int]]:
    """A knob with a firm hand, in lists, a grid, and a cell to begin with."""
    hand = {"inertia": 3e-7, "damping": 1.2e-3, "stiffness": 0.3}
    knob = knob_of(with_clock(scene(bias={"torque": bias}, hand=hand), 0.2))
    cells = grid_of(knob.body, knob.wall, 8)
    begun = (round(1.3 / cells.width) - cells.left) * cells.rows + round(-0.05 / cells.height) - cells.low
    return knob._replace(wall=as_list(knob.wall)), cells, [begun]


def follow_cells(
    functions: dict[str, Any], body: Body, wall: Controller, cells: Cells, begun: list[int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Cells that are reached, those that rest, those that are left, and the widest range."""
    size = cells.columns * cells.rows
    state, queue = np.zeros(size, np.int8), np.zeros(2 * size, np.int64)
    state[begun], queue[: len(begun)] = THERE, begun
    filled, _ = functions["general.reach_cells"](state, queue, len(begun), 10**9, cells, body, wall)
    found, resting, degree = queue[:filled].copy(), np.flatnonzero(state == RESTS), np.zeros(size, np.int64)
    left, _ = functions["general.trim_cells"](state, queue, filled, degree, cells, body, wall)
    assert set(np.flatnonzero(state == THERE).tolist()) == set(queue[:left].tolist())
    assert np.count_nonzero(state != UNSEEN) == left
    joined = Joined(np.zeros(size, np.int64), degree, np.zeros(left), np.zeros(left))
    widest = functions["general.widest_range"](state, queue, left, joined, cells, body, wall)
    return found, resting, queue[:left].copy(), widest


PLAIN: dict[str, Any] = {f"general.{one.__name__}": one for one in (reach_cells, trim_cells, widest_range)}


@pytest.mark.parametrize("bias", [1e-3, 1.8e-3, 2.2e-3])
def test_the_graph_is_trimmed_as_another_way_does(bias: float) -> None:
    """What is reached, what is left, and the widest range of what is connected."""
    knob, cells, begun = ringed(bias)
    edges = graph_of(knob, cells, begun)
    there = recurrent({at: {one for one in then if edges[one]} for at, then in edges.items() if then})
    assert len(edges) > 100
    assert any(not then for then in edges.values()) == (bias == 2.2e-3)
    found, resting, left, widest = follow_cells(PLAIN, knob.body, knob.wall, cells, begun)
    assert set(found.tolist()) == set(edges)
    assert set(resting.tolist()) == {at for at, then in edges.items() if not then}
    assert set(left.tolist()) == there
    assert widest == connected_range(knob, cells, edges, there)
    assert (widest > 0.0) == bool(there)


@pytest.mark.parametrize("bias", [1.8e-3, 2.2e-3])
def test_visits_are_counted_and_limited(bias: float) -> None:
    """A visit is a cell of a box of successors; what lies in the queue behind those that are filled is not read."""
    knob, cells, begun = ringed(bias)
    edges = graph_of(knob, cells, begun)
    there = recurrent({at: {one for one in then if edges[one]} for at, then in edges.items() if then})
    areas: dict[int, int] = {}
    for at, then in edges.items():
        count = successors(at, cells, knob.body, knob.wall) if then else 0
        boxes = [cells.boxes[4 * i : 4 * i + 4] for i in range(count)]
        areas[at] = sum((last - first + 1) * (over - under + 1) for first, last, under, over in boxes)
    whole, size = sum(areas.values()), cells.columns * cells.rows

    def reach(most: int, halt: float = 0.0) -> tuple[int, int, list[int], list[int]]:
        state, queue = [UNSEEN] * size, [next(iter(there))] * (2 * size)
        state[begun[0]], queue[0] = THERE, begun[0]
        body = knob.body._replace(halt=[halt])
        return *reach_cells(state, queue, 1, most, cells, body, knob.wall), state, queue

    filled, visits, state, queue = reach(whole)
    assert (filled, visits) == (len(edges), whole)
    before = whole - areas[queue[filled - 1]]  # the last is asked for its successors after so many
    assert reach(before)[:2] == (len(edges), whole)
    assert reach(before - 1)[:2] == (-1, before)
    assert reach(whole, 0.5)[:2] == (-1, 0)
    halted = knob.body._replace(halt=[0.5])
    assert trim_cells(state, list(queue), filled, [0] * size, cells, halted, knob.wall) == (-1, 0)
    gone = sum(areas[at] for at in edges if at not in there)
    kept, visits = trim_cells(state, queue, filled, [0] * size, cells, knob.body, knob.wall)
    assert (kept, visits) == (len(there), whole + gone)
    assert set(queue[:kept]) == there


def connected_range(knob: GeneralKnob, cells: Cells, edges: dict[int, set[int]], there: set[int]) -> float:
    """The widest range of cells that are connected, either way."""
    beside: dict[int, set[int]] = {at: set() for at in there}
    for at in there:
        for then in edges[at] & there:
            beside[at].add(then)
            beside[then].add(at)
    widest, left = 0.0, set(there)
    while left:
        group, new = set(), {left.pop()}
        while new:
            group |= new
            new = {then for at in new for then in beside[at]} - group
        left -= group
        spans = [hold_range(at, cells, knob.body, knob.wall) for at in group]
        widest = max(widest, max(span[1] for span in spans) - min(span[0] for span in spans))
    return widest


def test_a_grid_that_motions_leave_says_so() -> None:
    knob = knob_of(with_clock(scene(), 0.2))
    body, wall = knob.body, as_list(knob.wall)
    cells = grid_of(body, wall, 4, far=1)
    at = cells.rows // 2  # the deepest column, at rest
    size = cells.columns * cells.rows
    assert successors(cells.rows - 1 + (cells.columns - 1) * cells.rows, cells, body, wall) == LEAVES
    state, queue = [0] * size, [0] * (2 * size)
    state[at], queue[0] = THERE, at
    filled, visits = reach_cells(state, queue, 1, 10**9, cells, body, wall)
    assert filled == -1
    assert visits < 1000


def test_starts_hold_the_first_sample_at_any_time() -> None:
    knob = knob_of(with_clock(scene(), 0.2))
    body = knob.body
    start = [2.0, -0.7]
    regions = every_clock.start_regions(body, start)
    assert len(regions) == every_clock.START_PARTS
    for t in np.linspace(0.0, 1.0, 5001):
        s, g, f = hold_coefficients(body.alpha, body.beta, float(t))
        y = body.drive - body.beta * start[0]
        x, v = start[0] + s * start[1] + g * y, f * start[1] + s * y
        part = regions[min(int(t * len(regions)), len(regions) - 1)]
        assert part.left <= x <= part.right
        assert part.low <= v <= part.high
    assert every_clock.start_region([[0.0, -1.0], [2.0, 3.0]]) == [every_clock.Region(0.0, 2.0, -1.0, 3.0)]


@pytest.mark.parametrize("rounding", ["floor", "ceil"])
def test_a_start_on_a_counts_edge_is_in_the_boxes_of_both_sides(rounding: str) -> None:
    """Whichever way the encoder rounds, one of them has the command of that very state."""
    knob = knob_of(with_clock(scene(encoder={"rounding": rounding}), 0.2))
    seen = []

    def note(state: Any, queue: Any, filled: int, most: int, cells: Cells, body: Body, wall: Controller) -> Any:
        seen.append({middle(at, cells)[0] // 1.0 for at in queue[:filled].tolist()})
        assert float(read(-2.0, wall)) in {float(read(count + 0.5, wall)) for count in seen[-1]}
        return -1, 0

    bound = every_clock.ClockBound(dict(PLAIN, **{"general.reach_cells": note}), knob.body, knob.wall)
    region = every_clock.start_region([[-2.0, 0.01], [-1.5, 0.02]])
    assert bound.range(region) is None
    assert seen == [{-3.0, -2.0}] * every_clock.TRIES
