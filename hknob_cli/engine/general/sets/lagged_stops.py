"""States that stop under a torque that comes late: what the derivatives of their motions lie in, over a part of a hold.

Where each state that stops is held to the part's end, or each turns round and goes on, the derivative of its motion is
that of `friction_step`, with the times and the pulls between those under the least and the greatest torque of the part:
the velocity after a time only grows with the torque. Where that cannot be told, the derivative lies in intervals that
hold it for any number of stops (`take_in_any`): what is left of a difference in speed at each is between none and all.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.general.sets.friction_step import (
    Hold,
    take_in,
    take_in_hold,
    take_in_slide,
    take_in_turn,
    time_of_line,
)
from hknob_cli.engine.general.slide_two import coefficients
from hknob_cli.engine.turning import first_zero

STEADY = 0.05  # part of the friction level that the torque may change by where states stop
# Numbers of a part of a hold: its length, the plant's coefficients, the answers of x and v to a torque that is 1 at
# first and decays with the lag, and what is left of it.
SPAN, S, G, F, LATE_X, LATE_V, LEFT = range(7)
LAGS = 7


class LaggedHold(NamedTuple):
    """A part of a hold under a torque that comes late.

    ``a``: the torque that acts at first, as an acceleration of the knob; ``apart``: by which those of the set's states
    may differ from it; ``u``: the command, which it goes to; ``part``: numbers of this part, `LAGS`; ``halve``: whether
    half of it may be taken first.
    """

    a: float
    apart: float
    u: float
    part: Any
    halve: bool


class Stops(NamedTuple):
    """What the states do that begin by moving one way.

    ``slides``: whether one slides to the end, or may; ``passes``: whether one surely does; ``stops``: whether one may
    stop; ``crosses``: whether one begins by moving the other way; ``sure``: whether each that may stop does. ``first``,
    ``last``: when one may stop; ``between``: by how much the times differ under the middle of the torques. ``low_x``,
    ``high_x``: places; ``high_y``: the greatest rate; ``fastest``: speed.
    """

    slides: bool
    passes: bool
    stops: bool
    crosses: bool
    sure: bool
    first: float
    last: float
    between: float
    low_x: float
    high_x: float
    high_y: float
    fastest: float


def plain_of(part):
    """A part of a hold as `friction_step` has it."""
    return Hold(part[SPAN], part[S], part[G], part[F])


def end_of(hold):
    """The torque that acts as a part of a hold ends."""
    return hold.u + (hold.a - hold.u) * hold.part[LEFT]


def take_in_any(first, last, most, span, beta, jac):
    """Take in the derivatives of all motions that stop once, and then do anything until a part of a hold ends.

    ``first``, ``last``: coefficients over the time of the first stop, at least and at most; ``most``: of a
    difference in speed that the stop leaves. Speed is lost at stops alone, beside the spring: in a time t differences
    (1, 0) and (0, 1) come to x between 1 - beta t^2 and 1, and between -beta t^3 and t; and to v between -beta t and
    0, and between -beta t^2 and 1.
    """
    sa, ga, fa = first
    sb, gb, _ = last
    way, left = beta * span, most * beta * sb
    take_in(jac, 0, (1.0 - way * span) * (1.0 - beta * gb) - span * left, 1.0 - beta * ga + way * span * span * left)
    take_in(jac, 1, (1.0 - way * span) * sa - way * span * span * most * fa, sb + span * most * fa)
    take_in(jac, 2, -way - left, way * span * left)
    take_in(jac, 3, -way * sb - way * span * most * fa, most * fa)


def find_stops(sign, shape, slack, hold, body):
    """When the states stop, if they do, that begin by moving in direction ``sign``: `Stops`."""
    x, v, corners, count = shape
    a, u, to_a, part = hold.a, hold.u, end_of(hold), hold.part
    beta, friction, span, s, f = body.beta, body.friction, part[SPAN], part[S], part[F]
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
    if slides or late_stop:
        last = span
    return Stops(slides, passes, stops, crosses, sure, first, last, latest - sooner, low_x, high_x, high_y, fastest)


def part_at(sign, at, shape, hold, body, line):
    """Tell a line: of the states whose speed, in direction ``sign``, vanishes about a time."""
    beta, u, part = body.beta, hold.u, hold.part
    drive, late = sign * body.drive, part[LATE_V] * (sign * (hold.a - u))
    mid_x, mid_v = sign * shape.x, sign * shape.v
    sm, _, fm = coefficients(at, body)
    line[0], line[1] = -sign * beta * sm, sign * fm
    line[2] = -(fm * mid_v + sm * (sign * u + drive - body.friction - beta * mid_x) + late * at / part[SPAN])


def take_in_stops(sign, shape, slack, hold, body, room):
    """Take in the derivatives of the states that begin by moving in direction ``sign``.

    Returns ``(smooth, spread, later)``: as `friction_step.take_in_side`, and whether half of the time would tell what
    the states do. Where they differ by more than the torque does in it, a cut tells more.
    """
    beta, friction, jac, plain = body.beta, body.friction, room.space, plain_of(hold.part)
    span, to_a, drive = plain.span, end_of(hold), sign * body.drive
    low_a, high_a = min(sign * hold.a, sign * to_a), max(sign * hold.a, sign * to_a)
    told = find_stops(sign, shape, slack, hold, body)
    slides, crosses, first, last = told.slides, told.crosses, told.first, told.last
    if slides or not told.stops:
        take_in_slide(plain, beta, jac)
    if not told.stops:
        return True, 0.0, False
    soon, late = coefficients(first, body), coefficients(last, body)
    # Pulls where they stop, and on the way back.
    way = span * (told.fastest + span * max(0.0, told.high_y))
    least, most = low_a + drive - beta * (told.high_x + way), high_a + drive - beta * told.low_x
    turning = min(least, -friction)
    way += span * span * (-friction - turning)
    back = most + beta * way
    small_jump, jump, unsure = 2.0 * friction / (friction - turning), 1.0, False
    if told.sure and back < -friction:
        jump = 2.0 * friction / (friction - back)
        take_in_turn(plain, first, last, small_jump, jump, body, jac)
    elif told.sure and least >= -friction and most <= friction:
        take_in_hold(soon[0], soon[1], late[0], late[1], beta, jac)
    else:
        take_in_any(soon, late, 1.0 - small_jump, span, beta, jac)
        unsure = True
    # Halves of the time tell more of a set that stops in one of them. One that stops in both, or in part, is cut.
    later = (unsure or high_a - low_a > STEADY * friction) and told.between < 0.5 * span
    later = later and not (crosses or told.passes)
    times, jumps = (last - first) * jump, (jump - small_jump + (beta if most >= -friction > least else 0.0)) * span
    if slides or crosses or times >= jumps:
        at = time_of_line(crosses, slides, first, last, span)
        part_at(sign, at, shape, hold, body, room.line)
    else:
        room.line[0], room.line[1], room.line[2] = 1.0, 0.0, 0.0
    return not (slides or (crosses and least < -friction)), max(times, jumps), later
