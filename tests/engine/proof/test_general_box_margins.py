"""Pieces of the general loop followed until they end: where what balls, cuts and ends say is written down.

So a piece stands exactly where it ends, is parted, kept, or looks for an end of its own; no state of it may be lost,
and every rounding counts. How a box begins is told by exact fractions.
"""

import random
from collections.abc import Callable
from fractions import Fraction
from math import sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN, REST_PROVEN, UNSETTLED
from hknob_cli.engine.follow import GREW as GREW_FATE
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets import box
from hknob_cli.engine.general.sets.ball import (
    CAPTURED,
    FIRST_REST_TEST,
    GREW,
    MEETS_EDGE,
    OUT_OF_SAMPLES,
    STEPS_DEEPER,
)
from hknob_cli.engine.general.sets.box import ENDED, KEPT, PARTED, SECTION, SMALL, UNPROVEN
from hknob_cli.engine.general.sets.cell import Cell, Centre
from hknob_cli.engine.general.sets.known import FULL, NO_ROOM, UNPROVEN_END
from hknob_cli.engine.general.sets.piece import BEFORE, COUNT, ERROR, LEVEL, SAMPLE, STATE, WEIGHT, piece_size
from hknob_cli.engine.general.sets.room import PieceRoom
from hknob_cli.engine.general.sets.scope import Scope

from .test_general_capture_margins import body_of, room, wall_of
from .test_general_cutting_margins import SQUARE, drift_of, small_room, waiting

BODY = body_of(1.0, 4.0, 1.0)  # half a count for a norm of 1
DRIFT = drift_of()._replace(blur=0.0625)
WALL = wall_of()
FAR = 4.0, -2.0, 1.0, 0.5  # middle x and v, error, weight of the piece that is followed
BUDGET, LIMIT = 1000, 77.0
FIRST = sqrt(4.25)  # norm of the corners of `SQUARE`
BLURRED = 0.0625 * FIRST
BALL = "centre", "radius", "run", "next_test", "samples", "limit", "small", "cell"
Answer = tuple[Any, ...]


def says(event: int, used: int, row: int = -1, **more: Any) -> tuple[Answer, dict[str, Any]]:
    """What a ball comes to: and where its centre is then."""
    one = {"before": 0.0, "head": 0, "error": 0.25, "level": -2.0, "run": 3, "next_test": 16} | more
    return (event, row, *(one[k] for k in ("before", "head", "error", "level", "run", "next_test")), used), more


def asked_of(*given: Any) -> dict[str, Any]:
    """What a ball is asked to follow, by name."""
    one = dict(zip(BALL, given, strict=True))
    centre, cell = one["centre"], one["cell"]
    return one | centre._asdict() | cell._asdict() | {"z": list(centre.z), "ring": list(centre.ring)}


def come_to(centre: Centre, answer: Answer) -> Answer:
    """The answer of a ball that was followed from this centre."""
    event, row, before, head, error, level, run, next_test, used = answer
    sample = centre.sample + used
    end = centre._replace(before=before, head=head, error=error, level=level, sample=sample)
    return event, row, end, run, next_test


def scope_of(patience: int, budget: int = BUDGET, skip: int = 0) -> Scope:
    return Scope(budget=budget, skip=skip, patience=patience, limit=LIMIT, fine=True)


