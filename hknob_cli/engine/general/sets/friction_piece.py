"""Pieces of knob and hand with Coulomb friction: moved over one interval, and cut where a reading meets a count edge.

A piece is as in `piece`. Where all its corners have the velocity 0, all its states have exactly that, with no error:
friction holds them. Under a law that reads its encoder within an interval, too, a piece is cut there as well, and each
part remembers what it read. States differ in angle and speed alone: a torque that lags is the same for all of a piece.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, area_of, drop_edge, keep_side, widen, widest
from hknob_cli.engine.general.sets.friction_step import CUT, HELD, MOST_CUTS, move_set
from hknob_cli.engine.general.sets.lagged_step import DEEPEST, LAGS, LATER, LEFT, depth_at, move_lagged
from hknob_cli.engine.general.sets.memory import command_all, first_look, looks_of, watched
from hknob_cli.engine.general.sets.piece import SPREAD, halve, piece_size, put, within
from hknob_cli.engine.general.sets.readings import acting, highest, lowest, next_level, remembered

PART, CUTS, LATE, APART, DEPTH, X, V, WEIGHT, COUNT, CORNERS = range(10)  # numbers of a set within an interval
# Of these, with a lag: the torque that acts, by which those of its states may differ from it, and halvings of the part
# of a hold that is to be tried next.
ACTS = 3
MOST = MOST_CORNERS + 2 + MOST_CUTS + 2  # corners of one
SET = CORNERS + 2 * MOST  # numbers of one; then the readings of its looks into the interval so far
SETS = 256  # of one piece within an interval, at most
SETS_LOOKED = 2048  # the same where it is cut within the interval, too
# Numbers of a part of an interval: which of the torques acts, the plant, and which look is at its end, or -1.
TORQUE, SPAN, S, G, F, LOOK = range(6)
LEG = 6
TINY = 1e-290  # a velocity that is not 0; beside one of the centre's size a unit in its last place
LEAST_PART = 1e-30  # of an area: an end that any state reaches has a share
LEAST_WEIGHT = 1e-300  # of the part of a part: products of such shares would round to none


def stands(v, corners, count):
    """Whether all states of a piece have the velocity 0."""
    for k in range(count):
        if v + corners[2 * k + 1] != 0.0:
            return False
    return True


def part_weight(weight, whole, corners, count, body):
    """Measure of the starts of a part of a set with this ``weight`` and the area ``whole``; or a bound on it.

    Without friction the differences of all states go by one matrix, which keeps ratios of areas.
    """
    if body.friction > 0.0 or not whole > 0.0:
        return weight
    return max(weight * min(max(area_of(corners, count) / whole, LEAST_PART), 1.0), LEAST_WEIGHT)


def begin_set(work, at, part, cuts, x, v, weight, corners, count):
    """Enter a set that is ``part`` parts into the interval, is cut so often in this one, and has read ``work.seen``.

    With a lag ``part`` may end in a fraction, and ``work.acts`` has the torque that acts.
    """
    looks = looks_of(work.law)
    base = at * (SET + looks)
    work.sets[base + PART], work.sets[base + CUTS], work.sets[base + COUNT] = part, float(cuts), float(count)
    for k in range(ACTS):
        work.sets[base + LATE + k] = work.acts[k]
    work.sets[base + X], work.sets[base + V], work.sets[base + WEIGHT] = x, v, weight
    for k in range(2 * count):
        work.sets[base + CORNERS + k] = corners[k]
    for k in range(looks):
        work.sets[base + SET + k] = work.seen[k]


def begin_halves(room, work, at, part, x, v, weight, count, body):
    """Enter the set in ``room.halves``, simpler if it has too many corners; how many sets there are then.

    With friction the simpler one is around it. Without, where measures are areas, it is in two halves.
    """
    if count > MOST_CORNERS and body.friction == 0.0:
        whole = area_of(room.halves, count)
        count, other = halve(room, count, 2)
        begin_set(work, at, part, 0, x, v, part_weight(weight, whole, room.parts, other, body), room.parts, other)
        weight = part_weight(weight, whole, room.halves, count, body)
        at += 1
    while count > MOST_CORNERS:
        count = drop_edge(room.halves, count)
    begin_set(work, at, part, 0, x, v, weight, room.halves, count)
    return at + 1


def look_at_set(room, work, at, part, x, v, weight, count, error, look, body, drift, wall):
    """Cut the set in ``work.corners`` where a look into the interval tells readings apart; how many sets there are.

    As `part_piece` does at a sample: each part goes beyond its edges by what ``error`` may come to. -1: no room.
    """
    watch = watched(work.law, wall)
    least, most = work.corners[0], work.corners[0]
    for k in range(1, count):
        least, most = min(least, work.corners[2 * k]), max(most, work.corners[2 * k])
    reach = body.reach * error + 8.0 * EPSILON * abs(x)
    level, last = acting(x + least - reach, drift.bottom, watch), acting(x + most + reach, drift.bottom, watch)
    whole, room_for = area_of(work.corners, count), len(work.sets) // (SET + looks_of(work.law))
    while level <= last:
        bottom, top = lowest(level, drift.bottom, watch) - reach - x, highest(level, watch) + reach - x
        kept = within(room, work.corners, count, bottom, top, 2)
        if kept > 0:
            if at + 2 > room_for:
                return -1
            work.seen[look] = level
            share = part_weight(weight, whole, room.halves, kept, body)
            at = begin_halves(room, work, at, part, x, v, share, kept, body)
        level = next_level(level, watch)
    return at


def cut_set(work, at, part, cuts, x, v, weight, count):
    """Put both sides of a set that is cut by ``work.line`` in its place; how many sets there are then, 0: one side.

    The set itself is in ``work.corners``, and is left there.
    """
    a, b, c = work.line[0], work.line[1], work.line[2]
    over = keep_side(work.corners, count, a, b, c, work.one)
    under = keep_side(work.corners, count, -a, -b, -c, work.other)
    if over == 0 or under == 0:
        return 0
    begin_set(work, at, part, cuts + 1, x, v, weight, work.one, over)
    begin_set(work, at + 1, part, cuts + 1, x, v, weight, work.other, under)
    return at + 2


def move_over_part(lags, work, part, x, v, count, least, body):
    """Move the set in ``work.corners`` over the part of a hold, or over half of it: ``(fate, x, v, late, count)``.

    ``lags``: None without a lag, and the compiler leaves out what only a lag needs. ``work.acts`` tells the torque, and
    which half; ``late`` is the torque then. ``least``: as `friction_step.move_set` has it, infinite where the set is
    not to be cut.
    """
    leg = int(part) * LEG
    u = work.torques[int(work.course[leg + TORQUE])]
    if lags is None:
        span, s, g, f = work.course[leg + SPAN], work.course[leg + S], work.course[leg + G], work.course[leg + F]
        fate, x, v, count = move_set(x, v, u, span, s, g, f, work.corners, count, least, body, work.space, work.line)
        return fate, x, v, 0.0, count
    at = int(work.halves[int(part)]) + int(work.acts[2]) * LAGS
    for k in range(LAGS):
        work.lag[k] = lags[at + k]
    halve = work.acts[2] < DEEPEST
    return move_lagged(
        x,
        v,
        work.acts[0],
        work.acts[1],
        u,
        work.lag,
        halve,
        work.corners,
        count,
        least,
        work.plane,
        body,
        work.space,
        work.line,
        work.moved,
        work.pad,
    )


def move_piece(
    room, work, waiting, z, before, ring, head, error, level, sample, weight, corners, count, drift, body, wall
):
    """Move a piece over one interval, acting as ``level``, and let what becomes of it wait; how many then, -1: no room.

    The piece is told from ``z``, which is left alone, as ``ring`` is. The piece in ``room.own`` says how far
    torques that lag may differ from that of ``z``.
    """
    delay = len(ring)
    for j in range(delay):
        work.ring[j] = ring[(head + j) % delay]
    to, largest = command_all(work.law, level, before, work.ring, wall, work.torques)
    error += drift.once[0] + drift.once[1] * largest + drift.once[2] * abs(z[0]) + drift.once[3] * abs(z[1])
    for k in range(ACTS):
        work.acts[k] = 0.0
    if body.lag > 0.0:
        work.acts[0], work.acts[1] = z[2], room.own[SPREAD]
        error += drift.once[4] * abs(z[2])
    error += drift.blur * widest(corners, count, body)
    legs, looks, size = len(work.course) // LEG, looks_of(work.law), piece_size(len(z), delay)
    wide = SET + looks
    most = len(work.sets) // wide
    begin_set(work, 0, 0.0, 0, z[0], z[1], weight, corners, count)
    sets = 1
    while sets > 0:
        sets -= 1
        base = sets * wide
        part, cuts, kept = work.sets[base + PART], int(work.sets[base + CUTS]), int(work.sets[base + COUNT])
        for k in range(ACTS):
            work.acts[k] = work.sets[base + LATE + k]
        x, v, weight = work.sets[base + X], work.sets[base + V], work.sets[base + WEIGHT]
        for k in range(2 * kept):
            work.corners[k] = work.sets[base + CORNERS + k]
        for k in range(looks):
            work.seen[k] = work.sets[base + SET + k]
        if part == legs:
            if (waiting + 1) * size > len(room.stack):
                return -1
            work.z[0], work.z[1] = x, v
            if body.lag > 0.0:
                work.z[2] = work.acts[0]
            for k in range(looks):
                work.ring[first_look(work.law) + k] = work.seen[k]
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
            room.stack[waiting * size + SPREAD] = work.acts[1]
            waiting += 1
            continue
        least = work.least[0] if cuts < MOST_CUTS and sets + 2 <= most else float("inf")
        fate, to_x, to_v, later, after = move_over_part(work.lags, work, part, x, v, kept, least, body)
        while fate == LATER:
            work.acts[2] += 1.0
            fate, to_x, to_v, later, after = move_over_part(work.lags, work, part, x, v, kept, least, body)
        if fate == CUT:
            more = cut_set(work, sets, part, cuts, x, v, weight, kept)
            if more > 0:
                sets = more
                continue
            # Within rounding of the line: the enclosure is taken as it is.
            fate, to_x, to_v, later, after = move_over_part(work.lags, work, part, x, v, kept, float("inf"), body)
        if body.friction > 0.0:
            while after > MOST_CORNERS:
                after = drop_edge(work.corners, after)
        if fate != HELD and stands(to_v, work.corners, after):
            after = widen(work.corners, after, 0.0, TINY + EPSILON * abs(to_v), work.space)
        look, then = int(work.course[int(part) * LEG + LOOK]), part + 1.0
        if body.lag > 0.0:
            then = part + 0.5 ** work.acts[2]
            work.acts[0], work.acts[1] = later, work.acts[1] * work.lag[LEFT]
            work.acts[2] = depth_at(then, work.acts[2])
        if look >= 0 and then % 1.0 == 0.0:
            sets = look_at_set(room, work, sets, then, to_x, to_v, weight, after, error, look, body, drift, wall)
            if sets < 0:
                return -1
            continue
        if sets + 2 > most:
            return -1
        for k in range(2 * after):
            room.halves[k] = work.corners[k]
        sets = begin_halves(room, work, sets, then, to_x, to_v, weight, after, body)
    return waiting


def part_piece(
    room, waiting, z, before, ring, head, error, reach, sample, weight, corners, count, low, high, drift, body, wall
):
    """Cut a piece at the edges that change the command, and let the parts wait; how many pieces wait then, -1: no room.

    ``low`` and ``high``: the readings it has; ``reach``: position by which each part goes beyond its edges. So whatever
    a state truly reads, a part that acts as this reading holds the state. A part waits at the same sample: half a
    sample more says that how it acts is settled.
    """
    size, level, whole = piece_size(len(z), len(ring)), low, area_of(corners, count)
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
                part_weight(weight, whole, room.halves, kept, body),
                room.halves,
                kept,
                room.middle,
                drift,
                2,
            )
            room.stack[waiting * size + SPREAD] = room.own[SPREAD]
            waiting += 1
        level = next_level(level, wall)
    return waiting
