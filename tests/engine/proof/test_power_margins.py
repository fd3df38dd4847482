"""Powers of a derivative, on their margins: against fractions, numpy's powers, and maps whose end is known."""

from collections.abc import Callable
from fractions import Fraction
from math import cos, inf, nextafter, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.powers import (
    dissipates,
    ellipse_bound,
    falls,
    growth_bound,
    invert,
    lyapunov_sum,
    scaled,
    square,
)

ROUNDING = 64.0 * EPSILON  # of a product of one term
STRIDE = 7  # more than there are rows: a column has room for what is not asked for


def columns(m: np.ndarray, stride: int = STRIDE) -> list[float]:
    n = len(m)
    return [float(m[i, c]) if i < n else 9e9 for c in range(n) for i in range(stride)]


def turning(radius: float, angle: float) -> np.ndarray:
    return radius * np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])


def units(n: int, scale: float) -> np.ndarray:
    """Of positions and speeds in turn."""
    return np.array([1.0, scale, 1.0, scale, 1.0, scale][:n])


def random_map(numbers: np.random.Generator, n: int, radius: float, scale: float) -> np.ndarray:
    """Whose largest eigenvalue is as large as the radius, in units that differ by the scale."""
    m = numbers.normal(size=(n, n))
    m *= radius / np.abs(np.linalg.eigvals(m)).max()
    return np.asarray(m * units(n, scale)[:, None] / units(n, scale)[None, :])


# The inverse.


def inverted(matrix: list[list[float]]) -> list[list[float]] | None:
    """Of a matrix whose entries are exact beside 1."""
    n = len(matrix)
    a = [5.0] * (2 * n * n)
    if not invert(a, columns(np.eye(n) - np.array(matrix)), n, STRIDE):
        return None
    return [a[2 * n * i + n : 2 * n * (i + 1)] for i in range(n)]


def exact_inverse(matrix: list[list[float]]) -> list[list[Fraction]]:
    """By minors."""
    n = len(matrix)
    whole = [[Fraction(entry) for entry in row] for row in matrix]

    def determinant(rows: list[list[Fraction]]) -> Fraction:
        if not rows:
            return Fraction(1)
        return sum(
            (
                (-1) ** c * rows[0][c] * determinant([row[:c] + row[c + 1 :] for row in rows[1:]])
                for c in range(len(rows))
            ),
            Fraction(0),
        )

    def minor(i: int, j: int) -> Fraction:
        return determinant([row[:j] + row[j + 1 :] for k, row in enumerate(whole) if k != i])

    size = determinant(whole)
    return [[(-1) ** (i + j) * minor(j, i) / size for j in range(n)] for i in range(n)]


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_the_inverse_of_whole_numbers_is_that_of_fractions(n: int) -> None:
    """Small whole numbers: entries of 0, 1 and -1 are among the factors, and rows that must change places."""
    numbers, tried = np.random.default_rng(n), 0
    while tried < 40:
        matrix = numbers.integers(-2, 3, size=(n, n)).astype(float).tolist()
        if abs(np.linalg.det(matrix)) < 0.5:
            continue
        tried += 1
        found, exact = inverted(matrix), exact_inverse(matrix)
        assert found is not None
        for row, true in zip(found, exact, strict=True):
            assert row == pytest.approx([float(one) for one in true], abs=1e-13)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("row", [0, 1, 2])
def test_the_largest_entry_of_a_column_is_the_pivot_whatever_its_sign(row: int, sign: float) -> None:
    """A first entry of 2^-40 as pivot would cost 12 digits."""
    matrix = [[2.0**-40, 2.0, 1.0], [-(2.0**-40), 1.0, 3.0], [2.0**-40, -1.0, 1.0]]
    matrix[row][0] = sign
    found, exact = inverted(matrix), exact_inverse(matrix)
    assert found is not None
    for i in range(3):
        assert found[i] == pytest.approx([float(one) for one in exact[i]], rel=1e-14, abs=1e-24)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_pivot_below_the_roundings_of_one_is_none(sign: float) -> None:
    """1e-14 is 90 roundings of 1: what is smaller may be 0."""
    for pivot, regular in ((1e-14, True), (nextafter(1e-14, 0.0), False), (0.0, False)):
        assert (inverted([[0.0, 1.0], [sign * pivot, 0.0]]) is not None) is regular
    assert inverted([[0.0]]) is None


# Powers that vanish.


def shrinks(m: np.ndarray, scale: float = 1.0, samples: int = 1) -> bool:
    n = len(m)
    return bool(dissipates(columns(m), STRIDE, [5.0] * n * n, [5.0] * n * n, n, scale, samples))


@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("scale", [1.0, 1e-3, 30.0])
def test_a_map_dissipates_if_its_eigenvalues_are_inside_the_circle(n: int, scale: float) -> None:
    numbers = np.random.default_rng(n)
    for _ in range(10):
        for radius, vanishes in ((0.3, True), (0.99, True), (1.0 - 1e-6, True), (1.0 + 1e-6, False), (2.0, False)):
            assert shrinks(random_map(numbers, n, radius, scale), scale) is vanishes


@pytest.mark.parametrize("samples", [1, 100])
def test_a_map_that_keeps_its_differences_does_not_dissipate_by_rounding(samples: int) -> None:
    """A turn has rows that are rounded: its power 10^17 would vanish. Of an undamped body it is the derivative."""
    shrunk = 0
    for k in range(1, 400):
        m = turning(1.0, k / 128.0)
        shrunk += m[0, 0] * m[0, 0] + m[1, 0] * m[1, 0] < 1.0
        assert not shrinks(m, samples=samples)
        assert not shrinks((1.0 - 1e-15) * m, samples=samples)
    assert shrunk > 50
    for sign in (-1.0, 1.0):
        assert not shrinks(np.diag([sign * nextafter(1.0, 0.0), 0.5]))
        assert not shrinks(np.diag([0.5, sign * nextafter(1.0, 0.0)]))


def test_a_power_counts_while_its_roundings_are_below_a_quarter() -> None:
    """64 roundings for a row of two terms and each of 8 samples, doubled from power to power: up to the 2^k-th."""
    highest = 1
    while 2 * highest * ROUNDING * 2 * 8 < 0.25:
        highest *= 2
    assert shrinks(np.diag([0.4999 ** (1.0 / highest), 0.0]), samples=8)
    assert not shrinks(np.diag([0.5001 ** (1.0 / highest), 0.0]), samples=8)
    # Exactly a quarter: 2^-46 a term is a quarter at a power of 2^43 for two terms, and that power does not count.
    assert ROUNDING == 2.0**-46
    assert shrinks(np.diag([0.4999 ** (2.0**-42), 0.0]))
    assert not shrinks(np.diag([0.5001 ** (2.0**-42), 0.0]))


def test_each_row_of_a_power_must_be_below_one_half() -> None:
    """What vanishes at the second power, and grew before, is seen at the second; beyond 1e100 nothing is."""
    for place in ((0, 1), (1, 0)):
        m = np.zeros((2, 2))
        m[place] = 0.9e100
        assert shrinks(m)
        for large in (1e100, 1.1e100):
            m[place] = large
            assert not shrinks(m)
    assert not shrinks(np.array([[nextafter(inf, 0.0)] * 2] * 2))
    # [[1/4, 1/4], [1/4, 1/4]] has rows of 1/2 and is its own square, twice.
    power = [0.0] * 4
    assert dissipates(columns(np.full((2, 2), 0.25)), STRIDE, power, [0.0] * 4, 2, 1.0, 1)
    assert power == [0.125] * 4
    for sign in (-1.0, 1.0):
        m = np.array([[0.3, 0.0], [sign * 0.3, 0.3]])
        assert dissipates(columns(m), STRIDE, power, [0.0] * 4, 2, 1.0, 1)
        assert power == pytest.approx((m @ m).ravel().tolist())
        assert dissipates(columns(m.T), STRIDE, power, [0.0] * 4, 2, 1.0, 1)
        assert power == pytest.approx((m.T @ m.T).ravel().tolist())
        # A row that is short when a speed counts 10.
        assert dissipates(columns(np.array([[0.3, 0.01], [-2.0, 0.1]])), STRIDE, power, [0.0] * 4, 2, 10.0, 1)
        assert power == pytest.approx([0.3, 0.1, -0.2, 0.1])


