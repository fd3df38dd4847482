"""How far sets of the general loop are followed, with how much room, and what is told of those without a proven end."""

from math import inf, nextafter
from typing import Any

import pytest

from hknob_cli.engine.budget import FINEST
from hknob_cli.engine.follow import CYCLE_ON_EDGE, GREW, UNSETTLED
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.search import GENERAL_FATES, make_space
from hknob_cli.engine.general.sets import scope
from hknob_cli.engine.general.sets.arc_parts import arc_size
from hknob_cli.engine.general.sets.ends import ENDS, FATES, POINTS, make_known, why_not
from hknob_cli.engine.general.sets.known import NO_ROOM
from hknob_cli.engine.general.sets.lattice import CELL, KEY
from hknob_cli.engine.general.sets.piece import CORNERS, piece_size
from hknob_cli.engine.general.sets.room import ARCS, hash_scale, make_arc_room, make_piece_room
from hknob_cli.engine.general.sets.scope import can_follow, make_scope
from hknob_cli.engine.outcome import Reason

from .test_general_capture_margins import body_of, room, wall_of
from .test_standstill_margins import body as rubbing_of


def zeros(count: int) -> list[float]:
    return [0.0] * count


# Which cells, and how far.


def test_sets_are_followed_where_differences_go_by_one_matrix_and_fade() -> None:
    """Not with friction, nor where every position has a reading of its own; nor where nothing damps or holds."""
    held, wall = body_of(1.0, 4.0, 1.0), wall_of()
    assert can_follow(held, wall)
    for body, other in (
        (held._replace(friction=1.0), wall),
        (held._replace(friction=1e-9), wall),
        (held, wall._replace(analog=1.0)),
        (held._replace(damped=False), wall),
        (held._replace(reach=inf), wall),
        (body_of(0.0, 4.0, 1.0), wall),
        (body_of(1.0, 0.0, 1.0), wall),
        (rubbing_of(friction=1.0), wall),
    ):
        assert not can_follow(body, other)


FINGER = body_of(1.0, 4.0, 1.0)._replace(order=4, ratio=1.0, reach=0.25, beta=0.5)


@pytest.mark.parametrize(("body", "spring"), [(body_of(1.0, 4.0, 1.0), 4.0), (FINGER, 16.0)])
def test_a_motion_goes_as_far_as_start_push_and_springs_say(body: Body, spring: float) -> None:
    """A million times that is what grows. The springs of a finger are told from how far a speed of 1 takes it."""
    wall = wall_of(2.0)
    for x, v, scale in ((5.0, 0.0, 5.0), (-5.0, 0.0, 5.0), (0.0, 90.0, 90.0 / spring**0.5), (0.0, 0.0, 1.0)):
        assert make_scope(body, wall, x, v, 0.25, None).limit == pytest.approx(1e6 * scale, rel=1e-15)
    pushed = body._replace(push=60.0)
    assert make_scope(pushed, wall, 0.0, 0.0, 0.25, None).limit == pytest.approx(60e6 / (2.0 + spring), rel=1e-15)


def test_a_torque_over_the_angle_may_reach_farther(monkeypatch: pytest.MonkeyPatch) -> None:
    for span, scale in ((9.0, 9.0), (4.0, 5.0)):
        monkeypatch.setattr(scope, "torque_range", lambda _, span=span: type("Range", (), {"span": span}))
        assert make_scope(body_of(1.0, 4.0, 1.0), wall_of(), 5.0, 0.0, 0.25, None).limit == 1e6 * scale


def test_positions_are_told_apart_below_the_finest() -> None:
    for x, fine in ((FINEST, False), (nextafter(FINEST, 0.0), True), (1.0, True), (2.0 * FINEST, False)):
        assert make_scope(body_of(1.0, 4.0, 1.0), wall_of(), x, 0.0, 0.25, None).fine == fine


