"""Teeth with play from flank to flank: against matrix exponentials, event by event, and the end of a mode by hand."""

from functools import cache
from math import inf
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general import flanks, teeth_ends
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import TURNED
from hknob_cli.engine.general.columns import Columns
from hknob_cli.engine.general.flanks import (
    kind_of,
    meet,
    meet_with_friction,
    next_flank,
    pass_end,
    play_chart,
    play_columns,
    play_many,
    spread_teeth,
)
from hknob_cli.engine.general.teeth import APART, BACK, SPRUNG, STUCK_APART, STUCK_BACK, flank, pressing, touches
from hknob_cli.engine.general.teeth_ends import Mode, press

from .gears import Gear, begun, geared

BODIES: dict[str, dict[str, Any]] = {
    "plain": {},
    "undamped": {"mesh_damping": 0.0},
    "soft": {"stiffness": 1.0, "mesh_damping": 1e-4},
    "rubs": {"friction": 2e-5},
    "rubs hard": {"friction": 1e-4, "mesh_damping": 2e-2},
    "rubs, lag": {"friction": 1e-5, "lag": 2e-4},
    "rubs, wound": {"friction": 1e-5, "wound": True},
    "wound, lag": {"wound": True, "lag": 2e-4},
}
CLOSE = 1e-9  # of the size of the state: far above roundings, far below any event that is missed


@cache
def body_of(name: str) -> Body:
    more = dict(BODIES[name])
    return geared(more.pop("friction", 0.0), **more)


class Case:
    """One motion over a time of so many 64ths of a sample, and what the exponentials make of it."""

    def __init__(self, name: str, seed: int) -> None:
        self.body = body_of(name)
        chance = Random(f"{name} {seed}")
        self.z, self.u = begun(self.body, chance)
        self.steps = chance.choice([1, 24, 63, 64, 64])
        self.gear = Gear(self.body)
        self.end, self.events = self.gear.move(self.z, self.u, self.steps)
        self.size = 1.0 + max(map(abs, self.end))
        self.pad = [0.0] * (2 * self.body.order)

    @property
    def span(self) -> float:
        return self.steps / 64.0

    def near(self, found: Any, expected: Any) -> bool:
        n = self.body.order
        return bool(np.abs(np.array(found[:n]) - np.array(expected[:n])).max() <= CLOSE * self.size)


SEEDS = range(5)


@pytest.mark.parametrize("name", BODIES)
def test_a_motion_and_its_chart_go_from_event_to_event(name: str) -> None:
    """The same ends, in the same order; a chart has a piece for each, with its mode, and stops where its rows do."""
    events = 0
    for seed in SEEDS:
        case = Case(name, seed)
        body, n = case.body, case.body.order
        z = list(case.z)
        play_many(z, case.u, case.span, body, case.pad)
        assert case.near(z, case.end)
        events += len(case.events)
        pieces = SimpleNamespace(spans=[0.0] * 30, modes=[9] * 30, commands=[0.0] * 30, states=[0.0] * (31 * n))
        z = list(case.z)
        rows = play_chart(z, case.u, case.span, body, case.pad, 2, pieces)
        assert case.near(z, case.end)
        assert pieces.states[rows * n : rows * n + n] == z
        assert sum(pieces.spans) == pytest.approx(case.span, rel=1e-12)
        assert pieces.commands == [0.0] * 2 + [case.u] * (rows - 2) + [0.0] * (30 - rows)
        seen = np.cumsum(pieces.spans[2:rows])
        told = [row for row in range(2, rows) if pieces.spans[row] > 1e-9]
        # An end of a mode that is told at once with another makes a piece of no length.
        starts = [0.0, *(one.time for one in case.events)]
        assert all(min(abs(t - one) for one in [*starts, case.span]) < 1e-9 for t in seen)
        assert all(min([abs(one - t) for t in [0.0, *seen]]) < 1e-9 for one in starts)
        first = Gear(body)
        first.move(case.z, case.u, 0)
        modes = [first.now, *((one.flank, one.way) for one in case.events)]
        for row in told:
            at = 0.0 if row == 2 else seen[row - 3]
            side, way = next(mode for mode, one in reversed(list(zip(modes, starts, strict=True))) if one < at + 1e-9)
            held = body.friction > 0.0 and way == 0
            expected = {1: 0, 0: STUCK_APART, -1: STUCK_BACK}[side] if held else {1: 1, 0: APART, -1: BACK}[side] * way
            assert pieces.modes[row] == expected
        full = SimpleNamespace(spans=[0.0] * 3, modes=[0] * 3, commands=[0.0] * 3, states=[0.0] * (4 * n))
        assert play_chart(list(case.z), case.u, case.span, body, case.pad, 2, full) == 3
        assert full.spans[2] == pieces.spans[2]
    assert events >= 2


