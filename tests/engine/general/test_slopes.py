"""Cogging from corner to corner: against matrix exponentials, event by event, and what is asked for, by hand."""

from functools import cache
from math import inf
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general import slopes
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import (
    CENTRE,
    COGGED,
    COGGED_HALVES,
    FALLEN,
    FREE,
    LENGTH,
    RISEN,
    STABLE,
    TURNED,
    UNSTABLE,
    slope_at,
)
from hknob_cli.engine.general.slope_columns import cog_columns
from hknob_cli.engine.general.slopes import (
    cog_acceleration,
    cog_chart,
    cog_many,
    cog_rate,
    pass_on,
    roll,
    way_from,
)

from .bodies import fresh_marks
from .cogs import SCENES, Cogged, begun, body_of, by_hand

CLOSE = 1e-9  # of the size of the state: far above roundings, far below any event that is missed
SEEDS = range(10)


class Case:
    """One motion over a time of so many 64ths of a sample, and what the exponentials make of it."""

    def __init__(self, name: str, seed: int, *, ways: bool = False) -> None:
        self.body = body_of(name)
        chance = Random(f"{name} {seed}")
        self.z, self.u = begun(self.body, chance)
        self.steps = chance.choice([1, 24, 63, 64, 64, 64])
        self.ways = ways
        self.known = self.begin()
        self.events = self.known.move(self.steps)
        self.end = self.known.state
        self.size = 1.0 + float(np.abs(self.end).max())
        self.pad = [0.0] * (2 * self.body.order)

    def begin(self) -> Cogged:
        return Cogged(self.body, self.z, self.u, ways=self.ways)

    @property
    def span(self) -> float:
        return self.steps / 64.0

    def near(self, found: Any, expected: Any) -> bool:
        n = self.body.order
        return bool(np.abs(np.array(found[:n]) - np.array(expected[:n])).max() <= CLOSE * self.size)


@cache
def case_of(name: str, seed: int, ways: bool) -> Case:
    return Case(name, seed, ways=ways)


@pytest.mark.parametrize("name", SCENES)
def test_rates_are_those_of_the_torques(name: str) -> None:
    """On both kinds of slope; held, sliding, and free."""
    body = body_of(name)
    for seed in SEEDS:
        case = case_of(name, seed, False)
        known = case.begin()
        slope = slope_at(case.z[0], body.cogs)
        assert slope == known.slope
        for known.slope in (slope, slope + 1.0, slope - 2.0):
            pull = known.pull() @ known.z
            size = 1e-12 * (1.0 + np.abs(known.pull() * known.z).sum())
            assert cog_acceleration(case.z, case.u, known.slope, body) == pytest.approx(pull, abs=size)
            for mode in (FREE, 1, -1, 0):
                known.mode = mode
                out = [0.0] * body.order
                cog_rate(case.z, case.u, known.slope, mode, body, out)
                a = known.rates()
                sizes = 1e-12 * (1.0 + (np.abs(a) @ np.abs(known.z))[:-2])
                assert (np.abs(out - (a @ known.z)[:-2]) <= sizes).all()


@pytest.mark.parametrize("name", SCENES)
def test_a_motion_and_its_chart_go_from_event_to_event(name: str) -> None:
    """The same ends, in the same order; a chart has a piece for each, with its mode, and stops where its rows do."""
    events = 0
    for seed in SEEDS:
        case = case_of(name, seed, True)
        body, n = case.body, case.body.order
        z = list(case.z)
        cog_many(body.cogs, z, case.u, case.span, body, case.pad)
        assert case.near(z, case.end)
        events += len(case.events)
        pieces = SimpleNamespace(spans=[0.0] * 60, modes=[9] * 60, commands=[0.0] * 60, states=[0.0] * (61 * n))
        z = list(case.z)
        rows = cog_chart(body.cogs, z, case.u, case.span, body, case.pad, 2, pieces)
        assert case.near(z, case.end)
        assert pieces.states[rows * n : rows * n + n] == z
        assert sum(pieces.spans) == pytest.approx(case.span, rel=1e-12)
        assert pieces.commands == [0.0] * 2 + [case.u] * (rows - 2) + [0.0] * (60 - rows)
        starts = [0.0, *(one.time for one in case.events)]
        modes = [case.begin(), *case.events]
        seen = np.cumsum(pieces.spans[2:rows])
        assert all(min(abs(t - one) for one in [*starts, case.span]) < 1e-9 for t in seen)
        for row in range(2, rows):
            if pieces.spans[row] > 1e-9:
                at = 0.0 if row == 2 else seen[row - 3]
                now = next(mode for mode, one in reversed(list(zip(modes, starts, strict=True))) if one < at + 1e-9)
                assert pieces.modes[row] == now.mode * (STABLE if now.slope % 2.0 == 0.0 else UNSTABLE)
        full = SimpleNamespace(spans=[0.0] * 3, modes=[0] * 3, commands=[0.0] * 3, states=[0.0] * (4 * n))
        assert cog_chart(body.cogs, list(case.z), case.u, case.span, body, case.pad, 2, full) == 3
        assert full.spans[2] == pieces.spans[2]
    assert events >= 2


