"""Trials of the general loop, counted by their end: where an orbit is entered, as what, and when an end is known.

States and verdicts of proofs are written down. What is the same to rounding differs by 1e-9 of 1 and its size at most.
"""

from math import nan
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    GREW,
    LEFT,
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
)
from hknob_cli.engine.general import ensemble
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.ensemble import (
    Batch,
    TrialSpace,
    begin,
    count_end,
    deepest,
    enter,
    enter_row,
    find,
    is_cycle,
    run_trials,
)
from hknob_cli.engine.general.follow import CYCLE_AT_EVENT, CYCLE_EXPANDS, CYCLE_PARTS, KNOWN
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS
from hknob_cli.engine.general.search import make_space
from tests.engine.trial_space import trial_of

from .test_standstill_margins import WALL, body

State = tuple[float, float]
NEAR = 1e-9 * 3.0  # of a position of 2
CYCLES = (CYCLE_PROVEN, CYCLE_ON_EDGE, CYCLE_CONTINUUM, CYCLE_AT_EVENT, CYCLE_EXPANDS, CYCLE_PARTS)


def a_row(fate: int, period: int, reading: float = 9.0, counted: float = 3.0) -> list[float]:
    return [float(fate), float(period), 0.5, 0.25, 0.125, 0.0625, counted, -2.0, -1.0, reading]


def with_room(z: list[float], ring: list[float], rows: list[list[float]], states: list[State], room: int) -> TrialSpace:
    """A trial beside ends that are known, with room for more."""
    space = make_space(2, len(ring), lambda count: [7.0] * count)
    known = len(rows)
    filled = [*rows, *([[7.0] * FIELDS] * room)]
    lines = [[7.0] * len(ring)] * len(filled)
    trial = trial_of(z, ring, space, filled, [*states, *([(7.0, 7.0)] * room)], lines)
    trial.counts[0] = float(known)
    return trial


def test_a_cycle_is_one_by_its_fate() -> None:
    assert all(is_cycle(fate) for fate in CYCLES)
    assert not any(is_cycle(fate) for fate in (REST_PROVEN, REST_EDGE, UNSETTLED, LEFT, GREW, UNDAMPED, KNOWN))


