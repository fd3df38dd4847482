"""Clock phases of one start, as intervals that are followed as balls, and halved where a ball meets a count edge.

Before the first sample the knob moves freely: s(phi) = s(0) + an integral of its rate, and the difference of two such
states a time h apart is what the free motion makes of s(h) - s(0), which by the norm is at most h times the norm of
the first rate. So phases within h of one are a ball around it.
"""

import math

import numpy as np

from tests.verification.every_start.compiling import compiled
from tests.verification.every_start.follow import ALL, DEEP, UNKNOWN, captor, levels, step
from tests.verification.every_start.outward import add, down, middle, multiply, point, reach, size, up
from tests.verification.every_start.polygon import BLUR, HIGHEST, LOWEST, V, X

TERMS = 80  # of the series of the free motion
LARGEST = 8.0  # row sum of A for which they are enough


@compiled
def flight(piece, start, rate, flow, phase, inverse_beta):
    """Put the centre at the state a ``phase`` of a sample after ``start``.

    The series of the free motion: its first term is the ``rate`` at the start times the phase, each next one A times
    the phase over its number times the last. ``start``, ``rate`` and the entries of A, ``flow``, are enclosed. By the
    row sums of A, at most LARGEST, terms fall by more than half at the end: all that are left out are at most twice
    the first of them.
    """
    x, v = (start[0, 0], start[0, 1]), (start[1, 0], start[1, 1])
    dx = multiply((rate[0, 0], rate[0, 1]), point(phase))
    dv = multiply((rate[1, 0], rate[1, 1]), point(phase))
    for n in range(2, TERMS + 1):
        x, v = add(x, dx), add(v, dv)
        share = (down(phase / n), up(phase / n))
        next_v = add(multiply((flow[0, 0], flow[0, 1]), dx), multiply((flow[1, 0], flow[1, 1]), dv))
        dx, dv = multiply(dv, share), multiply(next_v, share)
    rest = 2.1 * max(abs(dx[0]), abs(dx[1]), abs(dv[0]), abs(dv[1]))
    x, v = add(x, (-rest, rest)), add(v, (-rest, rest))
    piece[X], piece[V] = middle(x), middle(v)
    piece[BLUR] = size(reach(x, piece[X]), reach(v, piece[V]), inverse_beta)


@compiled
def halve(stack, count, start, rate, flow, powers, drives, shrinking, inverse_beta, table, shares, least):
    """Follow the ``count`` intervals of phases on the stack, the last first.

    Returns why it ended, how many are left, how many were followed, the phases that are undecided, as intervals not
    wider than ``least``; and the state of an interval that no known orbit captured. ``shares`` counts phases by
    orbit.
    """
    undecided, pieces = 0.0, 0
    first = size(max(abs(rate[0, 0]), abs(rate[0, 1])), max(abs(rate[1, 0]), abs(rate[1, 1])), inverse_beta)
    piece = np.zeros(8)
    while count > 0:
        if count + 1 >= len(stack):
            raise ValueError("too many intervals wait")
        low, high = stack[count - 1]  # multiples of a power of two: sums and halves of them are exact
        half, phase = 0.5 * (high - low), 0.5 * (high + low)
        flight(piece, start, rate, flow, phase, inverse_beta)
        wide, before, owner, clear = up(half * first), 0.0, -1, True
        piece[LOWEST], piece[HIGHEST] = DEEP, 0.0
        for n in range(len(shrinking)):
            around = up(up(wide * shrinking[n]) + piece[BLUR])
            lowest, highest = levels(down(piece[X] - around), up(piece[X] + around), piece)
            if lowest < highest:
                clear = False
                break
            if lowest < before or n % 64 == 63:
                owner = captor(piece[X], piece[V], around, table, inverse_beta)
                if owner >= 0:
                    break
            before = lowest
            if -lowest >= len(drives):
                raise ValueError("a level that no torque is kept for")
            step(piece, powers[1], drives[-int(lowest)], inverse_beta)
        pieces += 1
        if owner >= 0:
            shares[owner] += high - low
            count -= 1
        elif clear:
            return UNKNOWN, count, pieces, undecided, piece[X], piece[V]
        elif high - low <= least:
            undecided += high - low
            count -= 1
        else:
            stack[count - 1, 0], stack[count - 1, 1] = low, phase
            stack[count, 0], stack[count, 1] = phase, high
            count += 1
    return ALL, count, pieces, undecided, math.nan, math.nan
