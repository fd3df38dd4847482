"""What a search of all starts makes of what it is told: a cell is complete only where all that was followed ended."""

import random
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import FATES, Attractor, NeedsCompilerError, Patience, Search, StoppedError, whole
from hknob_cli.engine.budget import OPEN, TOO_FINE, UNHELD
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, UNDAMPED
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets import arc, cells, search
from hknob_cli.engine.sets.polygon import POLYGON, WEIGHT
from hknob_cli.engine.sets.search import SAMPLED, Box, SetEngine

LOOP: Any = SimpleNamespace(alpha=0.5, beta=0.25)
LATE = whole(Outcome.UNDECIDED, Reason.TIME_LIMIT, 0.0)


class Clock:
    """Stands for the time, which others move on."""

    def __init__(self, patch: pytest.MonkeyPatch, now: float = 10.0) -> None:
        self.now = now
        patch.setattr(search, "monotonic", lambda: self.now)


# All phases of one start.


class Phases:
    """Follows the phases of a cell as told, ``(state, change of the room)`` call by call, until the time is over."""

    def __init__(self, patch: pytest.MonkeyPatch, *script: Any, calls: float = inf, lost: float = 0.0) -> None:
        self.script, self.calls = list(script), calls
        self.asked: list[tuple[Any, ...]] = []
        self.budgets: list[tuple[Any, ...]] = []
        self.budget = 1000
        patch.setattr(search, "Alarm", lambda _seconds: self)
        patch.setattr(search, "prospect", self._prospect)
        patch.setattr(cells, "lost_share", lambda *_: lost)

    @property
    def over(self) -> bool:
        return len(self.asked) >= self.calls

    def _prospect(self, *given: Any) -> Any:
        self.budgets.append(given)
        return OPEN, self.budget, 0, 1e6

    def __call__(self, *given: Any) -> tuple[int, int]:
        loop, start, *numbers, room, known = given
        self.asked.append((loop, *start, *numbers))
        state, change = self.script.pop(0)
        for at, value in change.items():
            room.progress[at] = value
        for k, value in enumerate([0.25, 0.5, 9.0] + [0.0] * (arc.ARC - 3) + [0.625, 0.75]):
            room.stack[k] = value
        known.counts[0] = 0.0
        return state, 7

    def search(self, engine: SetEngine | None = None, max_samples: int | None = None) -> Search | None:
        engine = engine or SetEngine({"sets.follow_cell": self})
        return engine.search_phases(LOOP, x=2.0, v=0.5, delay_line=1, max_samples=max_samples)