class Followed:
    """The third piece that waits, followed."""

    def __init__(self, patch: pytest.MonkeyPatch, balls: list[Any], **more: Any) -> None:
        """``seeks``: row and samples of each search; ``parted``: pieces that wait then; ``keeps``: whether it fits."""
        self.balls, self.seeks, self.keeps = list(balls), list(more.get("seeks", [])), list(more.get("keeps", []))
        self.parted, self.halts = more.get("parted", 5), more.get("halts", 0.0)
        self.seen: list[dict[str, Any]] = []
        self.parts: list[Answer] = []
        self.kept: list[Answer] = []
        self.steps: list[Answer] = []
        self.looked: list[Answer] = []
        for name in ("follow_ball", "seek", "keep", "part", "step_through"):
            patch.setattr(box, name, getattr(self, name))
        self.delay = more.get("delay", 0)
        self.body = BODY._replace(halt=[0.0])
        self.known, self.room = room(self.delay), small_room(self.delay)
        self.known.table[0], self.known.table[FIELDS], self.known.table[2 * FIELDS] = CYCLE_PROVEN, REST_PROVEN, 0.0
        self.known.table[2 * FIELDS] = CYCLE_ON_EDGE
        self.wall = more.get("wall", WALL)
        corners, sample, count = more.get("corners", SQUARE), more.get("sample", 0.0), 0
        x, v, error, weight = FAR
        one = [more.get("error", error), 5.0, -3.0, sample, weight, 0.0, 0.0, more.get("x", x), v]
        count = len(corners) // 2
        one[COUNT] = float(count)
        one += [10.0 * k for k in range(1, self.delay + 1)] + list(corners)
        assert (ERROR, BEFORE, LEVEL, SAMPLE, WEIGHT, STATE) == (0, 1, 2, 3, 4, 7)
        size = piece_size(2, self.delay)
        self.room.stack[:] = [9.0] * len(self.room.stack)
        self.room.stack[2 * size : 2 * size + len(one)] = one

    def follow_ball(self, centre: Centre, *given: Any) -> Answer:
        self.seen.append(asked_of(centre, *given))
        answer, more = self.balls.pop(0)
        z = centre.z
        z[0], z[1] = more.get("x", z[0]), more.get("v", z[1])
        return come_to(centre, answer)

    def seek(self, centre: Centre, scope: Scope, cell: Cell) -> Any:
        z, before, ring, head = centre[:4]
        self.looked.append((list(z), before, list(ring), head, scope.budget - int(centre.sample), scope.limit))
        assert cell[1:] == (self.known, self.body, self.wall)
        self.body.halt[0] = self.halts
        return self.seeks.pop(0)

    def keep(self, room: PieceRoom, centre: Centre, corners: Any, count: int, width: float, *_: Any) -> bool:
        self.kept.append((list(centre.z), *centre[1:], list(corners[: 2 * count]), width))
        return bool(self.keeps.pop(0))

    def part(
        self, room: PieceRoom, waits: int, centre: Centre, count: int, low: float, high: float, reach: float, _: Cell
    ) -> int:
        z, before, _, head, error, _, sample, weight = centre
        corners = list(room.corners[: 2 * count])
        self.parts.append((waits, list(z), before, head, error, reach, sample, weight, corners, low, high))
        return int(self.parted)

    def step_through(self, centre: Centre, *_: Any) -> Centre:
        z, before, ring, head, error, level, sample, _ = centre
        self.steps.append((list(z), before, error, level, list(ring), head))
        z[0] += 0.5
        return centre._replace(before=before + 1.0, error=error + 0.125, head=head + 1, sample=sample + 1.0)

    def run(self, width: float = 0.0, patience: int = 64, budget: int = BUDGET) -> Answer:
        cell = Cell(DRIFT, self.known, self.body, self.wall)
        found = box.follow_piece(self.room, 3, width, scope_of(patience, budget), cell)
        assert self.balls == []
        return tuple(found)


@pytest.fixture
def followed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Followed]:
    return lambda balls, **more: Followed(monkeypatch, balls, **more)


def moved(samples: int) -> list[float]:
    """The corners of `SQUARE`, moved by the plant so many samples."""
    corners = list(zip(SQUARE[::2], SQUARE[1::2], strict=True))
    for _ in range(samples):
        corners = [(x + 0.5 * v, -0.25 * x + 0.75 * v) for x, v in corners]
    return [value for one in corners for value in one]


def radius(samples: int) -> float:
    corners = moved(samples)
    return max(sqrt(v * v + 4.0 * x * x) for x, v in zip(corners[::2], corners[1::2], strict=True))


# One piece.


@pytest.mark.parametrize("delay", [0, 2])
def test_a_piece_is_followed_as_a_ball_around_its_centre(followed: Callable[..., Followed], delay: int) -> None:
    """With its last reading, its level, its commands under way, and what its corners may lose by rounding."""
    one = followed([says(CAPTURED, 5)], delay=delay)
    assert one.run() == (2, ENDED, 5)
    seen = one.seen[0]
    assert (seen["z"], seen["before"], seen["level"], seen["error"]) == ([4.0, -2.0], 5.0, -3.0, 1.0)
    assert (seen["ring"], seen["head"]) == ([10.0, 20.0][:delay], 0)
    assert (seen["run"], seen["next_test"], seen["limit"]) == (0, FIRST_REST_TEST, LIMIT)
    assert seen["radius"] == pytest.approx(FIRST + BLURRED, rel=1e-15)
    assert (seen["drift"], seen["known"], seen["body"], seen["wall"]) == (DRIFT, one.known, one.body, WALL)
    assert one.known.why == [0.0] * len(one.known.why)


def test_the_radius_is_computed_again_after_eight_samples_or_an_eighth_of_half_the_patience(
    followed: Callable[..., Followed],
) -> None:
    """From the corners as they were at first, moved through all samples since; what they lose stays."""
    for patience, between in ((64, 8), (128, 8), (144, 9), (240, 15), (16 * 15 + 15, 15), (16 * 17, 17)):
        one = followed([says(OUT_OF_SAMPLES, between), says(OUT_OF_SAMPLES, 1), says(CAPTURED, 0)])
        assert one.run(patience=patience) == (2, ENDED, between + 1)
        assert [seen["samples"] for seen in one.seen] == [between] * 3
        for seen, samples in zip(one.seen, (0, between, between + 1), strict=True):
            assert seen["radius"] == pytest.approx(radius(samples) + BLURRED, rel=1e-12)
        assert [seen["error"] for seen in one.seen] == [1.0, 0.25, 0.25]
        assert (one.seen[1]["level"], one.seen[1]["run"], one.seen[1]["next_test"]) == (-2.0, 3, 16)


