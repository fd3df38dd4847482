"""Bounces of the sampled knob off the wall: the peaks of its angle outside, between samples, in closed form."""

from typing import NamedTuple

from hknob_cli.engine.loop import interval, level_of, push
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing


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