def test_a_square_is_a_product() -> None:
    numbers = np.random.default_rng(2)
    for n in (1, 2, 3, 5):
        m = numbers.normal(size=(n, n))
        power = m.ravel().tolist()
        square(power, [5.0] * n * n, n)
        np.testing.assert_allclose(np.array(power).reshape(n, n), m @ m, rtol=0, atol=1e-14)


@pytest.mark.parametrize("scale", [1.0, 0.01, 3.0])
def test_speeds_are_the_odd_entries(scale: float) -> None:
    m = np.arange(1.0, 26.0).reshape(5, 5)
    found = [[scaled(columns(m), STRIDE, i, j, scale) for j in range(5)] for i in range(5)]
    one = units(5, scale)
    np.testing.assert_allclose(found, m * one[None, :] / one[:, None], rtol=1e-15)


# The sum of the powers.


def grown(m: np.ndarray, scale: float = 1.0) -> np.ndarray | None:
    n = len(m)
    total = [5.0] * n * n
    whether = growth_bound(columns(m), STRIDE, [5.0] * n * n, [5.0] * n * n, total, n, scale)
    return np.array(total).reshape(n, n) if whether else None


@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize("scale", [1.0, 1e-3, 30.0])
def test_the_sum_is_that_of_the_absolute_powers_until_a_thousandth_is_left(n: int, scale: float) -> None:
    numbers, one = np.random.default_rng(n), units(n, scale)
    for radius in (0.01, 0.5, 0.9):
        m = random_map(numbers, n, radius, scale)
        power, total = np.eye(n), np.zeros((n, n))
        while True:
            total += np.abs(power)
            if (np.abs(power) * one[None, :] / one[:, None]).sum(axis=1).max() < 1e-3:
                break
            power = power @ m
        found = grown(m, scale)
        assert found is not None
        np.testing.assert_allclose(found, total, rtol=1e-12, atol=1e-12 * total.max())


def test_a_thousandth_itself_is_still_carried_on() -> None:
    """One, c, and the square of c only where c is not below a thousandth."""
    for c, last in ((nextafter(1e-3, 0.0), 0.0), (6e-4, 0.0), (1e-3, 1e-6), (1.5e-3, 2.25e-6)):
        assert grown(np.array([[-c]])) == pytest.approx(1.0 + c + last, rel=1e-15)


def test_what_does_not_vanish_in_time_has_no_sum() -> None:
    """4096 powers: 0.998 has vanished by then, 0.9985 has not."""
    assert grown(np.array([[0.998]])) is not None
    for keeps in (0.9985, 1.0, 1.5):
        assert grown(np.array([[keeps]])) is None
    assert grown(np.array([[np.nan, 0.0], [0.0, 0.1]])) is None
    assert grown(np.array([[0.0, 0.0], [0.9e100, 0.0]])) is not None
    assert grown(np.diag([0.1, 1.0])) is None
    assert grown(np.diag([1.0, 0.1])) is None


# The ellipse.


def test_the_sum_ends_where_the_powers_do() -> None:
    def summed(m: np.ndarray) -> list[float] | None:
        n = len(m)
        p = [5.0] * n * n
        return p if lyapunov_sum(columns(m), STRIDE, p, [5.0] * n * n, [5.0] * n * n, n, 1.0) else None

    # Two rows: half a thousandth is small, and is not summed; one row: a thousandth.
    assert summed(np.diag([4e-4, 0.0])) == [1.0, 0.0, 0.0, 1.0]
    assert summed(np.diag([6e-4, 0.0])) == [pytest.approx(1.0 + 3.6e-7, rel=1e-15), 0.0, 0.0, 1.0]
    assert summed(np.array([[6e-4]])) == [1.0]
    assert summed(np.array([[1e-3]])) == [pytest.approx(1.0 + 1e-6, rel=1e-15)]
    assert summed(np.array([[0.0, 0.9e100], [0.0, 0.0]])) == [1.0, 0.0, 0.0, pytest.approx(0.81e200)]
    for large in (1e100, 1.5e100):
        assert summed(np.array([[0.0, large], [0.0, 0.0]])) is None
    for keeps in (turning(1.0 + 1e-9, 0.3), np.diag([1.0, 0.5]), turning(3.0, 0.3)):
        assert summed(keeps) is None


