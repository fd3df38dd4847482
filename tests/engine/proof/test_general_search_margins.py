"""What a search of all starts in the general loop makes of what it is told: as `test_set_search_margins`."""

import random
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor, Patience, Search, StoppedError, whole
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets import arc, box, cell, lattice, search
from hknob_cli.engine.general.sets.arc_parts import HIGH, LOW, arc_size
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.ends import make_known
from hknob_cli.engine.general.sets.piece import STATE, WEIGHT, piece_size
from hknob_cli.engine.general.sets.room import CELLS
from hknob_cli.engine.general.sets.scope import LONGEST, Scope
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets import region
from hknob_cli.engine.sets.arc import MOST_ARCS, MOST_COVERED
from hknob_cli.engine.sets.search import GENERATIONS, SAMPLED, SEEN, SLICE, WIDEST, Box

BODY: Any = SimpleNamespace(cogs=None, order=2, reach=2.0, halt=[0.0])
WALL: Any = "wall"
KNOWN: Any = SimpleNamespace(turns="turns")
SCOPE = Scope(budget=1000, skip=4, patience=64, limit=1e6, fine=True)
RATE = 0.125


def rest(trials: float) -> Attractor:
    return Attractor(Outcome.REST, Reason.NONE, trials, period=1, x=-0.5)


class Engine(GeneralSetEngine):
    """Follows sets of a cell as told: 100 samples at most."""

    can, area, states = True, False, 2

    def able(self, body: Any, wall: Any) -> bool:
        assert (body, wall) == (BODY, WALL)
        return self.can

    def by_area(self, _body: Any) -> bool:
        return self.area

    def plane(self, _body: Any) -> Any:
        return BODY if self.states == 2 else SimpleNamespace(order=self.states)

    def longest(self, _body: Any) -> int:
        return 100

    def ready(self, body: Any, wall: Any, delay_line: int) -> Any:
        assert (body, wall, delay_line) == (BODY, WALL, 1)
        return cell.Cell("drift", KNOWN, body, wall if self.compiled else ["list of", wall])


class Cell:
    """What all searches of a cell ask: its scope, its time, and its ends; ``plain``: whether it is not compiled."""

    def __init__(
        self, patch: pytest.MonkeyPatch, names: dict[str, Any], *, calls: float = inf, found: Any = (),
        plain: bool = False, scope: Scope = SCOPE, stops: bool = False,
    ) -> None:  # fmt: skip
        self.calls, self.asked, self.scopes = calls, [], []  # type: float, list[Any], list[Any]
        self.wall = ["list of", WALL] if plain else WALL
        patch.setattr(search, "as_list", lambda wall: ["list of", wall])
        patch.setattr(search, "make_scope", lambda *given: self.scopes.append(given) or scope)
        patch.setattr(search, "Alarm", lambda _seconds, halt: self if halt is BODY.halt else None)
        patch.setattr(search, "ends_of", lambda known, order, delay: self.ends(known, order, delay, found))
        patch.setattr(search, "why_not", lambda known: Reason.TOO_MANY)
        if plain:
            for name, function in names.items():
                patch.setattr(arc if "arcs" in name else lattice if name == "release" else box, name, function)
        functions = None if plain else {f"general.sets.{name}": function for name, function in names.items()}
        self.engine = Engine(functions, lambda: stops)

    def ends(self, known: Any, order: int, delay: int, found: Any) -> list[Attractor]:
        assert (known, order, delay) == (KNOWN, 2, 1)
        return list(found)

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @property
    def over(self) -> bool:
        return len(self.asked) >= self.calls


# All phases of one start.


