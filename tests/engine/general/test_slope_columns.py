"""The derivative over cogging, and what is marked: against matrix exponentials, event by event, and by hand."""

from math import exp, inf, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general import columns as marks_module
from hknob_cli.engine.general import slope_columns, slopes
from hknob_cli.engine.general.body import Body, norm
from hknob_cli.engine.general.cogging import (
    CENTRE,
    COGGED,
    COGGED_HALVES,
    FALLEN,
    FREE,
    LENGTH,
    RISEN,
    ROOT,
    TURNED,
)
from hknob_cli.engine.general.columns import (
    CORNER_ROOM,
    FASTEST,
    LEAST_RELEASE,
    LEAST_TURN,
    LEVEL,
    LOOSE,
    PRESSED,
    RELEASED_FOR,
    RELEASING,
    SLOWEST,
    SLOWNESS,
    SPEED,
    STUCK_FOR,
    SWOLLEN,
    TURN_ROOM,
    TURNING,
    Columns,
)
from hknob_cli.engine.general.slope_columns import cog_columns, mark_end, mark_start, mark_turn

from .bodies import fresh_marks
from .cogs import CLOSE, COGS, PLAIN, RUBS, SCENES, SEEDS, Case, Cogged, Script, body_of, case_of

NONE = Columns([], 0, 0, 2)


@pytest.mark.one_in(3)
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
        moved = Columns(cols, command, n + 1, width)
        cog_columns(body.cogs, z, case.u, case.span, body, case.pad, moved, marks)
        assert case.near(z, case.end)
        check_marks(case, marks)
        if min(marks[LEVEL], marks[SPEED]) < 1e-4:
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


@pytest.mark.parametrize("name", [name for name in SCENES if "rubs" in name])
def test_marks_of_a_knob_that_friction_stops(name: str) -> None:
    """For good or for a while; in most of these samples it does."""
    turns, stuck = 0, 0
    for seed in SEEDS:
        case = Case(name, seed, ways=True, slow=True)
        marks = fresh_marks()
        z = list(case.z)
        cog_columns(case.body.cogs, z, case.u, case.span, case.body, case.pad, NONE, marks)
        assert case.near(z, case.end)
        found = check_marks(case, marks)
        turns, stuck = turns + len(found.turns), stuck + len(found.stuck)
    assert turns >= 4
    assert stuck >= 4 or "finger" in name


