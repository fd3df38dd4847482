"""All clock phases of one start: an arc of states, cut where a sample of it meets a count edge.

An arc is a centre, which is a trial, and two clock phases; `curve` says how its other states lie. Where an edge has to
be found on it, it is a chord, and the rate of its rate bounds how far it bulges from it: an arc that bulges by more
than rounding is cut beside the edge first, and what is left there is so short that it is straight.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import GREW as GREW_FATE
from hknob_cli.engine.follow import UNSETTLED
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets.arc_parts import (
    ARC_BEFORE,
    ARC_ERROR,
    ARC_LEVEL,
    ARC_SAMPLE,
    ARC_STATE,
    HIGH,
    LOW,
    arc_size,
    part_arc,
    split_arc,
    turns_apart,
    wait_arc,
)
from hknob_cli.engine.general.sets.ball import CAPTURED, FIRST_REST_TEST, GREW, MEETS_EDGE, follow_ball, step_through
from hknob_cli.engine.general.sets.curve import measure_arc, place_on
from hknob_cli.engine.general.sets.known import blame, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.memory import begin_at, watched
from hknob_cli.engine.general.sets.turns import (
    count_of,
    edge_reach,
    half_of,
    highest_at,
    keep_count,
    level_at,
    peek,
)

SHORTEST = 1e-13  # phases: no shorter arc is told apart
OPEN, ENDED, UNPROVEN, PARTED = range(4)  # what becomes of an arc
FLAT = 0.0625  # bulge by the way from end to end, above which an arc is halved and not cut


def fill_arcs(start, delay, room, drift, body):
    """Let all phases of a start wait as one arc; a bound on the rounding of every state of it, by its centre's."""
    n = body.order
    place_on(0.5, start, room.own_z, room, body)
    slack = drift.coast * norm(room.rate, body)
    error = slack
    for j in range(n):
        error += 8.0 * EPSILON * drift.units[j] * (abs(start[j]) + abs(room.own_z[j]))
    for j in range(delay):
        room.own_ring[j] = 0.0
    wait_arc(room, 0, 0.0, 1.0, room.own_z, 0.0, room.own_ring, 0 * delay, error, 0.0, 0.0, n)
    return slack


