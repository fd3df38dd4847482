"""Convex polygons of states: cut where a sample of them meets a count edge, and merged where they are small.

While all of a polygon acts alike, its corners differ from its centre, n samples later, by Phi^n times what they
differed at first. So one trial, the centre, is followed, and the corners are computed where they matter.

Motions that come together are then followed once. A merged rectangle holds more states than its members, so that where
it ends in known attractors, they do: the list of attractors stays proven, while shares are no longer told apart.
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON, distance
from hknob_cli.engine.loop import lower_edge, upper_edge
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.sets.ball import Centre, step_through

CORNERS = 16  # that a polygon keeps; one with more is halved, for a simpler one around it might never shrink
X, V, ERROR, LEVEL, SAMPLE, WEIGHT, COUNT = range(7)  # numbers of a polygon; its corners follow, relative to x and v
POLYGON = 7 + 2 * CORNERS


def blur(loop):
    """Relative error of the free response over any number of samples, with a margin.

    The phase of its ringing is off by an ulp or two, of as many radians as it rings until it has decayed.
    """
    return 64.0 * EPSILON * (1.0 + sqrt(loop.beta) / loop.alpha)


def corner_radius(corners, base, count, loop):
    """Largest distance of a polygon's corners from its centre, and so of all its states (the norm is convex)."""
    radius = 0.0
    for k in range(count):
        radius = max(radius, distance(corners[base + 2 * k], corners[base + 2 * k + 1], loop))
    return radius


def move_corners(given, base, count, samples, out, at, loop):
    """Corners after ``samples`` samples of acting alike, from those at ``given[base:]`` to ``out[at:]``."""
    s, g, f = hold_coefficients(loop.alpha, loop.beta, float(samples))
    for k in range(count):
        dx, dv = given[base + 2 * k], given[base + 2 * k + 1]
        out[at + 2 * k] = dx + (s * dv - loop.beta * g * dx)
        out[at + 2 * k + 1] = f * dv - loop.beta * s * dx


def clip(given, count, limit, sign, out, at):
    """The part of a convex polygon on one side of ``x = limit``, to ``out[at:]``; its number of corners.

    ``sign`` +1 keeps what lies above the limit, -1 what lies below; what lies on it is kept. A line crosses the outline
    of a convex polygon at most twice. Where rounding makes it cross more often, as along an edge of a flat one, the
    part is the whole polygon, which holds it.
    """
    kept, crossings = 0, 0
    for k in range(count):
        ax, av = given[2 * k], given[2 * k + 1]
        j = (k + 1) % count
        bx, bv = given[2 * j], given[2 * j + 1]
        inside, following = sign * (ax - limit) >= 0.0, sign * (bx - limit) >= 0.0
        if inside:
            out[at + 2 * kept], out[at + 2 * kept + 1] = ax, av
            kept += 1
        if inside != following:
            crossings += 1
            if crossings > 2:
                for i in range(2 * count):
                    out[at + i] = given[i]
                return count
            part = (limit - ax) / (bx - ax)
            out[at + 2 * kept], out[at + 2 * kept + 1] = limit, av + part * (bv - av)
            kept += 1
    return kept


def put_box(out, at, low_x, high_x, low_v, high_v):
    """The corners of a rectangle, in order, to ``out[at:]``."""
    out[at], out[at + 1] = low_x, low_v
    out[at + 2], out[at + 3] = high_x, low_v
    out[at + 4], out[at + 5] = high_x, high_v
    out[at + 6], out[at + 7] = low_x, high_v


def put(out, base, centre, corners, count):
    """Enter a polygon, told from the middle of the rectangle around it, to ``out[base:]``; ``centre``: as it was."""
    low_x, high_x, low_v, high_v = corners[0], corners[0], corners[1], corners[1]
    for k in range(1, count):
        low_x, high_x = min(low_x, corners[2 * k]), max(high_x, corners[2 * k])
        low_v, high_v = min(low_v, corners[2 * k + 1]), max(high_v, corners[2 * k + 1])
    cx, cv = 0.5 * (low_x + high_x), 0.5 * (low_v + high_v)
    out[base + X], out[base + V], out[base + ERROR] = centre.x + cx, centre.v + cv, centre.error
    out[base + LEVEL], out[base + SAMPLE], out[base + WEIGHT] = centre.level, centre.sample, centre.weight
    for k in range(count):
        out[base + 7 + 2 * k], out[base + 8 + 2 * k] = corners[2 * k] - cx, corners[2 * k + 1] - cv
    out[base + COUNT] = float(count)


def put_next(room, waiting, centre, corners, count, loop):
    """Enter a polygon among those that wait, one sample on, as its level."""
    base = waiting * POLYGON
    put(room.stack, base, centre, corners, count)
    room.stack[base + SAMPLE] = centre.sample + 1.0
    for k in range(2 * count):
        room.moved[k] = room.stack[base + 7 + k]
    x, v, error, _ = step_through(
        room.stack[base + X], room.stack[base + V], room.stack[base + ERROR], centre.level, room.ring, 0, loop
    )
    room.stack[base + X], room.stack[base + V], room.stack[base + ERROR] = x, v, error
    move_corners(room.moved, 0, count, 1, room.stack, base + 7, loop)