def test_phases_are_followed_until_all_have_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled with all samples that a motion may take, by hand with those of the patience; slice by slice."""
    for max_samples, most in ((None, 0), (7, 7)):
        one = Phases(monkeypatch, (0, {}), (0, {}), (1, {arc.TAKEN: 55.0, arc.DONE: 3.0, arc.SHORTEST: 0.125}))
        found = one.search(max_samples=max_samples)
        assert one.asked == [(LOOP, 2.0, 0.5, 1, most, 0, search.SLICE)] * 3
        assert found is not None
        assert (found.attractors, found.complete) == ((), True)
        assert (found.samples, found.pieces, found.narrowest) == (55, 3, 0.125)
        one = Phases(monkeypatch, (1, {}))
        monkeypatch.setattr(cells, "follow_cell", one)
        assert one.search(SetEngine(patience=Patience(samples=20)), max_samples) is not None
        assert one.asked == [(LOOP, 2.0, 0.5, 1, most, 20, search.SLICE_INTERPRETED)]
    assert Phases(monkeypatch, (-1, {})).search() is None
    with pytest.raises(StoppedError):
        Phases(monkeypatch).search(SetEngine({"sets.follow_cell": one}, stopped=lambda: True))


def test_phases_that_still_wait_are_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """By their lengths together; all, where none has begun."""
    for waiting, left in ((2.0, 0.375), (1.0, 0.25), (0.0, 1.0)):
        found = Phases(monkeypatch, (0, {}), (0, {arc.WAITING: waiting}), calls=2).search()
        assert found is not None
        assert (found.attractors, found.complete) == ((LATE._replace(trials=left),), False)


def test_an_undecided_or_a_lost_share_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    for undecided in (0.0, 0.5, 1.0):
        for lost in (0.0, 0.25):
            found = Phases(monkeypatch, (1, {arc.UNDECIDED: undecided}), lost=lost).search()
            assert found is not None
            assert bool(found.complete) == (undecided == 0.0)
            more = (whole(Outcome.UNDECIDED, Reason.NO_REPEAT, lost),) if lost else ()
            assert found.attractors == more


def test_only_the_interpreter_hands_phases_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a motion took all of its patience, and has less than its own samples."""
    for spent in (0.0, 0.5, 2.0):
        for budget in (19, 20, 21):
            for max_samples, most in ((None, 0), (7, 7)):
                one = Phases(monkeypatch, (1, {arc.SPENT: spent}))
                one.budget = budget
                monkeypatch.setattr(cells, "follow_cell", one)
                engine = SetEngine(patience=Patience(samples=20))
                if spent > 0.0 and budget > 20:
                    with pytest.raises(NeedsCompilerError) as told:
                        one.search(engine, max_samples)
                    assert told.value.group == "sets"
                else:
                    assert one.search(engine, max_samples) is not None
                assert one.budgets == [(2.0, 0.5, most, LOOP)][: int(spent > 0.0)]
                again = Phases(monkeypatch, (1, {arc.SPENT: spent}))
                assert again.search(max_samples=max_samples) is not None
                assert again.budgets == []


# All states of a box.

BOX = Box(-3.0, 5.0, -1.0, 2.0)


class Boxes:
    """Work of a search of a box, as told: samples and unproven of each slice of trials, then of each of polygons.

    ``polygons``: what each slice returns, and how much the lattice keeps then; ``released``: how many wait after it.
    """

    def __init__(
        self, patch: pytest.MonkeyPatch, *, samples: Any = ((5, 0),), polygons: Any = ((0, 0, 0.0, 0, 0),),
        released: Any = (), skip: int = 0, sought: int = 0, wait_s: tuple[float, float] = (0.0, 0.0),
        stops: bool = False,
    ) -> None:  # fmt: skip
        self.samples, self.polygons, self.released = list(samples), list(polygons), list(released)
        self.skip, self.sought, self.wait_s, self.fate = skip, sought, wait_s, OPEN
        self.slices: list[tuple[int, int]] = []
        self.widths: list[float] = []
        self.asked: list[Any] = []
        self.clock = Clock(patch)
        patch.setattr(search, "prospect", self._prospect)
        names = ("sample_box", "follow_generation", "seek_some", "release", "fill_box", "fill_polygon")
        self.engine = SetEngine({f"sets.{name}": getattr(self, name) for name in names}, stopped=lambda: stops)
        stack = [0.0] * (4 * POLYGON)
        for k in range(4):
            stack[k * POLYGON + WEIGHT] = 0.0625 * 2.0**k
        self.room = SimpleNamespace(counts=[0.0], ring=[], stack=stack)
        self.engine._polygons = self.room

    def _prospect(self, *given: Any) -> Any:
        self.asked.append(("prospect", *given))
        return self.fate, 1000, self.skip, 1e6

    def sample_box(
        self, starts: Any, first: int, stop: int, scope: Any, ring: Any, ends: Any, known: Any, loop: Any
    ) -> Any:
        assert first < stop <= SAMPLED
        assert isinstance(stop, int)
        assert (*scope, ring, loop) == (self.skip, 1000, 1e6, [], LOOP)
        assert (len(starts), len(ends), len(known.lines)) == (2 * SAMPLED, SAMPLED, 1)
        self.starts = starts
        self.slices.append((first, stop))
        self.clock.now += self.wait_s[0]
        return self.samples.pop(0) if len(self.samples) > 1 else self.samples[0]

    def fill_box(self, *given: Any) -> None:
        assert given == (*BOX, self.room, LOOP)
        self.asked.append("fill")

    def fill_polygon(self, *given: Any) -> None:
        self.asked.append(("fill", *given))

    def follow_generation(
        self, room: Any, waiting: int, width: float, samples: int, scope: Any, known: Any, loop: Any
    ) -> Any:
        assert (room, *scope, samples, loop) == (
            self.room, cells.first_patience(self.skip), 1000, 1e6, search.SLICE, LOOP,
        )  # fmt: skip
        known.counts[0] = 1.0
        known.table[:10] = [REST_PROVEN, 1.0, -0.5, 0.0, 0.25, 0.0, 0.0, 0.0, 4096.0, 0.0]
        self.widths.append(width)
        self.asked.append(("follow", waiting))
        self.clock.now += self.wait_s[1]
        *found, kept = self.polygons.pop(0)
        room.counts[0] = kept
        return found

    def release(self, room: Any, slot: int, loop: Any) -> float:
        assert (room, slot, loop) == (self.room, 0, LOOP)
        self.asked.append("release")
        return float(self.released.pop(0))

    def seek_some(self, room: Any, waiting: int, some: int, scope: Any, known: Any, loop: Any) -> int:
        assert (room, some, *scope, loop) == (self.room, search.SEEN, self.skip, 1000, 1e6, LOOP)
        self.asked.append(("seek", waiting))
        return self.sought

    def search(self, box: Box = BOX, loop: Any = LOOP, **more: Any) -> Search:
        return self.engine.search_box(loop, box, max_samples=more.get("max_samples"), seconds=more.get("seconds"))