@pytest.mark.parametrize("name", BODIES)
def test_one_mode_is_left_at_its_end_and_bounds_its_torque(name: str) -> None:
    """Where it ends, as what, and a bound from below on the torque of the mesh that is near it."""
    for seed in SEEDS:
        case = Case(name, seed + 100)
        body, gear = case.body, case.gear
        z, side = list(case.z), flank(case.z, case.body)
        rubs = body.friction > 0.0
        way = Gear(body).way_of(np.array([*case.z, 1.0, case.u]), side)
        t, ended, least = press(z, case.u, Mode(side, way, 0.0), case.span, False, body, case.pad)
        if not case.events:
            assert (t, ended) == (case.span, 0)
            assert case.near(z, case.end)
            if side:
                true = min(gear.least, pressing(case.z, 0, side, body))
                assert 0.75 * true <= least <= true * (1.0 + 1e-9)
            continue
        first = case.events[0]
        assert t == pytest.approx(first.time, abs=1e-9)
        assert case.near(z, first.state)
        assert ended == (SPRUNG if first.flank != side else TURNED)
        if ended == SPRUNG:
            assert least == -1.0 or side == 0
        if not rubs and side == first.flank:
            assert first.state[1] == 0.0


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", BODIES)
def test_columns_are_the_derivative_and_marks_what_decides(name: str) -> None:
    """Against differences of the motion itself, of states 1e-6 apart, where no neighbour goes another way."""
    compared = 0
    for seed in SEEDS:
        case = Case(name, seed)
        body, n = case.body, case.body.order
        width = n + 2
        cols = [0.0] * (width * (width + 2))
        for c in range(n + 1):
            for i in range(n):
                cols[c * width + i] = float(i == c)
        command = width * width
        cols[command + n] = 1.0  # the last column is that of the command itself
        marks = [inf] * 4
        z = list(case.z)
        play_columns(z, case.u, case.span, body, case.pad, Columns(cols, command, n + 1, width), marks)
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
                gear = Gear(body)
                _, events = gear.move(other, u, case.steps)
                kinds.append([(one.flank, one.way) for one in events])
                play_many(other, u, case.span, body, case.pad)
                ends.append(np.array(other))
            if kinds[0] != kinds[1] or (c == 1 and case.z[1] == 0.0 and body.friction > 0.0):
                continue
            slope = (ends[0] - ends[1]) / 2e-6
            np.testing.assert_allclose(cols[c * width : c * width + n], slope, atol=2e-5 * (1.0 + np.abs(slope).max()))
            compared += 1
    assert compared >= 5


def check_marks(case: Case, marks: list[float]) -> None:
    """Distances from the friction level where that decides, a speed at the end, and the least torque of the mesh."""
    body, gear = case.body, case.gear
    assert marks[3] == inf  # no cogging
    start = np.array([*case.z, 1.0, case.u])
    side = flank(case.z, body)
    if body.friction == 0.0:
        assert marks[:2] == [inf, inf]
    else:
        levels, way, at = [], Gear(body).way_of(start, side), side
        if case.z[1] == 0.0:
            levels.append(start)
        flanks = [side]
        for one in case.events:
            flanks.append(one.flank)
            z = np.array([*one.state, 1.0, case.u])
            if z[1] == 0.0 and (way != 0 or one.flank != at):
                levels.append(z)
            way, at = one.way, one.flank
        found = [
            abs(abs(gear.pulls[flank(list(z[:-2]), body)] @ z) - body.friction) if k == 0 and case.z[1] == 0.0 else None
            for k, z in enumerate(levels)
        ]
        if case.z[1] == 0.0 and len(levels) == 1:
            assert marks[0] == pytest.approx(found[0], rel=1e-9, abs=1e-9)
        assert (marks[0] < inf) == bool(levels)
        assert (marks[1] < inf) == (way != 0)
        if way != 0:
            assert marks[1] == pytest.approx(abs(case.end[1]), abs=CLOSE * case.size)
    parted = side == 0 or any(one.flank != side for one in case.events)
    if parted:
        assert marks[2] == -1.0
    else:
        assert marks[2] <= gear.least * (1.0 + 1e-9) + 1e-9
        assert marks[2] > 0.0 or gear.least < 0.1 * abs(pressing(case.z, 0, side, body))