class Marked:
    """What the exponentials say of the marks of a case: pieces in one mode each, and their ends."""

    def __init__(self, case: Case) -> None:
        self.case, self.rubs = case, case.body.friction > 0.0
        self.known = case.begin()
        self.levels = [abs(self.known.level())] if case.z[1] == 0.0 else []
        self.room, self.loose = self.known.room(), 0.0
        self.turn_room = self.room if case.z[1] == 0.0 else inf
        self.speeds, self.turns = list[float](), list[float]()
        self.stuck = [level * case.span for level in self.levels]
        self.largest, self.top = 0.0, 0.0  # acceleration of the knob; root of the energy of rates at a piece's start
        self.more = self.rubs and case.body.order > 2
        self.held, self.slow = list[tuple[float, float]](), list[tuple[float, float]]()
        self.released, self.between = list[float](), list[float]()
        self.slowed, self.let_go = inf, 0.0
        self.begun = list[float]()  # of what is held as the hold begins, at most
        self.way, self.time = self.known.mode, 0.0
        for one in case.events:
            self.pass_piece(one.time - self.time, one.end, case.span - one.time)
            self.known.z[:-2], self.known.slope = one.state, one.slope
            if one.end == TURNED:
                self.turn(one.mode, case.span - one.time)
            else:
                self.room = -1.0
                self.speeds.append(abs(float(one.state[1])))
            self.way, self.known.mode, self.time = one.mode, one.mode, one.time
        self.pass_piece(case.span - self.time, 0, 0.0)
        self.room = min(self.room, case.known.room())

    def pass_piece(self, span: float, end: int, left: float) -> None:
        known, body = self.known, self.case.body
        self.loose += span if known.slope % 2.0 == 1.0 else 0.0
        if self.more:
            self.follow_piece(span, end, left)
        if self.way == 0 and not self.more:
            return
        a = known.rates()
        rates = (a @ known.z)[:-2]
        self.top = max(self.top, norm(list(rates), body) + body.cogs[ROOT] * abs(float(rates[0])))
        step = expm(a * (span / 16.0))
        z = known.z
        for _ in range(17):
            self.largest = max(self.largest, abs(float((a @ z)[1])))
            z = step @ z

    def follow_piece(self, span: float, end: int, left: float) -> None:
        """Values on the way, each with what it may be below its mark for: time beside a stop, a start or a release."""
        known, friction = self.known, self.case.body.friction
        a, z, first = known.rates(), known.z, known.z
        whole = expm(a * span) @ z
        falls = [float(known.pull() @ (a @ whole)), abs(float((a @ whole)[1])), abs(float((a @ first)[1]))]
        if self.way == 0:
            stuck = 0.5 * min(self.slowed, friction - abs(float(known.pull() @ z))) * span
            (self.stuck if self.slowed < inf else self.begun).append(stuck)
            if end == TURNED:
                self.released.append(abs(falls[0]))
                self.between.append(abs(falls[0]) * min(span, left))
        for k in range(33):
            z, past = expm(a * (span * k / 32.0)) @ first, span * k / 32.0
            if self.way == 0:
                beside = 0.5 * abs(falls[0]) * (span - past) if end == TURNED else inf
                self.held.append((friction - abs(float(known.pull() @ z)), beside))
                continue
            beside = 0.5 * falls[1] * (span - past) if end == TURNED else inf
            if first[1] == 0.0:
                beside = min(beside, 0.25 * self.let_go * past**2 if self.let_go else 0.5 * falls[2] * past)
            self.slow.append((abs(float(z[1])), beside))
        self.let_go = abs(falls[0]) if self.way == 0 else 0.0
        self.slowed = falls[1] if end == TURNED and self.way != 0 else inf

    def turn(self, mode: int, left: float) -> None:
        if self.way == 0:
            room = self.known.room()
            self.room, self.turn_room = min(self.room, room), min(self.turn_room, room)
            return
        self.room = min(self.room, self.known.room())
        self.turn_room = min(self.turn_room, self.known.room())
        if self.rubs:
            self.levels.append(abs(self.known.level()))
            self.turns.append(abs(float(self.known.pull() @ self.known.z) - self.way * self.case.body.friction))
            if mode == 0:
                self.stuck.append(self.turns[-1] * left)


def near_sum(numbers: list[float], size: float) -> Any:
    """The sum of 1 / each, of which each is known as far as the exponentials are."""
    return pytest.approx(sum(1.0 / one for one in numbers), rel=1e-9, abs=sum(size / one**2 for one in numbers))


def check_marks(case: Case, marks: list[float]) -> Marked:
    """What torques lack of the friction level, speeds, rooms, times and decelerations, each where it decides.

    `FASTEST` may be more than the largest acceleration, but no more than the root of the energy of the rates at the
    start of a piece, with the slope's spring by itself, has grown to within the hold.
    """
    found, off = Marked(case), 10.0 * CLOSE * case.size
    close: dict[str, float] = {"rel": 1e-7, "abs": max(1e-9, off)}
    assert marks[PRESSED] == inf
    assert marks[CORNER_ROOM] == pytest.approx(found.room, **close)
    assert marks[TURN_ROOM] == pytest.approx(found.turn_room, **close)
    assert marks[SLOWNESS] == near_sum(found.speeds, off)
    assert marks[SLOWEST] == pytest.approx(min(found.speeds, default=inf), **close)
    assert marks[LOOSE] == pytest.approx(found.loose, abs=1e-7)
    assert marks[SWOLLEN] == 0.0
    assert found.largest <= found.top * exp(case.body.cogs[ROOT] * case.span) * (1.0 + 1e-7)
    assert max(found.largest, found.top) <= marks[FASTEST] * (1.0 + 1e-7)
    assert marks[FASTEST] <= found.top * exp(case.body.cogs[ROOT] * case.span) * (1.0 + 1e-7)
    if found.rubs:
        last = abs(case.end[1]) if found.way != 0 else inf
        if found.more:
            assert 0.0 <= marks[LEVEL] <= min(found.levels, default=inf) * (1.0 + 1e-7) + off
            assert 0.0 <= marks[SPEED] <= last * (1.0 + 1e-7) + off
            assert all(value >= min(marks[LEVEL], beside) - off for value, beside in found.held)
            assert all(value >= min(marks[SPEED], beside) - off for value, beside in found.slow)
            assert marks[RELEASING] == near_sum(found.released, 10.0 * off)
            assert marks[LEAST_RELEASE] == pytest.approx(min(found.released, default=inf), rel=1e-6, abs=10.0 * off)
            assert marks[RELEASED_FOR] == pytest.approx(min(found.between, default=inf), rel=1e-6, abs=10.0 * off)
        else:
            assert marks[LEVEL] == pytest.approx(min(found.levels, default=inf), **close)
            assert marks[SPEED] == pytest.approx(last, **close)
            assert marks[RELEASING:] == [0.0, inf, inf]
        assert marks[TURNING] == near_sum(found.turns, 10.0 * off)
        assert marks[LEAST_TURN] == pytest.approx(min(found.turns, default=inf), rel=1e-6, abs=10.0 * off)
        stuck = pytest.approx(min(found.stuck, default=inf), rel=1e-6, abs=10.0 * off)
        assert marks[STUCK_FOR] == stuck or (
            found.begun and 0.0 <= marks[STUCK_FOR] <= min([*found.stuck, *found.begun])
        )
    else:
        assert (marks[LEVEL], marks[SPEED]) == (inf, inf)
        assert marks[TURNING:] == [0.0, inf, inf] * 2
    return found


