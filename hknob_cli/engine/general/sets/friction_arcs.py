"""Every clock phase of one start, with friction and more than angle and speed: arcs, cut where a sample meets an edge.

As `arc`, but arcs are moved hold by hold (`friction_arc`), and are begun anew from the start, shorter, where too much
of one is known only by how far it is from its line. A part of an arc goes beyond the edge where it is cut by as much:
so whatever a state truly reads, a part that acts as this reading holds it.
"""

from hknob_cli.engine.follow import CYCLE_PROVEN, GREW, UNSETTLED
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.cogging import reach_of, size_at
from hknob_cli.engine.general.sets.ball import FIRST_REST_TEST
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.cog_arc import begin_phases, move_arc
from hknob_cli.engine.general.sets.friction_arc import (
    BEFORE,
    COUNT,
    COUNT_TO,
    ERROR,
    FROM,
    HIGH,
    LEVEL,
    LOW,
    SAMPLE,
    STANDS,
    STATE,
    TO,
    TOLD,
    apart_of,
    ball_of,
    beside_of,
    start_rate,
)
from hknob_cli.engine.general.sets.friction_arc_counts import begin_counts, count_turns, keep_start, tells_counts
from hknob_cli.engine.general.sets.friction_arc_parts import (
    ARCS,
    INTERVAL,
    begin_again,
    halve_arc,
    keep_arc,
    part_arc,
    take_arc,
    wait_arc,
)
from hknob_cli.engine.general.sets.friction_arc_rest import SEVERAL, rest_of_arc
from hknob_cli.engine.general.sets.friction_phases import NARROWEST, UNPROVEN
from hknob_cli.engine.general.sets.friction_set import LEAST_WEIGHT
from hknob_cli.engine.general.sets.known import FULL, NO_ROOM, blame, captor, fate_of, is_compared, is_proven, seek
from hknob_cli.engine.general.sets.memory import begin_at, command_all, first_look, watched
from hknob_cli.engine.general.sets.readings import remembered, steps_deeper
from hknob_cli.engine.general.sets.turns import half_of, keep_count, level_at

TORQUE, SPAN, LOOK = range(3)  # numbers of a hold of an interval: which torque acts, how long, which look ends it
HOLD = 3
MOST = 4096  # that one beginning may come to
BLURRED = 0.25  # of an arc's half length: with as much beside its line it is not cut, but begun anew
MUCH = 0.25  # of the margin of an orbit: a larger arc that it does not capture is halved
ENDED, PARTED, AGAIN, LOST = range(4)  # what becomes of an arc
SINCE = 2.0  # all states stand, and did at the sample before; 1: since then
TORN, BEGIN_ANEW = -1, -2  # instead of the number of a reading: states do not all do, or count, the same
LONG = 2.0**-12  # counts per sample: a shorter arc is not halved for that


def is_line(length, beside):
    """Whether an arc of half this length is mostly its line, so that its halves are shorter."""
    return not length * BLURRED < beside


def look_up(room, which, cell):
    """The reading, number ``which`` of an interval, of the arc in ``room``: ``(level, the highest that it may be)``.

    What is told of it is kept. So is that of the sample before it where all states stand since.
    """
    drift, body, watch = cell.drift, cell.body, watched(cell.known.law, cell.wall)
    if which < int(room.arc[TOLD]):
        return room.told[which], room.told[which]
    if room.arc[STANDS] >= SINCE:
        room.told[which] = room.arc[LEVEL] if which == 0 else room.told[0]
        return room.told[which], room.told[which]
    x, reach, turns = room.z[0], abs(room.columns[0]) + beside_of(room, body), cell.known.turns
    half = half_of(turns, which == 0 and room.arc[SAMPLE] == 0.0, watch)
    low = level_at(turns, x - reach, room.arc[COUNT], half, drift.bottom, watch)
    high = level_at(turns, x + reach, room.arc[COUNT_TO], half, drift.bottom, watch)
    room.told[which] = low
    return low, high


def step_arc(room, before, narrow, cell):
    """Move the arc in ``room`` over an interval that acts as `room.told` begins: ``(high, which)``.

    ``which``: number of a reading within the interval that is not one, 0 without, `TORN` where the arc is to be halved
    first; and `BEGIN_ANEW` where that would not tell its counts, unless it is ``narrow``; ``high``: the highest that it
    may be.
    """
    drift, body, wall, law, turns = cell.drift, cell.body, cell.wall, cell.known.law, cell.known.turns
    z, ring = room.z, room.ring
    watch, line = watched(law, wall), size_at(body.cogs, room.columns, 0, body)
    stood = room.arc[STANDS] > 0.0
    ball = ball_of(room, body)
    long, torn = line > LONG and line > 2.0 * ball, is_line(line, ball + room.arc[ERROR])
    begin_counts(turns, room.told[0], room.arc)
    head, _ = command_all(law, room.told[0], before, ring, wall, room.torques)
    for j in range(len(ring)):
        room.spare[j] = ring[(head + j) % len(ring)]
    copy_to(ring, room.spare)
    for at in range(0, len(room.course), HOLD):
        u, span = room.torques[int(room.course[at + TORQUE])], room.course[at + SPAN]
        wide = keep_start(turns, room, body)
        alike = move_arc(room, z, u, span, drift, body)
        if not alike and long:
            return 0.0, TORN
        count_turns(turns, room, u, span, alike, wide, body, watch)
        if not (narrow or tells_counts(turns, room.arc)):
            return 0.0, TORN if torn else BEGIN_ANEW
        if stood and room.arc[STANDS] > 0.0:
            room.arc[STANDS] = SINCE
        elif not room.arc[STANDS] > 0.0:
            stood = False
        look = int(room.course[at + LOOK])
        if look >= 0:
            low, high = look_up(room, look + 1, cell)
            if low < high:
                return high, look + 1
            ring[first_look(law) + look] = low  # what a law remembers is the count at the last turning point
    return 0.0, 0


def shorten_arc(room, waiting, body):
    """Halve the arc in ``room.own``, of which too little is told: ``(waiting, fate, row)``, as `end_of_arc`."""
    if not is_line(size_at(body.cogs, room.columns, 0, body), ball_of(room, body) + room.arc[ERROR]):
        return waiting, AGAIN, -1
    waiting = halve_arc(room, waiting)
    return waiting, (PARTED if waiting >= 0 else LOST), NO_ROOM


def take_apart(room, waiting, which, high, narrow, cell):
    """Halve the arc in ``room.own``, or cut it where its reading ``which`` tells states apart: as `shorten_arc`."""
    body = cell.body
    if which == TORN:
        waiting = halve_arc(room, waiting)
    elif which == BEGIN_ANEW or (not narrow and beside_of(room, body) > BLURRED * abs(room.columns[0])):
        return waiting, AGAIN, -1
    else:
        waiting = part_arc(room, waiting, which, high, cell)
    return waiting, (PARTED if waiting >= 0 else LOST), NO_ROOM


def end_of_arc(room, waiting, scope, cell):
    """Follow the last arc that waits: ``(waiting, fate, row, samples)``; ``row`` is a fate where it is lost.

    It is left in ``room.own`` as it was at its last sample.
    """
    known, body, wall, law, turns = cell.known, cell.body, cell.wall, cell.known.law, cell.known.turns
    z, ring, arc = room.z, room.ring, room.arc
    watch = watched(law, wall)
    waiting -= 1
    take_arc(room, waiting)
    narrow = arc[HIGH] - arc[LOW] <= NARROWEST
    run, next_test, wait, taken, shorter = 0, FIRST_REST_TEST, scope.patience, 0, False
    since = int(arc[SAMPLE]) % scope.patience
    while True:
        keep_arc(room)
        if arc[SAMPLE] >= scope.budget or not -scope.limit < z[0] < scope.limit:
            return waiting, LOST, UNSETTLED if arc[SAMPLE] >= scope.budget else GREW, taken
        reach, last, before = apart_of(room, body), arc[LEVEL], arc[BEFORE]
        taken += 1
        level, high = look_up(room, 0, cell)
        which = 0
        if level == high:
            if arc[SAMPLE] == 0.0:
                before = begin_at(law, level, ring, wall)
            elif tells_counts(turns, arc) and is_compared(steps_deeper(level, last, watch), True, body):
                row = captor(z, before, ring, 0 * len(ring), reach, known, body, wall)
                if row >= 0:
                    return waiting, ENDED, row, taken
            run = run + 1 if level == last else 0
            if level != last:
                next_test = FIRST_REST_TEST
            elif run >= next_test:
                next_test = 2 * run
                row = rest_of_arc(room, reach, level, narrow, cell)
                if row >= 0:
                    return waiting, ENDED, row, taken
                if row == FULL:
                    return waiting, LOST, NO_ROOM, taken
                shorter = shorter or row == SEVERAL
            if since >= wait and not shorter:
                here = Centre(z, before, ring, 0 * len(ring), arc[ERROR], level, arc[SAMPLE], 0.0)
                row, steps = seek(here, scope, cell)
                taken += steps
                if body.halt[0] > 0.0 or not is_proven(row, known):
                    return waiting, LOST, fate_of(row, known), taken
                if known.table[row * FIELDS] == CYCLE_PROVEN:
                    much = MUCH * (known.table[row * FIELDS + 2] - known.table[row * FIELDS + 5])
                    shorter = wait != scope.patience and not narrow and reach_of(body.cogs, body) * reach > much
                since, wait = 0, wait + 2 * int(known.table[row * FIELDS + 1]) + 1
            if shorter:
                waiting, fate, row = shorten_arc(room, waiting, body)
                return waiting, fate, row, taken
            high, which = step_arc(room, before, narrow, cell)
            if which == 0:
                arc[BEFORE] = keep_count(turns, law, arc[COUNT], remembered(level, wall), ring)
                arc[LEVEL], arc[TOLD] = level, 0.0
                arc[SAMPLE] += 1.0
                since += 1
                continue
        waiting, fate, row = take_apart(room, waiting, which, high, narrow, cell)
        return waiting, fate, row, taken


