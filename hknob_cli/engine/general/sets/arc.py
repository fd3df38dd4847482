"""All clock phases of one start: an arc of states, cut where a sample of it meets a count edge.

An arc is a centre, which is a trial, and two clock phases; `curve` says how its other states lie. Where an edge has to
be found on it, it is a chord, and the rate of its rate bounds how far it bulges from it: an arc that bulges by more
than rounding is cut beside the edge first, and what is left there is so short that it is straight.
"""

from typing import NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import GREW as GREW_FATE
from hknob_cli.engine.follow import UNSETTLED
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.sets.arc_parts import (
    arc_size,
    part_arc,
    split_arc,
    take_arc,
    turns_apart,
    wait_arc,
)
from hknob_cli.engine.general.sets.ball import CAPTURED, FIRST_REST_TEST, GREW, MEETS_EDGE, follow_ball, step_through
from hknob_cli.engine.general.sets.cell import Centre, acting_as
from hknob_cli.engine.general.sets.curve import measure_arc, place_on
from hknob_cli.engine.general.sets.known import blame, fate_of, is_proven, seek
from hknob_cli.engine.general.sets.memory import begin_at, watched
from hknob_cli.engine.general.sets.turns import (
    count_of,
    edge_reach,
    half_of,
    highest_at,
    level_at,
    peek,
)

SHORTEST = 1e-13  # phases: no shorter arc is told apart
OPEN, ENDED, UNPROVEN, PARTED = range(4)  # what becomes of an arc
FLAT = 0.0625  # bulge by the way from end to end, above which an arc is halved and not cut


class Sight(NamedTuple):
    """What an arc shows at its next sample.

    Attributes:
        narrow: How far its places may be from where they are told, if it is straight.
        bow: How far it may lie from its chord.
        reach: How far from its places an edge matters.
        least: Its lowest reading.
        most: Its highest reading.
    """

    narrow: float
    bow: float
    reach: float
    least: float
    most: float


def fill_arcs(start, room, drift, body):
    """Let all phases of a start wait as one arc; a bound on the rounding of every state of it, by its centre's."""
    delay = len(room.own_ring)
    place_on(0.5, start, room.own_z, room, body)
    slack = drift.coast * norm(room.rate, body)
    error = slack
    for j in range(body.order):
        error += 8.0 * EPSILON * drift.units[j] * (abs(start[j]) + abs(room.own_z[j]))
    for j in range(delay):
        room.own_ring[j] = 0.0
    wait_arc(room, 0, (0.0, 1.0), Centre(room.own_z, 0.0, room.own_ring, 0 * delay, error, 0.0, 0.0, 1.0))
    return slack


def readings_of(room, centre, reach, cell):
    """The least and the greatest reading of an arc at its next sample, whose places may be wrong by ``reach``."""
    turns, law, watch, x = cell.known.turns, cell.known.law, watched(cell.known.law, cell.wall), centre.z[0]
    left, right, half, shown = x + room.below[0], x + room.above[0], half_of(turns, centre.sample == 0, watch), 0.0
    if centre.sample > 0:
        shown = count_of(turns, law, centre.before, centre.ring)
    least = level_at(turns, min(left, right) - reach, shown, half, cell.drift.bottom, watch)
    return least, level_at(turns, max(left, right) + reach, shown, half, cell.drift.bottom, watch)


def look_at_arc(room, centre, slack, bulge, cell):
    """The `Sight` of an arc that bulges by so much."""
    narrow = cell.body.reach * (centre.error + slack) + 8.0 * EPSILON * abs(centre.z[0])
    bow = cell.body.reach * bulge
    reach = edge_reach(cell.known.turns, narrow) + bow
    least, most = readings_of(room, centre, reach, cell)
    return Sight(narrow, bow, reach, least, most)


def cut_around(room, centre, span, edge, reach):
    """The two phases between which an arc that bends may meet an ``edge``, so that neither outer part does.

    Each lies so far from the edge that an outer part, whose own reach is below twice this one, does not meet it. The
    part between them is less than half of the arc; and as it comes to the edge, an outer part is never all of it.
    """
    low, high = span
    left, right = centre.z[0] + room.below[0], centre.z[0] + room.above[0]
    one, other = (edge - 2.0 * reach - left) / (right - left), (edge + 2.0 * reach - left) / (right - left)
    first = low + (high - low) * max(0.0, min(one, other))
    last = low + (high - low) * min(1.0, max(one, other))
    if first >= high or last <= low:  # by rounding
        return 0.5 * (low + high), 0.5 * (low + high)
    return first, last