@pytest.mark.parametrize("name", SCENES)
def test_one_mode_is_left_at_its_end(name: str) -> None:
    """Where it ends, and as what; without turning points, too."""
    for seed in SEEDS:
        for ways in (True, False):
            case = case_of(name, seed + 50, ways)
            body, known = case.body, case.begin()
            z = list(case.z)
            slope, mode = slope_at(z[0], body.cogs), way_from(z, case.u, known.slope, body) if known.ways else FREE
            assert mode == known.mode
            fresh = mode not in (0, FREE) and z[1] == 0.0
            t, end = roll(z, case.u, slope, mode, case.span, fresh, body, case.pad)
            if not case.events:
                assert (t, end) == (case.span, 0)
                assert case.near(z, case.end)
                continue
            first = case.events[0]
            assert (t, end) == (pytest.approx(first.time, abs=1e-9), first.end)
            state = first.state.copy()
            if end == TURNED and mode != 0:
                assert abs(z[1]) < 1e-9 * case.size
                state[1] = z[1]
            assert case.near(z, state)


@pytest.mark.parametrize("name", SCENES)
def test_columns_are_the_derivative_and_marks_what_decides(name: str) -> None:
    """Against differences of the motion itself, of states 1e-6 apart, where no neighbour goes another way."""
    compared = 0
    for seed in SEEDS:
        case = case_of(name, seed, True)
        body, n = case.body, case.body.order
        width = n + 2
        cols = [0.0] * (width * (width + 2))
        for c in range(n + 1):
            for i in range(n):
                cols[c * width + i] = float(i == c)
        command = width * width
        cols[command + n] = 1.0  # the last column is that of the command itself
        marks = fresh_marks()
        z = list(case.z)
        cog_columns(body.cogs, z, case.u, case.span, body, case.pad, cols, command, n + 1, width, marks)
        assert case.near(z, case.end)
        check_marks(case, marks)
        if min(marks[:2]) < 1e-4:
            continue
        for c in range(n + 1):
            ends, kinds = [], []
            for nudge in (1e-6, -1e-6):
                other, u = list(case.z), case.u
                if c < n:
                    other[c] += nudge
                else:
                    u += nudge
                known = Cogged(body, other, u, ways=True)
                kinds.append([(one.end, one.mode) for one in known.move(case.steps)])
                ends.append(known.state)
            if kinds[0] != kinds[1] or (c == 1 and case.z[1] == 0.0 and body.friction > 0.0):
                continue
            slope = (ends[0] - ends[1]) / 2e-6
            np.testing.assert_allclose(cols[c * width : c * width + n], slope, atol=2e-5 * (1.0 + np.abs(slope).max()))
            compared += 1
    assert compared >= 5


def check_marks(case: Case, marks: list[float]) -> None:
    """Distances from the friction level where that decides, a speed at the end, and the least distance to a corner."""
    known = case.begin()
    levels = [abs(known.level())] if case.z[1] == 0.0 else []
    room, way = known.room(), known.mode
    for one in case.events:
        known.z[:-2], known.slope = one.state, one.slope
        if one.end == TURNED:
            levels += [abs(known.level())] if way != 0 else []
            room = min(room, known.room())
        else:
            room = min(room, -1.0)
        way = one.mode
    close: dict[str, float] = {"rel": 1e-7, "abs": 1e-9}
    if case.body.friction > 0.0:
        assert marks[0] == pytest.approx(min(levels, default=inf), **close)
        assert marks[1] == pytest.approx(abs(case.end[1]) if way != 0 else inf, **close)
    else:
        assert marks[:2] == [inf, inf]
    assert marks[2] == inf
    assert marks[3] == pytest.approx(min(room, case.known.room()), **close)


# What is asked for, mode by mode: `roll` is written down.

# Slopes of 1/4, 8 counts long: the stable one about a place of rest at 0, the next one about 8.
COGS = [0.25, 8.0, 0.0, 1.0, 0.5, 8.0]
PLAIN = by_hand(cogs=COGS)
RUBS = by_hand(friction=2.0, cogs=COGS)


class Script:
    """Ends of modes as they are written down: time, end; then position and speed of the knob."""

    def __init__(self, patch: pytest.MonkeyPatch, steps: list[tuple[float, int, float, float]]) -> None:
        self.steps, self.asked, self.spread = steps, list[Any](), list[Any]()
        self.turned = list[float]()
        patch.setattr(slopes, "roll", self.roll)
        patch.setattr(slopes, "spread_by", self.spread_by)
        patch.setattr(slopes, "turn_round", self.turn_round)

    def roll(self, z: Any, u: float, slope: float, mode: int, left: float, fresh: bool, body: Body, pad: Any) -> Any:
        self.asked.append((slope, mode, left, fresh))
        t, end, z[0], z[1] = self.steps[len(self.asked) - 1]
        return t, end

    def spread_by(
        self, cols: Any, command: int, count: int, width: int, span: float, rates: int, halves: int, pulled: bool,
        body: Body, pad: Any,
    ) -> None:  # fmt: skip
        self.spread.append((span, rates, halves, pulled))

    def turn_round(self, cols: Any, count: int, width: int, jump: float, body: Body) -> None:
        self.turned.append(jump)


def test_without_cogging_nothing_moves() -> None:
    z = [1.0, 2.0]
    cog_many(None, z, 0.0, 1.0, PLAIN, [])
    cog_columns(None, z, 0.0, 1.0, PLAIN, [], [], 0, 0, 0, [])
    assert cog_chart(None, z, 0.0, 1.0, PLAIN, [], 3, None) == 3
    assert z == [1.0, 2.0]


def test_after_an_end_comes_the_next_slope_or_the_other_way() -> None:
    for mode in (FREE, 1, -1):
        assert pass_on([4.0, 1.0], 0.0, 0.0, mode, RISEN, RUBS) == (1.0, mode)
        assert pass_on([-4.0, -1.0], 0.0, 0.0, mode, FALLEN, RUBS) == (-1.0, mode)
    for mode in (1, -1):
        for u, then in ((4.0, 1), (2.0, 0), (-2.0, 0), (-4.0, -1)):
            z = [0.0, 1e-17]
            assert pass_on(z, u, 0.0, mode, TURNED, RUBS) == (0.0, then)
            assert z == [0.0, 0.0]
    for u, then in (
        (2.0, 1),
        (0.5, 1),
        (-0.5, -1),
        (-2.0, -1),
        (0.0, -1),
    ):  # released, though rounding may say otherwise
        z = [0.0, 0.0]
        assert pass_on(z, u, 0.0, 0, TURNED, RUBS) == (0.0, then)
    # Of an unstable slope, too: at 9, a count beyond the top, cogging pulls by 1/4, the hand by 9.
    for u, then in ((9.0 - 0.25 + 2.0, 0), (9.0 - 0.25 + 2.0 + 1e-9, 1), (9.0 - 0.25 - 2.0 - 1e-9, -1)):
        assert pass_on([9.0, 0.0], u, 1.0, 1, TURNED, RUBS) == (1.0, then)
        assert way_from([9.0, 0.0], u, 1.0, RUBS) == then
    assert way_from([9.0, 1e-300], 0.0, 1.0, RUBS) == 1
    assert way_from([9.0, -1e-300], 0.0, 1.0, RUBS) == -1


@pytest.mark.parametrize("body", [PLAIN, RUBS])
def test_a_motion_goes_on_until_nothing_is_left(monkeypatch: pytest.MonkeyPatch, body: Body) -> None:
    """On the slope and in the mode that the last end leads to; what begins where another has ended is fresh."""
    rubs = body.friction > 0.0
    for v, u, way in ((0.5, 0.0, 1), (-0.5, 0.0, -1), (0.0, 0.0, 0), (0.0, 3.0, 1), (0.0, -3.0, -1), (1.0, 0.0, 1)):
        mode = way if rubs else FREE
        fresh = v == 0.0 and mode != 0
        script = Script(monkeypatch, [(0.25, RISEN, 4.0, 1.0), (0.125, FALLEN, 4.0, -1.0), (0.625, TURNED, 1.0, 0.0)])
        z = [0.0, v]
        cog_many(COGS, z, u, 1.0, body, [])
        assert script.asked == [(0.0, mode, 1.0, fresh), (1.0, mode, 0.75, True), (0.0, mode, 0.625, True)]
        assert z == [1.0, 0.0]
        script = Script(monkeypatch, [(0.5, 0, 4.0, 1.0)])  # given up: all is over
        cog_many(COGS, z, 0.0, 1.0, body, [])
        assert len(script.asked) == 1
    script = Script(monkeypatch, [])
    cog_many(COGS, z, 0.0, 0.0, body, [])
    assert script.asked == []


