"""One period of an orbit as a row of holds: the motion that every measure is taken from."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.loop import Loop

Array = NDArray[np.float64]


class Period(NamedTuple):
    """Holds of one period in time order; ``m`` holds, dimensionless (counts, sample periods).

    ``x``, ``v``: state at the start of each hold and, last, at the end of the period (m + 1). ``drive``: the constant
    acceleration in each (m). ``duration``: its length (m), whole samples unless a fractional delay splits them.
    ``kinds``: the distinct lengths.
    """

    loop: Loop
    samples: int
    x: Array
    v: Array
    drive: Array
    duration: Array
    kinds: tuple[float, ...]


def split_holds(loop: Loop, xs: Array, vs: Array, older: Array, newer: Array) -> Period:
    """Holds of a traced period (see `engine.trace.trace`): one per sample, or two where the delay splits it."""
    n = len(newer)
    if loop.split == 0.0:
        return Period(loop=loop, samples=n, x=xs, v=vs, drive=newer, duration=np.ones(n), kinds=(1.0,))
    y = older - loop.beta * xs[:-1]
    x = np.empty(2 * n + 1)
    v = np.empty(2 * n + 1)
    x[0::2], v[0::2] = xs, vs
    x[1::2] = xs[:-1] + (loop.s1 * vs[:-1] + loop.g1 * y)
    v[1::2] = loop.f1 * vs[:-1] + loop.s1 * y
    drive = np.empty(2 * n)
    drive[0::2], drive[1::2] = older, newer
    kinds = (loop.split, 1.0 - loop.split)
    return Period(loop=loop, samples=n, x=x, v=v, drive=drive, duration=np.tile(kinds, n), kinds=kinds)
