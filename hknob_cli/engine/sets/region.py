"""Convex regions of states, and a region around all that the loop may make of one in a sample.

A wall that reads its encoder differs from one that knows the angle by less than one count of torque. So from
sample to sample a region is bent once, along the line where the wall begins, and shifted by a bounded amount; what
comes out is enclosed in a convex region again, with few corners and with all roundings.
"""

from math import sqrt
from typing import NamedTuple

from hknob_cli.engine.certificate import EPSILON, distance
from hknob_cli.engine.loop import interval
from hknob_cli.engine.sets.polygon import clip, put_box


class Goal(NamedTuple):
    """How far a region is moved on: for ``samples``, or until it lies within ``target`` or beyond ``ceiling`` of 0."""

    samples: int
    target: float
    ceiling: float


def sort_points(points, count):
    """Sort points, x and v of each, flat, by x and then by v; in place (Shell's method)."""
    gap = count // 2
    while gap > 0:
        for k in range(gap, count):
            x, v = points[2 * k], points[2 * k + 1]
            j = k
            while j >= gap and (
                points[2 * (j - gap)] > x or (points[2 * (j - gap)] == x and points[2 * (j - gap) + 1] > v)
            ):
                points[2 * j], points[2 * j + 1] = points[2 * (j - gap)], points[2 * (j - gap) + 1]
                j -= gap
            points[2 * j], points[2 * j + 1] = x, v
        gap = gap // 2


def turn(points, a, b, x, v):
    """Twice the area of the triangle of points ``a`` and ``b`` and ``(x, v)``: positive where it turns left."""
    ax, av = points[2 * a], points[2 * a + 1]
    return (points[2 * b] - ax) * (v - av) - (points[2 * b + 1] - av) * (x - ax)


def enclose(points, count, dx, dv, chain, out):
    """The convex hull of points, grown by the rectangle of half sides ``dx`` and ``dv``, to ``out``; its corners.

    ``points`` are sorted in place. A corner goes with the corner of the rectangle that lies on its side, those between
    two sides with both; so there are four corners more than the hull has. Andrew's method; what its rounding leaves out
    lies within 16 ``count`` units in the last place of the hull, in x and in v.
    """
    sort_points(points, count)
    total = 0
    for side in range(2):
        # First the lower half from left to right, then the upper half back.
        sign = 1.0 if side == 0 else -1.0
        kept = 0
        for i in range(count):
            k = i if side == 0 else count - 1 - i
            x, v = points[2 * k], points[2 * k + 1]
            while kept > 1 and turn(chain, kept - 2, kept - 1, x, v) <= 0.0:
                kept -= 1
            chain[2 * kept], chain[2 * kept + 1] = x, v
            kept += 1
        end = 0
        for k in range(1, kept):
            if sign * chain[2 * k + 1] < sign * chain[2 * end + 1]:
                end = k
        for k in range(kept):
            if k <= end:
                out[2 * total], out[2 * total + 1] = chain[2 * k] - sign * dx, chain[2 * k + 1] - sign * dv
                total += 1
            if k > end or (k == end and dx > 0.0):
                out[2 * total], out[2 * total + 1] = chain[2 * k] + sign * dx, chain[2 * k + 1] - sign * dv
                total += 1
        if dx == 0.0 and kept > 1:
            total -= 1  # the other half begins where this one ends
    return total


def drop_side(points, count, k):
    """Where the neighbours of side ``k`` of a convex polygon meet outside it, and the area that adds: ``(area, x, v)``.

    Infinite where they do not meet, or where rounding leaves open that the polygon lies within.
    """
    before, far, beyond = (k - 1) % count, (k + 1) % count, (k + 2) % count
    bx, bv = points[2 * k], points[2 * k + 1]
    ux, uv = bx - points[2 * before], bv - points[2 * before + 1]
    cx, cv = points[2 * far], points[2 * far + 1]
    wx, wv = cx - points[2 * beyond], cv - points[2 * beyond + 1]
    across = ux * wv - uv * wx
    if not across < 0.0:
        return float("inf"), 0.0, 0.0
    along = ((cx - bx) * wv - (cv - bv) * wx) / across
    if not 0.0 <= along < 1e6:
        return float("inf"), 0.0, 0.0
    along = along * (1.0 + 1e-9)
    x, v = bx + along * ux, bv + along * uv
    # The far corner of the side must lie within the triangle, too.
    dx, dv = points[2 * beyond], points[2 * beyond + 1]
    if not (dx - x) * (cv - v) - (dv - v) * (cx - x) >= 0.0:
        return float("inf"), 0.0, 0.0
    return abs((cx - bx) * (v - bv) - (cv - bv) * (x - bx)), x, v


