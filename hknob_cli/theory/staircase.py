"""The describing function of the whole quantised wall, a staircase that begins at an edge, under its push.

Of a motion x0 + A sin(wt) the wall gives a mean and a fundamental. The mean carries push and hand's spring, which sets
x0; the fundamental keeps the motion up (the dual-input describing function of Gelb & Vander Velde 1968, ch. 6). Each
edge e with a torque step h below it adds a mean h (1/2 + asin(d)/pi) and a gain 2 h sqrt(1 - d^2)/(pi A), where
d = (e - x0)/A is within -1 to 1. The wall has no memory, so that the pitch is that of one relay
(`relay.describing_function`). Angles are in counts, times in samples, torques accelerations.
"""

from math import floor, pi
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.loop import Loop

MOST_COUNTS = 1000.0  # amplitude; larger motions are not looked for
_LEAST = 1e-2  # counts
_FINER = 1.08  # of neighbours on the grid of amplitudes
_STEPS = 50  # of a bisection


class Swing(NamedTuple):
    """A motion that the wall keeps up: amplitude (half of peak to peak) and mean, in counts."""

    amplitude: float
    mean: float


def mean_and_gain(loop: Loop, amplitude: float, mean: float) -> tuple[float, float]:
    """Mean torque of the wall, and its fundamental over the amplitude, of the motion mean + amplitude sin."""
    first = 0.0 if loop.sense > 0.0 else -1.0
    deepest = max(0, floor(first - (mean - amplitude)) + 1)
    edges = first - np.arange(deepest)
    steps = np.full(deepest, loop.kappa)
    steps[:1] *= 1.0 - loop.offset
    d = np.clip((edges - mean) / amplitude, -1.0, 1.0)
    whole = float((steps * (0.5 + np.arcsin(d) / pi)).sum())
    return whole, float((steps * np.sqrt(1.0 - d * d)).sum()) * 2.0 / (pi * amplitude)


def balanced(loop: Loop, amplitude: float) -> float:
    """Mean of the motion at which the wall carries push and spring; its torque falls with the mean, theirs rises."""
    low, high = -amplitude - loop.gamma / loop.kappa - 2.0, amplitude + 1.0
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        if mean_and_gain(loop, amplitude, middle)[0] > loop.gamma + loop.beta * middle:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def swings(loop: Loop, response: float) -> list[Swing]:
    """Motions with ``response`` times the wall's gain = 1, smallest first, ``response`` the plant's at their pitch.

    Only those where the gain falls as the motion grows: the others do not last.
    """

    def spare(amplitude: float) -> float:
        return response * mean_and_gain(loop, amplitude, balanced(loop, amplitude))[1] - 1.0

    found = []
    low, before = _LEAST, spare(_LEAST)
    while low < MOST_COUNTS:
        high = low * _FINER
        after = spare(high)
        if before > 0.0 >= after:
            first, last = low, high
            for _ in range(_STEPS):
                middle = 0.5 * (first + last)
                first, last = (middle, last) if spare(middle) > 0.0 else (first, middle)
            found.append(Swing(0.5 * (first + last), balanced(loop, 0.5 * (first + last))))
        low, before = high, after
    return found
