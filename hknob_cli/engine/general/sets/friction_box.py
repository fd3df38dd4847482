"""Pieces with Coulomb friction, followed until each lies inside what a proven orbit captures, or comes to rest.

As `box`, but that pieces are moved sample by sample: what friction does to their states is no one matrix.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import GREW, UNSETTLED
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets.box import ENDED, KEPT, PARTED, SECTION, SMALL, UNPROVEN
from hknob_cli.engine.general.sets.cell import Centre, acting_as
from hknob_cli.engine.general.sets.convex import extent, widest
from hknob_cli.engine.general.sets.friction_piece import move_piece, part_piece
from hknob_cli.engine.general.sets.friction_rest import UNKNOWN, resting_piece
from hknob_cli.engine.general.sets.known import NO_ROOM, blame, captor, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.lattice import keep
from hknob_cli.engine.general.sets.memory import watched
from hknob_cli.engine.general.sets.piece import COUNT, SAMPLE, SPREAD, STATE, WEIGHT, take
from hknob_cli.engine.general.sets.readings import steps_deeper
from hknob_cli.engine.general.sets.turns import count_of, half_of, level_at

OFTEN = 8  # samples from one chance of wide pieces to be merged to the next


def take_piece(room, waiting):
    """Leave the piece that waits at this place in ``room.own``, and its corners: ``(centre, number of corners)``."""
    own, size = room.own, len(room.own)
    for k in range(size):
        own[k] = room.stack[waiting * size + k]
    centre, count = take(own, room.own_z, room.own_ring), int(own[COUNT])
    first = STATE + len(centre.z) + len(centre.ring)
    for k in range(2 * count):
        room.corners[k] = own[first + k]
    return centre, count


def readings_of(centre, low, high, half, watch, cell):
    """Least and largest reading of a piece whose states lie from ``low`` to ``high``, roundings included."""
    turns, bottom = cell.known.turns, cell.drift.bottom
    shown = count_of(turns, cell.known.law, centre.before, centre.ring)
    return level_at(turns, low, shown, half, bottom, watch), level_at(turns, high, shown, half, bottom, watch)


def follow_piece(room, work, waiting, width, scope, cell):
    """Follow the last piece that waits until it ends, is parted or kept: ``(waiting, fate, row, samples)``.

    ``row``: of the attractor where it ended.
    """
    drift, known, body, turns = cell.drift, cell.known, cell.body, cell.known.turns
    own, corners = room.own, room.corners
    size = len(own)
    waiting -= 1
    start = int(room.stack[waiting * size + SAMPLE])
    since, wait, taken = start % scope.patience, scope.patience, 0
    watch = watched(known.law, cell.wall)
    half = half_of(turns, False, watch)
    while True:
        centre, count = take_piece(room, waiting)
        z, last, at, weight = centre.z, centre.level, int(centre.sample), centre.weight
        radius = widest(corners, count, body)
        ahead = centre.error  # with all that torques may still add
        if body.lag > 0.0:
            ahead += own[SPREAD] / body.lag
        least, most, _, _ = extent(corners, count)
        if at >= scope.budget or not -scope.limit < z[0] < scope.limit:
            blame(UNSETTLED if at >= scope.budget else GREW, weight, known)
            return waiting, UNPROVEN, -1, taken
        reach = body.reach * centre.error + 8.0 * EPSILON * abs(z[0])
        settled = centre.sample > at
        level, high = last, last
        if not settled:
            level, high = readings_of(centre, z[0] + least - reach, z[0] + most + reach, half, watch, cell)
        whole = Centre(z, centre.before, centre.ring, centre.head, centre.error, last, float(at), weight)
        taken += 1
        if level < high:
            parted = part_piece(room, waiting, whole, count, level, high, reach, cell)
            if parted < 0:
                blame(NO_ROOM, weight, known)
                return waiting, UNPROVEN, -1, taken
            return parted, PARTED, -1, taken
        acts = acting_as(whole, level, whole.before, whole.error)
        deeper = steps_deeper(level, last, watch)
        row = UNKNOWN
        if deeper:
            row = captor(z, whole.before, whole.ring, whole.head, radius + ahead, known, body, cell.wall)
        elif level == last or at == 0:
            row = resting_piece(acts, ahead, radius, corners, count, cell)
        if row >= 0:
            return waiting, ENDED, row, taken
        small = body.reach * (radius + centre.error) < SMALL * width
        meets = at > start and (deeper or (width > SECTION and at % OFTEN == 0))
        if (meets and small) and keep(room, whole, corners, count, width, drift, body):
            return waiting, KEPT, -1, taken
        if since >= wait:
            since, wait = 0, 2 * wait
            row, steps = seek(whole, scope, cell)
            taken += steps
            if body.halt[0] > 0.0:
                return waiting + 1, PARTED, -1, taken  # as it was, among those that wait
            if not is_proven(row, known):
                blame(fate_of(row, known), weight, known)
                return waiting, UNPROVEN, -1, taken
        after = move_piece(room, work, waiting, acts, count, cell)
        since += 1
        if after < 0:
            blame(NO_ROOM, weight, known)
            return waiting, UNPROVEN, -1, taken
        if after != waiting + 1:
            return after, PARTED, -1, taken


def follow_friction(room, work, waiting, width, samples, scope, cell):
    """Follow pieces until none waits or ``samples`` are taken: ``(waiting, pieces, undecided, samples)``.

    As `box.follow_generation`. Without friction the measures of pieces are areas, which their ends take. Behind
    hysteresis parts of a piece overlap, so that they are bounds.
    """
    ended, undecided, taken, body = 0, 0.0, 0, cell.body
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        weight = room.stack[(waiting - 1) * len(room.own) + WEIGHT]
        waiting, fate, row, steps = follow_piece(room, work, waiting, width, scope, cell)
        taken += steps
        if fate == UNPROVEN:
            undecided += weight
        if fate == ENDED and body.friction == 0.0 and cell.known.turns is None:
            cell.known.table[row * FIELDS + 6] += weight
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken
