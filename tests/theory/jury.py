"""Jury's criterion (1964): from a polynomial's coefficients, whether its roots lie inside the unit circle."""

import numpy as np


def stable_by_jury(polynomial: np.ndarray) -> bool:
    """Of a polynomial in z, the highest power first: each row of his table takes a power off it."""
    row = np.trim_zeros(np.asarray(polynomial, dtype=float), "f")
    while len(row) > 1:
        row = row * np.sign(row[0])
        if abs(row[-1]) >= row[0]:
            return False
        row = (row[0] * row - row[-1] * row[::-1])[:-1]
        row = row / np.abs(row).max()
    return True