def test_what_grows_or_has_no_samples_left_is_not_proven(followed: Callable[..., Followed]) -> None:
    """And says why, with its weight."""
    for answer, sample, fate in (
        (says(GREW, 3), 0.0, GREW_FATE),
        (says(GREW, 5), 995.0, GREW_FATE),
        (says(OUT_OF_SAMPLES, 5), 995.0, UNSETTLED),
        (says(OUT_OF_SAMPLES, 6), 995.0, UNSETTLED),
        (says(MEETS_EDGE, 5), 995.0, UNSETTLED),
    ):
        one = followed([answer], sample=sample)
        assert one.run() == (2, UNPROVEN, answer[0][-1])
        assert {k: weight for k, weight in enumerate(one.known.why) if weight} == {fate: 0.5}
    one = followed([says(OUT_OF_SAMPLES, 4), says(GREW, 0)], sample=995.0)
    one.run()
    assert [seen["samples"] for seen in one.seen] == [5, 1]
    one = followed([says(CAPTURED, 5)], sample=995.0)
    assert one.run() == (2, ENDED, 5)


# Without an end.


def test_a_piece_long_in_no_known_attractor_looks_for_its_centres_own(followed: Callable[..., Followed]) -> None:
    """After its patience, counted from its start through all cuts; then after twice that, and twice that again."""
    ways = says(OUT_OF_SAMPLES, 10, x=3.0, v=0.5, before=2.0, head=1)
    for sample, first in ((0.0, 10), (3.0, 7), (10.0, 10), (23.0, 7)):
        balls = [ways if first == 10 else says(OUT_OF_SAMPLES, first, x=3.0, v=0.5, before=2.0, head=1)]
        one = followed([*balls, says(OUT_OF_SAMPLES, 20), says(OUT_OF_SAMPLES, 1), says(CAPTURED, 2)], sample=sample,
                       delay=2, seeks=[(0, 100), (1, 30)])  # fmt: skip
        assert one.run(patience=10) == (2, ENDED, first + 20 + 1 + 2 + 100 + 30)
        at = int(sample) + first
        assert one.looked[0] == ([3.0, 0.5], 2.0, [10.0, 20.0], 1, BUDGET - at, LIMIT)
        assert one.looked[1][4] == BUDGET - at - 20
        assert [seen["samples"] for seen in one.seen] == [min(8, first), 8, 8, 8]
    # No further than to the next look: 3 of 11 are left.
    one = followed([says(OUT_OF_SAMPLES, 8), says(OUT_OF_SAMPLES, 3), says(CAPTURED, 0)], seeks=[(0, 0)])
    one.run(patience=11)
    assert [seen["samples"] for seen in one.seen] == [8, 3, 8]
    assert len(one.looked) == 1
    one = followed([says(OUT_OF_SAMPLES, 5), says(OUT_OF_SAMPLES, 9), says(CAPTURED, 0)], seeks=[(0, 0)])
    one.run(patience=5)
    assert [seen["samples"] for seen in one.seen] == [5, 8, 1]


@pytest.mark.parametrize(("row", "fate"), [(2, CYCLE_ON_EDGE), (UNPROVEN_END, UNSETTLED), (-2, NO_ROOM)])
def test_a_piece_whose_centre_has_no_proven_end_has_none(
    followed: Callable[..., Followed], row: int, fate: int
) -> None:
    one = followed([says(OUT_OF_SAMPLES, 10)], seeks=[(row, 100)])
    assert one.run(patience=10) == (2, UNPROVEN, 110)
    assert {k: weight for k, weight in enumerate(one.known.why) if weight} == {fate: 0.5}


def test_a_piece_waits_as_it_was_where_a_search_is_given_up(followed: Callable[..., Followed]) -> None:
    one = followed([says(OUT_OF_SAMPLES, 10)], seeks=[(UNPROVEN_END, 100)], halts=1.0)
    before = waiting(one.room, 2)
    assert one.run(patience=10) == (3, PARTED, 110)
    assert waiting(one.room, 2) == before
    assert not any(one.known.why)


# Small enough to be merged.