def test_a_trial_begins_without_a_torque(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[Any] = []
    monkeypatch.setattr(ensemble, "advance_span", lambda z, *given: told.append((list(z), *given)))
    begin([9.0, 9.0], [2.0, -3.0], 0.25, SimpleNamespace(order=2), "pad")
    assert told == [([2.0, -3.0], 0.0, 0.25, SimpleNamespace(order=2), "pad")]


# The deepest sample.


class Orbit:
    """An orbit over scripted states; commands under way are numbers of samples, and turn in their line."""

    def __init__(self, patch: pytest.MonkeyPatch, states: list[State], lines: list[list[float]] | None = None) -> None:
        self.at, self.states, self.lines = 0, states, lines
        patch.setattr(ensemble, "advance", self.advance)

    def line(self, at: int) -> list[float]:
        """Oldest first."""
        return self.lines[at % len(self.lines)] if self.lines else []

    def put(self, ring: list[float], head: int) -> None:
        for j, u in enumerate(self.line(self.at)):
            ring[(head + j) % len(ring)] = u

    def advance(self, z: Any, before: float, ring: Any, head: int, one: Any, wall: Any, pad: Any) -> tuple[float, int]:
        assert (one.order, wall, pad) == (2, WALL, [7.0] * 8)
        shown = z[0] - 100.0  # tells where it was
        self.at += 1
        z[:] = self.states[self.at % len(self.states)]
        head = (head + 1) % len(ring) if ring else head
        self.put(ring, head)
        return shown, head

    def turned(self, period: int, head: int = 0) -> Any:
        """Reading before, period, state and line, oldest first, at the deepest sample."""
        ring = [0.0] * len(self.line(0))
        self.at = 0
        self.put(ring, head)
        trial = with_room(list(self.states[0]), ring, [], [], 1)
        before, head, period = deepest(-99.0, head, period, trial, body(), WALL)
        return before, period, trial.z, [ring[(head + j) % len(ring)] for j in range(len(ring))]


@pytest.mark.parametrize("first", range(4))
@pytest.mark.parametrize("delay", [0, 2, 3])
def test_an_orbit_is_turned_to_its_deepest_sample(monkeypatch: pytest.MonkeyPatch, first: int, delay: int) -> None:
    states: list[State] = [(-1.0, 0.5), (-2.0, 0.25), (-3.0, 0.0), (-2.0, -0.25)]
    states = states[first:] + states[:first]
    lines = [[float(10 * at + j) for j in range(delay)] for at in range(4)]
    orbit = Orbit(monkeypatch, states, lines if delay else None)
    at = (2 - first) % 4
    before = states[at - 1][0] - 100.0 if at else -99.0
    for head in range(max(delay, 1)):
        for period in (4, 8, 12):
            assert orbit.turned(period, head) == (before, 4, [-3.0, 0.0], lines[at])
        assert orbit.turned(6, head)[1] == 6  # four do not divide it
        assert orbit.turned(7, head)[1] == 7


def test_of_samples_that_are_equally_deep_the_first_is_meant(monkeypatch: pytest.MonkeyPatch) -> None:
    orbit = Orbit(monkeypatch, [(-1.0, 0.5), (-3.0, 0.25), (-2.0, 0.0), (-3.0, 0.125)])
    assert orbit.turned(4) == (-101.0, 4, [-3.0, 0.25], [])
    assert Orbit(monkeypatch, [(-3.0, 0.25)]).turned(4) == (-99.0, 1, [-3.0, 0.25], [])


@pytest.mark.parametrize(("off", "period"), [(0.99, 2), (1.01, 4)])
def test_a_shorter_period_is_one_up_to_rounding(monkeypatch: pytest.MonkeyPatch, off: float, period: int) -> None:
    """In each number of the state, and of the commands under way."""
    for sign in (1.0, -1.0):
        nudge = sign * off * NEAR
        for dx, dv, du in ((nudge, 0.0, 0.0), (0.0, nudge, 0.0), (0.0, 0.0, nudge)):
            states: list[State] = [(-2.0, 2.0), (-1.0, 0.0), (-2.0 + dx, 2.0 + dv), (-1.0, 0.0)]
            lines = [[2.0, 3.0], [0.0, 0.0], [2.0 + du, 3.0], [0.0, 0.0]]
            assert Orbit(monkeypatch, states, lines).turned(4)[1] == period
    # The last command under way counts as the first does.
    states = [(-2.0, 2.0), (-1.0, 0.0)]
    nudge = off * 1e-9 * 4.0
    lines = [[2.0, 3.0 + nudge], [0.0, 0.0], [2.0, 3.0], [0.0, 0.0]]
    assert Orbit(monkeypatch, states, lines).turned(4)[1] == period


# Ends that are known.


def test_an_end_is_known_by_fate_period_and_place() -> None:
    """Rests that friction holds by their reading; what has no period by its fate alone."""
    table = [x for one in (a_row(CYCLE_PROVEN, 4), a_row(CYCLE_PROVEN, 6), a_row(UNSETTLED, 0)) for x in one]
    states = [-2.0, 2.0, -2.0, 2.0, 9.0, 9.0]
    for fate, period, z, row in (
        (CYCLE_PROVEN, 4, [-2.0, 2.0], 0),
        (CYCLE_PROVEN, 6, [-2.0, 2.0], 1),
        (CYCLE_PROVEN, 5, [-2.0, 2.0], 3),
        (CYCLE_ON_EDGE, 4, [-2.0, 2.0], 3),
        (UNSETTLED, 0, [-2.0, 2.0], 2),
        (LEFT, 0, [-2.0, 2.0], 3),
        (CYCLE_PROVEN, 6, [-2.0 + 0.99 * NEAR, 2.0 - 0.99 * NEAR], 1),
        (CYCLE_PROVEN, 6, [-2.0 - 1.01 * NEAR, 2.0], 3),
        (CYCLE_PROVEN, 6, [-2.0, 2.0 + 1.01 * NEAR], 3),
    ):
        assert find(fate, period, z, nan, 3, table, states, 2) == row
    assert find(CYCLE_PROVEN, 6, [-2.0, 2.0], nan, 1, table, states, 2) == 1  # of the first row alone
    rests = [x for one in (a_row(REST_PROVEN, 1, -3.0), a_row(REST_PROVEN, 1, -2.0)) for x in one]
    for shown, row in ((-3.0, 0), (-2.0, 1), (-1.0, 2)):
        assert find(REST_PROVEN, 1, [-2.0, 2.0], shown, 2, rests, states, 2) == row


@pytest.mark.parametrize("head", [0, 1, 2])
def test_a_new_end_is_written_down_whole(head: int) -> None:
    """Its commands oldest first. Of an end at rest the row keeps from where to where its trials stand."""
    line = [0.0] * 3
    for j, u in enumerate((4.0, 5.0, 6.0)):
        line[(head + j) % 3] = u
    trial = with_room([-2.5, 0.25], line, [a_row(LEFT, 0)], [(1.0, 1.0)], 2)
    enter_row(1, CYCLE_PROVEN, 6, (0.5, 0.25, 0.125, 0.0625), -3.0, trial, head, False)
    assert trial.counts == [2.0]
    written = [float(CYCLE_PROVEN), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, -2.5, -2.5, -3.0]
    assert trial.table == [*a_row(LEFT, 0), *written, *[7.0] * FIELDS]
    assert trial.states == [1.0, 1.0, -2.5, 0.25, 7.0, 7.0]
    assert trial.lines == [7.0] * 3 + [4.0, 5.0, 6.0] + [7.0] * 3
    for x, least, most in ((-2.25, -2.5, -2.25), (-2.75, -2.75, -2.25), (-2.5, -2.75, -2.25)):
        trial.z[0] = x
        enter_row(1, REST_PROVEN, 1, (9.0, 9.0, 9.0, 9.0), 9.0, trial, head, False)
        enter_row(1, REST_PROVEN, 1, (9.0, 9.0, 9.0, 9.0), 9.0, trial, head, True)
        assert trial.table[FIELDS : 2 * FIELDS] == [*written[:7], least, most, -3.0]
    assert trial.counts == [2.0]


# What a trial has come to.


class Entry:
    """One end to be entered; the deepest sample and what proofs say there are written down."""

    def __init__(self, patch: pytest.MonkeyPatch, proofs: list[int], turned: int | None = None) -> None:
        """``proofs``: one after the other; ``turned``: the shortest period, if the orbit has a shorter one."""
        self.proofs, self.turned, self.asked = list(proofs), turned, list[Any]()
        patch.setattr(ensemble, "deepest", self.deepest)
        patch.setattr(ensemble, "certify", self.certify)

    def deepest(self, before: float, head: int, period: int, trial: Any, one: Any, wall: Any) -> Any:
        trial.z[:] = [-3.0, 0.5]
        return before - 1.0, 1, self.turned or period

    def certify(self, z: Any, before: float, ring: Any, head: int, period: int, one: Any, wall: Any, space: Any) -> Any:
        assert (z, before, head) == ([-3.0, 0.5], -6.0, 1)
        self.asked.append(period)
        k = len(self.asked)
        space.orbit[:], space.orbit_line[:], space.reading[0] = [-3.0 - 2.0**-30 * k, 0.5], [8.0 + k, 9.0], -4.0
        return self.proofs[k - 1], 0.5 * k, 0.25 * k, 0.125 * k, 0.0625 * k

    def run(self, fate: int, period: int, rows: Any = (), states: Any = (), room: int = 1, **more: Any) -> Any:
        wall, friction = more.get("wall", WALL), more.get("friction", 0.0)
        one = body(friction=friction)._replace(halt=[more.get("halt", 0.0)])
        self.trial = with_room(more.get("z", [-2.5, 0.25]), [4.0, 5.0], list(rows), list(states), room)
        return enter(fate, period, more.get("before", -5.0), 0, self.trial, one, wall)

    @property
    def written(self) -> list[float]:
        """The last row."""
        rows = int(self.trial.counts[0])
        return self.trial.table[FIELDS * (rows - 1) : FIELDS * rows]


def test_a_proven_orbit_is_entered_as_it_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    """The orbit's own state, commands and reading, not the trial's."""
    for status in (PROVEN, NOT_CAPTURED):
        entry = Entry(monkeypatch, [status])
        assert entry.run(CYCLE_PROVEN, 6) == 0
        x = -3.0 - 2.0**-30
        assert entry.asked == [6]
        assert entry.written == [float(CYCLE_PROVEN), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, x, x, -4.0]
        assert entry.trial.states[:2] == [x, 0.5]
        assert entry.trial.lines[:2] == [9.0, 9.0]


def test_an_orbit_that_is_known_is_not_proven_again(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = Entry(monkeypatch, [])
    assert entry.run(CYCLE_PROVEN, 6, [a_row(LEFT, 0), a_row(CYCLE_PROVEN, 6)], [(9.0, 9.0), (-3.0, 0.5)]) == 1
    assert entry.trial.counts == [2.0]


@pytest.mark.parametrize(
    ("status", "fate"),
    [(ON_EDGE, CYCLE_ON_EDGE), (AT_EVENT, CYCLE_AT_EVENT), (PARTS, CYCLE_PARTS), (EXPANDS, CYCLE_EXPANDS)],
)
def test_a_proof_that_fails_at_the_deepest_sample_is_none(
    monkeypatch: pytest.MonkeyPatch, status: int, fate: int
) -> None:
    """It is entered as what that says, with the trial's state; the next one of that kind is the same end."""
    entry = Entry(monkeypatch, [status])
    assert entry.run(CYCLE_PROVEN, 6) == 0
    assert entry.written == [float(fate), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, -3.0, -3.0, -6.0]
    assert entry.trial.lines[:2] == [5.0, 4.0]
    entry = Entry(monkeypatch, [status])
    assert entry.run(CYCLE_PROVEN, 6, [a_row(LEFT, 0), a_row(fate, 6)], [(9.0, 9.0), (-3.0, 0.5)]) == 1
    assert (entry.asked, entry.trial.counts) == ([6], [2.0])


@pytest.mark.parametrize("fate", CYCLES)
@pytest.mark.parametrize("status", [DIFFERENT, NEUTRAL])
def test_what_is_no_orbit_there_has_not_settled(monkeypatch: pytest.MonkeyPatch, fate: int, status: int) -> None:
    """A failed proof that says so; of what was none before, only that readings differ."""
    entry = Entry(monkeypatch, [status])
    assert entry.run(fate, 6) == 0
    if status == DIFFERENT or fate == CYCLE_PROVEN:
        assert entry.written == [float(UNSETTLED), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -3.0, -3.0, -6.0]
        entry = Entry(monkeypatch, [status])
        assert entry.run(fate, 6, [a_row(UNSETTLED, 0)], [(9.0, 9.0)]) == 0
        assert entry.trial.counts == [1.0]
    else:
        assert entry.written == [float(fate), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, -3.0, -3.0, -6.0]


@pytest.mark.parametrize("fate", CYCLES[1:])
def test_what_was_not_proven_is_not_proven_by_being_turned(monkeypatch: pytest.MonkeyPatch, fate: int) -> None:
    entry = Entry(monkeypatch, [PROVEN])
    assert entry.run(fate, 6) == 0
    assert entry.written == [float(fate), 6.0, 0.5, 0.25, 0.125, 0.0625, 0.0, -3.0, -3.0, -6.0]


def test_a_shorter_turn_that_was_near_not_equal_is_an_orbit_of_all_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is proven with its whole period, of which another trial may have told before."""
    entry = Entry(monkeypatch, [DIFFERENT, PROVEN], turned=2)
    assert entry.run(CYCLE_PROVEN, 6) == 0
    assert entry.asked == [2, 6]
    x = -3.0 - 2.0**-29
    assert entry.written == [float(CYCLE_PROVEN), 6.0, 1.0, 0.5, 0.25, 0.125, 0.0, x, x, -4.0]
    entry = Entry(monkeypatch, [DIFFERENT, PROVEN], turned=2)
    known = [a_row(LEFT, 0), a_row(CYCLE_PROVEN, 6)]
    assert entry.run(CYCLE_PROVEN, 6, known, [(9.0, 9.0), (-3.0, 0.5)]) == 1
    # It is not tried where the whole period was, and where the shorter one is proven.
    for turned, status in ((6, DIFFERENT), (2, PROVEN), (2, ON_EDGE)):
        entry = Entry(monkeypatch, [status], turned=turned)
        entry.run(CYCLE_PROVEN, 6)
        assert entry.asked == [turned]
    entry = Entry(monkeypatch, [DIFFERENT, DIFFERENT], turned=2)
    entry.run(CYCLE_PROVEN, 6)
    assert entry.asked == [2, 6]
    assert entry.written[:6] == [float(UNSETTLED), 0.0, 0.0, 0.0, 0.0, 0.0]


def test_a_rest_is_entered_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without friction by its place. With it by its reading: with a continuous sensor, by the side of the wall."""
    analog = WALL._replace(analog=1.0)
    for fate in (REST_PROVEN, REST_EDGE):
        for z, wall, friction, last in (
            ([-2.5, 0.0], WALL, 0.0, -5.0),
            ([-2.5, 0.0], WALL, 0.5, -3.0),
            ([-2.5, 0.0], WALL, 1.5, -3.0),
            ([-2.5, 0.0], WALL._replace(hysteresis=1.5), 0.5, -4.0),
            ([-2.5, 0.0], analog, 0.5, -1.0),
            ([0.0, 0.0], analog, 0.5, 0.0),
            ([0.5, 0.0], analog, 1.5, 0.0),
            ([-0.5, 0.0], analog, 0.5, -1.0),
            ([-0.5, 0.0], analog, 0.0, -5.0),
            ([-2.5, 0.0], WALL._replace(analog=0.5), 0.5, -1.0),
        ):
            entry = Entry(monkeypatch, [])
            assert entry.run(fate, 1, wall=wall, friction=friction, z=list(z)) == 0
            assert entry.written == [float(fate), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, z[0], z[0], last]
            other = Entry(monkeypatch, [])
            known, place = a_row(fate, 1, last), (z[0] + (0.25 if friction else 0.0), 0.0)
            assert other.run(fate, 1, [known], [place], wall=wall, friction=friction, z=list(z)) == 0
            assert other.trial.counts == [1.0]
            assert other.trial.table[7:9] == [min(-2.0, z[0]), max(-1.0, z[0])]
    # What moves has no rest's reading.
    entry = Entry(monkeypatch, [PROVEN])
    entry.run(CYCLE_PROVEN, 6, friction=0.5)
    assert entry.written[9] == -4.0
    for wall in (WALL, analog):  # it is known by its place, whatever was read there
        for place, row in (((-3.0, 0.5), 0), ((-2.0, 0.5), 1)):
            entry = Entry(monkeypatch, [PROVEN])
            assert entry.run(CYCLE_PROVEN, 6, [a_row(CYCLE_PROVEN, 6, -3.0)], [place], friction=0.5, wall=wall) == row
    entry = Entry(monkeypatch, [])
    entry.run(LEFT, 0, friction=0.5)
    assert entry.written[9] == -5.0
    assert entry.written[7:9] == [-2.5, -2.5]
    entry = Entry(monkeypatch, [])
    assert entry.run(LEFT, 0, [a_row(LEFT, 0)], [(9.0, 9.0)], friction=0.5) == 0
    assert entry.trial.table[7:9] == [-2.0, -1.0]


def test_without_room_or_time_nothing_is_entered(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = Entry(monkeypatch, [PROVEN])
    assert entry.run(CYCLE_PROVEN, 6, [a_row(LEFT, 0)], [(9.0, 9.0)], room=0) == 1
    assert entry.trial.table == a_row(LEFT, 0)
    for halt in (0.5, 1.0):
        entry = Entry(monkeypatch, [PROVEN])
        assert entry.run(CYCLE_PROVEN, 6, halt=halt) == -1
        assert entry.trial.counts == [0.0]


# A batch.


def test_an_end_is_counted_or_finds_no_room() -> None:
    trial = with_room([0.0, 0.0], [], [a_row(LEFT, 0), a_row(UNSETTLED, 0)], [(9.0, 9.0)] * 2, 0)
    assert count_end(1, trial) == 0
    assert [trial.table[6], trial.table[FIELDS + 6]] == [3.0, 4.0]
    assert count_end(2, trial) == 1
    assert [trial.table[6], trial.table[FIELDS + 6]] == [3.0, 4.0]


class Run:
    """A batch of trials whose ends are written down: fate, row that `enter` gives, samples."""

    def __init__(self, patch: pytest.MonkeyPatch, ends: list[tuple[int, int, int]], delay: int = 2) -> None:
        self.ends, self.told, self.at = ends, list[Any](), 0
        self.body = body()
        for name in ("begin", "begin_clock", "pass_over", "follow_trial", "enter"):
            patch.setattr(ensemble, name, getattr(self, name))
        self.trial = with_room([-9.0, 9.0], [9.0] * delay, [a_row(LEFT, 0)] * 2, [(9.0, 9.0)] * 2, 0)

    def begin(self, z: Any, start: Any, part: float, one: Any, pad: Any) -> None:
        self.told.append(("begin", start, part))
        z[:] = [-2.5, 0.0]

    def begin_clock(self, clock: Any, number: float) -> None:
        self.told.append(("clock", clock, number))

    def pass_over(self, z: Any, before: float, ring: Any, head: int, budget: TrialBudget, *_: Any) -> Any:
        self.told.append(("pass", before, list(ring), head, budget))
        return -7.0, 1

    def follow_trial(self, trial: Any, before: float, head: int, budget: Any, one: Any, wall: Any) -> Any:
        self.told.append(("follow", before, head))
        fate, row, used = self.ends[self.at]
        if fate == KNOWN:
            self.at += 1
        elif fate < -1:
            one.halt[0] = 0.5
        return fate, row if fate == KNOWN else 6, -8.0, 0, used

    def enter(self, fate: int, period: int, before: float, head: int, *given: Any) -> int:
        self.told.append(("enter", fate, period, before, head))
        self.at += 1
        return self.ends[self.at - 1][1]

    def run(self, batch: Batch) -> Any:
        return run_trials([1.0, 2.0], batch, TrialBudget(5, 99, True, 1e6), self.trial, self.body, WALL)


def test_trials_are_begun_passed_over_followed_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The middle of each part of the first interval; what is skipped counts as samples."""
    one = Run(monkeypatch, [(CYCLE_PROVEN, 0, 30), (KNOWN, 1, 40), (UNSETTLED, 2, 50), (KNOWN, 2, 1)])
    assert one.run(Batch(8, 3, 7)) == (2, 30 + 40 + 50 + 1 + 4 * 5)
    assert [one.trial.table[6], one.trial.table[FIELDS + 6]] == [4.0, 4.0]
    begun = [
        step
        for i in range(3, 7)
        for step in (
            ("begin", [1.0, 2.0], (i + 0.5) / 8.0),
            ("clock", None, float(i)),
            ("pass", -3.0, [0.0, 0.0], 0, TrialBudget(5, 99, True, 1e6)),
            ("follow", -7.0, 1),
        )
    ]
    begun.insert(4, ("enter", CYCLE_PROVEN, 6, -8.0, 0))
    begun.insert(4 + 1 + 8, ("enter", UNSETTLED, 6, -8.0, 0))
    assert one.told == begun


def test_once_halted_no_trial_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    for ends, samples in (
        ([(KNOWN, 0, 30), (-9, 0, 40)], 30 + 40 + 10),
        ([(KNOWN, 0, 30), (CYCLE_PROVEN, -1, 40)], 30 + 40 + 10),
    ):
        one = Run(monkeypatch, ends, delay=0)
        assert one.run(Batch(8, 0, 7)) == (0, samples)
        assert [one.trial.table[6], one.trial.table[FIELDS + 6]] == [4.0, 3.0]
