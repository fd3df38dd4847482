"""Numbers between two, on a log scale."""

from collections.abc import Iterable
from math import isfinite


def log_between(first: float, last: float, shares: Iterable[float]) -> list[float]:
    """Numbers at ``shares``, 0 to 1, of the way from ``first`` to ``last``, both > 0, on a log scale.

    One by one by the C library's power: that of arrays depends on the processor, and on where in one a number is.
    """
    ratio = last / first
    if isfinite(ratio) and ratio > 0.0:
        return [first * ratio**share for share in shares]
    return [first ** (1.0 - share) * last**share for share in shares]  # further apart than floats reach
