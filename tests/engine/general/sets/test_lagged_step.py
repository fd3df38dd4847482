"""Tests of `engine.general.sets.lagged_step`: no state of a set is lost over a hold under a torque that comes late."""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.advance import rub_many
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.sets.convex import keep_side, radius_of
from hknob_cli.engine.general.sets.friction_room import _halves, plane_of
from hknob_cli.engine.general.sets.friction_step import (
    CUT,
    ENCLOSED,
    HELD,
    MOST_CUTS,
    SLID,
    Room,
    Shape,
    parts_of_hold,
)
from hknob_cli.engine.general.sets.lagged_step import DEEPEST, LATER, depth_at, move_lagged
from hknob_cli.engine.general.sets.lagged_stops import LAGS, LaggedHold
from tests.engine.general.sets.test_friction_step import ROOM, body_of, inside_of, shapes
from tests.engine.sets.loops import zeros
from tests.engine.sets.test_polygon import states_of

bodies = st.builds(
    body_of,
    alpha=st.floats(0.0, 3.0),
    beta=st.floats(1e-5, 2.0),
    friction=st.floats(1e-3, 2.0),
    push=st.floats(0.0, 1.0),
    lag=st.sampled_from([0.05, 0.5, 3.0, 20.0, 1000.0]),
)

SETS: dict[str, Any] = {
    "body": bodies,
    "corners": shapes(),
    "x": st.floats(-3.0, 1.0),
    "v": st.one_of(st.just(0.0), st.floats(-1.0, 1.0), st.floats(-0.01, 0.01)),
    "a": st.floats(0.0, 3.0),
    "u": st.floats(0.0, 3.0),
    "seed": st.integers(0, 2**32 - 1),
}


def move_one(body: Body, x: float, v: float, a: float, u: float, span: float) -> tuple[float, float]:
    """One state, by the loop that follows trials."""
    z = [x, v, a]
    rub_many(z, u, span, body, zeros(6))
    return z[0], z[1]


class Part(NamedTuple):
    """A set on its way: where in the interval, how often it was cut and halved, centre, torque, corners."""

    at: float
    cuts: int
    depth: int
    fate: int
    x: float
    v: float
    a: float
    own: list[float]


def room_of(line: list[float]) -> Room:
    return Room(zeros(ROOM + 8), line, zeros(3), zeros(6))