def test_a_piece_is_small_below_two_fifths_of_the_lattice(followed: Callable[..., Followed]) -> None:
    """With its error, as a position: half of what it is in the norm. At first, and after it has moved."""
    assert SMALL == 0.4
    size = 0.5 * (FIRST + BLURRED + 1.0)
    for part, small in ((1.0 + 1e-12, True), (1.0 - 1e-12, False)):
        one = followed([says(CAPTURED, 0)])
        one.run(part * size / 0.4)
        assert one.seen[0]["small"] is small
    size = 0.5 * (radius(3) + BLURRED + 0.25)
    for part, small in ((1.0 + 1e-12, True), (1.0 - 1e-12, False)):
        one = followed([says(OUT_OF_SAMPLES, 3), *([] if small else [says(CAPTURED, 0)])], keeps=[True])
        found = one.run(part * size / 0.4)
        assert found == ((2, KEPT, 3) if small else (2, ENDED, 3))
        assert len(one.kept) == small
    # A point with an error of 4 is 2 large, and two fifths of 5 are no more than that.
    one = followed([says(OUT_OF_SAMPLES, 3, error=4.0), says(CAPTURED, 0)], corners=[0.0, 0.0], error=4.0)
    assert one.run(5.0) == (2, ENDED, 3)
    assert [seen["small"] for seen in one.seen] == [False, False]


def test_a_piece_is_kept_with_all_its_roundings(followed: Callable[..., Followed]) -> None:
    one = followed([says(OUT_OF_SAMPLES, 5, x=3.0, v=0.5, before=2.0, head=1)], keeps=[True], sample=7.0)
    assert one.run(100.0) == (2, KEPT, 5)
    z, before, ring, head, error, level, sample, weight, corners, width = one.kept[0]
    assert (z, before, ring, head, level, sample, weight, width) == ([3.0, 0.5], 2.0, [], 1, -2.0, 12.0, 0.5, 100.0)
    assert error == pytest.approx(0.25 + BLURRED, rel=1e-15)
    assert corners == pytest.approx(moved(5), rel=1e-12)


def test_in_a_narrow_lattice_pieces_are_kept_where_the_wall_steps_deeper_alone(
    followed: Callable[..., Followed],
) -> None:
    assert SECTION == 0.01
    dot = {"corners": [0.0, 0.0], "error": 0.0}
    for width, event, kept in (
        (SECTION, OUT_OF_SAMPLES, False),
        (SECTION, STEPS_DEEPER, True),
        (SECTION * (1.0 + 1e-15), OUT_OF_SAMPLES, True),
        (1.0, STEPS_DEEPER, True),
    ):
        answers = [says(event, 3, error=0.0), *([] if kept else [says(CAPTURED, 0)])]
        one = followed(answers, keeps=[True], **dot)
        assert one.run(width) == (2, KEPT if kept else ENDED, 3)


def test_where_the_lattice_is_full_a_piece_goes_on_and_stops_no_more(followed: Callable[..., Followed]) -> None:
    one = followed([says(STEPS_DEEPER, 3), says(OUT_OF_SAMPLES, 2), says(CAPTURED, 0)], keeps=[False, False])
    assert one.run(100.0) == (2, ENDED, 5)
    assert [seen["small"] for seen in one.seen] == [True, False, False]
    assert len(one.kept) == 2  # it asks again
    # One that meets an edge there is parted all the same.
    one = followed([says(MEETS_EDGE, 3, x=0.25)], keeps=[False])
    assert one.run(100.0) == (5, PARTED, 3)


# At an edge.

NARROW = [0.125, 1.0, 0.25, 0.0, -0.125, -1.0, -0.25, 0.0, -0.125, 0.5]


def at_edge(followed: Callable[..., Followed], x: float, error: float, **more: Any) -> Followed:
    """At the start of its way, so that its corners are as they were."""
    return followed([says(MEETS_EDGE, 0, x=x, error=error), *more.pop("then", [])], corners=NARROW, **more)


SIDE = sqrt(1.0 + 4.0 * 0.125**2)  # the norm of its farthest corner
SIDE_BLURRED = 0.0625 * SIDE


@pytest.mark.parametrize("x", [-8.0, 8.0, 0.0])
def test_a_piece_reaches_as_far_as_its_corners_and_its_roundings(followed: Callable[..., Followed], x: float) -> None:
    """The error as a position, what corners lose, and 8 units of where it is; beside both edges of a count."""
    wall = wall_of(damping=1e-9)  # each count acts by itself
    error = 0.25
    for side, edge in ((1.0, x + 1.0), (-1.0, x)):
        for off, low, high in ((1e-9, None, None), (-1e-9, edge - 1.0, edge)):
            reach = 0.5 * (error + SIDE_BLURRED)
            middle = edge - side * (0.25 + reach + off)
            one = at_edge(followed, middle, error, wall=wall, then=[] if low is not None else [says(CAPTURED, 0)])
            found = one.run()
            if low is None:
                assert found == (2, ENDED, 1)
                assert one.parts == []
                continue
            assert found == (5, PARTED, 0)
            waits, z, before, head, given, told, sample, weight, corners, least, most = one.parts[0]
            assert (waits, z, before, head, sample, weight) == (2, [middle, -2.0], 0.0, 0, 0.0, 0.5)
            assert (least, most, corners) == (low, high, NARROW)
            assert given == pytest.approx(error + SIDE_BLURRED, rel=1e-15)
            assert told == pytest.approx(reach + 8.0 * EPSILON * abs(middle), rel=1e-15, abs=0.0)