class Arcs(Cell):
    """Follows arcs as told: how many wait, samples, and totals, call by call."""

    def __init__(self, patch: pytest.MonkeyPatch, *script: Any, arcs: Any = ((0.25, 0.5), (0.625, 0.75)), **more: Any):
        super().__init__(patch, {"fill_arcs": self.fill, "follow_arcs": self.follow}, **more)
        self.script, self.arcs = list(script), arcs

    def fill(self, begin: Any, room: Any, drift: Any, body: Any) -> float:
        assert type(begin) is (np.ndarray if self.engine.compiled else list)
        assert (list(begin), len(room.own_ring), drift, body) == ([2.0, 0.5], 1, "drift", BODY)
        size = arc_size(2, 1)
        for k, (low, high) in enumerate(self.arcs):
            room.stack[k * size + LOW], room.stack[k * size + HIGH] = low, high
        return 0.125

    def follow(self, waiting: int, *given: Any) -> tuple[int, float]:
        slack, samples, totals, scope, room, its = given
        assert (len(room.own_ring), slack, samples, scope) == (1, 0.125, SLICE, SCOPE)
        assert (its, len(totals)) == (("drift", KNOWN, BODY, self.wall), 4)
        if not self.asked:
            assert list(totals) == [0.0, 0.0, 1.0, 0.0]
        self.asked.append(waiting)
        waiting, used, *told = self.script.pop(0)
        if told:
            totals[:] = told
        return waiting, float(used)

    def search(self, **more: Any) -> Search | None:
        found = self.engine.search_phases(
            BODY, WALL, [2.0, 0.5], rate=RATE, delay_line=1, max_samples=more.get("max_samples")
        )
        assert self.scopes in ([], [(BODY, WALL, 2.0, 0.5, RATE, more.get("max_samples"))])
        return found


DONE = (0, 9, 3.0, 0.0, 0.25, 1.0)


@pytest.mark.parametrize("plain", [True, False])
def test_arcs_are_followed_until_none_waits(monkeypatch: pytest.MonkeyPatch, plain: bool) -> None:
    """Shares are of all lengths together; more than one by what arcs overlap, which is no more wrong than that."""
    for covered in (0.75, 1.0, 1.25):
        one = Arcs(monkeypatch, (2, 7), (1, 8), (*DONE[:-1], covered), found=[rest(0.5)], plain=plain)
        found = one.search(max_samples=7)
        assert one.asked == [1, 2, 1]
        assert found is not None
        error = max(0.0, covered - 1.0) + EPSILON * 4.0
        assert found == Search(
            (rest(0.5 / covered),), 24, complete=True, pieces=3, narrowest=0.25, why=Reason.NONE, share_error=error
        )


