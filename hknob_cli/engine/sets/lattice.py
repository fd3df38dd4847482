"""Small polygons, merged: those in one cell of a lattice go on as the rectangle around them.

Motions that come together are then followed once. A merged rectangle holds more states than its members, so that where
it ends in known attractors, they do: the list of attractors stays proven, while shares are no longer told apart.
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.sets.polygon import COUNT, ERROR, LEVEL, POLYGON, SAMPLE, WEIGHT, V, X, put, put_box

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