def follow_arcs(waiting, delay, slack, budget, patience, limit, samples, totals, room, drift, known, body, wall):
    """Follow arcs until none waits or ``samples`` are taken: ``(waiting, samples)``, waiting -1 where there is no room.

    ``totals``: arcs that ended, the phases that did not end proven, the shortest arc, the length of all; added to.
    """
    n = body.order
    size = arc_size(n, delay)
    z, ring = room.own_z, room.own_ring
    cell, watch = (known.law, drift, body, wall), watched(known.law, wall)
    taken = 0
    most_waiting = len(room.stack) // size - 4
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        waiting -= 1
        base = waiting * size
        low, high, error = room.stack[base + LOW], room.stack[base + HIGH], room.stack[base + ARC_ERROR]
        before, level, at = (
            room.stack[base + ARC_BEFORE],
            room.stack[base + ARC_LEVEL],
            int(room.stack[base + ARC_SAMPLE]),
        )
        for j in range(n):
            z[j] = room.stack[base + ARC_STATE + j]
        for j in range(delay):
            ring[j] = room.stack[base + ARC_STATE + n + j]
        run, next_test, head, since, wait = 0, FIRST_REST_TEST, 0 * delay, 0, patience
        radius, bulge = measure_arc(low, high, at, room, drift, body)
        fate, row = OPEN, -1
        taken += 1
        while fate == OPEN:
            event, used = MEETS_EDGE, 0
            if at > 0:
                event, row, before, head, error, level, run, next_test, used = follow_ball(
                    z,
                    before,
                    ring,
                    head,
                    radius + slack,
                    error,
                    level,
                    run,
                    next_test,
                    min(wait - since, budget - at),
                    limit,
                    False,
                    drift,
                    known,
                    body,
                    wall,
                )
            at += used
            since += used
            taken += used
            if event == CAPTURED:
                fate = ENDED
                continue
            if event == GREW or at >= budget:
                fate, row = UNPROVEN, -1
                blame(GREW_FATE if event == GREW else UNSETTLED, high - low, known)
                continue
            radius, bulge = measure_arc(low, high, at, room, drift, body)
            if event != MEETS_EDGE:
                # Long in no known attractor: its middle's own is found, and entered.
                since, wait = 0, 2 * wait
                row, steps = seek(z, before, ring, head, budget - at, limit, known, body, wall)
                taken += steps
                if body.halt[0] > 0.0 or taken >= samples:
                    waiting = wait_arc(room, waiting, low, high, z, before, ring, head, error, level, float(at), n)
                    fate = PARTED
                elif not is_proven(row, known):
                    fate = UNPROVEN
                    blame(fate_of(row, known), high - low, known)
                continue
            # The ball meets an edge: the arc itself is looked at.
            ways = abs(room.above[0] - room.below[0])
            narrow = body.reach * (error + slack) + 8.0 * EPSILON * abs(z[0])
            bow = body.reach * bulge
            reach = edge_reach(known.turns, narrow) + bow
            left, right = z[0] + room.below[0], z[0] + room.above[0]
            turns, half, shown = known.turns, half_of(known.turns, at == 0, watch), 0.0
            if at > 0:
                shown = count_of(turns, known.law, before, ring)
            least = level_at(turns, min(left, right) - reach, shown, half, drift.bottom, watch)
            most = level_at(turns, max(left, right) + reach, shown, half, drift.bottom, watch)
            same, then = least == most, 0.0
            if same:
                if at == 0:
                    before = begin_at(known.law, least, ring, wall)
                ball = radius + slack + error
                same, then = peek(turns, known.law, z, least, before, ring, head, ball, drift, body, wall, watch)
            if same:
                run, next_test = (run + 1, next_test) if level == least else (0, FIRST_REST_TEST)
                level = least
                before, error, head = step_through(
                    known.law, z, before, error, level, ring, head, drift, body, wall, room.pad
                )
                before = keep_count(turns, known.law, then, before, ring)
                at += 1
                since += 1
                taken += 1
            elif waiting > most_waiting:
                return -1, taken
            elif high - low > SHORTEST and (
                bow > narrow or turns_apart(room, z, before, ring, head, reach, at, least, most, cell)
            ):
                middle = 0.5 * (low + high)
                first, last = middle, middle
                if bow > narrow and bow < FLAT * ways and least < most:
                    edge = highest_at(turns, least, shown, half, watch)
                    # So far from the edge that neither outer part, whose own reach is below twice this one, meets it.
                    # That is less than half of the arc; and as it comes to the edge, an outer part is never all of it.
                    one = (edge - 2.0 * reach - left) / (right - left)
                    other = (edge + 2.0 * reach - left) / (right - left)
                    first = low + (high - low) * max(0.0, min(one, other))
                    last = low + (high - low) * min(1.0, max(one, other))
                if first >= high or last <= low:  # by rounding
                    first, last = middle, middle
                waiting = split_arc(
                    room, waiting, low, high, first, last, z, before, ring, head, error, slack, at, drift, body
                )
                fate = PARTED
            else:
                waiting = part_arc(
                    room, waiting, low, high, z, before, ring, head, error, slack, reach, at, least, most, cell
                )
                fate = PARTED
        if fate == UNPROVEN:
            totals[1] += high - low
        if fate != PARTED:
            if row >= 0:
                known.table[row * FIELDS + 6] += high - low
            ended = int(totals[0])
            if 3 * ended + 3 <= len(room.ended):
                room.ended[3 * ended], room.ended[3 * ended + 1], room.ended[3 * ended + 2] = low, high, row
            totals[0] += 1.0
            totals[2] = min(totals[2], high - low)
            totals[3] += high - low
    return waiting, taken