def norm_falls(p: list[float], m: np.ndarray, samples: int = 1, scale: float = 1.0) -> bool:
    n = len(m)
    return bool(falls(columns(m), STRIDE, p, [5.0] * n * n, [5.0] * n * n, n, scale, samples))


@pytest.mark.parametrize("samples", [1, 50])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_norm_falls_by_more_than_its_roundings(samples: int, sign: float) -> None:
    """64 roundings of each term for each row and sample, on the diagonal and beside it."""
    small = 2 * ROUNDING * samples
    for part, found in ((2.1, True), (1.9, False)):  # 1 - q > small (1 + q)
        q = sign * (1.0 - part * small)
        assert norm_falls([1.0, q, q, 1.0], np.zeros((2, 2)), samples) is found
    for part, found in ((1.1, True), (0.9, False)):  # c^2 = 1 - 2 part small: 1 - c^2 > small (1 + c^2)
        c = sign * (1.0 - part * small)
        for place in (0, 1):
            m = np.zeros((2, 2))
            m[place, place] = c
            assert norm_falls([1e6, 0.0, 0.0, 1e6], m, samples) is found
    assert not norm_falls([0.0] * 4, np.zeros((2, 2)))  # that of nothing falls from 0 to 0


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_all_that_is_beside_the_diagonal_counts_against_it(sign: float) -> None:
    assert norm_falls([1.0, sign * 0.9, sign * 0.9, 1.0], np.zeros((2, 2)))
    for p in ([1.0, sign * 0.9, sign * 0.9, 0.5], [0.5, sign * 0.9, sign * 0.9, 1.0]):
        assert not norm_falls(p, np.zeros((2, 2)))


@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("scale", [1.0, 0.01, 20.0])
def test_what_falls_is_what_numpy_says(n: int, scale: float) -> None:
    """Gershgorin's rows of P - M' P M, computed another way, for norms that fall and norms that do not."""
    numbers, seen = np.random.default_rng(n), set()
    for _ in range(200):
        m = random_map(numbers, n, numbers.uniform(0.05, 0.6), scale)
        root = np.eye(n) + 0.2 * numbers.normal(size=(n, n))
        p, a = root @ root.T, m * units(n, scale)[None, :] / units(n, scale)[:, None]
        left = p - a.T @ p @ a
        rows = 2.0 * np.diag(left) - np.abs(left).sum(axis=1)
        if np.abs(rows).min() < 1e-9:
            continue
        found = norm_falls(p.ravel().tolist(), m, 1, scale)
        assert found is bool((rows > 0.0).all())
        seen.add(found)
    assert seen == {True, False}


def ellipse(
    m: np.ndarray, residual: np.ndarray, away: np.ndarray, scale: float = 1.0, samples: int = 1
) -> np.ndarray | None:
    n = len(m)
    work: Any = {name: [5.0] * (n * n) for name in ("power", "spare", "total")}
    space = SimpleNamespace(cols=columns(m), width=STRIDE, matrix=[5.0] * (2 * n * n), **work)
    space.residual, space.away = residual.tolist(), away.tolist()
    if not ellipse_bound(space, n, scale, samples):
        return None
    assert space.power[:n] == away.tolist()
    return np.array(space.away)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("scale", [1.0, 0.01, 20.0])
def test_the_ellipse_is_that_of_scipys_solution(n: int, scale: float) -> None:
    """Its largest entries are roots of the diagonal of P's inverse; an error counts in the worst of its directions."""
    linalg = pytest.importorskip("scipy.linalg")
    numbers, one = np.random.default_rng(n), units(n, scale)
    for radius in (0.02, 0.5, 0.97):
        m = random_map(numbers, n, radius, scale)
        p = linalg.solve_discrete_lyapunov((m * one[None, :] / one[:, None]).T, np.eye(n))
        entries = one * np.sqrt(np.diag(np.linalg.inv(p)))
        w = numbers.normal(size=n) * one
        away = np.abs(numbers.normal(size=n)) * one
        size = np.sqrt((w / one) @ p @ (w / one))
        blurred = np.sqrt((away / one) @ np.abs(p) @ (away / one))
        found = ellipse(m, w, away, scale)
        assert found is not None
        np.testing.assert_allclose(found, away + (size + blurred) * entries, rtol=1e-6)
        alone = ellipse(m, w, np.zeros(n), scale)
        np.testing.assert_allclose(alone, size * entries, rtol=1e-6)


