"""A convex set of states over a hold under a torque that comes late: the same torque for all, and no longer constant.

The torque that acts, a, goes to its command u as a' = lag (u - a), whatever the knob does. All states of a set had the
same commands, and so a is one number of the set, as a command under way is. While all states slide one way, they move
by one affine map, whose constant alone has a; while all are held, not at all.

What else happens is looked at in a part of the hold that is halved until a changes by little in it. Where each state
that stops is held to the part's end, or each turns round and goes on, the derivative of its motion is that of
`friction_step`, with the times and the pulls between those under the least and the greatest a of the part: the
velocity after a time only grows with the torque. Where that cannot be told, the derivative lies in intervals that hold
it for any number of stops (`take_in_any`): what is left of a difference in speed at each is between none and all.
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
    ask_for_cut,
    excess,
    map_corners,
    slide_corners,
    take_in,
    take_in_hold,
    take_in_slide,
    take_in_turn,
)
from hknob_cli.engine.general.slide_two import coefficients
from hknob_cli.engine.turning import first_zero

LATER = 4  # beside the fates of `friction_step`: half the part of the hold is to be taken first
DEEPEST = 20  # halvings of a part of a hold
COARSE = 4.0  # counts: of a set with a larger radius it does not matter what each of its states does
STEADY = 0.05  # part of the friction level that the torque may change by where states stop
# Numbers of a part of a hold: its length, the plant's coefficients, the answers of x and v to a torque that is 1 at
# first and decays with the lag, and what is left of it.
SPAN, S, G, F, LATE_X, LATE_V, LEFT = range(7)
LAGS = 7


def depth_at(part, depth):
    """Halvings of the part of a hold that may be taken next, ``part`` into the interval: as few as its place allows.

    One fewer than ``depth``, at least: where the last part was short, the next may be, too.
    """
    rest, least = part % 1.0, 0.0
    while rest != 0.0:
        rest, least = (2.0 * rest) % 1.0, least + 1.0
    return max(least, depth - 1.0)


def take_in_any(beta, span, sa, sb, ga, gb, fa, most, jac):
    """Take in the derivatives of all motions that stop once, and then do anything until a part of a hold ends.

    ``(sa, ga, fa)``, ``(sb, gb)``: coefficients over the time of the first stop, at least and at most; ``most``: of a
    difference in speed that the stop leaves. Speed is lost at stops alone, beside the spring: in a time t differences
    (1, 0) and (0, 1) come to x between 1 - beta t^2 and 1, and between -beta t^3 and t; and to v between -beta t and
    0, and between -beta t^2 and 1.
    """
    way, left = beta * span, most * beta * sb
    take_in(jac, 0, (1.0 - way * span) * (1.0 - beta * gb) - span * left, 1.0 - beta * ga + way * span * span * left)
    take_in(jac, 1, (1.0 - way * span) * sa - way * span * span * most * fa, sb + span * most * fa)
    take_in(jac, 2, -way - left, way * span * left)
    take_in(jac, 3, -way * sb - way * span * most * fa, most * fa)


def take_in_stops(sign, x, v, a, to_a, u, part, slack, corners, count, body, jac, line):
    """Take the derivatives of the states that begin by moving in direction ``sign`` into ``jac``.

    Returns ``(smooth, spread, later)``: as `friction_step.take_in_side`, and whether half of the time would tell what
    the states do. Where they differ by more than the torque does in it, a cut tells more.
    """
    beta, friction, span = body.beta, body.friction, part[SPAN]
    s, g, f = part[S], part[G], part[F]
    mid_x, mid_v = sign * x, sign * v
    low_a, high_a = min(sign * a, sign * to_a), max(sign * a, sign * to_a)
    rises = sign * to_a > sign * a
    drive, late = sign * body.drive, part[LATE_V] * (sign * (a - u))
    slides, late_stop, stops, crosses = False, False, False, False
    passes, sure = False, True
    first, last, sooner, latest = span, 0.0, span, 0.0
    low_x, high_x, high_y, fastest = float("inf"), -float("inf"), -float("inf"), 0.0
    for k in range(count):
        px, pv = sign * (x + corners[2 * k]), sign * (v + corners[2 * k + 1])
        low, high = low_a + drive - friction - beta * px, high_a + drive - friction - beta * px
        low_x, high_x, high_y = min(low_x, px), max(high_x, px), max(high_y, high)
        if pv < -slack:
            crosses = True
            continue
        pv = max(pv, 0.0)
        fastest = max(fastest, pv)
        end = f * pv + s * (sign * u + drive - friction - beta * px) + late
        if (not rises and end >= -slack) or f * pv + s * low >= -slack:
            slides, passes, late_stop = slides or end > slack, passes or end > slack, late_stop or pv > slack
            continue
        stops = True
        if rises and f * pv + s * high >= -slack:
            slides, sure = True, False  # it may stop, or not, or stop and go on
        first = min(first, first_zero(pv, low, body.alpha, beta) if pv > 0.0 else 0.0)
        if pv > 0.0:
            last = max(last, min(first_zero(pv, high, body.alpha, beta), span))
        elif high >= 0.0:
            last = span
        about = min(first_zero(pv, 0.5 * (low + high), body.alpha, beta), span) if pv > 0.0 else 0.0
        sooner, latest = min(sooner, about), max(latest, about)
    if crosses:
        first, stops = 0.0, True
        slides = slides or high_y >= 0.0
    if slides or not stops:
        take_in_slide(s, g, f, beta, jac)
    if not stops:
        return True, 0.0, False
    if slides or late_stop:
        last = span
    sa, ga, fa = coefficients(first, body)
    sb, gb, _ = coefficients(last, body)
    # Pulls where they stop, and on the way back.
    way = span * (fastest + span * max(0.0, high_y))
    least, most = low_a + drive - beta * (high_x + way), high_a + drive - beta * low_x
    turning = min(least, -friction)
    way += span * span * (-friction - turning)
    back = most + beta * way
    small_jump, jump, unsure = 2.0 * friction / (friction - turning), 1.0, False
    if sure and back < -friction:
        jump = 2.0 * friction / (friction - back)
        take_in_turn(s, g, f, first, last, span, small_jump, jump, body, jac)
    elif sure and least >= -friction and most <= friction:
        take_in_hold(sa, ga, sb, gb, beta, jac)
    else:
        take_in_any(beta, span, sa, sb, ga, gb, fa, 1.0 - small_jump, jac)
        unsure = True
    # Halves of the time tell more of a set that stops in one of them. One that stops in both, or in part, is cut.
    later = (unsure or high_a - low_a > STEADY * friction) and latest - sooner < 0.5 * span and not (crosses or passes)
    times, jumps = (last - first) * jump, (jump - small_jump + (beta if most >= -friction > least else 0.0)) * span
    at = span
    if crosses:
        at = 0.0
    elif not slides:
        at = 0.5 * (first + last)
    if slides or crosses or times >= jumps:
        sm, _, fm = coefficients(at, body)
        line[0], line[1] = -sign * beta * sm, sign * fm
        line[2] = -(fm * mid_v + sm * (sign * u + drive - friction - beta * mid_x) + late * at / span)
    else:
        line[0], line[1], line[2] = 1.0, 0.0, 0.0
    return not (slides or (crosses and least < -friction)), max(times, jumps), later


def slides_all_along(sign, pv, px, low_a, end, rises, part, slack, body):
    """Whether a state slides in direction ``sign`` to the end of a part of a hold, to within rounding."""
    if pv < -slack:
        return False
    if not rises:
        return end >= -slack
    low = low_a + sign * body.drive - body.friction - body.beta * px
    return part[F] * pv + part[S] * low >= -slack


def move_lagged(x, v, a, apart, u, part, halve, corners, count, least, body, whole, space, line, z, pad):
    """Move a set over a part of a hold under the command ``u``, which the torque ``a`` goes to.

    Args:
        x: Position of its centre, counts.
        v: Velocity of its centre, counts per sample.
        a: Torque that acts, as an acceleration of the knob.
        apart: By which the torques of its states may differ from that.
        u: Command.
        part: Numbers of this part, `LAGS`.
        halve: Whether half of it may be taken first.
        corners: Relative to the centre; changed in place, room as `friction_step.move_set` wants it.
        count: Of corners.
        least: Radius below which nothing is cut.
        body: The body without lag, of second order and held by a spring.
        whole: The body with its lag.
        space: Work space, as much as ``corners`` and eight numbers more.
        line: Three numbers: where a cut is asked for, that at ``line[0] dx + line[1] dv = line[2]``.
        z: Work space of a state.
        pad: Work space of its motion.

    Returns ``(fate, x, v, a, count)``, as `friction_step.move_set`. If the fate is `LATER`, nothing has moved. The
    distance of two motions grows by no more than their torques differ, whatever friction does: where those of a set
    differ it is widened by that.
    """
    beta, friction = body.beta, body.friction
    s, g, f = part[S], part[G], part[F]
    to_a = u + (a - u) * part[LEFT]
    low_a, high_a = min(a, to_a), max(a, to_a)
    size = max(abs(a), abs(u))
    slack = ROUNDED / 8.0 * EPSILON * (abs(v) + size + abs(body.drive) + friction + beta * abs(x))
    late = part[LATE_V] * (a - u)
    up, down, held = True, True, True
    for k in range(count):
        px, pv = x + corners[2 * k], v + corners[2 * k + 1]
        free = f * pv + s * (u + body.drive - beta * px) + late
        up = up and slides_all_along(1.0, pv, px, low_a, free - s * friction, to_a > a, part, slack, body)
        down = down and slides_all_along(-1.0, -pv, -px, -high_a, -free - s * friction, to_a < a, part, slack, body)
        pull = body.drive - beta * px
        held = held and pv == 0.0 and pull + high_a + apart <= friction and pull + low_a - apart >= -friction
    if held and friction > 0.0:
        return HELD, x, v, to_a, count
    if up or down or friction == 0.0:
        y = u + body.drive - beta * x - (friction if up else -friction)
        slide_corners(corners, count, s, g, f, beta)
        if apart > 0.0:
            added = apart * (1.0 - part[LEFT]) / whole.lag
            count = widen(corners, count, part[SPAN] * added, added, space)
        return SLID, x + (s * v + g * y + part[LATE_X] * (a - u)), f * v + s * y + late, to_a, count
    cx, cv = recentre(corners, count)
    mid_x, mid_v = x + cx, v + cv
    low_x, high_x, low_v, high_v = extent(corners, count)
    radius = radius_of(corners, count, beta)
    for entry in range(4):
        space[2 * entry], space[2 * entry + 1] = float("inf"), -float("inf")
    smooth, spread, later = True, 0.0, False
    rises, falls = mid_v + high_v > 0.0, mid_v + low_v < 0.0
    if rises:
        smooth, spread, later = take_in_stops(
            1.0, mid_x, mid_v, a, to_a, u, part, slack, corners, count, body, space, line
        )
    if falls:
        p, q, r = line[0], line[1], line[2]
        also, other, more = take_in_stops(
            -1.0, mid_x, mid_v, a, to_a, u, part, slack, corners, count, body, space, line
        )
        if also and (not smooth or other < spread):
            line[0], line[1], line[2] = p, q, r
        smooth, later = smooth and also, later or more
    if not rises and not falls:
        # All stand: some are held for a time, others leave.
        take_in_any(beta, part[SPAN], 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, space)
        line[0], line[1], line[2] = 1.0, 0.0, 0.0
        for k in range(2):
            edge = (body.drive + a + (friction if k == 0 else -friction)) / beta - mid_x
            if low_x < edge and edge < high_x:
                line[2] = edge
        smooth, later = False, True
    more_x, more_v, wider, grown = excess(space, high_x, high_v, corners, count, beta)
    narrow = wider <= (NARROW_SMOOTH if smooth else NARROW) * radius
    narrow = narrow or (grown <= GROWN * radius and (smooth or radius > COARSE))
    sooner = halve and later
    if not narrow and (sooner or radius > least):
        ask_for_cut(corners, count, cx, cv, line)
        return (LATER if sooner else CUT), x, v, a, count
    stuck = map_corners(corners, count, space)
    z[0], z[1], z[2] = mid_x, mid_v, a
    rub_many(z, u, part[SPAN], whole, pad)
    if apart > 0.0:
        added = apart * (1.0 - part[LEFT]) / whole.lag
        more_x, more_v, stuck = more_x + part[SPAN] * added, more_v + added, False
    if more_x > 0.0 or more_v > 0.0:
        count = widen(corners, count, more_x, more_v, space)
    return (HELD if stuck and z[1] == 0.0 else ENCLOSED), z[0], z[1], to_a, count
