"""What floating point makes of an interval under a torque that lags, against 60 digits: no more than its bound says."""

import random
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.sets.friction_piece import move_piece
from hknob_cli.engine.general.sets.friction_room import can_rub, friction_drift, make_friction_room
from hknob_cli.engine.general.sets.piece import COUNT, ERROR, STATE, piece_size
from hknob_cli.engine.general.sets.room import make_piece_room
from tests.engine.general.sets.test_friction_step import body_of

from .friction_work import cell_of, centre_of
from .orbits import DIGITS
from .test_friction_rounding import apart, wall_of, zeros

Number = Any  # of mpmath
LOOKS = 32  # times at which a slide is looked at for its first turn
BITS = 170  # to which a turn is found
State = tuple[Number, Number, Number]


def slide(state: State, u: Number, way: int, t: Number, body: Body) -> State:
    """Angle, speed and torque a time on, sliding in direction ``way``."""
    drive = mp.mpf(body.drive) - way * mp.mpf(body.friction)
    rates = mp.zeros(4)
    rates[0, 1] = rates[1, 2] = 1
    rates[1, 0], rates[1, 1], rates[1, 3] = -mp.mpf(body.beta), -mp.mpf(body.alpha), drive
    rates[2, 2], rates[2, 3] = -mp.mpf(body.lag), mp.mpf(body.lag) * u
    to = mp.expm(rates * t) * mp.matrix([*state, 1])
    return to[0], to[1], to[2]


def first_turn(state: State, u: Number, way: int, span: Number, body: Body) -> Number | None:
    """When the speed first vanishes; None if it does not."""
    before = mp.mpf(0)
    for k in range(1, LOOKS + 1):
        after = span * k / LOOKS
        if slide(state, u, way, after, body)[1] * way < 0:
            for _ in range(BITS):
                middle = (before + after) / 2
                turned = slide(state, u, way, middle, body)[1] * way < 0
                before, after = (before, middle) if turned else (middle, after)
            return before
        before = after
    return None


def exact(state: State, u: Number, body: Body) -> State:
    """One interval, slide by slide; friction holds until the torque has changed by enough."""
    friction, drive, beta, lag = (mp.mpf(value) for value in (body.friction, body.drive, body.beta, body.lag))
    left, (x, v, a) = mp.mpf(1), state
    while left > 0:
        pull = a + drive - beta * x
        way = int(mp.sign(v)) if v != 0 else (int(mp.sign(pull)) if abs(pull) > friction else 0)
        if way == 0:
            ends = [(side * friction - drive + beta * x - u) / (a - u) for side in (1, -1)] if a != u else []
            times = [-mp.log(part) / lag for part in ends if 0 < part < 1]
            t = min([one for one in times if one < left], default=left)
            t = min(t + mp.mpf(10) ** -50, left)  # just beyond the edge, where it slides
            a, left = u + (a - u) * mp.exp(-lag * t), left - t
            continue
        t = first_turn((x, v, a), u, way, left, body)
        x, v, a = slide((x, v, a), u, way, left if t is None else t, body)
        if t is None:
            break
        v, left = mp.mpf(0), left - t
    return x, v, a


def random_case(chance: random.Random) -> tuple[Body, Controller, list[float], float]:
    """A body whose torque lags, its wall, a state, and the reading; many stop, or are let go, in the interval."""
    while True:
        beta = 10.0 ** chance.uniform(-6.0, 0.5)
        alpha = 2.0 * beta**0.5 * 10.0 ** chance.uniform(-2.0, 0.8)
        friction, lag = 10.0 ** chance.uniform(-3.0, 0.5), 10.0 ** chance.uniform(-1.5, 2.5)
        kappa = 10.0 ** chance.uniform(-3.0, 0.5)
        x = -chance.choice([0.0, 1.0, 30.0, 1e3]) * chance.random() + 0.5
        level = min(0.0, x // 1.0)
        push = max(0.0, -kappa * level - beta * x + chance.gauss(0.0, 2.0 * friction))
        body, wall = body_of(alpha, beta, friction, push, lag), wall_of(kappa, 0.0)
        if can_rub(body, wall):
            v = chance.choice([0.0, friction, 0.1 * friction, 1.0]) * chance.gauss(0.0, 1.0)
            return body, wall, [x, v, -kappa * level * chance.choice([0.0, 1.0, chance.random()])], level


@pytest.mark.parametrize("count", [6, pytest.param(120, marks=pytest.mark.long)])
def test_a_state_is_moved_to_within_the_bound(count: int) -> None:
    """A set of one state: all that is left is rounding, of its torque, too."""
    chance, worst, stopped = random.Random(count), mp.mpf(0), 0
    room = make_piece_room(zeros, 3, 0, lattice=8, deep=64)
    size, first = piece_size(3, 0), STATE + 3
    with mp.workdps(DIGITS):
        for _ in range(count):
            body, wall, z, level = random_case(chance)
            drift, work = friction_drift(body, wall), make_friction_room(zeros, list, 0, body, wall)
            room.corners[:2] = [0.0, 0.0]
            waiting = move_piece(room, work, 0, centre_of(z, [], level=level), 1, cell_of(body, drift, wall))
            x, v, a = exact((mp.mpf(z[0]), mp.mpf(z[1]), mp.mpf(z[2])), mp.mpf(-wall.kappa * level), body)
            stopped += v == 0
            for k in range(waiting):
                one = room.stack[k * size : (k + 1) * size]
                places = range(first, first + 2 * int(one[COUNT]), 2)
                corners = [(one[STATE] + one[at], one[STATE + 1] + one[at + 1]) for at in places]
                error = apart(x, v, corners, body.beta) + abs(mp.mpf(one[STATE + 2]) - a) / mp.mpf(body.lag)
                assert error <= one[ERROR]
                worst = max(worst, error / one[ERROR])
    assert stopped > count / 20
    assert 1.0 / 1000.0 < worst < 1.0 / 100.0  # as without a lag, 256 units are many