def exact_ellipse(m: np.ndarray, w: np.ndarray, p: list[float]) -> list[float]:
    """Root of w' P w, and of the diagonal of P's inverse, at 60 digits, from the engine's own P."""
    import mpmath as mp

    with mp.workdps(60):
        n = len(m)
        whole = mp.matrix(n, n)
        for i in range(n):
            for j in range(n):
                whole[i, j] = (mp.mpf(p[i * n + j]) + mp.mpf(p[j * n + i])) / 2
        v = mp.matrix([mp.mpf(float(one)) for one in w])
        size = mp.sqrt((v.T * whole * v)[0])
        inverse = whole**-1
        return [float(size * mp.sqrt(inverse[i, i])) for i in range(n)]


@pytest.mark.parametrize("decay", [1e-4, 1e-8, 1e-11])
@pytest.mark.parametrize("n", [2, 4])
def test_an_ellipse_of_large_numbers_that_cancel_is_rounded_outward(decay: float, n: int) -> None:
    """Two slow modes that nearly agree: the ellipse is thin, and the difference lies along it.

    The bound is not below the ellipse at 60 digits, and above it by what the roundings of its terms may make.
    """
    m = np.zeros((n, n))
    m[:2, :2] = [[1.0 - decay, 0.5], [0.0, 0.5]]
    slow = np.zeros(n)
    slow[:2] = [1.0, -1.0]  # the quick mode: P has 1 / decay in each of its terms
    found = ellipse(m, slow, np.zeros(n))
    p, work = [0.0] * n * n, [0.0] * n * n
    assert lyapunov_sum(columns(m), STRIDE, p, work, [0.0] * n * n, n, 1.0)
    true = exact_ellipse(m, slow, p)
    assert found is not None
    rounding = sum(abs(slow[i] * p[i * n + j] * slow[j]) for i in range(n) for j in range(n))
    own = sum(slow[i] * p[i * n + j] * slow[j] for i in range(n) for j in range(n))
    assert abs(own) < 0.1 * rounding  # they do cancel
    x = np.linalg.inv(np.array(p).reshape(n, n))
    small = n * ROUNDING
    more = np.diag(np.abs(x) @ np.abs(np.array(p).reshape(n, n)) @ np.abs(x.T))
    for i in range(2):
        assert found[i] >= true[i]
        wide = np.sqrt((own + small * rounding) * (x[i, i] + small * more[i]))
        assert found[i] == pytest.approx(wide, rel=1e-3 * (wide / true[i] - 1.0) + 1e-12)


def test_an_ellipse_is_kept_only_where_the_norm_falls() -> None:
    m = turning(1.0 - 1e-12, 0.3)
    w, none = np.array([1.0, 0.0]), np.zeros(2)
    assert ellipse(m, w, none) is not None
    assert ellipse(m, w, none, samples=1000) is None  # the roundings of a thousand samples may be more than its decay
    for kept in (turning(1.0, 0.3), turning(1.0 + 1e-9, 0.3), turning(1.0 - 1e-16, 0.3)):
        assert ellipse(kept, w, none) is None


CHECKS: list[Callable[[np.ndarray], bool]] = [
    shrinks,
    lambda m: ellipse(m, np.ones(len(m)), np.zeros(len(m))) is not None,
]


@pytest.mark.parametrize("check", CHECKS)
def test_nothing_that_is_no_number_passes(check: Callable[[np.ndarray], bool]) -> None:
    for value in (np.nan, np.inf, -np.inf):
        assert not check(np.array([[value, 0.0], [0.0, 0.1]]))
        assert not check(np.array([[0.1, 0.0], [value, 0.1]]))
