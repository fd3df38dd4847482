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
from hknob_cli.engine.general.sets.cell import Centre, acting_as
from hknob_cli.engine.general.sets.known import NO_ROOM, blame, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.lattice import keep
from hknob_cli.engine.general.sets.memory import begin_memory, watched
from hknob_cli.engine.general.sets.parts import part
from hknob_cli.engine.general.sets.piece import (
    COUNT,
    STATE,
    WEIGHT,
    largest_norm,
    move_corners,
    piece_size,
    put,
    take,
    within,
)
from hknob_cli.engine.general.sets.readings import acting, remembered
from hknob_cli.engine.general.sets.turns import (
    count_of,
    edge_reach,
    half_of,
    highest_at,
    level_at,
    lowest_at,
    peek,
)

SMALL = 0.4  # part of a lattice cell's width: a piece of that radius may be merged with others
SECTION = 0.01  # counts: narrower pieces are merged only where the wall steps deeper, as in `engine.sets.box`
ENDED, UNPROVEN, PARTED, KEPT = range(4)  # what becomes of a piece


def begin_sample(starts, k, room):
    """Leave the start ``k`` in ``room``, the finger moving with the knob and no command under way."""
    for j in range(len(room.own_z)):
        room.own_z[j] = 0.0
    room.own_z[0], room.own_z[1] = starts[2 * k], starts[2 * k + 1]
    for j in range(len(room.own_ring)):
        room.own_ring[j] = 0.0


def count_end(row, k, ends, known):
    """Count the end of a start; 1 where none is proven."""
    ends[k] = row
    if row < 0:
        return 1
    known.table[row * FIELDS + 6] += 1.0
    return 0


def sample_box(starts, first, stop, ends, scope, room, cell):
    """Count where the trials from single states end; ``(samples, unproven)``.

    ``starts``: x, v of each, flat, of which those from ``first`` to ``stop`` are followed; ``ends`` takes their rows.
    """
    taken, unproven, known = 0, 0, cell.known
    head = 0 * len(room.own_ring)
    for k in range(first, stop):
        begin_sample(starts, k, room)
        before = remembered(read(room.own_z[0], cell.wall), cell.wall)
        start = Centre(room.own_z, before, room.own_ring, head, 0.0, 0.0, 0.0, 1.0)
        patience = min(scope.skip, scope.budget)
        event, row, end, _, _ = follow_ball(start, 0.0, 0, FIRST_REST_TEST, patience, scope.limit, False, cell)
        taken += int(end.sample)
        if event != CAPTURED:
            row, used = seek(end, scope, cell)
            taken += used
        unproven += count_end(row, k, ends, known)
    return taken, unproven


def sample_trials(starts, first, stop, ends, scope, room, cell):
    """As `sample_box`, trial by trial: under a law, or with friction behind hysteresis."""
    taken, unproven, law = 0, 0, cell.known.law
    head = 0 * len(room.own_ring)
    for k in range(first, stop):
        begin_sample(starts, k, room)
        begin_memory(law, acting(room.own_z[0], cell.drift.bottom, watched(law, cell.wall)), room.own_ring)
        before = remembered(read(room.own_z[0], cell.wall), cell.wall)
        start = Centre(room.own_z, before, room.own_ring, head, 0.0, 0.0, 0.0, 1.0)
        row, used = seek(start, scope, cell)
        taken += used
        unproven += count_end(row, k, ends, cell.known)
    return taken, unproven


def fill_box(box, room, turns, drift, body, wall):
    """Let a box be all that waits, no command under way; how many pieces: one, or one a reading that is remembered.

    The lattice is emptied: a search that was given up has left pieces in it.

    ``box``: its low and high angle, its low and high velocity; ``body``: its order says in how many numbers states may
    differ; ``room`` is that of a piece's state.
    """
    for one in range(int(room.counts[0])):
        room.used[int(room.taken[one])] = 0.0
    low_x, high_x, low_v, high_v = box
    n, size, head = body.order, piece_size(len(room.z), len(room.ring)), 0 * len(room.ring)
    low, high = 0.0, 0.0
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
    for j in range(len(room.ring)):
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
        centre = Centre(room.z, remembered(low, wall), room.ring, head, error, 0.0, 0.0, weight)
        put(room.stack, waiting * size, centre, room.halves, kept, room.middle, drift, n)
        waiting += 1
        low += 1.0
    room.counts[0] = 0.0
    return waiting if low > high else -1


