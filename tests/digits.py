"""Numbers of 60 digits for the models that the package is compared with: MPFR's, by gmpy2, named as mpmath names them.

An operation takes a tenth of a microsecond, where mpmath takes one or two. All modules that import this one share one
precision, which operators take from gmpy2's context. It is set here; `workdps` and `extradps` change it for a while.
What is not a number is an error, as in mpmath: a division by zero, an overflow, the root of a negative real number.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import gmpy2

DIGITS = 60
BITS_OF_A_DIGIT = 3.3219280948873626  # log2(10), rounded up

mpf, mpc = gmpy2.mpfr, gmpy2.mpc
sqrt, exp, expm1, log2, sin, cos = gmpy2.sqrt, gmpy2.exp, gmpy2.expm1, gmpy2.log2, gmpy2.sin, gmpy2.cos
floor, ceil, nint, sign = gmpy2.floor, gmpy2.ceil, gmpy2.rint, gmpy2.sign


def _bits(digits: float) -> int:
    return int(digits * BITS_OF_A_DIGIT) + 4


gmpy2.set_context(gmpy2.context(precision=_bits(DIGITS), trap_divzero=True, trap_invalid=True, trap_overflow=True))
zero, one, inf, pi = mpf(0), mpf(1), mpf("inf"), gmpy2.const_pi()


def _with(bits: int) -> Any:
    return gmpy2.context(gmpy2.get_context(), precision=bits)


def workdps(digits: int) -> Any:
    """A context of ``digits`` digits."""
    return _with(_bits(digits))


def extradps(digits: int) -> Any:
    """A context of ``digits`` digits more."""
    return _with(gmpy2.get_context().precision + _bits(digits))


def fsum(numbers: Iterable[Any]) -> Any:
    """The sum, rounded once."""
    return gmpy2.fsum(list(numbers))


def ldexp(number: Any, power: int) -> Any:
    """``number`` times a power of two, exactly."""
    return gmpy2.mul_2exp(number, power) if power >= 0 else gmpy2.div_2exp(number, -power)


def whole(number: Any) -> Any:
    """The whole number towards zero, of any size: sums of such in fixed point take half the time that int takes."""
    return gmpy2.mpz(gmpy2.trunc(number))


def re(number: Any) -> Any:
    """The real part."""
    return number.real


def im(number: Any) -> Any:
    """The imaginary part."""
    return number.imag


class matrix:
    """Rows of numbers: from their size, from rows, or a column from numbers."""

    def __init__(self, rows: Any, columns: int | None = None) -> None:
        if isinstance(rows, int):
            self.rows = [[zero] * (rows if columns is None else columns) for _ in range(rows)]
        else:
            self.rows = [[mpf(x) for x in (row if isinstance(row, list | tuple) else [row])] for row in rows]

    def tolist(self) -> list[list[Any]]:
        """The rows."""
        return self.rows

    def __getitem__(self, at: Any) -> Any:
        i, j = at if isinstance(at, tuple) else (at, 0)
        return self.rows[i][j]

    def __setitem__(self, at: Any, value: Any) -> None:
        i, j = at if isinstance(at, tuple) else (at, 0)
        self.rows[i][j] = value

    def __iter__(self) -> Iterator[Any]:
        return (x for row in self.rows for x in row)

    def __mul__(self, other: Any) -> "matrix":
        found = matrix(0)
        if isinstance(other, matrix):
            found.rows = _product(self.rows, other.rows)
        else:
            found.rows = [[x * other for x in row] for row in self.rows]
        return found


def _product(a: list[list[Any]], b: list[list[Any]]) -> list[list[Any]]:
    found = []
    for row in a:
        there = [(x, b[k]) for k, x in enumerate(row) if x]
        found.append([sum((x * other[j] for x, other in there if other[j]), zero) for j in range(len(b[0]))])
    return found


def expm(a: matrix) -> matrix:
    """exp(a): the series of a part of it so small that each term gains eight bits, squared again and again.

    A squaring may double the relative error: as many bits more are carried as there are squarings, twice, and some.
    """
    bits, n = gmpy2.get_context().precision, len(a.rows)
    norm = max(sum(abs(x) for x in row) for row in a.rows)
    squarings = max(0, gmpy2.frexp(norm)[0] + 8) if norm else 0
    with _with(bits + 2 * squarings + 64):
        part = [[ldexp(x, -squarings) for x in row] for row in a.rows]
        term = [[one if i == j else zero for j in range(n)] for i in range(n)]
        total, k, least = [row[:] for row in term], 0, ldexp(one, -(bits + 2 * squarings + 64))
        while any(abs(x) > least for row in term for x in row):
            k += 1
            term = [[x / k for x in row] for row in _product(term, part)]
            total = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
        for _ in range(squarings):
            total = _product(total, total)
    found = matrix(0)
    found.rows = [[+x for x in row] for row in total]
    return found


def lu_solve(a: matrix, b: matrix) -> matrix:
    """The x of a x = b: elimination with the largest pivot of each column, with 20 digits more."""
    n = len(a.rows)
    with extradps(20):
        rows = [[*row, value] for row, value in zip(a.rows, b, strict=True)]
        for k in range(n):
            best = max(range(k, n), key=lambda i: abs(rows[i][k]))
            rows[k], rows[best] = rows[best], rows[k]
            for i in range(k + 1, n):
                share = rows[i][k] / rows[k][k]
                rows[i] = [x - share * y for x, y in zip(rows[i], rows[k], strict=True)]
        found = [zero] * n
        for k in reversed(range(n)):
            found[k] = (rows[k][n] - sum((rows[k][j] * found[j] for j in range(k + 1, n)), zero)) / rows[k][k]
    return matrix([+x for x in found])
