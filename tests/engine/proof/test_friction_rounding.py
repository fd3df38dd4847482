"""What floating point makes of an interval with friction, against 60 digits: never more than `friction_drift` says."""

import random
from math import cos, pi, sin, sqrt
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller, command
from hknob_cli.engine.general.sets.friction_piece import move_piece
from hknob_cli.engine.general.sets.friction_room import can_rub, friction_drift, make_friction_room
from hknob_cli.engine.general.sets.piece import COUNT, ERROR, STATE, piece_size
from hknob_cli.engine.general.sets.room import PieceRoom, make_piece_room
from hknob_cli.scene.general_knob import make_body
from hknob_cli.specs.plan import Bias, Hand, Knob, Scene, Wall

from .friction_work import cell_of, centre_of
from .orbits import DIGITS, plant

Number = Any  # of mpmath
Case = tuple[Body, Controller, int, float, float, float, list[float]]
ROOMS: dict[int, PieceRoom] = {}


def zeros(count: int) -> list[float]:
    return [0.0] * count


def body_of(alpha: float, beta: float, friction: float, push: float, split: float) -> Body:
    """A body with these numbers: unit inertia, period and quantum."""
    scene = Scene(
        knob=Knob(inertia=1.0, damping=alpha, coulomb_torque=friction),
        wall=Wall(stiffness=1.0),
        hand=Hand(stiffness=beta),
        bias=Bias(torque=push),
        encoder=None,
        actuator=None,
    )
    return make_body(scene, period=1.0, quantum=1.0, shift=0.0, split=split)[0]


def wall_of(kappa: float, split: float) -> Controller:
    return Controller(kappa, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, float("inf"), split)


def until_zero(v: Number, y: Number, body: Body) -> Number:
    """When the velocity next vanishes, e^-at (v cos wt + (y - a v) sin wt / w) = 0; infinity if it never does."""
    a = mp.mpf(body.alpha) / 2
    square, rate = mp.mpf(body.beta) - a * a, y - a * v
    if square > 0:
        w = mp.sqrt(square)
        t = mp.atan2(-v * w, rate) / w
        while t <= mp.mpf(10) ** -50:
            t += mp.pi / w
        return t
    r = mp.sqrt(-square)
    if v == 0 or v * rate >= 0 or abs(v) * r >= abs(rate):
        return mp.inf
    return mp.atanh(-v * r / rate) / r


def exact(x: Number, v: Number, u: float, span: Number, body: Body) -> tuple[Number, Number]:
    """The motion over ``span``, slide by slide; friction holds, lets go, or turns round."""
    free, friction = mp.mpf(u) + mp.mpf(body.drive), mp.mpf(body.friction)
    while span > 0:
        pull = free - mp.mpf(body.beta) * x
        way = mp.sign(v) if v != 0 else (mp.sign(pull) if abs(pull) > friction else 0)
        if way == 0:
            break
        y = pull - way * friction
        t = until_zero(v, y, body)
        ends = t < span
        t = min(t, span)
        _, s, g, f = plant(body, t)
        x, v = x + s * v + g * y, f * v + s * y
        if ends:
            assert abs(v) < mp.mpf(10) ** -45 * (1 + abs(y))
            v = mp.mpf(0)
        span -= t
    return x, v