# By hand.

LOOSE = geared(0.0)._replace(play=2.0)


def test_teeth_press_where_they_overlap_and_do_not_pull() -> None:
    one = LOOSE._replace(pad_stiffness=2.0, pad_damping=0.5)
    for d, w, side, torque, presses in (
        (0.5, 1.0, 1, 1.5, True),
        (0.5, -2.0, 1, 0.0, False),
        (0.5, -1.875, 1, 0.0625, True),
        (0.0, 9.0, 1, 4.5, False),
        (-0.25, 9.0, 1, 4.0, False),
        (-2.5, -1.0, -1, 1.5, True),
        (-2.5, 2.0, -1, 0.0, False),
        (-2.0, -9.0, -1, 4.5, False),
        (-1.75, -9.0, -1, 4.0, False),
    ):
        z = [0.0, 0.0, d, w]
        assert pressing(z, 0, side, one) == torque
        assert pressing([7.0, *z], 1, side, one) == torque
        assert touches(z, 0, side, one) is presses
        assert touches([7.0, *z], 1, side, one) is presses
        assert flank(z, one) == (side if presses else 0)


def test_after_a_mode_comes_the_nearer_flank_or_none() -> None:
    for d, side in ((0.1, 1), (-0.9, 1), (-1.0, -1), (-1.1, -1), (-2.1, -1)):
        assert next_flank([0.0, 0.0, d, 0.0], 0, LOOSE) == side
        assert next_flank([0.0, 0.0, d, 0.0], 1, LOOSE) == next_flank([0.0, 0.0, d, 0.0], -1, LOOSE) == 0


def test_without_friction_a_way_is_followed_where_it_is_asked_for() -> None:
    """The motor turns round, or teeth part; the sign that speed has by rounding decides with the end that is told."""
    for way in (1, -1):
        for end, v in ((TURNED, 1e-17), (TURNED, -1e-17), (SPRUNG, -1e-17 * way)):
            for u, then in ((9e3, 1), (-9e3, -1)):
                z = [0.0, v, 0.5, 0.1]
                assert pass_end(z, u, 1, way, end, LOOSE) == (1, then)
                assert z[1] == 0.0
        z = [0.0, 0.25 * way, 0.5, 0.1]
        assert pass_end(z, 0.0, 1, way, SPRUNG, LOOSE) == (0, way)
        assert z[1] == 0.25 * way
        z = [0.0, 0.25 * way, -1.9, 0.1]
        assert pass_end(z, 0.0, 0, way, SPRUNG, LOOSE) == (-1, way)
        assert pass_end([0.0, 0.0, 0.5, 0.1], 0.0, 1, way, SPRUNG, LOOSE)[0] == 0  # it stands as teeth part
    z = [0.0, 0.25, 0.5, 0.1]
    assert pass_end(z, 0.0, 1, 0, SPRUNG, LOOSE) == (0, 0)
    assert pass_end([0.0, -0.25, 0.5, 0.1], 0.0, 0, 0, SPRUNG, LOOSE) == (1, 0)


