"""Pieces of the plane, followed from sample to sample until proven orbits capture them; cut where they meet an edge."""

import math

from tests.verification.every_start.compiling import compiled
from tests.verification.every_start.outward import add, down, middle, multiply, point, reach, size, up
from tests.verification.every_start.polygon import (
    BLUR,
    HIGHEST,
    LOWEST,
    V,
    X,
    angles,
    contract,
    cut,
    radius,
)

ALL, UNKNOWN, STOPPED = (
    0,
    1,
    2,
)  # why following ended: all pieces are captured; one is in no known orbit; enough for now
DEEP = -1e9  # below every level


@compiled
def step(piece, phi, drive, inverse_beta):
    """Move the centre by one sample whose torque adds ``drive``; its rounding goes into the blur."""
    x, v = point(piece[X]), point(piece[V])
    at_x = add(
        add(multiply((phi[0, 0, 0], phi[0, 0, 1]), x), multiply((phi[0, 1, 0], phi[0, 1, 1]), v)),
        (drive[0, 0], drive[0, 1]),
    )
    at_v = add(
        add(multiply((phi[1, 0, 0], phi[1, 0, 1]), x), multiply((phi[1, 1, 0], phi[1, 1, 1]), v)),
        (drive[1, 0], drive[1, 1]),
    )
    piece[X], piece[V] = middle(at_x), middle(at_v)
    piece[BLUR] = up(piece[BLUR] + size(reach(at_x, piece[X]), reach(at_v, piece[V]), inverse_beta))


@compiled
def captor(x, v, wide, table, inverse_beta):
    """The orbit that keeps every state within ``wide`` of (x, v), or -1.

    A row of ``table`` is a sample of a proven orbit: x, v, what it may be off by, the orbit's margin, its number. All
    those states are nearer to it than the margin, so they read what it reads, now and for ever.
    """
    for i in range(len(table)):
        dx, dv = up(abs(x - table[i, 0])), up(abs(v - table[i, 1]))
        if up(up(size(dx, dv, inverse_beta) + table[i, 2]) + wide) < table[i, 3]:
            return int(table[i, 4])
    return -1


@compiled
def levels(low, high, piece):
    """Least and largest level that states with angles from ``low`` to ``high`` read, of those that the piece may
    read."""
    return max(min(math.floor(low), 0.0), piece[LOWEST]), min(min(math.floor(high), 0.0), piece[HIGHEST])


@compiled
def follow(stack, count, powers, drives, inverse_beta, table, captured, patience, most):
    """Follow the ``count`` pieces of the stack, the last first.

    Returns why it ended, how many pieces are left, how many were cut, and samples. UNKNOWN: the last piece of the
    stack was neither cut nor captured in ``patience`` samples. ``captured`` counts pieces by orbit.
    """
    cuts, samples = 0, 0
    while count > 0:
        if samples > most or count + 1 >= len(stack):
            return STOPPED, count, cuts, samples
        piece = stack[count - 1].copy()
        wide, turns, before, is_open = radius(piece, inverse_beta), 0, 0.0, True
        for n in range(patience):
            around = up(wide + piece[BLUR])
            lowest, highest = levels(down(piece[X] - around), up(piece[X] + around), piece)
            # the polygon itself is looked at where its ball meets an edge, and where it may be captured
            deeper = highest < before or n % 64 == 63
            before = highest
            if (lowest < highest or deeper) and turns > 0:
                contract(piece, powers[turns], inverse_beta)
                wide, turns = radius(piece, inverse_beta), 0
            if lowest < highest:
                low, high = angles(piece)
                lowest, highest = levels(low, high, piece)
            if lowest > highest:  # no state has a level that this part was made for: it is empty
                is_open, count = False, count - 1
                break
            if lowest < highest:
                edge = lowest + 1.0 + math.floor(0.5 * (highest - lowest - 1.0))
                count -= 1
                for side in (-1, 1):
                    if cut(piece, edge, side, stack[count], inverse_beta):
                        count += 1
                is_open, cuts = False, cuts + 1
                break
            if deeper:
                owner = captor(piece[X], piece[V], up(wide + piece[BLUR]), table, inverse_beta)
                if owner >= 0:
                    captured[owner] += 1
                    is_open, count = False, count - 1
                    break
            if -lowest >= len(drives):
                raise ValueError("a level that no torque is kept for")
            step(piece, powers[1], drives[-int(lowest)], inverse_beta)
            piece[LOWEST], piece[HIGHEST] = DEEP, 0.0
            turns, samples = turns + 1, samples + 1
            if turns == len(powers) - 1:
                contract(piece, powers[turns], inverse_beta)
                wide, turns = radius(piece, inverse_beta), 0
        if is_open:
            if turns > 0:
                contract(piece, powers[turns], inverse_beta)
            stack[count - 1] = piece
            return UNKNOWN, count, cuts, samples
    return ALL, count, cuts, samples
