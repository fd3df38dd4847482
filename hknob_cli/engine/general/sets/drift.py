"""How the difference of two motions moves, and how far roundings move a computed one: bounds, with exact numbers.

Two motions that get the same readings get the same commands, and their difference goes by Phi = exp(A) from sample to
sample. Powers of Phi are computed in whole numbers of `BITS` bits after the point and rounded once; what floating point
makes of the plant over a hold is compared with them, entry by entry. So every bound is told from the numbers of the
cell, however stiff, and not from a rule. Not compiled.
"""

from fractions import Fraction
from math import inf
from typing import Any, NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import CONSTANT, ENTRY, FIRST, HALVES, HALVINGS, RATES, SECOND, Body, norm
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import MATRIX, PIECE, SPAN, F, G, Law, S
from hknob_cli.engine.general.sets.readings import deepest_level

BITS = 320  # after the point
POINT = 1 << BITS
TERMS = 48  # of the exponential's series, of a matrix below 1/8: the rest is below 2^-340
POWERS = 24  # Phi, Phi^2, Phi^4, ...; 2^24 samples are the most that a trial takes
MARGIN = 1.01  # for the roundings of the bounds themselves

Matrix = list[list[int]]


class Drift(NamedTuple):
    """Numbers of a cell that sets of states are followed by; ``n`` is the order of its body.

    ``powers``: (`POWERS` * n * n), of Phi; ``once``: (n + 2), bound on what roundings add in one interval to the error
    of a state, in `body.norm`: a constant, and what there is of it by the largest command and by each |z|. ``units``:
    (n), norm of a unit of each. ``blur``: relative error of a difference moved by any number of samples.
    ``coast``: bound on what roundings add to a state that moves freely for up to a sample period, by the norm of its
    rate. ``bottom``: `readings.deepest_level`.
    """

    powers: Any
    once: Any
    units: Any
    blur: float
    coast: float
    bottom: float


class Hold(NamedTuple):
    """A part of an interval: its length, the place of its matrix of more than two states, its (S, G, F) of two."""

    span: float
    matrix: int
    plane: tuple[float, float, float]


def make_drift(body: Body, wall: Controller, law: Law | None = None) -> Drift:
    """The numbers of a cell, in lists. The body has no friction and is held: ``body.reach`` is finite.

    Under a ``law`` the body moves over the pieces of an interval that the law has.
    """
    units = [norm([float(i == j) for j in range(body.order)], body) for i in range(body.order)]
    spans = largest_entries(body)
    overlap = 1.0 + sum(one * span for one, span in zip(units, spans, strict=True))
    powers, blur = _powers(body, wall, units, spans)
    return Drift(
        powers=powers,
        once=[MARGIN * value for value in _rounded_once(body, _holds(body, wall, law), units)],
        units=units,
        blur=MARGIN * overlap * blur,
        coast=MARGIN * _coast(body, units, spans),
        bottom=deepest_level(wall) if law is None else -inf,
    )


def _powers(body: Body, wall: Controller, units: list[float], spans: list[float]) -> tuple[list[float], float]:
    """Powers of Phi, and what rounding them, cutting a polygon and telling it from another centre adds up to."""
    n, a = body.order, whole_matrix(body)
    phi = product(exponential(a, 1.0 - wall.split)[0], exponential(a, wall.split)[0])
    powers: list[float] = []
    blur = 16.0 * EPSILON  # for what cutting a polygon and telling it from another centre rounds
    for _ in range(POWERS):
        entries = [[entry / POINT for entry in row] for row in phi]
        powers += [entry for row in entries for entry in row]
        blur += sum(
            units[i] * (n + 2) * EPSILON * sum(abs(entries[i][j]) * spans[j] for j in range(n)) for i in range(n)
        )
        phi = product(phi, phi)
    return powers, blur


def _holds(body: Body, wall: Controller, law: Law | None) -> list[Hold]:
    """The parts of an interval."""
    if law is not None:
        pieces = [law.sched[at : at + PIECE] for at in range(0, law.pieces * PIECE, PIECE)]
        return [Hold(one[SPAN], int(one[MATRIX]), (one[S], one[G], one[F])) for one in pieces]
    later = Hold(1.0 - wall.split, SECOND, (body.s2, body.g2, body.f2))
    return [Hold(wall.split, FIRST, (body.s1, body.g1, body.f1)), later] if wall.split > 0.0 else [later]


def _rounded_once(body: Body, holds: list[Hold], units: list[float]) -> list[float]:
    """`Drift.once`, without its margin."""
    n, a = body.order, whole_matrix(body)
    once, reached = [0.0] * (n + 2), [[1.0 if k == 2 + i else 0.0 for k in range(n + 2)] for i in range(n)]
    for hold in holds:
        power, integral = exponential(a, hold.span)
        own, size = _hold(body, integral, power, hold)
        later = [sum(own[2 + j] * reached[j][k] for j in range(n)) for k in range(n + 2)]
        once = [value + (own[k] if k < 2 else 0.0) + later[k] for k, value in enumerate(once)]
        reached = [
            [(row[k] if k < 2 else 0.0) + sum(row[2 + j] * reached[j][k] for j in range(n)) for k in range(n + 2)]
            for row in size
        ]
    # Where a position is compared with an edge, and where a state is told from another centre, it is rounded, too.
    for j in range(n):
        once[2 + j] += 8.0 * EPSILON * units[j] * (1.0 if j else body.reach * units[0])
    return once


def _coast(body: Body, units: list[float], spans: list[float]) -> float:
    """Bound on the error of `arc.drift_over`, and of a rate by it, for a rate of norm 1."""
    n = body.order
    if n == 2:
        # S and F are at most 1, G at most 1/2, each good to a few units in the last place.
        within = units[0] * (2.0 * spans[0] * (1.0 + body.alpha) + spans[1]) + units[1] * (
            spans[1] + body.beta * spans[0]
        )
        size = sum(units[i] * abs(body.matrices[i * n + j]) * spans[j] for i in range(n) for j in range(n))
        return float(32.0 * EPSILON * (1.0 + size) * (1.0 + within))
    total = 0.0
    size = [spans[i] + sum(abs(body.matrices[i * n + j]) * spans[j] for j in range(n)) for i in range(n)]
    for half, right in enumerate(halves(body)):
        base = (HALVES + half) * n * n
        for i in range(n):
            for j in range(n):
                held = body.matrices[base + i * n + j]
                total += units[i] * (off(held, right[i][j]) * spans[j] + (2 * n + 6) * EPSILON * abs(held) * size[j])
    ways = sum(units[i] * size[i] for i in range(n))
    return float((total + 0.5 ** (HALVINGS - 1)) * (1.0 + ways) + (n + 2) * EPSILON * ways)


def largest_entries(body: Body) -> list[float]:
    """The largest that each entry of a difference of norm 1 can be."""
    spans = [body.reach, 1.0]
    if body.ratio > 0.0:
        spans += [body.pad_stiffness**-0.5, 1.0 + body.ratio**0.5]
    if body.coil > 0.0:
        spans.append(body.coil**-0.5)
    if body.lag > 0.0:
        spans.append(body.lag)
    return spans


