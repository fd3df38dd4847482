"""Turning points: where the velocity vanishes inside a hold, in closed form.

Inside a hold the velocity is v(t) = e^(-a t) [v0 cos wt + ((y0 - a v0)/w) sin wt], a = alpha/2, w^2 = beta - a^2.
"""

from math import atan, log1p, pi, sqrt


def first_zero(v, y, alpha, beta):
    """Time of the first zero of the velocity after a start at ``v`` with ``y = drive - beta x``; inf if none.

    Zero velocity at the start does not count.
    """
    a = 0.5 * alpha
    rate = y - a * v
    slows = v > 0.0 > rate or v < 0.0 < rate  # not told from the quotient, which underflows
    square = beta - a * a
    if square > 0.0:
        w = sqrt(square)
        if rate == 0.0:
            return 0.5 * pi / w
        t = atan(-v * w / rate) / w
        return t if slows else t + pi / w
    if not slows:
        return float("inf")
    z = -v / rate
    r = sqrt(-square)
    if r == 0.0:
        return z
    if r * z >= 1.0:
        return float("inf")
    return (log1p(r * z) - log1p(-r * z)) / (2.0 * r)


def zero_spacing(alpha, beta):
    """Time between zeros of the velocity under a constant drive: half a ringing period; inf if it does not ring."""
    square = beta - 0.25 * alpha * alpha
    return pi / sqrt(square) if square > 0.0 else float("inf")