def columns(
    patch: pytest.MonkeyPatch,
    z: list[float],
    u: float,
    steps: list[tuple[float, int, float, float]],
    body: Body = RUBS,
    marks: tuple[float, ...] = (inf, inf, inf, inf),
    span: float = 1.0,
) -> tuple[Script, list[float]]:
    script, found = Script(patch, steps), list(marks)
    cog_columns(COGS, z, u, span, body, [0.0] * 4, [], 0, 0, 0, found)
    return script, found


def test_columns_follow_the_same_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the matrices of a slope, or of a knob that friction holds, on which no command acts."""
    steps = [(0.25, RISEN, 4.0, 1.0), (0.125, RISEN, 12.0, 1.0), (0.5, FALLEN, 12.0, -1.0), (0.125, TURNED, 9.0, 0.0)]
    for body, mode in ((RUBS, 1), (PLAIN, 1)):
        script, marks = columns(monkeypatch, [0.0, 0.5], 0.0, steps, body)
        assert script.asked == [(0.0, mode, 1.0, False), *((float(k), mode, left, True) for k, left in
                                                            ((1, 0.75), (2, 0.625), (1, 0.125)))]  # fmt: skip
        stable, unstable = (COGGED, COGGED_HALVES, True), (COGGED + 1, COGGED_HALVES + 53, True)
        assert script.spread == [(0.25, *stable), (0.125, *unstable), (0.5, *stable), (0.125, *unstable)]
        assert marks[2:] == [inf, -1.0]
    for u, way in ((0.0, 0), (3.0, 1), (-3.0, -1)):
        script, _ = columns(monkeypatch, [0.0, 0.0], u, [(1.0, 0, 0.0, 0.0)])
        assert script.asked == [(0.0, way, 1.0, way != 0)]
        assert script.spread == [(1.0, *((1, 57, False) if way == 0 else stable))]
    assert columns(monkeypatch, [0.0, 0.0], 0.0, [], span=0.0)[0].asked == []
    assert len(columns(monkeypatch, [0.0, 1.0], 0.0, [(0.5, 0, 0.0, 0.0)])[0].asked) == 1


def test_what_torques_lack_of_friction_is_marked_where_it_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the knob stands at first, and where it turns; not where it passes a corner, nor where it is released."""
    on = [(1.0, 0, 1.0, 1.0)]
    for u, mark in ((0.5, 1.5), (1.75, 0.25), (-1.75, 0.25), (2.5, 0.5), (-3.0, 1.0), (9.0, 5.0)):
        assert columns(monkeypatch, [0.0, 0.0], u, on, marks=(5.0, inf, inf, inf))[1][0] == mark
        assert columns(monkeypatch, [0.0, 1.0], u, on, marks=(5.0, inf, inf, inf))[1][0] == 5.0
        turned = [(0.5, TURNED, 0.0, 1e-17), (0.5, 0, 0.0, 1.0)]
        assert columns(monkeypatch, [0.0, 1.0], u, turned, marks=(5.0, inf, inf, inf))[1][0] == mark
        assert columns(monkeypatch, [0.0, 0.0], 0.5, turned, marks=(5.0, inf, inf, inf))[1][0] == 1.5  # released
        assert columns(monkeypatch, [0.0, 0.0], u, on, PLAIN, (5.0, 6.0, inf, inf))[1][:2] == [5.0, 6.0]
        assert columns(monkeypatch, [0.0, 1.0], u, turned, PLAIN, (5.0, 6.0, inf, inf))[1][:2] == [5.0, 6.0]
    # At 9 on the unstable slope, of the hand's 9 and the top's 1/4.
    for u, mark in ((9.0, 1.75), (6.0, 0.75)):
        assert columns(monkeypatch, [9.0, 0.0], u, on)[1][0] == mark
        corner = [(0.5, RISEN, 4.0, 1.0), (0.25, TURNED, 9.0, 0.0), (0.25, 0, 9.0, 0.0)]
        assert columns(monkeypatch, [0.0, 1.0], u, corner)[1][0] == mark
    corner = [(0.5, RISEN, 4.0, 1.0), (0.5, 0, 5.0, 1.0)]
    assert columns(monkeypatch, [0.0, 1.0], 0.0, corner)[1][0] == inf