def _hold(body: Body, d: Matrix, phi: Matrix, hold: Hold) -> tuple[list[float], list[list[float]]]:
    """Bounds on the roundings of a part of an interval, and on the state after it.

    Each is told by 1, the command, and the entries of the state: the first in the norm, (n + 2); the second by entry.
    """
    n = body.order
    units = [norm([float(i == j) for j in range(n)], body) for i in range(n)]
    rate = []  # bounds on the terms of each rate
    for i in range(n):
        command = abs(body.vectors[ENTRY * n + i]) if body.lag == 0.0 else (body.lag if i == n - 1 else 0.0)
        row = [abs(body.matrices[i * n + j]) for j in range(n)]
        rate.append([abs(body.vectors[CONSTANT * n + i]), command, *row])
    if n == 2:
        # x + (s v + g y) and f v + s y; y is the second rate without its damping.
        s, g, f = hold.plane
        wrong_s, wrong_g, wrong_f = off(s, phi[0][1]), off(g, d[0][1]), off(f, phi[1][1])
        pull = [rate[1][0], rate[1][1], rate[1][2], 0.0]
        speed = [0.0, 0.0, 0.0, 1.0]
        place = [0.0, 0.0, 1.0, 0.0]
        size = [_add(place, speed, pull, abs(s), abs(g)), _add([0.0] * 4, speed, pull, abs(f), abs(s))]
        wrong = [_add([0.0] * 4, speed, pull, wrong_s, wrong_g), _add([0.0] * 4, speed, pull, wrong_f, wrong_s)]
    else:
        base = hold.matrix * n * n
        size, wrong = [], []
        for i in range(n):
            held = [abs(body.matrices[base + i * n + j]) for j in range(n)]
            apart = [off(body.matrices[base + i * n + j], d[i][j]) for j in range(n)]
            own = [1.0 if k == 2 + i else 0.0 for k in range(n + 2)]
            size.append([own[k] + sum(held[j] * rate[j][k] for j in range(n)) for k in range(n + 2)])
            wrong.append([sum(apart[j] * rate[j][k] for j in range(n)) for k in range(n + 2)])
    once = [sum(units[i] * (wrong[i][k] + (2 * n + 6) * EPSILON * size[i][k]) for i in range(n)) for k in range(n + 2)]
    return once, size


def _add(base: list[float], one: list[float], other: list[float], by: float, by_other: float) -> list[float]:
    return [p + by * q + by_other * r for p, q, r in zip(base, one, other, strict=True)]


def off(value: float, exact: int) -> float:
    """How far a float is from an exact number."""
    return float(abs(_whole(value) - exact) / POINT)


def _whole(value: float) -> int:
    return int(Fraction(value) * POINT)


def whole_matrix(body: Body, which: int = RATES) -> Matrix:
    """The rates of a body, that slides or as ``which`` of its matrices has it, as whole numbers."""
    n = body.order
    at = which * n * n
    return [[_whole(body.matrices[at + i * n + j]) for j in range(n)] for i in range(n)]


def halves(body: Body, which: int = RATES) -> list[Matrix]:
    """Integrals of the exponential of these rates over a sample period, half of it, and so on, `body.HALVINGS` many."""
    power, integral = exponential(whole_matrix(body, which), 0.5 ** (HALVINGS - 1))
    found: list[Matrix] = []
    for _ in range(HALVINGS):
        found.append(integral)
        further = product(power, integral)
        integral = [[p + q for p, q in zip(r, s, strict=True)] for r, s in zip(integral, further, strict=True)]
        power = product(power, power)
    return found[::-1]


def product(a: Matrix, b: Matrix) -> Matrix:
    """Product of two matrices of numbers with `BITS` bits after the point."""
    columns = list(zip(*b, strict=True))
    return [[sum(p * q for p, q in zip(row, column, strict=True)) >> BITS for column in columns] for row in a]


def exponential(a: Matrix, span: float) -> tuple[Matrix, Matrix]:
    """The exponential of ``a`` over ``span``, and its integral, of numbers with `BITS` bits after the point."""
    n = len(a)
    one = [[(1 << BITS) if i == j else 0 for j in range(n)] for i in range(n)]
    time = _whole(span)
    over = [[entry * time >> BITS for entry in row] for row in a]
    size = max(sum(abs(entry) for entry in row) for row in over)
    halvings = max(0, size.bit_length() - BITS + 4)
    over = [[entry >> halvings for entry in row] for row in over]
    term = one
    series = one  # sum of (A t)^k / (k + 1)!
    for k in range(1, TERMS):
        term = [[entry // (k + 1) for entry in row] for row in product(term, over)]
        series = [[p + q for p, q in zip(r, s, strict=True)] for r, s in zip(series, term, strict=True)]
    step = time >> halvings
    integral = [[entry * step >> BITS for entry in row] for row in series]
    power = product(over, series)
    for i in range(n):
        power[i][i] += 1 << BITS
    for _ in range(halvings):
        further = product(power, integral)
        integral = [[p + q for p, q in zip(r, s, strict=True)] for r, s in zip(integral, further, strict=True)]
        power = product(power, power)
    return power, integral
