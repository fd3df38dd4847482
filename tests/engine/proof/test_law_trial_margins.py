"""A trial under a law whose states and memory, and what proofs say of them, are written down; and how far two part."""

from collections.abc import Callable
from math import inf, nextafter
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
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
)
from hknob_cli.engine.general.follow import BESIDE, CYCLE_AT_EVENT, CYCLE_EXPANDS, CYCLE_PARTS, KNOWN, PATIENCE
from hknob_cli.engine.general.laws import follow
from hknob_cli.engine.general.laws.cascade import (
    apart,
    faded,
    nearly_same,
    pushed_apart,
    same_count,
    torques_apart,
)
from hknob_cli.engine.general.laws.follow import (
    CLOSE,
    LOOK_AGAIN,
    captured_with_law,
    fate_of,
    follow_with_law,
    periods_passed,
    same_to_the_bit,
    unlike,
)
from hknob_cli.engine.general.laws.law import CYCLE_AT_SWITCH, CYCLE_NOT_AFFINE, REST_NOT_PROVEN
from hknob_cli.engine.general.laws.period import AT_SWITCH, REPEATS
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.general.standstill import SETTLING
from hknob_cli.engine.rest import AT_REST, MOVING, REST_ON_EDGE, RINGS
from tests.engine.trial_space import trial_of

from .test_general_follow_margins import row
from .test_general_trial_margins import CONTINUOUS, FIRST, State, returns
from .test_standstill_margins import WALL, body

ORBIT, PERIODIC = [-3.25, 0.125], [5.0]
OUTSIDE = WALL._replace(damping=1.0)  # readings outside matter


def law_of(**more: Any) -> Any:
    """Memory of two numbers, of which the second fades by a half; two torques under way of one part each."""
    one = {
        "unit": 1.0,
        "provable": True, "unproven": CYCLE_NOT_AFFINE, "watch": WALL, "fading": -1, "fade": 0.0, "weight": 0.0,
        "pair": [], "drifts": -1, "senses": False, "line": 1, "parts": 1, "ages": 1,
        "guarded": False, "beside": [0.0] * 9,
        "periodic": [0.0] * 9,
    }  # fmt: skip
    return SimpleNamespace(**(one | more))


FADING = law_of(line=3, fading=1, fade=0.5, weight=0.25, ages=3, parts=1)


class Trial:
    """One trial over scripted states. Which proofs were asked for, and when, is noted."""

    def __init__(
        self,
        patch: pytest.MonkeyPatch,
        states: list[State],
        *,
        proofs: Callable[[int], int] = lambda sample: DIFFERENT,
        rests: dict[int, int] | None = None,
        **more: Any,
    ) -> None:
        """``proofs``: by sample; ``rests``: what `settles_with_law` says at a sample."""
        self.at, self.states, self.proofs, self.rests = 0, states, proofs, rests or {}
        self.certified: list[tuple[int, int]] = []  # sample and period
        self.settled: list[int] = []
        self.asked: list[int] = []  # samples at which the known orbits are looked through
        self.more = {"captor": -1, "margin": 0.0, "orbit": ORBIT, "stands": (9.0, 9.0)} | more
        self.law = more.get("law", law_of())
        self.law.periodic = list(PERIODIC)
        self.beside: list[list[float]] = []
        for name in ("advance_with_law", "certify_with_law", "settles_with_law", "captured_with_law"):
            patch.setattr(follow, name, getattr(self, name))

    def advance_with_law(self, z: Any, past: Any, *_: Any) -> None:
        if z is self.z:
            self.at += 1
            z[:] = self.states[self.at]
            past[0] = float(self.more.get("memory", {}).get(self.at, 0.0))
        else:
            self.beside.append([*z, past[0]])
            z[:] = self.more["stands"]

    def certify_with_law(self, z: Any, past: Any, period: int, one: Any, wall: Any, law: Any, space: Any) -> Any:
        self.certified.append((self.at, period))
        space.orbit[:] = self.more["orbit"]
        return self.proofs(self.at), self.more["margin"], 0.0, 0.0, 0.0

    def settles_with_law(
        self, z: Any, shown: float, past: Any, one: Any, wall: Any, law: Any, orbit: Any, away: Any
    ) -> int:
        self.settled.append(self.at)
        orbit[:] = ORBIT
        return self.rests.get(self.at, MOVING)

    def captured_with_law(self, *_: Any) -> int:
        self.asked.append(self.at)
        return int(self.more["captor"])

    def run(self, one: Any = None, *, final: bool = True, limit: float = 1e9, wall: Any = WALL) -> Any:
        """``(fate, period, samples)``; where it is left, in ``z`` and ``past``."""
        rows = self.more.get("rows", [])
        self.z, self.past = list(self.states[0]), [0.0]
        space = make_space(2, 1, lambda count: [7.0] * count)
        trial = trial_of(self.z, self.past, space, rows, self.more.get("places", []))
        return follow_with_law(trial, TrialBudget(3, len(self.states) + 2, final, limit), one or body(), wall, self.law)


