"""The bound for every clock, step by step: grids, starts and halved cells by hand; passes are written down."""

from collections.abc import Callable
from fractions import Fraction
from math import ceil, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general import every_clock
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.clock_cells import HOLD, LEVELS, THERE, Joined
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.every_clock import (
    GROWS,
    MOST_VISITS,
    START_PARTS,
    TRIES,
    ClockBound,
    Region,
    is_bounded,
    parts_of,
    start_region,
    start_regions,
)

from .bodies import knob
from .test_controller import wall

# Springs of 1/4 of the hand and 2 of the wall, a push of 1/2.
BODY = knob().body._replace(order=2, friction=0.0, alpha=0.5, beta=0.25, push=0.5, drive=-0.5, halt=[0.0])
WALL = wall(clock=[0.0, 0.5, 0.5, 0.0, 0.0, 0.75])
FEW = 100_000  # boxes of a grid, here


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(every_clock, "MOST_CELLS", FEW)


def test_what_every_clock_is_followed_for() -> None:
    """Angle and speed, damped and held by a spring; a torque that follows from the last reading alone."""
    assert is_bounded(BODY, WALL, 0)
    assert is_bounded(BODY._replace(alpha=1e-9, beta=1e-9), WALL, 0)
    others: list[tuple[Body, Controller, int]] = [
        *((BODY._replace(**{name: value}), WALL, 0) for name, value in (
            ("order", 3), ("friction", 1e-9), ("friction", 2.0), ("alpha", 0.0), ("beta", 0.0), ("cogs", [1.0] * 6),
        )),
        *((BODY, WALL._replace(**{name: 0.5}), 0) for name in ("hysteresis", "damping", "analog")),
        (BODY, WALL, 1),
    ]  # fmt: skip
    assert not any(is_bounded(*one) for one in others)


@pytest.mark.parametrize("shortest", [0.5, 0.9, 1.0])
def test_parts_have_the_motion_in_the_middle_of_each(shortest: float) -> None:
    """Against the matrix exponential: 1, 2, 4, ... parts of the intervals that may be, then those of a hold."""
    parts = parts_of(BODY, shortest).reshape(-1, 3)
    times = [
        shortest + (1.0 - shortest) * (2 * i + 1) / 2 ** (level + 1) for level in range(LEVELS) for i in range(2**level)
    ]
    times += [(2 * i + 1) / (2.0 * HOLD) for i in range(HOLD)]
    assert len(parts) == len(times)
    rates = np.array([[0.0, 1.0, 0.0], [-BODY.beta, -BODY.alpha, 1.0], [0.0, 0.0, 0.0]])
    for found, time in list(zip(parts, times, strict=True))[:: 1 if shortest == 0.5 else 17]:
        whole = expm(rates * time)
        np.testing.assert_allclose(found, [whole[0, 1], whole[0, 2], whole[1, 1]], rtol=1e-13)


@pytest.mark.parametrize("start", [(2.0, -0.75), (-3.0, 1.5), (0.5, 0.0)])
def test_a_start_is_where_the_first_sample_may_be(monkeypatch: pytest.MonkeyPatch, start: tuple[float, float]) -> None:
    """In exact numbers: half a part before and after its middle, at a speed and a rate that are bounded."""
    monkeypatch.setattr(every_clock, "START_PARTS", 4)
    asked: list[float] = []

    def coefficients(alpha: float, beta: float, time: float) -> tuple[float, float, float]:
        assert (alpha, beta) == (0.5, 0.25)
        asked.append(time)
        return 0.75 * time, -0.5 * time, 1.0 - time

    monkeypatch.setattr(every_clock, "hold_coefficients", coefficients)
    found = start_regions(BODY, start)
    assert asked == [0.125, 0.375, 0.625, 0.875]
    x, v = map(Fraction, start)
    y = Fraction(-0.5) - x / 4
    fast = abs(v) + abs(y)
    hard = abs(y) + Fraction(3, 4) * fast
    wide = (1 + abs(x) + fast + hard + Fraction(1, 2)) / 2**32
    for time, one in zip(map(Fraction, asked), found, strict=True):
        place, pace = x + Fraction(3, 4) * time * v - time / 2 * y, (1 - time) * v + Fraction(3, 4) * time * y
        off, more = (abs(pace) + hard / 8) / 8 + wide, hard / 8 + wide
        expected = Region(*map(float, (place - off, place + off, pace - more, pace + more)))
        assert one == pytest.approx(expected, rel=1e-14)
    assert START_PARTS == 2048


def test_starts_at_a_sample_are_all_between_them() -> None:
    states = [[1.0, 5.0], [-2.0, 3.0], [0.0, -4.0]]
    assert start_region(states) == [Region(-2.0, 1.0, -4.0, 5.0)]