def follow_friction_arcs(start, first, samples, stack, scope, room, cell):
    """Follow the intervals of phases that wait until none does or ``samples`` are taken.

    Args:
        start: State before the first sample, (order).
        first: Intervals that wait, in ``stack``.
        samples: That may pass.
        stack: Room for intervals, `INTERVAL` numbers each: low and high phase, and those from which to which it counts.
        scope: `scope.Scope`.
        room: `friction_arc_search.RubRoom`.
        cell: `cell.Cell`, its bounds as `friction_arc_search.rub_drift` has them; shares are entered into its table.

    Returns ``(waiting, ended, undecided, shortest, taken)`` as `friction_phases.follow_phases`.
    """
    waiting, ended, undecided, shortest, taken = first, 0, 0.0, 1.0, 0
    known, body = cell.known, cell.body
    rate = start_rate(start, body, room.pad)
    while waiting > 0 and taken < samples and not body.halt[0] > 0.0:
        waiting -= 1
        length = stack[INTERVAL * waiting + 1] - stack[INTERVAL * waiting]
        for j in range(STATE):
            room.arc[j] = 0.0
        for j in range(INTERVAL):
            room.arc[LOW + j] = stack[INTERVAL * waiting + j]
        for j in range(len(room.ring)):
            room.ring[j] = 0.0
        begin_phases(start, rate, room, cell.drift, body)
        keep_arc(room)
        wait_arc(room, 0, -1.0, 1.0, -1.0, 1.0)
        arcs, begun = 1, 1
        while arcs > 0:
            before = arcs
            arcs, fate, row, used = end_of_arc(room, arcs, scope, cell)
            taken += used
            if fate == PARTED and begun < MOST:
                begun += arcs - before
                continue
            counted = max(room.own[TO] - room.own[FROM], LEAST_WEIGHT)
            halted, more = body.halt[0] > 0.0, -1  # where all stand still nothing has ended
            if fate == ENDED and not halted:
                known.table[row * FIELDS + 6] += counted
                shortest = min(shortest, counted)
                ended += 1
                continue
            if arcs < 0 or fate == PARTED:
                fate, row, arcs = AGAIN, NO_ROOM, before - 1
            if fate == AGAIN or counted > UNPROVEN or halted:
                more = begin_again(stack, waiting, room.own, 0, length)
            if more < 0:
                blame(NO_ROOM if fate == AGAIN else row, counted, known)
                undecided += counted
                ended += 1
            waiting = max(waiting, more)
            full = fate == AGAIN and row == NO_ROOM
            while (full or halted) and arcs > 0:  # what waits of this beginning is begun anew, too
                arcs -= 1
                more = begin_again(stack, waiting, room.stack, arcs * (len(room.stack) // ARCS), length)
                if more < 0:
                    blame(NO_ROOM, 1.0, known)
                    undecided += 1.0
                waiting = max(waiting, more)
    return waiting, ended, undecided, shortest, taken
