"""Every clock phase of one start, with Coulomb friction: intervals of phases, halved until each ends in one attractor.

The states at the first sample are a curve over the phase. That of an interval of phases lies near its chord: what it
may bulge is known from the rates of the free flight. So it is followed as a piece. Where the piece ends in more than
one attractor, the interval is halved, and both halves are followed from the beginning. Without friction, under a law,
an interval that is nearly straight needs no more halving: its attractors share it as the areas of the piece do.
"""

from math import sqrt

from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets.box import ENDED, PARTED
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.convex import area_of, widen
from hknob_cli.engine.general.sets.friction_box import follow_piece
from hknob_cli.engine.general.sets.friction_set import part_weight
from hknob_cli.engine.general.sets.known import NO_ROOM, blame
from hknob_cli.engine.general.sets.memory import begin_memory, watched
from hknob_cli.engine.general.sets.piece import WEIGHT, put, within
from hknob_cli.engine.general.sets.readings import remembered
from hknob_cli.engine.general.sets.turns import highest_at, level_at, lowest_at
from hknob_cli.engine.general.slide_two import coefficients, step_with_friction

FIRST = 16  # intervals to begin with
HALVINGS = 28
NARROWEST = 2.0**-HALVINGS / FIRST  # interval of phases that is not halved any more
STRAIGHT = 2.0**-16  # the same without friction
UNPROVEN = 2.0**-10  # interval that is not halved any more where it has no proven end
TOO_MANY = 4096  # pieces of one interval


def fly(angle, velocity, phase, body):
    """State after ``phase`` of a period of free flight, no torque commanded."""
    s, g, f = coefficients(phase, body)
    return step_with_friction(angle, velocity, 0.0, phase, s, g, f, body)


def is_narrow(low, high, body):
    """Whether an interval of phases is not halved any more."""
    return high - low <= (STRAIGHT if body.friction == 0.0 else NARROWEST)


def put_chord(start, span, weight, room, work, cell):
    """Let the states of an interval of phases wait, at the first sample; how many: one a reading, if that is kept.

    ``start``: angle and velocity; ``weight``: measure that a piece without a proven end counts. -1: no room.
    """
    drift, body, wall, law = cell.drift, cell.body, cell.wall, cell.known.law
    angle, velocity = start
    plane = work.plane if body.lag > 0.0 else body
    a, va = fly(angle, velocity, span[0], plane)
    b, vb = fly(angle, velocity, span[1], plane)
    x, v = 0.5 * (a + b), 0.5 * (va + vb)
    # The distance from the rest at zero pull never grows: bounds on speed and pull.
    away = angle - body.drive / body.beta
    fastest = sqrt(velocity * velocity + body.beta * away * away)
    rate = sqrt(body.beta) * fastest + body.friction + body.alpha * fastest
    part = span[1] - span[0]
    bulge = 0.125 * part * part * rate
    bulge_v = 0.125 * part * part * (body.beta * fastest + body.alpha * rate)
    if part >= plane.spacing:
        bulge_v += 0.5 * part * rate  # it may turn more than once
    elif not va * vb > 0.0:
        bulge_v += 0.5 * part * body.friction  # its rate may jump once, by at most twice the friction
    work.corners[0], work.corners[1], work.corners[2], work.corners[3] = a - x, va - v, b - x, vb - v
    count = widen(work.corners, 2, bulge * 1.001 + 1e-300, bulge_v * 1.001 + 1e-300, work.space)
    error = 4.0 * (drift.once[0] + drift.once[2] * (abs(angle) + abs(x)) + drift.once[3] * fastest)
    size, watch, turns = len(room.own), watched(law, wall), cell.known.turns
    apart = watch.damping > 0.0 or turns is not None
    work.z[0], work.z[1] = x, v
    least, most = work.corners[0], work.corners[0]
    for k in range(1, count):
        least, most = min(least, work.corners[2 * k]), max(most, work.corners[2 * k])
    reach = body.reach * error
    level, last, waiting, whole = 0.0, 0.0, 0, area_of(work.corners, count)
    if apart:
        level = level_at(turns, x + least - reach, 0.0, 0.0, drift.bottom, watch)
        last = level_at(turns, x + most + reach, 0.0, 0.0, drift.bottom, watch)
    while level <= last:
        kept = count
        for k in range(2 * count):
            room.halves[k] = work.corners[k]
        if apart:
            bottom = lowest_at(turns, level, level, 0.0, drift.bottom, watch) - reach - x
            top = highest_at(turns, level, level, 0.0, watch) + reach - x
            kept = within(room, work.corners, count, bottom, top, 2)
        if kept > 0:
            if (waiting + 1) * size > len(room.stack):
                return -1
            for j in range(2, len(work.z)):
                work.z[j] = 0.0
            begin_memory(law, level, work.ring)
            share, head = part_weight(weight, whole, room.halves, kept, body), 0 * len(work.ring)
            centre = Centre(work.z, remembered(level, wall), work.ring, head, error, 0.0, 0.0, share)
            put(room.stack, waiting * size, centre, room.halves, kept, room.middle, drift, 2)
            waiting += 1
        level += 1.0
    return waiting


