"""Rest under a law: one reading for ever, and what is remembered comes to an end that is known.

Under a reading that goes on, what is counted stops changing, and what fades comes nearer to its fixed point in each
sample. So all that the torques will still differ by from their last value is a known sum. As in `general.standstill`
and `general.inner_region`, the distance from a rest under that last torque cannot grow by more.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import acceleration, copy_to, distance
from hknob_cli.engine.general.cog_rest import LastTorque, keeps_to_slope, settles_free
from hknob_cli.engine.general.cogging import cog_pull, has_cogs
from hknob_cli.engine.general.controller import edge_gap, table_size
from hknob_cli.engine.general.flank_rest import flank_room
from hknob_cli.engine.general.inner_region import ROUNDINGS, hold_zone, rest_at
from hknob_cli.engine.general.laws.cascade import faded, pushed_apart, same_count, settle_faded, torques_apart
from hknob_cli.engine.general.laws.step import decide
from hknob_cli.engine.general.standstill import SETTLING, find_balance, rest_rounding, stays_held
from hknob_cli.engine.rest import AT_REST, MOVING, REST_ON_EDGE, RINGS


def settled_past(past, shown, wall, law):
    """Leave in ``law.periodic`` what is remembered where ``shown`` goes on for ever; whether it is, and the guard.

    False where something that is counted still changes, or where the torques of an interval differ.
    """
    for j in range(law.rows, law.line):
        if past[j] != shown:
            return False, 0.0
    copy_to(law.periodic, past)
    decide(shown, 0.0, law.periodic, wall, law)
    if not same_count(law.periodic, past, law):
        return False, 0.0
    settle_faded(law.periodic, past, 1, law)
    guard = 0.0
    for _ in range(law.ages):
        guard = decide(shown, 0.0, law.periodic, wall, law)
    newest = law.line + (law.ages - 1) * law.parts
    for i in range(law.parts):
        if law.periodic[newest + i] != law.periodic[newest]:
            return False, guard
    return True, guard


def settled_torque(x, shown, past, wall, law):
    """The `cog_rest.LastTorque` where ``shown`` goes on for ever: ``(whether it comes to an end, torque)``.

    ``x``: where the knob is. What is remembered in the end is left in ``law.periodic``.
    """
    none = LastTorque(0.0, 0.0, 0.0)
    if law.senses or not law.provable:
        return False, none
    still, guard = settled_past(past, shown, wall, law)
    if not still:
        return False, none
    worn = 0.0  # by how much what fades may end elsewhere: its last steps are smaller than a rounding
    if law.fading >= 0:
        worn = ROUNDINGS * EPSILON * (1.0 + abs(x) + abs(law.periodic[law.fading])) / (1.0 - law.fade)
    if law.weight > 0.0 and not guard > faded(past, law.periodic, law) + worn:
        return False, none
    u = law.periodic[law.line + (law.ages - 1) * law.parts]
    size = abs(u) + table_size(shown, wall) + law.unit * (1.0 + abs(x))  # of its terms, which may cancel
    wrong = law.weight * worn + ROUNDINGS * EPSILON * law.coarse * size
    return True, LastTorque(u, wrong, torques_apart(past, law.periodic, law))


def swings_to_rest(z, torque, shown, body, watch, orbit, away):
    """Fate without friction or cogging of a trial under its last torque; the rest point is left in ``orbit``."""
    u, wrong, left = torque
    if not find_balance(u, body, orbit):
        return MOVING
    for i in range(body.order):
        away[i] = z[i] - orbit[i]
    gap = edge_gap(orbit[0], shown, shown, watch)
    # Under a torque that is off by so much the knob swings about another rest, and comes as far beyond that.
    bound = rest_rounding(z, orbit[0], abs(u) + 2.0 * wrong / (ROUNDINGS * EPSILON), body)
    reach = distance(away, body) + pushed_apart(left, z[0], body)
    if body.play > 0.0 and not reach + bound < flank_room(body.pad_stiffness * orbit[2], body):
        return MOVING
    if reach + bound < gap:
        return AT_REST if body.damped else RINGS
    return REST_ON_EDGE if abs(gap) <= bound and reach < 1e-6 else MOVING


def is_held(z, torque, body):
    """Whether friction holds a knob under all that its torques will ever be."""
    u, wrong, left = torque
    cogged = cog_pull(body.cogs, z[0])
    if body.order == 2 and z[1] == 0.0 and abs(acceleration(z, u, body) + cogged) + left + wrong <= body.friction:
        return True
    return left == 0.0 and stays_held(z, u - wrong, body) and stays_held(z, u + wrong, body)


def slides_to_rest(z, torque, shown, body, watch, away):
    """Whether friction, without cogging, brings a knob to rest before its reading changes."""
    u, wrong, left = torque
    if body.ratio > 0.0 and body.pad_damping + body.finger_damping == 0.0:
        return False
    stiffness, low, high = hold_zone(u, shown, body, watch)
    if stiffness > 0.0:
        low, high = low + wrong / stiffness, high - wrong / stiffness
    if low > high:
        return False
    rest = min(max(z[0], low), high)
    rest_at(rest, u, stiffness, away, body)
    teeth = body.pad_stiffness * away[2] if body.play > 0.0 else 0.0
    for i in range(body.order):
        away[i] = z[i] - away[i]
    gap = edge_gap(rest, shown, shown, watch)
    push = pushed_apart(left, z[0], body)
    reach = distance(away, body) + push + ROUNDINGS * EPSILON * (1.0 + abs(rest) + abs(z[0]))
    if body.play > 0.0 and not reach < flank_room(teeth, body):
        return False
    return reach < gap


def settles_with_law(z, shown, past, body, wall, law, orbit, away):
    """Fate of a trial whose reading goes on, as `standstill.settles`; the rest point is left in ``orbit``."""
    still, torque = settled_torque(z[0], shown, past, wall, law)
    if not still:
        return MOVING
    if body.friction == 0.0:
        if has_cogs(body.cogs):
            fate, _ = settles_free(body.cogs, z, torque, shown, body, law.watch, orbit, away)
            return fate
        return swings_to_rest(z, torque, shown, body, law.watch, orbit, away)
    copy_to(orbit, z)
    if is_held(z, torque, body):
        gap = edge_gap(z[0], shown, shown, law.watch)
        return AT_REST if gap > ROUNDINGS * EPSILON * (1.0 + abs(z[0])) else REST_ON_EDGE
    if has_cogs(body.cogs):
        settling, _ = keeps_to_slope(body.cogs, z, torque, shown, body, law.watch, orbit, away)
    else:
        settling = slides_to_rest(z, torque, shown, body, law.watch, away)
    return SETTLING if settling else MOVING