def test_friction_holds_or_lets_go_where_a_mode_ends() -> None:
    rubs = LOOSE._replace(friction=1.0)
    for u, then in ((0.5, 0), (2.5, 1), (-2.5, -1)):
        z = [0.0, 1e-17, -0.5, 0.0]  # in the gap nothing else pulls
        assert pass_end(z, u, 0, 1, TURNED, rubs) == (0, then)
        assert z[1] == 0.0
        z = [0.0, 0.0, -2.0001, -1.0]
        side, way = pass_end(z, u, 0, 0, SPRUNG, rubs)
        assert side == -1
        assert pass_end([0.0, 0.5, -0.5, 0.0], u, 1, 1, SPRUNG, rubs) == (0, 1)
    for u, way in ((1.0, 1), (-1.0, -1), (0.999, 1), (-0.999, -1)):  # released, though rounding may say otherwise
        assert pass_end([0.0, 0.0, -0.5, 0.0], u, 0, 0, TURNED, rubs) == (0, way)
    pressed = geared(mesh_damping=2e-2)._replace(friction=1.0, play=2.0)
    w = -4.0 * 0.5 * pressed.pad_stiffness / pressed.pad_damping  # the damper pulls, by more than the spring presses
    assert pass_end([0.0, 0.0, 0.5, w], 0.0, 1, 0, TURNED, pressed) == (1, 1)
    assert pass_end([0.0, 0.0, 0.5, 0.0], 0.0, 1, 0, TURNED, pressed) == (1, -1)


def test_a_piece_is_written_with_flank_and_way() -> None:
    rubs = LOOSE._replace(friction=1.0)
    for side, held, free in ((1, 0, 1), (0, STUCK_APART, APART), (-1, STUCK_BACK, BACK)):
        assert kind_of(side, 0, rubs) == held
        for one in (LOOSE, rubs):
            assert kind_of(side, 1, one) == free
            assert kind_of(side, -1, one) == -free


# What is asked for, mode by mode: `press` is written down.


class Script:
    """Ends of modes as they are written down: time, end, least torque; then flank, way and speed of the motor."""

    def __init__(self, patch: pytest.MonkeyPatch, module: Any, steps: list[tuple[Any, ...]], pulls: Any = ()) -> None:
        self.steps, self.pulls, self.asked, self.then = steps, list(pulls), list[Any](), list[Any]()
        patch.setattr(module, "press", self.press)
        patch.setattr(module, "pass_end", self.pass_end)
        patch.setattr(module, "teeth_pull", self.teeth_pull, raising=False)

    def press(self, z: Any, u: float, mode: Mode, left: float, fresh: bool, body: Body, pad: Any) -> Any:
        side, way, slope = mode
        assert slope == 0.0
        self.asked.append((side, way, left, fresh))
        t, end, least, *_ = self.steps[len(self.asked) - 1]
        z[0] = -float(len(self.asked))
        return t, end, least

    def pass_end(self, z: Any, u: float, side: int, way: int, end: int, body: Body, slope: float) -> tuple[int, int]:
        assert slope == 0.0
        *_, side, way, v = self.steps[len(self.asked) - 1]
        z[1] = v
        return side, way

    def teeth_pull(self, z: Any, at: int, u: float, side: int, body: Body, slope: float) -> float:
        assert (at, slope) == (0, 0.0)
        return float(self.pulls[len(self.asked)])


RUBS = LOOSE._replace(friction=1.0)
ONE = Columns([], 0, 1, 4)
# On the wall's flank; it turns round, teeth part while it stands, it is released, teeth meet, and it ends.
COURSE = [
    (0.25, TURNED, 3.0, 1, 0, 0.0),
    (0.25, SPRUNG, -1.0, 0, 0, 0.0),
    (0.125, TURNED, inf, 0, -1, 0.0),
    (0.125, SPRUNG, inf, -1, -1, -0.5),
    (0.25, 0, 2.0, 0, 0, 0.0),
]
BEGUN = [0.0, 0.5, 0.5, 0.0]  # presses, the motor under way


def modes_of(course: list[tuple[Any, ...]], first: tuple[int, int], fresh: bool, span: float = 1.0) -> list[Any]:
    """What is asked for, one mode after the other: what has begun where another ended is fresh."""
    found, left, now = [], span, first
    for k, (t, *_, side, way, _) in enumerate(course):
        found.append((*now, left, fresh if k == 0 else True))
        left, now = left - t, (side, way)
    return found


