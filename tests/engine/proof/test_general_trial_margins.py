"""A trial of the general loop whose states, and what proofs say of them, are written down: what is made of them.

Its states are scripted instead of moved; so it stands exactly where a verdict, or an attempt at a proof, begins.
"""

from collections.abc import Callable
from math import inf, nextafter
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
from hknob_cli.engine.general import follow
from hknob_cli.engine.general import looks as rest
from hknob_cli.engine.general.captured import LOOK_AGAIN
from hknob_cli.engine.general.follow import (
    BESIDE,
    CYCLE_AT_EVENT,
    CYCLE_EXPANDS,
    CYCLE_PARTS,
    KNOWN,
    PATIENCE,
    PROOF_COST,
    downgrade,
    follow_trial,
    rubs_alone,
)
from hknob_cli.engine.general.laws.law import REST_NOT_PROVEN
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.general.standstill import SETTLING
from hknob_cli.engine.general.torque_curve import HEAD, HIGHEST, LOWEST, STOP
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS
from tests.engine.trial_space import trial_of

from .test_general_follow_margins import row
from .test_standstill_margins import WALL, body

State = tuple[float, float]
CONTINUOUS = WALL._replace(analog=1.0)
ORBIT, LINE, READING = [-3.25, 0.125], [5.0, 6.0, 7.0], -4.0
FIRST = 0.03  # counts of a first return that are worth an attempt


class Trial:
    """One trial over scripted states. Which proofs were asked for, and when, is noted."""

    def __init__(
        self,
        patch: pytest.MonkeyPatch,
        states: list[State],
        *,
        proofs: list[int] | Callable[[int], int] = lambda sample: DIFFERENT,
        rests: dict[int, int] | None = None,
        **more: Any,
    ) -> None:
        """``proofs``: what `certify` says, one time after another; ``rests``: what `settles` says at a sample."""
        self.at, self.states, self.proofs, self.rests = 0, states, proofs, rests or {}
        self.certified: list[tuple[int, int]] = []  # sample and period
        self.settled: list[int] = []
        self.asked: list[int] = []  # samples at which the known orbits are looked through
        self.trails: list[list[float]] = []
        self.more = {"closes": True, "captor": -1, "stands": False, "contracts": False, "margin": 0.0, "orbit": ORBIT}
        self.more |= more
        self.lines: list[list[float]] = more.get("lines", [[]] * len(states))
        for name in ("advance", "certify", "captured", "closes_in"):
            patch.setattr(follow, name, getattr(self, name))
        for name in ("settles", "stands", "contracts_to_rest"):
            patch.setattr(rest, name, getattr(self, name))
        patch.setattr(follow, "step_with_friction", self.slide)

    def advance(self, z: Any, before: float, ring: Any, head: int, one: Any, wall: Any, pad: Any) -> Any:
        shown = follow.read(z[0], wall)
        assert not self.more.get("slides")
        self.at += 1
        z[:], ring[:] = self.states[self.at], self.lines[self.at]
        return shown, self.more.get("head", 0)

    def slide(self, x: float, v: float, u: float, t: float, *rest: Any) -> State:
        assert self.more.get("slides")
        assert (x, v, t) == (*self.states[self.at], 1.0)
        self.at += 1
        return self.states[self.at]

    def certify(self, z: Any, before: float, ring: Any, head: int, period: int, one: Any, wall: Any, space: Any) -> Any:
        self.certified.append((self.at, period))
        status = self.proofs(self.at) if callable(self.proofs) else self.proofs[len(self.certified) - 1]
        space.orbit[:], space.orbit_line[:], space.reading[0] = self.more["orbit"], LINE[: len(ring)], READING
        return status, self.more["margin"], 0.0, 0.0, 0.0

    def settles(
        self, z: Any, shown: float, before: float, ring: Any, one: Any, wall: Any, orbit: Any, away: Any
    ) -> Any:
        self.settled.append(self.at)
        orbit[:] = self.more["orbit"]
        return self.rests.get(self.at, MOVING), 0.0

    def stands(self, *_: Any) -> bool:
        return bool(self.more["stands"])

    def contracts_to_rest(self, *_: Any) -> bool:
        return bool(self.more["contracts"])

    def captured(self, *_: Any) -> int:
        self.asked.append(self.at)
        return int(self.more["captor"])

    def closes_in(self, trial: Any, before: float, head: int, period: int, gap: float, *rest: Any) -> bool:
        self.trails.append(list(trial.space.trail[:period]))
        return bool(self.more["closes"])

    def run(self, one: Any = None, wall: Any = WALL, *, final: bool = True, limit: float = 1e9) -> Any:
        """``(fate, period, before, head, samples)``; where it is left, in ``z`` and ``ring``."""
        delay, rows = len(self.lines[0]), self.more.get("rows", [])
        space = make_space(2, delay, lambda count: [7.0] * count)
        space = space._replace(trail=[7.0] * self.more.get("trail", 9))
        self.z, self.ring = list(self.states[0]), list(self.lines[0])
        trial = trial_of(self.z, self.ring, space, rows, self.more.get("places", []))
        budget = TrialBudget(5, len(self.states) + 4, final, limit)  # what it skips has passed
        return follow_trial(trial, -9.0, 0, budget, one or body(), wall)


