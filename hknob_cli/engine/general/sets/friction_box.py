"""Pieces with Coulomb friction, followed until each lies inside what a proven orbit captures, or comes to rest.

As `box`, but that pieces are moved sample by sample: what friction does to their states is no one matrix.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import GREW, UNSETTLED
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets.box import ENDED, KEPT, PARTED, SECTION, SMALL, UNPROVEN
from hknob_cli.engine.general.sets.convex import widest
from hknob_cli.engine.general.sets.friction_piece import move_piece, part_piece
from hknob_cli.engine.general.sets.friction_rest import UNKNOWN, resting_piece
from hknob_cli.engine.general.sets.known import NO_ROOM, blame, captor, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.lattice import keep
from hknob_cli.engine.general.sets.memory import watched
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
)
from hknob_cli.engine.general.sets.readings import acting, steps_deeper

OFTEN = 8  # samples from one chance of wide pieces to be merged to the next


def follow_piece(room, work, waiting, delay, width, patience, budget, limit, drift, known, body, wall):
    """Follow the last piece that waits until it ends, is parted or kept: ``(waiting, fate, row, samples)``.

    ``row``: of the attractor where it ended.
    """
    own, corners, z, ring = room.own, room.corners, room.own_z, room.own_ring
    n = body.order
    size = piece_size(n, delay)
    waiting -= 1
    start = int(room.stack[waiting * size + SAMPLE])
    since, wait, taken = start % patience, patience, 0
    watch = watched(known.law, wall)
    while True:
        for k in range(size):
            own[k] = room.stack[waiting * size + k]
        for j in range(n):
            z[j] = own[STATE + j]
        for j in range(delay):
            ring[j] = own[STATE + n + j]
        error, before, last, at = own[ERROR], own[BEFORE], own[LEVEL], int(own[SAMPLE])
        count, weight, edges = int(own[COUNT]), own[WEIGHT], STATE + n + delay
        for k in range(2 * count):
            corners[k] = own[edges + k]
        radius = widest(corners, count, body)
        ahead = error  # with all that torques may still add
        if body.lag > 0.0:
            ahead += own[SPREAD] / body.lag
        least, most = corners[0], corners[0]
        for k in range(1, count):
            least, most = min(least, corners[2 * k]), max(most, corners[2 * k])
        if at >= budget or not -limit < z[0] < limit:
            blame(UNSETTLED if at >= budget else GREW, weight, known)
            return waiting, UNPROVEN, -1, taken
        reach = body.reach * error + 8.0 * EPSILON * abs(z[0])
        settled = own[SAMPLE] > at
        level = last if settled else acting(z[0] + least - reach, drift.bottom, watch)
        high = last if settled else acting(z[0] + most + reach, drift.bottom, watch)
        taken += 1
        if level < high:
            parted = part_piece(
                room,
                waiting,
                z,
                before,
                ring,
                0 * delay,
                error,
                reach,
                float(at),
                weight,
                corners,
                count,
                level,
                high,
                drift,
                body,
                watch,
            )
            if parted < 0:
                blame(NO_ROOM, weight, known)
                return waiting, UNPROVEN, -1, taken
            return parted, PARTED, -1, taken
        deeper = steps_deeper(level, last, watch)
        row = UNKNOWN
        if deeper:
            row = captor(z, before, ring, 0 * delay, radius + ahead, known, body, wall)
        elif level == last or at == 0:
            row = resting_piece(z, before, ring, ahead, radius, level, corners, count, known, drift, body, wall)
        if row >= 0:
            return waiting, ENDED, row, taken
        small = body.reach * (radius + error) < SMALL * width
        meets = at > start and (deeper or (width > SECTION and at % OFTEN == 0))
        sample = float(at)
        if (meets and small) and keep(
            room, z, before, ring, 0 * delay, error, last, sample, weight, corners, count, width, drift, body
        ):
            return waiting, KEPT, -1, taken
        if since >= wait:
            since, wait = 0, 2 * wait
            row, steps = seek(z, before, ring, 0 * delay, budget - at, limit, known, body, wall)
            taken += steps
            if body.halt[0] > 0.0:
                return waiting + 1, PARTED, -1, taken  # as it was, among those that wait
            if not is_proven(row, known):
                blame(fate_of(row, known), weight, known)
                return waiting, UNPROVEN, -1, taken
        after = move_piece(
            room,
            work,
            waiting,
            z,
            before,
            ring,
            0 * delay,
            error,
            level,
            sample,
            weight,
            corners,
            count,
            drift,
            body,
            wall,
        )
        since += 1
        if after < 0:
            blame(NO_ROOM, weight, known)
            return waiting, UNPROVEN, -1, taken
        if after != waiting + 1:
            return after, PARTED, -1, taken


def follow_friction(room, work, waiting, delay, width, patience, budget, limit, samples, drift, known, body, wall):
    """Follow pieces until none waits or ``samples`` are taken: ``(waiting, pieces, undecided, samples)``.

    As `box.follow_generation`. Without friction the measures of pieces are areas, which their ends take.
    """
    ended, undecided, taken = 0, 0.0, 0
    size = piece_size(body.order, delay)
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        weight = room.stack[(waiting - 1) * size + WEIGHT]
        waiting, fate, row, steps = follow_piece(
            room, work, waiting, delay, width, patience, budget, limit, drift, known, body, wall
        )
        taken += steps
        if fate == UNPROVEN:
            undecided += weight
        if fate == ENDED and body.friction == 0.0:
            known.table[row * FIELDS + 6] += weight
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken
