"""Pieces beside cogging, followed until each lies inside what a proven orbit captures, or comes to rest.

As `friction_box`. A piece whose centre ends in nothing that is proven ends the search: no list is complete then.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import GREW, UNSETTLED
from hknob_cli.engine.general.cogging import unit_reach
from hknob_cli.engine.general.sets.box import ENDED, KEPT, PARTED, SECTION, SMALL, UNPROVEN
from hknob_cli.engine.general.sets.cell import Centre, acting_as
from hknob_cli.engine.general.sets.cog_fold import size_of_piece
from hknob_cli.engine.general.sets.cog_piece import move_piece, take_in_error
from hknob_cli.engine.general.sets.convex import extent
from hknob_cli.engine.general.sets.friction_arc import BEFORE, ERROR, STANDS
from hknob_cli.engine.general.sets.friction_arc_rest import rest_of_arc
from hknob_cli.engine.general.sets.friction_box import OFTEN, readings_of, take_piece
from hknob_cli.engine.general.sets.friction_piece import part_piece, stands
from hknob_cli.engine.general.sets.known import FULL, NO_ROOM, blame, captor, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.lattice import keep
from hknob_cli.engine.general.sets.memory import watched
from hknob_cli.engine.general.sets.piece import SAMPLE, WEIGHT
from hknob_cli.engine.general.sets.readings import steps_deeper
from hknob_cli.engine.general.sets.turns import half_of

LASTING = 24.0  # over the damping of a sample period: samples after which a piece that is not small is halved often


def rest_of_piece(room, rub, centre, reach, count, cell):
    """Row of the rest where all states of the piece in ``room.corners`` end, below 0 if none is known to.

    ``reach``: of the piece, by `cogging.size_at`.
    """
    delay = len(centre.ring)
    for j in range(len(centre.z)):
        rub.z[j] = centre.z[j]
    for j in range(delay):
        rub.ring[j] = centre.ring[(centre.head + j) % delay]
    rub.arc[BEFORE], rub.arc[ERROR] = centre.before, centre.error
    rub.arc[STANDS] = 1.0 if stands(centre.z[1], room.corners, count) else 0.0
    return rest_of_arc(rub, reach, centre.level, True, cell)


def follow_piece(room, rub, folds, waiting, width, scope, cell):
    """Follow the last piece that waits until it ends, is parted or kept: ``(waiting, fate, row, samples)``.

    ``row``: of the attractor where it ended.
    """
    drift, known, body, turns = cell.drift, cell.known, cell.body, cell.known.turns
    size, corners = len(room.own), room.corners
    waiting -= 1
    since, wait, taken = int(room.stack[waiting * size + SAMPLE]) % scope.patience, scope.patience, 0
    watch = watched(known.law, cell.wall)
    half = half_of(turns, False, watch)
    while True:
        centre, count = take_piece(room, waiting)
        z, last, at, weight = centre.z, centre.level, int(centre.sample), centre.weight
        settled = centre.sample > at
        radius = size_of_piece(corners, count, body)
        error, count = take_in_error(centre, room, count, radius, body)
        centre = acting_as(centre, last, centre.before, error)
        radius = size_of_piece(corners, count, body)
        least, most, _, _ = extent(corners, count)
        if at >= scope.budget or not -scope.limit < z[0] < scope.limit:
            blame(UNSETTLED if at >= scope.budget else GREW, weight, known)
            return waiting, UNPROVEN, -1, taken
        reach = unit_reach(body) * centre.error + 8.0 * EPSILON * abs(z[0])
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
        row = captor(z, whole.before, whole.ring, whole.head, radius + whole.error, known, body, cell.wall)
        if row < 0 and (level == last or at == 0):
            row = rest_of_piece(room, rub, acts, radius + whole.error, count, cell)
        if row >= 0:
            return waiting, ENDED, row, taken
        if row == FULL:
            blame(NO_ROOM, weight, known)
            return waiting, UNPROVEN, -1, taken
        deeper = steps_deeper(level, last, watch)
        small = body.reach * (radius + centre.error) < SMALL * width and 2 * room.counts[0] < len(room.used)
        meets = at > 0 and (deeper or (width > SECTION and at >= OFTEN))
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
        lasts = not small and at * body.alpha >= LASTING and at % OFTEN == 0 and not settled
        after = move_piece(room, rub, folds, waiting, acts, count, (small, lasts), cell)
        since += 1
        if after < 0:
            blame(NO_ROOM, weight, known)
            return waiting, UNPROVEN, -1, taken
        if after != waiting + 1:
            return after, PARTED, -1, taken


def follow_cogged(room, rub, folds, waiting, width, samples, scope, cell):
    """Follow pieces until none waits or ``samples`` are taken: ``(waiting, pieces, undecided, samples)``.

    As `box.follow_generation`. Measures of pieces are bounds.
    """
    ended, undecided, taken, body = 0, 0.0, 0, cell.body
    size = len(room.own)
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        weight = room.stack[(waiting - 1) * size + WEIGHT]
        waiting, fate, _, steps = follow_piece(room, rub, folds, waiting, width, scope, cell)
        taken += steps
        if fate == UNPROVEN:
            undecided += weight
            while waiting > 0:
                waiting -= 1
                undecided += room.stack[waiting * size + WEIGHT]
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken
