"""One cell of a sweep in count units, with every coefficient enclosed, and the proof of one of its orbits.

x is the angle in counts, v its speed in counts a sample, time is in samples: x'' = -alpha v - beta x + u. There
alpha = b T / J and beta = k T^2 / J. After a sample that reads level l <= 0, u = -kappa l - gamma, with
kappa = K T^2 / J and gamma = g T^2 / (J dtheta). Numbers are mpmath intervals of 40 digits (`iv`), made from the digits
that the spec prints; pi is enclosed. What the compiled search needs is rounded outward to floats. Nothing of the
package is imported.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

DIGITS = 40
TERMS = 60  # of the exponential series
DEEPEST = 2000  # counts inside the wall, for which torques are kept

iv = mpmath.ctx_iv.MPIntervalContext()  # a context of its own
iv.dps = DIGITS

Interval = Any  # an mpmath interval


class NotProven(ArithmeticError):
    """A step of the argument does not hold, or not within the roundings."""


@dataclass(frozen=True)
class Orbit:
    """A proven periodic orbit: its levels, and each of its samples within ``error`` of (x, v), in the norm."""

    levels: tuple[int, ...]
    x: NDArray
    v: NDArray
    error: float
    margin: tuple[float, float]  # least distance of a sample to an edge that matters, enclosed [counts]
    nearest: tuple[float, float]  # to any edge: outside the wall none matters, but results count them

    @property
    def period(self) -> int:
        """Samples."""
        return len(self.levels)


class Cell:
    """The cell of a scene as a spec writes it, at ``rate`` [Hz] and ``counts`` a revolution."""

    def __init__(self, scene: Mapping[str, Any], rate: float, counts: int) -> None:
        def printed(number: float) -> Interval:
            return iv.mpf(repr(float(number)))

        hand, wall = scene["hand"], printed(scene["wall"]["stiffness"])
        inertia = printed(scene["knob"]["inertia"]) + printed(hand["inertia"])
        period, quantum = 1 / iv.mpf(rate), 2 * iv.pi / counts  # the rate is the float that the table has
        half = scene["bias"].get("half_quantum", False)
        push = wall * quantum / 2 if half else printed(scene["bias"]["torque"])
        self.alpha = printed(hand["damping"]) * period / inertia
        self.beta = printed(hand["stiffness"]) * period**2 / inertia
        self.kappa = wall * period**2 / inertia
        self.gamma = push * period**2 / (inertia * quantum)
        self.period, self.quantum = period, quantum
        self.inverse_beta = above(1 / self.beta)
        self.check_norm()

    def flow(self, time: Interval) -> tuple[list[list[Interval]], list[Interval]]:
        """exp(A t), and what a torque u = 1 that lasts from 0 to t adds; A = [[0, 1], [-beta, -alpha]].

        Series of exp of the matrix that has u as its third, constant state. Of what is left out no entry is more than
        the first term left out by the row-sum norm, twice, since that falls by half from term to term.
        """
        a = [[iv.mpf(0), time, iv.mpf(0)], [-self.beta * time, -self.alpha * time, time], [iv.mpf(0)] * 3]
        total = [[iv.mpf(int(i == j)) for j in range(3)] for i in range(3)]
        term = [row[:] for row in total]
        for n in range(1, TERMS + 1):
            term = [[sum(term[i][m] * a[m][j] for m in range(3)) / n for j in range(3)] for i in range(3)]
            total = [[total[i][j] + term[i][j] for j in range(3)] for i in range(3)]
        norm = max((sum(abs(one) for one in row) for row in a), key=above)
        if not above(norm) < TERMS / 2:
            raise NotProven("the series of the exponential is too short")
        rest = above(2 * norm ** (TERMS + 1) / iv.mpf(math.factorial(TERMS + 1)))
        total = [[one + iv.mpf([-rest, rest]) for one in row] for row in total]
        return [row[:2] for row in total[:2]], [total[0][2], total[1][2]]

    @cached_property
    def hold(self) -> tuple[list[list[Interval]], list[Interval]]:
        """Phi and Gamma of one sample."""
        return self.flow(iv.mpf(1))

    def torque(self, level: int) -> Interval:
        """u [counts per sample^2] after a sample that reads ``level``."""
        return -self.kappa * min(level, 0) - self.gamma

    def check_norm(self) -> None:
        """P - Phi' P Phi is positive definite for P = diag(1, 1 / beta): free motion shrinks |s|^2 = x^2 + v^2 / beta.

        Raises:
            NotProven: It is not, within the roundings.
        """
        (a, b), (c, d) = self.hold[0]
        q = 1 / self.beta
        first, mixed, last = 1 - a * a - q * c * c, -(a * b + q * c * d), q - b * b - q * d * d
        if not (below(first) > 0 and below(first * last - mixed * mixed) > 0):
            raise NotProven("free motion is not proven to shrink")

    def prove(self, levels: tuple[int, ...]) -> Orbit:
        """The orbit that reads ``levels`` over and over.

        The map of one period is affine with the linear part Phi^n, whose fixed point is enclosed by Cramer's rule.
        Every sample of it must read its level for certain. Then it is an orbit. States nearer to one of its samples
        than the margin read the same level, are moved by Phi relative to it, and so come to it: it is asymptotically
        stable.

        Raises:
            NotProven: A sample does not read its level, or not for certain.
        """
        (p11, p12), (p21, p22) = self.hold[0]
        g1, g2 = self.hold[1]
        torques = [self.torque(level) for level in levels]

        def step(x: Interval, v: Interval, u: Interval) -> tuple[Interval, Interval]:
            return p11 * x + p12 * v + g1 * u, p21 * x + p22 * v + g2 * u

        ends = [(iv.mpf(0), iv.mpf(0)), (iv.mpf(1), iv.mpf(0)), (iv.mpf(0), iv.mpf(1))]
        for u in torques:
            ends = [step(*ends[0], u), step(*ends[1], iv.mpf(0)), step(*ends[2], iv.mpf(0))]
        (c1, c2), (m11, m21), (m12, m22) = ends
        determinant = (1 - m11) * (1 - m22) - m12 * m21
        x, v = ((1 - m22) * c1 + m12 * c2) / determinant, ((1 - m11) * c2 + m21 * c1) / determinant
        xs, vs, error, margin, nearest = [], [], 0.0, (math.inf, math.inf), (math.inf, math.inf)
        for level, u in zip(levels, torques, strict=True):
            gaps = [x - level] if level == 0 else [x - level, level + 1 - x]
            for gap in gaps:
                if not below(gap) > 0:
                    raise NotProven(f"sample {len(xs)} of {len(levels)} reads another level than {level}")
                margin = min(margin[0], below(gap)), min(margin[1], above(gap))
            whole = math.floor(float(x.mid))
            for gap in (x - whole, whole + 1 - x):
                nearest = min(nearest[0], below(gap)), min(nearest[1], above(gap))
            xs.append(float(x.mid))
            vs.append(float(v.mid))
            distance = iv.sqrt((x - iv.mpf(xs[-1])) ** 2 + (v - iv.mpf(vs[-1])) ** 2 / self.beta)
            error = max(error, above(distance))
            x, v = step(x, v, u)
        return Orbit(levels, np.array(xs), np.array(vs), error, margin, nearest)

    def powers(self, most: int) -> NDArray:
        """Phi^m for m = 0 ... ``most``, shape (most + 1, 2, 2, 2): entries enclosed by floats."""
        phi, power = self.hold[0], [[iv.mpf(1), iv.mpf(0)], [iv.mpf(0), iv.mpf(1)]]
        table = np.empty((most + 1, 2, 2, 2))
        for m in range(most + 1):
            table[m] = [[floats(one) for one in row] for row in power]
            power = [[sum(phi[i][n] * power[n][j] for n in range(2)) for j in range(2)] for i in range(2)]
        return table

    def shrinking(self, most: int) -> NDArray:
        """At least the norm of Phi^m, m = 0 ... ``most``: the root of the sum of squares of its entries, scaled."""
        phi, power, table = self.hold[0], [[iv.mpf(1), iv.mpf(0)], [iv.mpf(0), iv.mpf(1)]], []
        for _ in range(most + 1):
            (a, b), (c, d) = power
            table.append(min(1.0, above(iv.sqrt(a**2 + b**2 * self.beta + c**2 / self.beta + d**2))))
            power = [[sum(phi[i][n] * power[n][j] for n in range(2)) for j in range(2)] for i in range(2)]
        return np.array(table)

    def drives(self) -> NDArray:
        """What the torque of level -m adds in a sample, m = 0 ... DEEPEST, shape (m, 2, 2), enclosed by floats."""
        g1, g2 = self.hold[1]
        torques = [self.torque(-m) for m in range(DEEPEST + 1)]
        return np.array([[floats(g1 * u), floats(g2 * u)] for u in torques])


def below(number: Interval) -> float:
    """A float that is at most the interval's least number."""
    return math.nextafter(float(mpmath.mpf(number.a._mpi_[0])), -math.inf)


def above(number: Interval) -> float:
    """A float that is at least the interval's largest number."""
    return math.nextafter(float(mpmath.mpf(number.b._mpi_[1])), math.inf)


def floats(number: Interval) -> tuple[float, float]:
    """The interval, rounded outward."""
    return below(number), above(number)
