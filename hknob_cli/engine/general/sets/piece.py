"""Convex polygons of states of any order, cut where a sample of them meets a count edge.

A piece is a centre, which is a trial with its commands under way and its last reading, and the corners of a polygon
relative to it. While all of it acts alike its corners go by Phi from sample to sample, so that a polygon of starts, two
angles wide, stays one in the space of all states.

A piece in a list of numbers: `ERROR` to `SPREAD`, by which torques that lag may differ from the centre's; then its
state (order), the commands under way, oldest first (delay), and its corners (order each; of `friction_piece`, whose
states differ in angle and speed alone, two).
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import norm_at
from hknob_cli.engine.general.sets.ball import step_through
from hknob_cli.engine.general.sets.cell import Centre

CORNERS = 16  # that a piece keeps; one with more is halved, for a simpler one around it might never shrink
ERROR, BEFORE, LEVEL, SAMPLE, WEIGHT, COUNT, SPREAD, STATE = range(8)


def piece_size(n, delay):
    """Numbers of a piece."""
    return STATE + n + delay + n * CORNERS


def largest_norm(corners, base, count, body):
    """Largest distance of a piece's corners from its centre, and so of all its states (the norm is convex)."""
    radius = 0.0
    for k in range(count):
        radius = max(radius, norm_at(corners, base + k * body.order, body))
    return radius


def power_of(samples, drift, n, matrix, spare):
    """Phi to the power ``samples``, to ``matrix`` (n * n)."""
    for i in range(n):
        for j in range(n):
            matrix[i * n + j] = 1.0 if i == j else 0.0
    base, first = 0, True
    while samples > 0:
        if samples % 2 == 1:
            for k in range(n * n):
                spare[k] = matrix[k]
            for i in range(n):
                for j in range(n):
                    total = 0.0
                    if first:
                        total = drift.powers[base + i * n + j]
                    else:
                        for k in range(n):
                            total += drift.powers[base + i * n + k] * spare[k * n + j]
                    matrix[i * n + j] = total
            first = False
        samples //= 2
        base += n * n


def move_corners(given, base, count, samples, out, drift, n, room):
    """Corners after ``samples`` samples of acting alike, from ``given[base:]`` to ``out``."""
    matrix = room.matrix
    power_of(samples, drift, n, matrix, room.spare)
    for k in range(count):
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += matrix[i * n + j] * given[base + k * n + j]
            out[k * n + i] = total


def clip_by(by, given, count, limit, sign, out, at, n):
    """The part of a convex polygon whose number ``by`` is on one side of a limit, to ``out[at:]``; its corners.

    ``sign`` +1 keeps what lies above the limit, -1 what lies below; what lies on it is kept. Two corners are a chord.
    """
    kept = 0
    for k in range(count):
        a, b = k * n, (k + 1) % count * n
        inside, following = sign * (given[a + by] - limit) >= 0.0, sign * (given[b + by] - limit) >= 0.0
        if inside:
            for j in range(n):
                out[at + kept * n + j] = given[a + j]
            kept += 1
        if inside != following and (count > 2 or k == 0):
            part = (limit - given[a + by]) / (given[b + by] - given[a + by])
            for j in range(n):
                out[at + kept * n + j] = given[a + j] + part * (given[b + j] - given[a + j])
            out[at + kept * n + by] = limit
            kept += 1
    return kept


def clip(given, count, limit, sign, out, at, n):
    """As `clip_by`, by the position."""
    return clip_by(0, given, count, limit, sign, out, at, n)


def find_middle(corners, count, n, middle):
    """The middle of the box around a polygon, to ``middle``."""
    for j in range(n):
        low, high = corners[j], corners[j]
        for k in range(1, count):
            low, high = min(low, corners[k * n + j]), max(high, corners[k * n + j])
        middle[j] = 0.5 * (low + high)


