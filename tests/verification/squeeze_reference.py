"""A grip that follows its push, at 60 digits: every rest of wall and hand, by roots in closed form, none by bisection.

It reads the printed tables by itself, and shares no code with the package. A grip F holds the torque F / p. Between two
rows of the table the hand has the stiffness h + s F; in a piece of the wall its torque is T = a d + b d^2 at a depth d.
Behind a gear of stiffness c the motor is at the depth d, and the knob at d + e T, e = 1 / c: that far the torque T of
the mesh has turned it further. In each pair of pieces the rests are the roots d of T + (h + s p T) (d + e T) = g, a
polynomial of at most the fourth degree. What it finds is put into the balance again.
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath

TABLES = Path(__file__).parents[2] / "data" / "printed"
APPARATUS = {1: "19.8e-7", 2: "19.8e-7", 3: "32.7e-7", 4: "32.7e-7", 5: "32.7e-7"}  # kg m^2, Table 10
KEYS = ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad")
DIGITS, SAME = 60, mpmath.mpf("1e-45")

Number = Any  # of mpmath, which has no types
Row = tuple[Number, ...]  # grip, inertia, damping, stiffness


def rows_of(table: int) -> list[Row]:
    """The rows of a table, by their grip, without the inertia of the apparatus."""
    with (TABLES / f"table_{table:02d}.csv").open() as file:
        printed = list(csv.DictReader(file))
    with mpmath.workdps(DIGITS):
        found = []
        for row in printed:
            inertia, damping, stiffness = (mpmath.mpf(row[key]) for key in KEYS)
            found.append((mpmath.mpf(row["grip_n"]), inertia - mpmath.mpf(APPARATUS[table]), damping, stiffness))
    return found


@dataclass(frozen=True)
class Push:
    """A push g (N·m) on a wall by a hand of a table, whose least grip is a row's.

    ``per_torque``: p, N per N·m; ``surface`` and ``depth`` (rad) of a wall that stiffens; ``most``: torque limit;
    ``mesh``: stiffness (N·m/rad) of a gear, None: rigid.
    """

    table: int
    least: int
    torque: float
    friction: float
    radius: float
    margin: float
    stiffness: float
    surface: float = 1.0
    depth: float = 1.0
    most: float | None = None
    mesh: float | None = None

    @property
    def twist(self) -> Number:
        """Turn of the knob against the motor, of a torque."""
        return 1 / mpmath.mpf(self.mesh) if self.mesh is not None else mpmath.mpf(0)

    @property
    def per_torque(self) -> Number:
        """Grip for a torque."""
        return mpmath.mpf(self.margin) / (2 * mpmath.mpf(self.friction) * mpmath.mpf(self.radius))


@dataclass(frozen=True)
class Rest:
    """Depth (rad), torque of the wall (N·m), grip (N), and the hand's inertia, damping and stiffness there.

    The depth is that of the motor.
    """

    depth: Number
    torque: Number
    grip: Number
    hand: tuple[Number, ...]


def rests(push: Push) -> list[Rest]:
    """Every rest inside the wall, found once in each pair of pieces, and twice where it is on the end of both."""
    with mpmath.workdps(DIGITS):
        rows, p, g, e = rows_of(push.table), push.per_torque, mpmath.mpf(push.torque), push.twist
        found: list[Rest] = []
        for a, b, shallow, deep in walls(push):
            for h, s, light, firm in _hands(rows, push.least):
                torques, stiffnesses = [mpmath.mpf(0), a, b], [h, s * p * a, s * p * b]
                terms = _product(stiffnesses, [mpmath.mpf(0), 1 + e * a, e * b])
                for power, coefficient in enumerate([-g, *torques[1:]]):
                    terms[power] += coefficient
                for d in _positive(terms):
                    torque = a * d + b * d**2
                    if _within(d, shallow, deep) and _within(p * torque, light, firm) and _allowed(push, torque):
                        found.append(_rest(rows, push, d, torque))
        if push.most is not None:
            most = mpmath.mpf(push.most)
            stiffness = at_grip(rows, max(p * most, rows[push.least][0]))[2]
            d = (g - most) / stiffness - e * most
            if d > 0 and any(a * d + b * d**2 >= most for a, b, low, high in walls(push) if low <= d <= high):
                found.append(_rest(rows, push, d, most))
        return found


def walls(push: Push) -> Iterator[tuple[Number, Number, Number, Number]]:
    """Pieces of the wall: T = a d + b d^2 from one depth to another."""
    k, surface, depth = (mpmath.mpf(value) for value in (push.stiffness, push.surface, push.depth))
    if push.surface == 1.0:
        yield k, mpmath.mpf(0), mpmath.mpf(0), mpmath.inf
        return
    yield k * surface, k * (1 - surface) / depth, mpmath.mpf(0), depth
    yield k, mpmath.mpf(0), depth, mpmath.inf


def _hands(rows: list[Row], least: int) -> Iterator[tuple[Number, Number, Number, Number]]:
    """Pieces of the table: stiffness h + s F for what the torque asks from one grip force to another."""
    yield rows[least][3], mpmath.mpf(0), mpmath.mpf(0), rows[least][0]
    for one, other in pairwise(rows[least:]):
        s = (other[3] - one[3]) / (other[0] - one[0])
        yield one[3] - s * one[0], s, one[0], other[0]
    yield rows[-1][3], mpmath.mpf(0), rows[-1][0], mpmath.inf


def _product(one: list[Number], other: list[Number]) -> list[Number]:
    """Terms of the product of two polynomials, the lowest first."""
    found = [mpmath.mpf(0)] * (len(one) + len(other) - 1)
    for i, left in enumerate(one):
        for j, right in enumerate(other):
            found[i + j] += left * right
    return found


def _positive(terms: list[Number]) -> list[Number]:
    """Positive real roots of a polynomial of at most the fourth degree, its lowest term first, in closed form."""
    with mpmath.workdps(16 * DIGITS):  # the highest term may be tiny
        roots = _roots(terms)
        return [x.real for x in roots if x.real > 0 and abs(x.imag) < SAME * abs(x)]


def _roots(terms: list[Number]) -> list[Number]:
    """All its roots, real or not."""
    while not terms[-1]:
        terms = terms[:-1]
    lower = [term / terms[-1] for term in terms[:-1]]
    return [_of_line, _of_square, _of_cubic, _of_quartic][len(lower) - 1](*lower)


def _of_line(a: Number) -> list[Number]:
    """The root of x + a."""
    return [mpmath.mpc(-a)]


def _of_square(b: Number, a: Number) -> list[Number]:
    """Roots of x^2 + a x + b."""
    one = mpmath.mpc(a * a / 4 - b) ** 0.5
    return [-a / 2 + one, -a / 2 - one]


def _of_cubic(c: Number, b: Number, a: Number) -> list[Number]:
    """Roots of x^3 + a x^2 + b x + c, by Cardano."""
    shift, p, q = a / 3, b - a * a / 3, 2 * a**3 / 27 - a * b / 3 + c
    one = mpmath.mpc(q * q / 4 + p**3 / 27) ** 0.5
    cube = max(-q / 2 + one, -q / 2 - one, key=abs) ** (mpmath.mpf(1) / 3)
    turns = [cube * mpmath.expjpi(mpmath.mpf(2 * k) / 3) for k in range(3)]
    return [turn - p / (3 * turn) - shift for turn in turns]


def _of_quartic(d: Number, c: Number, b: Number, a: Number) -> list[Number]:
    """Roots of x^4 + a x^3 + b x^2 + c x + d, by Ferrari."""
    p, q = b - 3 * a * a / 8, c - a * b / 2 + a**3 / 8
    r = d - a * c / 4 + a * a * b / 16 - 3 * a**4 / 256
    m = max(_of_cubic(-q * q / 8, p * p / 4 - r, p), key=abs)
    side, one = (2 * m) ** 0.5, q / (8 * m) ** 0.5
    halves = [*_of_square(p / 2 + m + one, -side), *_of_square(p / 2 + m - one, side)]
    return [half - a / 4 for half in halves]


def _within(value: Number, low: Number, high: Number) -> bool:
    return bool(low * (1 - SAME) <= value <= high * (1 + SAME))


def _allowed(push: Push, torque: Number) -> bool:
    return push.most is None or bool(torque <= mpmath.mpf(push.most))


def _rest(rows: list[Row], push: Push, depth: Number, torque: Number) -> Rest:
    grip = max(push.per_torque * torque, rows[push.least][0])
    hand = at_grip(rows, grip)
    missing = torque + hand[2] * (depth + push.twist * torque) - mpmath.mpf(push.torque)
    assert abs(missing) <= SAME * push.torque, (push, depth, missing)
    return Rest(depth, torque, grip, hand)


def at_grip(rows: list[Row], grip: Number) -> tuple[Number, ...]:
    """Inertia, damping and stiffness at a grip force: on the line between two rows, and as the end's beyond."""
    if grip <= rows[0][0]:
        return rows[0][1:]
    for one, other in pairwise(rows):
        if grip <= other[0]:
            share = (grip - one[0]) / (other[0] - one[0])
            return tuple(a + share * (b - a) for a, b in zip(one[1:], other[1:], strict=True))
    return rows[-1][1:]
