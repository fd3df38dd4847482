"""Every start in a box: pieces followed until each lies inside what a proven orbit captures."""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import GREW as GREW_FATE
from hknob_cli.engine.follow import UNSETTLED
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.sets.ball import (
    CAPTURED,
    FIRST_REST_TEST,
    GREW,
    MEETS_EDGE,
    STEPS_DEEPER,
    follow_ball,
    step_through,
)
from hknob_cli.engine.general.sets.known import NO_ROOM, blame, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.lattice import keep
from hknob_cli.engine.general.sets.memory import begin_memory, watched
from hknob_cli.engine.general.sets.parts import part
from hknob_cli.engine.general.sets.piece import (
    BEFORE,
    COUNT,
    ERROR,
    LEVEL,
    SAMPLE,
    STATE,
    WEIGHT,
    largest_norm,
    move_corners,
    piece_size,
    put,
    within,
)
from hknob_cli.engine.general.sets.readings import acting, remembered
from hknob_cli.engine.general.sets.turns import (
    count_of,
    edge_reach,
    half_of,
    highest_at,
    keep_count,
    level_at,
    lowest_at,
    peek,
)

SMALL = 0.4  # part of a lattice cell's width: a piece of that radius may be merged with others
SECTION = 0.01  # counts: narrower pieces are merged only where the wall steps deeper, as in `engine.sets.box`
ENDED, UNPROVEN, PARTED, KEPT = range(4)  # what becomes of a piece


def sample_box(starts, first, stop, patience, budget, limit, ends, room, drift, known, body, wall):
    """Count where the trials from single states end; ``(samples, unproven)``.

    ``starts``: x, v of each, flat, of which those from ``first`` to ``stop`` are followed; ``ends`` takes their rows.
    """
    taken, unproven, n, delay = 0, 0, body.order, len(room.own_ring)
    for k in range(first, stop):
        for j in range(n):
            room.own_z[j] = 0.0
        room.own_z[0], room.own_z[1] = starts[2 * k], starts[2 * k + 1]
        for j in range(delay):
            room.own_ring[j] = 0.0
        before = remembered(read(room.own_z[0], wall), wall)
        event, row, before, head, _, _, _, _, used = follow_ball(
            room.own_z,
            before,
            room.own_ring,
            0 * delay,
            0.0,
            0.0,
            0.0,
            0,
            FIRST_REST_TEST,
            min(patience, budget),
            limit,
            False,
            drift,
            known,
            body,
            wall,
        )
        taken += used
        if event != CAPTURED:
            row, used = seek(room.own_z, before, room.own_ring, head, budget - used, limit, known, body, wall)
            taken += used
        ends[k] = row
        if row < 0:
            unproven += 1
        else:
            known.table[row * FIELDS + 6] += 1.0
    return taken, unproven


def sample_with_law(starts, first, stop, _patience, budget, limit, ends, room, drift, known, body, wall):
    """Count where the trials from single states end under a law: as `sample_box`."""
    taken, unproven = 0, 0
    for k in range(first, stop):
        for j in range(body.order):
            room.own_z[j] = 0.0
        room.own_z[0], room.own_z[1] = starts[2 * k], starts[2 * k + 1]
        begin_memory(known.law, acting(room.own_z[0], drift.bottom, known.law.watch), room.own_ring)
        row, used = seek(room.own_z, 0.0, room.own_ring, 0, budget, limit, known, body, wall)
        taken += used
        ends[k] = row
        if row < 0:
            unproven += 1
        else:
            known.table[row * FIELDS + 6] += 1.0
    return taken, unproven


def fill_box(low_x, high_x, low_v, high_v, delay, room, drift, body, wall):
    """Let the box be all that waits, no command under way; how many pieces: one, or one a reading that is remembered.

    ``body``: its order says in how many numbers states may differ; ``room`` is that of a piece's state.
    """
    n, size = body.order, piece_size(len(room.z), delay)
    low, high, turns = 0.0, 0.0, room.turns
    apart = wall.damping > 0.0 or wall.hysteresis > 0.0
    if apart:
        low = level_at(turns, low_x, 0.0, 0.0, drift.bottom, wall)
        high = level_at(turns, high_x, 0.0, 0.0, drift.bottom, wall)
    for j in range(len(room.z)):
        room.z[j] = 0.0
    for k in range(4 * n):
        room.corners[k] = 0.0
    for k in range(4):
        room.corners[k * n] = low_x if k == 0 or k == 3 else high_x
        room.corners[k * n + 1] = low_v if k < 2 else high_v
    for j in range(delay):
        room.ring[j] = 0.0
    error = 4.0 * EPSILON * drift.units[0] * (abs(low_x) + abs(high_x))
    error += 4.0 * EPSILON * drift.units[1] * (abs(low_v) + abs(high_v))
    waiting = 0
    while low <= high and (waiting + 1) * size <= len(room.stack):
        kept, weight = 4, 1.0
        for k in range(4 * n):
            room.halves[k] = room.corners[k]
        if apart:
            bottom = lowest_at(turns, low, low, 0.0, drift.bottom, wall)
            kept = within(room, room.corners, 4, bottom, highest_at(turns, low, low, 0.0, wall), n)
            weight = (room.halves[n] - room.halves[0]) / (high_x - low_x)  # a rectangle again, in the same order
            weight = max(weight, EPSILON)  # a line has none, but its states are starts
        put(
            room.stack,
            waiting * size,
            room.z,
            remembered(low, wall),
            room.ring,
            0 * delay,
            error,
            0.0,
            0.0,
            weight,
            room.halves,
            kept,
            room.middle,
            drift,
            n,
        )
        waiting += 1
        low += 1.0
    room.counts[0] = 0.0
    return waiting if low > high else -1


