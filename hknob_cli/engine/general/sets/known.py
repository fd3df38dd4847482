"""The attractors known so far of a cell, and whether one of them captures a set of states.

The same as `engine.sets.ball`, with what the general loop has more: states of any order, commands under way, and the
last reading. Reaches are bounds on a distance from the centre in `body.norm`, in which the free plant never grows.
"""

from hknob_cli.engine.certificate import PROVEN
from hknob_cli.engine.follow import CYCLE_PROVEN, GREW, REST_PROVEN, UNSETTLED
from hknob_cli.engine.general.body import copy_to, distance
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.cog_rest import LastTorque, balance_on, stays_on_slope
from hknob_cli.engine.general.cogging import far_around, has_cogs, reach_on
from hknob_cli.engine.general.controller import edge_gap, inside, read
from hknob_cli.engine.general.follow import KNOWN
from hknob_cli.engine.general.sets.memory import (
    OrbitSample,
    advance_memory,
    certify_again,
    copy_settled,
    counted_alike,
    enter_end,
    find_end,
    memory_apart,
    reading_of,
    rest_within,
    settle_memory,
    store_memory,
    watched,
)
from hknob_cli.engine.rest import AT_REST

POINTS_OF_ORBIT = 64  # samples of an orbit, where the wall steps deeper, at which sets are compared with it
FULL, UNPROVEN_END = -2, -1  # instead of a row
NO_ROOM = 12  # beside the fates of `general.follow`: more ends, or more pieces, than a cell keeps


def is_compared(deeper, deepest, body):
    """Whether sets are compared with a sample of a proven orbit: where the wall steps ``deeper``.

    Beside cogging at its ``deepest`` one, as it is known only there what an orbit over corners captures.
    """
    return deepest if has_cogs(body.cogs) else deeper


def walk_points(row, before, known, body, wall):
    """Enter the samples of a proven orbit at which the wall steps deeper, as far as there is room.

    The orbit, which is that of ``row``, goes through ``known.z`` with what ``known.ring`` remembers, oldest first.
    """
    n, delay = body.order, len(known.ring)
    width = n + delay + 2
    period, head = int(known.table[row * FIELDS + 1]), 0 * delay
    count, entered, last = int(known.counts[1]), 0, 0.0
    for i in range(2 * period):
        shown = reading_of(known.law, known.z, before, known.ring, wall)
        wanted = is_compared(inside(shown, wall) < inside(last, wall), i == period, body)
        if i >= period and wanted and entered < POINTS_OF_ORBIT and (count + 1) * width <= len(known.points):
            base = count * width
            known.points[base], known.points[base + 1] = row, before
            if wall.hysteresis > 0.0:
                known.points[base + 1] = inside(before, wall)
            for j in range(n):
                known.points[base + 2 + j] = known.z[j]
            store_memory(known.law, known.ring, head, known.points, base + 2 + n)
            count += 1
            entered += 1
        last = shown
        before, head = advance_memory(known.law, known.z, before, known.ring, head, body, wall, known.space.pad)
    known.counts[1] = count


def add_points(row, known, body, wall):
    """Enter these samples of the orbit of a row that is new."""
    n, delay = body.order, len(known.ring)
    for j in range(n):
        known.z[j] = known.states[row * n + j]
    for j in range(delay):
        known.ring[j] = known.lines[row * delay + j]
    walk_points(row, known.table[row * FIELDS + 9], known, body, wall)


def has_points(row, known, body):
    """Whether samples of the orbit of ``row`` are entered that count as ``known.ring`` does near ``known.z``."""
    n, delay = body.order, len(known.ring)
    width = n + delay + 2
    for k in range(int(known.counts[1])):
        base = k * width
        near = abs(known.z[0] - known.points[base + 2]) < known.table[row * FIELDS + 2]
        if known.points[base] == row and near and counted_alike(known.law, known.ring, known.points, base + 2 + n):
            return True
    return False


def add_memory(row, known, body, wall):
    """Enter the samples of a known orbit that is at ``known.z``, deepest, with what ``known.ring`` remembers there.

    From other starts an average may come to a number that differs by a unit in the last place, and stay there. The
    orbit is proven with it, too, and has the smaller margin of the two and the larger error.
    """
    base = row * FIELDS
    if counted_alike(known.law, known.ring, known.lines, row * len(known.ring)):
        return
    period = int(known.table[base + 1])
    status, margin, bound, room = certify_again(known.law, period, known, body, wall)
    if status != PROVEN:
        return
    last = inside(reading_of(known.law, known.z, 0.0, known.ring, wall), wall)
    for _ in range(period):  # to a sample at which points are entered
        advance_memory(known.law, known.z, 0.0, known.ring, 0 * len(known.ring), body, wall, known.space.pad)
        shown = inside(reading_of(known.law, known.z, 0.0, known.ring, wall), wall)
        if shown < last:
            break
        last = shown
    if has_points(row, known, body):
        return
    known.table[base + 2] = min(known.table[base + 2], margin)
    known.table[base + 5] = max(known.table[base + 5], bound)
    known.table[base + 9] = min(known.table[base + 9], room)
    walk_points(row, 0.0, known, body, wall)


