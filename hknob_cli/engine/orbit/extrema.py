"""Peaks and troughs of the motion between samples, all of them, in closed form.

The zeros of the velocity are known (`engine.turning`). Holds shorter than half a ringing period hold at most one, and
do exactly when the velocity changes sign; longer ones may hold many.
"""

from math import ceil

from hknob_cli.engine.orbit.holds import LENGTH, PART
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing

MOST_TURNS = 1e7  # of a period: a second of compiled code, and of a knob that rings millions of times in an interval


def direction(x, v, drive, beta):
    """Which way the knob moves just after it was at ``(x, v)`` under a ``drive``: 1, -1, or 0 if it stays."""
    if v == 0.0:
        v = drive - beta * x
    return 1 if v > 0.0 else (-1 if v < 0.0 else 0)


def turns_within(first, span, spacing, odd):
    """Number of turning points in a hold of length ``span``: at ``first``, and one every ``spacing`` after it.

    The directions at both ends fix whether it is ``odd`` (0 or 1); rounding can only move a zero at the very end.
    """
    if spacing >= span:
        return odd
    count = ceil((span - first) / spacing) if first < span else 0
    if count % 2 != odd:
        count += 1 if (first + count * spacing) - span < span - (first + (count - 1) * spacing) else -1
    return max(0, count)


def find_extrema(holds, count, parts, kinds, alpha, beta, reference):
    """All local maxima and minima of a period of ``count`` holds, relative to ``reference``.

    Returns ``(peaks, sum of peaks, highest, troughs, sum of troughs, lowest)``; no peaks where nothing moves, or where
    there are more than `MOST_TURNS`.
    """
    x, v, drive = holds
    spacing = zero_spacing(alpha, beta)
    if count > MOST_TURNS * kinds * spacing:
        return 0, 0.0, 0.0, 0, 0.0, 0.0
    peaks, peak_sum, highest = 0, 0.0, -float("inf")
    troughs, trough_sum, lowest = 0, 0.0, float("inf")
    # A knob that stays where it is for a hold moves as it did before; so does the first hold of a period.
    first, last = direction(x[0], v[0], drive[0], beta), count
    while first == 0 and last > 0:
        last -= 1
        first = direction(x[last], v[last], drive[last], beta)
    going = first
    base, other = 0, (kinds - 1) * PART
    for i in range(count):
        following = first
        if i + 1 < count:
            following = direction(x[i + 1], v[i + 1], drive[i + 1], beta)
            following = going if following == 0 else following
        span = parts[base + LENGTH]
        base = other - base
        odd = 1 if following != going else 0
        # One that stays where it is does not ring.
        apart = float("inf") if direction(x[i], v[i], drive[i], beta) == 0 else spacing
        if odd == 1 or apart < span:
            y = drive[i] - beta * x[i]
            at = first_zero(v[i], y, alpha, beta)
            up = going > 0
            for turn in range(turns_within(at, span, apart, odd)):
                # Not ``turn * spacing`` alone: an infinite spacing times 0 is no number.
                t = min(at + turn * spacing, span) if turn > 0 else min(at, span)
                s, g, _ = hold_coefficients(alpha, beta, t)
                turned = (x[i] - reference) + (s * v[i] + g * y)
                if up:
                    peaks += 1
                    peak_sum += turned
                    highest = max(highest, turned)
                else:
                    troughs += 1
                    trough_sum += turned
                    lowest = min(lowest, turned)
                up = not up
        going = following
    return peaks, peak_sum, highest, troughs, trough_sum, lowest
