"""All clock phases of one start: an arc of states, cut where a sample of it meets a count edge.

The state at the first sample, after phi of a period of free motion, is a curve over the phase; its rate, q(phi), goes
by exp(A phi), and while all of an arc acts alike by Phi from sample to sample. So an arc is a centre trial and two
phases: its states differ from the centre's by D(t) q. Where an edge has to be found on it, it is a chord, and the
energy of the rate's own rate bounds how far the arc bulges from it.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import CONSTANT, HALVES, HALVINGS, norm
from hknob_cli.engine.general.follow import FIELDS
from hknob_cli.engine.general.sets.ball import CAPTURED, FIRST_REST_TEST, GREW, MEETS_EDGE, follow_ball, step_through
from hknob_cli.engine.general.sets.known import is_proven, seek
from hknob_cli.engine.general.sets.piece import power_of
from hknob_cli.engine.general.sets.readings import acting, highest, lowest, remembered
from hknob_cli.engine.propagator import hold_coefficients

LOW, HIGH, ARC_ERROR, ARC_BEFORE, ARC_LEVEL, ARC_SAMPLE, ARC_STATE = range(7)
SHORTEST = 1e-13  # phases: no shorter arc is told apart
OPEN, ENDED, UNPROVEN, PARTED = range(4)  # what becomes of an arc
FLAT = 0.0625  # bulge by the way from end to end, above which an arc is halved and not cut


def arc_size(n, delay):
    """Numbers of an arc that waits: `LOW` to `ARC_SAMPLE`, its state, and the commands under way, oldest first."""
    return ARC_STATE + n + delay


def drift_over(t, rate, out, body, pad):
    """D(t) times ``rate``, to ``out``, for a time from 0 to 1; not in place."""
    n = body.order
    if n == 2:
        s, g, _ = hold_coefficients(body.alpha, body.beta, t)
        out[0] = (s + body.alpha * g) * rate[0] + g * rate[1]
        out[1] = s * rate[1] - body.beta * g * rate[0]
        return
    for i in range(n):
        out[i] = 0.0
    h, left = 1.0, t
    for half in range(HALVINGS):
        if left >= h:
            left -= h
            base = (HALVES + half) * n * n
            for i in range(n):
                total = rate[i]
                for j in range(n):
                    total += body.matrices[i * n + j] * out[j]
                pad[i] = total
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += body.matrices[base + i * n + j] * pad[j]
                out[i] += total
        h *= 0.5


def apply(matrix, vector, n, out):
    """``matrix`` times ``vector``, to ``out``."""
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += matrix[i * n + j] * vector[j]
        out[i] = total


def place_on(phase, start, z, room, body):
    """State at the first sample, of a start that has moved freely for ``phase`` of a period."""
    n = body.order
    for i in range(n):
        total = body.vectors[CONSTANT * n + i]
        for j in range(n):
            total += body.matrices[i * n + j] * start[j]
        room.rate[i] = total
    drift_over(phase, room.rate, z, body, room.pad)
    for i in range(n):
        z[i] += start[i]


def rate_at(phase, room, body, out):
    """Rate of the curve at a phase, to ``out``: `place_on` has left that at phase 0 in ``room.rate``."""
    n = body.order
    drift_over(phase, room.rate, room.spare, body, room.pad)
    for i in range(n):
        total = room.rate[i]
        for j in range(n):
            total += body.matrices[i * n + j] * room.spare[j]
        out[i] = total


def measure_arc(low, high, sample, room, drift, body):
    """How an arc lies ``sample`` samples on: ``(radius, bulge)`` in the norm; `room.below`, `room.above`: its ends.

    The ends are told from its middle. ``radius``: half the length, at most. ``bulge``: from the chord.
    """
    n = body.order
    half = 0.5 * (high - low)
    power_of(sample, drift, n, room.matrix, room.power)
    rate_at(low, room, body, room.speed)
    drift_over(half, room.speed, room.spare, body, room.pad)
    for j in range(n):
        room.spare[j] = -room.spare[j]
    apply(room.matrix, room.spare, n, room.below)
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += body.matrices[i * n + j] * room.speed[j]
        room.turn[i] = total
    apply(room.matrix, room.turn, n, room.spare)
    bulge = 0.5 * half * half * norm(room.spare, body)
    apply(room.matrix, room.speed, n, room.spare)
    radius = half * norm(room.spare, body)
    rate_at(low + half, room, body, room.speed)
    drift_over(half, room.speed, room.spare, body, room.pad)
    apply(room.matrix, room.spare, n, room.above)
    return radius * (1.0 + drift.blur), bulge * (1.0 + drift.blur)


def move_centre(z, middle, to, sample, room, drift, body, out):
    """The state of an arc's phase ``to``, from that of its ``middle``, ``sample`` samples on; to ``out``."""
    n = body.order
    power_of(sample, drift, n, room.matrix, room.power)
    first = min(middle, to)
    rate_at(first, room, body, room.speed)
    drift_over(abs(to - middle), room.speed, room.spare, body, room.pad)
    apply(room.matrix, room.spare, n, out)
    sign = 1.0 if to > middle else -1.0
    for j in range(n):
        out[j] = z[j] + sign * out[j]