def simplify(points, count, most, areas):
    """Drop sides of a convex polygon, in place, those that add the least area, until ``most`` are left; its corners.

    ``areas``: work space, a number a side.
    """
    if count > most:
        for k in range(count):
            areas[k], _, _ = drop_side(points, count, k)
    while count > most:
        at = 0
        for k in range(1, count):
            if areas[k] < areas[at]:
                at = k
        if areas[at] == float("inf"):
            return count
        _, x, v = drop_side(points, count, at)
        points[2 * at], points[2 * at + 1] = x, v
        gone = (at + 1) % count
        for k in range(gone, count - 1):
            points[2 * k], points[2 * k + 1], areas[k] = points[2 * k + 2], points[2 * k + 3], areas[k + 1]
        count -= 1
        if gone < at:
            at -= 1
        for k in range(-2, 2):
            near = (at + k) % count
            areas[near], _, _ = drop_side(points, count, near)
    return count


def simplify_hull(points, count, most, chain, out):
    """A convex polygon with at most ``most`` corners, or few more, around points, to ``out``; its corners."""
    return simplify(out, enclose(points, count, 0.0, 0.0, chain, out), most, chain)


def advance(region, count, most, limits, room, loop):
    """The region one sample later, in place; its number of corners.

    ``limits``: position where the wall begins; least and largest push outside it; least and largest push inside beside
    that of a wall that knows the angle; stiffness of a spring outside. What lies near the wall's edge, within the bound
    on rounding, goes both ways.
    """
    edge = limits[0]
    cloud, chain = room.cloud, room.chain
    far, fast = abs(edge), 0.0
    for k in range(count):
        far, fast = max(far, abs(region[2 * k])), max(fast, abs(region[2 * k + 1]))
    reach = 64.0 * EPSILON * count * far
    total = 0
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        kept = clip(region, count, edge - sign * reach, sign, chain, 0)
        stiffness = limits[5] if side == 0 else loop.kappa
        low, high = limits[1 + 2 * side], limits[2 + 2 * side]
        for k in range(kept):
            x, v = chain[2 * k], chain[2 * k + 1]
            cloud[2 * total], cloud[2 * total + 1] = interval(x, v, 0.0, low - stiffness * x, loop)
            total += 1
            if high > low:
                cloud[2 * total], cloud[2 * total + 1] = interval(x, v, 0.0, high - stiffness * x, loop)
                total += 1
    most_push = max(-limits[1], limits[2], -limits[3], limits[4])
    pull = most_push + (max(loop.kappa, limits[5]) + loop.beta) * far
    next_far, next_fast = 0.0, 0.0
    for k in range(total):
        next_far, next_fast = max(next_far, abs(cloud[2 * k])), max(next_fast, abs(cloud[2 * k + 1]))
    # Rounding of the motion, as `ball.step_error` has it, and of both hulls and the corners dropped between them.
    dx = EPSILON * (8.0 * far + 48.0 * (fast + pull) + 64.0 * total * next_far)
    dv = EPSILON * (48.0 * (fast + pull) + 64.0 * total * next_fast)
    kept = simplify_hull(cloud, total, most, chain, room.rough)
    return enclose(room.rough, kept, dx, dv, chain, region)


