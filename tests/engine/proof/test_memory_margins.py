"""What a set remembers, and how far that pushes it from an orbit: with a law whose numbers are written down."""

from math import inf, nextafter
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.sets import memory
from hknob_cli.engine.general.sets.friction_room import make_friction_room

from .test_law_trial_margins import law_of
from .test_standstill_margins import WALL, body

# A number that is counted, one that fades, the last reading; then the torques of three samples.
PAST = [4.0, 1.5, -3.0, 0.5, 2.0, -1.0]
POINTS = [9.0, 9.0, 9.0, 0.0, -1.0, 0.5, 0.5, *PAST]  # the orbit's begin at 3: row, last reading, state, memory


def law(**more: Any) -> Any:
    one = {"line": 3, "rows": 2, "fading": 1, "fade": 0.5, "weight": 0.25, "ages": 3, "beside": [0.0] * 6}
    return law_of(**(one | more))


def pushed(by: dict[int, float], room: float = 9.0, **more: Any) -> float:
    past = list(PAST)
    for at, one in by.items():
        past[at] += one
    one = body(beta=4.0)  # a reach of a half
    return float(memory.memory_apart(law(**more), 0.0, past, 0, memory.OrbitSample(POINTS, 3, room), one, WALL))


def test_a_motion_is_pushed_by_what_its_memory_is_off_by() -> None:
    """The mean halves every sample, and pushes by a quarter of what it is off; each torque pushes by what it is off.

    The oldest torque does not push. Where the count or the last reading is off, the push is not known.
    """
    assert pushed({}) == 0.0
    assert pushed({1: 2.0}) == pushed({1: -2.0}) == 0.5 * 0.25 * 2.0 / 0.5
    assert pushed({4: 3.0, 5: -1.0}) == 0.5 * 4.0
    assert pushed({3: 7.0}) == 0.0
    for at in (0, 2):
        assert pushed({at: 1e-9}) == inf


def test_what_fades_must_be_within_the_room_of_a_guard() -> None:
    """Only if the guards are of it."""
    for off, room, found in ((1.0, 1.0, inf), (-1.0, 1.0, inf), (1.0, nextafter(1.0, 2.0), 0.25)):
        assert pushed({1: off}, room, guarded=True) == found
        assert pushed({1: off}, room, guarded=False) == 0.25


def test_a_sum_must_be_the_same_or_within_the_room_in_which_it_decides_nothing() -> None:
    for off, room, found in ((0.0, -inf, 0.0), (1.0, 1.0, inf), (1.0, nextafter(1.0, 2.0), 0.0), (-1.0, -inf, inf)):
        assert pushed({0: off}, room, drifts=0, fading=-1, weight=0.0, fade=0.0) == found


def test_looks_into_an_interval_are_those_of_a_law() -> None:
    """They are remembered after the last reading. The room for what a set has seen says how many there are."""
    for chosen, looks, first in ((None, 0, 0), (law(looks=3, pieces=0, sched=[]), 3, 3)):
        work = make_friction_room(lambda count: [0.0] * count, list, 0, body(), WALL, chosen)
        assert (len(work.seen), memory.first_look(chosen)) == (looks, first)