def wait_arc(room, waiting, low, high, z, before, ring, head, error, level, sample, n):
    """Let an arc wait; how many do then."""
    delay = len(ring)
    base = waiting * arc_size(n, delay)
    room.stack[base + LOW], room.stack[base + HIGH], room.stack[base + ARC_ERROR] = low, high, error
    room.stack[base + ARC_BEFORE], room.stack[base + ARC_LEVEL], room.stack[base + ARC_SAMPLE] = before, level, sample
    for j in range(n):
        room.stack[base + ARC_STATE + j] = z[j]
    for j in range(delay):
        room.stack[base + ARC_STATE + n + j] = ring[(head + j) % delay]
    return waiting + 1


def split_arc(room, waiting, low, high, first, last, z, before, ring, head, error, slack, sample, drift, body):
    """Cut an arc at two of its phases, at most; how many arcs wait then. The parts have not moved on."""
    middle = 0.5 * (low + high)
    for part in range(3):
        begin = low if part == 0 else (first if part == 1 else last)
        end = first if part == 0 else (last if part == 1 else high)
        if begin < end:
            move_centre(z, middle, 0.5 * (begin + end), sample, room, drift, body, room.z)
            waiting = wait_arc(
                room, waiting, begin, end, room.z, before, ring, head, error + slack, 0.0, float(sample), body.order
            )
    return waiting


def part_arc(room, waiting, low, high, z, before, ring, head, error, slack, reach, sample, least, most, cell):
    """Cut an arc that is a chord at its edges, and move each part; how many arcs wait then, -1: no room.

    ``reach``: position by which each part goes beyond its edges; ``least``, ``most``: the readings of the arc.
    """
    drift, body, wall = cell
    n, delay = body.order, len(ring)
    if waiting + int(most - least) + 1 > len(room.stack) // arc_size(n, delay):
        return -1
    middle, left, right = 0.5 * (low + high), z[0] + room.below[0], z[0] + room.above[0]
    level = least
    while level <= most:
        bottom, top = lowest(level, drift.bottom, wall) - reach, highest(level, wall) + reach
        first, last = 0.0, 1.0
        if left != right:
            one, other = (bottom - left) / (right - left), (top - left) / (right - left)
            first, last = max(first, min(one, other)), min(last, max(one, other))
        elif left < bottom or left > top:
            last = -1.0
        if first <= last:
            begin, end = low + first * (high - low), low + last * (high - low)
            move_centre(z, middle, 0.5 * (begin + end), sample, room, drift, body, room.z)
            for j in range(delay):
                room.ring[j] = ring[(head + j) % delay]
            was = remembered(level, wall) if sample == 0 else before
            remembers, grown, to = step_through(
                room.z, was, error + slack, level, room.ring, 0 * delay, drift, body, wall, room.pad
            )
            waiting = wait_arc(
                room, waiting, begin, end, room.z, remembers, room.ring, to, grown, level, sample + 1.0, n
            )
        level += 1.0
    return waiting


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
    cell = (drift, body, wall)
    taken = 0
    most_waiting = len(room.stack) // size - 4
    while waiting > 0 and taken < samples:
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
                continue
            radius, bulge = measure_arc(low, high, at, room, drift, body)
            if event != MEETS_EDGE:
                # Long in no known attractor: its middle's own is found, and entered.
                since, wait = 0, 2 * wait
                row, steps = seek(z, before, ring, head, budget - at, limit, known, body, wall)
                taken += steps
                if not is_proven(row, known):
                    fate = UNPROVEN
                continue
            # The ball meets an edge: the arc itself is looked at.
            ways = abs(room.above[0] - room.below[0])
            narrow = body.reach * (error + slack) + 8.0 * EPSILON * abs(z[0])
            bow = body.reach * bulge
            reach = narrow + bow
            left, right = z[0] + room.below[0], z[0] + room.above[0]
            least = acting(min(left, right) - reach, drift.bottom, wall)
            most = acting(max(left, right) + reach, drift.bottom, wall)
            if least == most:
                run, next_test = (run + 1, next_test) if level == least else (0, FIRST_REST_TEST)
                level = least
                was = remembered(level, wall) if at == 0 else before
                before, error, head = step_through(z, was, error, level, ring, head, drift, body, wall, room.pad)
                at += 1
                since += 1
                taken += 1
            elif waiting > most_waiting:
                return -1, taken
            elif bow > narrow and high - low > SHORTEST:
                middle = 0.5 * (low + high)
                first, last = middle, middle
                if bow < FLAT * ways:
                    edge = highest(least, wall)
                    # So far from the edge that neither outer part, whose own reach is below twice this one, meets it.
                    one = (edge - 2.0 * reach - left) / (right - left)
                    other = (edge + 2.0 * reach - left) / (right - left)
                    first = low + (high - low) * min(1.0, max(0.0, min(one, other)))
                    last = low + (high - low) * min(1.0, max(0.0, max(one, other)))
                if last - first > 0.75 * (high - low) or first >= high or last <= low:
                    first, last = middle, middle
                waiting = split_arc(
                    room, waiting, low, high, first, last, z, before, ring, head, error, slack, at, drift, body
                )
                fate = PARTED
            else:
                waiting = part_arc(
                    room, waiting, low, high, z, before, ring, head, error, slack, reach, at, least, most, cell
                )
                if waiting < 0:
                    return -1, taken
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
