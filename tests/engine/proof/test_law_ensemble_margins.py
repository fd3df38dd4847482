"""Trials under a law, counted by their end: where an orbit is entered, as what, and what a rest is proven by.

States, memory and verdicts of proofs are written down.
"""

from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    LEFT,
    REST_EDGE,
    REST_PROVEN,
    UNSETTLED,
)
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.ensemble import Batch, TrialSpace
from hknob_cli.engine.general.follow import CYCLE_AT_EVENT, CYCLE_EXPANDS, CYCLE_PARTS, KNOWN
from hknob_cli.engine.general.laws import trials
from hknob_cli.engine.general.laws.law import AT_SWITCH, CYCLE_AT_SWITCH, CYCLE_NOT_AFFINE, REST_NOT_PROVEN
from hknob_cli.engine.general.laws.trials import (
    SAME,
    enter_with_law,
    is_cycle_of_law,
    rest_of_law,
    run_trials_with_law,
    turn_to_deepest,
)
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS

from .test_general_ensemble_margins import CYCLES, NEAR, State, a_row, with_room
from .test_standstill_margins import WALL, body

ALL_CYCLES = (*CYCLES, CYCLE_AT_SWITCH, CYCLE_NOT_AFFINE)
RESTS = (REST_PROVEN, REST_EDGE, REST_NOT_PROVEN)
ANALOG = WALL._replace(analog=1.0)


def law_of(**more: Any) -> Any:
    """It remembers two numbers, and a torque; the second is the count where there is hysteresis."""
    one = {
        "line": 2,
        "drifts": -1,
        "senses": False,
        "provable": True,
        "unproven": CYCLE_NOT_AFFINE,
        "room": [0.75],
        "watch": WALL,
    }
    return SimpleNamespace(**(one | {"periodic": [8.0, 8.5, 9.0]} | more))


def test_two_more_fates_are_cycles_under_a_law() -> None:
    assert all(is_cycle_of_law(fate) for fate in ALL_CYCLES)
    assert not any(is_cycle_of_law(fate) for fate in (*RESTS, UNSETTLED, LEFT, KNOWN))


# The deepest sample.


class Orbit:
    """An orbit over scripted states and memories."""

    def __init__(self, patch: pytest.MonkeyPatch, states: list[State], pasts: list[list[float]]) -> None:
        self.states, self.pasts = states, pasts
        patch.setattr(trials, "advance_with_law", self.advance)

    def advance(self, z: Any, past: Any, one: Any, wall: Any, law: Any, pad: Any) -> None:
        assert (one.order, wall, pad) == (2, WALL, [7.0] * 8)
        self.at += 1
        z[:] = self.states[self.at % len(self.states)]
        past[:] = self.pasts[self.at % len(self.pasts)]

    def turned(self, period: int, law: Any = None) -> Any:
        self.at = 0
        trial = with_room(list(self.states[0]), list(self.pasts[0]), [], [], 1)
        return turn_to_deepest(period, trial, body(), WALL, law or law_of()), trial.z, trial.ring


@pytest.mark.parametrize("first", range(4))
def test_an_orbit_is_turned_to_its_deepest_sample(monkeypatch: pytest.MonkeyPatch, first: int) -> None:
    """With what is remembered there."""
    states: list[State] = [(-1.0, 0.5), (-2.0, 0.25), (-3.0, 0.0), (-2.0, -0.25)]
    pasts = [[float(10 * at + j) for j in range(3)] for at in range(4)]
    orbit = Orbit(monkeypatch, states[first:] + states[:first], pasts[first:] + pasts[:first])
    for period in (4, 8, 12):
        assert orbit.turned(period) == (4, [-3.0, 0.0], pasts[2])
    for period in (6, 7):
        assert orbit.turned(period)[0] == period
    level = Orbit(monkeypatch, [(-1.0, 0.5), (-3.0, 0.25), (-2.0, 0.0), (-3.0, 0.125)], pasts)
    assert level.turned(4) == (4, [-3.0, 0.25], pasts[1])
    assert Orbit(monkeypatch, [(-3.0, 0.25)], [[1.0, 2.0, 3.0]]).turned(4) == (1, [-3.0, 0.25], [1.0, 2.0, 3.0])


@pytest.mark.parametrize(("off", "period"), [(0.99, 2), (1.01, 4)])
def test_a_shorter_period_is_one_up_to_rounding(monkeypatch: pytest.MonkeyPatch, off: float, period: int) -> None:
    """In each number of the state and of what is remembered. Torques follow from these, and what drifts may differ."""
    nudge = off * NEAR
    for sign in (1.0, -1.0):
        for dx, dv, first, second in ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0, 0, 0, 1.0)):
            states: list[State] = [
                (-2.0, 2.0),
                (-1.0, 0.0),
                (-2.0 + sign * dx * nudge, 2.0 + sign * dv * nudge),
                (-1.0, 0.0),
            ]
            pasts = [[2.0, 2.0, 1.0], [0.0] * 3, [2.0 + sign * first * nudge, 2.0 + sign * second * nudge, 5.0]]
            orbit = Orbit(monkeypatch, states, [*pasts, [0.0] * 3])
            assert orbit.turned(4)[0] == period
            if second:
                assert orbit.turned(4, law_of(drifts=1))[0] == 2
    assert SAME == 1e-9


# What is the same at every sample.


@pytest.mark.parametrize(
    ("status", "fate"),
    [(PROVEN, REST_PROVEN), (NOT_CAPTURED, REST_PROVEN), (ON_EDGE, REST_EDGE)]
    + [(status, REST_NOT_PROVEN) for status in (DIFFERENT, EXPANDS, AT_SWITCH, NEUTRAL)],
)
def test_a_rest_is_proven_as_a_period_of_one(monkeypatch: pytest.MonkeyPatch, status: int, fate: int) -> None:
    told: list[Any] = []
    monkeypatch.setattr(trials, "certify_with_law", lambda *given: told.append(given[:3]) or (status, 9.0, 9, 9, 9))
    trial, law = with_room([-2.5, 0.25], [1.0, 2.0, 3.0], [], [], 1), law_of()
    trial.space.orbit[:] = [-2.25, 0.0]
    assert rest_of_law(trial, body(), WALL, law) == fate
    moved = fate == REST_PROVEN
    assert (trial.z, trial.ring) == (([-2.25, 0.0], [8.0, 8.5, 9.0]) if moved else ([-2.5, 0.25], [1.0, 2.0, 3.0]))
    assert told == [(trial.z, trial.ring, 1)]
    assert rest_of_law(trial, body(), WALL, law_of(provable=False)) == REST_NOT_PROVEN
    assert len(told) == 1


# What a trial has come to.


class Entry:
    """One end to be entered; the deepest sample and what proofs say there are written down."""

    trial: TrialSpace

    def __init__(
        self, patch: pytest.MonkeyPatch, proofs: list[int], turned: int | None = None, rest: int = REST_PROVEN
    ) -> None:
        """``turned``: the shortest period; ``rest``: what `rest_of_law` says."""
        self.proofs, self.turned, self.rest, self.asked = list(proofs), turned, rest, list[Any]()
        for name in ("turn_to_deepest", "certify_with_law", "rest_of_law"):
            patch.setattr(trials, name, getattr(self, name))

    def turn_to_deepest(self, period: int, trial: Any, one: Any, wall: Any, law: Any) -> int:
        trial.z[:] = [-3.0, 0.5]
        return self.turned or period

    def rest_of_law(self, *_: Any) -> int:
        self.asked.append("rest")
        return self.rest

    def certify_with_law(self, z: Any, past: Any, period: int, one: Any, wall: Any, law: Any, space: Any) -> Any:
        assert (z, past) == ([-3.0, 0.5], [1.0, -4.0, 3.0])
        self.asked.append(period)
        k = len(self.asked)
        space.orbit[:] = [-3.0 - 2.0**-30 * k, 0.5]
        return self.proofs[k - 1], 0.5 * k, 0.25 * k, 0.125 * k, 0.0625 * k

    def run(self, fate: int, period: int, rows: Any = (), states: Any = (), room: int = 1, **more: Any) -> int:
        one = body(friction=more.get("friction", 0.0))._replace(halt=[more.get("halt", 0.0)])
        z = list(more.get("z", [-2.5, 0.25]))
        self.trial = with_room(z, [1.0, -4.0, 3.0], list(rows), list(states), room)
        law = more.get("law") or law_of()
        return int(enter_with_law(fate, period, self.trial, one, more.get("wall", WALL), law))

    @property
    def written(self) -> list[float]:
        """The last row."""
        rows = int(self.trial.counts[0])
        return list(self.trial.table[FIELDS * (rows - 1) : FIELDS * rows])


