"""A convex set of states over one hold of the torque, with Coulomb friction: exact where all slide, else enclosed.

While all states slide one way, they move by one affine map; while all are held, not at all. A state that stops within
the hold, after a time t, is held there or reverses. Either way the derivative of its motion is known (saltation, in
`general.advance`): with tau what is left of the hold, and Phi the free response,

    reverses   Phi(T) - m Phi(tau) e2 e2' Phi(t),  m = 2 friction / (pull + friction)  by how much the rate jumps
    sticks     e1 e1' Phi(t)

The motion is continuous. So all states of the set lie within that of its centre plus the derivatives, as intervals over
the set, times what they differ by (mean value theorem). Over a hold in which a velocity response keeps its sign, t is
largest and least at corners, and the responses are monotone in t: the intervals are tight. Where they are not narrow
enough, the caller is told a line to cut the set by.
"""

from math import sqrt
from typing import Any, NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets.convex import extent, radius_of, recentre, widen
from hknob_cli.engine.general.slide_two import coefficients, step_with_friction
from hknob_cli.engine.turning import first_zero

SLID, HELD, ENCLOSED, CUT = range(4)  # what a hold does with a set
NARROW = 0.03  # part of a set's radius that an enclosure may be wider than its states, where a line can part them
NARROW_SMOOTH = 0.1  # the same, where the motion is smooth and a cut only halves
MOST_CUTS = 8  # of a set in one part of a hold; then the enclosure is taken as it is
GROWN = 1.02  # times its radius that the enclosure of a set that stops may measure, where it is wider
ROUNDED = 256.0
TURN = 0.25  # radians that the spring turns the motion by in a part of a hold
MOST_PARTS = 256


class Hold(NamedTuple):
    """A hold of the torque, or a part of one: its length, and the plant's coefficients over it."""

    span: float
    s: float
    g: float
    f: float


class Shape(NamedTuple):
    """A convex set of states: position and velocity of its centre, corners relative to it, and how many these are.

    Corners change in place; there is room for four times as many and two.
    """

    x: float
    v: float
    corners: Any
    number: int


class Room(NamedTuple):
    """Work space of a motion: ``space``, as much as corners have and eight numbers more; and a ``line``.

    Where a cut is asked for, it is at ``line[0] dx + line[1] dv = line[2]``. ``z``: a state whose torque lags; ``pad``:
    for its motion.
    """

    space: Any
    line: Any
    z: Any
    pad: Any


def parts_of_hold(span, body):
    """How many equal parts a hold is taken in; 0: too many.

    In each the velocity response keeps its sign, and the spring turns the motion by little: what stops is a thin part
    of a set then, and enclosures are narrow.
    """
    n = 1
    while n <= MOST_PARTS:
        t = span / n
        if t * sqrt(body.beta) <= TURN and coefficients(t, body)[2] >= 0.0:
            return n
        n *= 2
    return 0


def take_in(jac, entry, low, high):
    """Widen the interval of an entry of the derivative by another."""
    jac[2 * entry] = min(jac[2 * entry], low)
    jac[2 * entry + 1] = max(jac[2 * entry + 1], high)


def take_in_slide(hold, beta, jac):
    """Take in the derivative of states that slide one way all along."""
    _, s, g, f = hold
    take_in(jac, 0, 1.0 - beta * g, 1.0 - beta * g)
    take_in(jac, 1, s, s)
    take_in(jac, 2, -beta * s, -beta * s)
    take_in(jac, 3, f, f)


def take_in_turn(hold, first, last, small_jump, jump, body, jac):
    """Take in the derivatives of states that turn round, from ``first`` to ``last``, by jumps of the rate."""
    span, s, g, f = hold
    beta = body.beta
    sa, _, fa = coefficients(first, body)
    sb, _, fb = coefficients(last, body)
    sc, _, fc = coefficients(span - first, body)
    sd, _, fd = coefficients(span - last, body)
    take_in(jac, 0, 1.0 - beta * (g - small_jump * sd * sa), 1.0 - beta * (g - jump * sc * sb))
    take_in(jac, 1, s - jump * sc * fa, s - small_jump * sd * fb)
    take_in(jac, 2, -beta * (s - small_jump * fc * sa), -beta * (s - jump * fd * sb))
    take_in(jac, 3, f - jump * fd * fa, f - small_jump * fc * fb)


def take_in_hold(sa, ga, sb, gb, beta, jac):
    """Take in the derivatives of states that stop and are held; coefficients of the first and the last stop."""
    take_in(jac, 0, 1.0 - beta * gb, 1.0 - beta * ga)
    take_in(jac, 1, sa, sb)
    take_in(jac, 2, 0.0, 0.0)
    take_in(jac, 3, 0.0, 0.0)


def slide_corners(corners, count, s, g, f, beta):
    """Move corners, relative to the centre, by the free response."""
    for k in range(count):
        dx, dv = corners[2 * k], corners[2 * k + 1]
        corners[2 * k] = dx + (s * dv - beta * g * dx)
        corners[2 * k + 1] = f * dv - beta * s * dx


