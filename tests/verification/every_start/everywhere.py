"""All starts in ranges of angle and velocity, proven with outward rounding to end in orbits that are proven, too.

The argument is that of docs/explanation/every_start.md, programmed again without the package, and in intervals: a
rectangle of states is followed from sample to sample, cut where it meets a count edge (`follow.py`, `polygon.py`),
until each piece is captured by a proven orbit (`cell.Cell.prove`). An orbit that is not known yet is guessed by plain
simulation, and counts only once it is proven.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tests.verification.every_start.cell import Cell, NotProven, Orbit, iv
from tests.verification.every_start.follow import ALL, STOPPED, follow
from tests.verification.every_start.polygon import BLUR, FIRST, HIGHEST, LOWEST, WIDTH, V, X, rectangle

WAITING = 8_000  # pieces
POWERS = 1024  # samples between two looks at a polygon, at most


@dataclass
class Proof:
    """What is proven of a cell: its orbits, and of how many pieces; nothing is left if ``complete``."""

    cell: Cell
    orbits: list[Orbit] = field(default_factory=list)
    captured: list[int] = field(default_factory=list)
    cuts: int = 0
    samples: int = 0
    complete: bool = False

    def table(self) -> NDArray:
        """For each orbit the samples at which it goes deeper (all, where it never does): (x, v, error, margin,
        orbit)."""
        rows = [
            (one.x[i], one.v[i], one.error, one.margin[0], float(number))
            for number, one in enumerate(self.orbits)
            for i in range(one.period)
            if one.levels[i] < one.levels[i - 1] or len(set(one.levels)) == 1
        ]
        return np.array(rows).reshape(-1, 5)

    def learn(self, x: float, v: float) -> bool:
        """Prove the orbit that a motion from (x, v) settles to; whether it is new."""
        levels = settled_levels(self.cell, x, v)
        if turned(levels) in [turned(one.levels) for one in self.orbits]:
            return False
        self.orbits.append(self.cell.prove(levels))
        self.captured.append(0)
        return True


def prove_box(cell: Cell, angle: tuple[float, float], velocity: tuple[float, float], most: int = 10**9) -> Proof:
    """Every start in the ranges [rad, rad/s], at a sample.

    Raises:
        NotProven: Something in the argument does not hold within the roundings.
    """
    proof = Proof(cell)
    stack, count = np.zeros((WAITING, WIDTH)), 1
    low_x, high_x = (iv.mpf(one) / cell.quantum for one in angle)
    low_v, high_v = (iv.mpf(one) * cell.period / cell.quantum for one in velocity)
    rectangle(stack[0], *(float(end) for one in ((low_x, high_x), (low_v, high_v)) for end in outer(*one)))
    stack[0, LOWEST], stack[0, HIGHEST] = -1e9, 0.0
    powers, drives = cell.powers(POWERS), cell.drives()
    first = patience = 200 + int(30.0 * slowest(cell))
    while True:
        captured = np.zeros(len(proof.orbits) + 1, dtype=np.int64)
        why, count, cuts, samples = follow(
            stack, count, powers, drives, cell.inverse_beta, proof.table(), captured, patience, most
        )
        proof.captured = [one + int(more) for one, more in zip(proof.captured, captured, strict=False)]
        proof.cuts += cuts
        proof.samples += samples
        if why == ALL:
            proof.complete = True
            return proof
        if why == STOPPED:
            return proof
        if proof.learn(stack[count - 1, X], stack[count - 1, V]):
            patience = first
        elif patience > 1000 * first:
            raise NotProven(
                f"a piece {stack[count - 1, :FIRST]} stays near the edge of a margin: {stack[count - 1, BLUR]}"
            )
        else:
            patience *= 4


def outer(low: object, high: object) -> tuple[float, float]:
    """Floats around both."""
    from tests.verification.every_start.cell import above, below

    return below(low), above(high)


def slowest(cell: Cell) -> float:
    """The slowest time constant of the free motion in samples, about; it only says how long to wait."""
    alpha, beta = float(cell.alpha.mid), float(cell.beta.mid)
    root = alpha * alpha / 4.0 - beta
    return 1.0 / (alpha / 2.0 - math.sqrt(max(root, 0.0)))


def settled_levels(cell: Cell, x: float, v: float) -> tuple[int, ...]:
    """Levels of one period of the motion that a plain simulation from (x, v) settles to: a guess, to be proven."""
    (phi, gamma), torques = cell.hold, {}
    (a, b), (c, d) = ((float(one.mid) for one in row) for row in phi)
    g, h, gain, push = (float(one.mid) for one in (*gamma, cell.kappa, cell.gamma))
    seen: list[tuple[float, float, int]] = []
    settle = 200 + int(60.0 * slowest(cell))
    for n in range(settle + 100_000):
        level = min(math.floor(x), 0)
        if n >= settle:
            for back in range(len(seen) - 1, -1, -1) if n % 16 == 0 else ():
                if abs(seen[back][0] - x) < 1e-10 and abs(seen[back][1] - v) < 1e-10:
                    return primitive(tuple(one[2] for one in seen[back:]))
            seen.append((x, v, level))
        u = torques.setdefault(level, -gain * level - push)
        x, v = a * x + b * v + g * u, c * x + d * v + h * u
    raise NotProven("a motion that does not repeat")


def primitive(levels: tuple[int, ...]) -> tuple[int, ...]:
    """The shortest part that the levels are a repetition of."""
    n = len(levels)
    return next(levels[:d] for d in range(1, n + 1) if n % d == 0 and levels[:d] * (n // d) == levels)


def turned(levels: tuple[int, ...]) -> tuple[int, ...]:
    """One period of levels, so that every turn of it is the same."""
    return min(levels[i:] + levels[:i] for i in range(len(levels)))
