"""Orbits of random loops, and the same motions at 60 digits, for tests of proofs."""

import random
from collections.abc import Iterator
from math import sqrt
from typing import Any, NamedTuple

import mpmath as mp

from hknob_cli.engine.follow import CYCLE_CONTINUUM, CYCLE_PROVEN, follow
from hknob_cli.engine.loop import Loop, level_of, make_loop

Number = Any  # of mpmath
DIGITS = 60


class Orbit(NamedTuple):
    """An orbit of ``n`` samples that a trial has reached, and the delay line there."""

    loop: Loop
    x: float
    v: float
    n: int
    ring: list[float]
    head: int


def orbits(seed: int, count: int, delay: int = 0, held: bool = True) -> Iterator[Orbit]:
    """Orbits of random loops: soft and stiff, pushed a count or a thousand deep; ``held``: with hand stiffness."""
    chance = random.Random(seed)
    while count:
        beta = 10.0 ** chance.uniform(-4.0, 0.3)
        alpha, kappa = 2.0 * sqrt(beta) * 10.0 ** chance.uniform(-1.0, 0.3), beta * 10.0 ** chance.uniform(-0.5, 3.0)
        depth = chance.choice([0.5, 1.0, 2.3, 1000.0]) * chance.uniform(0.8, 1.2)
        sense, offset, split = chance.choice([-1.0, 1.0]), chance.choice([0.0, 0.3]), chance.choice([0.0, 0.4])
        gamma = kappa * depth
        if not held:
            beta, gamma = 0.0, 0.5 * kappa
        if kappa > 3.0 or (delay == 0 and split > 0.0):
            continue
        loop = make_loop(alpha, beta, kappa, gamma, sense, offset if held else 0.0, split)
        ring = [level_of(-depth, sense)] * delay
        start = -depth * kappa / (kappa + beta) + chance.uniform(-2.0, 2.0)
        fate, n, x, v, head, _ = follow(start, 0.0, ring, 0, 20_000, 1e9, loop)
        if fate == (CYCLE_PROVEN if held else CYCLE_CONTINUUM) and n <= 400:
            count -= 1
            yield Orbit(loop, x, v, n, ring, head)


def plant(loop: Loop, t: float) -> tuple[Number, Number, Number, Number]:
    """Response of the position to itself, a velocity and a torque over ``t`` samples; of the velocity to itself."""
    a, beta, t = mp.mpf(loop.alpha) / 2, mp.mpf(loop.beta), mp.mpf(t)
    if beta == 0:
        f = mp.exp(-2 * a * t)
        s = (1 - f) / (2 * a)
        return mp.mpf(1), s, (t - s) / (2 * a), f
    w = mp.sqrt(mp.mpc(beta - a * a))
    decay = mp.exp(-a * t)
    s, c = (decay * mp.sin(w * t) / w).real, (decay * mp.cos(w * t)).real
    return c + a * s, s, (1 - c - a * s) / beta, c - a * s


def drive(level: float, loop: Loop) -> Number:
    """Acceleration by wall and bias, without a rounding."""
    wall = -mp.mpf(loop.kappa) * (mp.mpf(level) + mp.mpf(loop.offset)) if level < 0.0 else mp.mpf(0)
    return wall - mp.mpf(loop.gamma)


def move(x: Number, v: Number, older: float, newer: float, loop: Loop) -> tuple[Number, Number]:
    """One sample under these levels."""
    beta = mp.mpf(loop.beta)
    parts = [(loop.split, older), (1.0 - loop.split, newer)] if loop.split > 0.0 else [(1.0, newer)]
    for t, level in parts:
        p, s, g, f = plant(loop, t)
        push = drive(level, loop)
        x, v = p * x + s * v + g * push, -beta * s * x + f * v + s * push
    return x, v