def test_arcs_that_cannot_be_followed_have_no_list(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Arcs(monkeypatch, (-1, 7)).search() is None
    assert Arcs(monkeypatch, scope=SCOPE._replace(fine=False)).search() is None
    one = Arcs(monkeypatch)
    one.engine.can = False
    assert (one.search(), one.scopes) == (None, [])
    with pytest.raises(StoppedError):
        Arcs(monkeypatch, stops=True).search()


def test_arcs_that_still_wait_are_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """By their lengths; with their time, or their work, as the reason. At the very end of the work it goes on."""
    for used, told, calls, why in (
        (100, (3.0, 0.0, 0.25, 0.625), 2, Reason.TIME_LIMIT), (101, (3.0, 0.0, 0.25, 0.625), inf, Reason.WORK_LIMIT),
        (7, (float(MOST_ARCS), 0.0, 0.25, 0.625), inf, Reason.WORK_LIMIT),
        (7, (3.0, 0.0, 0.25, 2.0 * MOST_COVERED), inf, Reason.WORK_LIMIT),
        (101, (float(MOST_ARCS), 0.0, 0.25, 0.625), inf, Reason.WORK_LIMIT),
    ):  # fmt: skip
        one = Arcs(monkeypatch, (1, 0), (2, used, *told), found=[rest(0.5)], calls=calls)
        found = one.search()
        assert one.asked == [1, 1]
        assert found is not None
        covered = told[3] + 0.375
        late = whole(Outcome.UNDECIDED, why, 0.375 / covered)
        assert set(found.attractors) == {rest(0.5 / covered), late}
        assert (found.complete, found.why, found.samples) == (False, why, used)
    one = Arcs(monkeypatch, (1, 100, 3.0, 0.0, 0.25, 0.5), DONE)
    assert one.search() is not None
    assert one.asked == [1, 1]
    # An arc without a length is one, too.
    found = Arcs(monkeypatch, (1, 101, 3.0, 0.0, 0.25, 1.0), arcs=[(0.5, 0.5)]).search()
    assert found is not None
    assert (found.complete, found.attractors) == (False, ())


def test_arcs_are_too_many_from_a_number_on() -> None:
    for pieces, covered, endless in (
        (MOST_ARCS - 1.0, MOST_COVERED, False), (MOST_ARCS, 1.0, True), (1.0, MOST_COVERED * 1.001, True),
        (MOST_ARCS, MOST_COVERED * 2.0, True), (MOST_ARCS + 1.0, 0.0, True),
    ):  # fmt: skip
        assert search._endless([pieces, 0.0, 0.0, covered]) is endless


def test_a_share_that_is_lost_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above a part in 10^9, where any arc had no proven end; however short that was, the list is not complete."""
    for lost, told in ((0.25, True), (1.5e-9, True), (7e-10, False), (0.0, False)):
        for undecided in (0.0, 0.5, 1.0, 2.0):
            one = Arcs(monkeypatch, (*DONE[:3], undecided, 0.25, 1.0), found=[rest(1.0 - lost)])
            found = one.search()
            assert found is not None
            assert (found.complete, found.why is Reason.NONE) == (undecided == 0.0, undecided == 0.0)
            assert found.why in (Reason.NONE, Reason.TOO_MANY)
            reasons = [end.reason for end in found.attractors]
            assert reasons == [Reason.NONE] + [Reason.TOO_MANY] * (told and undecided > 0.0)
            if len(reasons) == 2:
                assert found.attractors[1].trials == pytest.approx(lost, rel=1e-6)
    # Of all lengths together, with what still waits.
    found = Arcs(monkeypatch, (2, 101, 3.0, 0.5, 0.25, 1.625), found=[rest(0.5)]).search()
    assert found is not None
    assert [end.trials for end in found.attractors] == [0.5625, 0.25, 0.1875]
    # Exactly that part: what is left of 1 less 2^-29, and of 2^-29 less it.
    part = 2.0**-29
    script = (1, 101, 3.0, 0.5, 0.25, part)
    found = Arcs(monkeypatch, script, arcs=[(0.0, 1.0 - part)], found=[rest(part - 1e-9)]).search()
    assert found is not None
    assert [end.reason for end in found.attractors] == [Reason.WORK_LIMIT, Reason.NONE]
    assert 1.0 - (1.0 - part) - (part - 1e-9) == 1e-9


# All states of a box.

BOX = Box(-3.0, 5.0, -1.0, 2.0)
SIZE = piece_size(2, 1)


class Boxes(Cell):
    """Work of a search of a box, as told: see `test_set_search_margins.Boxes`."""

    def __init__(
        self, patch: pytest.MonkeyPatch, *, samples: Any = ((5, 0),), polygons: Any = ((0, 0, 0.0, 0, 0),),
        released: Any = (), filled: int = 1, sought: int = 0, sampled: float = inf, **more: Any,
    ) -> None:  # fmt: skip
        names = ("sample_box", "fill_box", "follow_generation", "seek_some", "release")
        super().__init__(patch, {name: getattr(self, name) for name in names}, **more)
        self.samples, self.polygons, self.released = list(samples), list(polygons), list(released)
        self.filled, self.sought, self.sampled, self.scope = filled, sought, sampled, more.get("scope", SCOPE)
        self.slices: list[tuple[int, int]] = []
        self.widths: list[float] = []
        stack, singles = [0.0] * (4 * SIZE), [0.0] * (4 * SIZE)
        for k in range(4):
            stack[k * SIZE + WEIGHT] = 0.0625 * 2.0**k
            singles[k * SIZE + WEIGHT] = 0.015625 * 2.0**k
        self.room: Any = SimpleNamespace(counts=[0.0], stack=stack, singles=singles, taken=[3.0, 0.0, 2.0], scale=[0.0])
        patch.setattr(search, "hash_scale", lambda wall: 3.0 if wall == WALL else 0.0)
        patch.setattr(self.engine, "room", lambda body, delay: self.room if (body, delay) == (BODY, 1) else None)

    @property
    def over(self) -> bool:
        return len(self.slices) >= self.sampled or len(self.asked) >= self.calls

    def is_cell(self, its: Any) -> bool:
        return bool(its == ("drift", KNOWN, BODY, self.wall) and self.room.scale == [3.0])

    def sample_box(self, starts: Any, first: int, stop: int, ends: Any, scope: Any, room: Any, its: Any) -> Any:
        assert first < stop <= SAMPLED
        assert isinstance(stop, int)
        assert (scope, room) == (self.scope, self.room)
        assert self.is_cell(its)
        assert (len(starts), len(ends)) == (2 * SAMPLED, SAMPLED)
        self.starts = starts
        self.slices.append((first, stop))
        return self.samples.pop(0) if len(self.samples) > 1 else self.samples[0]

    def fill_box(self, *given: Any) -> float:
        assert given == (BOX, self.room, "turns", "drift", self.engine.plane(BODY), self.wall)
        return float(self.filled)

    def follow_generation(self, room: Any, waiting: int, width: float, samples: int, scope: Any, its: Any) -> Any:
        assert (room, samples, scope) == (self.room, SLICE, self.scope)
        assert self.is_cell(its)
        self.widths.append(width)
        self.asked.append(("follow", waiting))
        *found, kept = self.polygons.pop(0)
        room.counts[0] = kept
        return found

    def release(self, *given: Any) -> float:
        assert given == (self.room, 0, 1, "drift")
        self.asked.append("release")
        self.room.counts[0] = 0.0
        return float(self.released.pop(0))

    def seek_some(self, room: Any, waiting: int, *given: Any) -> int:
        some, scope, its = given
        assert (room, some, scope) == (self.room, SEEN, self.scope)
        assert self.is_cell(its)
        self.asked.append(("seek", waiting))
        return self.sought

    def search(self, states: Box = BOX, **more: Any) -> Search:
        found = self.engine.search_box(
            BODY, WALL, states, rate=RATE, delay_line=1, max_samples=more.get("max_samples"), seconds=None
        )
        assert found is not None
        return found


def ends_of(found: Search) -> list[tuple[Outcome, Reason, float]]:
    return [(one.outcome, one.reason, one.trials) for one in found.attractors]


def test_the_farthest_state_of_a_box_says_how_far_it_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    for states in (BOX, Box(-5.0, 3.0, -2.0, 1.0), Box(-5.0, -3.0, 1.0, 2.0), Box(3.0, 5.0, -2.0, -1.0)):
        one = Boxes(monkeypatch)
        monkeypatch.setattr(one.engine, "_fill", lambda *_: 0)
        one.search(states, max_samples=7)
        assert one.scopes == [(BODY, WALL, 5.0, 2.0, RATE, 7)]
    for change in ({"scope": SCOPE._replace(fine=False)}, {}):
        one = Boxes(monkeypatch, **change)
        one.engine.can = bool(change)
        found = one.engine.search_box(BODY, WALL, BOX, rate=RATE, delay_line=1, max_samples=None)
        assert (found, len(one.scopes)) == (None, len(change))


def test_random_starts_are_the_same_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    one, chance = Boxes(monkeypatch), random.Random(0)
    one.search()
    assert one.starts.tolist() == [chance.uniform(*BOX[2 * (k % 2) : 2 * (k % 2) + 2]) for k in range(2 * SAMPLED)]


def test_random_starts_are_followed_in_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    """Until the time is over; those that are left are undecided."""
    monkeypatch.setattr(search, "SLICE", 4000)
    monkeypatch.setattr(f"{__name__}.SLICE", 4000)
    for skip, size in ((0, 4000), (1, 4000), (2, 2000), (3, 1333), (4000, 1), (4001, 1)):
        one = Boxes(
            monkeypatch, samples=((5, 1), (3, 2), (1, 0)), scope=SCOPE._replace(skip=skip), found=[rest(4096.0)]
        )
        found = one.search()
        assert one.slices == [(k, min(k + size, SAMPLED)) for k in range(0, SAMPLED, size)]
        count = len(one.slices)
        assert found.samples == sum((5, 3)[:count]) + max(0, count - 2)
        lost = (Outcome.UNDECIDED, Reason.NO_REPEAT, float(sum((1, 2)[:count])))
        assert ends_of(found) == [(Outcome.REST, Reason.NONE, 4096.0), lost]
    one = Boxes(monkeypatch, samples=((5, 1), (3, 2)), sampled=2)
    found = one.search()
    assert one.slices == [(0, 1000), (1000, 2000)]
    assert ends_of(found) == [
        (Outcome.UNDECIDED, Reason.TIME_LIMIT, SAMPLED - 2000.0), (Outcome.UNDECIDED, Reason.NO_REPEAT, 3.0),
    ]  # fmt: skip
    assert (found.complete, found.why, found.undecided) == (False, Reason.TIME_LIMIT, 0.0625)
    with pytest.raises(StoppedError):
        Boxes(monkeypatch, stops=True).search()


def test_only_polygons_of_two_numbers_are_merged(monkeypatch: pytest.MonkeyPatch) -> None:
    """In cells an eighth of the box wide, by angle or by speed; each lattice is half as wide as the last."""
    for states, area, width in ((2, False, 1.0), (2, True, 0.0), (3, False, 0.0), (1, False, 0.0), (3, True, 0.0)):
        one = Boxes(monkeypatch, polygons=((0, 1, 0.0, 0, 1), (0, 1, 0.0, 0, 2), (0, 1, 0.0, 0, 0)), released=(3, 2))
        one.engine.states, one.engine.area = states, area
        assert one.search().complete
        assert one.widths == [width, width / 2.0, width / 4.0]
        assert one.asked == [
            ("follow", 1), "release", ("seek", 3), ("follow", 3), "release", ("seek", 2), ("follow", 2),
        ]  # fmt: skip
    for reach, across in ((2.0, 8.0), (8.0, 24.0)):
        monkeypatch.setattr(BODY, "reach", reach)
        one = Boxes(monkeypatch)
        one.search()
        assert one.widths == [across / WIDEST]


@pytest.mark.parametrize("plain", [True, False])
def test_what_polygons_end_in_adds_up(monkeypatch: pytest.MonkeyPatch, plain: bool) -> None:
    for lost, undecided in ((0.0, 0.0), (0.125, 0.25), (0.375, 0.75), (0.5, 1.0), (0.75, 1.0)):
        one = Boxes(
            monkeypatch, polygons=((2, 3, lost, 11, 0), (0, 4, lost, 13, 1), (0, 5, 0.0, 17, 0)), released=(1,),
            sought=30, found=[rest(4096.0)], plain=plain,
        )  # fmt: skip
        found = one.search()
        assert one.asked == [("follow", 1), ("follow", 2), "release", ("seek", 1), ("follow", 1)]
        assert (found.samples, found.pieces) == (5 + 11 + 13 + 30 + 17, 12)
        assert (found.undecided, found.complete) == (undecided, undecided == 0.0)
        assert found.why is (Reason.TOO_MANY if undecided else Reason.NONE)
        assert ends_of(found) == [(Outcome.REST, Reason.NONE, 4096.0)]


def test_a_box_without_room_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Boxes(monkeypatch, filled=-1)
    monkeypatch.setattr(search, "why_not", lambda known: Reason.NO_REPEAT)
    found = one.search()
    assert (found.undecided, found.complete, found.why, one.asked) == (1.0, False, Reason.TOO_MANY, [])
    one = Boxes(monkeypatch, filled=0)
    found = one.search()
    assert (found.undecided, found.complete, found.why, one.asked) == (0.0, True, Reason.NONE, [])


def test_what_still_waits_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces, and those of the lattice; with its reason. At the very end of the work it goes on."""
    one = Boxes(monkeypatch, polygons=((1, 3, 0.125, 95, 0), (0, 4, 0.0, 0, 0)))
    assert one.search().undecided == 0.125
    for used, calls, why in (
        (96, inf, Reason.WORK_LIMIT), (95, 1, Reason.TIME_LIMIT), (96, 1, Reason.WORK_LIMIT),
    ):  # fmt: skip
        for kept, left in ((0, 0.1875), (1, 0.1875 + 0.125), (2, 0.1875 + 0.125 + 0.015625)):
            one = Boxes(monkeypatch, polygons=((2, 3, 0.125, used, kept),), calls=calls)
            found = one.search()
            assert (found.undecided, found.why, found.complete) == (0.125 + left, why, False)
            assert (found.samples, found.pieces) == (5 + used, 3)
    one = Boxes(monkeypatch, polygons=((4, 3, 0.125, 96, 0),))
    assert one.search().undecided == 1.0


def test_what_waits_after_the_last_lattice_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the lattice, which is not emptied then: the work was too much."""
    monkeypatch.setattr(search, "GENERATIONS", 3)
    for lost, kept, undecided, why in (
        (0.0, 1, 0.125, Reason.WORK_LIMIT), (0.125, 2, 0.265625, Reason.WORK_LIMIT), (0.25, 0, 0.25, Reason.TOO_MANY),
        (0.0, 0, 0.0, Reason.NONE),
    ):  # fmt: skip
        polygons = ((0, 1, lost, 0, 1), (0, 1, 0.0, 0, 1), (0, 1, 0.0, 0, kept))
        one = Boxes(monkeypatch, polygons=polygons, released=(1, 1), sought=10)
        found = one.search()
        assert (found.undecided, found.why, found.complete) == (undecided, why, undecided == 0.0)
        assert one.asked[1::3] == ["release"] * 2
        assert (found.samples, found.pieces) == (25, 3)
    assert GENERATIONS == 60


def test_shares_of_areas_leave_out_ends_without_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """And tell the share that is undecided, with its reason."""
    for lost in (0.0, 0.25):
        one = Boxes(monkeypatch, polygons=((0, 1, lost, 0, 0),), found=[rest(0.0), rest(0.5)])
        one.engine.area = True
        more = [(Outcome.UNDECIDED, Reason.TOO_MANY, lost)] if lost else []
        assert ends_of(one.search()) == [(Outcome.REST, Reason.NONE, 0.5), *more]
        one = Boxes(monkeypatch, polygons=((0, 1, lost, 0, 0),), found=[rest(0.0), rest(0.5)])
        assert [end.trials for end in one.search().attractors] == [0.5, 0.0]


# Every state at all.


def test_every_state_is_that_of_the_box_around_the_region(monkeypatch: pytest.MonkeyPatch) -> None:
    """In what is left of the time; a region that is too fine for doubles is undecided."""
    now = [10.0]
    monkeypatch.setattr(search, "monotonic", lambda: now[0])
    monkeypatch.setattr(search, "look_from_afar", lambda body, wall: ("afar", body, wall))
    ranges = (-1.0, 1.0, -2.0, 2.0)
    for seconds, until, left in ((None, inf, None), (2.0, 12.0, 1.5)):
        for search_found in (Search((), 3), None):
            now[0] = 10.0
            asked: list[Any] = []

            def find(*given: Any, asked: list[Any] = asked) -> Any:
                asked.append(given)
                now[0] += 0.5
                return SimpleNamespace(ranges=ranges)

            def box_of(*given: Any, asked: list[Any] = asked, found: Any = search_found, **more: Any) -> Any:
                asked.append((given, more))
                return found

            one = Engine()
            monkeypatch.setattr(one, "_regions", SimpleNamespace(find=find))
            monkeypatch.setattr(one, "search_box", box_of)
            found = one.search_anywhere(BODY, WALL, rate=RATE, delay_line=1, max_samples=7, seconds=seconds)
            more = {"rate": RATE, "delay_line": 1, "max_samples": 7, "seconds": left}
            assert asked == [("afar", BODY, WALL, until), ((BODY, WALL, Box(*ranges)), more)]
            fine = Reason.TOO_FINE
            none = Search((whole(Outcome.UNDECIDED, fine, 1.0),), 0, complete=False, undecided=1.0, why=fine)
            assert found == (search_found or none)._replace(region=ranges)
    one = Engine()
    regions = SimpleNamespace(find=lambda *_: None, why_none=lambda *given: given)
    monkeypatch.setattr(one, "_regions", regions)
    given = one.search_anywhere(BODY, WALL, rate=RATE, delay_line=1, max_samples=7)
    assert given == ("afar", BODY, WALL, inf)  # type: ignore[comparison-overlap]


# What it works with.


def test_functions_and_room_are_compiled_or_plain(monkeypatch: pytest.MonkeyPatch) -> None:
    plain, fast = GeneralSetEngine(), GeneralSetEngine({"general.sets.fill_box": 1, "sets.enclose": 2})  # type: ignore[dict-item]
    assert (plain.compiled, fast.compiled) == (False, True)
    assert plain._function(box, "fill_box") is box.fill_box
    assert fast._function(box, "fill_box") == 1
    assert plain._region_function("enclose") is region.enclose
    assert fast._region_function("enclose") == 2
    assert plain._zeros(3) == [0.0] * 3
    assert isinstance(fast._zeros(3), np.ndarray)
    assert not plain.by_area(BODY)
    assert [plain.longest(SimpleNamespace(order=n)) for n in (2, 3, 5)] == [LONGEST[2], LONGEST[3], LONGEST[3]]
    made: list[Any] = []

    def make(zeros: Any, *given: Any, **more: Any) -> Any:
        made.append((*given, more["lattice"]))
        return len(made)

    monkeypatch.setattr(search, "make_piece_room", make)
    for order, delay in ((2, 0), (2, 0), (3, 1), (2, 1), (1, 0)):
        plain.room(SimpleNamespace(order=order), delay)
    assert made == [(2, 0, CELLS), (3, 1, 1), (2, 1, CELLS), (1, 0, 1)]


def test_lists_are_arrays_where_it_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    drift = Drift(powers=[1.0], once=[2.0], units=[3.0], blur=4.0, coast=5.0, bottom=-inf)
    monkeypatch.setattr(search, "make_drift", lambda *_: drift)
    ends: Any = make_known(lambda _: [], 2, 1, "space")
    monkeypatch.setattr(search, "make_known", lambda *_: ends)
    monkeypatch.setattr(search, "make_space", lambda *_: "space")
    monkeypatch.setattr(search, "make_turn_room", lambda *_: "turns")
    monkeypatch.setattr(search, "as_arrays", lambda body: ["arrays of", body])
    monkeypatch.setattr(search, "as_list", lambda wall: ["list of", wall])
    right = ends._replace(turns="turns")
    assert GeneralSetEngine().ready(BODY, WALL, 1) == (drift, right, BODY, ["list of", WALL])
    told, known, body, wall = GeneralSetEngine({"x": len}).ready(BODY, WALL, 1)
    assert (body, known, wall) == (["arrays of", BODY], right, WALL)
    assert [type(value) for value in told] == [np.ndarray] * 3 + [float] * 3
    assert GeneralSetEngine(patience=Patience(samples=3)).patience.samples == 3
    assert STATE < SIZE