class Passes:
    """Passes over cells that are written down; the grids that they are asked for are noted."""

    def __init__(
        self,
        *,
        reach: Callable[[int], tuple[int, int]] = lambda filled: (-1, 10),
        trim: Callable[[Any, int], tuple[int, int]] = lambda queue, filled: (0, 100),
        widest: Callable[[int], float] = lambda grid: 1.0,
        body: Body = BODY,
    ) -> None:
        self._reach, self._trim, self._widest = reach, trim, widest
        self.body = body._replace(halt=[0.0])
        self.grids: list[Any] = []  # of reach
        self.begun: list[set[tuple[float, float]]] = []  # corners of cells that motions begin in
        self.fine: list[Any] = []  # of trim
        self.kept: list[set[tuple[float, float]]] = []
        self.bound = ClockBound(
            {"general.reach_cells": self.reach, "general.trim_cells": self.trim, "general.widest_range": self.widest},
            self.body,
            WALL,
        )

    def reach(
        self, state: Any, queue: Any, filled: int, most: int, cells: Any, body: Any, wall: Any
    ) -> tuple[int, int]:
        assert (most, body, wall, cells.whole) == (MOST_VISITS, self.body, WALL, True)
        assert len(state) == cells.columns * cells.rows
        assert len(queue) == 2 * len(state)
        assert {int(at) for at in queue[:filled]} == {int(at) for at in np.flatnonzero(state == THERE)}
        self.grids.append(cells)
        self.begun.append(corners(queue[:filled], cells))
        return self._reach(filled)

    def trim(self, state: Any, queue: Any, filled: int, degree: Any, cells: Any, *given: Any) -> tuple[int, int]:
        assert given == (self.body, WALL)
        assert not degree.any()
        assert len(degree) == len(state) == cells.columns * cells.rows
        assert len(queue) >= 2 * filled
        self.fine.append(cells)
        self.kept.append(corners(queue[:filled], cells))
        if len(self.fine) > 1:
            assert not cells.whole
            assert {int(at) for at in queue[:filled]} == {int(at) for at in np.flatnonzero(state == THERE)}
        return self._trim(queue, filled)

    def widest(self, state: Any, queue: Any, filled: int, joined: Joined, *given: Any) -> float:
        assert [len(one) for one in joined] == [len(state), len(state), filled, filled]
        assert given == (self.fine[-1], self.body, WALL)
        return self._widest(len(self.fine) - 1)


