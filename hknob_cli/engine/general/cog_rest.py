"""Rest beside cogging: settling on one slope whose springs hold the knob.

As in `standstill` and `inner_region`, by the energy of the distance from a place of rest, which never grows while both
stay on one slope (`cogging.far_apart`). A corner is one more edge that must not be reached.
"""

from typing import NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.cogging import (
    LENGTH,
    SLOPE,
    far_apart,
    hold_stiffness,
    middle_of,
    own_stiffness,
    reach_on,
    room_on,
    slope_at,
)
from hknob_cli.engine.general.controller import edge_gap
from hknob_cli.engine.general.flank_rest import flank_room_on
from hknob_cli.engine.general.torque_curve import has_curve
from hknob_cli.engine.rest import AT_REST, MOVING, REST_ON_EDGE, RINGS

ROUNDINGS = 64.0  # of a position that has stopped changing


class LastTorque(NamedTuple):
    """The torque under a reading that goes on for ever: in the end ``u``, known to within ``wrong``.

    ``left``: impulse, in all, by which it may still differ from that.
    """

    u: float
    wrong: float
    left: float


def is_carried(body):
    """Whether all that moves beside the knob has a place of its own where the knob rests."""
    return body.ratio == 0.0 or (body.pad_stiffness > 0.0 and body.finger_stiffness > 0.0)


def put_at(rest, u, body, orbit):
    """Leave in ``orbit`` the state at rest at a position, under the torque ``u``."""
    for i in range(body.order):
        orbit[i] = 0.0
    orbit[0] = rest
    if body.ratio > 0.0:
        orbit[2] = own_stiffness(body) * (rest + body.shift) / body.pad_stiffness
    if body.lag > 0.0:
        orbit[body.order - 1] = u


def cancelled(own, hold, cogs):
    """How many times larger the rounding of a stiffness is than where no springs cancel: 1 on a stable slope."""
    return (own + cogs[SLOPE]) / hold


def stays_on_slope(z, gap, slack, body, orbit, away):
    """Whether ``z`` keeps for ever to the slope of the rest in ``orbit``, and within ``gap`` of it: ``(whether, far)``.

    ``slack``: what may push it further, and roundings.
    """
    for i in range(body.order):
        away[i] = z[i] - orbit[i]
    rest = orbit[0]
    slope = slope_at(rest, body.cogs)
    far = far_apart(body.cogs, away, rest, body)
    if slope_at(z[0], body.cogs) != slope:
        return False, far
    reach = far + slack
    if body.play > 0.0 and not reach < flank_room_on(body.cogs, body.pad_stiffness * orbit[2], rest, body):
        return False, far  # where teeth part, the energy of a difference may grow
    return reach < gap and reach < room_on(rest, slope, body.cogs), far


def balance_on(cogs, z, torque, body, orbit):
    """Leave in ``orbit`` where a knob that nothing rubs stands on the slope at ``z``: ``(whether it does, slack)``.

    ``slack``: what roundings, and what of its `LastTorque` is not known, make of a distance from there.
    """
    u, wrong, _ = torque
    hold = hold_stiffness(cogs, z[0], body)
    if not hold > 0.0 or not is_carried(body):
        return False, 0.0
    middle, own = middle_of(slope_at(z[0], cogs), cogs), own_stiffness(body)
    rest = middle + (u - body.push - own * (middle + body.shift)) / hold
    size = abs(middle) + (abs(u) + body.push + own * (abs(middle) + abs(body.shift))) / hold
    size += abs(rest - middle) * cancelled(own, hold, cogs)
    put_at(rest, u, body, orbit)
    # Under a torque that is off by so much the knob swings about another rest, and comes as far beyond that.
    return True, ROUNDINGS * EPSILON * (1.0 + abs(z[0]) + size) + 2.0 * wrong / hold


def settles_free(cogs, z, torque, shown, body, wall, orbit, away):
    """Fate without friction of a trial under its `LastTorque`: ``(fate, margin)``; its rest is left in ``orbit``."""
    if cogs is None or not len(cogs):
        return MOVING, 0.0
    stands, slack = balance_on(cogs, z, torque, body, orbit)
    if not stands:
        return MOVING, 0.0
    rest = orbit[0]
    seen = rest if has_curve(wall.curve) else shown
    gap = edge_gap(rest, seen, seen, wall)
    pushed = torque.left * reach_on(cogs, rest, body)
    stays, far = stays_on_slope(z, gap, slack + pushed, body, orbit, away)
    if stays:
        return (AT_REST if body.damped else RINGS), gap
    if abs(gap) <= slack and far < 1e-6 and body.play == 0.0:
        return REST_ON_EDGE, 0.0
    return MOVING, gap


def zone_on(cogs, x, u, wrong, body):
    """Positions from which to which friction holds the knob on the slope at ``x``, ``u`` known to within ``wrong``.

    ``(low, high)``; low above high where there are none.
    """
    hold = hold_stiffness(cogs, x, body)
    if not hold > 0.0 or not is_carried(body):
        return 1.0, 0.0
    if body.ratio > 0.0 and body.pad_damping + body.finger_damping == 0.0:
        return 1.0, 0.0  # a finger that nothing damps swings on beside a knob that is held
    middle, own = middle_of(slope_at(x, cogs), cogs), own_stiffness(body)
    pull = u - body.push - own * (middle + body.shift)
    size = abs(u) + body.push + body.friction + own * (abs(middle) + abs(body.shift)) + hold * abs(middle)
    size += (abs(pull) + body.friction) * cancelled(own, hold, cogs)
    held = body.friction - ROUNDINGS * EPSILON * size - wrong
    half = 0.5 * cogs[LENGTH]
    return middle + max((pull - held) / hold, -half), middle + min((pull + held) / hold, half)


def keeps_to_slope(cogs, z, torque, shown, body, wall, orbit, away):
    """Whether a knob with friction gets one reading for ever and settles: ``(whether, gap)``, as `keeps_reading`."""
    u, wrong, left = torque
    if cogs is None or not len(cogs):
        return False, 0.0
    low, high = zone_on(cogs, z[0], u, wrong, body)
    if low > high:
        return False, 0.0
    rest = min(max(z[0], low), high)
    put_at(rest, u, body, orbit)
    seen = rest if has_curve(wall.curve) else shown
    gap = edge_gap(rest, seen, seen, wall)
    slack = ROUNDINGS * EPSILON * (1.0 + abs(rest) + abs(z[0]))
    hold = hold_stiffness(cogs, rest, body)
    if not hold > 0.0:
        return False, gap  # at a corner
    stays, _ = stays_on_slope(z, gap, slack + left / hold**0.5, body, orbit, away)
    return stays, gap