# What is asked for, mode by mode: `roll` is written down.


class Spread(Script):
    """What the columns are moved by, too, and turned by."""

    def __init__(self, patch: pytest.MonkeyPatch, steps: list[tuple[float, int, float, float]]) -> None:
        super().__init__(patch, slope_columns, steps)
        self.spread, self.turned = list[Any](), list[float]()
        patch.setattr(slope_columns, "spread_by", self.spread_by)
        patch.setattr(slope_columns, "turn_round", self.turn_round)

    def spread_by(
        self, columns: Columns, span: float, rates: int, halves: int, pulled: bool, body: Body, pad: Any
    ) -> None:
        self.spread.append((span, rates, halves, pulled))

    def turn_round(self, columns: Columns, jump: float, body: Body) -> None:
        self.turned.append(jump)


def columns(
    patch: pytest.MonkeyPatch,
    z: list[float],
    u: float,
    steps: list[tuple[float, int, float, float]],
    body: Body = RUBS,
    span: float = 1.0,
    **begun: float,
) -> tuple[Spread, list[float]]:
    """The marks ``begun`` are as so long a period has left them, by their names."""
    script, found = Spread(patch, steps), fresh_marks()
    for name, mark in begun.items():
        found[getattr(marks_module, name)] = mark
    cog_columns(COGS, z, u, span, body, [0.0] * 4, NONE, found)
    return script, found


def test_without_cogging_nothing_is_marked() -> None:
    z = [1.0, 2.0]
    cog_columns(None, z, 0.0, 1.0, PLAIN, [], NONE, [])
    assert z == [1.0, 2.0]


