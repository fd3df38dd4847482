"""Pieces of knob and hand with Coulomb friction: moved over one interval, and cut where a reading meets a count edge.

A piece is as in `piece`. Where all its corners have the velocity 0, all its states have exactly that, with no error:
friction holds them. Under a law that reads its encoder within an interval, too, a piece is cut there as well, and each
part remembers what it read. States differ in angle and speed alone: a torque that lags is the same for all of a piece.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, area_of, drop_edge, keep_side, widen, widest
from hknob_cli.engine.general.sets.friction_set import (
    ACTS,
    LATE,
    LEG,
    LOOK,
    SHOWN,
    SPAN,
    TORQUE,
    F,
    G,
    S,
    begin_set,
    part_weight,
    room_for_sets,
    take_set,
)
from hknob_cli.engine.general.sets.friction_step import CUT, HELD, MOST_CUTS, Hold, Room, Shape, move_set
from hknob_cli.engine.general.sets.friction_turns import tell_count
from hknob_cli.engine.general.sets.lagged_step import DEEPEST, LATER, depth_at, move_lagged
from hknob_cli.engine.general.sets.lagged_stops import LAGS, LEFT, LaggedHold
from hknob_cli.engine.general.sets.memory import command_all, first_look, watched
from hknob_cli.engine.general.sets.piece import SPREAD, halve, put, within
from hknob_cli.engine.general.sets.readings import remembered
from hknob_cli.engine.general.sets.turns import count_of, half_of, highest_at, keep_count, level_at, lowest_at, next_at

TINY = 1e-290  # a velocity that is not 0; beside one of the centre's size a unit in its last place


def stands(v, corners, count):
    """Whether all states of a piece have the velocity 0."""
    for k in range(count):
        if v + corners[2 * k + 1] != 0.0:
            return False
    return True


def begin_halves(room, work, at, place, count, body):
    """Enter the set in ``room.halves``, simpler if it has too many corners; how many sets there are then.

    With friction the simpler one is around it. Without, where measures are areas, it is in two halves.
    """
    part, x, v, weight = place
    if count > MOST_CORNERS and body.friction == 0.0:
        whole = area_of(room.halves, count)
        count, other = halve(room, count, 2)
        share = part_weight(weight, whole, room.parts, other, body)
        begin_set(work, at, (part, x, v, share), 0, room.parts, other)
        weight = part_weight(weight, whole, room.halves, count, body)
        at += 1
    while count > MOST_CORNERS:
        count = drop_edge(room.halves, count)
    begin_set(work, at, (part, x, v, weight), 0, room.halves, count)
    return at + 1


def look_at_set(room, work, at, place, count, error, look, cell):
    """Cut the set in ``work.corners`` where a look into the interval tells readings apart; how many sets there are.

    As `part_piece` does at a sample: each part goes beyond its edges by what ``error`` may come to. -1: no room.
    """
    drift, body, turns, watch = cell.drift, cell.body, cell.known.turns, watched(cell.known.law, cell.wall)
    part, x, v, weight = place
    half, shown = half_of(turns, False, watch), work.acts[SHOWN - LATE]
    least, most = work.corners[0], work.corners[0]
    for k in range(1, count):
        least, most = min(least, work.corners[2 * k]), max(most, work.corners[2 * k])
    reach = body.reach * error + 8.0 * EPSILON * abs(x)
    level = level_at(turns, x + least - reach, shown, half, drift.bottom, watch)
    last = level_at(turns, x + most + reach, shown, half, drift.bottom, watch)
    whole, room_for = area_of(work.corners, count), room_for_sets(work)
    while level <= last:
        bottom = lowest_at(turns, level, shown, half, drift.bottom, watch) - reach - x
        top = highest_at(turns, level, shown, half, watch) + reach - x
        kept = within(room, work.corners, count, bottom, top, 2)
        if kept > 0:
            if at + 2 > room_for:
                return -1
            work.seen[look] = level
            share = part_weight(weight, whole, room.halves, kept, body)
            at = begin_halves(room, work, at, (part, x, v, share), kept, body)
        level = next_at(turns, level, watch)
    return at


def cut_set(work, at, place, cuts, count):
    """Put both sides of a set that is cut by ``work.line`` in its place; how many sets there are then, 0: one side.

    The set itself is in ``work.corners``, and is left there.
    """
    a, b, c = work.line[0], work.line[1], work.line[2]
    over = keep_side(work.corners, count, a, b, c, work.one)
    under = keep_side(work.corners, count, -a, -b, -c, work.other)
    if over == 0 or under == 0:
        return 0
    begin_set(work, at, place, cuts + 1, work.one, over)
    begin_set(work, at + 1, place, cuts + 1, work.other, under)
    return at + 2


def move_over_part(work, place, count, least, body):
    """Move the set in ``work.corners`` over the part of a hold, or over half of it: ``(fate, x, v, late, count)``.

    ``work.acts`` tells the torque, and which half; ``late`` is the torque then. ``least``: as `friction_step.move_set`
    has it, infinite where the set is not to be cut.
    """
    part, x, v, _ = place
    leg = int(part) * LEG
    u = work.torques[int(work.course[leg + TORQUE])]
    shape, space = Shape(x, v, work.corners, count), Room(work.space, work.line, work.moved, work.pad)
    if work.lags is None:
        hold = Hold(work.course[leg + SPAN], work.course[leg + S], work.course[leg + G], work.course[leg + F])
        fate, x, v, count = move_set(shape, u, hold, least, body, space)
        return fate, x, v, 0.0, count
    at = int(work.halves[int(part)]) + int(work.acts[2]) * LAGS
    for k in range(LAGS):
        work.lag[k] = work.lags[at + k]
    lagged = LaggedHold(work.acts[0], work.acts[1], u, work.lag, work.acts[2] < DEEPEST)
    return move_lagged(shape, lagged, least, work.plane, body, space)


def end_set(room, work, waiting, place, count, centre, cell):
    """Let a set that has passed the interval wait as a piece, told from what ``centre`` has become; how many do then.

    -1: no room.
    """
    size = len(room.own)
    if (waiting + 1) * size > len(room.stack):
        return -1
    _, x, v, weight = place
    work.z[0], work.z[1] = x, v
    if cell.body.lag > 0.0:
        work.z[2] = work.acts[0]
    for k in range(len(work.seen)):
        work.ring[first_look(cell.known.law) + k] = work.seen[k]
    level, sample = centre.level, centre.sample + 1.0
    before = remembered(level, cell.wall)
    before = keep_count(cell.known.turns, cell.known.law, work.acts[SHOWN - LATE], before, work.ring)
    end = Centre(work.z, before, work.ring, centre.head, centre.error, level, sample, weight)
    put(room.stack, waiting * size, end, work.corners, count, room.middle, cell.drift, 2)
    room.stack[waiting * size + SPREAD] = work.acts[1]
    return waiting + 1


def move_piece(room, work, waiting, centre, count, cell):
    """Move the piece in ``room.corners`` over an interval, and let what becomes of it wait; how many then, -1: no room.

    It acts as its level. Its centre is left alone. The piece in ``room.own`` says how far torques that lag may differ
    from that of the centre.
    """
    drift, body, law, turns = cell.drift, cell.body, cell.known.law, cell.known.turns
    z, ring, error, delay = centre.z, centre.ring, centre.error, len(centre.ring)
    for j in range(delay):
        work.ring[j] = ring[(centre.head + j) % delay]
    to, largest = command_all(law, centre.level, centre.before, work.ring, cell.wall, work.torques)
    error += drift.once[0] + drift.once[1] * largest + drift.once[2] * abs(z[0]) + drift.once[3] * abs(z[1])
    for k in range(ACTS):
        work.acts[k] = 0.0
    if body.lag > 0.0:
        work.acts[0], work.acts[1] = z[2], room.own[SPREAD]
        error += drift.once[4] * abs(z[2])
    work.acts[SHOWN - LATE] = centre.level
    error += drift.blur * widest(room.corners, count, body)
    then = Centre(z, centre.before, ring, to, error, centre.level, centre.sample, centre.weight)
    legs, most = len(work.course) // LEG, room_for_sets(work)
    begin_set(work, 0, (0.0, z[0], z[1], centre.weight), 0, room.corners, count)
    sets = 1
    while sets > 0:
        sets -= 1
        place, cuts, kept = take_set(work, sets)
        part, _, _, weight = place
        if part == legs:
            waiting = end_set(room, work, waiting, place, kept, then, cell)
            if waiting < 0:
                return -1
            continue
        if turns is not None:
            sets, parted = tell_count(work, sets, place, cuts, kept, error, cell)
            if sets < 0:
                return -1
            if parted:
                continue
        least = work.least[0] if cuts < MOST_CUTS and sets + 2 <= most else float("inf")
        fate, x, v, later, after = move_over_part(work, place, kept, least, body)
        while fate == LATER:
            work.acts[2] += 1.0
            fate, x, v, later, after = move_over_part(work, place, kept, least, body)
        if fate == CUT:
            more = cut_set(work, sets, place, cuts, kept)
            if more > 0:
                sets = more
                continue
            # Within rounding of the line: the enclosure is taken as it is.
            fate, x, v, later, after = move_over_part(work, place, kept, float("inf"), body)
        if body.friction > 0.0:
            while after > MOST_CORNERS:
                after = drop_edge(work.corners, after)
        if fate != HELD and stands(v, work.corners, after):
            after = widen(work.corners, after, 0.0, TINY + EPSILON * abs(v), work.space)
        look, passed = int(work.course[int(part) * LEG + LOOK]), part + 1.0
        if body.lag > 0.0:
            passed = part + 0.5 ** work.acts[2]
            work.acts[0], work.acts[1] = later, work.acts[1] * work.lag[LEFT]
            work.acts[2] = depth_at(passed, work.acts[2])
        if look >= 0 and passed % 1.0 == 0.0:
            sets = look_at_set(room, work, sets, (passed, x, v, weight), after, error, look, cell)
            if sets < 0:
                return -1
            continue
        if sets + 2 > most:
            return -1
        for k in range(2 * after):
            room.halves[k] = work.corners[k]
        sets = begin_halves(room, work, sets, (passed, x, v, weight), after, body)
    return waiting


def part_piece(room, waiting, centre, count, low, high, reach, cell):
    """Cut the piece in ``room.corners`` where the command changes; how many pieces wait then, -1: no room.

    ``low`` and ``high``: the readings it has; ``reach``: position by which each part goes beyond its edges. So whatever
    a state truly reads, a part that acts as this reading holds the state. A part waits at the same sample: half a
    sample more says that how it acts is settled.
    """
    drift, body, turns, watch = cell.drift, cell.body, cell.known.turns, watched(cell.known.law, cell.wall)
    size, level, whole = len(room.own), low, area_of(room.corners, count)
    z, sample, half = centre.z, centre.sample + 0.5, half_of(turns, False, watch)
    shown = count_of(turns, cell.known.law, centre.before, centre.ring)
    while level <= high:
        bottom = lowest_at(turns, level, shown, half, drift.bottom, watch) - reach - z[0]
        top = highest_at(turns, level, shown, half, watch) + reach - z[0]
        kept = within(room, room.corners, count, bottom, top, 2)
        if kept > 0:
            if (waiting + 1) * size > len(room.stack):
                return -1
            weight = part_weight(centre.weight, whole, room.halves, kept, body)
            acts = Centre(z, centre.before, centre.ring, centre.head, centre.error, level, sample, weight)
            put(room.stack, waiting * size, acts, room.halves, kept, room.middle, drift, 2)
            room.stack[waiting * size + SPREAD] = room.own[SPREAD]
            waiting += 1
        level = next_at(turns, level, watch)
    return waiting