def test_a_rate_that_jumps_at_a_turn_turns_the_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the change of the acceleration, over what it was: to 0 where friction holds the knob."""
    for way in (1, -1):
        for pull, mode in ((-1.0, 0), (-3.0, -1), (1.0, 0), (-2.0, 0)):
            script, _ = columns(
                monkeypatch, [0.0, 1.0 * way], pull * way, [(0.5, TURNED, 0.0, 0.0), (0.5, 0, 0.0, 0.0)]
            )
            rate, after = pull - 2.0, 0.0 if mode == 0 else pull + 2.0
            assert script.turned == [(after - rate) / rate]
            assert script.asked[1][1] == mode * way
    for steps, way in (
        ([(0.5, TURNED, 0.0, 0.0), (0.5, 0, 0.0, 0.0)], 0),  # released
        ([(0.5, RISEN, 4.0, 0.0), (0.5, 0, 0.0, 0.0)], 1),
        ([(0.5, FALLEN, 4.0, 0.0), (0.5, 0, 0.0, 0.0)], 1),
    ):
        assert columns(monkeypatch, [0.0, float(way)], -1.0, steps)[0].turned == []
    turned = [(0.5, TURNED, 0.0, 0.0), (0.5, 0, 0.0, 0.0)]
    assert columns(monkeypatch, [0.0, 1.0], -1.0, turned, PLAIN)[0].turned == []
    for u in (2.0, 3.0, 1.0):  # no rate before: nothing to divide by; and one of 1, and of -1
        script, _ = columns(monkeypatch, [0.0, 1.0], u, turned)
        assert script.turned == ([] if u == 2.0 else [-1.0] if u == 1.0 else [0.0])


def test_a_speed_at_the_end_is_marked_beside_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    for v in (0.5, -0.5):
        assert columns(monkeypatch, [0.0, 1.0], 0.0, [(1.0, 0, 1.0, v)])[1][1] == 0.5
        assert columns(monkeypatch, [0.0, 1.0], 0.0, [(1.0, 0, 1.0, v)], marks=(inf, 0.25, inf, inf))[1][1] == 0.25
        assert columns(monkeypatch, [0.0, 0.0], 0.0, [(1.0, 0, 1.0, v)])[1][1] == inf
        assert columns(monkeypatch, [0.0, 1.0], 0.0, [(1.0, 0, 1.0, v)], PLAIN)[1][1] == inf
    for way in (1, -1):
        assert columns(monkeypatch, [0.0, 1.0 * way], 0.0, [(1.0, 0, 1.0, 0.5)])[1][1] == 0.5


def test_the_least_distance_to_a_corner_is_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the start, at every turn, and at the end; a corner that is passed is -1 away."""
    for z, ends, room in (
        ([3.0, 1.0], [(1.0, 0, 1.0, 1.0)], 1.0),
        ([-3.5, 1.0], [(1.0, 0, 1.0, 1.0)], 0.5),
        ([1.0, 1.0], [(1.0, 0, 3.25, 1.0)], 0.75),
        ([1.0, 1.0], [(0.5, TURNED, 3.25, 0.0), (0.5, 0, 1.0, -1.0)], 0.75),
        ([1.0, 1.0], [(0.5, TURNED, 2.0, 0.0), (0.5, 0, -1.0, -1.0)], 2.0),
        ([1.0, 1.0], [(0.5, RISEN, 4.0, 1.0), (0.5, 0, 8.0, 1.0)], -1.0),
        ([1.0, -1.0], [(0.5, FALLEN, -4.0, -1.0), (0.5, 0, -8.0, -1.0)], -1.0),
        ([9.0, 1.0], [(0.5, TURNED, 10.0, 0.0), (0.5, 0, 6.0, -1.0)], 2.0),
        ([9.0, 1.0], [(1.0, 0, 11.0, -1.0)], 1.0),
    ):
        for body in (PLAIN, RUBS):
            assert columns(monkeypatch, list(z), -9.0, ends, body)[1][3] == room
            assert columns(monkeypatch, list(z), -9.0, ends, body, (inf, inf, inf, 0.625))[1][3] == min(room, 0.625)