def divide_arc(room, waiting, span, centre, blurry, sight, cell):
    """Let the parts of an arc wait that cannot be moved on as a whole: how many wait, -1 where there is no room.

    ``blurry``: its centre, told to within what any of its states is.
    """
    narrow, bow, reach, least, most = sight
    low, high = span
    turns, law, watch = cell.known.turns, cell.known.law, watched(cell.known.law, cell.wall)
    if waiting > len(room.stack) // arc_size(cell.body.order, len(room.own_ring)) - 4:
        return -1
    if not high - low > SHORTEST or not (bow > narrow or turns_apart(room, centre, reach, least, most, cell)):
        return part_arc(room, waiting, span, blurry, reach, least, most, cell)
    first, last = 0.5 * (low + high), 0.5 * (low + high)
    if bow > narrow and bow < FLAT * abs(room.above[0] - room.below[0]) and least < most:
        half, shown = half_of(turns, centre.sample == 0, watch), 0.0
        if centre.sample > 0:
            shown = count_of(turns, law, centre.before, centre.ring)
        first, last = cut_around(room, centre, span, highest_at(turns, least, shown, half, watch), reach)
    return split_arc(room, waiting, span, first, last, blurry, cell)


def enter_arc(span, row, totals, room, known):
    """Enter an arc that has ended, in the attractor of this row; below 0: in none that is proven."""
    low, high = span
    if row >= 0:
        known.table[row * FIELDS + 6] += high - low
    ended = int(totals[0])
    if 3 * ended + 3 <= len(room.ended):
        room.ended[3 * ended], room.ended[3 * ended + 1], room.ended[3 * ended + 2] = low, high, row
    totals[0] += 1.0
    totals[2] = min(totals[2], high - low)
    totals[3] += high - low


def follow_arc(span, centre, waiting, slack, left, scope, room, cell):
    """Follow one arc until it ends, or waits in parts: ``(waiting, fate, row, samples)``, waiting -1 without room.

    After ``left`` samples or more it may wait as it is.
    """
    drift, known, body, law = cell.drift, cell.known, cell.body, cell.known.law
    low, high = span
    run, next_test, since, wait = 0, FIRST_REST_TEST, 0, scope.patience
    at, taken = int(centre.sample), 1
    radius, bulge = measure_arc(low, high, at, room, drift, body)
    while True:
        event, row, used = MEETS_EDGE, -1, 0
        if at > 0:
            event, row, centre, run, next_test = follow_ball(
                centre,
                radius + slack,
                run,
                next_test,
                min(wait - since, scope.budget - at),
                scope.limit,
                False,
                cell,
            )
            used = int(centre.sample) - at
        at, since, taken = at + used, since + used, taken + used
        if event == CAPTURED:
            return waiting, ENDED, row, taken
        if event == GREW or at >= scope.budget:
            blame(GREW_FATE if event == GREW else UNSETTLED, high - low, known)
            return waiting, UNPROVEN, -1, taken
        radius, bulge = measure_arc(low, high, at, room, drift, body)
        if event != MEETS_EDGE:
            # Long in no known attractor: its middle's own is found, and entered.
            since, wait = 0, 2 * wait
            row, steps = seek(centre, scope, cell)
            taken += steps
            if body.halt[0] > 0.0 or taken >= left:
                return wait_arc(room, waiting, span, centre), PARTED, row, taken
            if not is_proven(row, known):
                blame(fate_of(row, known), high - low, known)
                return waiting, UNPROVEN, row, taken
            continue
        # The ball meets an edge: the arc itself is looked at.
        sight = look_at_arc(room, centre, slack, bulge, cell)
        least, same, then = sight.least, sight.least == sight.most, 0.0
        if same and at == 0:
            before = begin_at(law, least, centre.ring, cell.wall)
            centre = acting_as(centre, centre.level, before, centre.error)
        acts = acting_as(centre, least, centre.before, centre.error)
        if same:
            same, then = peek(acts, radius + slack + centre.error, cell)
        if not same:
            blurry = acting_as(centre, centre.level, centre.before, centre.error + slack)
            return divide_arc(room, waiting, span, centre, blurry, sight, cell), PARTED, row, taken
        run, next_test = (run + 1, next_test) if centre.level == least else (0, FIRST_REST_TEST)
        centre = step_through(acts, then, cell, room.pad)
        at, since, taken = at + 1, since + 1, taken + 1


def follow_arcs(waiting, slack, samples, totals, scope, room, cell):
    """Follow arcs until none waits or ``samples`` are taken: ``(waiting, samples)``, waiting -1 where there is no room.

    ``totals``: arcs that ended, the phases that did not end proven, the shortest arc, the length of all; added to.
    """
    known, taken = cell.known, 0
    while waiting > 0 and taken < samples and not cell.body.halt[0] > 0.0:
        span, centre = take_arc(room, waiting - 1)
        waiting, fate, row, used = follow_arc(span, centre, waiting - 1, slack, samples - taken, scope, room, cell)
        taken += used
        if fate == UNPROVEN:
            totals[1] += span[1] - span[0]
        if fate != PARTED:
            enter_arc(span, row, totals, room, known)
    return waiting, taken