def put(out, base, centre, corners, count, middle, drift, n):
    """Enter a piece, told from the middle of the box around it, to ``out[base:]``; states differ in ``n`` numbers."""
    find_middle(corners, count, n, middle)
    z, ring, error = centre.z, centre.ring, centre.error
    order, delay = len(z), len(ring)
    for j in range(n):
        at = z[j] + middle[j]
        out[base + STATE + j] = at
        error += 4.0 * EPSILON * drift.units[j] * (abs(at) + abs(middle[j]))
    for j in range(n, order):
        out[base + STATE + j] = z[j]
    for j in range(delay):
        out[base + STATE + order + j] = ring[(centre.head + j) % delay]
    first = base + STATE + order + delay
    for k in range(count):
        for j in range(n):
            out[first + k * n + j] = corners[k * n + j] - middle[j]
    out[base + ERROR], out[base + BEFORE], out[base + LEVEL] = error, centre.before, centre.level
    out[base + SAMPLE], out[base + WEIGHT] = centre.sample, centre.weight
    out[base + COUNT], out[base + SPREAD] = float(count), 0.0


def take(own, z, ring):
    """The centre of the piece in ``own``, its state in ``z`` and what it remembers in ``ring``."""
    n, delay = len(z), len(ring)
    for j in range(n):
        z[j] = own[STATE + j]
    for j in range(delay):
        ring[j] = own[STATE + n + j]
    return Centre(z, own[BEFORE], ring, 0 * delay, own[ERROR], own[LEVEL], own[SAMPLE], own[WEIGHT])


def move_piece(room, waiting, centre, corners, count, shown, cell):
    """Move a piece over one hold, acting as its level, and let what becomes of it wait; how many pieces wait then.

    The centre is left alone. It is one piece after a hold in which all differences go by Phi. ``shown``: its count
    before the next sample, with hysteresis of the encoder.
    """
    n, delay, stack = cell.body.order, len(centre.ring), room.stack
    base = waiting * piece_size(n, delay)
    put(stack, base, centre, corners, count, room.middle, cell.drift, n)
    for j in range(n):
        room.z[j] = stack[base + STATE + j]
    for j in range(delay):
        room.ring[j] = stack[base + STATE + n + j]
    error, head = stack[base + ERROR], 0 * delay
    here = Centre(room.z, centre.before, room.ring, head, error, centre.level, centre.sample, centre.weight)
    moved = step_through(here, shown, cell, room.pad)
    stack[base + ERROR], stack[base + BEFORE], stack[base + SAMPLE] = moved.error, moved.before, moved.sample
    for j in range(n):
        stack[base + STATE + j] = room.z[j]
    for j in range(delay):
        stack[base + STATE + n + j] = room.ring[(moved.head + j) % delay]
    first = base + STATE + n + delay
    move_corners(stack, first, count, 1, room.moved, cell.drift, n, room)
    for k in range(count * n):
        stack[first + k] = room.moved[k]
    return waiting + 1


def within(room, corners, count, low, high, n):
    """The part of a polygon between two edges, told from its centre, to ``room.halves``; its number of corners."""
    kept, first = count, 0
    for k in range(count * n):
        room.parts[k] = corners[k]
    half = len(room.parts) // 2
    if low > -float("inf"):
        kept = clip(corners, count, low, 1.0, room.parts, 0, n)
    if kept > 0 and high < float("inf"):
        for k in range(kept * n):
            room.halves[k] = room.parts[k]
        kept = clip(room.halves, kept, high, -1.0, room.parts, half, n)
        first = half
    for k in range(kept * n):
        room.halves[k] = room.parts[first + k]
    return kept


def halve(room, kept, n):
    """In two, by the line from the first corner to the one opposite: corners of both, in `halves` and `parts`."""
    opposite = kept // 2
    for k in range((kept - opposite) * n):
        room.parts[k] = room.halves[opposite * n + k]
    for j in range(n):
        room.parts[(kept - opposite) * n + j] = room.halves[j]
    return opposite + 1, kept - opposite + 1
