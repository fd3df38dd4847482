"""A convex set of states over a hold under a torque that comes late: the same torque for all, and no longer constant.

The torque that acts, a, goes to its command u as a' = lag (u - a), whatever the knob does. All states of a set had the
same commands, and so a is one number of the set, as a command under way is. While all states slide one way, they move
by one affine map, whose constant alone has a; while all are held, not at all.

What else happens is looked at in a part of the hold that is halved until a changes by little in it: `lagged_stops`.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.advance import rub_many
from hknob_cli.engine.general.sets.convex import extent, radius_of, recentre, widen
from hknob_cli.engine.general.sets.friction_step import (
    CUT,
    ENCLOSED,
    GROWN,
    HELD,
    NARROW,
    NARROW_SMOOTH,
    ROUNDED,
    SLID,
    Shape,
    ask_for_cut,
    excess,
    map_corners,
    slide_corners,
)
from hknob_cli.engine.general.sets.lagged_stops import (
    LATE_V,
    LATE_X,
    LEFT,
    SPAN,
    F,
    G,
    S,
    end_of,
    take_in_any,
    take_in_stops,
)

LATER = 4  # beside the fates of `friction_step`: half the part of the hold is to be taken first
DEEPEST = 20  # halvings of a part of a hold
COARSE = 4.0  # counts: of a set with a larger radius it does not matter what each of its states does


def depth_at(part, depth):
    """Halvings of the part of a hold that may be taken next, ``part`` into the interval: as few as its place allows.

    One fewer than ``depth``, at least: where the last part was short, the next may be, too.
    """
    rest, least = part % 1.0, 0.0
    while rest != 0.0:
        rest, least = (2.0 * rest) % 1.0, least + 1.0
    return max(least, depth - 1.0)


def take_in_resting(shape, box, hold, body, room):
    """Take in the derivatives of states that all stand: some are held for a time, others leave; and tell a line."""
    line, none = room.line, (0.0, 0.0, 0.0)
    take_in_any(none, none, 1.0, hold.part[SPAN], body.beta, room.space)
    line[0], line[1], line[2] = 1.0, 0.0, 0.0
    for k in range(2):
        edge = (body.drive + hold.a + (body.friction if k == 0 else -body.friction)) / body.beta - shape.x
        if box[0] < edge and edge < box[1]:
            line[2] = edge


def take_in_lagged(shape, box, slack, hold, body, room):
    """Leave the derivatives of all states of a set in ``room.space``: ``(smooth, later)``, as `take_in_stops`.

    ``box`` and the line: as `friction_step.take_in_all` has them.
    """
    jac, line = room.space, room.line
    for entry in range(4):
        jac[2 * entry], jac[2 * entry + 1] = float("inf"), -float("inf")
    smooth, spread, later = True, 0.0, False
    rises, falls = shape.v + box[3] > 0.0, shape.v + box[2] < 0.0
    if rises:
        smooth, spread, later = take_in_stops(1.0, shape, slack, hold, body, room)
    if falls:
        p, q, r = line[0], line[1], line[2]
        also, other, more = take_in_stops(-1.0, shape, slack, hold, body, room)
        if also and (not smooth or other < spread):
            line[0], line[1], line[2] = p, q, r
        smooth, later = smooth and also, later or more
    if not rises and not falls:
        take_in_resting(shape, box, hold, body, room)
        smooth, later = False, True
    return smooth, later


def added_by(hold, whole):
    """Speed that torques which differ from that of the centre may add by the end."""
    return hold.apart * (1.0 - hold.part[LEFT]) / whole.lag


def enclose_lagged(shape, slack, hold, least, body, whole, room):
    """Move a set some of which may stop within the part: as `move_lagged`, which tells what else may be."""
    x, v, corners, count = shape
    beta, z, span = body.beta, room.z, hold.part[SPAN]
    cx, cv = recentre(corners, count)
    middle = Shape(x + cx, v + cv, corners, count)
    box = extent(corners, count)
    radius = radius_of(corners, count, beta)
    smooth, later = take_in_lagged(middle, box, slack, hold, body, room)
    more_x, more_v, wider, grown = excess(room.space, box[1], box[3], corners, count, beta)
    narrow = wider <= (NARROW_SMOOTH if smooth else NARROW) * radius
    narrow = narrow or (grown <= GROWN * radius and (smooth or radius > COARSE))
    sooner = hold.halve and later
    if not narrow and (sooner or radius > least):
        ask_for_cut(corners, count, cx, cv, room.line)
        return (LATER if sooner else CUT), x, v, hold.a, count
    stuck = map_corners(corners, count, room.space)
    z[0], z[1], z[2] = middle.x, middle.v, hold.a
    rub_many(z, hold.u, span, whole, room.pad)
    if hold.apart > 0.0:
        added = added_by(hold, whole)
        more_x, more_v, stuck = more_x + span * added, more_v + added, False
    if more_x > 0.0 or more_v > 0.0:
        count = widen(corners, count, more_x, more_v, room.space)
    return (HELD if stuck and z[1] == 0.0 else ENCLOSED), z[0], z[1], end_of(hold), count


def slide_lagged(shape, up, hold, body, whole, room):
    """Move a set all of which slides one way, up or not: as `move_lagged`."""
    x, v, corners, count = shape
    part, u, friction, late = hold.part, hold.u, body.friction, hold.a - hold.u
    s, g, f = part[S], part[G], part[F]
    y = u + body.drive - body.beta * x - (friction if up else -friction)
    slide_corners(corners, count, s, g, f, body.beta)
    if hold.apart > 0.0:
        added = added_by(hold, whole)
        count = widen(corners, count, part[SPAN] * added, added, room.space)
    to_x, to_v = x + (s * v + g * y + part[LATE_X] * late), f * v + s * y + part[LATE_V] * late
    return SLID, to_x, to_v, end_of(hold), count


def slides_all_along(sign, at, low_a, end, rises, part, slack, body):
    """Whether a state slides in direction ``sign`` to the end of a part of a hold, to within rounding.

    ``at``: its position and velocity, told in that direction.
    """
    px, pv = at
    if pv < -slack:
        return False
    if not rises:
        return end >= -slack
    low = low_a + sign * body.drive - body.friction - body.beta * px
    return part[F] * pv + part[S] * low >= -slack


def lagged_motion_of_all(shape, slack, hold, body):
    """What all states of a set do, if it is the same: ``(up, down, held)``, sliding to the end one way, or held."""
    x, v, corners, count = shape
    a, apart, u, part, _ = hold
    beta, friction, to_a = body.beta, body.friction, end_of(hold)
    s, f, late = part[S], part[F], part[LATE_V] * (a - u)
    low_a, high_a = min(a, to_a), max(a, to_a)
    up, down, held = True, True, True
    for k in range(count):
        px, pv = x + corners[2 * k], v + corners[2 * k + 1]
        free = f * pv + s * (u + body.drive - beta * px) + late
        up = up and slides_all_along(1.0, (px, pv), low_a, free - s * friction, to_a > a, part, slack, body)
        down = down and slides_all_along(-1.0, (-px, -pv), -high_a, -free - s * friction, to_a < a, part, slack, body)
        pull = body.drive - beta * px
        held = held and pv == 0.0 and pull + high_a + apart <= friction and pull + low_a - apart >= -friction
    return up, down, held


def move_lagged(shape, hold, least, body, whole, room):
    """Move a set over a part of a hold, in which the torque goes to its command.

    ``hold``: `lagged_stops.LaggedHold`; ``least``: radius below which nothing is cut; ``body``: without lag, of second
    order and held by a spring; ``whole``: the same with its lag.

    Returns ``(fate, x, v, a, count)``, as `friction_step.move_set`. If the fate is `LATER`, nothing has moved. The
    distance of two motions grows by no more than their torques differ, whatever friction does: where those of a set
    differ it is widened by that.
    """
    x, v, friction = shape.x, shape.v, body.friction
    size = max(abs(hold.a), abs(hold.u))
    slack = ROUNDED / 8.0 * EPSILON * (abs(v) + size + abs(body.drive) + friction + body.beta * abs(x))
    up, down, held = lagged_motion_of_all(shape, slack, hold, body)
    if held and friction > 0.0:
        return HELD, x, v, end_of(hold), shape.number
    if up or down or friction == 0.0:
        return slide_lagged(shape, up, hold, body, whole, room)
    return enclose_lagged(shape, slack, hold, least, body, whole, room)