class Mover:
    """Moves sets of a body over a period under the command ``u``, as `friction_piece` does."""

    def __init__(self, body: Body, u: float) -> None:
        self.body, self.plane, self.u = body, plane_of(body), u
        self.parts = parts_of_hold(1.0, self.plane)
        assert self.parts > 0
        self.lags, self.line = _halves(body, 1.0 / self.parts), zeros(3)

    def move(self, one: Part, least: float) -> Part:
        """One part of the interval on."""
        work, numbers = one.own + zeros(ROOM), self.lags[one.depth * LAGS : (one.depth + 1) * LAGS]
        shape = Shape(one.x, one.v, work, len(one.own) // 2)
        hold = LaggedHold(one.a, 0.0, self.u, numbers, one.depth < DEEPEST)
        fate, x, v, a, count = move_lagged(shape, hold, least, self.plane, self.body, room_of(self.line))
        if fate in (CUT, LATER):
            return one._replace(fate=fate)
        then = one.at + 0.5**one.depth
        return Part(then, 0, int(depth_at(then, one.depth)), fate, x, v, a, work[: 2 * count])

    def sides(self, one: Part) -> list[Part]:
        """Both sides of the line that was asked for; fewer where a side is empty."""
        p, q, r = self.line
        found = []
        for sign in (1.0, -1.0):
            out = zeros(len(one.own) + 4)
            kept = keep_side(one.own, len(one.own) // 2, sign * p, sign * q, sign * r, out)
            if kept:
                found.append(one._replace(cuts=one.cuts + 1, own=out[: 2 * kept]))
        return found


def move_all(
    x: float, v: float, a: float, u: float, corners: list[float], body: Body, least: float
) -> list[tuple[int, float, float, list[float]]]:
    """Move a set over one period: ``(fate, x, v, corners)`` of each part."""
    mover = Mover(body, u)
    waiting, done, tries = [Part(0.0, 0, 0, SLID, x, v, a, list(corners))], [], 0
    while waiting:
        one = waiting.pop()
        if one.at == mover.parts:
            done.append((one.fate, one.x, one.v, one.own))
            continue
        tries += 1
        assume(tries + len(done) < 4000)
        limit = least if one.cuts < MOST_CUTS else float("inf")
        moved = mover.move(one, limit)
        while moved.fate == LATER:
            one = one._replace(depth=one.depth + 1)
            moved = mover.move(one, limit)
        if moved.fate == CUT:
            sides = mover.sides(one)
            if len(sides) == 2:
                waiting += sides
                continue
            moved = mover.move(one, float("inf"))
            assert moved.fate in (ENCLOSED, HELD)
        waiting.append(moved)
    return done


@pytest.mark.one_in(16)
@pytest.mark.parametrize("turn", range(16))
@settings(deadline=None, max_examples=40, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(**SETS)
def test_no_state_is_lost(
    turn: int, body: Body, corners: list[float], x: float, v: float, a: float, u: float, seed: int
) -> None:
    """Every state of the set, moved by itself as a trial, lies in a part of the set that has moved."""
    size = radius_of(corners, len(corners) // 2, 1.0)
    done = move_all(x, v, a, u, corners, body, 1e-3 * size + 1e-9)
    slack = 1e-10 * (1.0 + abs(x) + abs(v) + a + u + size) * (1.0 + 1.0 / sqrt(body.beta))
    for dx, dv in states_of(corners, 24, seed + turn):
        at_x, at_v = move_one(body, x + dx, v + dv, a, u, 1.0)
        assert any(inside_of(at_x - to_x, at_v - to_v, own, slack) for _, to_x, to_v, own in done)


@pytest.mark.long
@settings(deadline=None, max_examples=300, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(depth=st.integers(0, DEEPEST), **SETS)
def test_no_state_is_lost_without_a_cut(
    body: Body, corners: list[float], x: float, v: float, a: float, u: float, depth: int, seed: int
) -> None:
    """The enclosure holds all states of any set over any part of a hold, whatever they do in it."""
    plane = plane_of(body)
    n = parts_of_hold(1.0, plane)
    numbers = _halves(body, 1.0 / n)[depth * LAGS : (depth + 1) * LAGS]
    count = len(corners) // 2
    work = corners + zeros(ROOM)
    shape, hold = Shape(x, v, work, count), LaggedHold(a, 0.0, u, numbers, False)
    fate, to_x, to_v, to_a, after = move_lagged(shape, hold, float("inf"), plane, body, room_of(zeros(3)))
    assert fate not in (CUT, LATER)
    size = radius_of(corners, count, 1.0)
    slack = 1e-10 * (1.0 + abs(x) + abs(v) + a + u + size) * (1.0 + 1.0 / sqrt(body.beta))
    z = [x, v, a]
    rub_many(z, u, numbers[0], body, zeros(6))
    assert to_a == pytest.approx(z[2], abs=1e-12)
    for dx, dv in states_of(corners, 24, seed):
        at_x, at_v = move_one(body, x + dx, v + dv, a, u, numbers[0])
        assert inside_of(at_x - to_x, at_v - to_v, work[: 2 * after], slack)
        if fate == HELD:
            assert at_v == 0.0


def test_what_slides_moves_as_a_trial_does() -> None:
    """The centre's closed form and the trial's halvings are two ways to one motion."""
    chance = np.random.default_rng(1)
    for lag in (0.05, 1.0, 20.0, 1e4):
        body = body_of(0.2, 0.05, 0.1, 0.3, lag)
        plane = plane_of(body)
        for depth in (0, 3, 9):
            numbers = _halves(body, 0.5)[depth * LAGS : (depth + 1) * LAGS]
            x, v, a, u = chance.uniform(-1, 1), chance.uniform(2.0, 4.0), *chance.uniform(0.0, 1.0, 2)
            work = [-0.1, -0.1, 0.1, -0.1, 0.1, 0.1, -0.1, 0.1, *zeros(ROOM)]
            shape, hold = Shape(x, v, work, 4), LaggedHold(a, 0.0, u, numbers, True)
            fate, to_x, to_v, to_a, count = move_lagged(shape, hold, 0.0, plane, body, room_of(zeros(3)))
            assert (fate, count) == (SLID, 4)
            z = [x, v, a]
            rub_many(z, u, numbers[0], body, zeros(6))
            assert [to_x, to_v, to_a] == pytest.approx(z, rel=1e-13, abs=1e-13)