def test_columns_follow_the_same_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the matrices of a slope, or of a knob that friction holds, on which no command acts."""
    steps = [(0.25, RISEN, 4.0, 1.0), (0.125, RISEN, 12.0, 1.0), (0.5, FALLEN, 12.0, -1.0), (0.125, TURNED, 9.0, 0.0)]
    for body, mode in ((RUBS, 1), (PLAIN, 1)):
        script, marks = columns(monkeypatch, [0.0, 0.5], 0.0, steps, body)
        assert script.asked == [(0.0, mode, 1.0, False), *((float(k), mode, left, True) for k, left in
                                                            ((1, 0.75), (2, 0.625), (1, 0.125)))]  # fmt: skip
        stable, unstable = (COGGED, COGGED_HALVES, True), (COGGED + 1, COGGED_HALVES + 53, True)
        assert script.spread == [(0.25, *stable), (0.125, *unstable), (0.5, *stable), (0.125, *unstable)]
        assert (marks[PRESSED], marks[CORNER_ROOM]) == (inf, -1.0)
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
        assert columns(monkeypatch, [0.0, 0.0], u, on, LEVEL=5.0)[1][LEVEL] == mark
        assert columns(monkeypatch, [0.0, 1.0], u, on, LEVEL=5.0)[1][LEVEL] == 5.0
        turned = [(0.5, TURNED, 0.0, 1e-17), (0.5, 0, 0.0, 1.0)]
        assert columns(monkeypatch, [0.0, 1.0], u, turned, LEVEL=5.0)[1][LEVEL] == mark
        assert columns(monkeypatch, [0.0, 0.0], 0.5, turned, LEVEL=5.0)[1][LEVEL] == 1.5  # released
        assert columns(monkeypatch, [0.0, 0.0], u, on, PLAIN, LEVEL=5.0, SPEED=6.0)[1][:2] == [5.0, 6.0]
        assert columns(monkeypatch, [0.0, 1.0], u, turned, PLAIN, LEVEL=5.0, SPEED=6.0)[1][:2] == [5.0, 6.0]
    # At 9 on the unstable slope, of the hand's 9 and the top's 1/4.
    for u, mark in ((9.0, 1.75), (6.0, 0.75)):
        assert columns(monkeypatch, [9.0, 0.0], u, on)[1][LEVEL] == mark
        corner = [(0.5, RISEN, 4.0, 1.0), (0.25, TURNED, 9.0, 0.0), (0.25, 0, 9.0, 0.0)]
        assert columns(monkeypatch, [0.0, 1.0], u, corner)[1][LEVEL] == mark
    corner = [(0.5, RISEN, 4.0, 1.0), (0.5, 0, 5.0, 1.0)]
    assert columns(monkeypatch, [0.0, 1.0], 0.0, corner)[1][LEVEL] == inf


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
        assert columns(monkeypatch, [0.0, 1.0], 0.0, [(1.0, 0, 1.0, v)])[1][SPEED] == 0.5
        assert columns(monkeypatch, [0.0, 1.0], 0.0, [(1.0, 0, 1.0, v)], SPEED=0.25)[1][SPEED] == 0.25
        assert columns(monkeypatch, [0.0, 0.0], 0.0, [(1.0, 0, 1.0, v)])[1][SPEED] == inf
        assert columns(monkeypatch, [0.0, 1.0], 0.0, [(1.0, 0, 1.0, v)], PLAIN)[1][SPEED] == inf
    for way in (1, -1):
        assert columns(monkeypatch, [0.0, 1.0 * way], 0.0, [(1.0, 0, 1.0, 0.5)])[1][SPEED] == 0.5


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
            assert columns(monkeypatch, list(z), -9.0, ends, body)[1][CORNER_ROOM] == room
            assert columns(monkeypatch, list(z), -9.0, ends, body, CORNER_ROOM=0.625)[1][CORNER_ROOM] == min(
                room, 0.625
            )


# What a period over corners is marked with.


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_accelerations_are_bounded_by_the_energy_of_rates(sign: float) -> None:
    """With the root of the slope times the speed, and by what both grow to: at 1, at 2 a sample, under 3 or 1."""
    for body, u, slope, mode, pull in (
        (PLAIN, 3.0, 0.0, FREE, 3.0 - 2.0 - 1.0 - 0.25),
        (PLAIN, 1.0, 0.0, FREE, 1.0 - 2.0 - 1.0 - 0.25),
        (PLAIN, 3.0, 1.0, FREE, 3.0 - 2.0 - 1.0 + 0.25 * (1.0 - 8.0)),
        (RUBS, 3.0, 0.0, 1, 3.0 - 2.0 - 1.0 - 0.25 - 2.0),
        (RUBS, 3.0, 0.0, -1, 3.0 - 2.0 - 1.0 - 0.25 + 2.0),
    ):
        for span in (1.0, 0.25):
            marks = fresh_marks()
            way = mode if mode == FREE else int(sign * mode)
            mark_start([sign, 2.0 * sign], sign * u, sign * slope, span, way, body, [0.0] * 4, marks)
            wanted = (sqrt(pull**2 + 4.0) + 0.5 * 2.0) * exp(0.5 * span)
            assert marks[FASTEST] == pytest.approx(wanted, rel=1e-14)
            only = fresh_marks()
            only[FASTEST] = marks[FASTEST]
            assert marks == only
            marks[FASTEST] = 99.0
            mark_start([sign, 2.0 * sign], sign * u, sign * slope, span, way, body, [0.0] * 4, marks)
            assert marks[FASTEST] == 99.0


def test_a_piece_is_marked_by_its_slope_and_its_end() -> None:
    """The time where nothing holds; the room where it turns; and the speed over a corner."""
    for slope, loose in ((0.0, 1.0), (1.0, 1.25), (-1.0, 1.25), (2.0, 1.0)):
        for end in (0, TURNED, RISEN, FALLEN):
            for speed in (0.5, -0.5, 2.0):
                marks = fresh_marks()
                marks[LOOSE], marks[SLOWNESS], marks[SLOWEST], marks[TURN_ROOM] = 1.0, 0.25, 1.0, 3.0
                wanted = list(marks)
                wanted[LOOSE] = loose
                wanted[CORNER_ROOM] = 2.5 if end in (0, TURNED) else -1.0
                if end == TURNED:
                    wanted[TURN_ROOM] = 2.5
                if end in (RISEN, FALLEN):
                    wanted[SLOWNESS], wanted[SLOWEST] = 0.25 + 1.0 / abs(speed), min(1.0, abs(speed))
                for side in (1.5, -1.5):
                    found = list(marks)
                    mark_end([8.0 * slope + side, speed], slope, end, 0.25, COGS, found)
                    assert found == wanted
    marks = fresh_marks()
    marks[TURN_ROOM], marks[CORNER_ROOM] = 0.5, 0.25
    mark_end([1.5, 0.0], 0.0, TURNED, 0.25, COGS, marks)
    assert (marks[TURN_ROOM], marks[CORNER_ROOM]) == (0.5, 0.25)
    mark_end([4.0, 0.0], 0.0, RISEN, 0.25, COGS, marks)
    assert (marks[SLOWNESS], marks[SLOWEST]) == (inf, 0.0)


def test_a_turn_is_marked_by_its_deceleration() -> None:
    """And by how long it is held from there on, if it is."""
    for pull, level in ((3.0, 1.0), (1.5, 0.5), (-1.5, 0.5), (-4.0, 2.0)):
        for rate in (0.5, -0.5):
            for mode in (0, 1, -1):
                marks = fresh_marks()
                marks[TURNING] = 0.25
                wanted = list(marks)
                wanted[LEVEL], wanted[TURNING], wanted[LEAST_TURN] = level, 2.25, 0.5
                wanted[STUCK_FOR] = 0.5 * 0.375 if mode == 0 else inf
                mark_turn(pull, rate, mode, 0.375, RUBS, marks)
                assert marks == wanted
                mark_turn(9.0, 8.0, mode, 0.5, RUBS, marks)
                wanted[TURNING] = 2.375
                assert marks == wanted
    marks = fresh_marks()
    mark_turn(2.0, 0.0, 0, 0.5, RUBS, marks)
    assert (marks[LEVEL], marks[TURNING], marks[LEAST_TURN], marks[STUCK_FOR]) == (0.0, inf, 0.0, 0.0)


def test_a_knob_that_stands_at_first_has_room_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that moves needs it where it turns alone."""
    on, back = [(1.0, 0, 1.0, 1.0)], [(0.5, TURNED, 3.25, 0.0), (0.5, 0, 1.0, -1.0)]
    for body in (PLAIN, RUBS):
        assert columns(monkeypatch, [3.0, 0.0], 9.0, on, body)[1][TURN_ROOM] == 1.0
        assert columns(monkeypatch, [3.0, 0.0], 9.0, on, body, TURN_ROOM=0.5)[1][TURN_ROOM] == 0.5
        assert columns(monkeypatch, [3.0, 0.0], 9.0, on, body, TURN_ROOM=-1.0)[1][TURN_ROOM] == -1.0
        assert columns(monkeypatch, [3.0, 1.0], 9.0, on, body)[1][TURN_ROOM] == inf
        assert columns(monkeypatch, [3.0, 1.0], 9.0, back, body)[1][TURN_ROOM] == 0.75
        assert columns(monkeypatch, [3.5, 0.0], 9.0, back, body)[1][TURN_ROOM] == 0.5
    assert columns(monkeypatch, [0.0, 0.0], 0.5, on)[1][TURN_ROOM] == 4.0  # held


