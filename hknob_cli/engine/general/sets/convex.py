"""Convex polygons, relative to a centre: cut by any line, widened, made simpler; points and segments are polygons, too.

Corners are flat: dx, dv of each, in order around. All results hold what they are made from, to within 64
roundings of the polygon's size.
"""

from math import sqrt

MOST_CORNERS = 12  # that a widened polygon keeps


def extent(corners, count):
    """The rectangle around a polygon: ``(low_x, high_x, low_v, high_v)``."""
    low_x, high_x, low_v, high_v = corners[0], corners[0], corners[1], corners[1]
    for k in range(1, count):
        low_x, high_x = min(low_x, corners[2 * k]), max(high_x, corners[2 * k])
        low_v, high_v = min(low_v, corners[2 * k + 1]), max(high_v, corners[2 * k + 1])
    return low_x, high_x, low_v, high_v


def radius_of(corners, count, beta):
    """Largest distance of a polygon's states from its centre, sqrt(x^2 + v^2 / beta)."""
    square = 0.0
    for k in range(count):
        square = max(square, corners[2 * k] * corners[2 * k] + corners[2 * k + 1] * corners[2 * k + 1] / beta)
    return sqrt(square)


def widest(corners, count, body):
    """Largest distance of a piece's states from its centre, in `body.norm`: of their angles and speeds."""
    square = 0.0
    for k in range(count):
        dx, dv = corners[2 * k], corners[2 * k + 1]
        square = max(square, dv * dv + body.beta * dx * dx)
    return sqrt(square)


def area_of(corners, count):
    """Area of a polygon, by the triangles from its first corner."""
    total = 0.0
    for k in range(1, count - 1):
        ax, av = corners[2 * k] - corners[0], corners[2 * k + 1] - corners[1]
        bx, bv = corners[2 * k + 2] - corners[0], corners[2 * k + 3] - corners[1]
        total += ax * bv - av * bx
    return 0.5 * abs(total)


def recentre(corners, count):
    """Tell a polygon from the middle of the rectangle around it, which lies in it: by how much the centre moves."""
    low_x, high_x, low_v, high_v = extent(corners, count)
    cx, cv = 0.5 * (low_x + high_x), 0.5 * (low_v + high_v)
    if cx != 0.0 or cv != 0.0:
        for k in range(count):
            corners[2 * k] -= cx
            corners[2 * k + 1] -= cv
    return cx, cv


def append(out, kept, dx, dv):
    """Enter a corner unless it is the last one again; how many there are then."""
    if kept > 0 and out[2 * kept - 2] == dx and out[2 * kept - 1] == dv:
        return kept
    out[2 * kept], out[2 * kept + 1] = dx, dv
    return kept + 1


def keep_side(given, count, a, b, c, out):
    """The part of a polygon where ``a dx + b dv >= c``, to ``out``, which has room for one more; its corners.

    A line crosses the outline of a convex polygon at most twice. Where rounding makes it cross more often, as along an
    edge of a flat one, the part is the whole polygon, which holds it.
    """
    kept, crossings = 0, 0
    for k in range(count):
        px, pv = given[2 * k], given[2 * k + 1]
        j = (k + 1) % count
        qx, qv = given[2 * j], given[2 * j + 1]
        here, there = a * px + b * pv - c, a * qx + b * qv - c
        if here >= 0.0:
            kept = append(out, kept, px, pv)
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            crossings += 1
            if crossings > 2:
                for i in range(2 * count):
                    out[i] = given[i]
                return count
            part = here / (here - there)
            kept = append(out, kept, px + part * (qx - px), pv + part * (qv - pv))
    if kept > 1 and out[0] == out[2 * kept - 2] and out[1] == out[2 * kept - 1]:
        kept -= 1
    return kept