def test_a_motion_asks_for_mode_after_mode(monkeypatch: pytest.MonkeyPatch) -> None:
    """It ends with its time, be it at the very end of a mode. Without friction the motor's way is not asked for."""
    for course in (COURSE, COURSE[:4], COURSE[:2]):
        span = sum(one[0] for one in course)
        for z, fresh in ((BEGUN, False), ([0.0, 0.0, 0.5, 0.0], True), ([0.0, -0.5, 0.5, 0.0], False)):
            for pull, v in ((5.0, 1), (-5.0, -1)):
                script = Script(monkeypatch, flanks, course)
                way = int(np.sign(z[1])) or v
                monkeypatch.setattr(flanks, "direction", lambda *_, way=way: way)
                play_many(list(z), pull, span, RUBS, [])
                assert script.asked == modes_of(course, (1, way), fresh, span)
        script = Script(monkeypatch, flanks, course)
        monkeypatch.setattr(flanks, "direction", lambda *_: 0)
        play_many([0.0, 0.0, 0.5, 0.0], 0.0, span, RUBS, [])
        assert script.asked == modes_of(course, (1, 0), False, span)
        script = Script(monkeypatch, flanks, course)
        monkeypatch.setattr(flanks, "direction", lambda *_: 7)
        play_many([0.0, 0.0, 0.5, 0.0], 0.0, span, LOOSE, [])
        assert script.asked == modes_of(course, (1, 0), False, span)


def test_a_chart_asks_for_mode_after_mode(monkeypatch: pytest.MonkeyPatch) -> None:
    """What takes no time is no piece."""
    course = [COURSE[0], (0.0, SPRUNG, -1.0, 0, 0, 0.0), *COURSE[2:]]
    for one, z, way, fresh in (
        (RUBS, BEGUN, 1, False),
        (RUBS, BEGUN, -1, False),
        (RUBS, [0.0, 0.0, 0.5, 0.0], 1, True),
        (RUBS, [0.0, 0.0, 0.5, 0.0], -1, True),
        (RUBS, [0.0, 0.0, 0.5, 0.0], 0, False),
        (LOOSE, [0.0, 0.0, 0.5, 0.0], 1, False),
        (RUBS._replace(friction=0.5), [0.0, 0.0, 0.5, 0.0], 1, True),
    ):
        for some in (course, course[:4]):
            script = Script(monkeypatch, flanks, some)
            monkeypatch.setattr(flanks, "direction", lambda *_, way=way: way)
            pieces = SimpleNamespace(spans=[0.0] * 9, modes=[9] * 9, commands=[0.0] * 9, states=[0.0] * 40)
            span = sum(step[0] for step in some)
            rows = play_chart(list(z), 2.0, span, one, [], 0, pieces)
            assert script.asked == modes_of(some, (1, way), fresh, span)
            assert pieces.spans[:rows] == [step[0] for step in some if step[0] > 0.0]
            # The state of a piece is that at its begin, and after the last there is the end.
            starts = [0.0, *(-float(k + 1) for k in range(len(some)))]
            kept = [starts[k] for k, step in enumerate(some) if step[0] > 0.0]
            assert pieces.states[0 : 4 * rows + 1 : 4] == [*kept, starts[-1]]


@pytest.mark.parametrize("v", [0.0, 0.5])
def test_marks_are_the_least_of_all_that_decides(monkeypatch: pytest.MonkeyPatch, v: float) -> None:
    """The pull on a motor that stands or turns from friction's level, but not where it is only released."""
    spread: list[Any] = []
    met: list[Any] = []
    turned: list[float] = []
    monkeypatch.setattr(flanks, "spread_teeth", lambda *given: spread.append(given[1:4]))
    monkeypatch.setattr(flanks, "meet", lambda z, side, *_: met.append(side))
    monkeypatch.setattr(
        flanks, "meet_with_friction", lambda z, u, side, before, way, *_: met.append((side, before, way))
    )
    monkeypatch.setattr(flanks, "turn_round", lambda columns, jump, body: turned.append(jump))
    monkeypatch.setattr(flanks, "direction", lambda *_: 1)
    for pulls, least in (
        ([1.75, 1.5, 1.625, 9.0, 9.0, 9.0], 0.5),
        ([1.75, -1.5, 1.25, 9.0, 9.0, 9.0], 0.25),
        ([-1.125, 5.0, -5.0, 9.0, 9.0, 9.0], 4.0 if v else 0.125),
        ([9.0, 0.75, 5.0, 1.0, 1.0, 1.0], 0.25),
        ([9.0, 5.0, 0.25, 1.0, 1.0, 1.0], 0.75),
        ([0.5, 5.0, 4.5, 1.0, 1.0, 1.0], 3.5 if v else 0.5),
    ):
        for kept in (spread, met, turned):
            kept.clear()
        script = Script(monkeypatch, flanks, COURSE, pulls)
        marks = [inf] * 4
        play_columns([0.0, v, 0.5, 0.0], 0.0, 1.0, RUBS, [], ONE, marks)
        assert script.asked == modes_of(COURSE, (1, 1), v == 0.0)
        assert spread == [(0.25, 1, 1), (0.25, 1, 0), (0.125, 0, 0), (0.125, 0, -1), (0.25, -1, -1)]
        assert met == [(-1, -1, -1)]
        # At the first end it turns from 1 to a stand; the release, and what teeth do, change no rate.
        rate = pulls[1] - 1.0
        assert turned == ([-1.0] if rate else [])
        assert marks == [least, 0.5, -1.0, inf]
        script = Script(monkeypatch, flanks, COURSE, pulls)
        marks = [0.0625, 0.125, -2.0, 0.5]
        play_columns([0.0, v, 0.5, 0.0], 0.0, 1.0, RUBS, [], ONE, marks)
        assert marks == [0.0625, 0.125, -2.0, 0.5]