def follow_piece(room, waiting, delay, width, patience, budget, limit, drift, known, body, wall):
    """Follow the last piece that waits until it ends, is parted or kept; ``(waiting, fate, samples)``."""
    n = body.order
    own, corners, z, ring = room.own, room.corners, room.own_z, room.own_ring
    size = piece_size(n, delay)
    waiting -= 1
    for k in range(size):
        own[k] = room.stack[waiting * size + k]
    for j in range(n):
        z[j] = own[STATE + j]
    for j in range(delay):
        ring[j] = own[STATE + n + j]
    error, before, level, at = own[ERROR], own[BEFORE], own[LEVEL], int(own[SAMPLE])
    count, weight, edges = int(own[COUNT]), own[WEIGHT], STATE + n + delay
    first = largest_norm(own, edges, count, body)
    blurred = drift.blur * first
    radius = first + blurred
    # Samples in no known attractor count through all cuts: what is cut again and again would else never be asked.
    age, since, wait, taken, head = 0, at % patience, patience, 0, 0 * delay
    run, next_test = 0, FIRST_REST_TEST
    watch = watched(known.law, wall)
    half = half_of(known.turns, False, watch)
    between = max(8, patience // 16)  # samples after which the radius is computed again
    small = body.reach * (radius + error) < SMALL * width
    while True:
        event, row, before, head, error, level, run, next_test, used = follow_ball(
            z,
            before,
            ring,
            head,
            radius,
            error,
            level,
            run,
            next_test,
            min(between, wait - since, budget - at),
            limit,
            small,
            drift,
            known,
            body,
            wall,
        )
        at += used
        age += used
        since += used
        taken += used
        if event == CAPTURED:
            return waiting, ENDED, taken
        if event == GREW or at >= budget:  # that what has grown so far never comes back is not proven
            blame(GREW_FATE if event == GREW else UNSETTLED, weight, known)
            return waiting, UNPROVEN, taken
        move_corners(own, edges, count, age, corners, 0, drift, n, room.matrix, room.spare)
        radius = largest_norm(corners, 0, count, body) + blurred
        small = body.reach * (radius + error) < SMALL * width
        if small and (event == STEPS_DEEPER or width > SECTION):
            sample = float(at)
            if keep(
                room, z, before, ring, head, error + blurred, level, sample, weight, corners, count, width, drift, body
            ):
                return waiting, KEPT, taken
            small = False
        if event == MEETS_EDGE:
            least, most = corners[0], corners[0]
            for k in range(1, count):
                least, most = min(least, corners[k * n]), max(most, corners[k * n])
            reach = edge_reach(known.turns, body.reach * (error + blurred) + 8.0 * EPSILON * abs(z[0]))
            shown = count_of(known.turns, known.law, before, ring)
            low = level_at(known.turns, z[0] + least - reach, shown, half, drift.bottom, watch)
            high = level_at(known.turns, z[0] + most + reach, shown, half, drift.bottom, watch)
            ball = radius + error
            same, then = peek(known.turns, known.law, z, low, before, ring, head, ball, drift, body, wall, watch)
            if low < high or not same:
                parted = part(
                    room,
                    waiting,
                    z,
                    before,
                    ring,
                    head,
                    error + blurred,
                    reach,
                    float(at),
                    weight,
                    corners,
                    count,
                    low,
                    high,
                    drift,
                    body,
                    wall,
                )
                if parted < 0:
                    blame(NO_ROOM, weight, known)
                    return waiting, UNPROVEN, taken
                return parted, PARTED, taken
            run, next_test = (run + 1, next_test) if level == low else (0, FIRST_REST_TEST)
            level = low
            before, error, head = step_through(
                known.law, z, before, error, level, ring, head, drift, body, wall, room.pad
            )
            before = keep_count(known.turns, known.law, then, before, ring)
            at += 1
            age += 1
            since += 1
            taken += 1
        elif since >= wait:
            # Long in no known attractor: its centre's own is found, and entered.
            since, wait = 0, 2 * wait
            row, steps = seek(z, before, ring, head, budget - at, limit, known, body, wall)
            taken += steps
            if body.halt[0] > 0.0:
                return waiting + 1, PARTED, taken  # as it was, among those that wait
            if not is_proven(row, known):
                blame(fate_of(row, known), weight, known)
                return waiting, UNPROVEN, taken


def follow_generation(room, waiting, delay, width, patience, budget, limit, samples, drift, known, body, wall):
    """Follow pieces until none waits or ``samples`` are taken: ``(waiting, pieces, undecided, samples)``.

    ``undecided``: measure of starts, as a part of the box or a bound on it, that reach a piece without a proven end.
    """
    ended, undecided, taken = 0, 0.0, 0
    size = piece_size(body.order, delay)
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        weight = room.stack[(waiting - 1) * size + WEIGHT]
        waiting, fate, steps = follow_piece(
            room, waiting, delay, width, patience, budget, limit, drift, known, body, wall
        )
        taken += steps + 1
        if fate == UNPROVEN:
            undecided += weight
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken


def seek_some(room, waiting, delay, some, budget, limit, known, body, wall):
    """Find what the centres of ``some`` of the pieces that wait end in, evenly spread; the samples taken."""
    taken, n = 0, body.order
    size = piece_size(n, delay)
    for k in range(min(some, waiting)):
        base = size * (k * waiting // min(some, waiting))
        for j in range(n):
            room.own_z[j] = room.stack[base + STATE + j]
        for j in range(delay):
            room.own_ring[j] = room.stack[base + STATE + n + j]
        before = room.stack[base + BEFORE]
        _, used = seek(room.own_z, before, room.own_ring, 0 * delay, budget, limit, known, body, wall)
        taken += used
    return taken