def corners(queue: Any, cells: Any) -> set[tuple[float, float]]:
    """Lower left corners of cells."""
    return {
        ((cells.left + int(at) // cells.rows) * cells.width, (cells.low + int(at) % cells.rows) * cells.height)
        for at in queue
    }


SMALL = [Region(-1.0, 0.5, -0.25, 0.25)]


def test_grids_are_as_large_as_starts_and_springs_ask_for() -> None:
    """One and a half times; three of them, each twice as large both ways. Boxes of a part of a count; 1/2 as high."""
    for regions, push, far, speed in (
        (SMALL, 0.5, 3.0, 0.25),
        ([Region(-4.0, 0.5, -0.25, 0.25)], 0.5, 6.0, 0.25),
        ([Region(-1.0, 8.0, -0.25, 0.25)], 0.5, 12.0, 0.25),
        ([*SMALL, Region(-1.0, 8.0, -5.0, 0.25)], 0.5, 12.0, 5.0),
        ([Region(-1.0, 0.5, -0.25, 7.0), *SMALL], 0.5, 3.0, 7.0),
        (SMALL, 9.0, 6.0, 0.25),  # 9 / (1/4 + 2) is 4
    ):
        passes = Passes(body=BODY._replace(push=push))
        assert passes.bound.range(regions) is None
        assert passes.bound.visits == 10 * TRIES
        fast = 1.5 * (speed + far * 1.5)  # of a spring of 9/4
        for k, cells in enumerate(passes.grids):
            wide, high = far * 2**k, fast * 2**k
            fineness = round(1.0 / cells.width)
            assert fineness & (fineness - 1) == 0
            assert cells.height == 0.5 * cells.width
            # As fine as the number of cells allows: twice as fine there would be too many.
            assert (cells.columns, cells.rows) == (2 * ceil(wide * fineness), 2 * ceil(2.0 * high * fineness))
            assert (cells.left, cells.low) == (-cells.columns // 2, -cells.rows // 2)
            assert cells.columns * cells.rows <= FEW <= 4 * cells.columns * cells.rows
            assert cells.shortest == 0.5
            assert len(cells.boxes) == 4 * 2 ** (LEVELS - 1)
            assert len(cells.parts) == 3 * (2**LEVELS - 1 + HOLD)
        assert len(passes.grids) == TRIES
    assert TRIES == 3


def test_motions_begin_in_all_boxes_of_their_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A place on a side is in both boxes; a speed in the one that it begins."""
    monkeypatch.setattr(every_clock, "MOST_CELLS", 1500)
    regions = [Region(-1.0, 0.4, -0.5, 0.6), Region(1.1, 1.2, 1.0, 1.0)]
    passes = Passes()
    passes.bound.range(regions)
    for cells, begun in zip(passes.grids, passes.begun, strict=True):
        expected = {
            (i * cells.width, j * cells.height)
            for i in range(-40, 40)
            for j in range(-80, 80)
            for one in regions
            if i * cells.width <= one.right
            and (i + 1) * cells.width >= one.left
            and j * cells.height <= one.high
            and (j + 1) * cells.height > one.low
        }
        assert begun == expected


def test_a_grid_of_too_many_boxes_is_none() -> None:
    """As where a count is too wide for it."""
    passes = Passes()
    assert passes.bound.range([Region(-1e4, 0.5, -0.25, 0.25)]) is None
    assert passes.grids == []


def test_a_halt_ends_the_search() -> None:
    passes = Passes()

    def halt(filled: int) -> tuple[int, int]:
        passes.body.halt[0] = 0.5
        return -1, 10

    passes._reach = halt
    assert passes.bound.range(SMALL) is None
    assert len(passes.grids) == 1


def test_where_nothing_is_left_all_come_to_rest() -> None:
    """Where the pass is halted there is no bound."""
    for left, found in ((0, 0.0), (-1, None)):
        passes = Passes(reach=lambda filled: (filled, 10), trim=lambda queue, filled, left=left: (left, 100))
        assert passes.bound.range(SMALL) == found
        assert passes.bound.visits == 110
        assert len(passes.grids) == len(passes.fine) == 1


def test_the_range_is_the_least_of_all_grids() -> None:
    """Each with cells half as wide, as long as a pass costs a sixth of what is allowed."""
    enough = MOST_VISITS // GROWS
    assert enough * GROWS == MOST_VISITS
    for widths, costs, found in (
        ([3.0, 2.0, 2.5], [1, 1, enough + 1], 2.0),
        ([3.0, 4.0, 1.0], [1, enough, enough + 1], 1.0),
        ([3.0, 2.0, 1.0], [enough + 1], 3.0),
        ([3.0, 2.0, 1.0], [1, enough + 1], 2.0),
    ):
        left = list(costs)
        passes = Passes(
            reach=lambda filled: (filled, 10),
            trim=lambda queue, filled, left=left: (1, left.pop(0)),
            widest=lambda grid, widths=widths: widths[grid],
        )
        assert passes.bound.range(SMALL) == found
        assert left == []
        assert passes.bound.visits == 10 + sum(costs)


def test_halved_cells_cover_what_is_left() -> None:
    """Each as four; in a grid just about them, however they lie."""
    chosen: list[set[tuple[float, float]]] = []
    passes = Passes(reach=lambda filled: (filled, 10))

    def trim(queue: Any, filled: int) -> tuple[int, int]:
        cells = passes.fine[-1]
        columns = [3, 5, 6, 7] if len(passes.fine) == 1 else [1, 2, 4]
        rows = [20, 11, 12, 12] if len(passes.fine) == 1 else [0, 3, 5]
        kept = [column * cells.rows + row for column, row in zip(columns, rows, strict=True)]
        queue[: len(kept)] = kept
        chosen.append(corners(kept, cells))
        return len(kept), 1 if len(passes.fine) < 3 else MOST_VISITS

    passes._trim = trim
    assert passes.bound.range(SMALL) == 1.0
    for k in (1, 2):
        before, cells = passes.fine[k - 1], passes.fine[k]
        assert (cells.width, cells.height) == (0.5 * before.width, 0.5 * before.height)
        assert passes.kept[k] == {
            (x + i * cells.width, v + j * cells.height) for x, v in chosen[k - 1] for i in (0, 1) for j in (0, 1)
        }
        xs, vs = zip(*passes.kept[k], strict=True)
        assert (cells.left * cells.width, cells.low * cells.height) == (min(xs), min(vs))
        assert (cells.columns - 1) * cells.width == max(xs) - min(xs)
        assert (cells.rows - 1) * cells.height == max(vs) - min(vs)
        assert cells.shortest == 0.5


def test_cells_that_lie_far_apart_are_halved_as_long_as_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two corners of the grid 4 times as many would be needed."""
    passes = Passes(reach=lambda filled: (filled, 10), widest=lambda grid: 2.0)

    def trim(queue: Any, filled: int) -> tuple[int, int]:
        cells = passes.fine[-1]
        queue[:2] = [0, cells.columns * cells.rows - 1]
        return 2, 1

    passes._trim = trim
    assert passes.bound.range(SMALL) == 2.0
    assert len(passes.fine) == 1
    first = passes.fine[0]
    for room, grids in ((4 * first.columns * first.rows, 2), (4 * first.columns * first.rows - 1, 1)):
        passes.fine.clear()
        passes._reach = lambda filled, room=room: monkeypatch.setattr(every_clock, "MOST_CELLS", room) or (filled, 10)
        monkeypatch.setattr(every_clock, "MOST_CELLS", FEW)
        assert passes.bound.range(SMALL) == 2.0
        assert len(passes.fine) == grids


def test_a_wider_box_is_as_high_as_its_spring_makes_it() -> None:
    """Energy of position and speed are alike in it."""
    passes = Passes(body=BODY._replace(beta=4.0))
    passes.bound.range(SMALL)
    assert passes.grids[0].height == passes.grids[0].width * sqrt(4.0)