@pytest.fixture
def trial(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Trial]:
    return lambda states, **more: Trial(monkeypatch, states, **more)


def returns(gaps: list[float]) -> list[State]:
    """It steps deeper every second sample: 16 times apart, the last the checkpoint, then so far from that in speed."""
    speeds = [*[float(k + 1) for k in range(15)], 0.0, *gaps]
    return [state for v in speeds for state in ((0.5, v), (-0.5, v))] + [(-0.5, speeds[-1])]


def tried(gaps: list[float], trial: Callable[..., Trial], one: Any = None, wall: Any = WALL, **more: Any) -> list[bool]:
    """Of which returns to the checkpoint, of 16 at most, a proof is attempted."""
    assert len(gaps) <= 16
    found = trial(returns(gaps), **more)
    found.run(one or body(), wall)
    asked = [(sample - 33) // 2 for sample, _ in found.certified]
    assert [2 * (k + 1) for k in asked] == [period for _, period in found.certified]
    return [k in asked for k in range(len(gaps))]


# Returns.


def test_the_checkpoint_moves_on_after_1_2_4_and_8_steps_deeper(trial: Callable[..., Trial]) -> None:
    """So a period is looked for among 2, 4, ... samples, with the readings of each."""
    found = trial([(0.5, 0.0), (-0.5, 0.0)] * 9 + [(0.5, 0.0)])
    assert found.run() == (UNSETTLED, 0, -1.0, 0, 18)
    assert found.certified == [
        (2 * k + 1, period) for k, period in enumerate([2, 2, 4, 2, 4, 6, 8, 2], start=1)
    ]  # one turn after another
    assert found.trails == [[-1.0, 0.0] * (period // 2) for _, period in found.certified]
    short = trial([(0.5, 0.0), (-0.5, 0.0)] * 9 + [(0.5, 0.0)], trail=3)
    short.run()
    assert short.trails == [([-1.0, 0.0] * 4)[: min(3, period)] for _, period in found.certified]


def test_a_first_return_is_worth_an_attempt_below_its_tolerance(trial: Callable[..., Trial]) -> None:
    near = nextafter(FIRST, 0.0)
    assert tried([FIRST, near], trial) == [False, True]
    assert tried([-FIRST, -near], trial) == [False, True]
    assert tried([near, near], trial, closes=False) == [False, False]


def test_after_a_failure_it_must_come_twice_as_near(trial: Callable[..., Trial]) -> None:
    gap, half = 2.0**-6, 2.0**-7
    for status in (DIFFERENT, ON_EDGE, AT_EVENT, EXPANDS, PARTS):
        below = nextafter(half, 0.0)
        assert tried([gap, half, below, below], trial, proofs=lambda _, s=status: s) == [True, False, True, False]
    # A return to the last bit: another period may show another, unless it is the one on an edge.
    assert tried([0.0, nextafter(FIRST, 0.0)], trial) == [True, True]
    assert tried([0.0, 1e-9, 0.0], trial, proofs=lambda _: ON_EDGE) == [True, False, False]


def test_after_an_orbit_that_does_not_capture_it_waits_until_it_would(trial: Callable[..., Trial]) -> None:
    """Gap and distance from the orbit shrink together: by the margin over the distance, a tenth in reserve."""
    gap = 2.0**-6
    for orbit, margin, part in (
        ([-0.75, gap], 0.125, 0.45),
        ([-2.5, gap], 1.0, 0.45),
        ([-0.75, gap], 0.1, 0.36),
        ([-0.75, gap], 9.0, 1.0),
        ([-0.5, gap], 0.125, 0.5),
    ):
        gaps = [gap, part * gap * (1.0 + 1e-12), part * gap * (1.0 - 1e-12), 0.0]
        expected = [True, False, True]
        assert tried(gaps, trial, proofs=lambda _: NOT_CAPTURED, orbit=orbit, margin=margin)[:3] == expected


def test_a_multiple_of_a_known_period_is_left_alone_twelve_times(trial: Callable[..., Trial]) -> None:
    """Each at a quarter of the gap; a return to the last bit is not."""
    more = {"rows": [row(period=2)], "places": [(-99.0, 0.0)]}
    gaps = [2.0**-6 * 0.25**k * (1.0 - 1e-9) ** k for k in range(PATIENCE + 2)]
    assert tried(gaps, trial, **more) == [False] * PATIENCE + [True, True]
    assert tried([gaps[0], gaps[0] / 4.0, *gaps[1:]], trial, **more) == [False] * (PATIENCE + 1) + [True, True]
    later = [0.1 * gap for gap in gaps[:12]]
    assert tried([gaps[0], 0.3 * gaps[0], *later], trial, **more) == [False] * 13 + [True]
    assert tried([0.0], trial, **more) == [True]
    assert tried([2.0**-6], trial, **more | {"rows": [row(period=5)]}) == [True]
    for each in (gaps[:3], [0.0]):
        assert tried(each, trial, wall=CONTINUOUS, proofs=lambda _: PROVEN, **more)[0]


def test_the_same_commands_must_be_under_way_again(trial: Callable[..., Trial]) -> None:
    states = returns([0.0, 0.0])
    lines = [[1.0, 2.0, 3.0]] * 33 + [[1.0, 2.0, 4.0]] * 2 + [[1.0, 2.0, 3.0]] * 9
    found = trial(states, lines=lines[: len(states)])
    found.run()
    assert [sample for sample, _ in found.certified] == [35]
    continuous = trial(states, lines=lines[: len(states)], proofs=[PROVEN])
    continuous.run(wall=CONTINUOUS)
    assert [sample for sample, _ in continuous.certified] == [33]


def test_a_continuous_sensor_is_tried_again_after_what_it_cost(trial: Callable[..., Trial]) -> None:
    """Eight of the periods tried; a count's is tried at once. It is proven without being followed once more."""
    gaps = [2.0**-6 * 0.25**k for k in range(16)]
    found = trial(returns(gaps), closes=False)
    found.run(wall=CONTINUOUS)
    assert found.trails == []
    assert found.certified == [(33, 2), (33 + 2 * PROOF_COST, 2 + 2 * PROOF_COST)]
    assert tried(gaps, trial) == [True] * 16


def test_a_continuous_sensor_steps_deeper_where_it_enters(trial: Callable[..., Trial]) -> None:
    """From 0 or above; not from a place inside the wall to one that is deeper."""
    for outside, enters in ((0.0, True), (0.5, True), (1.5, True), (-0.25, False), (-1.5, False)):
        found = trial([(outside, 0.0), (-2.5, 0.0)] * 2 + [(0.5, 0.0)], proofs=[PROVEN])
        assert found.run(wall=CONTINUOUS)[0] == (CYCLE_PROVEN if enters else UNSETTLED)
        counted = trial([(outside, 0.0), (-2.5, 0.0)] * 2 + [(0.5, 0.0)], proofs=[PROVEN])
        assert counted.run()[0] == CYCLE_PROVEN
    found = trial([(-2.5, 0.0), (0.5, 0.0)] + [(0.25, 0.0)] * 4, proofs=[])
    assert found.run()[0] == UNSETTLED  # a step out, and none


# A continuous sensor beside a torque over the angle: turns are what repeats, and places what a rest is in.

PLACES = [0.0] * HEAD  # end stops alone: places end at -5.5 and 2.5
PLACES[STOP], PLACES[LOWEST], PLACES[HIGHEST] = 1.0, -5.5, 2.5
CURVED = CONTINUOUS._replace(curve=PLACES)


@pytest.mark.parametrize("shift", [0.5, -3.5])
def test_beside_a_curve_a_motion_that_turns_down_may_begin_a_period(trial: Callable[..., Trial], shift: float) -> None:
    """It turned down first where it came down for the second time: that it began on its way down is no turn."""
    down_first = trial([(shift + (0.1 if k % 2 == 0 else 0.0), 0.0) for k in range(9)], proofs=[PROVEN])
    assert down_first.run(wall=CURVED)[:2] == (CYCLE_PROVEN, 2)
    assert down_first.certified == [(5, 2)]
    up_first = trial([(shift + (0.0 if k % 2 == 0 else 0.1), 0.0) for k in range(9)], proofs=[PROVEN])
    assert up_first.run(wall=CURVED)[:2] == (CYCLE_PROVEN, 2)
    assert up_first.certified == [(4, 2)]


def test_beside_a_curve_a_rest_is_looked_for_in_one_place_on_one_side(trial: Callable[..., Trial]) -> None:
    """On the way up or down: a turn ends nothing. A knee passed, or the wall's edge, begins anew."""
    for first in (0.5, -4.5):
        rising = [first + 0.01 * k for k in range(40)]
        assert looks(trial, rising, CURVED) == [7, 15, 31]
        assert looks(trial, rising[::-1], CURVED) == [7, 15, 31]
    assert looks(trial, [2.25, 2.75] * 10, CURVED) == []
    assert looks(trial, [-0.25, 0.25] * 10, CURVED) == []
    assert looks(trial, [2.25, 2.75] * 10, CONTINUOUS) == [7, 15]


# A clock that jitters.

CLOCK = [1.0, 0.9, 0.1, 0.0, 0.0, 0.95]


@pytest.fixture
def late(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[Any, Trial]]:
    """A trial of so many samples in two states, a turn each, at intervals of any length: its end, and the trial."""

    def run(wall: Any, states: list[State], **more: Any) -> tuple[Any, Trial]:
        found = Trial(monkeypatch, states, **more)
        monkeypatch.setattr(follow, "advance_jittering", found.advance)
        return found.run(wall=wall), found

    return run


def test_a_motion_that_stands_under_a_jittering_clock_is_at_rest_but_not_proven(late: Callable[..., Any]) -> None:
    """Of a continuous sensor, whose states are compared every 64 samples; those of the first begin it."""
    still = [(0.25, 0.0)] * 150
    for first in (0.25, 7.0):  # what was kept of nothing yet, 7, is no state
        found, _ = late(CONTINUOUS._replace(clock=CLOCK), [(first, 7.0 if first == 7.0 else 0.0)] * 150)
        assert (found[0], found[1], found[4]) == (REST_NOT_PROVEN, 1, LOOK_AGAIN)
    moving = [(0.25 + 0.001 * k, 0.0) for k in range(150)]
    assert late(CONTINUOUS._replace(clock=CLOCK), moving)[0][0] == UNSETTLED
    assert late(CONTINUOUS, still)[0][0] == UNSETTLED
    assert late(WALL._replace(clock=CLOCK), still)[0][0] == UNSETTLED


def test_under_a_jittering_clock_nothing_repeats(late: Callable[..., Any]) -> None:
    states = [(0.5, 0.0), (-0.5, 0.0)] * 20
    _, found = late(WALL._replace(clock=CLOCK), states, proofs=[PROVEN])
    assert found.certified == []
    _, plain = late(WALL, states, proofs=[PROVEN])
    assert plain.certified == [(3, 2)]


# Verdicts on a candidate.


def verdict(trial: Callable[..., Trial], proofs: list[int], one: Any = None, **more: Any) -> tuple[Any, Trial]:
    """Of a trial that comes back exactly at samples 3 and 5, with three commands under way."""
    states = [(0.5, 0.0), (-0.5, 0.0)] * 3 + [(0.5, 0.0)]
    found = trial(states, proofs=proofs, lines=[[1.0, 2.0, 3.0]] * 7, head=1, **more)
    return found.run(one), found


def test_a_proof_ends_a_trial_at_its_orbit(trial: Callable[..., Trial]) -> None:
    for status, fate in ((PROVEN, CYCLE_PROVEN), (NEUTRAL, CYCLE_CONTINUUM)):
        found, at = verdict(trial, [status])
        assert found == (fate, 2, READING, 1, 3)
        assert (at.z, at.ring) == (ORBIT, LINE)
    found, at = verdict(trial, [DIFFERENT, DIFFERENT])
    assert found == (UNSETTLED, 0, -1.0, 1, 6)
    assert at.z == [0.5, 0.0]


@pytest.mark.parametrize("friction", [0.25, 4.0])
def test_what_friction_holds_is_no_cycle(trial: Callable[..., Trial], friction: float) -> None:
    found, _ = verdict(trial, [NEUTRAL, NEUTRAL], body(friction=friction))
    assert found == (UNSETTLED, 0, -1.0, 1, 6)
    assert verdict(trial, [PROVEN], body(friction=friction))[0][0] == CYCLE_PROVEN


def test_what_is_not_proven_is_reported_when_samples_are_over(trial: Callable[..., Trial]) -> None:
    ends = ((ON_EDGE, CYCLE_ON_EDGE), (AT_EVENT, CYCLE_AT_EVENT), (EXPANDS, CYCLE_EXPANDS), (PARTS, CYCLE_PARTS))
    for status, fate in ends:
        found, at = verdict(trial, [status, DIFFERENT])
        assert found == (fate, 2, READING, 1, 6)
        assert (at.z, at.ring) == (ORBIT, LINE)
        # What is proven later counts more.
        assert verdict(trial, [status, PROVEN])[0] == (CYCLE_PROVEN, 2, READING, 1, 5)
    last = verdict(trial, [EXPANDS, ON_EDGE])[0]
    assert last[0] == CYCLE_ON_EDGE
    assert verdict(trial, [NOT_CAPTURED, DIFFERENT])[0][0] == UNSETTLED
    # At two edges one sample apart, a hair on either side.
    found = trial([(0.5, 0.0), (-0.999, 0.0), (-1.001, 0.0), (-1.5, 0.0)], proofs=[ON_EDGE])
    assert found.run()[:2] == (CYCLE_ON_EDGE, 1)


def test_near_a_cycle_through_the_play_of_teeth_a_trial_is_not_followed_further(
    trial: Callable[..., Trial], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In position or speed, nearer than a millionth of a count, of which the nearest power of two is exact."""
    assert BESIDE == 1e-6
    near = 2.0**-20
    monkeypatch.setattr(follow, "BESIDE", near)
    for status, fate in ((EXPANDS, CYCLE_EXPANDS), (PARTS, CYCLE_PARTS)):
        for off, beside in ((0.0, True), (nextafter(near, 0.0), True), (near, False), (0.5, False)):
            found, at = verdict(trial, [status, DIFFERENT], orbit=[-0.5, off])
            assert found == (fate, 2, READING, 1, 3 if beside and status == PARTS else 6), (status, off)
            assert (at.z, at.ring) == ([-0.5, off], LINE)


# Known orbits, limits.


def test_known_orbits_are_looked_through_within_their_margin_only(trial: Callable[..., Trial]) -> None:
    """In position; any proven one. What `captured` finds ends the trial."""
    margin = 0.25
    rows = [row(margin=margin), row(margin=margin, fate=CYCLE_ON_EDGE), row(margin=margin)]
    places = [(-2.5, 0.0), (-4.5, 0.0), (-6.5, 0.0)]
    at = [
        (-2.25, False), (nextafter(-2.25, -3.0), True), (-2.75, False), (nextafter(-2.75, -2.0), True), (-4.5, False),
        (-6.5, True), (-9.0, False), (2.5, False), (-2.5, True),
    ]  # fmt: skip
    states = [(x, 0.0) for x, _ in at] + [(-9.0, 0.0)]
    found = trial(states, rows=rows, places=places)
    found.run()
    assert found.asked == [k for k, (_, near) in enumerate(at) if near]
    continuous = trial(states, rows=rows, places=places)
    continuous.run(wall=CONTINUOUS)
    assert continuous.asked == []
    for captor in (0, 1, 2):
        known = trial(states, rows=rows, places=places, captor=captor)
        assert known.run() == (KNOWN, captor, -3.0, 0, 1)


def test_a_trial_ends_at_its_limit_and_where_the_search_is_given_up(trial: Callable[..., Trial]) -> None:
    for x, limit, fate in ((2.5, 2.5, GREW), (-2.5, 2.5, GREW), (2.5, 2.6, UNSETTLED), (-2.5, 2.6, UNSETTLED)):
        found = trial([(0.5, 0.0), (x, 0.0), (0.5, 0.0)])
        assert found.run(limit=limit)[0] == fate
        assert found.at == (1 if fate == GREW else 2)
    for halt in (1e-9, 1.0):
        given_up = trial([(0.5, 0.0)] * 3)
        assert given_up.run(body()._replace(halt=[halt])) == (UNSETTLED, 0, -9.0, 0, 0)


# Rest.


def looks(trial: Callable[..., Trial], places: list[float], wall: Any = WALL) -> list[int]:
    found = trial([(x, 0.0) for x in [*places, places[-1]]])
    found.run(wall=wall, final=False)
    return found.settled


def test_rest_is_looked_for_after_8_16_and_32_samples_of_one_reading(trial: Callable[..., Trial]) -> None:
    """Outside the wall any two readings are one; to a continuous sensor, any two inside, too."""
    assert looks(trial, [-2.5] * 70) == [7, 15, 31, 63]
    assert looks(trial, [-1.5] * 3 + [-2.5] * 40) == [11, 19, 35]
    assert looks(trial, [2.5, 0.0] * 10) == [7, 15]
    assert looks(trial, [-2.5, -0.5] * 10) == []
    for inside in ([-2.5, -0.5], [-2.5, -1.5], [-0.5, -0.25]):
        assert looks(trial, inside * 10, CONTINUOUS) == [7, 15]
    for pair in ([-0.5, 0.0], [-1.5, 0.5], [-0.5, 2.5]):
        assert looks(trial, pair * 10, CONTINUOUS) == []
    assert looks(trial, [0.0, 1.5] * 10, CONTINUOUS) == [7, 15]


@pytest.mark.parametrize(
    ("answer", "stands", "contracts", "found"),
    [
        (AT_REST, False, False, (REST_PROVEN, 1, -3.0, 0, 7)),
        (SETTLING, True, False, (REST_PROVEN, 1, -3.0, 0, 7)),
        (LEAVES, False, False, (LEFT, 0, -3.0, 0, 7)),
        (RINGS, False, False, (UNDAMPED, 0, -3.0, 0, 7)),
        (MOVING, False, True, (REST_PROVEN, 1, -2.5, 0, 7)),
        (MOVING, False, False, None),
        (MOVING, True, False, None),
        (REST_ON_EDGE, True, True, None),
        (SETTLING, False, True, None),
    ],
)
def test_a_rest_ends_a_trial_where_it_is_proven(
    trial: Callable[..., Trial], answer: int, stands: bool, contracts: bool, found: Any
) -> None:
    """Nine samples in level -3; they are looked at once."""
    one = trial([(-2.5, 0.0)] * 10, rests={7: answer}, stands=stands, contracts=contracts)
    left = one.run(final=False)
    assert left == (found or (UNSETTLED, 0, -3.0, 0, 9))
    proven = found is not None and found[0] == REST_PROVEN and answer != MOVING
    assert one.z == (ORBIT if proven else [-2.5, 0.0])


def test_a_rest_on_an_edge_is_left_at_its_place_and_forgotten_where_it_moves_on(trial: Callable[..., Trial]) -> None:
    stays = trial([(-2.5, 0.0)] * 10, rests={7: REST_ON_EDGE, 9: REST_ON_EDGE})
    assert stays.run() == (REST_EDGE, 1, -3.0, 0, 9)
    assert trial([(-2.5, 0.0)] * 10, rests={7: REST_ON_EDGE}).run(final=False)[0] == UNSETTLED
    assert stays.z == ORBIT
    moves = trial([(-2.5, 0.0)] * 9 + [(-1.5, 0.0)] * 2, rests={7: REST_ON_EDGE})
    assert moves.run()[0] == UNSETTLED
    later = trial([(-2.5, 0.0)] * 20, rests={7: REST_ON_EDGE, 15: MOVING})
    assert later.run()[0] == UNSETTLED


def test_a_last_look_is_taken_where_no_samples_follow(trial: Callable[..., Trial]) -> None:
    """At the state after the last sample; what `settles` found to settle before does so still, in that reading."""
    for answer, fate in ((AT_REST, REST_PROVEN), (SETTLING, REST_PROVEN), (MOVING, UNSETTLED), (LEAVES, UNSETTLED)):
        one = trial([(-2.5, 0.0)] * 6, rests={5: answer})
        assert one.run()[0] == fate
        assert (one.z == ORBIT) == (fate == REST_PROVEN)
        assert trial([(-2.5, 0.0)] * 6, rests={5: answer}).run(final=False)[0] == UNSETTLED
    for answer in (MOVING, LEAVES, RINGS):
        contracts = trial([(-2.5, 0.0)] * 6, rests={5: answer}, contracts=True)
        fate = REST_PROVEN if answer == MOVING else UNSETTLED
        assert contracts.run()[:3] == (fate, int(fate == REST_PROVEN), -2.5 if fate == REST_PROVEN else -3.0)
    settles = trial([(-2.5, 0.0)] * 10, rests={7: SETTLING})
    assert settles.run() == (REST_PROVEN, 1, -3.0, 0, 9)
    moves = trial([(-2.5, 0.0)] * 9 + [(-1.5, 0.0)] * 2, rests={7: SETTLING})
    assert moves.run()[0] == UNSETTLED


@pytest.mark.parametrize("final", [False, True])
def test_without_damping_nothing_is_expected_to_settle(trial: Callable[..., Trial], final: bool) -> None:
    for damped, fate in ((True, UNSETTLED), (False, UNDAMPED)):
        one = body()._replace(damped=damped)
        assert trial([(-2.5, 0.0)] * 6).run(one, final=final)[0] == fate


# Moving on.


def test_only_a_knob_alone_with_friction_takes_the_shorter_step(trial: Callable[..., Trial]) -> None:
    """Of one sample. `Trial` fails where the other step is taken."""
    states = [(-2.5, 0.25), (-1.5, 0.5), (0.5, 0.75)]
    for friction in (0.25, 4.0):
        assert trial(states, slides=True).run(body(friction=friction))[2:] == (-2.0, 0, 2)
        late = trial(states, lines=[[1.0]] * 3)
        assert late.run(body(friction=friction))[4] == 2
        more = trial(states)
        assert more.run(body(friction=friction)._replace(order=3, lag=0.5))[4] == 2
    assert trial(states).run(body())[4] == 2


def test_inf_is_no_limit(trial: Callable[..., Trial]) -> None:
    assert trial([(-1e300, 0.0)] * 3).run(limit=inf)[0] == UNSETTLED


def test_a_rest_keeps_the_reading_that_hysteresis_goes_on_from(trial: Callable[..., Trial]) -> None:
    """That of the sample; without hysteresis that of the sample before. Outside the wall all act alike."""
    drifting = [(2.0 * i + 0.5, 0.0) for i in range(30)]
    for hysteresis, ahead in ((0.0, 0), (1e-9, 1), (0.5, 1)):
        wall = WALL._replace(hysteresis=hysteresis)
        seen = trial(drifting, rests=dict.fromkeys(range(30), AT_REST))
        fate, period, before, head, at = seen.run(wall=wall)
        assert (fate, period, before, head) == (REST_PROVEN, 1, 2.0 * (at - 1 + ahead), 0)
        assert 0 < at < 29
        late = trial(drifting, rests={29: AT_REST})
        assert late.run(wall=wall) == (REST_PROVEN, 1, 2.0 * (28 + ahead), 0, 29)


def test_friction_alone_is_what_a_shorter_step_is_for() -> None:
    rubs = body(friction=0.01)
    assert rubs_alone([], rubs, WALL)
    assert not rubs_alone([], body(), WALL)
    assert not rubs_alone([0.0], rubs, WALL)
    assert not rubs_alone([], rubs._replace(order=3), WALL)
    assert not rubs_alone([], rubs._replace(cogs=[1.0] * 6), WALL)
    assert not rubs_alone([], rubs, WALL._replace(hysteresis=1e-9))


def test_a_failed_proof_that_says_nothing_leaves_a_trial_open() -> None:
    assert downgrade(EXPANDS) == CYCLE_EXPANDS
    assert downgrade(DIFFERENT) == UNSETTLED


def test_what_settles_once_settles_though_a_later_look_does_not_tell(trial: Callable[..., Trial]) -> None:
    looked = trial([(0.5, 0.0)] * 40)
    assert looked.run()[0] == UNSETTLED
    first, second = looked.settled[:2]
    assert second < 39
    assert trial([(0.5, 0.0)] * 40, rests={first: SETTLING}).run()[:2] == (REST_PROVEN, 1)
