"""A piece of the plane: all states centre + d + b, with d in a convex polygon and |b| <= blur, in the norm of the cell.

A piece is a row of numbers: blur, x, v of the centre, the least and the largest level that its next sample may read,
how many corners, and the corners d around, x and v in turn. The blur takes up every rounding, so that a piece never
loses a state.
"""

import math

from tests.verification.every_start.compiling import compiled
from tests.verification.every_start.outward import (
    add,
    divide,
    down,
    middle,
    multiply,
    point,
    reach,
    size,
    subtract,
    up,
)

BLUR, X, V, LOWEST, HIGHEST, CORNERS, FIRST = 0, 1, 2, 3, 4, 5, 6
MOST = 240  # corners
WIDTH = FIRST + 2 * MOST + 2


@compiled
def radius(piece, inverse_beta):
    """At least the norm of every d."""
    most = 0.0
    for i in range(FIRST, FIRST + 2 * int(piece[CORNERS]), 2):
        most = max(most, size(piece[i], piece[i + 1], inverse_beta))
    return most


@compiled
def contract(piece, power, inverse_beta):
    """Move every d by Phi^m, whose entries ``power`` encloses: the differences of states that read the same levels."""
    blur = 0.0
    for i in range(FIRST, FIRST + 2 * int(piece[CORNERS]), 2):
        x, v = point(piece[i]), point(piece[i + 1])
        at_x = add(
            multiply((power[0, 0, 0], power[0, 0, 1]), x),
            multiply((power[0, 1, 0], power[0, 1, 1]), v),
        )
        at_v = add(
            multiply((power[1, 0, 0], power[1, 0, 1]), x),
            multiply((power[1, 1, 0], power[1, 1, 1]), v),
        )
        piece[i], piece[i + 1] = middle(at_x), middle(at_v)
        blur = max(blur, size(reach(at_x, piece[i]), reach(at_v, piece[i + 1]), inverse_beta))
    piece[BLUR] = up(piece[BLUR] + blur)


@compiled
def angles(piece):
    """Bounds on x of all states of the piece; |x| of a state is at most its norm."""
    low, high = math.inf, -math.inf
    for i in range(FIRST, FIRST + 2 * int(piece[CORNERS]), 2):
        low, high = min(low, piece[i]), max(high, piece[i])
    return down(down(piece[X] + low) - piece[BLUR]), up(up(piece[X] + high) + piece[BLUR])


@compiled
def cut(piece, edge, side, part, inverse_beta):
    """Write into ``part`` a piece with every state of ``piece`` below the edge (side -1), or at and above it (side 1).

    A state centre + d + b is there only if d is there or within the blur of it: the polygon is cut that much beyond
    the edge. That line is a float, so that it is certain which corners are beyond it. Corners that the line makes are
    rounded, which adds to the blur. Returns whether anything is left.
    """
    gap = subtract(point(edge), point(piece[X]))
    line = up(gap[1] + piece[BLUR]) if side < 0 else down(gap[0] - piece[BLUR])
    count, corners, blur = 0, int(piece[CORNERS]), 0.0
    for i in range(corners):
        j = FIRST + 2 * i
        k = FIRST + 2 * ((i + 1) % corners)
        x, v, next_x, next_v = piece[j], piece[j + 1], piece[k], piece[k + 1]
        inside, next_inside = (x - line) * side >= 0.0, (next_x - line) * side >= 0.0
        if inside:
            part[FIRST + 2 * count], part[FIRST + 2 * count + 1] = x, v
            count += 1
        if inside != next_inside:
            share = divide(subtract(point(line), point(x)), subtract(point(next_x), point(x)))
            at = add(point(v), multiply(share, subtract(point(next_v), point(v))))
            part[FIRST + 2 * count], part[FIRST + 2 * count + 1] = line, middle(at)
            blur = max(blur, size(0.0, reach(at, middle(at)), inverse_beta))
            count += 1
    part[CORNERS] = count
    if not count:
        return False
    part[BLUR], part[X], part[V] = up(piece[BLUR] + blur), piece[X], piece[V]
    part[LOWEST], part[HIGHEST] = piece[LOWEST], piece[HIGHEST]
    if side < 0:
        part[HIGHEST] = edge - 1.0
    else:
        part[LOWEST] = edge
    if count > MOST - 1:
        enclose(part)
    recentre(part, inverse_beta)
    return True


@compiled
def recentre(piece, inverse_beta):
    """Move the centre into the middle of the corners, and the corners by as much the other way."""
    corners, mean_x, mean_v, blur = int(piece[CORNERS]), 0.0, 0.0, 0.0
    for i in range(FIRST, FIRST + 2 * corners, 2):
        mean_x += piece[i] / corners
        mean_v += piece[i + 1] / corners
    x, v = piece[X] + mean_x, piece[V] + mean_v
    by_x, by_v = subtract(point(x), point(piece[X])), subtract(point(v), point(piece[V]))
    piece[X], piece[V] = x, v
    for i in range(FIRST, FIRST + 2 * corners, 2):
        at_x, at_v = subtract(point(piece[i]), by_x), subtract(point(piece[i + 1]), by_v)
        piece[i], piece[i + 1] = middle(at_x), middle(at_v)
        blur = max(blur, size(reach(at_x, piece[i]), reach(at_v, piece[i + 1]), inverse_beta))
    piece[BLUR] = up(piece[BLUR] + blur)


@compiled
def enclose(piece):
    """Put the rectangle around its corners in the place of a polygon that has too many."""
    low_x, high_x, low_v, high_v = math.inf, -math.inf, math.inf, -math.inf
    for i in range(FIRST, FIRST + 2 * int(piece[CORNERS]), 2):
        low_x, high_x = min(low_x, piece[i]), max(high_x, piece[i])
        low_v, high_v = min(low_v, piece[i + 1]), max(high_v, piece[i + 1])
    rectangle(piece, low_x, high_x, low_v, high_v)


@compiled
def rectangle(piece, low_x, high_x, low_v, high_v):
    """Let the polygon be a rectangle."""
    piece[CORNERS] = 4
    piece[FIRST], piece[FIRST + 1] = low_x, low_v
    piece[FIRST + 2], piece[FIRST + 3] = high_x, low_v
    piece[FIRST + 4], piece[FIRST + 5] = high_x, high_v
    piece[FIRST + 6], piece[FIRST + 7] = low_x, high_v