def test_what_is_marked_along_a_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of every piece, with the time that is left: of rates of 1 and -1 at first, and of 1 and -6 over the corner."""
    over = [(0.25, RISEN, 4.0, 1.0), (0.25, TURNED, 5.0, 0.0), (0.5, 0, 4.5, -0.5)]
    _, marks = columns(monkeypatch, [0.0, 1.0], 0.0, over, PLAIN, LOOSE=0.25)
    sizes = [(sqrt(2.0) + 0.5) * exp(0.5), (sqrt(37.0) + 0.5) * exp(0.375), (5.0 + 0.75) * exp(0.25)]
    assert marks[FASTEST] == pytest.approx(max(sizes), rel=1e-14)
    assert (marks[LOOSE], marks[SLOWNESS], marks[SLOWEST], marks[TURN_ROOM]) == (1.0, 1.0, 1.0, 1.0)
    assert marks[TURNING:] == [0.0, inf, inf] * 2
    # With friction: -3 and -8; at 5 it lacks 3.75 of 5.75 - 2.
    _, marks = columns(monkeypatch, [0.0, 1.0], 0.0, over)
    assert marks[FASTEST] == pytest.approx((sqrt(65.0) + 0.5) * exp(0.375), rel=1e-14)
    assert marks[TURNING:] == [1.0 / 7.75, 7.75, inf, 0.0, inf, inf]
    assert (marks[LEVEL], marks[SPEED]) == (3.75, 0.5)
    # Held from 1 on under 1: it slowed by 2 + 1/4, and is held for the half that is left.
    _, marks = columns(monkeypatch, [0.0, 1.0], 1.0, [(0.5, TURNED, 1.0, 0.0), (0.5, 0, 1.0, 0.0)])
    assert marks[TURNING:] == [1.0 / 2.25, 2.25, 1.125, 0.0, inf, inf]
    assert (marks[LEVEL], marks[SPEED]) == (1.75, inf)
    # One that is held has no accelerations.
    assert columns(monkeypatch, [0.0, 0.0], 1.0, [(1.0, 0, 0.0, 0.0)])[1][FASTEST] == 0.0


@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-14, 3e-13])
def test_a_knob_that_has_settled_is_moved_at_once(off: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """It balances to a rounding, and would turn round at each: in steps of a rounding of the time."""
    body, asked = body_of("strong"), 0
    cogs = body.cogs
    x = cogs[CENTRE] + 0.125 * cogs[LENGTH]
    u = -float(Cogged(body, [x, 0.0], 0.0).pull() @ [x, 0.0, 1.0, 0.0]) + off
    real = slope_columns.roll

    def roll(*given: Any) -> Any:
        nonlocal asked
        asked += 1
        assert asked < 9
        return real(*given)

    monkeypatch.setattr(slope_columns, "roll", roll)
    z, pad, marks = [x, 0.0], [0.0] * 4, fresh_marks()
    cols = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]  # of angle, speed, and the command
    cog_columns(cogs, z, u, 1.0, body, pad, Columns(cols, 2, 3, 2), marks)
    assert asked == 1
    assert z[0] == pytest.approx(x, abs=1e-11 * (1.0 + abs(x)))
    assert (marks[LEVEL], marks[SPEED]) == (inf, inf)
    room = 0.375 * cogs[LENGTH]
    assert room - 2e-11 * (1.0 + abs(x)) < marks[CORNER_ROOM] <= room


def test_what_a_settled_knob_may_move_is_no_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a count; with friction nothing has settled."""
    monkeypatch.setattr(slopes, "STILL", 0.25)
    monkeypatch.setattr(slopes, "far_apart", lambda *_: 1.0)
    for body, mark, mode in ((PLAIN, 2.5, FREE), (PLAIN._replace(friction=0.5), 3.0, 1), (RUBS, 3.0, 1)):
        script, marks = columns(monkeypatch, [1.0, 0.5], 0.0, [(0.5, 0, 1.0, 0.5)], body, span=0.5)
        assert marks[CORNER_ROOM] == mark
        assert marks[TURN_ROOM] == (mark if body is PLAIN else inf)
        assert script.asked[0][1] == mode
    # As where nothing pulls at all.
    _, marks = columns(monkeypatch, [1.0, 0.0], 1.25, [(0.5, 0, 1.0, 0.0)], PLAIN, span=0.5)
    assert marks[TURN_ROOM] == 2.5


def test_a_knob_that_balances_where_no_springs_hold_it_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """On the top of cogging that is stiffer than the hand: no bound says that it stays, and no torque moves it."""
    cogs = [2.0, *COGS[1:]]
    script, marks = Spread(monkeypatch, [(1.0, 0, 8.0, 0.0)]), fresh_marks()
    cog_columns(cogs, [8.0, 0.0], 8.0, 1.0, PLAIN._replace(cogs=cogs), [0.0] * 4, NONE, marks)
    assert script.asked == [(1.0, FREE, 1.0, True)]
    # It may turn round anywhere, and at a moment that no mode ends at: nothing is said of the room there.
    assert marks[TURN_ROOM] == -1.0
