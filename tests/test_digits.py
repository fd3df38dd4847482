"""The numbers of 60 digits are what they say: against mpmath, which shares no code with MPFR."""

import random

import mpmath
import pytest

from tests import digits as mp

CLOSE = 1e-58


@pytest.fixture(scope="module")
def other() -> mpmath.MPContext:
    """A context of 100 digits."""
    context = mpmath.MPContext()
    context.dps = 100
    return context


def off(found: mp.mpf, other: mpmath.MPContext, expected: mpmath.mpf) -> float:
    """The difference of two numbers over the size of the second, at least 1."""
    top, bottom = map(int, found.as_integer_ratio())
    return float(abs(other.mpf(top) / bottom - expected) / max(1, abs(expected)))


def test_functions(other: mpmath.MPContext) -> None:
    third, wide = mp.mpf(1) / 3, other.mpf(1) / 3
    assert off(third, other, wide) < CLOSE
    assert off(mp.pi, other, +other.pi) < CLOSE
    for name in ("sqrt", "exp", "expm1", "sin", "cos"):
        assert 0.0 < off(getattr(mp, name)(third), other, getattr(other, name)(wide)) < CLOSE, name
    root = mp.sqrt(mp.mpc(-third))
    assert root.real == 0
    assert off(mp.im(mp.exp(root)), other, other.exp(other.sqrt(-wide)).imag) < CLOSE
    assert off(mp.fsum(third * k for k in range(10)), other, 45 * wide) < CLOSE
    assert mp.ldexp(third, -3) * 8 == third == mp.ldexp(third, 3) / 8
    assert [int(f(mp.mpf(-2.5))) for f in (mp.floor, mp.ceil, mp.nint)] == [-3, -2, -2]
    assert (mp.mpf(0.1), mp.nint(mp.mpf(1.5))) == (0.1, 2)


@pytest.mark.parametrize(("size", "scale"), [(2, 1.0), (3, 1e-9), (8, 1.0), (8, 300.0)])
def test_matrices(other: mpmath.MPContext, size: int, scale: float) -> None:
    chance = random.Random(size)
    a = [[scale * chance.uniform(-1.0, 1.0) * (chance.random() < 0.7) for _ in range(size)] for _ in range(size)]
    b = [chance.random() for _ in range(size)]
    found, expected = mp.expm(mp.matrix(a)), other.expm(other.matrix(a))
    largest = max(abs(expected[i, j]) for i in range(size) for j in range(size))
    for i in range(size):
        for j in range(size):
            assert off(found[i, j] / mp.mpf(str(largest)), other, expected[i, j] / largest) < CLOSE
    whole = [[x + (2.0 * scale if i == j else 0.0) for j, x in enumerate(row)] for i, row in enumerate(a)]
    solved, right = mp.lu_solve(mp.matrix(whole), mp.matrix(b)), other.lu_solve(other.matrix(whole), other.matrix(b))
    assert all(off(x, other, y) < CLOSE * 10.0 for x, y in zip(solved, right, strict=True))
    assert (mp.matrix(whole) * solved)[0] == pytest.approx(b[0])


def test_what_is_not_a_number_is_an_error_and_precision_comes_back() -> None:
    with pytest.raises(ArithmeticError):
        mp.one / mp.zero
    with pytest.raises((ArithmeticError, ValueError)):
        mp.sqrt(-mp.one)
    with mp.extradps(30):
        more = mp.one / 3
    assert more != mp.one / 3 == +more
    with mp.workdps(20):
        assert abs(mp.one / 3 - more) > 1e-25
