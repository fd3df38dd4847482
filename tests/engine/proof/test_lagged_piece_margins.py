"""A piece under a torque that lags, by hand: over which halves of an interval it moves, and what it carries along."""

from typing import Any

import pytest

from hknob_cli.engine.general.sets import friction_piece
from hknob_cli.engine.general.sets.convex import widest
from hknob_cli.engine.general.sets.friction_piece import move_over_part, move_piece
from hknob_cli.engine.general.sets.friction_set import LEG
from hknob_cli.engine.general.sets.friction_step import CUT, ENCLOSED, SLID, Room, Shape
from hknob_cli.engine.general.sets.lagged_step import DEEPEST, LATER
from hknob_cli.engine.general.sets.lagged_stops import LAGS, LEFT, LaggedHold
from hknob_cli.engine.general.sets.piece import ERROR, SPREAD, STATE, piece_size
from hknob_cli.engine.general.sets.room import make_piece_room

from .friction_work import SQUARE, body_of, cell_of, centre_of, drift_of, wall_of, work_of, zeros

BODY = body_of(friction=1.0)
BODY.order, BODY.lag = 3, 0.5
LEFTS = 0.5, 0.75, 0.875  # what is left of a difference in torque over a whole part, half of it, a quarter
DEPTHS = DEEPEST + 1
SIZE = piece_size(3, 0)


def lags_of(mark: float) -> list[float]:
    """Numbers of a part and of its halves: a mark, and how deep each is."""
    rows = []
    for depth in range(DEPTHS):
        row = [mark, float(depth), *zeros(LAGS - 2)]
        row[LEFT] = LEFTS[min(depth, 2)]
        rows += row
    return rows


class Lagged:
    """Moves a set over a part of a hold as told, fate by fate; then it slides. A torque is halved, whatever is left."""

    def __init__(self, patch: pytest.MonkeyPatch, *script: int, looks: int = 0) -> None:
        self.script, self.asked = list(script), []  # type: list[int], list[tuple[Any, ...]]
        patch.setattr(friction_piece, "move_lagged", self)
        self.work = work_of(
            course=[0.0, 0.5, 0.0, 0.0, 0.0, -1.0, 1.0, 0.5, 0.0, 0.0, 0.0, -1.0], lags=[*lags_of(7.0), *lags_of(8.0)],
            halves=[0.0, float(DEPTHS * LAGS)], lag=zeros(LAGS), plane="plane", moved=zeros(3), pad=zeros(6),
            z=zeros(3), looks=looks,
        )  # fmt: skip
        self.work.line[:] = [1.0, 0.0, 0.0]

    def __call__(self, shape: Shape, hold: LaggedHold, least: float, plane: Any, body: Any, room: Room) -> Any:
        (x, v, _, count), (a, apart, u, part, halve) = shape, hold
        assert (plane, body) == ("plane", BODY)
        assert room == (self.work.space, self.work.line, self.work.moved, self.work.pad)
        self.asked.append((a, apart, u, int(part[0]), int(part[1]), halve))
        fate = self.script.pop(0) if self.script else SLID
        if fate in (LATER, CUT):
            return fate, x, v, a, count
        return fate, x + 1.0, v, 0.5 * a, count


@pytest.mark.parametrize("depth", [0, 1, 2, DEEPEST - 1, DEEPEST])
def test_a_part_is_looked_up_by_its_length_and_its_halvings(monkeypatch: pytest.MonkeyPatch, depth: int) -> None:
    """The last half of all is not halved."""
    for part, mark, u in ((0.0, 7, 3.0), (0.5, 7, 3.0), (1.0, 8, 4.0), (1.75, 8, 4.0)):
        one = Lagged(monkeypatch)
        one.work.torques[:] = [3.0, 4.0]
        one.work.acts[:3] = [-4.0, 0.25, float(depth)]
        found = move_over_part(one.work, (part, 1.0, 2.0, 1.0), 4, 0.125, BODY)
        assert found == (SLID, 2.0, 2.0, -2.0, 4)
        assert one.asked == [(-4.0, 0.25, u, mark, depth, depth < DEEPEST)]
        assert len(one.work.course) == 2 * LEG