def add_end(fate, period, before, head, known, body, wall):
    """Row of an end whose state is in ``known.z`` and ``known.ring``, entered where it is new; `FULL` without room."""
    rows = int(known.counts[0])
    row = enter_end(known.law, fate, period, before, head, known, body, wall)
    if row < 0 or row >= len(known.table) // FIELDS:
        return FULL
    if known.table[row * FIELDS] == CYCLE_PROVEN:
        if row == rows:
            add_points(row, known, body, wall)
        elif fate == CYCLE_PROVEN:
            add_memory(row, known, body, wall)
    return row


def captor(z, before, ring, head, reach, known, body, wall):
    """Row of the proven orbit that captures every state within ``reach`` of ``z``; -1 if none is known to.

    To be asked at a sample where the wall steps deeper, or beside cogging at any.
    """
    n, delay = body.order, len(ring)
    points, table, away = known.points, known.table, known.space.away
    width = n + delay + 2
    for k in range(int(known.counts[1])):
        base = k * width
        row = int(points[base])
        at = points[base + 2]
        margin = table[row * FIELDS + 2] - table[row * FIELDS + 5] - reach_on(body.cogs, at, body) * reach
        if not abs(z[0] - at) < margin:
            continue
        sample = OrbitSample(points, base, table[row * FIELDS + 9])
        pushed = memory_apart(known.law, before, ring, head, sample, body, wall)
        for j in range(n):
            away[j] = z[j] - points[base + 2 + j]
        if far_around(body.cogs, away, at, body) + pushed < margin:
            return row
    return -1


def resting_on_slope(z, before, ring, reach, level, known, body, wall):
    """As `resting`, beside cogging: all of these states stay on one slope, whose springs hold the knob."""
    orbit, away, cogs = known.space.orbit, known.space.away, body.cogs
    still, u, wrong, left = settle_memory(known.law, z[0], level, before, ring, wall)
    stands, slack = balance_on(cogs, z, LastTorque(u, wrong, left), body, orbit)
    if not (still and stands):
        return -1
    slack += reach_on(cogs, orbit[0], body) * (reach + left) * (1.0 + 1e-9)
    gap = edge_gap(orbit[0], level, level, watched(known.law, wall))
    stays, _ = stays_on_slope(z, gap, slack, body, orbit, away)
    if not stays:
        return -1
    copy_to(known.z, orbit)
    copy_settled(known.law, ring, known.ring)
    shown = level if wall.hysteresis > 0.0 else read(orbit[0], wall)
    return add_end(REST_PROVEN, 1, shown, 0 * len(ring), known, body, wall)


def resting(z, before, ring, reach, level, known, body, wall):
    """Row of the rest inside one reading where every state within ``reach`` of ``z`` ends; -1 if none is known to.

    ``level``: the reading as which all of them act.
    """
    n, space = body.order, known.space
    if has_cogs(body.cogs):
        return resting_on_slope(z, before, ring, reach, level, known, body, wall)
    fate, shown, gap, push, bound = rest_within(known.law, z, level, before, ring, body, wall, space)
    if fate != AT_REST:
        return -1
    if not (distance(space.away, body) + push + body.reach * reach) * (1.0 + 1e-9) + 1e-12 + bound < gap:
        return -1
    for j in range(n):
        known.z[j] = space.orbit[j]
    copy_settled(known.law, ring, known.ring)
    return add_end(REST_PROVEN, 1, shown, 0 * len(ring), known, body, wall)


def is_proven(row, known):
    """Whether a row is that of an attractor that is proven."""
    return row >= 0 and (known.table[row * FIELDS] == CYCLE_PROVEN or known.table[row * FIELDS] == REST_PROVEN)


def fate_of(row, known):
    """Fate of an end that is not proven, as `seek` gave it."""
    if row >= 0:
        return int(known.table[row * FIELDS])
    return NO_ROOM if row == FULL else UNSETTLED


def blame(fate, weight, known):
    """Enter why a measure of starts has no proven end."""
    known.why[fate] += weight


def seek(centre, scope, cell):
    """What the trial from a centre ends in, entered where it is new: ``(row, samples)``, the row below 0 if unknown.

    The centre is left alone. It may take as many samples as ``scope.budget`` leaves it.
    """
    known, delay, budget = cell.known, len(centre.ring), scope.budget - int(centre.sample)
    for j in range(len(centre.z)):
        known.z[j] = centre.z[j]
    for j in range(delay):
        known.ring[j] = centre.ring[(centre.head + j) % delay]
    fate, period, before, head, used = find_end(
        known.law, centre.before, budget, scope.limit, known, cell.body, cell.wall
    )
    if fate == KNOWN:
        return period, used
    if not (period > 0 or fate == GREW):
        return UNPROVEN_END, used
    return add_end(fate, period, before, head, known, cell.body, cell.wall), used
