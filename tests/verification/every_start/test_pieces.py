"""The outward arithmetic and the pieces of the plane hold their promise: no true result, and no state, is lost."""

import math
import random
from fractions import Fraction

import numpy as np
import pytest

from tests.verification.every_start import outward, polygon
from tests.verification.every_start.cell import Cell, NotProven, above, below, floats, iv
from tests.verification.every_start.everywhere import settled_levels
from tests.verification.every_start.follow import captor, step
from tests.verification.every_start.polygon import BLUR, CORNERS, FIRST, HIGHEST, LOWEST, WIDTH, V, X

SCENE = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}

State = tuple[Fraction, Fraction]


def intervals(chance: random.Random) -> tuple[tuple[float, float], Fraction]:
    """An interval of floats of any size, and a number in it."""
    low = chance.uniform(-1.0, 1.0) * 10.0 ** chance.randint(-12, 6)
    high = low + abs(low) * chance.choice([0.0, 1e-16, 1e-9, 3.0])
    share = Fraction(chance.random())
    return (low, high), Fraction(low) + (Fraction(high) - Fraction(low)) * share


def test_true_results_are_inside() -> None:
    """Sums, differences, products and quotients of numbers in two intervals, exactly, lie in the result."""
    chance = random.Random(0)
    for _ in range(3000):
        (a, p), (b, q) = intervals(chance), intervals(chance)
        results = [(outward.add(a, b), p + q), (outward.subtract(a, b), p - q), (outward.multiply(a, b), p * q)]
        if not b[0] <= 0.0 <= b[1]:
            results.append((outward.divide(a, b), p / q))
        for (low, high), true in results:
            assert low < true < high
        x = outward.middle(a)
        assert a[0] <= x <= a[1]
        for far in (x, b[0]):
            assert all(outward.reach(a, far) >= abs(end - Fraction(far)) for end in (Fraction(a[0]), p, Fraction(a[1])))


def test_sizes_are_not_too_small() -> None:
    """sqrt(x^2 + v^2 / beta), against its square in fractions."""
    chance = random.Random(1)
    for _ in range(1000):
        dx, dv, weight = chance.random() * 1e-9, chance.random(), 10.0 ** chance.uniform(-1.0, 5.0)
        found = Fraction(outward.size(dx, dv, weight))
        assert found**2 >= Fraction(dx) ** 2 + Fraction(dv) ** 2 * Fraction(weight)
        assert found**2 <= (Fraction(dx) ** 2 + Fraction(dv) ** 2 * Fraction(weight)) * (1 + Fraction(1, 10**14))


@pytest.mark.parametrize("rate", [100.0, 10_000.0])
def test_coefficients_are_those_of_the_equations(rate: float) -> None:
    """Phi and Gamma in closed form, at 40 digits: exp of an underdamped oscillator and its step response."""
    cell = Cell(SCENE, rate, 512)
    a, b = cell.alpha / 2, cell.beta
    w = iv.sqrt(b - a * a)
    decay, cosine, sine = iv.exp(-a), iv.cos(w), iv.sin(w) / w
    expected = [[decay * (cosine + a * sine), decay * sine], [-b * decay * sine, decay * (cosine - a * sine)]]
    for row, others in zip(cell.hold[0], expected, strict=True):
        for one, other in zip(row, others, strict=True):
            assert abs((one - other).mid) < 1e-36
            assert above(one) - below(one) < 1e-15
    gain = [(1 - expected[0][0]) / b, expected[0][1]]
    assert all(abs((one - other).mid) < 1e-30 for one, other in zip(cell.hold[1], gain, strict=True))
    assert float(cell.beta.mid) == pytest.approx(0.04 / 2.2e-6 / rate**2)
    low, high = floats(iv.mpf("0.1"))
    assert low < 0.1 < high


def test_free_motion_that_grows_is_not_passed() -> None:
    """The norm is checked: damping that is negative makes it grow."""
    spoilt = {**SCENE, "hand": {**SCENE["hand"], "damping": -1e-6}}
    with pytest.raises(NotProven, match="shrink"):
        Cell(spoilt, 1000.0, 512)


def test_levels_that_no_motion_reads_are_not_proven() -> None:
    """A settled motion's levels are proven; with one of them changed they are not."""
    cell = Cell(SCENE, 464.2, 128)
    levels = settled_levels(cell, 1.0, 0.0)
    orbit = cell.prove(levels)
    assert 0.0 < orbit.nearest[0] <= orbit.margin[0] <= orbit.margin[1] < 0.5
    assert orbit.error < 1e-15
    for i in range(len(levels)):
        spoilt = (*levels[:i], levels[i] - 1 if levels[i] else -1, *levels[i + 1 :])
        with pytest.raises(NotProven, match="reads another level"):
            cell.prove(spoilt)


def made(chance: random.Random) -> list[float]:
    """A piece with a few corners around a centre, and a blur that is large enough to be seen."""
    piece = [0.0] * WIDTH
    corners = chance.randint(1, 7)
    piece[BLUR], piece[X], piece[V] = 1e-3 * chance.random(), chance.uniform(-3.0, 3.0), chance.uniform(-0.3, 0.3)
    piece[LOWEST], piece[HIGHEST], piece[CORNERS] = -1e9, 0.0, corners
    for i, turn in enumerate(sorted(chance.uniform(0.0, 2.0 * math.pi) for _ in range(corners))):
        piece[FIRST + 2 * i], piece[FIRST + 2 * i + 1] = 1.5 * math.cos(turn), 0.1 * math.sin(turn)
    return piece