def test_a_motor_that_turns_round_changes_its_rate_by_friction_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """By (after - rate) / rate; none where it has no rate. What is held at the end has no speed that counts."""
    turned: list[float] = []
    monkeypatch.setattr(flanks, "spread_teeth", lambda *_: None)
    monkeypatch.setattr(flanks, "turn_round", lambda columns, jump, body: turned.append(jump))
    monkeypatch.setattr(flanks, "direction", lambda *_: 1)
    for pull, way, jumps in (
        (-3.0, -1, [(-2.0 - -4.0) / -4.0]),
        (2.0, -1, [(3.0 - 1.0) / 1.0]),
        (0.0, -1, [(1.0 - -1.0) / -1.0]),
        (1.0, -1, []),
        (0.5, 0, [-1.0]),
    ):
        turned.clear()
        Script(monkeypatch, flanks, [(0.5, TURNED, 1.5, 1, way, 0.0), (0.5, 0, 2.5, 0, 0, 0.0)], [0.0, pull, pull])
        marks = [inf] * 4
        play_columns(list(BEGUN), 0.0, 1.0, RUBS, [], ONE, marks)
        assert turned == jumps
        assert marks == [abs(abs(pull) - 1.0), 0.0 if way else inf, 1.5, inf]


def test_without_friction_teeth_that_meet_are_all_that_changes_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    met: list[int] = []
    course = [(0.5, SPRUNG, -1.0, 0, 0, 0.5), (0.125, SPRUNG, inf, -1, 0, 0.5), (0.375, SPRUNG, -1.0, 0, 0, 0.5)]
    monkeypatch.setattr(flanks, "spread_teeth", lambda *_: None)
    monkeypatch.setattr(flanks, "meet", lambda z, side, *_: met.append(side))
    monkeypatch.setattr(flanks, "direction", lambda *_: 7)
    for name in ("meet_with_friction", "turn_round"):
        monkeypatch.setattr(flanks, name, lambda *_: pytest.fail("no friction"))
    script = Script(monkeypatch, flanks, course, [0.0] * 9)
    marks = [inf] * 4
    play_columns([0.0, 0.0, 0.5, 0.0], 0.0, 1.0, LOOSE, [], ONE, marks)
    assert script.asked == modes_of(course, (1, 0), False)
    assert met == [-1]
    assert marks == [inf, inf, -1.0, inf]


# Columns by hand.


def test_where_teeth_meet_rates_jump_by_what_the_damper_takes() -> None:
    """A quarter of a difference in the mesh's angle; four times the motor's and its own on the knob."""
    one = LOOSE._replace(pad_damping=0.25, ratio=4.0)
    for side, w, jumps in ((1, 0.5, True), (1, -0.5, False), (-1, -0.5, True), (-1, 0.5, False), (1, 0.0, False)):
        cols = [1.0, 2.0, 3.0, 4.0, 9.0, -5.0, -6.0, -7.0, -8.0, 9.0]
        meet([0.0, 0.0, 0.0, w], side, Columns(cols, 0, 2, 5), one)
        first = [1.0, 2.0 - 0.75, 3.0, 4.0 - 5.0 * 0.75, 9.0]
        second = [-5.0, -6.0 + 1.75, -7.0, -8.0 + 5.0 * 1.75, 9.0]
        assert cols == ([*first, *second] if jumps else [1.0, 2.0, 3.0, 4.0, 9.0, -5.0, -6.0, -7.0, -8.0, 9.0])


