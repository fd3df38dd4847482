"""Rest of an arc with friction: whether all of its states provably come to rest, and in which readings."""

from math import inf

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import REST_PROVEN
from hknob_cli.engine.general.body import stiffness
from hknob_cli.engine.general.cog_rest import zone_on
from hknob_cli.engine.general.cogging import (
    ROOT,
    cog_number,
    cog_room,
    far_apart,
    has_cogs,
    own_stiffness,
    reach_of,
    reach_on,
    slope_of,
)
from hknob_cli.engine.general.controller import lower_edge, read, upper_edge
from hknob_cli.engine.general.inner_region import ROUNDINGS, hold_zone, rest_at
from hknob_cli.engine.general.sets.friction_arc import BEFORE, STANDS
from hknob_cli.engine.general.sets.known import FULL, add_end, resting
from hknob_cli.engine.general.sets.memory import copy_settled, settle_memory, watched
from hknob_cli.engine.general.sets.turns import half_of, highest_at, lowest_at
from hknob_cli.engine.general.standstill import stays_held

UNKNOWN, SEVERAL = -1, -3  # instead of the row of a rest


def zone_of(z, stands, u, wrong, level, body, wall):
    """Stiffness of a hand's springs, felt by the knob, and where friction holds it: ``(spring, low, high, blur)``.

    ``low`` above ``high`` where there are none. ``blur``: how far beyond it may do so within rounding. Beside cogging
    the zone is that of the slope at ``z``, and nothing is known of places beyond; of an arc that ``stands`` it is told
    elsewhere whether friction holds it.
    """
    if has_cogs(body.cogs):
        own = own_stiffness(body)
        if stands:
            return own, -inf, inf, 0.0
        low, high = zone_on(body.cogs, z[0], u, wrong, body)
        return own, low, high, inf
    spring, low, high = hold_zone(u, level, body, wall)
    if not spring > 0.0:
        return 0.0, 1.0, 0.0, 0.0
    low, high = low + wrong / spring, high - wrong / spring
    return spring, low, high, 2.0 * body.friction / spring - (high - low)


def stay_held(z, u, other, body):
    """As `stays_held`, of all states that stand and whose torques differ from that of ``z`` by at most ``other``.

    A torque that lags differs with the one that it goes to: else what is left of its way would make up for it.
    """
    late, held = z[body.order - 1], True
    for sign in (-1.0, 1.0):
        if body.lag > 0.0:
            z[body.order - 1] = late + sign * other
        held = held and stays_held(z, u + sign * other, body)
    z[body.order - 1] = late
    return held


def rest_of_arc(room, reach, level, narrow, cell):
    """Row of the rest where all states of the arc in ``room`` end that acts as ``level``.

    As `friction_rest.near_rest`. `UNKNOWN` if none is known to, `SEVERAL` where they may rest in more than one reading;
    if ``narrow``, each of these is entered. ``reach``: of the arc, in `body.norm`.
    """
    drift, known, body, wall, turns = cell.drift, cell.known, cell.body, cell.wall, cell.known.turns
    z, ring, before, away = room.z, room.ring, room.arc[BEFORE], known.space.away
    if body.friction == 0.0:
        return resting(z, before, ring, reach, level, known, body, wall)
    still, u, wrong, left = settle_memory(known.law, z[0], level, before, ring, wall)
    if not still or (body.ratio > 0.0 and body.pad_damping + body.finger_damping == 0.0):
        return UNKNOWN
    stands = room.arc[STANDS] > 0.0 and left == 0.0
    spring, low, high, blur = zone_of(z, stands, u, wrong, level, body, wall)
    if low > high:
        return UNKNOWN
    rest = min(max(z[0], low), high)
    rest_at(rest, u, spring, away, body)
    for j in range(body.order):
        away[j] = z[j] - away[j]
    far = reach_of(body.cogs, body) * reach * (1.0 + 1e-9)
    if not (stands and has_cogs(body.cogs)):
        far = (far_apart(body.cogs, away, rest, body) + reach_on(body.cogs, rest, body) * (reach + left)) * (1.0 + 1e-9)
    far += ROUNDINGS * EPSILON * (1.0 + abs(rest) + abs(z[0]))
    watch = watched(known.law, wall)
    half = half_of(turns, False, watch)
    bottom = lowest_at(turns, level, level, half, drift.bottom, watch)
    top = highest_at(turns, level, level, half, watch)
    if stands:
        other = wrong + (stiffness(body) + cog_number(body.cogs, ROOT)) * reach
        if not stay_held(z, u, other, body):
            return UNKNOWN
    elif not far < min(rest - bottom, top - rest, cog_room(body.cogs, rest, slope_of(body.cogs, z[0]))):
        return UNKNOWN
    inside = 8.0 * EPSILON * (1.0 + abs(rest))
    if turns is not None:  # the count stays as it is
        at = min(max(rest, bottom + inside), top - inside)
        if not low <= at <= high:
            return UNKNOWN
        rest_at(at, u, spring, known.z, body)
        copy_settled(known.law, ring, known.ring)
        return add_end(REST_PROVEN, 1, level, 0 * len(ring), known, body, wall)
    shown, last, row = read(max(rest - far, bottom + inside), wall), read(min(rest + far, top - inside), wall), UNKNOWN
    if shown < last and not narrow:
        return SEVERAL
    while shown <= last:
        at = min(max(rest, lower_edge(shown, wall) + inside), upper_edge(shown, wall) - inside)
        if low <= at <= high:
            rest_at(at, u, spring, known.z, body)
            copy_settled(known.law, ring, known.ring)
            row = add_end(REST_PROVEN, 1, shown, 0 * len(ring), known, body, wall)
            if row == FULL:
                return row
        elif low - blur <= at <= high + blur:
            return UNKNOWN
        shown += 1.0
    return row