def test_what_is_counted_is_told_apart_by_what_a_law_keeps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither by the last reading nor by the torques under way; without a law there is nothing."""
    told: list[Any] = []
    monkeypatch.setattr(memory, "same_count", lambda *given: told.append((*given[:1], list(given[1]))) or "same")
    ring = [value + 100.0 for value in PAST]
    assert memory.counted_alike(law(), ring, POINTS, 7) == "same"
    assert told == [(ring, [*PAST[:2], *ring[2:]])]
    assert memory.counted_alike(None, ring, POINTS, 7) is True


def test_an_orbit_is_proven_again_with_another_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """It need not capture the motion that came to it; the motion is moved to the orbit."""
    one = body()
    for status in (PROVEN, NOT_CAPTURED, DIFFERENT, ON_EDGE, NEUTRAL):
        told: list[Any] = []

        def certify(*given: Any, status: int = status, told: list[Any] = told) -> Any:
            told.append(given)
            return status, 0.5, 9.0, 9.0, 0.125

        monkeypatch.setattr(memory, "certify_with_law", certify)
        known: Any = SimpleNamespace(z=[1.0, 2.0], ring=list(PAST), space=SimpleNamespace(orbit=[3.0, 4.0]))
        chosen = law(periodic=[7.0] * 6, room=[0.25])
        found = memory.certify_again(chosen, 5, known, one, WALL)
        assert told == [(known.z, known.ring, 5, one, WALL, chosen, known.space)]
        if status in (PROVEN, NOT_CAPTURED):
            assert found == (PROVEN, 0.5, 0.125, 0.25)
            assert (known.z, known.ring) == ([3.0, 4.0], [7.0] * 6)
        else:
            assert found == (DIFFERENT, 0.0, 0.0, 0.0)
            assert (known.z, known.ring) == ([1.0, 2.0], PAST)
        told.clear()
        assert memory.certify_again(None, 5, known, one, WALL) == (DIFFERENT, 0.0, 0.0, 0.0)
        assert told == []


@pytest.mark.parametrize("damping", [0.0, 1e-9, 0.5, 2.0])
def test_a_torque_has_settled_if_all_commands_are_that_of_the_reading(damping: float) -> None:
    """And, with virtual damping, the last reading is that one."""
    wall = WALL._replace(damping=damping)
    for before, ring, found in (
        (-3.0, [3.0, 3.0], True), (-3.0, [], True), (-3.0, [3.0, 2.0], False), (-3.0, [2.0, 3.0], False),
        (-2.0, [3.0, 3.0], damping == 0.0), (-2.0, [3.0, 2.0], False), (0.0, [3.0], damping == 0.0),
    ):  # fmt: skip
        assert memory.settle_memory(None, -2.5, -3.0, before, ring, wall) == (found, 3.0, 0.0, 0.0)


def test_without_a_law_the_largest_torque_is_that_of_both_parts_of_an_interval() -> None:
    for ring, largest in (([-9.0, 1.0], 9.0), ([1.0, -9.0], 9.0), ([1.0, 9.0], 9.0), ([9.0, 1.0], 9.0), ([], 3.0)):
        assert memory.command_all(None, -3.0, 0.0, list(ring), WALL, [0.0, 0.0])[1] == largest


def test_under_a_law_the_torques_are_those_that_it_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """At no speed, for a law that reads one is not followed as a set; the largest of them bounds what is rounded."""
    for torques, largest in (
        ([1.0, 5.0, 2.0], 5.0),
        ([-6.0, 5.0, 2.0], 6.0),
        ([1.0, 2.0, -7.0], 7.0),
        ([0.0] * 3, 0.0),
    ):
        given: list[Any] = []

        def decide(*some: Any, torques: Any = torques, given: Any = given) -> float:
            given.append(some[:2])
            some[2][3:] = torques
            return 0.0

        monkeypatch.setattr(memory, "decide", decide)
        out, past = [7.0] * 6, list(PAST)
        assert memory.command_all(law(), -3.0, -2.0, past, WALL, out) == (0, largest)
        assert out == [7.0, 7.0, 7.0, *torques]
        assert given == [(-3.0, 0.0)]


@pytest.mark.parametrize("under_law", [False, True])
def test_an_end_is_looked_for_as_that_of_one_trial(monkeypatch: pytest.MonkeyPatch, under_law: bool) -> None:
    """Which is the last: a motion that ends nowhere is decided by it."""
    known = SimpleNamespace(ring=[2.0, 3.0])
    given: list[Any] = []

    def follow(*some: Any) -> Any:
        given.append(some)
        return (1, 2, 3) if under_law else (1, 2, 3.0, 4, 5)

    monkeypatch.setattr(memory, "follow_with_law" if under_law else "follow_trial", follow)
    one, chosen = body(), law() if under_law else None
    found = memory.find_end(chosen, -1.0, 100, 50.0, known, one, WALL)
    last = TrialBudget(0, 100, True, 50.0)
    if under_law:
        assert given == [(known, last, one, WALL, chosen)]
        assert found == (1, 2, -1.0, 0, 3)
    else:
        assert given == [(known, -1.0, 0, last, one, WALL)]
        assert found == (1, 2, 3.0, 4, 5)
