"""The describing function of the whole quantised wall, and of a lag that is bounded by one count.

Of a motion x0 + A sin(wt) the wall gives a mean and a fundamental. The mean carries push and hand's spring, which sets
x0; the fundamental keeps the motion up (the dual-input describing function of Gelb & Vander Velde 1968, ch. 6). Each
edge e with a torque step h below it adds a mean h (1/2 + asin(d)/pi) and a gain 2 h sqrt(1 - d^2)/(pi A), where
d = (e - x0)/A is within -1 to 1. The wall has no memory, so that the pitch is that of one relay
(`relay.describing_function`). Angles are in counts, times in samples, torques accelerations.

A bounded lag keeps a part of a step and gives the rest late. Within one count the law is the lag K (keep tau s +
1)/(tau s + 1). At the frequency w of the buzz it acts as a spring K (1 + keep tau^2 w^2)/(1 + tau^2 w^2) and as a
damper -(1 - keep) K tau/(1 + tau^2 w^2), which is below 0: the lag drives, and works only while w tau is large. The
quantizer turns K into a gain G that falls with the amplitude. With G keep well above the hand's stiffness and w tau
well above 1, w^2 = G keep/J, and the buzz is where the loss of the sample's delay and of the lag is the damping b:

    G keep T/2 + (1 - keep) J/(keep tau) = b.

So G = (2 b/(keep T)) (1 - r (1 - keep)/keep) with r = J/(b tau); the plain wall's (keep = 1) is 2 b/T, and the
amplitude goes as 1/G. The buzz is smaller than the plain wall's for r < keep < 1, smallest at keep = 2 r/(1 + r), where
it is (1 + r)^2/(4 r) times smaller. Below keep = r/(1 + r) the lag drives a slow oscillation of its own; from r = 1 on
no lag makes the buzz smaller. Sample delay, friction and the hand's stiffness are left out: the last helps.
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


def slowness(*, inertia_kg_m2: float, damping_nm_s_per_rad: float, time_constant_s: float) -> float:
    """Time J/b in which knob and hand lose their speed, over that of the lag; infinite without damping."""
    loss = damping_nm_s_per_rad * time_constant_s
    return inertia_kg_m2 / loss if loss > 0.0 else float("inf")


def best_keep(r: float) -> float:
    """Part of a step that leaves the smallest buzz; 1, the plain wall, where none makes it smaller."""
    return 2.0 * r / (1.0 + r) if r < 1.0 else 1.0