def middle_of(jac):
    """Middles of the intervals of a derivative, row by row."""
    return 0.5 * (jac[0] + jac[1]), 0.5 * (jac[2] + jac[3]), 0.5 * (jac[4] + jac[5]), 0.5 * (jac[6] + jac[7])


def excess(jac, high_x, high_v, corners, count, beta):
    """What an enclosure is made of: ``(more_x, more_v, wider, grown)``.

    By how much the intervals of the derivative widen a set of this extent, in x and v and as a radius; and the largest
    radius after it.
    """
    more_x = 0.5 * ((jac[1] - jac[0]) * high_x + (jac[3] - jac[2]) * high_v)
    more_v = 0.5 * ((jac[5] - jac[4]) * high_x + (jac[7] - jac[6]) * high_v)
    ax, ay, bx, by = middle_of(jac)
    grown = 0.0
    for k in range(count):
        dx, dv = corners[2 * k], corners[2 * k + 1]
        at_x, at_v = abs(ax * dx + ay * dv) + more_x, abs(bx * dx + by * dv) + more_v
        grown = max(grown, at_x * at_x + at_v * at_v / beta)
    return more_x, more_v, sqrt(more_x * more_x + more_v * more_v / beta), sqrt(grown)


def ask_for_cut(corners, count, cx, cv, line):
    """Tell corners and line from the caller's centre again: the line was told from the middle of the polygon."""
    line[2] += line[0] * cx + line[1] * cv
    for k in range(count):
        corners[2 * k] += cx
        corners[2 * k + 1] += cv


def map_corners(corners, count, jac):
    """Move corners by the middle of the derivative; whether it is that of states which are all held."""
    ax, ay, bx, by = middle_of(jac)
    for k in range(count):
        dx, dv = corners[2 * k], corners[2 * k + 1]
        corners[2 * k], corners[2 * k + 1] = ax * dx + ay * dv, bx * dx + by * dv
    return jac[4] == 0.0 and jac[5] == 0.0 and jac[6] == 0.0 and jac[7] == 0.0


def time_of_line(crosses, slides, first, last, span):
    """When the states stop that a set is cut by: those that stand, those that stop at the end, or halfway."""
    return 0.0 if crosses else (span if slides else 0.5 * (first + last))


def take_in_side(sign, shape, free, slack, hold, body, room):
    """Take in the derivatives of the states that begin by moving in direction ``sign``: ``(smooth, spread)``.

    ``smooth``: whether no state slides to the end while another stops. ``spread``: how far the times of the stop lie
    apart, or what is left of the hold with the jumps of rates, whichever is more. ``room.space`` has the intervals,
    ``room.line`` a, b and c of a line that halves the spread.
    """
    beta, friction, jac, line = body.beta, body.friction, room.space, room.line
    x, v, corners, count = shape
    span, s, _, f = hold
    pull_free = sign * free - friction
    slides, late, stops, crosses = False, False, False, False
    first, last = span, 0.0
    low_x, high_x, high_y, fastest = float("inf"), -float("inf"), -float("inf"), 0.0
    for k in range(count):
        px, pv = sign * (x + corners[2 * k]), sign * (v + corners[2 * k + 1])
        y = pull_free - beta * px
        low_x, high_x, high_y = min(low_x, px), max(high_x, px), max(high_y, y)
        if pv < -slack:
            crosses = True
            continue
        pv = max(pv, 0.0)
        fastest = max(fastest, pv)
        end = f * pv + s * y
        if end >= -slack:
            # One at rest that is neither held nor leaves, to within rounding, is where lines of all times meet.
            slides, late = slides or end > slack, late or pv > slack
            continue
        stops = True
        t = 0.0
        if pv > 0.0:
            t = min(first_zero(pv, y, body.alpha, beta), span)
        first, last = min(first, t), max(last, t)
    if crosses:
        # States at v = 0 belong to this side, too.
        first, stops = 0.0, True
        slides = slides or high_y >= 0.0
    if slides or not stops:
        take_in_slide(hold, beta, jac)
    if not stops:
        return True, 0.0
    if slides or late:
        last = span
    sa, ga, _ = coefficients(first, body)
    sb, gb, _ = coefficients(last, body)
    sign_free = sign * free
    least, most = sign_free - beta * (high_x + sb * fastest), sign_free - beta * low_x  # pull where they stop
    small_jump, jump = 1.0, 1.0
    if least < -friction:
        small_jump = 2.0 * friction / (friction - least)
        if most < -friction:
            jump = 2.0 * friction / (friction - most)
        take_in_turn(hold, first, last, small_jump, jump, body, jac)
    if most >= -friction:
        take_in_hold(sa, ga, sb, gb, beta, jac)
    # Lines: v = 0, the states that stop as the hold ends, those that stop halfway, or half the width.
    times, jumps = (last - first) * jump, (jump - small_jump + (beta if most >= -friction > least else 0.0)) * span
    if slides or crosses or times >= jumps:
        at = time_of_line(crosses, slides, first, last, span)
        sm, _, fm = coefficients(at, body)
        line[0], line[1] = -sign * beta * sm, sign * fm
        line[2] = -(fm * sign * v + sm * (pull_free - beta * sign * x))
    else:
        line[0], line[1], line[2] = 1.0, 0.0, 0.0
    return not (slides or (crosses and least < -friction)), max(times, jumps)