def test_a_chart_has_no_pieces_without_length(monkeypatch: pytest.MonkeyPatch) -> None:
    for body in (PLAIN, RUBS):
        for v, u, way in ((0.5, 0.0, 1), (0.0, 0.0, 0), (0.0, 3.0, 1), (0.0, -3.0, -1)):
            if body is PLAIN and v == u == 0.0:
                continue
            script = Script(
                monkeypatch,
                [
                    (0.25, RISEN, 4.0, 1.0),
                    (0.0, FALLEN, 3.0, -1.0),
                    (0.5, FALLEN, -4.0, -1.0),
                    (0.25, RISEN, -4.0, 0.0),
                ],
            )
            pieces = SimpleNamespace(spans=[0.0] * 9, modes=[9] * 9, commands=[0.0] * 9, states=[7.0] * 20)
            assert cog_chart(COGS, [0.0, v], u, 1.0, body, [], 1, pieces) == 4
            assert script.asked == [
                (0.0, way, 1.0, v == 0.0 and way != 0),
                (1.0, way, 0.75, True),
                (0.0, way, 0.75, True),
                (-1.0, way, 0.25, True),
            ]
            assert pieces.spans == [0.0, 0.25, 0.5, 0.25, *[0.0] * 5]
            assert pieces.modes[:5] == [9, STABLE * way, STABLE * way, UNSTABLE * way, 9]
            assert pieces.commands == [0.0, u, u, u, *[0.0] * 5]
            assert pieces.states == [7.0, 7.0, 0.0, v, 3.0, -1.0, -4.0, -1.0, -4.0, 0.0, *[7.0] * 10]
            given_up = Script(monkeypatch, [(0.5, 0, 4.0, 1.0)])
            assert cog_chart(COGS, [0.0, v], u, 1.0, body, [], 1, pieces) == 2
            assert len(given_up.asked) == 1
            nothing = Script(monkeypatch, [])
            assert cog_chart(COGS, [0.0, v], u, 0.0, body, [], 1, pieces) == 1
            assert nothing.asked == []


@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-14, 3e-13])
def test_a_knob_that_has_settled_is_moved_at_once(off: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """It balances to a rounding, and would turn round at each: in steps of a rounding of the time."""
    body, asked = body_of("strong"), 0
    cogs = body.cogs
    x = cogs[CENTRE] + 0.125 * cogs[LENGTH]
    u = -float(Cogged(body, [x, 0.0], 0.0).pull() @ [x, 0.0, 1.0, 0.0]) + off
    real = slopes.roll

    def roll(*given: Any) -> Any:
        nonlocal asked
        asked += 1
        assert asked < 9
        return real(*given)

    monkeypatch.setattr(slopes, "roll", roll)
    z, pad, marks = [x, 0.0], [0.0] * 4, fresh_marks()
    cols = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]  # of angle, speed, and the command
    cog_columns(cogs, z, u, 1.0, body, pad, cols, 2, 3, 2, marks)
    assert asked == 1
    assert z[0] == pytest.approx(x, abs=1e-11 * (1.0 + abs(x)))
    assert marks[:2] == [inf, inf]
    room = 0.375 * cogs[LENGTH]
    assert room - 2e-11 * (1.0 + abs(x)) < marks[3] <= room


def test_what_a_settled_knob_may_move_is_no_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a count; with friction nothing has settled."""
    monkeypatch.setattr(slopes, "STILL", 0.25)
    monkeypatch.setattr(slopes, "far_apart", lambda *_: 1.0)
    for body, mark, mode in ((PLAIN, 2.5, FREE), (PLAIN._replace(friction=0.5), 3.0, 1), (RUBS, 3.0, 1)):
        script, marks = columns(monkeypatch, [1.0, 0.5], 0.0, [(0.5, 0, 1.0, 0.5)], body, span=0.5)
        assert marks[3] == mark
        assert script.asked[0][1] == mode


def test_a_knob_that_balances_where_no_springs_hold_it_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """On the top of cogging that is stiffer than the hand: no bound says that it stays, and no torque moves it."""
    cogs = [2.0, *COGS[1:]]
    script, marks = Script(monkeypatch, [(1.0, 0, 8.0, 0.0)]), fresh_marks()
    cog_columns(cogs, [8.0, 0.0], 8.0, 1.0, PLAIN._replace(cogs=cogs), [0.0] * 4, [], 0, 0, 0, marks)
    assert script.asked == [(1.0, FREE, 1.0, True)]
