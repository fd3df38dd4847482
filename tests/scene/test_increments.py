"""Tests of `scene.increments`: D(t) of a stiff body against 60 digits, to a rounding of each number."""

import numpy as np
import pytest
from mpmath import mp

from hknob_cli.engine.general.body import HALVINGS
from hknob_cli.scene.increments import halves, increment

# A gear that yields, over 2.2 ms: its mesh's fast mode decays by exp(-3000) in a sample, beside slow ones.
STIFF = np.array(
    [
        [0.0, 1.0, 0.0, 0.0],
        [0.0, -419.972326, -525.53933, -2438.50249],
        [0.0, 0.0, 0.0, 1.0],
        [0.0707926055, -419.769084, -527.795214, -2448.84456],
    ]
)
LONGER = np.finfo(np.longdouble).nmant >= 63  # digits, than a double has; else each doubling may lose a few


def exact(a: np.ndarray, t: float) -> np.ndarray:
    """The upper right block of the exponential of [[A, 1], [0, 0]] t."""
    n = len(a)
    block = mp.zeros(2 * n)
    for i in range(n):
        block[i, n + i] = mp.mpf(t)
        for j in range(n):
            block[i, j] = mp.mpf(float(a[i, j])) * mp.mpf(t)
    whole = mp.expm(block)
    return np.array([[whole[i, n + j] for j in range(n)] for i in range(n)])


@pytest.mark.skipif(not LONGER, reason="needs floats with more digits than a double's")
@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_increments_of_a_stiff_body_are_right_to_a_rounding(scale: float) -> None:
    """Half a unit of the last digit, and a thousandth of one for what doubling lost."""
    a = STIFF * np.array([[1.0], [scale], [1.0], [scale]])
    every = halves(a)
    assert every.shape == (HALVINGS, 4, 4)
    with mp.workdps(60):
        for t, found in [(1.0, every[0]), (0.125, every[3]), (0.37, increment(a, 0.37, 0.0, 0.0))]:
            wanted = exact(a, t)
            # A column is one rate's; what is nearly nothing beside the column's largest is right beside that.
            size = np.abs(wanted.astype(float)).max(axis=0)
            off = np.abs((found.astype(object) - wanted).astype(float)).max(axis=0)
            assert (off <= 0.501 * 2.0**-52 * size).all()