def drawn(piece: list[float], weight: float, chance: random.Random) -> State:
    """A state of the piece: its centre, a mean of its corners, and most of the blur, exactly."""
    corners = int(piece[CORNERS])
    parts = [Fraction(chance.random() ** 4) for _ in range(corners)]
    total = sum(parts) or Fraction(1)
    turn, much = chance.uniform(0.0, 2.0 * math.pi), 0.999 * piece[BLUR]
    x = Fraction(piece[X]) + Fraction(much * math.cos(turn))
    v = Fraction(piece[V]) + Fraction(much * math.sin(turn) / math.sqrt(weight))
    for i, part in enumerate(parts):
        x += part / total * Fraction(piece[FIRST + 2 * i])
        v += part / total * Fraction(piece[FIRST + 2 * i + 1])
    return x, v


def holds(piece: list[float], state: State, weight: float) -> bool:
    """Whether a state is in the polygon around the centre, or nearer to it than the blur (and a last digit)."""
    scale = math.sqrt(weight)
    corners = [
        (Fraction(piece[FIRST + 2 * i]), Fraction(piece[FIRST + 2 * i + 1]) * Fraction(scale))
        for i in range(int(piece[CORNERS]))
    ]
    x, v = state[0] - Fraction(piece[X]), (state[1] - Fraction(piece[V])) * Fraction(scale)
    sides, near = [], math.inf
    for (ax, av), (bx, bv) in zip(corners, corners[1:] + corners[:1], strict=True):
        sides.append((bx - ax) * (v - av) - (bv - av) * (x - ax))
        length = (bx - ax) ** 2 + (bv - av) ** 2
        share = (
            min(max(((x - ax) * (bx - ax) + (v - av) * (bv - av)) / length, Fraction(0)), Fraction(1)) if length else 0
        )
        near = min(near, float((x - ax - share * (bx - ax)) ** 2 + (v - av - share * (bv - av)) ** 2))
    inside = len(corners) > 2 and all(side >= 0 for side in sides)
    return inside or math.sqrt(near) <= piece[BLUR] * (1.0 + 1e-12)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("rate", [215.4, 4641.6])
def test_no_state_is_lost(rate: float) -> None:
    """States of a piece, moved by the exact map, are in the moved piece; cut, in the part of their side of the edge."""
    cell, chance = Cell(SCENE, rate, 512), random.Random(3)
    weight, powers, drives = cell.inverse_beta, cell.powers(9), cell.drives()
    phi = [[exact(one) for one in row] for row in cell.hold[0]]
    for _ in range(150):
        piece = made(chance)
        edge = float(math.floor(piece[X] + chance.uniform(-1.0, 1.0)))
        if chance.random() < 0.5:  # all corners on one side, states on both
            corners, side = piece[FIRST : FIRST + 2 * int(piece[CORNERS]) : 2], chance.choice([-1, 1])
            piece[X] = edge - side * min(side * one for one in corners) + side * 0.5 * chance.random() * piece[BLUR]
        states = [drawn(piece, weight, chance) for _ in range(6)]
        assert all(holds(piece, state, weight) for state in states)
        for side in (-1, 1):
            part = [0.0] * WIDTH
            left = polygon.cut(piece, edge, side, part, weight)
            for x, v in states:
                if (x < edge) == (side < 0):
                    assert left
                    assert holds(part, (x, v), weight)
        low, high = polygon.angles(piece)
        assert all(low <= x <= high for x, _ in states)
        wide = polygon.radius(piece, weight) + piece[BLUR]
        for x, v in states:
            distance = float((x - Fraction(piece[X])) ** 2 + (v - Fraction(piece[V])) ** 2 * Fraction(weight))
            assert math.sqrt(distance) <= wide * (1.0 + 1e-15)
        level, moved = chance.randint(-3, 0), list(piece)
        u = exact(cell.torque(level))
        g = [exact(one) for one in cell.hold[1]]
        step(moved, powers[1], drives[-level], weight)
        polygon.contract(moved, powers[1], weight)
        for x, v in states:
            at = (phi[0][0] * x + phi[0][1] * v + g[0] * u, phi[1][0] * x + phi[1][1] * v + g[1] * u)
            assert holds(moved, at, weight)


def exact(number: object) -> Fraction:
    """The middle of an mpmath interval: 40 digits of the coefficient."""
    sign, mantissa, exponent, _ = number.mid._mpi_[0]
    return Fraction((-1) ** sign * int(mantissa)) * Fraction(2) ** exponent


def test_roundings_add_to_the_blur() -> None:
    """A piece without blur gets some from every step, and no more than a few last digits."""
    cell = Cell(SCENE, 1000.0, 512)
    piece = made(random.Random(5))
    piece[BLUR] = 0.0
    step(piece, cell.powers(1)[1], cell.drives()[1], cell.inverse_beta)
    assert 0.0 < piece[BLUR] < 1e-13


def test_capture_needs_the_whole_margin() -> None:
    """Distance, width and what the orbit may be off by, together less than the margin."""
    table = np.array([[-0.5, 0.01, 1e-9, 0.25, 3.0]])
    assert captor(-0.4, 0.01, 0.1, table, 100.0) == 3
    for x, v, wide in ((-0.4, 0.01, 0.15), (-0.4, 0.035, 0.0), (-0.24, 0.01, 0.0), (-0.5, 0.01, 0.25)):
        assert captor(x, v, wide, table, 100.0) == -1
    table[0, 2] = 0.1
    assert captor(-0.4, 0.01, 0.1, table, 100.0) == -1
    assert captor(-0.4, 0.01, 0.04, table, 100.0) == 3