def test_the_place_of_a_piece_is_rounded_too(followed: Callable[..., Followed]) -> None:
    """8 units of it: seen where there is no error, and nothing else to be lost."""
    dot = {"corners": [0.0, 0.0], "error": 0.0, "wall": wall_of(damping=1e-9)}
    for x in (1024.0, -1024.0):
        for off in (7.0, 9.0):
            for side in (-1.0, 1.0):
                parted = off < 8.0
                middle = x + side * off * EPSILON * 1024.0
                then = [] if parted else [says(CAPTURED, 0)]
                one = followed([says(MEETS_EDGE, 0, x=middle, error=0.0), *then], **dot)
                assert one.run()[1] == (PARTED if parted else ENDED)
                if parted:
                    assert one.parts[0][5] == pytest.approx(8.0 * EPSILON * 1024.0, rel=1e-9, abs=0.0)


def test_a_piece_inside_one_reading_goes_on_one_sample(followed: Callable[..., Followed]) -> None:
    """As that reading acts; which counts for rest, for its patience, and for its corners."""
    for level, run, next_test in ((-2.0, 4, 16), (-1.0, 0, FIRST_REST_TEST)):
        one = at_edge(followed, -1.5, 0.25, then=[says(CAPTURED, 3)])
        one.balls[0] = says(MEETS_EDGE, 0, x=-1.5, before=2.0, head=7, level=level)
        assert one.run() == (2, ENDED, 0 + 1 + 3)
        assert one.steps == [([-1.5, -2.0], 2.0, 0.25, -2.0, [], 7)]
        seen = one.seen[1]
        assert (seen["z"], seen["before"], seen["error"], seen["head"]) == ([-1.0, -2.0], 3.0, 0.375, 8)
        assert (seen["level"], seen["run"], seen["next_test"]) == (-2.0, run, next_test)
    assert one.parts == []


def test_samples_that_meet_an_edge_count_for_patience_budget_and_corners(followed: Callable[..., Followed]) -> None:
    thin = [0.0, 0.0]
    edge = says(MEETS_EDGE, 2, x=-1.5, error=0.0)
    one = followed([edge, edge, says(OUT_OF_SAMPLES, 2), says(CAPTURED, 0)], corners=thin, seeks=[(0, 100)], sample=7.0)
    assert one.run(patience=15) == (2, ENDED, 3 + 3 + 2 + 100)
    assert [seen["samples"] for seen in one.seen] == [8, 5, 2, 8]
    assert one.looked[0][4] == BUDGET - 7 - 8
    one = followed([edge, says(CAPTURED, 0)], corners=thin, sample=990.0)
    one.run()
    assert [seen["samples"] for seen in one.seen] == [8, 7]
    # The radius after 2 samples, one that met an edge, and 2 more.
    one = followed([says(MEETS_EDGE, 2, x=-64.5, error=0.0), says(OUT_OF_SAMPLES, 2), says(CAPTURED, 0)],
                   corners=[0.25 * c for c in SQUARE])  # fmt: skip
    one.run()
    assert one.steps[0][3] == -65.0
    assert [seen["radius"] for seen in one.seen] == pytest.approx(
        [0.25 * (radius(k) + BLURRED) for k in (0, 2, 5)], rel=1e-12
    )


@pytest.mark.parametrize(("parted", "found"), [(-1, (2, UNPROVEN, 0)), (0, (0, PARTED, 0)), (6, (6, PARTED, 0))])
def test_where_there_is_no_room_for_parts_a_piece_is_not_proven(
    followed: Callable[..., Followed], parted: int, found: Answer
) -> None:
    one = at_edge(followed, -1.0, 0.25, parted=parted)
    assert one.run() == found
    assert one.known.why[NO_ROOM] == (0.5 if parted < 0 else 0.0)


# All of them.