def follow_interval(start, span, scope, room, work, cell):
    """Where an interval of phases ends: ``(row, other, proven, pieces, lost, samples)``.

    ``row`` of one attractor, ``other`` of a second, -1 where none; given up at the second unless the interval is one of
    the narrowest. ``proven``: whether all that was followed ended in attractors; ``lost``: the measure that did not. Of
    the narrowest without friction the shares are entered.
    """
    known, body, length = cell.known, cell.body, span[1] - span[0]
    row, other, proven, pieces, lost, taken = -1, -1, True, 0, 0.0, 0
    narrow = is_narrow(span[0], span[1], body)
    shared = narrow and body.friction == 0.0 and known.turns is None  # behind hysteresis parts overlap
    blamed = length if length <= UNPROVEN else 0.0
    waiting = put_chord(start, span, blamed, room, work, cell)
    if waiting < 0:
        proven, lost = False, blamed
        blame(NO_ROOM, blamed, known)
    while waiting > 0 and (narrow or (proven and other < 0)) and not body.halt[0] > 0.0:
        weight = room.stack[(waiting - 1) * len(room.own) + WEIGHT]
        waiting, fate, found, used = follow_piece(room, work, waiting, 0.0, scope, cell)
        taken += used
        if fate == PARTED:
            continue
        pieces += 1
        if pieces > TOO_MANY:
            blame(NO_ROOM, blamed, known)
        if fate != ENDED or pieces > TOO_MANY:
            proven = False
            lost += weight
            continue
        if shared:
            known.table[found * FIELDS + 6] += weight
        if row < 0:
            row = found
        elif found != row:
            other = found
    return row, other, proven, pieces, lost, taken


def follow_phases(start, first, samples, stack, scope, room, work, cell):
    """Follow the intervals of phases that wait until none does or ``samples`` are taken.

    Args:
        start: Angle, counts, and velocity, counts per sample.
        first: Intervals that wait, in ``stack``: low and high phase of each.
        samples: That may pass.
        stack: Room for `FIRST` + `HALVINGS` + 2 intervals.
        scope: `scope.Scope`.
        room: `room.PieceRoom`.
        work: `friction_room.FrictionRoom`.
        cell: `cell.Cell`, its bounds as `friction_room.friction_drift` has them; shares are entered into its table.

    Returns ``(waiting, ended, undecided, shortest, taken)``: intervals that wait still and that ended; the length of
    those without a proven end; the shortest; and samples.
    """
    waiting, ended, undecided, shortest, taken = first, 0, 0.0, 1.0, 0
    known, body = cell.known, cell.body
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        waiting -= 1
        low, high = stack[2 * waiting], stack[2 * waiting + 1]
        row, other, proven, pieces, lost, used = follow_interval(start, (low, high), scope, room, work, cell)
        taken += used
        if body.halt[0] > 0.0:
            return waiting + 1, ended, undecided, shortest, taken  # as it was, among those that wait
        narrow = is_narrow(low, high, body)
        given_up = narrow or (not proven and high - low <= UNPROVEN)
        if (other >= 0 or not proven) and not given_up:
            middle = 0.5 * (low + high)
            stack[2 * waiting], stack[2 * waiting + 1] = low, middle
            stack[2 * waiting + 2], stack[2 * waiting + 3] = middle, high
            waiting += 2
            continue
        ended += pieces
        shortest = min(shortest, high - low)
        if narrow and body.friction == 0.0 and known.turns is None:
            undecided += lost
        elif not proven or row < 0:
            undecided += high - low
        else:
            known.table[row * FIELDS + 6] += high - low
    return waiting, ended, undecided, shortest, taken
