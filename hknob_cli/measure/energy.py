"""Energy over one period: what the virtual wall puts in, and what the damping takes out.

On a limit cycle the two are equal (bias and hand stiffness return what they take); they are computed independently, so
that their difference checks the orbit and its integrals.
"""

import numpy as np

from hknob_cli.measure.moments import Moments
from hknob_cli.measure.period import Period


def wall_work(period: Period) -> float:
    """Work of the wall torque over one period, in units of J (counts per sample)²: sum of torque times displacement.

    The mean torque does no work over a period; without it the sum keeps its digits however deep the knob is pushed.
    """
    loop = period.loop
    gain = np.empty((2, len(period.drive)))
    for kind in period.kinds:
        at = period.duration == kind
        if kind == loop.split:
            gain[:, at] = [[loop.s1], [loop.g1]]
        else:
            gain[:, at] = [[loop.s2], [loop.g2]]
    moved = gain[0] * period.v[:-1] + gain[1] * (period.drive - loop.beta * period.x[:-1])
    return float(((period.drive - period.drive.mean()) * moved).sum())


def damping_loss(period: Period, moments: Moments) -> float:
    """Energy that the damping dissipates over one period, in the same unit."""
    return period.loop.alpha * moments.speed
