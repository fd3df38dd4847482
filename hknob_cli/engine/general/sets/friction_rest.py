"""Rest under Coulomb friction: whether all states of a piece provably come to rest within one reading.

A rest that friction holds for ever is a motion, and the distance of two motions that get the same commands never grows.
So all states nearer to such a rest than it is to a count edge keep its reading, and damping and friction bring them to
rest in it. A piece whose states all stand needs no distance: friction holds each where it is.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import REST_PROVEN
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.controller import lower_edge, read, upper_edge
from hknob_cli.engine.general.inner_region import ROUNDINGS, hold_zone
from hknob_cli.engine.general.sets.friction_piece import stands
from hknob_cli.engine.general.sets.known import FULL, add_end
from hknob_cli.engine.general.sets.memory import copy_settled, keeps_torque, settle_memory, watched
from hknob_cli.engine.general.sets.turns import half_of, highest_at, lowest_at
from hknob_cli.engine.general.standstill import rest_rounding

UNKNOWN = -1


def enter_rest(x, shown, u, centre, cell):
    """Row of the rest at ``x``, which reads ``shown``, under the torque ``u``, of a set told from ``centre``."""
    known, body = cell.known, cell.body
    known.z[0], known.z[1] = x, 0.0
    if body.lag > 0.0:
        known.z[2] = u
    copy_settled(known.law, centre.ring, known.ring)
    return add_end(REST_PROVEN, 1, shown, 0 * len(centre.ring), known, body, cell.wall)


def reading_at(x, level, cell):
    """What a knob shows that comes to rest at ``x``: behind hysteresis, where all act as ``level``, that."""
    if cell.known.turns is None:
        return read(x, cell.wall)
    return level


def span_of(level, cell):
    """From where to where positions keep ``level``, once it is the reading."""
    turns, watch = cell.known.turns, watched(cell.known.law, cell.wall)
    half = half_of(turns, False, watch)
    bottom = lowest_at(turns, level, level, half, cell.drift.bottom, watch)
    return bottom, highest_at(turns, level, level, half, watch)


def held_rest(span, zone, shift, reach, u, centre, cell):
    """Row of a rest where the states of a ``span`` that stand stay; all readings that it can have are entered.

    ``zone``: from where to where friction holds a knob, and by how much that may truly go on beyond either end; a count
    that is reached only there is not known to have a rest or to have none. ``reach``: by which true positions may lie
    beyond the span. Those that truly act as the centre's level count. What is not held never gets farther from the end
    of the zone than it is: it ends there, or as far into the zone. ``shift``: by which a torque that has not come to
    its end may still move the zone; where it does, all must stand inside what is left of the zone at any time.
    """
    zone_low, zone_high, blur = zone
    wall, turns = cell.wall, cell.known.turns
    bottom, top = span_of(centre.level, cell)
    low, high = span[0] - reach, span[1] + reach
    if shift > 0.0 and not (zone_low + shift <= low and high <= zone_high - shift):
        return UNKNOWN
    under, over = max(0.0, zone_low - low), max(0.0, high - zone_high)
    if under > 0.0 and not (zone_low - under > bottom and zone_low + under < top):
        return UNKNOWN
    if over > 0.0 and not (zone_high - over > bottom and zone_high + over < top):
        return UNKNOWN
    inside = 2.0 * reach + 8.0 * EPSILON
    first, last = min(max(low, bottom + inside), top - inside), max(min(high, top - inside), bottom + inside)
    first, last = min(first, zone_high) - over, max(last, zone_low) + under
    shown = read(max(first, zone_low - blur, bottom + inside), wall)
    end, row = read(min(last, zone_high + blur, top - inside), wall), UNKNOWN
    middle = 0.5 * (max(first, zone_low) + min(last, zone_high))
    if turns is not None:
        at = min(max(middle, bottom + inside), top - inside)
        return enter_rest(at, centre.level, u, centre, cell) if zone_low <= at and at <= zone_high else UNKNOWN
    while shown <= end:
        at = min(max(middle, lower_edge(shown, wall) + inside), upper_edge(shown, wall) - inside)
        if not (zone_low <= at and at <= zone_high):
            return UNKNOWN
        row = enter_rest(at, shown, u, centre, cell)
        if row == FULL:
            return row
        shown += 1.0
    return row


def balance_rest(centre, reach, u, wrong, cell):
    """Row of the rest without friction that all states within ``reach``, counts, of a centre come to.

    ``wrong``: bound on the rounding of the torque ``u``.
    """
    body, z, away = cell.body, centre.z, cell.known.space.away
    bottom, top = span_of(centre.level, cell)
    rest = (u + body.drive) / body.beta
    for j in range(body.order):
        away[j] = 0.0  # what a torque that lags still adds is in ``reach``
    away[0], away[1] = z[0] - rest, z[1]
    gap = min(rest - bottom, top - rest)
    bound = rest_rounding(z, rest, abs(u) + wrong / (ROUNDINGS * EPSILON), body)
    if not (body.reach * norm(away, body) + reach) * (1.0 + 1e-9) + 1e-12 + bound < gap:
        return UNKNOWN
    return enter_rest(rest, reading_at(rest, centre.level, cell), u, centre, cell)


def near_rest(centre, reach, u, zone, cell):
    """Row of the rest that all states within ``reach``, counts, of a centre come to within one reading."""
    body, wall, z = cell.body, cell.wall, centre.z
    shown, away = read(z[0], wall), cell.known.space.away
    low, high = lower_edge(shown, wall), upper_edge(shown, wall)
    if cell.known.turns is not None:
        low, high = span_of(centre.level, cell)
        shown = centre.level
    elif not keeps_torque(cell.known.law, z[0], centre.level, u, wall):
        return UNKNOWN
    for j in range(body.order):
        away[j] = 0.0
    for k in range(2):
        rest = min(max(z[0] if k == 0 or high == float("inf") else 0.5 * (low + high), zone[0]), zone[1])
        away[0], away[1] = z[0] - rest, z[1]
        gap = min(rest - low, high - rest)
        if (body.reach * norm(away, body) + reach) * (1.0 + 1e-9) + 64.0 * EPSILON * (1.0 + abs(rest)) < gap:
            return enter_rest(rest, shown, u, centre, cell)
    return UNKNOWN


def resting_piece(centre, error, radius, corners, count, cell):
    """Row of the rest where all states of a piece end, `known.FULL` without room for it, -1 if none is known to.

    ``error``: of its centre, with all that torques may still add; ``radius``: both in `body.norm`.
    """
    z, body, wall = centre.z, cell.body, cell.wall
    still, u, wrong, left = settle_memory(cell.known.law, z[0], centre.level, centre.before, centre.ring, wall)
    if not still:
        return UNKNOWN
    late = 0.0
    if body.lag > 0.0:
        # The torque that acts follows its command: it is late by what it differs by now, and as long as that differs.
        late = abs(z[2] - u)
        left += late / body.lag
    # By what torques still differ the distance of two motions grows, at most.
    away = body.reach * (radius + error + left)
    if body.friction == 0.0:
        return balance_rest(centre, away, u, wrong, cell)
    stiffness, zone_low, zone_high = hold_zone(u, centre.level, body, wall)
    if wrong > 0.0:
        zone_low, zone_high = zone_low + wrong / stiffness, zone_high - wrong / stiffness
    if zone_low > zone_high:
        return UNKNOWN
    zone = zone_low, zone_high, 2.0 * body.friction / stiffness - (zone_high - zone_low)
    if stands(z[1], corners, count):
        least, most = corners[0], corners[0]
        for k in range(1, count):
            least, most = min(least, corners[2 * k]), max(most, corners[2 * k])
        reach = body.reach * error + 8.0 * EPSILON * abs(z[0])
        row = held_rest((z[0] + least, z[0] + most), zone, (left + late) / body.beta, reach, u, centre, cell)
        if row != UNKNOWN:
            return row
    return near_rest(centre, away, u, zone, cell)
