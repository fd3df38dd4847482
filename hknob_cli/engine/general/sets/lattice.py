"""Small pieces of second order, merged: those in one cell of a lattice go on as the rectangle around them.

As `engine.sets.polygon`; only pieces with the same commands under way and the same last reading are merged. Of those
whose torque lags, it has to be nearly the same: what goes on has the spread of all.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets.piece import (
    BEFORE,
    COUNT,
    ERROR,
    LEVEL,
    SAMPLE,
    SPREAD,
    STATE,
    WEIGHT,
    piece_size,
    put,
)

MEMBERS, LOW_X, HIGH_X, LOW_V, HIGH_V = range(5)  # numbers of a cell of the lattice
LOW_LATE, HIGH_LATE = 5, 6
CELL = 7
KEY = 4  # numbers of a cell's key, beside the commands under way
FULL = -1
FINER = 4.0  # times that the torques of what is merged are as near, by what they can still add


def late_cell(z, width, body):
    """Which cell of torques that lag a piece is in; 0 where none does."""
    if body.lag == 0.0:
        return 0.0
    return z[2] * FINER * body.reach / (width * body.lag) // 1.0


def slot(i, j, late, before, ring, head, room):
    """Slot of a cell of the lattice and its memory: where it is, or the empty one where it may be entered."""
    size, delay = len(room.used), len(ring)
    at = int(i) * 73856093 + int(j) * 19349663 + int(before) * 83492791 + int(late) * 40503001
    for k in range(delay):
        at = at * 31 + int(ring[(head + k) % delay] * room.scale[0]) % 1048573
        at %= 2147483647
    at %= size
    width = KEY + delay
    while room.used[at] > 0.0:
        key = width * at
        same = room.keys[key] == i and room.keys[key + 1] == j
        same = same and room.keys[key + 2] == late and room.keys[key + 3] == before
        for k in range(delay):
            same = same and room.keys[key + KEY + k] == ring[(head + k) % delay]
        if same:
            break
        at = (at + 1) % size
    return at


def keep(room, centre, corners, count, width, drift, body):
    """Enter a small piece into the lattice whose cells are ``width`` counts wide; whether there was room.

    The piece in ``room.own`` says how far torques that lag may differ from that of ``z``.
    """
    z, ring, head, error = centre.z, centre.ring, centre.head, centre.error
    delay = len(ring)
    scale = 1.0 / body.reach
    i, j = z[0] / width // 1.0, z[1] / (scale * width) // 1.0
    late = late_cell(z, width, body)
    at = slot(i, j, late, centre.before, ring, head, room)
    size = piece_size(len(z), delay)
    if room.used[at] == 0.0:
        if 2 * room.counts[0] >= len(room.used):
            return False
        room.used[at] = 1.0
        key = (KEY + delay) * at
        room.keys[key], room.keys[key + 1], room.keys[key + 2], room.keys[key + 3] = i, j, late, centre.before
        for k in range(delay):
            room.keys[key + KEY + k] = ring[(head + k) % delay]
        room.taken[int(room.counts[0])] = at
        room.counts[0] += 1.0
        room.cells[CELL * at + MEMBERS] = 0.0
        room.cells[CELL * at + LOW_X], room.cells[CELL * at + HIGH_X] = float("inf"), -float("inf")
        room.cells[CELL * at + LOW_V], room.cells[CELL * at + HIGH_V] = float("inf"), -float("inf")
        room.cells[CELL * at + LOW_LATE], room.cells[CELL * at + HIGH_LATE] = float("inf"), -float("inf")
        put(room.singles, size * at, centre, corners, count, room.middle, drift, 2)
        room.singles[size * at + WEIGHT] = 0.0
        room.singles[size * at + SPREAD] = room.own[SPREAD]
    base = CELL * at
    room.cells[base + MEMBERS] += 1.0
    room.singles[size * at + WEIGHT] += centre.weight
    slack = body.reach * error + 4.0 * EPSILON * abs(z[0])
    slack_v = error + 4.0 * EPSILON * abs(z[1])
    if body.lag > 0.0:
        apart = room.own[SPREAD] + body.lag * error + 4.0 * EPSILON * abs(z[2])
        room.cells[base + LOW_LATE] = min(room.cells[base + LOW_LATE], z[2] - apart)
        room.cells[base + HIGH_LATE] = max(room.cells[base + HIGH_LATE], z[2] + apart)
    for k in range(count):
        at_x, at_v = z[0] + corners[2 * k], z[1] + corners[2 * k + 1]
        room.cells[base + LOW_X] = min(room.cells[base + LOW_X], at_x - slack)
        room.cells[base + HIGH_X] = max(room.cells[base + HIGH_X], at_x + slack)
        room.cells[base + LOW_V] = min(room.cells[base + LOW_V], at_v - slack_v)
        room.cells[base + HIGH_V] = max(room.cells[base + HIGH_V], at_v + slack_v)
    return True


def put_box(out, at, low_x, high_x, low_v, high_v):
    """The corners of a rectangle of second order, in order, to ``out[at:]``."""
    out[at], out[at + 1] = low_x, low_v
    out[at + 2], out[at + 3] = high_x, low_v
    out[at + 4], out[at + 5] = high_x, high_v
    out[at + 6], out[at + 7] = low_x, high_v


def release(room, waiting, delay, drift):
    """Put what the lattice holds back to wait, merged, and empty it; how many pieces wait."""
    order = len(room.own_z)
    size = piece_size(order, delay)
    for one in range(int(room.counts[0])):
        at = int(room.taken[one])
        base, to = size * at, size * waiting
        entry = CELL * at
        if room.cells[entry + MEMBERS] == 1.0:
            for k in range(size):
                room.stack[to + k] = room.singles[base + k]
        else:
            low_x, high_x = room.cells[entry + LOW_X], room.cells[entry + HIGH_X]
            low_v, high_v = room.cells[entry + LOW_V], room.cells[entry + HIGH_V]
            x, v = 0.5 * (low_x + high_x), 0.5 * (low_v + high_v)
            room.stack[to + STATE], room.stack[to + STATE + 1] = x, v
            span = drift.units[0] * (abs(low_x) + abs(high_x)) + drift.units[1] * (abs(low_v) + abs(high_v))
            room.stack[to + ERROR] = 4.0 * EPSILON * span
            room.stack[to + SPREAD] = 0.0
            if order > 2:
                low, high = room.cells[entry + LOW_LATE], room.cells[entry + HIGH_LATE]
                room.stack[to + STATE + 2] = 0.5 * (low + high)
                room.stack[to + SPREAD] = 0.5 * (high - low)
                room.stack[to + ERROR] += drift.units[2] * 4.0 * EPSILON * (abs(low) + abs(high))
            room.stack[to + BEFORE] = room.singles[base + BEFORE]
            room.stack[to + LEVEL], room.stack[to + SAMPLE] = 0.0, 0.0
            room.stack[to + WEIGHT], room.stack[to + COUNT] = room.singles[base + WEIGHT], 4.0
            for k in range(delay):
                room.stack[to + STATE + order + k] = room.singles[base + STATE + order + k]
            put_box(room.stack, to + STATE + order + delay, low_x - x, high_x - x, low_v - v, high_v - v)
        room.used[at] = 0.0
        waiting += 1
    room.counts[0] = 0.0
    return waiting