def test_a_motion_gets_what_settling_wants_or_what_is_given() -> None:
    """600 time constants at most, and fewer with more states; an attractor is looked for after half the transient."""
    held = body_of(1.0, 4.0, 1.0)
    for rate, order, given, budget, skip, patience in (
        (0.25, 2, None, 65_536, 40, 64),
        (0.25, 2, 900, 900, 40, 64),
        (10.0 / 129.0, 2, None, 65_536, 129, 64),
        (10.0 / 130.9, 2, None, 65_536, 130, 65),
        (10.0 / 301.0, 2, None, 65_536, 301, 150),
        (2e-3, 2, None, 300_000, 5000, 2500),
        (1e-4, 2, None, 2**20, 100_000, 50_000),
        (2e-3, 3, None, 2**18, 5000, 2500),
        (2e-3, 5, None, 2**18, 5000, 2500),
        (2e-3, 2, 8000, 8000, 1000, 500),
        (0.0, 2, None, 2**20, 0, 64),
    ):
        found = make_scope(held._replace(order=order), wall_of(), 5.0, 0.0, rate, given)
        assert (found.budget, found.skip, found.patience) == (budget, skip, patience)


# Room.


@pytest.mark.parametrize(("order", "delay"), [(2, 0), (2, 3), (5, 2)])
def test_there_is_room_for_all_that_is_kept(order: int, delay: int) -> None:
    """As many numbers as functions of pieces, of arcs and of ends put into each list, and no more."""

    def sizes(of: Any) -> dict[str, int]:
        return {name: len(value) for name, value in of._asdict().items() if isinstance(value, list)}

    size = piece_size(order, delay)
    square, line = order * order, order * CORNERS
    assert sizes(make_piece_room(zeros, order, delay, lattice=16, deep=8)) == {
        "stack": 24 * size, "own": size, "own_z": order, "own_ring": delay, "corners": 2 * line, "parts": 8 * line,
        "halves": 4 * line, "moved": 4 * line, "middle": order, "z": order, "ring": delay, "matrix": square,
        "spare": square, "pad": 2 * order, "used": 16, "keys": 16 * (KEY + delay), "cells": 16 * CELL,
        "singles": 16 * size, "taken": 16, "counts": 1, "scale": 1,
    }  # fmt: skip
    assert sizes(make_arc_room(zeros, order, delay)) == {
        "stack": ARCS * arc_size(order, delay), "own_z": order, "own_ring": delay, "rate": order, "speed": order,
        "turn": order, "below": order, "above": order, "z": order, "ring": delay, "matrix": square, "power": square,
        "spare": order, "pad": 2 * order, "ended": 3 * ARCS,
    }  # fmt: skip
    assert sizes(make_known(zeros, order, delay, make_space(order, delay, zeros))) == {
        "table": FIELDS * ENDS, "states": order * ENDS, "lines": max(1, delay * ENDS),
        "points": (order + delay + 2) * POINTS, "counts": 2, "why": FATES, "z": order, "ring": delay, "check": order,
        "check_ring": delay, "keep": order, "keep_ring": delay,
    }  # fmt: skip


def table_of(*commands: float) -> list[float]:
    """Of a turn with these commands, one count each."""
    size = len(commands)
    runs = [float(k) for k in range(size)]
    return [0.0, float(size), 90.0, -90.0, *commands, *runs, *runs]


def test_commands_are_told_apart_by_whole_numbers() -> None:
    """8 of them between two counts of a wall; of a torque over the angle 2^15 up to its largest."""
    assert hash_scale(wall_of(0.25)) == 32.0
    assert hash_scale(wall_of(4.0)) == 2.0
    assert hash_scale(wall_of(0.0)) == 1.0
    for table, scale in (
        ((0.25, -0.5, 0.125), 2.0**16),
        ((4.0, 1.0), 2.0**13),
        ((-4.0, 1.0), 2.0**13),
        ((0.0, 0.0), 1.0),
    ):
        assert hash_scale(wall_of(3.0, table=table_of(*table))) == scale


def test_why_most_of_what_is_not_proven_is_not() -> None:
    """By measure; the largest alone is told."""
    known = room()
    assert why_not(known) is Reason.NONE
    for fate, weight, reason in (
        (GREW, 0.25, GENERAL_FATES[GREW][1]),
        (NO_ROOM, 0.5, Reason.TOO_MANY),
        (UNSETTLED, 0.75, GENERAL_FATES[UNSETTLED][1]),
        (CYCLE_ON_EDGE, 0.5, GENERAL_FATES[UNSETTLED][1]),
    ):
        known.why[fate] = weight
        assert why_not(known) is reason
    small = room()
    small.why[NO_ROOM] = 1e-12
    assert why_not(small) is Reason.TOO_MANY
