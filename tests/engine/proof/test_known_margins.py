"""Ends that are met again, with another memory: what is proven once more, and what is entered of it."""

from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, PROVEN
from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN, REST_PROVEN
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.sets import known

from .friction_work import body_of, wall_of

BODY, WALL = body_of(), wall_of()
Places = list[float]


class Again:
    """An orbit of 5 samples in row 1, whose two numbers of memory are met again: what is asked, and as told."""

    def __init__(
        self, patch: pytest.MonkeyPatch, places: Places, *, alike: bool = False, entered: bool = False,
        proven: tuple[int, float, float, float] = (PROVEN, 0.25, 0.125, 0.5),
    ) -> None:  # fmt: skip
        self.places, self.asked = list(places), []  # type: Places, list[tuple[Any, ...]]
        self.steps: list[tuple[Any, ...]] = []
        self.table = [7.0] * (3 * FIELDS)
        self.table[FIELDS : 2 * FIELDS] = [CYCLE_PROVEN, 5.0, 0.25, 7.0, 7.0, 0.125, 7.0, 7.0, 7.0, 0.5]
        self.known: Any = SimpleNamespace(
            law="law", z=[self.places.pop(0), 0.0], ring=[3.0, 4.0], lines="lines", table=self.table,
            space=SimpleNamespace(pad="pad"),
        )  # fmt: skip
        for name, told in (
            ("counted_alike", alike), ("certify_again", proven), ("has_points", entered), ("walk_points", None),
        ):  # fmt: skip
            patch.setattr(known, name, lambda *given, name=name, told=told: self._note(name, given, told))
        patch.setattr(known, "reading_of", lambda _law, z, _before, _ring, wall: read(z[0], wall))
        patch.setattr(known, "advance_memory", self._advance)

    def _note(self, name: str, given: tuple[Any, ...], told: Any) -> Any:
        self.asked.append((name, *given))
        return told

    def _advance(self, law: Any, z: Places, before: float, ring: Places, head: int, *rest: Any) -> tuple[float, int]:
        assert isinstance(head, int)
        self.steps.append((law, before, ring, head, *rest))
        z[0] = self.places.pop(0)
        return 0.0, head

    def names(self) -> list[str]:
        known.add_memory(1, self.known, BODY, WALL)
        return [name for name, *_ in self.asked]


ALL = ["counted_alike", "certify_again", "has_points", "walk_points"]