def sort_points(points, count):
    """Put points in order of x, then of v, in place."""
    for k in range(1, count):
        px, pv = points[2 * k], points[2 * k + 1]
        j = k - 1
        while j >= 0 and (points[2 * j] > px or (points[2 * j] == px and points[2 * j + 1] > pv)):
            points[2 * j + 2], points[2 * j + 3] = points[2 * j], points[2 * j + 1]
            j -= 1
        points[2 * j + 2], points[2 * j + 3] = px, pv


def turns_left(out, kept, px, pv):
    """Whether the way over the last two corners to a point turns left."""
    ax, av = out[2 * kept - 4], out[2 * kept - 3]
    bx, bv = out[2 * kept - 2], out[2 * kept - 1]
    return (bx - ax) * (pv - av) - (bv - av) * (px - ax) > 0.0


def hull(points, count, out):
    """Corners of the convex hull, counterclockwise, to ``out`` (room for ``count + 1``); sorts ``points``."""
    sort_points(points, count)
    kept = 0
    for k in range(count):
        while kept >= 2 and not turns_left(out, kept, points[2 * k], points[2 * k + 1]):
            kept -= 1
        kept = append(out, kept, points[2 * k], points[2 * k + 1])
    lower = kept + 1
    for k in range(count - 2, -1, -1):
        while kept >= lower and not turns_left(out, kept, points[2 * k], points[2 * k + 1]):
            kept -= 1
        kept = append(out, kept, points[2 * k], points[2 * k + 1])
    if kept > 1 and out[0] == out[2 * kept - 2] and out[1] == out[2 * kept - 1]:
        kept -= 1
    return kept


def drop_edge(corners, count):
    """Leave out the edge whose neighbours, drawn out until they meet, add the least area: one corner fewer.

    Where none meet, the rectangle around the polygon takes its place. ``count`` is at least 5.
    """
    best, chosen, to_x, to_v = float("inf"), -1, 0.0, 0.0
    for k in range(count):
        i, j, m = (k - 1) % count, (k + 1) % count, (k + 2) % count
        bx, bv = corners[2 * k], corners[2 * k + 1]
        cx, cv = corners[2 * j], corners[2 * j + 1]
        dx, dv = bx - corners[2 * i], bv - corners[2 * i + 1]
        ex, ev = cx - corners[2 * m], cv - corners[2 * m + 1]
        cross = dx * ev - dv * ex
        if not cross < 0.0:
            continue
        t = ((cx - bx) * ev - (cv - bv) * ex) / cross
        if not t >= 0.0:
            continue
        qx, qv = bx + t * dx, bv + t * dv
        area = abs((cx - bx) * (qv - bv) - (cv - bv) * (qx - bx))
        if area < best:
            best, chosen, to_x, to_v = area, k, qx, qv
    if chosen < 0:
        low_x, high_x, low_v, high_v = extent(corners, count)
        corners[0], corners[1], corners[2], corners[3] = low_x, low_v, high_x, low_v
        corners[4], corners[5], corners[6], corners[7] = high_x, high_v, low_x, high_v
        return 4
    corners[2 * chosen], corners[2 * chosen + 1] = to_x, to_v
    gone = (chosen + 1) % count
    for k in range(gone, count - 1):
        corners[2 * k], corners[2 * k + 1] = corners[2 * k + 2], corners[2 * k + 3]
    return count - 1


def widen(corners, count, more_x, more_v, points):
    """Add the rectangle from ``-more`` to ``more`` to every state of a polygon, in place; its corners.

    ``points`` has room for four times as many, ``corners`` for one more than that. At most `MOST_CORNERS` are kept.
    """
    made = 0
    for k in range(count):
        for i in range(2):
            side_x = more_x if i == 0 else -more_x
            for j in range(2):
                side_v = more_v if j == 0 else -more_v
                if (i == 1 and more_x == 0.0) or (j == 1 and more_v == 0.0):
                    continue
                points[2 * made] = corners[2 * k] + side_x
                points[2 * made + 1] = corners[2 * k + 1] + side_v
                made += 1
    count = hull(points, made, corners)
    while count > MOST_CORNERS:
        count = drop_edge(corners, count)
    return count