class Generation:
    """Pieces with weights 1/2, 1/4, 1/8, ..., whose fates and samples are written down, the last that waits first."""

    def __init__(self, patch: pytest.MonkeyPatch, fates: list[tuple[int, int, int]], halts: int = -1) -> None:
        """``fates``: how many wait then, what became of it, and its samples; ``halts``: the piece that is given up."""
        self.fates, self.followed, self.halts = list(fates), 0, halts
        patch.setattr(box, "follow_piece", self.follow_piece)
        self.room, self.body = small_room(), BODY._replace(halt=[0.0])
        self.cell = Cell(DRIFT, room(), self.body, WALL)
        for k in range(8):
            self.room.stack[piece_size(2, 0) * k + WEIGHT] = 0.5 ** (k + 1)

    def follow_piece(self, room: PieceRoom, waits: int, *rest: Any) -> Answer:
        assert (room, rest) == (self.room, (0.25, scope_of(64), self.cell))
        if self.followed == self.halts:
            self.body.halt[0] = 1.0
        self.followed += 1
        return self.fates.pop(0)

    def run(self, first: int, samples: int = 10**6) -> Answer:
        return tuple(box.follow_generation(self.room, first, 0.25, samples, scope_of(64), self.cell))


def test_generations_count_what_ended_and_what_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    """A piece costs a sample more than it takes."""
    fates = [(2, ENDED, 7), (3, PARTED, 2), (2, UNPROVEN, 0), (1, KEPT, 4), (0, UNPROVEN, 5)]
    for samples, waits, pieces, undecided, taken in (
        (0, 3, 0, 0.0, 0),
        (1, 2, 1, 0.0, 8),
        (8, 2, 1, 0.0, 8),
        (9, 3, 1, 0.0, 11),
        (11, 3, 1, 0.0, 11),
        (12, 2, 2, 0.125, 12),
        (10**6, 0, 4, 0.125 + 0.5, 23),
    ):
        assert Generation(monkeypatch, fates).run(3, samples) == (waits, pieces, undecided, taken)
    assert Generation(monkeypatch, []).run(0) == (0, 0, 0.0, 0)
    assert Generation(monkeypatch, fates, halts=1).run(3) == (3, 1, 0.0, 11)


@pytest.mark.parametrize("delay", [0, 2])
def test_some_of_those_that_wait_are_looked_at_evenly_spread(monkeypatch: pytest.MonkeyPatch, delay: int) -> None:
    seen: list[Answer] = []

    def seek(centre: Centre, scope: Scope, cell: Cell) -> Answer:
        seen.append((*centre.z, centre.before, *centre.ring, centre.head))
        assert (scope.budget - int(centre.sample), scope.limit) == (BUDGET, LIMIT)
        return -1, 10 ** int(centre.before)

    monkeypatch.setattr(box, "seek", seek)
    work, size = small_room(delay), piece_size(2, delay)
    cell = Cell(DRIFT, room(delay), BODY, WALL)
    for k in range(7):
        work.stack[k * size : k * size + STATE] = [0.0, float(k), 0.0, 0.0, 0.0, 0.0, 0.0]
        work.stack[k * size + STATE : k * size + STATE + 2 + delay] = [k + 0.5, k + 0.25, k + 0.125, k + 0.75][
            : 2 + delay
        ]
    for some, waits, which in (
        (0, 5, []),
        (1, 5, [0]),
        (2, 5, [0, 2]),
        (3, 5, [0, 1, 3]),
        (3, 7, [0, 2, 4]),
        (5, 5, [0, 1, 2, 3, 4]),
        (9, 4, [0, 1, 2, 3]),
        (3, 0, []),
    ):
        seen.clear()
        assert box.seek_some(work, waits, some, scope_of(64), cell) == sum(10**k for k in which)
        assert seen == [(k + 0.5, k + 0.25, float(k), *[k + 0.125, k + 0.75][:delay], 0) for k in which]