def follow_piece(room, waiting, width, scope, cell):
    """Follow the last piece that waits until it ends, is parted or kept; ``(waiting, fate, samples)``."""
    drift, known, body = cell.drift, cell.known, cell.body
    turns, law = known.turns, known.law
    own, corners = room.own, room.corners
    n, size = body.order, len(own)
    waiting -= 1
    for k in range(size):
        own[k] = room.stack[waiting * size + k]
    centre = take(own, room.own_z, room.own_ring)
    z, begun = centre.z, int(centre.sample)
    count, edges = int(own[COUNT]), STATE + n + len(centre.ring)
    first = largest_norm(own, edges, count, body)
    blurred = drift.blur * first
    radius = first + blurred
    # Samples in no known attractor count through all cuts: what is cut again and again would else never be asked.
    at, since, wait, taken = begun, begun % scope.patience, scope.patience, 0
    run, next_test = 0, FIRST_REST_TEST
    watch = watched(law, cell.wall)
    half = half_of(turns, False, watch)
    between = max(8, scope.patience // 16)  # samples after which the radius is computed again
    small = body.reach * (radius + centre.error) < SMALL * width
    while True:
        some = min(between, wait - since, scope.budget - at)
        event, row, centre, run, next_test = follow_ball(centre, radius, run, next_test, some, scope.limit, small, cell)
        used = int(centre.sample) - at
        at += used
        since += used
        taken += used
        if event == CAPTURED:
            return waiting, ENDED, taken
        if event == GREW or at >= scope.budget:  # that what has grown so far never comes back is not proven
            blame(GREW_FATE if event == GREW else UNSETTLED, centre.weight, known)
            return waiting, UNPROVEN, taken
        move_corners(own, edges, count, at - begun, corners, drift, n, room)
        radius = largest_norm(corners, 0, count, body) + blurred
        small = body.reach * (radius + centre.error) < SMALL * width
        blurry = acting_as(centre, centre.level, centre.before, centre.error + blurred)
        if small and (event == STEPS_DEEPER or width > SECTION):
            if keep(room, blurry, corners, count, width, drift, body):
                return waiting, KEPT, taken
            small = False
        if event == MEETS_EDGE:
            least, most = corners[0], corners[0]
            for k in range(1, count):
                least, most = min(least, corners[k * n]), max(most, corners[k * n])
            reach = edge_reach(turns, body.reach * blurry.error + 8.0 * EPSILON * abs(z[0]))
            shown = count_of(turns, law, centre.before, centre.ring)
            low = level_at(turns, z[0] + least - reach, shown, half, drift.bottom, watch)
            high = level_at(turns, z[0] + most + reach, shown, half, drift.bottom, watch)
            acts = acting_as(centre, low, centre.before, centre.error)
            same, then = peek(acts, radius + centre.error, cell)
            if low < high or not same:
                parted = part(room, waiting, blurry, count, low, high, reach, cell)
                if parted < 0:
                    blame(NO_ROOM, centre.weight, known)
                    return waiting, UNPROVEN, taken
                return parted, PARTED, taken
            run, next_test = (run + 1, next_test) if centre.level == low else (0, FIRST_REST_TEST)
            centre = step_through(acts, then, cell, room.pad)
            at += 1
            since += 1
            taken += 1
        elif since >= wait:
            # Long in no known attractor: its centre's own is found, and entered.
            since, wait = 0, 2 * wait
            row, steps = seek(centre, scope, cell)
            taken += steps
            if body.halt[0] > 0.0:
                return waiting + 1, PARTED, taken  # as it was, among those that wait
            if not is_proven(row, known):
                blame(fate_of(row, known), centre.weight, known)
                return waiting, UNPROVEN, taken


def follow_generation(room, waiting, width, samples, scope, cell):
    """Follow pieces until none waits or ``samples`` are taken: ``(waiting, pieces, undecided, samples)``.

    ``undecided``: measure of starts, as a part of the box or a bound on it, that reach a piece without a proven end.
    """
    ended, undecided, taken = 0, 0.0, 0
    while waiting > 0 and taken < samples and not cell.body.halt[0] > 0.0:
        weight = room.stack[(waiting - 1) * len(room.own) + WEIGHT]
        waiting, fate, steps = follow_piece(room, waiting, width, scope, cell)
        taken += steps + 1
        if fate == UNPROVEN:
            undecided += weight
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken


def seek_some(room, waiting, some, scope, cell):
    """Find what the centres of ``some`` of the pieces that wait end in, evenly spread; the samples taken."""
    taken, size = 0, len(room.own)
    for k in range(min(some, waiting)):
        base = size * (k * waiting // min(some, waiting))
        for j in range(size):
            room.own[j] = room.stack[base + j]
        own = take(room.own, room.own_z, room.own_ring)
        here = Centre(own.z, own.before, own.ring, own.head, 0.0, 0.0, 0.0, 1.0)  # it may take all of the budget
        _, used = seek(here, scope, cell)
        taken += used
    return taken
