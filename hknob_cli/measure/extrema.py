"""Peaks and troughs of the motion between samples, all of them, in closed form.

The zeros of the velocity are known (`engine.turning`). Holds shorter than half a ringing period hold at most one, and
do exactly when the velocity changes sign; longer ones may hold many.
"""

from math import ceil
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing
from hknob_cli.measure.period import Array, Period


class Extrema(NamedTuple):
    """Local maxima and minima of one period, in counts relative to ``reference``, in time order of each kind."""

    reference: float
    maxima: Array
    minima: Array


def _signs(period: Period) -> Array:
    """Direction of motion just after the start of each hold, and of the next period; never 0 while it moves."""
    loop = period.loop
    sign = np.sign(period.v[:-1])
    still = np.flatnonzero(sign == 0.0)
    for i in still:
        sign[i] = np.sign(period.drive[i] - loop.beta * period.x[i])
    for i in still:
        if sign[i] == 0.0:
            sign[i] = sign[i - 1]
    return np.append(sign, sign[0])


def find_extrema(period: Period) -> Extrema:
    """All local maxima and minima of one period."""
    loop = period.loop
    alpha, beta = loop.alpha, loop.beta
    reference = float(np.mean(period.x[:-1]))
    sign = _signs(period)
    spacing = zero_spacing(alpha, beta)
    many = spacing < max(period.kinds)
    holds = range(len(period.drive)) if many else np.flatnonzero(sign[:-1] != sign[1:])
    highs: list[float] = []
    lows: list[float] = []
    for i in holds:
        x, v, span = float(period.x[i]), float(period.v[i]), float(period.duration[i])
        y = float(period.drive[i]) - beta * x
        turns = sign[i] != sign[i + 1]
        t = first_zero(v, y, alpha, beta)
        if spacing >= span:
            times = [min(t, span)] if turns else []
        else:
            count = max(0, ceil((span - t) / spacing)) if t < span else 0
            # The directions at both ends fix whether the count is odd; rounding can only move a zero at the very end.
            if count % 2 != turns:
                count += 1 if (t + count * spacing) - span < span - (t + (count - 1) * spacing) else -1
            times = [min(t + k * spacing, span) for k in range(max(count, 0))]
        up = sign[i] > 0.0
        for at in times:
            s, g, _ = hold_coefficients(alpha, beta, at)
            (highs if up else lows).append((x - reference) + (s * v + g * y))
            up = not up
    return Extrema(reference=reference, maxima=np.array(highs), minima=np.array(lows))