def test_a_memory_that_is_known_is_not_proven_again(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Again(monkeypatch, [-1.5], alike=True)
    assert (one.names(), one.steps) == (["counted_alike"], [])
    assert one.asked == [("counted_alike", "law", [3.0, 4.0], "lines", 2)]


@pytest.mark.parametrize("status", [DIFFERENT, NOT_CAPTURED])
def test_a_memory_that_is_not_proven_adds_nothing(monkeypatch: pytest.MonkeyPatch, status: int) -> None:
    one = Again(monkeypatch, [-1.5], proven=(status, 0.0, 9.0, 0.0))
    before = list(one.table)
    assert (one.names(), one.steps, one.table) == (ALL[:2], [], before)
    assert one.asked[1] == ("certify_again", "law", 5, one.known, BODY, WALL)


def test_points_are_entered_from_a_sample_that_steps_deeper(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not one that stays; outside the wall all is alike. Of an orbit that has none, all samples are passed."""
    for places, steps in (
        ([-1.5, -1.25, -0.5, -1.5, 0.5], 3), ([-1.5, -2.5, -9.0], 1), ([2.5, 0.5, 1.5, -0.5, -1.5], 3),
        ([-1.5, -1.75, -1.25, -1.5, -1.75, -1.25, -9.0], 5),
    ):  # fmt: skip
        one = Again(monkeypatch, places)
        assert one.names() == ALL
        assert one.steps == [("law", 0.0, [3.0, 4.0], 0, BODY, WALL, "pad")] * steps
        assert one.known.z[0] == places[steps]
        assert one.asked[2:] == [("has_points", 1, one.known, BODY), ("walk_points", 1, 0.0, one.known, BODY, WALL)]


def test_points_that_are_there_are_not_entered_again(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Again(monkeypatch, [-1.5, -2.5], entered=True, proven=(PROVEN, 0.0, 9.0, 0.0))
    before = list(one.table)
    assert (one.names(), one.table) == (ALL[:3], before)


def test_an_orbit_captures_by_the_worse_of_both_proofs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The smaller margin and room, and the larger error; of this row alone."""
    for margin in (0.125, 0.5):
        for bound in (0.0625, 0.25):
            for room in (0.25, 0.75):
                one = Again(monkeypatch, [-1.5, -2.5], proven=(PROVEN, margin, bound, room))
                expected = list(one.table)
                expected[FIELDS + 2], expected[FIELDS + 9] = min(margin, 0.25), min(room, 0.5)
                expected[FIELDS + 5] = max(bound, 0.125)
                assert (one.names(), one.table) == (ALL, expected)


def test_points_are_there_if_one_of_the_orbit_is_near_and_counts_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nearer than the margin of its row, which is a quarter."""
    told: dict[int, bool] = {}
    points = [0.0, 9.0, -2.0, 9.0, 9.0, 9.0, 1.0, 9.0, -3.0, 9.0, 9.0, 9.0, 1.0, 9.0, -2.0, 9.0, 9.0, 9.0]
    monkeypatch.setattr(known, "counted_alike", lambda law, ring, given, at: (law, ring, given) == here and told[at])
    table = [7.0] * (2 * FIELDS)
    table[FIELDS + 2] = 0.25
    margin = 0.25 - 2.0**-40
    for x, second, third, found in (
        (-2.0, False, True, True), (-2.0, True, False, False), (-3.0, True, False, True), (-3.0, False, True, False),
        (-2.0 + margin, False, True, True), (-2.0 - margin, False, True, True), (-1.75, False, True, False),
        (-2.25, False, True, False), (2.0, True, True, False), (0.0, True, True, False),
    ):  # fmt: skip
        one: Any = SimpleNamespace(
            law="law", z=[x, 0.5], ring=[3.0, 4.0], points=points, table=table, counts=[2.0, 3.0]
        )
        here = ("law", one.ring, points)
        told.update({4: True, 10: second, 16: third})
        assert known.has_points(1, one, BODY) is found
    one.z[0], one.counts[1] = -2.0, 2.0
    assert known.has_points(1, one, BODY) is False  # what is not entered
    table[FIELDS + 2], one.counts[1] = inf, 3.0
    assert known.has_points(1, one, BODY) is True
    assert known.has_points(0, one, BODY) is True


@pytest.mark.parametrize("law", [False, True])
def test_what_is_done_with_an_end(monkeypatch: pytest.MonkeyPatch, law: bool) -> None:
    """A proven orbit that is new is walked; of one that is known its memory is looked at, where it is proven again."""
    for row, kept, fate, done in (
        (2, CYCLE_PROVEN, CYCLE_PROVEN, "add_points"), (1, CYCLE_PROVEN, CYCLE_PROVEN, "add_memory"),
        (1, CYCLE_PROVEN, CYCLE_ON_EDGE, None), (1, CYCLE_ON_EDGE, CYCLE_PROVEN, None),
        (1, REST_PROVEN, CYCLE_PROVEN, None), (2, CYCLE_ON_EDGE, CYCLE_ON_EDGE, None),
        (1, REST_PROVEN, REST_PROVEN, None), (2, REST_PROVEN, REST_PROVEN, None),
    ):  # fmt: skip
        asked: list[Any] = []
        table = [float(CYCLE_PROVEN) if row != 0 and kept != CYCLE_PROVEN else 0.0] * (4 * FIELDS)
        table[row * FIELDS] = kept
        one: Any = SimpleNamespace(law=law, counts=[2.0, 0.0], table=table)
        monkeypatch.setattr(known, "enter_end", lambda *given, row=row, asked=asked: asked.append(given) or row)
        for name in ("add_points", "add_memory"):
            monkeypatch.setattr(known, name, lambda *given, name=name, asked=asked: asked.append((name, *given)))
        assert known.add_end(fate, 4, -1.0, 3, one, BODY, WALL) == row
        assert asked[0] == (law, fate, 4, -1.0, 3, one, BODY, WALL)
        assert asked[1:] == ([(done, row, one, BODY, WALL)] if done else [])