def test_where_teeth_meet_a_motor_that_stood_starts_by_its_neighbours_delay(monkeypatch: pytest.MonkeyPatch) -> None:
    """A difference of 3 in the mesh comes 3 / 0.5 earlier: by so much longer the motor has what pulls it now."""
    one = LOOSE._replace(pad_damping=0.25, ratio=4.0, friction=0.5)
    monkeypatch.setattr(flanks, "teeth_pull", lambda z, at, u, side, body, slope: (3.0 if u else -3.0) + 99.0 * at)
    for before, way, u, own in (
        (1, 1, 1.0, -0.75),
        (-1, -1, 1.0, -0.75),
        (1, 0, 1.0, -0.75),
        (0, 0, 1.0, 0.0),
        (0, 1, 1.0, (3.0 - 0.5) / 0.5 * 3.0),
        (0, -1, 0.0, (-3.0 + 0.5) / 0.5 * 3.0),
    ):
        cols = [1.0, 2.0, 3.0, 4.0, 9.0]
        meet_with_friction([0.0, 0.0, 0.0, 0.5], u, 1, before, way, Columns(cols, 0, 1, 5), one)
        assert cols == [1.0, 2.0 + own, 3.0, 4.0 + own - 4.0 * 0.75, 9.0]
        for w in (-0.5, 0.0):
            cols = [1.0, 2.0, 3.0, 4.0, 9.0]
            meet_with_friction([0.0, 0.0, 0.0, w], u, 1, before, way, Columns(cols, 0, 1, 5), one)
            assert cols == [1.0, 2.0, 3.0, 4.0, 9.0]
        meet_with_friction([0.0, 0.0, 0.0, -0.25], u, -1, before, way, Columns(cols, 0, 1, 5), one)
        assert cols != [1.0, 2.0, 3.0, 4.0, 9.0]


@pytest.mark.parametrize("flank_of", [0.0, 1.0])
def test_what_stands_between_teeth_that_touch_is_one_step(flank_of: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing changes, and yet the overlap of teeth is 0, not above it: as where a motion has died away."""
    body, steps = body_of("plain"), []
    accept = teeth_ends.accept
    monkeypatch.setattr(teeth_ends, "accept", lambda z, pad, n: steps.append(len(steps)) or accept(z, pad, n))
    z = [-body.shift, 0.0, -flank_of * body.play, 0.0]
    body = body._replace(finger_stiffness=0.0, matrices=[0.0] * len(body.matrices), vectors=[0.0] * len(body.vectors))
    assert press(list(z), 0.0, Mode(0, 0, 0.0), 1.0, False, body, [0.0] * (2 * body.order)) == (1.0, 0, inf)
    assert len(steps) == 1


@pytest.mark.parametrize("name", ["plain", "rubs", "rubs, lag", "rubs, wound"])
def test_columns_move_by_their_own_mode(name: str) -> None:
    """By the exponential of that mode's rates; the last column has the torque's."""
    body = body_of(name)
    n, gear = body.order, Gear(body)
    width = n + 2
    numbers = np.random.default_rng(n).normal(size=(n + 1, n))
    for side in (1, 0, -1):
        for way in (1, 0, -1) if body.friction else (1,):
            for span in (1.0, 0.625):
                cols = [0.0] * (width * (width + 2))
                for c in range(n + 1):
                    cols[c * width : c * width + n] = numbers[c].tolist()
                cols[width * width + n] = 1.0
                columns = Columns(cols, width * width, n + 1, width)
                spread_teeth(columns, span, side, way, body, [0.0] * (2 * n))
                whole = expm(gear.rates[side, way] * span)
                for c in range(n + 1):
                    expected = whole[:n, :n] @ numbers[c] + (whole[:n, n + 1] if c == n else 0.0)
                    np.testing.assert_allclose(cols[c * width : c * width + n], expected, rtol=1e-10, atol=1e-10)