def test_a_proven_orbit_is_entered_as_it_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    """The orbit's own state and memory, and by how much its guards clear all errors."""
    for status in (PROVEN, NOT_CAPTURED):
        entry = Entry(monkeypatch, [status])
        assert entry.run(CYCLE_PROVEN, 6) == 0
        x = -3.0 - 2.0**-30
        assert entry.written == [float(CYCLE_PROVEN), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, x, x, 0.75]
        assert (entry.trial.states[:2], entry.trial.lines[:3]) == ([x, 0.5], [8.0, 8.5, 9.0])
    for fate in ALL_CYCLES[1:]:
        entry = Entry(monkeypatch, [PROVEN])
        assert entry.run(fate, 6) == 0
        assert entry.written == [float(fate), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, -3.0, -3.0, 0.75]
        assert entry.trial.lines[:3] == [1.0, -4.0, 3.0]
    entry = Entry(monkeypatch, [])
    assert entry.run(CYCLE_PROVEN, 6, [a_row(LEFT, 0), a_row(CYCLE_PROVEN, 6)], [(9.0, 9.0), (-3.0, 0.5)]) == 1
    assert (entry.asked, entry.trial.counts) == ([], [2.0])


@pytest.mark.parametrize(
    ("status", "provable", "fate"),
    [
        *((ON_EDGE, True, CYCLE_ON_EDGE), (AT_EVENT, True, CYCLE_AT_EVENT), (PARTS, True, CYCLE_PARTS)),
        *((EXPANDS, True, CYCLE_EXPANDS), (EXPANDS, False, CYCLE_NOT_AFFINE), (NEUTRAL, True, CYCLE_CONTINUUM)),
        (AT_SWITCH, True, CYCLE_AT_SWITCH),
    ],
)
def test_a_proof_that_fails_at_the_deepest_sample_is_none(
    monkeypatch: pytest.MonkeyPatch, status: int, provable: bool, fate: int
) -> None:
    """It is entered as what that says, with the trial's state; the next one of that kind is the same end."""
    law = law_of(provable=provable)
    entry = Entry(monkeypatch, [status])
    assert entry.run(CYCLE_PROVEN, 6, law=law) == 0
    assert entry.written == [float(fate), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, -3.0, -3.0, 0.75]
    assert entry.trial.lines[:3] == [1.0, -4.0, 3.0]
    entry = Entry(monkeypatch, [status])
    assert entry.run(CYCLE_PROVEN, 6, [a_row(LEFT, 0), a_row(fate, 6)], [(9.0, 9.0), (-3.0, 0.5)], law=law) == 1
    assert (entry.asked, entry.trial.counts) == ([6], [2.0])
    other = next(one for one in ALL_CYCLES[1:] if one != fate)
    entry = Entry(monkeypatch, [status])
    assert entry.run(other, 6, law=law) == 0  # what was not proven stays what it was
    assert entry.written[0] == other


@pytest.mark.parametrize("fate", ALL_CYCLES)
def test_what_has_other_readings_there_has_not_settled(monkeypatch: pytest.MonkeyPatch, fate: int) -> None:
    for proofs, turned in (([DIFFERENT], None), ([DIFFERENT, DIFFERENT], 2)):
        entry = Entry(monkeypatch, proofs, turned)
        assert entry.run(fate, 6) == 0
        assert entry.asked == ([2, 6] if turned else [6])
        assert entry.written == [float(UNSETTLED), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -3.0, -3.0, 0.75]
        entry = Entry(monkeypatch, proofs, turned)
        assert entry.run(fate, 6, [a_row(UNSETTLED, 0)], [(9.0, 9.0)]) == 0
        assert entry.trial.counts == [1.0]


def test_a_shorter_turn_that_was_near_not_equal_is_an_orbit_of_all_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = Entry(monkeypatch, [DIFFERENT, PROVEN], turned=2)
    assert entry.run(CYCLE_PROVEN, 6) == 0
    x = -3.0 - 2.0**-29
    assert entry.written == [float(CYCLE_PROVEN), 6.0, 1.0, 0.5, 0.25, 0.125, 0.0, x, x, 0.75]
    entry = Entry(monkeypatch, [DIFFERENT, PROVEN], turned=2)
    known = [a_row(LEFT, 0), a_row(CYCLE_PROVEN, 6)]
    assert entry.run(CYCLE_PROVEN, 6, known, [(9.0, 9.0), (-3.0, 0.5)]) == 1
    for turned, status in ((2, PROVEN), (2, ON_EDGE)):
        entry = Entry(monkeypatch, [status], turned=turned)
        entry.run(CYCLE_PROVEN, 6)
        assert entry.asked == [turned]


