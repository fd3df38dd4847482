"""Two numbers of a controller's memory that fade together: a norm in which they shrink by one factor a sample."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROUNDING = 1.0 + 2.0**-40  # of the norm of a matrix of two rows, far beyond its condition times the rounding of one


class FadingPair(NamedTuple):
    """``numbers`` as `Law.pair` has them; ``fade``: by which the norm of a difference shrinks in a sample, if < 1.

    The norm is never less than the difference in a row that was asked for.
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
    return FadingPair((*map(float, a.ravel()), *map(float, forms.ravel()), across), fade)
