"""Two numbers of a controller's memory that fade together: a norm in which they shrink by one factor a sample.

The norm is found in floats, from eigenvectors. Those of a filter that is far slower than the clock are nearly one, and
what is found may be wrong by more than its factor is below 1. So what a proof needs of it is checked in fractions.
"""

from fractions import Fraction
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROUNDING = 1.0 + 2.0**-40  # of the norm of a matrix of two rows, far beyond its condition times the rounding of one


class FadingPair(NamedTuple):
    """``numbers`` as `Law.pair` has them; ``fade``: by which the norm of a difference shrinks in a sample, if < 1.

    The norm is never less than the difference in a row that was asked for. Where that is not so, ``fade`` is infinite.
    """

    numbers: tuple[float, ...]
    fade: float


def make_pair(a: NDArray[np.float64], rows: tuple[int, ...]) -> FadingPair:
    """A norm for the map ``a``, (2, 2), of a difference in a sample; ``rows``: those that the norm must be above.

    In the coordinates of its eigenvectors, of a complex one its two parts, a map is its eigenvalues, or a turn and a
    factor: its Euclidean norm there is the largest of them.
    """
    values, vectors = np.linalg.eig(a)
    turns = bool(abs(values[0].imag) > 0.0)
    basis = np.column_stack([vectors[:, 0].real, vectors[:, 0].imag]) if turns else vectors.real
    forms = np.linalg.inv(basis)
    fade = float(np.linalg.norm(forms @ a @ basis, 2)) * ROUNDING
    forms = forms * max(float(np.linalg.norm(basis[row])) for row in rows) * ROUNDING
    across = float(np.linalg.norm(forms, 2)) * ROUNDING
    if not is_proven(a.tolist(), forms.tolist(), fade, rows):
        fade = inf
    return FadingPair((*map(float, a.ravel()), *map(float, forms.ravel()), across), fade)


def is_proven(a: list[list[float]], forms: list[list[float]], fade: float, rows: tuple[int, ...]) -> bool:
    """Whether |F A d| <= fade |F d| and |d[row]| <= |F d| for all d, with the rows F of ``forms``; by fractions."""
    f, g = _exact(forms), _times(_exact(forms), _exact(a))
    size, after, factor = _squares(f), _squares(g), Fraction(fade) ** 2
    falls = [factor * one - other for one, other in zip(size, after, strict=True)]
    above = [[one - (k == 2 * row) for k, one in enumerate(size)] for row in rows]
    return all(p >= 0 and r >= 0 and p * r >= q * q for p, q, r in (falls, *above))


def _exact(matrix: list[list[float]]) -> list[list[Fraction]]:
    return [[Fraction(entry) for entry in row] for row in matrix]


def _times(a: list[list[Fraction]], b: list[list[Fraction]]) -> list[list[Fraction]]:
    return [[row[0] * b[0][j] + row[1] * b[1][j] for j in range(2)] for row in a]


def _squares(f: list[list[Fraction]]) -> list[Fraction]:
    """The quadratic form |F d|^2: its entries for d0^2, half of d0 d1, and d1^2."""
    return [f[0][i] * f[0][j] + f[1][i] * f[1][j] for i, j in ((0, 0), (0, 1), (1, 1))]