def ends_of(found: Search) -> list[tuple[Outcome, Reason, float]]:
    return [(one.outcome, one.reason, one.trials) for one in found.attractors]


REST = (Outcome.REST, Reason.NONE, 4096.0)


def test_the_farthest_state_of_a_box_says_how_long_trials_are(monkeypatch: pytest.MonkeyPatch) -> None:
    for box, far in (
        (BOX, (5.0, 2.0)), (Box(-5.0, 3.0, -2.0, 1.0), (5.0, 2.0)), (Box(-5.0, -3.0, 1.0, 2.0), (5.0, 2.0)),
        (Box(3.0, 5.0, -2.0, -1.0), (5.0, 2.0)),
    ):  # fmt: skip
        for max_samples, most in ((None, 0), (7, 7)):
            one = Boxes(monkeypatch)
            monkeypatch.setattr(one, "fill_box", lambda *_: None)
            one.engine._functions["sets.fill_box"] = lambda *_: None  # type: ignore[index]
            one.search(box, max_samples=max_samples)
            assert one.asked[0] == ("prospect", *far, most, LOOP)


def test_what_no_set_is_followed_of(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is decided before it begins, and what nothing damps or holds; with its reason."""
    for alpha, beta, fate, told in (
        (0.5, 0.25, TOO_FINE, TOO_FINE), (0.0, 0.25, OPEN, UNDAMPED), (0.5, 0.0, OPEN, UNHELD),
        (0.0, 0.0, OPEN, UNDAMPED), (0.0, 0.0, TOO_FINE, TOO_FINE), (-0.5, 0.25, OPEN, UNHELD),
        (0.5, -0.25, OPEN, UNHELD),
    ):  # fmt: skip
        one = Boxes(monkeypatch)
        one.fate = fate
        found = one.search(loop=SimpleNamespace(alpha=alpha, beta=beta))
        assert found == Search((whole(*FATES[told], 1.0),), 0, complete=False, undecided=1.0)
    found = Boxes(monkeypatch).search()
    assert found.complete


def test_random_starts_are_the_same_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    one, chance = Boxes(monkeypatch), random.Random(0)
    one.search()
    drawn = [chance.uniform(*BOX[2 * (k % 2) : 2 * (k % 2) + 2]) for k in range(2 * SAMPLED)]
    assert one.starts.tolist() == drawn


def test_random_starts_are_followed_in_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of as many samples, by what passes before detection; of a start, at least."""
    monkeypatch.setattr(search, "SLICE", 4000)
    for skip, size in ((0, 4000), (1, 4000), (2, 2000), (3, 1333), (4000, 1), (4001, 1)):
        one = Boxes(monkeypatch, samples=((5, 1), (3, 2), (1, 0)), skip=skip)
        found = one.search()
        assert one.slices == [(k, min(k + size, SAMPLED)) for k in range(0, SAMPLED, size)]
        count = len(one.slices)
        assert found.samples == sum((5, 3)[:count]) + max(0, count - 2)
        assert ends_of(found) == [REST, (Outcome.UNDECIDED, Reason.NO_REPEAT, float(sum((1, 2)[:count])))]
    with pytest.raises(StoppedError):
        Boxes(monkeypatch, stops=True).search()


def test_starts_that_there_was_no_time_for_are_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the very end of the time there is none."""
    monkeypatch.setattr(search, "SLICE", 4000)
    one = Boxes(monkeypatch, samples=((5, 1), (3, 2)), skip=4, wait_s=(1.0, 0.0))
    found = one.search(seconds=2.0)
    assert one.slices == [(0, 1000), (1000, 2000)]
    assert (found.samples, found.complete, found.pieces, found.undecided) == (8, False, 0, 1.0)
    assert found.why is Reason.TIME_LIMIT
    assert ends_of(found) == [
        (Outcome.UNDECIDED, Reason.TIME_LIMIT, SAMPLED - 2000.0), (Outcome.UNDECIDED, Reason.NO_REPEAT, 3.0),
    ]  # fmt: skip
    one = Boxes(monkeypatch, skip=4, wait_s=(1.0, 0.0))
    assert one.search(seconds=5.0).complete
    assert len(one.slices) == 5


def test_the_first_lattice_has_eight_cells_across_a_box(monkeypatch: pytest.MonkeyPatch) -> None:
    """By angle, or by speed, which counts by the stiffness; each is half as wide as the last."""
    assert search.WIDEST == 8.0
    for beta, across in ((0.25, 8.0), (0.04, 15.0), (4.0, 8.0)):
        loop = SimpleNamespace(alpha=0.5, beta=beta)
        monkeypatch.setattr(f"{__name__}.LOOP", loop)
        one = Boxes(monkeypatch, polygons=((0, 1, 0.0, 0, 1), (0, 1, 0.0, 0, 2), (0, 1, 0.0, 0, 0)), released=(3, 2))
        assert one.search(loop=loop).complete
        assert one.widths == pytest.approx([across / 8.0, across / 16.0, across / 32.0], rel=1e-15)
        assert one.asked[1:] == [
            "fill", ("follow", 1), "release", ("seek", 3), ("follow", 3), "release", ("seek", 2), ("follow", 2),
        ]  # fmt: skip


def test_what_polygons_end_in_adds_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slice by slice; no more than all can be undecided."""
    for lost, undecided in ((0.0, 0.0), (0.125, 0.25), (0.375, 0.75), (0.5, 1.0), (0.75, 1.0)):
        one = Boxes(monkeypatch, polygons=((2, 3, lost, 11, 0), (0, 4, lost, 13, 1), (0, 5, 0.0, 17, 0)), released=(1,),
                    sought=100)  # fmt: skip
        found = one.search()
        assert one.asked[2:] == [("follow", 1), ("follow", 2), "release", ("seek", 1), ("follow", 1)]
        assert (found.samples, found.pieces) == (5 + 11 + 13 + 100 + 17, 12)
        assert (found.undecided, found.complete, found.why) == (undecided, undecided == 0.0, Reason.NONE)
        assert ends_of(found) == [REST]
        assert found.attractors[0].line == ()


def test_a_search_ends_with_its_work_or_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then nothing is said of any start; at the very end of both it goes on."""
    monkeypatch.setattr(search, "LONGEST", 100)
    for used, waits, why in (
        (95, 2.0, None), (96, 0.0, Reason.WORK_LIMIT), (0, 2.5, Reason.TIME_LIMIT), (96, 2.5, Reason.WORK_LIMIT),
        (95, 2.5, Reason.TIME_LIMIT),
    ):  # fmt: skip
        one = Boxes(monkeypatch, polygons=((1, 3, 0.125, used, 1), (0, 4, 0.0, 0, 0)), wait_s=(0.0, waits))
        one.polygons[1] = (0, 4, 0.0, 0, 0)
        if why is None:
            one.wait_s = (0.0, 1.0)
        found = one.search(seconds=2.0)
        if why is None:
            assert (found.undecided, found.pieces, found.why) == (0.125, 7, Reason.NONE)
        else:
            assert (found.undecided, found.pieces, found.why, found.complete) == (1.0, 3, why, False)
        assert found.samples == 5 + used


def test_what_still_waits_after_the_last_lattice_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """By its measure; and that the work was too much is said where it is most of it. Nothing is sought after it."""
    monkeypatch.setattr(search, "GENERATIONS", 3)
    for lost, waiting, undecided, why in (
        (0.0, 1, 0.0625, Reason.WORK_LIMIT), (0.0, 3, 0.4375, Reason.WORK_LIMIT), (0.0625, 1, 0.125, Reason.NONE),
        (0.125, 1, 0.1875, Reason.NONE), (0.03125, 1, 0.09375, Reason.WORK_LIMIT), (0.125, 4, 1.0, Reason.WORK_LIMIT),
        (0.25, 3, 0.6875, Reason.WORK_LIMIT), (0.0, 0, 0.0, Reason.NONE),
    ):  # fmt: skip
        polygons = ((0, 1, lost, 0, 1), (0, 1, 0.0, 0, 1), (0, 1, 0.0, 0, 1))
        one = Boxes(monkeypatch, polygons=polygons, released=(1, 1, waiting), sought=10)
        found = one.search()
        assert (found.undecided, found.why, found.complete) == (undecided, why, undecided == 0.0)
        assert [name for name in one.asked if name[0] == "seek"] == [("seek", 1)] * 2
        assert (found.samples, found.pieces) == (25, 3)


# Every state at all.


class Regions:
    """Finds the region that is told, or none."""

    def __init__(self, found: Any) -> None:
        self.found, self.asked = found, []  # type: Any, list[Any]

    def find(self, *given: Any) -> Any:
        self.asked.append(given)
        return self.found

    def why_none(self, *given: Any) -> Any:
        self.asked.append(given)
        return "why"


def test_every_state_is_that_of_the_region(monkeypatch: pytest.MonkeyPatch) -> None:
    """In what is left of the time; trials begin in its corners' polygon."""
    monkeypatch.setattr(search, "pushes", lambda loop: ("pushes", loop))
    monkeypatch.setattr(search, "states_in", lambda corners, count: [*corners, float(count)])
    corners = [-1.0, 0.0, 1.0, -1.0, 1.0, 1.0]
    for seconds, until, left in ((None, inf, None), (2.0, 12.0, 1.5)):
        one = Boxes(monkeypatch)
        regions = Regions(SimpleNamespace(ranges=(-1.0, 1.0, -1.0, 1.0), corners=corners))
        one.engine._regions = regions  # type: ignore[assignment]
        find = regions.find

        def slow(*given: Any, find: Any = find, one: Boxes = one) -> Any:
            one.clock.now += 0.5
            return find(*given)

        monkeypatch.setattr(regions, "find", slow)
        told: list[Any] = []

        def searched(*given: Any, told: list[Any] = told) -> Search:
            told.extend(given)
            return Search((), 3)

        monkeypatch.setattr(one.engine, "_search", searched)
        found = one.engine.search_anywhere(LOOP, max_samples=7, seconds=seconds)
        assert found == Search((), 3, region=(-1.0, 1.0, -1.0, 1.0))
        assert regions.asked == [(LOOP, ("pushes", LOOP), until)]
        loop, states, starts, fill, most, time = told
        assert (loop, states, most, time) == (LOOP, Box(-1.0, 1.0, -1.0, 1.0), 7, left)
        assert starts.tolist() == [*corners, float(SAMPLED)]
        fill()
        name, given, count, room, of = one.asked[-1]
        assert (name, given.tolist(), count, room, of) == ("fill", corners, 3, one.room, LOOP)
        assert isinstance(count, int)
        one = Boxes(monkeypatch)
        regions = Regions(None)
        one.engine._regions = regions  # type: ignore[assignment]
        assert one.engine.search_anywhere(LOOP, max_samples=7, seconds=seconds) == "why"
        assert regions.asked == [(LOOP, ("pushes", LOOP), until)] * 2


# Where the starts of a map end.


def test_each_start_of_a_map_is_of_a_proven_end_or_of_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ends that are not proven are entered nowhere; what ends in a row that is not listed is of none."""
    monkeypatch.setattr(search, "MAPPED", 3)
    rows, seen = [0, 3], []  # type: list[int], list[Any]
    asked: list[Any] = []
    ends = [0.0, 1.0, 3.0, -1.0, 0.0, 2.0, 3.0]

    def add(*given: Any) -> int:
        *numbers, ring, head, known, loop = given
        assert (len(ring), head, len(known.lines), loop) == (0, 0, 1, LOOP)
        seen.append(tuple(numbers))
        return rows.pop(0)

    def sample(flat: Any, first: int, stop: int, *rest: Any) -> None:
        (skip, most, limit), ring, out, known, loop = rest
        assert (skip, most, limit, len(ring), len(known.lines), loop) == (5, 1000, 1e6, 0, 1, LOOP)
        asked.append((first, stop, flat.tolist()))
        out[first:stop] = ends[first:stop]

    starts = np.array([[1.0, -2.0], [-3.0, 0.5], [0.0, 0.0], [2.0, 1.0], [1.5, 1.0], [0.5, 0.5], [0.25, 0.0]])
    budgets: list[Any] = []

    def prospect(*given: Any) -> Any:
        budgets.append(given)
        return OPEN, 1000, 5, 1e6

    monkeypatch.setattr(search, "prospect", prospect)
    cycle = Attractor(Outcome.CYCLE, Reason.NONE, 1.0, period=4, x=-1.5, v=0.25)
    rest = Attractor(Outcome.REST, Reason.NONE, 1.0, period=1, x=-0.5)
    open_one = Attractor(Outcome.CYCLE, Reason.ON_EDGE, 1.0, period=9, x=-9.0)
    for max_samples, most in ((None, 0), (7, 7)):
        rows[:] = [0, 3]
        seen.clear(), asked.clear(), budgets.clear()
        engine = SetEngine({"sets.add_end": add, "sets.sample_box": sample})
        found = engine.map_starts(LOOP, starts, (cycle, rest, open_one), max_samples=max_samples)
        assert found.tolist() == [0, -1, 1, -1, 0, -1, 1]
        assert seen == [(CYCLE_PROVEN, 4, -1.5, 0.25), (REST_PROVEN, 1, -0.5, 0.0)]
        flat = [float(one) for start in starts for one in start]
        assert asked == [(0, 3, flat), (3, 6, flat), (6, 7, flat)]
        assert budgets == [(3.0, 2.0, most, LOOP)]
    rows[:] = [0]
    engine = SetEngine({"sets.add_end": add, "sets.sample_box": sample}, stopped=lambda: True)
    with pytest.raises(StoppedError):
        engine.map_starts(LOOP, starts, (cycle,), max_samples=None)
