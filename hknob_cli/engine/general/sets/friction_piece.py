"""Pieces of second order with Coulomb friction: moved over one interval, and cut where a sample meets a count edge.

A piece is as in `piece`. Where all its corners have the velocity 0, all its states have exactly that, with no error:
friction holds them.
"""

from hknob_cli.engine.general.sets.convex import MOST_CORNERS, drop_edge, keep_side, widen
from hknob_cli.engine.general.sets.friction_step import CUT, HELD, MOST_CUTS, move_set
from hknob_cli.engine.general.sets.memory import command_all
from hknob_cli.engine.general.sets.piece import largest_norm, piece_size, put, within
from hknob_cli.engine.general.sets.readings import highest, lowest, next_level, remembered

PART, CUTS, X, V, COUNT, CORNERS = range(6)  # numbers of a set within an interval
MOST = MOST_CORNERS + 2 + MOST_CUTS + 2  # corners of one
SET = CORNERS + 2 * MOST
SETS = 256  # of one piece within an interval, at most
TORQUE, SPAN, S, G, F = range(5)  # numbers of a part of an interval: which of the torques acts, and the plant
LEG = 5
TINY = 1e-290  # a velocity that is not 0


def stands(v, corners, count):
    """Whether all states of a piece have the velocity 0."""
    for k in range(count):
        if v + corners[2 * k + 1] != 0.0:
            return False
    return True


def begin_set(work, at, part, cuts, x, v, corners, count):
    """Enter a set that is ``part`` parts into the interval, and is cut so often already in this one."""
    base = at * SET
    work.sets[base + PART], work.sets[base + CUTS], work.sets[base + COUNT] = float(part), float(cuts), float(count)
    work.sets[base + X], work.sets[base + V] = x, v
    for k in range(2 * count):
        work.sets[base + CORNERS + k] = corners[k]


def cut_set(work, at, part, cuts, x, v, count):
    """Put both sides of a set that is cut by ``work.line`` in its place; how many sets there are then, 0: one side.

    The set itself is in ``work.corners``, and is left there.
    """
    a, b, c = work.line[0], work.line[1], work.line[2]
    over = keep_side(work.corners, count, a, b, c, work.one)
    under = keep_side(work.corners, count, -a, -b, -c, work.other)
    if over == 0 or under == 0:
        return 0
    begin_set(work, at, part, cuts + 1, x, v, work.one, over)
    begin_set(work, at + 1, part, cuts + 1, x, v, work.other, under)
    return at + 2


def move_piece(
    room, work, waiting, z, before, ring, head, error, level, sample, weight, corners, count, drift, body, wall
):
    """Move a piece over one interval, acting as ``level``, and let what becomes of it wait; how many then, -1: no room.

    The piece is told from ``z``, which is left alone, as ``ring`` is.
    """
    delay = len(ring)
    for j in range(delay):
        work.ring[j] = ring[(head + j) % delay]
    to, largest = command_all(work.law, level, before, work.ring, wall, work.torques)
    error += drift.once[0] + drift.once[1] * largest + drift.once[2] * abs(z[0]) + drift.once[3] * abs(z[1])
    error += drift.blur * largest_norm(corners, 0, count, body)
    legs, size = len(work.course) // LEG, piece_size(2, delay)
    begin_set(work, 0, 0, 0, z[0], z[1], corners, count)
    sets = 1
    while sets > 0:
        sets -= 1
        base = sets * SET
        part, cuts, kept = int(work.sets[base + PART]), int(work.sets[base + CUTS]), int(work.sets[base + COUNT])
        x, v = work.sets[base + X], work.sets[base + V]
        for k in range(2 * kept):
            work.corners[k] = work.sets[base + CORNERS + k]
        if part == legs:
            if (waiting + 1) * size > len(room.stack):
                return -1
            work.z[0], work.z[1] = x, v
            put(
                room.stack,
                waiting * size,
                work.z,
                remembered(level, wall),
                work.ring,
                to,
                error,
                level,
                sample + 1.0,
                weight,
                work.corners,
                kept,
                room.middle,
                drift,
                2,
            )
            waiting += 1
            continue
        leg = part * LEG
        acting = work.torques[int(work.course[leg + TORQUE])]
        span, s, g, f = work.course[leg + SPAN], work.course[leg + S], work.course[leg + G], work.course[leg + F]
        least = work.least[0] if cuts < MOST_CUTS and sets + 2 <= SETS else float("inf")
        fate, to_x, to_v, after = move_set(
            x, v, acting, span, s, g, f, work.corners, kept, least, body, work.space, work.line
        )
        if fate == CUT:
            more = cut_set(work, sets, part, cuts, x, v, kept)
            if more > 0:
                sets = more
                continue
            # Within rounding of the line: the enclosure is taken as it is.
            fate, to_x, to_v, after = move_set(
                x, v, acting, span, s, g, f, work.corners, kept, float("inf"), body, work.space, work.line
            )
        while after > MOST_CORNERS:
            after = drop_edge(work.corners, after)
        if fate != HELD and stands(to_v, work.corners, after):
            after = widen(work.corners, after, 0.0, TINY, work.space)
        begin_set(work, sets, part + 1, 0, to_x, to_v, work.corners, after)
        sets += 1
    return waiting


def part_piece(
    room, waiting, z, before, ring, head, error, reach, sample, weight, corners, count, low, high, drift, wall
):
    """Cut a piece at the edges that change the command, and let the parts wait; how many pieces wait then, -1: no room.

    ``low`` and ``high``: the readings it has; ``reach``: position by which each part goes beyond its edges. So whatever
    a state truly reads, a part that acts as this reading holds the state. A part waits at the same sample: half a
    sample more says that how it acts is settled.
    """
    size, level = piece_size(2, len(ring)), low
    while level <= high:
        bottom, top = lowest(level, drift.bottom, wall) - reach - z[0], highest(level, wall) + reach - z[0]
        kept = within(room, corners, count, bottom, top, 2)
        if kept > 0:
            if (waiting + 1) * size > len(room.stack):
                return -1
            put(
                room.stack,
                waiting * size,
                z,
                before,
                ring,
                head,
                error,
                level,
                sample + 0.5,
                weight,
                room.halves,
                kept,
                room.middle,
                drift,
                2,
            )
            waiting += 1
        level = next_level(level, wall)
    return waiting
