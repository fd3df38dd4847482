"""Pieces of knob and hand with Coulomb friction: moved over one interval, and cut where a reading meets a count edge.

A piece is as in `piece`. Where all its corners have the velocity 0, all its states have exactly that, with no error:
friction holds them. Under a law that reads its encoder within an interval, too, a piece is cut there as well, and each
part remembers what it read. States differ in angle and speed alone: a torque that lags is the same for all of a piece.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, area_of, drop_edge, keep_side, widen, widest
from hknob_cli.engine.general.sets.friction_step import CUT, HELD, MOST_CUTS, Hold, Room, Shape, move_set
from hknob_cli.engine.general.sets.lagged_step import DEEPEST, LATER, depth_at, move_lagged
from hknob_cli.engine.general.sets.lagged_stops import LAGS, LEFT, LaggedHold
from hknob_cli.engine.general.sets.memory import command_all, first_look, watched
from hknob_cli.engine.general.sets.piece import SPREAD, halve, put, within
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


def begin_set(work, at, place, cuts, corners, count):
    """Enter a set that is cut so often in its part of an interval, and has read ``work.seen``.

    ``place``: how many parts of the interval it has passed, its centre's position and velocity, and its weight. With
    a lag the parts may end in a fraction, and ``work.acts`` has the torque that acts.
    """
    looks = len(work.seen)
    base = at * (SET + looks)
    work.sets[base + PART], work.sets[base + X], work.sets[base + V], work.sets[base + WEIGHT] = place
    work.sets[base + CUTS], work.sets[base + COUNT] = float(cuts), float(count)
    for k in range(ACTS):
        work.sets[base + LATE + k] = work.acts[k]
    for k in range(2 * count):
        work.sets[base + CORNERS + k] = corners[k]
    for k in range(looks):
        work.sets[base + SET + k] = work.seen[k]


def take_set(work, at):
    """Leave in ``work`` the set that waits at this place: its place in the interval, how often it is cut, corners."""
    base = at * (SET + len(work.seen))
    count = int(work.sets[base + COUNT])
    for k in range(ACTS):
        work.acts[k] = work.sets[base + LATE + k]
    for k in range(2 * count):
        work.corners[k] = work.sets[base + CORNERS + k]
    for k in range(len(work.seen)):
        work.seen[k] = work.sets[base + SET + k]
    place = work.sets[base + PART], work.sets[base + X], work.sets[base + V], work.sets[base + WEIGHT]
    return place, int(work.sets[base + CUTS]), count


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
    drift, body, watch = cell.drift, cell.body, watched(cell.known.law, cell.wall)
    part, x, v, weight = place
    least, most = work.corners[0], work.corners[0]
    for k in range(1, count):
        least, most = min(least, work.corners[2 * k]), max(most, work.corners[2 * k])
    reach = body.reach * error + 8.0 * EPSILON * abs(x)
    level, last = acting(x + least - reach, drift.bottom, watch), acting(x + most + reach, drift.bottom, watch)
    whole, room_for = area_of(work.corners, count), len(work.sets) // (SET + len(work.seen))
    while level <= last:
        bottom, top = lowest(level, drift.bottom, watch) - reach - x, highest(level, watch) + reach - x
        kept = within(room, work.corners, count, bottom, top, 2)
        if kept > 0:
            if at + 2 > room_for:
                return -1
            work.seen[look] = level
            share = part_weight(weight, whole, room.halves, kept, body)
            at = begin_halves(room, work, at, (part, x, v, share), kept, body)
        level = next_level(level, watch)
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
    before, level, sample = remembered(centre.level, cell.wall), centre.level, centre.sample + 1.0
    end = Centre(work.z, before, work.ring, centre.head, centre.error, level, sample, weight)
    put(room.stack, waiting * size, end, work.corners, count, room.middle, cell.drift, 2)
    room.stack[waiting * size + SPREAD] = work.acts[1]
    return waiting + 1


def move_piece(room, work, waiting, centre, count, cell):
    """Move the piece in ``room.corners`` over an interval, and let what becomes of it wait; how many then, -1: no room.

    It acts as its level. Its centre is left alone. The piece in ``room.own`` says how far torques that lag may differ
    from that of the centre.
    """
    drift, body, law = cell.drift, cell.body, cell.known.law
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
    error += drift.blur * widest(room.corners, count, body)
    then = Centre(z, centre.before, ring, to, error, centre.level, centre.sample, centre.weight)
    legs, most = len(work.course) // LEG, len(work.sets) // (SET + len(work.seen))
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
    drift, body, watch = cell.drift, cell.body, watched(cell.known.law, cell.wall)
    size, level, whole = len(room.own), low, area_of(room.corners, count)
    z, sample = centre.z, centre.sample + 0.5
    while level <= high:
        bottom, top = lowest(level, drift.bottom, watch) - reach - z[0], highest(level, watch) + reach - z[0]
        kept = within(room, room.corners, count, bottom, top, 2)
        if kept > 0:
            if (waiting + 1) * size > len(room.stack):
                return -1
            weight = part_weight(centre.weight, whole, room.halves, kept, body)
            acts = Centre(z, centre.before, centre.ring, centre.head, centre.error, level, sample, weight)
            put(room.stack, waiting * size, acts, room.halves, kept, room.middle, drift, 2)
            room.stack[waiting * size + SPREAD] = room.own[SPREAD]
            waiting += 1
        level = next_level(level, watch)
    return waiting