def trace_back(region, count, most, limits, room, loop):
    """Around the states that may be in the region one sample later, in place; its number of corners, 0 if not known.

    As `advance`, with the inverse of either map of a sample: it is found first, and then cut where the wall begins.
    """
    edge = limits[0]
    cloud, chain, spare = room.cloud, room.chain, room.spare
    far, fast = 0.0, 0.0
    for k in range(count):
        far, fast = max(far, abs(region[2 * k])), max(fast, abs(region[2 * k + 1]))
    s, g, f = loop.s2, loop.g2, loop.f2
    most_push = max(-limits[1], limits[2], -limits[3], limits[4])
    far, fast = far + abs(g) * most_push, fast + abs(s) * most_push
    total, error_x, error_v = 0, 0.0, 0.0
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        spring = loop.beta + (limits[5] if side == 0 else loop.kappa)
        hold = 1.0 - g * spring
        det = f * hold + s * s * spring
        size = abs(f) * (1.0 + g * spring) + s * s * spring
        if not abs(det) > 1e-6 * size:
            return 0
        # Each number of the inverse is exact to a few units in the last place and to what its determinant loses.
        lost = 64.0 * EPSILON * (1.0 + size / abs(det)) / abs(det)
        around_x = lost * (abs(f) * far + abs(s) * fast)
        around_v = lost * (abs(s) * spring * far + (1.0 + g * spring) * fast)
        points = 0
        for k in range(count):
            for end in range(2):
                drive = limits[1 + 2 * side + end]
                x, v = region[2 * k] - g * drive, region[2 * k + 1] - s * drive
                cloud[2 * points] = (f * x - s * v) / det
                cloud[2 * points + 1] = (s * spring * x + hold * v) / det
                points += 1
        wide = 0.0
        for k in range(points):
            wide = max(wide, abs(cloud[2 * k]))
        kept = enclose(cloud, points, 0.0, 0.0, chain, room.rough)
        reach = around_x + 64.0 * EPSILON * points * (wide + abs(edge))
        kept = clip(room.rough, kept, edge - sign * reach, sign, chain, 0)
        for k in range(2 * kept):
            spare[2 * total + k] = chain[k]
        total += kept
        error_x, error_v = max(error_x, around_x), max(error_v, around_v)
    wide, quick = 0.0, 0.0
    for k in range(total):
        wide, quick = max(wide, abs(spare[2 * k])), max(quick, abs(spare[2 * k + 1]))
    if total == 0:
        return 0
    kept = simplify_hull(spare, total, most, chain, room.rough)
    dx, dv = error_x + 64.0 * EPSILON * total * wide, error_v + 64.0 * EPSILON * total * quick
    # What rounding moves across the edge or along it moves both ways.
    return enclose(room.rough, kept, 2.0 * dx, 2.0 * dv, chain, region)


def farthest(region, count, loop):
    """Largest distance of a region's states from 0, in the norm of `certificate.distance`."""
    most = 0.0
    for k in range(count):
        most = max(most, distance(region[2 * k], region[2 * k + 1], loop))
    return most


def area_of(region, count):
    """Area of a convex region."""
    twice = 0.0
    for k in range(1, count - 1):
        twice += turn(region, 0, k, region[2 * k + 2], region[2 * k + 3])
    return 0.5 * abs(twice)


def ranges_of(region, count):
    """Least and largest position, least and largest speed of a region."""
    low_x, high_x, low_v, high_v = region[0], region[0], region[1], region[1]
    for k in range(1, count):
        low_x, high_x = min(low_x, region[2 * k]), max(high_x, region[2 * k])
        low_v, high_v = min(low_v, region[2 * k + 1]), max(high_v, region[2 * k + 1])
    return low_x, high_x, low_v, high_v


def fill_square(region, radius, loop):
    """The square, in the norm of `certificate.distance`, around all states within ``radius`` of 0; its corners."""
    high = sqrt(loop.beta) * radius
    put_box(region, 0, -radius, radius, -high, high)
    return 4


def shrink(region, count, most, goal, limits, back, room, loop):
    """Move a region on as far as its goal says.

    ``back``: move it back instead. Returns ``(count, used, far)``: its corners, the samples, and its largest distance
    from 0, infinite where it is not known.
    """
    far = farthest(region, count, loop)
    used = 0
    while used < goal.samples and goal.target < far < goal.ceiling:
        if back:
            count = trace_back(region, count, most, limits, room, loop)
            if count == 0:
                return 0, used, float("inf")
        else:
            count = advance(region, count, most, limits, room, loop)
        far = farthest(region, count, loop)
        used += 1
    return count, used, far