# Single states.


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize(("patience", "samples"), [(7, 7), (BUDGET + 1, BUDGET)])
def test_single_states_are_counted_where_they_end(
    monkeypatch: pytest.MonkeyPatch, delay: int, patience: int, samples: int
) -> None:
    """The second to the fifth of six: captured, found, unknown, grown. No command is under way at first."""
    balls = [(CAPTURED, 1, 3), (OUT_OF_SAMPLES, -1, 7), (GREW, -1, 4), (MEETS_EDGE, -1, 0)]
    seeks, asked, looked = [(0, 20), (UNPROVEN_END, 300), (-2, 4000)], [], []
    damped = wall_of(damping=0.25)

    def follow_ball(centre: Centre, *given: Any) -> Answer:
        asked.append(asked_of(centre, *given))
        centre.z[:2] = [3.0, 0.5]
        event, row, used = balls.pop(0)
        return come_to(centre, (event, row, -5.0, 1, 0.25, -2.0, 3, 16, used))

    def seek(centre: Centre, scope: Scope, _: Cell) -> Answer:
        z, before, ring, head = centre[:4]
        looked.append((list(z), before, list(ring), head, scope.budget - int(centre.sample), scope.limit))
        return seeks.pop(0)

    monkeypatch.setattr(box, "follow_ball", follow_ball)
    monkeypatch.setattr(box, "seek", seek)
    work, ends, known = small_room(delay, order=3), [9.0] * 6, room(delay, 3)
    work.own_z[:], work.own_ring[:] = [9.0] * 3, [9.0] * delay
    body = BODY._replace(order=3)
    starts = [9.0, 9.0, 0.7, 0.125, -300.5, -1.0, 0.25, 40.0, -2.0, 0.1, 9.0, 9.0]
    scope = scope_of(64, skip=patience)
    found = box.sample_box(starts, 1, 5, ends, scope, work, Cell(DRIFT, known, body, damped))
    assert found == (3 + 7 + 4 + 0 + 20 + 300 + 4000, 2)
    assert ends == [9.0, 1, 0, UNPROVEN_END, -2, 9.0]
    assert [known.table[FIELDS * row + 6] for row in range(3)] == [1.0, 1.0, 0.0]
    assert sum(map(abs, known.table)) == 2.0
    assert [(one["z"][:2], one["before"]) for one in asked[:3]] == [
        ([0.7, 0.125], 0.0),
        ([-300.5, -1.0], -301.0),
        ([0.25, 40.0], 0.0),
    ]
    for one in asked:
        assert one["z"][2] == 0.0
        assert (one["ring"], one["head"]) == ([0.0] * delay, 0)
        assert [one[k] for k in ("radius", "error", "level", "run", "next_test", "samples", "limit", "small")] == [
            0.0, 0.0, 0.0, 0, FIRST_REST_TEST, samples, LIMIT, False,
        ]  # fmt: skip
    assert [one[:4] for one in looked] == [([3.0, 0.5, 0.0], -5.0, [0.0] * delay, 1)] * 3
    assert [one[4:] for one in looked] == [(BUDGET - 7, LIMIT), (BUDGET - 4, LIMIT), (BUDGET, LIMIT)]


# Where it begins.


@pytest.mark.parametrize(("order", "delay"), [(2, 0), (3, 2)])
def test_a_box_begins_with_what_telling_it_from_its_middle_rounds_away(order: int, delay: int) -> None:
    """4 units of its sides, positions counted twice, and of its middle: more than what is lost, by fractions."""
    chance, body = random.Random(1), BODY._replace(order=order)
    drift = DRIFT._replace(units=[2.0, 0.75, 1.0][:order])
    for _ in range(100):
        low_x, low_v = chance.uniform(-1e3, 1e3), chance.uniform(-1e3, 1e3)
        high_x, high_v = low_x + 10.0 ** chance.uniform(-3.0, 3.0), low_v + 10.0 ** chance.uniform(-3.0, 3.0)
        work = small_room(delay, order=order)
        for name in ("z", "ring", "corners", "halves"):
            getattr(work, name)[:] = [9.0] * len(getattr(work, name))
        work.counts[0] = 7.0
        assert box.fill_box((low_x, high_x, low_v, high_v), work, None, drift, body, WALL) == 1
        assert work.counts[0] == 0.0
        found = work.stack[: piece_size(order, delay)]
        assert [found[k] for k in (LEVEL, SAMPLE, WEIGHT, COUNT, BEFORE)] == [0.0, 0.0, 1.0, 4.0, 0.0]
        x, v, *rest = found[STATE : STATE + order + delay]
        assert (x, v, rest) == (0.5 * (low_x + high_x), 0.5 * (low_v + high_v), [0.0] * (order - 2 + delay))
        sides = 2.0 * (abs(low_x) + abs(high_x)) + 0.75 * (abs(low_v) + abs(high_v))
        told = 2.0 * 2.0 * abs(x) + 0.75 * 2.0 * abs(v)
        assert found[ERROR] == pytest.approx(4.0 * EPSILON * (sides + told), rel=1e-14, abs=0.0)
        corners = found[STATE + order + delay :]
        for k, (at_x, at_v) in enumerate([(low_x, low_v), (high_x, low_v), (high_x, high_v), (low_x, high_v)]):
            off_x = Fraction(x) + Fraction(corners[order * k]) - Fraction(at_x)
            off_v = Fraction(v) + Fraction(corners[order * k + 1]) - Fraction(at_v)
            assert 2 * abs(off_x) + abs(off_v) <= Fraction(found[ERROR])
            assert corners[order * k + 2 : order * (k + 1)] == [0.0] * (order - 2)


def test_a_box_begins_with_an_empty_lattice() -> None:
    """A search that was given up has left pieces in it. Another that met their places would take its own for merged."""
    work = small_room(0)
    for one, at in enumerate((1, 3)):
        work.taken[one], work.used[at] = at, 1.0
    work.counts[0] = 2.0
    assert box.fill_box((-1.0, 1.0, -0.5, 0.5), work, None, DRIFT, BODY, WALL) == 1
    assert not any(work.used)
    assert work.counts[0] == 0.0