@pytest.fixture
def trial(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Trial]:
    return lambda states, **more: Trial(monkeypatch, states, **more)


def tried(gaps: list[float], trial: Callable[..., Trial], one: Any = None, **more: Any) -> list[bool]:
    """Of which returns to the checkpoint, of 16 at most, a proof is attempted."""
    found = trial(returns(gaps), **more)
    found.run(one or body())
    asked = [(sample - 33) // 2 for sample, _ in found.certified]
    assert [2 * (k + 1) for k in asked] == [period for _, period in found.certified]
    return [k in asked for k in range(len(gaps))]


# Returns.


def test_the_checkpoint_moves_on_after_1_2_4_and_8_steps_deeper(trial: Callable[..., Trial]) -> None:
    found = trial([(0.5, 0.0), (-0.5, 0.0)] * 9 + [(0.5, 0.0)])
    assert found.run() == (UNSETTLED, 0, 18)
    assert found.certified == [(2 * k + 1, period) for k, period in enumerate([2, 2, 4, 2, 4, 6, 8, 2], start=1)]


def test_a_return_is_worth_an_attempt_below_its_tolerance(trial: Callable[..., Trial]) -> None:
    """At first; then half of it, or until the orbit captures; from the first again after one to the last bit."""
    near, gap, half = nextafter(FIRST, 0.0), 2.0**-6, 2.0**-7
    assert tried([FIRST, near], trial) == [False, True]
    for status in (DIFFERENT, ON_EDGE, AT_EVENT, AT_SWITCH, EXPANDS):
        below = nextafter(half, 0.0)
        assert tried([gap, half, below, below], trial, proofs=lambda _, s=status: s) == [True, False, True, False]
    assert tried([0.0, near], trial) == [True, True]
    assert tried([0.0, 1e-9, 0.0], trial, proofs=lambda _: ON_EDGE) == [True, False, False]
    for orbit, margin, part in (
        ([-0.75, gap], 0.125, 0.45),
        ([-2.5, gap], 1.0, 0.45),
        ([-0.75, gap], 0.1, 0.36),
        ([-0.75, gap], 9.0, 1.0),
        ([-0.5, gap], 0.125, 0.5),
    ):
        gaps = [gap, part * gap * (1.0 + 1e-12), part * gap * (1.0 - 1e-12), 0.0]
        more = {"orbit": orbit, "margin": margin}
        assert tried(gaps, trial, proofs=lambda _: NOT_CAPTURED, **more)[:3] == [True, False, True]


def test_a_multiple_of_a_known_period_is_left_alone_twelve_times(trial: Callable[..., Trial]) -> None:
    more = {"rows": [row(period=2)], "places": [(-99.0, 0.0)]}
    gaps = [2.0**-6 * 0.25**k * (1.0 - 1e-9) ** k for k in range(PATIENCE + 2)]
    assert tried(gaps, trial, **more) == [False] * PATIENCE + [True, True]
    assert tried([gaps[0], gaps[0] / 4.0, *gaps[1:]], trial, **more) == [False] * (PATIENCE + 1) + [True, True]
    later = [0.1 * gap for gap in gaps[:12]]
    assert tried([gaps[0], 0.3 * gaps[0], *later], trial, **more) == [False] * 13 + [True]
    assert trial(returns(gaps[:3]), **more).run() == (UNSETTLED, 0, 38)  # and is no end of its own
    assert tried([0.0], trial, **more) == [True]
    assert tried([2.0**-6], trial, **more | {"rows": [row(period=5)]}) == [True]


def test_what_cannot_be_proven_must_come_back_to_eight_digits(trial: Callable[..., Trial]) -> None:
    """Of one and where it was at first; it is reported at once. A known period makes no difference."""
    within = REPEATS * 1.5
    for gap, back in ((within, False), (nextafter(within, 0.0), True)):
        law = law_of(provable=False)
        more = {"rows": [row(period=2)], "places": [(-99.0, 0.0)]}
        found = trial(returns([gap]), proofs=lambda _: EXPANDS, law=law, **more)
        assert (found.run()[0] == CYCLE_NOT_AFFINE) == back
        assert (found.z == ORBIT) == back
    off = trial(returns([0.0, nextafter(within, 0.0)]), law=law_of(provable=False))
    off.run()
    assert len(off.certified) == 2


def test_what_cannot_be_proven_is_looked_at_in_one_count_too(trial: Callable[..., Trial]) -> None:
    """Every 64 samples of one reading."""
    states = [(-2.5, 0.0)] * 260
    found = trial(states, law=law_of(provable=False))
    found.run()
    assert LOOK_AGAIN == 64
    assert found.certified == [(126, 64), (190, 64), (254, 128)]
    provable = trial(states)
    provable.run()
    assert provable.certified == []


# Verdicts on a candidate.


def verdict(trial: Callable[..., Trial], proofs: Callable[[int], int], one: Any = None, **more: Any) -> Any:
    """Of a trial that comes back exactly at samples 3 and 5."""
    found = trial([(0.5, 0.0), (-0.5, 0.0)] * 3 + [(0.5, 0.0)], proofs=proofs, **more)
    return found.run(one), found.z, found.past


def test_a_proof_ends_a_trial_at_its_orbit(trial: Callable[..., Trial]) -> None:
    for status, fate in ((PROVEN, CYCLE_PROVEN), (NEUTRAL, CYCLE_CONTINUUM)):
        assert verdict(trial, lambda _, s=status: s) == ((fate, 2, 3), ORBIT, PERIODIC)
    for friction in (0.25, 4.0):  # what friction holds is no cycle
        assert verdict(trial, lambda _: NEUTRAL, body(friction=friction))[0] == (UNSETTLED, 0, 6)
        assert verdict(trial, lambda _: PROVEN, body(friction=friction))[0][0] == CYCLE_PROVEN


def test_what_is_not_proven_is_reported_when_samples_are_over(trial: Callable[..., Trial]) -> None:
    for status, fate in (
        (ON_EDGE, CYCLE_ON_EDGE),
        (AT_EVENT, CYCLE_AT_EVENT),
        (AT_SWITCH, CYCLE_AT_SWITCH),
        (EXPANDS, CYCLE_EXPANDS),
    ):
        then = {3: status, 5: DIFFERENT}
        assert verdict(trial, lambda at, t=then: t[at]) == ((fate, 2, 6), ORBIT, PERIODIC)
        proven = {3: status, 5: PROVEN}
        assert verdict(trial, lambda at, t=proven: t[at])[0] == (CYCLE_PROVEN, 2, 5)
    for status in (DIFFERENT, NOT_CAPTURED):
        assert verdict(trial, lambda _, s=status: s)[0] == (UNSETTLED, 0, 6)
    found = trial([(0.5, 0.0), (-0.999, 0.0), (-1.001, 0.0), (-1.5, 0.0)], proofs=lambda _: ON_EDGE)
    assert found.run()[:2] == (CYCLE_ON_EDGE, 1)


def test_a_status_has_its_fate() -> None:
    provable, speed = law_of(), law_of(provable=False, unproven=CYCLE_NOT_AFFINE)
    for status, fate in (
        (PROVEN, CYCLE_PROVEN), (NOT_CAPTURED, CYCLE_PROVEN), (NEUTRAL, CYCLE_CONTINUUM), (ON_EDGE, CYCLE_ON_EDGE),
        (AT_EVENT, CYCLE_AT_EVENT), (AT_SWITCH, CYCLE_AT_SWITCH), (EXPANDS, CYCLE_EXPANDS), (DIFFERENT, UNSETTLED),
    ):  # fmt: skip
        assert fate_of(status, provable) == fate
    assert fate_of(EXPANDS, speed) == CYCLE_NOT_AFFINE


def test_a_cycle_whose_teeth_part_is_reported_at_once_where_the_trial_is_beside_it(
    trial: Callable[..., Trial],
) -> None:
    """As `general.follow`: a millionth of a count, by state and memory; farther off it may be left again."""
    there = dict.fromkeys(range(7), PERIODIC[0])
    for off, memory, at_once in (
        (0.0, there, True),
        (0.5 * BESIDE, there, True),
        (-0.5 * BESIDE, there, True),
        (BESIDE, there, False),
        (2.0 * BESIDE, there, False),
        (-2.0 * BESIDE, there, False),
        (0.0, {}, False),
    ):
        # Back at -0.5, where it began; the orbit is ``off`` in its speed, and a unit of speed is one of distance.
        orbit = [-0.5, off]
        states = [(0.5, 0.0), (-0.5, 0.0)] * 3 + [(0.5, 0.0)]
        found = trial(states, proofs=lambda _: PARTS, orbit=orbit, memory=memory)
        assert found.run() == ((CYCLE_PARTS, 2, 3) if at_once else (CYCLE_PARTS, 2, 6))
        assert (found.z, found.past) == (orbit, PERIODIC)
    for status in (ON_EDGE, AT_EVENT, EXPANDS):
        states = [(0.5, 0.0), (-0.5, 0.0)] * 3 + [(0.5, 0.0)]
        found = trial(states, proofs=lambda _, s=status: s, orbit=[-0.5, 0.0], memory=there)
        assert found.run()[2] == 6


def test_a_continuous_sensor_is_followed_until_motions_are_the_same_to_twelve_digits(
    trial: Callable[..., Trial],
) -> None:
    """Of a law that cannot be proven: a count comes back to eight digits. Of one and the place, on either side."""
    sensed, scale = CONTINUOUS._replace(kappa=0.0), 1.0 + 0.5
    for wall, gap, at_once in (
        (WALL, 4e-9, True),
        (sensed, 0.0, True),
        (sensed, CLOSE * scale, True),
        (sensed, 0.6 * CLOSE, True),
        (sensed, nextafter(CLOSE * scale, 1.0), False),
        (sensed, 4e-9, False),
    ):
        law = law_of(provable=False, watch=sensed if wall is sensed else WALL)
        states = [(0.0, 1.0), *returns([gap])[1:], (-0.5, gap), (-0.5, gap)]
        found = trial(states, proofs=lambda _: EXPANDS, law=law)
        fate, _, samples = found.run(wall=wall)
        assert fate == CYCLE_NOT_AFFINE
        assert (samples < len(found.states) - 1) is at_once
    assert CLOSE == 1e-12


def test_a_law_that_senses_has_a_proof_for_each_trial(trial: Callable[..., Trial]) -> None:
    """It is looked at in one count, too; no known orbit captures it, and none is waited for."""
    one = law_of(senses=True)
    found = trial([(-2.5, 0.0)] * 200, law=one)
    found.run()
    assert found.certified == [(126, 64), (190, 64)]
    more = {"rows": [row(period=2)], "places": [(-99.0, 0.0)]}
    assert tried([2.0**-6], trial, law=law_of(senses=True), **more) == [True]
    # What is not captured is tried again at half the distance, whatever the margin.
    gap = 2.0**-6
    gaps = [gap, 0.5 * gap, 0.499 * gap]
    asked = tried(gaps, trial, proofs=lambda _: NOT_CAPTURED, law=one, orbit=[-0.75, gap], margin=9.0)
    space = make_space(2, 1, lambda count: [7.0] * count)
    assert asked == [True, False, True]
    assert captured_with_law(trial_of([0.0, 0.0], [0.0], space, [row()], [[0.0, 0.0]], [[0.0]]), body(), one) == -1


def test_a_trial_that_is_not_at_its_last_is_open(trial: Callable[..., Trial]) -> None:
    for damped, fate in ((True, UNSETTLED), (False, UNDAMPED)):
        found = trial([(0.5, 0.0), (-0.5, 0.0)] * 3 + [(0.5, 0.0)], proofs=lambda _: ON_EDGE)
        assert found.run(body()._replace(damped=damped), final=False) == (fate, 0, 6)


# Known orbits, limits, rest.


def test_known_orbits_are_looked_through_within_their_margin_only(trial: Callable[..., Trial]) -> None:
    rows = [row(margin=0.25), row(margin=0.25, fate=CYCLE_ON_EDGE), row(margin=0.25)]
    places = [(-2.5, 0.0), (-4.5, 0.0), (-6.5, 0.0)]
    at = [
        (-2.25, False), (nextafter(-2.25, -3.0), True), (-2.75, False), (nextafter(-2.75, -2.0), True), (-4.5, False),
        (-6.5, True), (-9.0, False), (2.5, False), (-2.5, True),
    ]  # fmt: skip
    states = [(x, 0.0) for x, _ in at] + [(-9.0, 0.0)]
    found = trial(states, rows=rows, places=places)
    found.run()
    assert found.asked == [k for k, (_, near) in enumerate(at) if near]
    for captor in (0, 1, 2):
        assert trial(states, rows=rows, places=places, captor=captor).run() == (KNOWN, captor, 1)


def test_a_trial_ends_at_its_limit_and_where_the_search_is_given_up(trial: Callable[..., Trial]) -> None:
    for x, limit, fate in ((2.5, 2.5, GREW), (-2.5, 2.5, GREW), (2.5, 2.6, UNSETTLED), (-2.5, 2.6, UNSETTLED)):
        found = trial([(0.5, 0.0), (x, 0.0), (0.5, 0.0)])
        assert found.run(limit=limit)[0] == fate
        assert found.at == (1 if fate == GREW else 2)
    for halt in (1e-9, 1.0):
        assert trial([(0.5, 0.0)] * 3).run(body()._replace(halt=[halt])) == (UNSETTLED, 0, 0)


def looks(trial: Callable[..., Trial], places: list[float], watch: Any = WALL) -> list[int]:
    found = trial([(x, 0.0) for x in [*places, places[-1]]], law=law_of(watch=watch))
    found.run(final=False)
    return found.settled


def test_rest_is_looked_for_after_8_16_and_32_samples_of_one_reading(trial: Callable[..., Trial]) -> None:
    """Outside the wall any two are one, unless the law tells them apart."""
    for watch in (WALL, OUTSIDE):
        assert looks(trial, [-2.5] * 70, watch) == [7, 15, 31, 63]
        assert looks(trial, [-1.5] * 3 + [-2.5] * 40, watch) == [11, 19, 35]
        assert looks(trial, [-2.5, -0.5] * 10, watch) == []
    assert looks(trial, [0.0, 2.5] * 10) == [7, 15]
    assert looks(trial, [0.0, 2.5] * 10, OUTSIDE) == []
    assert looks(trial, [2.5] * 20, OUTSIDE) == [7, 15]


@pytest.mark.parametrize(
    ("answer", "stands", "found"),
    [
        (AT_REST, (9.0, 9.0), (REST_PROVEN, 1, 7)),
        (SETTLING, (-2.5, 0.0), (REST_PROVEN, 1, 7)),
        (SETTLING, (-2.4, 0.0), None),
        (SETTLING, (-2.5, 0.1), None),
        (RINGS, (-2.5, 0.0), (UNDAMPED, 0, 7)),
        (MOVING, (-2.5, 0.0), None),
        (REST_ON_EDGE, (-2.5, 0.0), None),
    ],
)
def test_a_rest_ends_a_trial_where_it_is_proven(
    trial: Callable[..., Trial], answer: int, stands: State, found: Any
) -> None:
    """Nine samples in level -3; they are looked at once. Unproven, it is no end while there are more samples."""
    one = trial([(-2.5, 0.0)] * 10, rests={7: answer}, stands=stands)
    assert one.run(final=False) == (found or (UNSETTLED, 0, 9))
    assert one.z == (ORBIT if answer == AT_REST else [-2.5, 0.0])
    assert one.beside == ([[-2.5, 0.0, 0.0]] if answer == SETTLING else [])


def test_a_rest_is_forgotten_where_the_reading_changes(trial: Callable[..., Trial]) -> None:
    for answer, fate in ((REST_ON_EDGE, REST_EDGE), (SETTLING, REST_PROVEN)):
        stays = trial([(-2.5, 0.0)] * 12, rests={7: answer})
        assert stays.run() == (fate, 1, 11)
        moves = trial([(-2.5, 0.0)] * 9 + [(-1.5, 0.0)] * 2, rests={7: answer})
        assert moves.run()[0] == UNSETTLED
    later = trial([(-2.5, 0.0)] * 20, rests={7: REST_ON_EDGE, 15: MOVING})
    assert later.run()[0] == UNSETTLED
    for damped, fate in ((True, UNSETTLED), (False, UNDAMPED)):
        assert trial([(-2.5, 0.0)] * 6).run(body()._replace(damped=damped))[0] == fate
    assert trial([(-1e300, 0.0)] * 3).run(limit=inf)[0] == UNSETTLED


# How far two motions part.


def test_all_that_is_counted_must_be_the_same() -> None:
    """But for what fades, and the torques, which come after it."""
    past = [1.0, 2.0, 3.0, 9.0, 9.0]
    for other, same in (
        ([1.0, 2.0, 3.0, 8.0, 8.0], True),
        ([1.0, 7.0, 3.0, 9.0, 9.0], True),
        ([1.5, 2.0, 3.0, 9.0, 9.0], False),
        ([1.0, 2.0, 3.5, 9.0, 9.0], False),
    ):
        assert same_count(past, other, FADING) == same
    assert not same_count(past, [1.0, 7.0, 3.0, 9.0, 9.0], law_of(line=3))


def test_nearly_the_same_is_so_much_of_one_and_its_size() -> None:
    law = law_of(line=2)
    assert nearly_same([4.0, 0.0], [3.0, 0.0], law, 0.25)
    assert nearly_same([2.0, 0.0], [3.0, 0.0], law, 0.25)
    assert not nearly_same([nextafter(4.0, 5.0), 0.0], [3.0, 0.0], law, 0.25)
    assert nearly_same([-4.0, 0.0], [-3.0, 0.0], law, 0.25)
    assert not nearly_same([4.0, 0.5], [3.0, 0.0], law, 0.25)
    assert not nearly_same([4.0, float("nan")], [3.0, 0.0], law, 0.25)


def test_torques_part_by_a_geometric_sum_and_by_those_under_way() -> None:
    """A quarter of 0.5, over one half; the oldest torque no longer matters."""
    past, other = [1.0, 2.0, 3.0, 7.0, 5.0, 6.0], [1.0, 2.5, 3.0, 9.0, 5.5, 5.75]
    assert faded(past, other, FADING) == 0.5
    assert faded(past, [3.5, *other[1:]], law_of(line=3, fading=0)) == 2.5
    assert faded(past, other, law_of(line=3)) == 0.0
    assert torques_apart(past, other, FADING) == 0.25 + 0.5 + 0.25
    two = law_of(line=2, parts=2, ages=2, fading=1, fade=0.5, weight=0.25)
    assert torques_apart([0.0, 1.0, 9.0, 9.0, 5.0, 6.0], [0.0, 1.0, 8.0, 8.0, 4.0, 4.0], two) == 3.0


def test_torques_push_as_far_as_what_holds_the_knob_allows() -> None:
    """A spring of a quarter; without one, a damper of one half; friction keeps to the spring."""
    held, free = body(beta=0.25), body(alpha=0.5, beta=0.0)
    assert pushed_apart(0.5, 0.0, held) == 1.0
    assert pushed_apart(0.5, 0.0, free) == 1.0
    assert pushed_apart(0.5, 0.0, free._replace(alpha=0.0)) == inf
    assert pushed_apart(0.0, 0.0, free._replace(alpha=0.0)) == 0.0
    assert pushed_apart(0.5, 0.0, free._replace(friction=1.0)) == inf
    assert pushed_apart(0.5, 0.0, free._replace(order=3, reach=4.0)) == 2.0
    past, other = [1.0, 2.0, 3.0, 7.0, 5.0, 6.0], [1.0, 2.5, 3.0, 9.0, 5.5, 5.75]
    assert apart([0.75, 0.5], 0.0, past, other, held, FADING) == 1.25 + 2.0
    assert unlike([0.75, 0.5], 0.0, past, other, held, FADING) == 1.25 + 2.0
    assert unlike([0.75, 0.5], 0.0, past, [2.0, *other[1:]], held, FADING) == inf
    loose = law_of(line=1, provable=False)
    assert unlike([0.75, 0.5], 0.0, [1.0], [1.0 + 1e-9], held, loose) == 1.25
    assert unlike([0.75, 0.5], 0.0, [1.0], [1.0 + 1e-7], held, loose) == inf


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_known_orbit_captures_within_its_margin_and_guards(side: float) -> None:
    """Margin 0.375 less its bound of 0.125, for position and torques together; what fades within the guard."""
    one, here = body(beta=0.25), [-2.5, 0.5]
    base = [1.0, 2.0, 3.0, 7.0, 5.0, 6.0]

    def row_of(off: State, memory: list[float], law: Any = FADING, **more: Any) -> int:
        rows, pasts = [row(fate=CYCLE_ON_EDGE), row(**more)], [*base, *base]
        z = [here[0] + side * off[0], here[1] + side * off[1]]
        space = make_space(2, 1, lambda count: [7.0] * count)
        return captured_with_law(trial_of(z, memory, space, rows, [here, here], [pasts]), one, law)

    off_by = [1.0, 2.0 + side * 0.125, 3.0, 7.0, 5.0, 6.0]  # pushes by 0.0625 / 0.5
    assert row_of((0.0, 0.0), base) == 1
    assert row_of((0.2499, 0.0), base) == 1
    assert row_of((0.25, 0.0), base) == -1
    assert row_of((0.0, 0.125), base) == -1
    assert row_of((0.0, 0.124), base) == 1
    assert row_of((0.124, 0.0), off_by) == 1
    assert row_of((0.125, 0.0), off_by) == -1
    assert row_of((0.0, 0.0), [1.5, *base[1:]]) == -1
    assert row_of((0.0, 0.0), base, fate=CYCLE_ON_EDGE) == -1
    guarded = law_of(**(vars(FADING) | {"guarded": True}))
    assert row_of((0.0, 0.0), off_by, guarded, before=0.126) == 1
    assert row_of((0.0, 0.0), off_by, guarded, before=0.125) == -1
    assert row_of((0.0, 0.0), off_by, before=0.125) == 1


# Periods that repeat to the last bit, and a clock that jitters.


def test_whole_periods_before_a_limit_and_a_checkpoint() -> None:
    """The event at which they are counted, and the one that makes a checkpoint, are seen."""
    counts = {(100, 4, 9, 2): 4, (7, 4, 99, 2): 1, (8, 4, 99, 2): 2, (3, 4, 99, 2): 0}
    counts |= {(100, 4, 3, 2): 1, (100, 4, 2, 2): 0, (100, 4, 0, 2): 0, (100, 4, 1, 1): 0}
    assert {given: periods_passed(*given) for given in counts} == counts


def test_the_same_to_the_bit_is_all_of_a_state_and_of_what_is_remembered() -> None:
    z, past, off = [1.0, 2.0], [3.0, 4.0], nextafter(4.0, 5.0)
    assert same_to_the_bit(z, past, [1.0, 2.0], [3.0, 4.0])
    for other, memory in (([1.0, nextafter(2.0, 3.0)], past), ([0.0, 2.0], past), (z, [3.0, off]), (z, [0.0, 4.0])):
        assert not same_to_the_bit(z, past, other, memory)


@pytest.mark.parametrize("inner", [1, 2])
def test_passing_over_periods_changes_nothing(
    inner: int, trial: Callable[..., Trial], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the limit: the same end, in the same state, and proofs of the same periods."""
    period = [(0.5, 0.0), (-0.5, 0.0)] + [(0.5, 1.0), (-0.5, 1.0)] * (inner - 1) + [(0.5, 2.0)]
    passed = 0
    for length in range(4, 150):
        states, ends = [period[i % len(period)] for i in range(length + 1)], []
        for count in (periods_passed, lambda *_: 0):
            monkeypatch.setattr(follow, "periods_passed", count)
            one = trial(states, proofs=lambda _: ON_EDGE)
            found = one.run()
            ends.append((found, one.z, one.past, [n for _, n in one.certified], one.at))
        (*short, few), (*full, every) = ends
        assert short == full
        assert every == length
        passed += every - few
    assert passed > 2000


@pytest.mark.parametrize("more", [{"provable": False}, {"senses": True}])
def test_only_what_can_be_proven_is_passed_over(more: dict[str, Any], trial: Callable[..., Trial]) -> None:
    one = trial([(0.5, 0.0), (-0.5, 0.0)] * 30, proofs=lambda _: DIFFERENT, law=law_of(**more))
    one.run()
    assert one.at == 59


def test_a_clock_that_jitters_leaves_a_rest_that_comes_again_to_twelve_digits(
    trial: Callable[..., Trial], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Looked for 64 samples apart, by the place and by what is remembered; without jitter a proof is asked for."""
    wall, law = WALL._replace(clock=[0.0] * 6), law_of(provable=False)
    for gap, memory, at in (
        (0.0, {}, 126),
        (0.999 * CLOSE * 3.5, {}, 126),
        (-0.999 * CLOSE * 3.5, {}, 126),
        (1.001 * CLOSE * 3.5, {}, 190),
        (0.0, dict.fromkeys(range(100, 300), 1e-07), 190),
    ):
        one = trial([(-2.5, 0.0)] * 100 + [(-2.5 + gap, 0.0)] * 200, law=law, memory=memory)
        monkeypatch.setattr(follow, "advance_jittering_with_law", one.advance_with_law)
        assert one.run(wall=wall) == (REST_NOT_PROVEN, 1, at)
        assert one.certified == []


def test_what_settles_once_under_a_law_settles_though_a_later_look_does_not_tell(trial: Callable[..., Trial]) -> None:
    first = trial([(0.5, 0.0)] * 40)
    first.run()
    assert trial([(0.5, 0.0)] * 40, rests={first.settled[0]: SETTLING}).run()[:2] == (REST_PROVEN, 1)