def part(room, waiting, centre, corners, count, low_level, high_level, loop):
    """Cut a polygon at the edges that change the torque; how many polygons wait then, -1 where there is no room.

    Each part takes in what lies within its error of its edges, so that whatever a state's true level is, a part with
    it holds the state; each is taken one sample on, as its level. Parts with too many corners are halved, too.
    """
    x, reach = centre.x, centre.error
    if waiting + 2 * (int(high_level - low_level) + 1) > len(room.stack) // POLYGON:
        return -1
    half = len(room.parts) // 2
    q = low_level
    while q <= high_level:
        acts = Centre(x, centre.v, reach, q, centre.sample, centre.weight)
        kept = clip(corners, count, lower_edge(q, loop.sense) - reach - x, 1.0, room.parts, 0)
        highest = upper_edge(q, loop.sense)
        first = 0
        if kept > 0 and highest < float("inf"):
            kept = clip(room.parts, kept, highest + reach - x, -1.0, room.parts, half)
            first = half
        for k in range(2 * kept):
            room.halves[k] = room.parts[first + k]
        if kept > CORNERS:
            # In two, by the line from the first corner to the one opposite.
            opposite = kept // 2
            put_next(room, waiting, acts, room.halves, opposite + 1, loop)
            for k in range(2 * (kept - opposite)):
                room.parts[k] = room.halves[2 * opposite + k]
            room.parts[2 * (kept - opposite)], room.parts[2 * (kept - opposite) + 1] = room.halves[0], room.halves[1]
            put_next(room, waiting + 1, acts, room.parts, kept - opposite + 1, loop)
            waiting += 2
        elif kept > 0:
            put_next(room, waiting, acts, room.halves, kept, loop)
            waiting += 1
        q += 1.0
    return waiting


MEMBERS, LOW_X, HIGH_X, LOW_V, HIGH_V = range(5)  # numbers of a cell of the lattice
CELL = 5


def slot(i, j, room):
    """Slot of the lattice cell (``i``, ``j``): where it is, or the empty one where it may be entered."""
    size = len(room.used)
    at = (int(i) * 73856093 + int(j) * 19349663) % size
    while room.used[at] > 0.0 and (room.keys[2 * at] != i or room.keys[2 * at + 1] != j):
        at = (at + 1) % size
    return at


def keep(room, centre, corners, count, width, loop):
    """Enter a small polygon into the lattice whose cells are ``width`` wide; whether there was room."""
    x, v, error = centre.x, centre.v, centre.error
    scale = sqrt(loop.beta)
    i, j = x / width // 1.0, v / (scale * width) // 1.0
    at = slot(i, j, room)
    if room.used[at] == 0.0:
        if 2 * room.counts[0] >= len(room.used):
            return False
        room.used[at] = 1.0
        room.keys[2 * at], room.keys[2 * at + 1] = i, j
        room.taken[int(room.counts[0])] = at
        room.counts[0] += 1.0
        room.cells[CELL * at + MEMBERS] = 0.0
        room.cells[CELL * at + LOW_X], room.cells[CELL * at + HIGH_X] = float("inf"), -float("inf")
        room.cells[CELL * at + LOW_V], room.cells[CELL * at + HIGH_V] = float("inf"), -float("inf")
        put(room.singles, POLYGON * at, centre, corners, count)
        room.singles[POLYGON * at + WEIGHT] = 0.0
    base = CELL * at
    room.cells[base + MEMBERS] += 1.0
    room.singles[POLYGON * at + WEIGHT] += centre.weight
    slack = error + 4.0 * EPSILON * abs(x)
    slack_v = scale * error + 4.0 * EPSILON * abs(v)
    for k in range(count):
        at_x, at_v = x + corners[2 * k], v + corners[2 * k + 1]
        room.cells[base + LOW_X] = min(room.cells[base + LOW_X], at_x - slack)
        room.cells[base + HIGH_X] = max(room.cells[base + HIGH_X], at_x + slack)
        room.cells[base + LOW_V] = min(room.cells[base + LOW_V], at_v - slack_v)
        room.cells[base + HIGH_V] = max(room.cells[base + HIGH_V], at_v + slack_v)
    return True


def forget(room):
    """Empty the lattice of what a search that was cut short has left: it would take in polygons of the next one."""
    for one in range(int(room.counts[0])):
        room.used[int(room.taken[one])] = 0.0
    room.counts[0] = 0.0


def release(room, waiting, loop):
    """Put what the lattice holds back to wait, merged, and empty it; how many polygons wait."""
    weight = 1.0 / sqrt(loop.beta)  # of velocities in the norm
    for one in range(int(room.counts[0])):
        at = int(room.taken[one])
        base, to = POLYGON * at, POLYGON * waiting
        entry = CELL * at
        if room.cells[entry + MEMBERS] == 1.0:
            for k in range(POLYGON):
                room.stack[to + k] = room.singles[base + k]
        else:
            low_x, high_x = room.cells[entry + LOW_X], room.cells[entry + HIGH_X]
            low_v, high_v = room.cells[entry + LOW_V], room.cells[entry + HIGH_V]
            x, v = 0.5 * (low_x + high_x), 0.5 * (low_v + high_v)
            room.stack[to + X], room.stack[to + V] = x, v
            size = abs(low_x) + abs(high_x) + weight * (abs(low_v) + abs(high_v))
            room.stack[to + ERROR] = 4.0 * EPSILON * size
            room.stack[to + LEVEL], room.stack[to + SAMPLE] = 0.0, 0.0
            room.stack[to + WEIGHT], room.stack[to + COUNT] = room.singles[base + WEIGHT], 4.0
            put_box(room.stack, to + 7, low_x - x, high_x - x, low_v - v, high_v - v)
        room.used[at] = 0.0
        waiting += 1
    room.counts[0] = 0.0
    return waiting