def test_what_repeats_at_every_sample_is_a_rest_where_no_cycle_can_be_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under a law that senses the velocity, or that is not provable; else it is a cycle of one sample."""
    for senses, provable, rests in (
        (False, True, False),
        (True, True, True),
        (False, False, True),
        (True, False, True),
    ):
        law = law_of(senses=senses, provable=provable)
        for fate in RESTS:
            for turned in (None, 1):
                entry = Entry(monkeypatch, [PROVEN], turned, rest=fate)
                assert entry.run(CYCLE_EXPANDS, 1 if turned is None else 6, law=law) == 0
                assert entry.asked == (["rest"] if rests else [1])
                assert entry.written[:2] == [float(fate if rests else CYCLE_EXPANDS), 1.0]
                assert entry.written[2:6] == ([0.0] * 4 if rests else [0.5, 0.25, 0.125, 0.0625])
        entry = Entry(monkeypatch, [PROVEN], 2)
        entry.run(CYCLE_EXPANDS, 6, law=law)
        assert entry.asked == [2]
        entry = Entry(monkeypatch, [PROVEN])
        entry.run(REST_PROVEN, 1, law=law)
        assert entry.asked == []


@pytest.mark.parametrize("fate", RESTS)
def test_a_rest_is_entered_where_it_is(monkeypatch: pytest.MonkeyPatch, fate: int) -> None:
    """With friction by its reading: with a continuous sensor, by the side of the wall it is on."""
    for x, wall, friction, last in (
        (-2.5, WALL, 0.0, 0.75),
        (-2.5, WALL, 0.5, -3.0),
        (-2.5, WALL, 1.5, -3.0),
        (-2.5, WALL._replace(hysteresis=1.5), 0.5, -4.0),  # the count of the last turning point
        (-2.5, ANALOG, 0.5, -1.0),
        (0.0, ANALOG, 0.5, 0.0),
        (0.5, ANALOG, 1.5, 0.0),
        (-0.5, ANALOG, 0.5, -1.0),
        (-0.5, ANALOG, 0.0, 0.75),
        (-2.5, WALL._replace(analog=0.5), 0.5, -1.0),
    ):
        entry = Entry(monkeypatch, [])
        assert entry.run(fate, 1, wall=wall, friction=friction, z=(x, 0.0)) == 0
        assert entry.written == [float(fate), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, x, x, last]
        other = Entry(monkeypatch, [])
        place = (x + (0.25 if friction else 0.0), 0.0)
        assert other.run(fate, 1, [a_row(fate, 1, last)], [place], wall=wall, friction=friction, z=(x, 0.0)) == 0
        assert other.trial.counts == [1.0]
        assert other.trial.table[7:9] == [min(-2.0, x), max(-1.0, x)]
    for friction in (0.0, 0.5):
        entry = Entry(monkeypatch, [])
        entry.run(LEFT, 0, friction=friction)
        assert entry.written[7:] == [-2.5, -2.5, 0.75]
        entry = Entry(monkeypatch, [PROVEN])
        entry.run(CYCLE_ON_EDGE, 6, friction=friction, wall=ANALOG)
        assert entry.written[9] == 0.75
        for wall in (WALL, ANALOG):  # it is known by its place, whatever was read there
            for place, row in (((-3.0, 0.5), 0), ((-2.0, 0.5), 1)):
                entry = Entry(monkeypatch, [PROVEN])
                known = [a_row(CYCLE_PROVEN, 6, -3.0)]
                assert entry.run(CYCLE_PROVEN, 6, known, [place], friction=friction, wall=wall) == row


def test_without_room_or_time_nothing_is_entered(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = Entry(monkeypatch, [PROVEN])
    assert entry.run(CYCLE_PROVEN, 6, [a_row(LEFT, 0)], [(9.0, 9.0)], room=0) == 1
    assert entry.trial.table == a_row(LEFT, 0)
    for halt in (0.5, 1.0):
        entry = Entry(monkeypatch, [PROVEN])
        assert entry.run(CYCLE_PROVEN, 6, halt=halt) == -1
        assert entry.trial.counts == [0.0]


# A batch.


class Run:
    """A batch of trials whose ends are written down: fate, row that `enter_with_law` gives, samples."""

    def __init__(self, patch: pytest.MonkeyPatch, ends: list[tuple[int, int, int]], **more: Any) -> None:
        self.ends, self.told, self.at, self.more = ends, list[Any](), 0, more
        self.body, self.law = body(), law_of()
        for name in ("begin", "begin_past", "begin_clock", "follow_with_law", "enter_with_law"):
            patch.setattr(trials, name, getattr(self, name))
        patch.setattr(trials, "advance_with_law", lambda *given: self.advance("plain", *given))
        patch.setattr(trials, "advance_jittering_with_law", lambda *given: self.advance("jitters", *given))
        self.trial = with_room([-9.0, 9.0], [9.0] * 3, [a_row(LEFT, 0)] * 2, [(9.0, 9.0)] * 2, 0)

    def begin(self, z: Any, start: Any, part: float, one: Any, pad: Any) -> None:
        self.told.append(("begin", start, part))
        z[:] = [-2.5, 0.0]

    def begin_past(self, past: Any, shown: float, law: Any) -> None:
        self.told.append(("past", shown))

    def begin_clock(self, clock: Any, number: float) -> None:
        self.told.append(("clock", number))

    def advance(self, how: str, z: Any, past: Any, one: Any, wall: Any, law: Any, pad: Any) -> None:
        self.told.append(how)
        z[0] -= self.more.get("step", 0.0)
        if self.told.count(how) == self.more.get("halts"):
            one.halt[0] = 0.5

    def follow_with_law(self, *_: Any) -> Any:
        self.told.append("follow")
        fate, row, used = self.ends[self.at]
        if fate == KNOWN:
            self.at += 1
        elif fate < -1:
            self.body.halt[0] = 0.5
        return fate, row if fate == KNOWN else 6, used

    def enter_with_law(self, fate: int, period: int, *_: Any) -> int:
        self.told.append(("enter", fate, period))
        self.at += 1
        return self.ends[self.at - 1][1]

    def run(self, batch: Batch, wall: Any = WALL) -> Any:
        budget = TrialBudget(3, 99, True, 10.0)
        return run_trials_with_law([1.0, 2.0], batch, budget, self.trial, self.body, wall, self.law)


@pytest.mark.parametrize(("clock", "how"), [(None, "plain"), ([0.0] * 6, "jitters")])
def test_trials_are_begun_passed_over_followed_and_counted(
    monkeypatch: pytest.MonkeyPatch, clock: Any, how: str
) -> None:
    """The middle of each part of the first interval; what is skipped counts as samples."""
    one = Run(monkeypatch, [(CYCLE_PROVEN, 0, 30), (KNOWN, 1, 40), (UNSETTLED, 2, 50), (KNOWN, 2, 1)])
    assert one.run(Batch(8, 3, 7), WALL._replace(clock=clock)) == (2, 30 + 40 + 50 + 1 + 4 * 3)
    assert [one.trial.table[6], one.trial.table[FIELDS + 6]] == [4.0, 4.0]
    begun: list[Any] = []
    for i, fate in ((3, CYCLE_PROVEN), (4, None), (5, UNSETTLED), (6, None)):
        begun += [("begin", [1.0, 2.0], (i + 0.5) / 8.0), ("past", -3.0), ("clock", float(i)), how, how, how, "follow"]
        begun += [("enter", fate, 6)] if fate is not None else []
    assert one.told == begun


def test_a_trial_that_has_left_is_passed_over_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten counts away; or halted."""
    for step, more, passed in ((7.5, {}, 1), (4.0, {}, 2), (-6.25, {}, 2), (-6.2, {}, 3), (0.0, {"halts": 2}, 2)):
        one = Run(monkeypatch, [(KNOWN, 0, 30)], step=step, **more)
        found = one.run(Batch(8, 0, 1))
        assert one.told.count("plain") == passed
        assert found == (0, 33)
        assert one.trial.table[6] == (3.0 if more else 4.0)


def test_once_halted_no_trial_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    for ends in ([(KNOWN, 0, 30), (-9, 0, 40)], [(KNOWN, 0, 30), (CYCLE_PROVEN, -1, 40)]):
        one = Run(monkeypatch, ends)
        assert one.run(Batch(8, 0, 7)) == (0, 30 + 40 + 6)
        assert [one.trial.table[6], one.trial.table[FIELDS + 6]] == [4.0, 3.0]