def random_case(chance: random.Random) -> Case:
    """A body, its wall, and a set: many stop within the interval, some deep in a wall whose torque the push cancels."""
    while True:
        beta = 10.0 ** chance.uniform(-7.0, 1.0)
        alpha = 2.0 * beta**0.5 * 10.0 ** chance.uniform(-2.0, 1.0)
        friction, size = 10.0 ** chance.uniform(-4.0, 1.0), 10.0 ** chance.uniform(-4.0, 1.0)
        split = chance.choice([0.0, chance.random()])
        kappa = 10.0 ** chance.uniform(-4.0, 0.5)
        x = -chance.choice([0.0, 1.0, 30.0, 1e4]) * chance.random() + 0.5
        level = min(0.0, x // 1.0)
        push = max(0.0, -kappa * level - beta * x + chance.gauss(0.0, 2.0 * friction))
        body, wall = body_of(alpha, beta, friction, push, split), wall_of(kappa, split)
        if can_rub(body, wall):
            v = chance.choice([0.0, friction, 0.1 * friction, size]) * chance.gauss(0.0, 1.0)
            return body, wall, 2 if split > 0.0 else 0, x, v, level, [0.0, -kappa * level]


def moved(case: Case, corners: list[float]) -> tuple[list[list[tuple[float, float]]], float]:
    """Corners of the sets that a set becomes in one interval, none if they are too many; and the bound on roundings."""
    body, wall, delay, x, v, level, line = case
    drift = friction_drift(body, wall)
    if delay not in ROOMS:
        ROOMS[delay] = make_piece_room(zeros, 2, delay, lattice=8, deep=512)
    room, work = ROOMS[delay], make_friction_room(zeros, list, delay, body, wall)
    count, size = len(corners) // 2, piece_size(2, delay)
    room.corners[: len(corners)] = corners
    told = centre_of([x, v], line[:delay], level=level)
    waiting = move_piece(room, work, 0, told, count, cell_of(body, drift, wall))
    found = []
    for k in range(waiting):
        one = room.stack[k * size : (k + 1) * size]
        base = STATE + 2 + delay
        places = range(base, base + 2 * int(one[COUNT]), 2)
        found.append([(one[STATE] + one[at], one[STATE + 1] + one[at + 1]) for at in places])
    return found, max((room.stack[k * size + ERROR] for k in range(waiting)), default=0.0)


def true_end(case: Case, dx: float, dv: float) -> tuple[Number, Number]:
    body, wall, delay, x, v, level, line = case
    u = command(level, 0.0, wall)
    older, newer = (line[0], line[1]) if delay else (u, u)
    state = mp.mpf(x) + mp.mpf(dx), mp.mpf(v) + mp.mpf(dv)
    if wall.split > 0.0:
        state = exact(*state, older, mp.mpf(wall.split), body)
    return exact(*state, newer, 1 - mp.mpf(wall.split), body)


def apart(x: Number, v: Number, corners: list[tuple[float, float]], beta: float) -> Number:
    """Distance of a state from a convex polygon, in the norm of the proofs."""
    root = mp.sqrt(mp.mpf(beta))
    c = [((mp.mpf(a) - x) * root, mp.mpf(b) - v) for a, b in corners]
    least, turned = mp.inf, mp.mpf(0)  # seen from the state, by the way around the corners
    for (ax, av), (bx, bv) in zip(c, [*c[1:], c[0]], strict=True):
        ex, ev = bx - ax, bv - av
        length = ex * ex + ev * ev
        t = max(mp.mpf(0), min(mp.mpf(1), -(ax * ex + av * ev) / length)) if length > 0 else mp.mpf(0)
        least = min(least, mp.hypot(ax + t * ex, av + t * ev))
        turned += mp.atan2(ax * bv - av * bx, ax * bx + av * bv)
    return mp.mpf(0) if abs(turned) > 6 else least


def test_a_state_is_moved_to_within_the_bound() -> None:
    """A set of one state: all that is left is rounding. A third of the states stop within the interval."""
    chance, worst, stopped = random.Random(1), mp.mpf(0), 0
    with mp.workdps(DIGITS):
        for _ in range(1500):
            case = random_case(chance)
            found, bound = moved(case, [0.0, 0.0])
            x, v = true_end(case, 0.0, 0.0)
            stopped += v == 0
            error = max(apart(x, v, one, case[0].beta) for one in found)
            assert error <= bound
            worst = max(worst, error / bound)
    assert stopped > 300
    assert 1.0 / 500.0 < worst < 1.0 / 250.0  # 256 units are many


@pytest.mark.long
def test_every_state_of_a_set_is_in_what_becomes_of_it_to_within_the_bound() -> None:
    """Corners and states between them, of sets that slide, stop, turn round and are cut."""
    chance, worst, cut = random.Random(2), mp.mpf(0), 0
    with mp.workdps(DIGITS):
        for _ in range(400):
            case = random_case(chance)
            beta, size = case[0].beta, 10.0 ** chance.uniform(-9.0, 0.5)
            turns = sorted(chance.uniform(0.0, 2.0 * pi) for _ in range(5))
            corners = [(size * cos(t), size * sqrt(beta) * sin(t)) for t in turns]
            found, bound = moved(case, [value for one in corners for value in one])
            cut += len(found) > 1
            if not found:
                continue
            shares = [chance.random() for _ in corners]
            inner = tuple(
                sum(share * one[j] for share, one in zip(shares, corners, strict=True)) / sum(shares) for j in (0, 1)
            )
            for dx, dv in (*corners, inner):
                x, v = true_end(case, dx, dv)
                error = min(apart(x, v, one, beta) for one in found)
                assert error <= bound
                worst = max(worst, error / bound)
    assert cut > 50
    assert 1.0 / 300.0 < worst < 1.0 / 150.0
