"""Arcs with friction that wait, their parts at the edges that a reading meets, and phases that are begun anew."""

from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.sets.friction_arc import COUNT, FROM, HIGH, LOW, SAMPLE, TO, TOLD, beside_of
from hknob_cli.engine.general.sets.friction_arc_counts import tells_counts
from hknob_cli.engine.general.sets.memory import watched
from hknob_cli.engine.general.sets.turns import half_of, highest_at, lowest_at, next_at

ARCS = 256  # of one beginning that wait
INTERVAL = 4  # numbers of phases that wait: `LOW` to `TO`


def put_all(source, stack, at):
    """Copy numbers to ``stack[at:]``; where the next ones go."""
    for j in range(len(source)):
        stack[at + j] = source[j]
    return at + len(source)


def take_all(target, stack, at):
    """Copy numbers from ``stack[at:]``; where the next ones are."""
    for j in range(len(target)):
        target[j] = stack[at + j]
    return at + len(target)


def keep_arc(room):
    """Keep the arc in ``room`` as it is at a sample."""
    copy_to(room.own, room.arc)
    copy_to(room.own_z, room.z)
    copy_to(room.own_columns, room.columns)
    copy_to(room.own_ring, room.ring)


def wait_arc(room, waiting, first, last, low, high):
    """Let a part of the arc that is kept wait: from ``first`` to ``last`` of its line, which is from -1 to 1.

    ``low`` and ``high``: from where to where it counts, if the arc does there.
    """
    size = len(room.stack) // ARCS
    base = waiting * size
    at = put_all(room.own, room.stack, base)
    middle, half = 0.5 * (room.own[LOW] + room.own[HIGH]), 0.5 * (room.own[HIGH] - room.own[LOW])
    room.stack[base + LOW], room.stack[base + HIGH] = middle + first * half, middle + last * half
    room.stack[base + FROM] = min(max(middle + low * half, room.own[FROM]), room.own[TO])
    room.stack[base + TO] = max(min(middle + high * half, room.own[TO]), room.own[FROM])
    at = put_all(room.own_z, room.stack, at)
    for j in range(len(room.z)):
        room.stack[at - len(room.z) + j] += 0.5 * (first + last) * room.own_columns[j]
    for j in range(len(room.z)):
        room.own_line[j] = room.own_columns[j] * 0.5 * (last - first)
    put_all(room.own_line, room.stack, put_all(room.own_columns, room.stack, at) - len(room.own_columns))
    at = put_all(room.own_ring, room.stack, at + len(room.own_columns))
    put_all(room.told, room.stack, at)


def take_arc(room, waiting):
    """Leave an arc that waits in ``room``."""
    at = take_all(room.arc, room.stack, waiting * (len(room.stack) // ARCS))
    at = take_all(room.z, room.stack, at)
    at = take_all(room.columns, room.stack, at)
    at = take_all(room.ring, room.stack, at)
    take_all(room.told, room.stack, at)


def part_arc(room, waiting, which, high, cell):
    """Cut an arc at the edges of reading number ``which`` of its interval, from that in `room.told` to ``high``.

    How many arcs wait then, -1: no room. The arc in ``room`` is at that reading; its parts are of that at the sample.
    One whose counts differ is not cut: all of it waits for each reading.
    """
    drift, body, turns, watch = cell.drift, cell.body, cell.known.turns, watched(cell.known.law, cell.wall)
    x, width, slack = room.z[0], room.columns[0], beside_of(room, body)
    level, begun, shown = room.told[which], waiting, room.arc[COUNT]
    half, cuts = half_of(turns, which == 0 and room.arc[SAMPLE] == 0.0, watch), tells_counts(turns, room.arc)
    room.own[TOLD] = which + 1.0
    while level <= high:
        bottom = lowest_at(turns, level, shown, half, drift.bottom, watch) - x
        top = highest_at(turns, level, shown, half, watch) - x
        first, last, low, up = -1.0, 1.0, -1.0 if waiting == begun else 1.0, 1.0  # a ball counts once
        if cuts and width != 0.0:
            a, b = (bottom, top) if width > 0.0 else (top, bottom)
            more = slack if width > 0.0 else -slack
            first, last = max(-1.0, (a - more) / width), min(1.0, (b + more) / width)
            low, up = min(max(-1.0, a / width), 1.0), max(-1.0, min(1.0, b / width))
        room.told[which] = level
        if first <= last:
            if waiting >= ARCS:
                return -1
            wait_arc(room, waiting, first, last, low, up)
            waiting += 1
        level = next_at(turns, level, watch)
    return waiting


def halve_arc(room, waiting):
    """Let both halves of the arc that is kept wait; how many arcs do then, -1: no room."""
    if waiting + 2 > ARCS:
        return -1
    wait_arc(room, waiting, -1.0, 0.0, -1.0, 0.0)
    wait_arc(room, waiting + 1, 0.0, 1.0, 0.0, 1.0)
    return waiting + 2


def begin_again(stack, waiting, arc, at, length):
    """Let the phases of the arc that is at ``arc[at:]`` be begun anew; how many intervals wait then, -1: no room.

    In halves where they are nearly as long as what was begun before, ``length``.
    """
    low, high, begin, end = arc[at + LOW], arc[at + HIGH], arc[at + FROM], arc[at + TO]
    if INTERVAL * (waiting + 2) > len(stack):
        return -1
    middle = 0.5 * (low + high) if high - low > 0.5 * length else low
    while low < high:
        base = INTERVAL * waiting
        stack[base], stack[base + 1] = low, middle if middle > low else high
        stack[base + 2] = min(max(begin, stack[base]), stack[base + 1])
        stack[base + 3] = max(min(end, stack[base + 1]), stack[base])
        low = stack[base + 1]
        waiting += 1
    return waiting
