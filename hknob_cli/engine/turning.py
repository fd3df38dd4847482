"""Turning points: where the velocity vanishes inside a hold, in closed form, and peaks of bounces off the wall.

Inside a hold the velocity is v(t) = e^(-a t) [v0 cos wt + ((y0 - a v0)/w) sin wt], a = alpha/2, w^2 = beta - a^2.
A bounce is a peak of the sampled knob's angle outside the wall, between samples.
"""

from math import atan, log1p, pi, sqrt
from typing import NamedTuple

from hknob_cli.engine.loop import interval, level_of, push
from hknob_cli.engine.propagator import hold_coefficients


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


class Hold(NamedTuple):
    """A hold of the command, from the time ``clock`` at ``(x, v)``, for ``span`` under the acceleration ``drive``.

    ``after``: the velocity at its end.
    """

    clock: float
    x: float
    v: float
    after: float
    drive: float
    span: float


def hold_peaks(hold, spacing, found, loop, times, peaks):
    """Append the maxima of one hold that lie outside the wall to ``times`` and ``peaks``; the new count.

    ``spacing``: the time between turning points of the free motion.
    """
    clock, x, v, after, drive, span = hold
    if spacing >= span and not (v > 0.0 and after <= 0.0):
        return found
    y = drive - loop.beta * x
    at = first_zero(v, y, loop.alpha, loop.beta)
    if spacing >= span:
        at = min(at, span)
    elif v < 0.0 or (v == 0.0 and y < 0.0):
        at += spacing
    while at <= span:
        s, g, _ = hold_coefficients(loop.alpha, loop.beta, at)
        top = x + (s * v + g * y)
        if level_of(top, loop.sense) == 0.0 and found < len(times):
            times[found], peaks[found] = clock + at, top
            found += 1
        at += 2.0 * spacing
    return found


def bounce_peaks(x, v, ring, samples, loop, times, peaks):
    """Peaks outside the wall over ``samples`` samples from ``(x, v)``, after the wall was first touched.

    ``ring``: delay line, all levels 0, used up. Writes the time of each peak, in samples from the first, to ``times``
    and its position, in counts, to ``peaks``; returns their number, which the length of ``times`` bounds.
    """
    delay = len(ring)
    spacing = zero_spacing(loop.alpha, loop.beta)
    head, found, touched = 0, 0, False
    for i in range(samples):
        level = level_of(x, loop.sense)
        touched = touched or level < 0.0
        older, newer = push(level, ring, head, loop)
        if delay > 0:
            head = (head + 1) % delay
        after, speed = interval(x, v, older, newer, loop)
        if touched:
            middle, pace = x, v
            if loop.split > 0.0:
                y = older - loop.beta * x
                middle, pace = x + (loop.s1 * v + loop.g1 * y), loop.f1 * v + loop.s1 * y
                first = Hold(i + 0.0, x, v, pace, older, loop.split)
                found = hold_peaks(first, spacing, found, loop, times, peaks)
            second = Hold(i + loop.split, middle, pace, speed, newer, 1.0 - loop.split)
            found = hold_peaks(second, spacing, found, loop, times, peaks)
        x, v = after, speed
    return found
