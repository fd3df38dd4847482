"""Small pieces under a torque that lags, merged: what goes on has the torques of all, with all that they are off by."""

from fractions import Fraction
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.lattice import keep, late_cell, release
from hknob_cli.engine.general.sets.piece import ERROR, SPREAD, STATE, WEIGHT, piece_size
from hknob_cli.engine.general.sets.room import PieceRoom, make_piece_room

from .friction_work import SQUARE, zeros

LAG = 0.5
BODY: Any = SimpleNamespace(order=3, reach=2.0, lag=LAG)
DRIFT = Drift(powers=[], once=[], units=[0.5, 1.0, 1.0 / LAG], blur=0.0, coast=0.0, bottom=-inf)
SIZE = piece_size(3, 0)
WIDTH = 32.0


def room_of() -> PieceRoom:
    room = make_piece_room(zeros, 3, 0, lattice=16, deep=8)
    room.scale[0] = 1.0
    return room


def kept(room: PieceRoom, a: float, *, error: float = 0.0, spread: float = 0.0) -> None:
    """A piece at (4, 2), whose torque is ``a`` and differs by ``spread``."""
    room.own[SPREAD] = spread
    centre = Centre([4.0, 2.0, a], 0.0, [], 0, error, -1.0, 7.0, 0.25)
    assert keep(room, centre, SQUARE, 4, WIDTH, DRIFT, BODY)


def test_torques_that_lag_are_parted_by_what_they_can_still_add() -> None:
    """A quarter of a cell's width, in counts: a difference of a goes reach a / lag far. Without a lag there is none."""
    for a, width, lag, reach, cell in (
        (0.3, 0.25, 0.5, 2.0, 19.0), (-0.3, 0.25, 0.5, 2.0, -20.0), (0.3, 0.5, 0.5, 2.0, 9.0),
        (0.3, 0.25, 0.25, 2.0, 38.0), (0.3, 0.25, 0.5, 1.0, 9.0), (0.0, 0.25, 0.5, 2.0, 0.0),
        (0.3, 0.25, 0.0, 2.0, 0.0),
    ):  # fmt: skip
        assert late_cell([9.0, 9.0, a], width, SimpleNamespace(lag=lag, reach=reach)) == cell


def test_pieces_with_far_torques_are_not_merged() -> None:
    """A cell of torques is 2 wide here."""
    room = room_of()
    for a in (0.5, 1.5, 2.5, -0.5):
        kept(room, a)
    assert room.counts[0] == 3.0
    assert release(room, 0, 0, DRIFT) == 3
    found = {round(room.stack[SIZE * k + STATE + 2], 12): room.stack[SIZE * k + WEIGHT] for k in range(3)}
    assert found == {1.0: 0.5, 2.5: 0.25, -0.5: 0.25}


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_what_is_merged_has_the_torques_of_all(way: float) -> None:
    """With their spreads, errors and roundings: an error of 1 in the norm is a torque of the lag."""
    for one, other in (
        ((0.5, 0.0, 0.0), (1.5, 0.0, 0.0)), ((0.5, 0.25, 0.0), (1.5, 0.0, 0.125)), ((0.5, 0.0, 0.25), (1.5, 0.5, 0.0)),
        ((1.0, 0.0, 0.5), (1.25, 0.0, 0.125)), ((1.0, 2.0**-40, 2.0**-42), (1.0, 0.0, 0.0)),
    ):  # fmt: skip
        room = room_of()
        for a, error, spread in (one, other):
            kept(room, way * a, error=error, spread=spread)
        assert release(room, 0, 0, DRIFT) == 1
        middle, left, told = room.stack[STATE + 2], room.stack[SPREAD], room.stack[ERROR]
        ends = [
            (Fraction(way * a) - sign * (Fraction(spread) + Fraction(LAG) * Fraction(error)))
            for a, error, spread in (one, other)
            for sign in (1, -1)
        ]
        assert Fraction(middle) - Fraction(left) <= min(ends)
        assert Fraction(middle) + Fraction(left) >= max(ends)
        assert 2.0 * left <= float(max(ends) - min(ends)) + 16.0 * EPSILON * 1.5
        largest = sum(abs(float(end)) for end in (min(ends), max(ends)))
        assert told >= 4.0 * EPSILON * largest / LAG
        if one[1] == other[1] == 0.0:
            assert told == pytest.approx(4.0 * EPSILON * (0.5 * 8.0 + 4.0 + largest / LAG), rel=1e-12, abs=0.0)
        # Four roundings of each torque, and no more.
        lates = [spread + LAG * error + 4.0 * EPSILON * abs(a) for a, error, spread in (one, other)]
        low = min(way * one[0] - lates[0], way * other[0] - lates[1])
        high = max(way * one[0] + lates[0], way * other[0] + lates[1])
        assert (middle, left) == (0.5 * (low + high), 0.5 * (high - low))


def test_without_a_lag_no_torques_differ() -> None:
    room = make_piece_room(zeros, 2, 0, lattice=16, deep=8)
    plain: Any = SimpleNamespace(order=2, reach=2.0, lag=0.0)
    room.scale[0], room.stack[SPREAD] = 1.0, 9.0
    for x in (4.0, 5.0):
        centre = Centre([x, 2.0], 0.0, [], 0, 0.0, -1.0, 7.0, 0.25)
        assert keep(room, centre, SQUARE, 4, WIDTH, DRIFT, plain)
    assert release(room, 0, 0, DRIFT) == 1
    assert room.stack[SPREAD] == 0.0