def take_in_standing(shape, low_x, free, hold, body, room):
    """Take in the derivatives of states that all stand: some are held, others leave, and a line parts them."""
    jac, line, beta, friction = room.space, room.line, body.beta, body.friction
    _, s, g, f = hold
    take_in(jac, 0, 1.0 - beta * g, 1.0)
    take_in(jac, 1, s, s)
    take_in(jac, 2, -beta * s, 0.0)
    take_in(jac, 3, f, f)
    edge = free - friction if free - beta * (shape.x + low_x) > friction else free + friction
    line[0], line[1], line[2] = 1.0, 0.0, edge / beta - shape.x


def take_in_all(shape, box, free, slack, hold, body, room):
    """Leave the derivatives of all states of a set in ``room.space``; whether its motion is smooth.

    ``box``: the rectangle around it, `convex.extent`. The line is that of the side that is not smooth or spreads more.
    """
    jac, line = room.space, room.line
    low_x, _, low_v, high_v = box
    for entry in range(4):
        jac[2 * entry], jac[2 * entry + 1] = float("inf"), -float("inf")
    smooth, spread = True, 0.0
    rises, falls = shape.v + high_v > 0.0, shape.v + low_v < 0.0
    if rises:
        smooth, spread = take_in_side(1.0, shape, free, slack, hold, body, room)
    if falls:
        a, b, c = line[0], line[1], line[2]
        also, other = take_in_side(-1.0, shape, free, slack, hold, body, room)
        if also and (not smooth or other < spread):
            line[0], line[1], line[2] = a, b, c
        smooth = smooth and also
    if not rises and not falls:
        take_in_standing(shape, low_x, free, hold, body, room)
        smooth = False
    return smooth


def enclose_set(shape, u, slack, hold, least, body, room):
    """Move a set some of which may stop within the hold: as `move_set`, which tells what else may be."""
    x, v, corners, count = shape
    beta = body.beta
    cx, cv = recentre(corners, count)
    middle = Shape(x + cx, v + cv, corners, count)
    box = extent(corners, count)
    radius = radius_of(corners, count, beta)
    smooth = take_in_all(middle, box, u + body.drive, slack, hold, body, room)
    more_x, more_v, wider, grown = excess(room.space, box[1], box[3], corners, count, beta)
    narrow = NARROW_SMOOTH if smooth else NARROW
    if not (wider <= narrow * radius or radius <= least or (smooth and grown <= GROWN * radius)):
        ask_for_cut(corners, count, cx, cv, room.line)
        return CUT, x, v, count
    stuck = map_corners(corners, count, room.space)
    to_x, to_v = step_with_friction(middle.x, middle.v, u, hold.span, hold.s, hold.g, hold.f, body)
    if more_x > 0.0 or more_v > 0.0:
        count = widen(corners, count, more_x, more_v, room.space)
    return (HELD if stuck and to_v == 0.0 else ENCLOSED), to_x, to_v, count


def motion_of_all(shape, free, slack, hold, body):
    """What all states of a set do, if it is the same: ``(up, down, held)``, sliding to the end one way, or held."""
    x, v, corners, count = shape
    beta, friction, s, f = body.beta, body.friction, hold.s, hold.f
    up, down, held = True, True, True
    for k in range(count):
        pv = v + corners[2 * k + 1]
        pull = free - beta * (x + corners[2 * k])
        up = up and pv >= -slack and f * pv + s * (pull - friction) >= -slack
        down = down and pv <= slack and f * pv + s * (pull + friction) <= slack
        held = held and pv == 0.0 and abs(pull) <= friction
    return up, down, held


def move_set(shape, u, hold, least, body, room):
    """Move a set over a hold, whose velocity response is not negative, under the command ``u``.

    ``least``: radius below which nothing is cut; ``body``: of second order with friction, and held by a spring.
    Returns ``(fate, x, v, count)``. If the fate is `CUT`, nothing has moved; if it is `HELD`, all velocities are 0,
    with no error.
    """
    x, v, corners, count = shape
    beta, friction = body.beta, body.friction
    free = u + body.drive
    slack = ROUNDED / 8.0 * EPSILON * (abs(v) + abs(free) + friction + beta * abs(x))
    up, down, held = motion_of_all(shape, free, slack, hold, body)
    if held:
        return HELD, x, v, count
    if up or down or friction == 0.0:
        _, s, g, f = hold
        y = free - (friction if up else -friction) - beta * x
        slide_corners(corners, count, s, g, f, beta)
        return SLID, x + (s * v + g * y), f * v + s * y, count
    return enclose_set(shape, u, slack, hold, least, body, room)