def filled(low: float, high: float, pieces: int = 32, **more: float) -> list[tuple[float, ...]] | int:
    """Last reading, lower and upper end, and share of each piece of a box that virtual damping remembers."""
    work, drift = small_room(1, pieces=pieces), DRIFT
    wall = wall_of(**({"damping": 0.25} | more))
    total = box.fill_box((low, high, -0.5, 1.5), work, None, drift, BODY, wall)
    if total < 0:
        return total
    found = []
    for k in range(total):
        one = waiting(work, k, 1)
        corners = one[STATE + 3 : STATE + 11]
        assert one[COUNT] == 4.0
        assert [one[STATE + 1] + v for v in corners[1::2]] == [-0.5, -0.5, 1.5, 1.5]
        left, right = (one[STATE] + pick(corners[::2]) for pick in (min, max))
        found.append((one[BEFORE], left, right, one[WEIGHT]))
    return found


def test_with_virtual_damping_a_box_is_a_piece_for_each_reading() -> None:
    """With the part of the starts that reads so. A side on an edge has a piece of no width beyond it, which counts."""
    for low, high, found in (
        (-1.5, 2.5, [(-2.0, -1.5, -1.0, 0.125), (-1.0, -1.0, 0.0, 0.25), (0.0, 0.0, 1.0, 0.25), (1.0, 1.0, 2.0, 0.25),
                     (2.0, 2.0, 2.5, 0.125)]),
        (0.25, 0.75, [(0.0, 0.25, 0.75, 1.0)]),
        (-2.0, -1.0, [(-2.0, -2.0, -1.0, 1.0), (-1.0, -1.0, -1.0, EPSILON)]),
        (-1.25, -0.25, [(-2.0, -1.25, -1.0, 0.25), (-1.0, -1.0, -0.25, 0.75)]),
    ):  # fmt: skip
        assert filled(low, high) == found
    assert filled(-1.0, 0.5, sense=-1.0) == [
        (-1.0, -1.0, -1.0, EPSILON),
        (0.0, -1.0, 0.0, 2 / 3),
        (1.0, 0.0, 0.5, 1 / 3),
    ]
    assert filled(-1.5, 2.5, damping=0.0) == [(0.0, -1.5, 2.5, 1.0)]


def test_a_box_begins_with_all_its_pieces_or_with_none() -> None:
    assert isinstance(filled(-1.5, 2.5, pieces=5), list)
    assert filled(-1.5, 2.5, pieces=4) == -1
    assert filled(-1.5, 2.5, pieces=0) == -1
    assert filled(-1.5, 2.5, pieces=1) == -1


# Single states.


def test_single_states_are_followed_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each from what is remembered before a first sample that acts as it does."""
    rows, told = [1, -1, 0, FULL, 1], []

    def begin(law: Any, level: float, ring: list[float]) -> None:
        ring[:] = [level] * len(ring)

    def seek(centre: Centre, scope: Scope, cell: Cell) -> tuple[int, int]:
        z, before, ring, head = centre[:4]
        more = scope.budget - int(centre.sample), scope.limit, *cell[1:]
        told.append((list(z), before, list(ring), head, more))
        return rows[len(told) - 1], 10 ** len(told)

    monkeypatch.setattr(box, "begin_memory", begin)
    monkeypatch.setattr(box, "seek", seek)
    body = BODY._replace(order=3)
    known: Any = SimpleNamespace(law=SimpleNamespace(watch=wall_of()), table=[0.0] * (FIELDS * 4))
    place = SimpleNamespace(own_z=[7.0, 7.0, 7.0], own_ring=[0.0, 0.0])
    starts, ends = [-1.5, 0.5, -2.5, 0.25, 3.5, 0.0, -7.5, 1.0, 0.5, -1.0, -9.5, 2.0], [9] * 6
    wall = wall_of()
    scope, cell = Scope(1000, 0, 64, 77.0, fine=True), Cell(drift_of(-4.0), known, body, wall)
    found = box.sample_trials(starts, 1, 5, ends, scope, place, cell)
    assert found == (10 + 100 + 1000 + 10000, 2)
    assert ends == [9, 1, -1, 0, FULL, 9]
    assert [one[:4] for one in told] == [
        ([-2.5, 0.25, 0.0], 0.0, [-3.0, -3.0], 0),
        ([3.5, 0.0, 0.0], 0.0, [0.0, 0.0], 0),
        ([-7.5, 1.0, 0.0], 0.0, [-4.0, -4.0], 0),
        ([0.5, -1.0, 0.0], 0.0, [0.0, 0.0], 0),
    ]
    assert all(one[4] == (1000, 77.0, known, body, wall) for one in told)
    assert [known.table[row * FIELDS + 6] for row in range(4)] == [1.0, 1.0, 0.0, 0.0]
    assert sum(known.table) == 2.0