class Moved:
    """The piece that waits after an interval in which a piece at (-1.5, 16) moves, whose torque is ``a``."""

    def __init__(self, one: Lagged, a: float = -4.0, body: Any = BODY) -> None:
        room = make_piece_room(zeros, 3, 0, lattice=8, deep=8)
        room.own[SPREAD] = 0.25
        one.work.acts[:3] = [9.0, 9.0, 9.0]
        drift = drift_of((0.5, 0.25, 0.125, 0.0625, 0.03125), blur=0.015625)
        room.corners[: len(SQUARE)] = SQUARE
        told = centre_of([-1.5, 16.0, a], [], error=1.0, level=-2.0, sample=5.0)
        self.waiting = move_piece(room, one.work, 0, told, 4, cell_of(body, drift, wall_of()))
        piece = room.stack[:SIZE]
        self.state, self.error, self.spread = piece[STATE : STATE + 3], piece[ERROR], piece[SPREAD]
        self.told = 1.0 + 0.5 + 0.25 * 2.0 + 0.125 * 1.5 + 0.0625 * 16.0 + 0.015625 * widest(SQUARE, 4, body)


def test_the_torque_that_acts_goes_along(monkeypatch: pytest.MonkeyPatch) -> None:
    """And by what those of its states differ, of which each part leaves its own; it is rounded itself."""
    for a in (-4.0, 4.0):
        one = Lagged(monkeypatch)
        found = Moved(one, a)
        assert one.asked == [(a, 0.25, 2.0, 7, 0, True), (0.5 * a, 0.125, 2.0, 8, 0, True)]
        assert (found.waiting, found.state, found.spread) == (1, [0.5, 16.0, 0.25 * a], 0.0625)
        assert found.error == pytest.approx(found.told + 0.03125 * 4.0, rel=1e-14)


def test_halves_are_taken_where_they_tell_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half by half until the part is over; the next is as long as its place allows."""
    one = Lagged(monkeypatch, LATER)
    found = Moved(one)
    assert one.asked == [
        (-4.0, 0.25, 2.0, 7, 0, True), (-4.0, 0.25, 2.0, 7, 1, True), (-2.0, 0.1875, 2.0, 7, 1, True),
        (-1.0, 0.75 * 0.1875, 2.0, 8, 0, True),
    ]  # fmt: skip
    assert (found.state[2], found.spread) == (-0.5, 0.375 * 0.1875)
    one = Lagged(monkeypatch, LATER, LATER, ENCLOSED, ENCLOSED, ENCLOSED)
    Moved(one)
    assert [(mark, depth) for _, _, _, mark, depth, _ in one.asked] == [(7, 0), (7, 1), (7, 2), (7, 2), (7, 1), (8, 0)]
    one = Lagged(monkeypatch, LATER, SLID, LATER)
    Moved(one)
    assert [(mark, depth) for _, _, _, mark, depth, _ in one.asked] == [
        (7, 0),
        (7, 1),
        (7, 1),
        (7, 2),
        (7, 2),
        (8, 1),
        (8, 1),
    ]


def test_a_set_that_is_cut_is_cut_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both sides go on from there, under the same torque, over the same half."""
    one = Lagged(monkeypatch, LATER, CUT)
    found = Moved(one)
    assert found.waiting == 2
    assert [given[:5] for given in one.asked[:3]] == [
        (-4.0, 0.25, 2.0, 7, 0), (-4.0, 0.25, 2.0, 7, 1), (-4.0, 0.25, 2.0, 7, 1),
    ]  # fmt: skip
    assert found.spread == 0.375 * 0.1875


def test_without_a_lag_no_torque_goes_along(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = body_of(friction=1.0)
    plain.order = 3
    one = Lagged(monkeypatch)
    one.work.lags = None
    monkeypatch.setattr(friction_piece, "move_set", lambda shape, *_: (SLID, shape.x + 1.0, shape.v, shape.number))
    found = Moved(one, body=plain)
    assert (found.waiting, found.state, found.spread) == (1, [0.5, 16.0, 0.0], 0.0)
    assert found.error == pytest.approx(found.told, rel=1e-14)


def test_a_look_is_at_the_end_of_a_whole_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not at that of a half."""
    looked: list[Any] = []

    def look(room: Any, work: Any, at: int, place: tuple[float, ...], *given: Any) -> int:
        looked.append(place)
        return -1

    monkeypatch.setattr(friction_piece, "look_at_set", look)
    monkeypatch.setattr(friction_piece, "command_all", lambda *_: (0, 2.0))
    for script in ((), (LATER,), (LATER, LATER)):
        one = Lagged(monkeypatch, *script, looks=1)
        one.work.course[5] = 0.0
        assert Moved(one).waiting == -1
        assert looked.pop()[0] == 1.0
        assert looked == []
