"""The motion without a sample clock: the wall in pieces, and from event to event: edges, turning points, stick, rest.

With an encoder the torque is a staircase: piece 0 is all that lies outside the wall, piece n = 1, 2, ... the n-th count
inside it, between the edges 1 - n and -n. With a continuous sensor there are two pieces, and piece 1 has the stiffness
of the wall. Angle ``x`` is measured from the wall's edge, in counts where there are any; time in a unit of the scene's.

The torque never falls with depth, so that the potential energy is convex: rest points form one interval, which is known
before anything moves (`rest_range`).

A motion inside one piece reaches its edge, or turns, or neither. Within a piece and one direction of motion x'' = y -
alpha x' - beta (x - x0), where ``y`` is the acceleration at the start ``x0``, friction included, the damping not.
``way`` is +1 upwards, -1 downwards; ``gap`` the signed distance to the edge ahead.

A state is ``(n, edge, u, v)``: the piece, a position ``edge + u`` told from a nearby edge so that the smallest
excursion keeps its digits, and the velocity. On an edge ``u`` is exactly 0. With it goes ``way``, the direction of
motion: +1, -1, or 0 at rest, for friction acts against it even where the velocity is momentarily zero.
"""

from math import atan, pi, sqrt
from typing import NamedTuple

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing


class Unsampled(NamedTuple):
    """Plant, wall and encoder, dimensionless; every field is a float. J x'' + ... is divided by J."""

    alpha: float  # damping
    beta: float  # hand stiffness
    kappa: float  # wall stiffness; 0: there is no wall
    gamma: float  # constant push into the wall
    phi: float  # Coulomb friction
    offset: float  # the angle that an encoder level reports, less the level, in counts: 0 <= offset < 1
    counted: float  # 1 with an encoder, 0 with a continuous sensor


def piece_drive(n, loop):
    """Acceleration in piece ``n`` by bias and encoder wall: what does not depend on the angle, without friction."""
    if n > 0.0 and loop.counted > 0.0:
        return loop.kappa * (n - loop.offset) - loop.gamma
    return -loop.gamma


def piece_stiffness(n, loop):
    """Stiffness in piece ``n``: of the hand, and of the wall where the sensor is continuous."""
    if n > 0.0 and loop.counted == 0.0:
        return loop.beta + loop.kappa
    return loop.beta


def upper_end(n):
    """Upper end of piece ``n``; infinite outside the wall."""
    return 1.0 - n if n > 0.0 else float("inf")


def lower_end(n, loop):
    """Lower end of piece ``n``; infinite where nothing changes further in."""
    if loop.kappa == 0.0 or (n > 0.0 and loop.counted == 0.0):
        return -float("inf")
    return 0.0 - n


def wall_potential(x, loop):
    """Energy stored in the wall at ``x``: the area under its torque, which is exact at count edges."""
    depth = -x
    if depth <= 0.0:
        return 0.0
    if loop.counted == 0.0:
        return 0.5 * loop.kappa * depth * depth
    whole = depth // 1.0
    return loop.kappa * (whole * (0.5 * (whole + 1.0) - loop.offset) + (whole + 1.0 - loop.offset) * (depth - whole))


def potential(x, loop):
    """Potential energy at ``x`` of bias, hand and wall; 0 at the wall's edge."""
    return (loop.gamma + 0.5 * loop.beta * x) * x + wall_potential(x, loop)


def highest_rest(loop):
    """Highest position at which the knob can rest: pushed up by no less than minus the friction, below it at least."""
    inf = float("inf")
    n = 0.0
    if loop.phi < loop.gamma and loop.kappa > 0.0:
        n = 1.0
        if loop.counted > 0.0:
            deep = (loop.gamma - loop.phi + loop.kappa * loop.offset) / (loop.kappa + loop.beta)
            n = max(-(-deep // 1.0), 1.0)
    pull, stiffness = piece_drive(n, loop) + loop.phi, piece_stiffness(n, loop)
    low, high = lower_end(n, loop), upper_end(n)
    if stiffness > 0.0:
        return min(max(pull / stiffness, low), high)
    return high if pull >= 0.0 else -inf


def lowest_rest(loop):
    """Lowest position at which the knob can rest: pushed up by no more than the friction, above it at least."""
    inf = float("inf")
    n = 0.0
    if loop.kappa > 0.0 and loop.counted > 0.0:
        deep = (loop.gamma + loop.phi + loop.kappa * loop.offset + loop.beta) / (loop.kappa + loop.beta)
        n = max(deep // 1.0, 0.0)
    elif loop.kappa > 0.0 and -loop.gamma - loop.phi < 0.0:
        n = 1.0
    pull, stiffness = piece_drive(n, loop) - loop.phi, piece_stiffness(n, loop)
    low, high = lower_end(n, loop), upper_end(n)
    if stiffness > 0.0:
        return min(max(pull / stiffness, low), high)
    return low if pull <= 0.0 else inf


def rest_range(loop):
    """Lowest and highest position at which the knob can rest; the first above the second if there is none.

    Rest on an edge is meant in Filippov's sense: the torques on its two sides, friction added, push towards it or hold.
    """
    return lowest_rest(loop), highest_rest(loop)


EDGE = 0
TURN = 1
ENDS = 2
LEAVES_FOR_GOOD = 3

ROUNDING = 2.0**-53


def glide_time(speeds, move, beta):
    """Time of an undamped move between two velocities whose sum is ``speeds``: 2/w arctan(w move / speeds).

    It is the half-angle form of the rotation of (v, y/w), w^2 = beta, and 2 move / speeds at constant acceleration.
    """
    if move == 0.0:
        return 0.0
    if beta == 0.0:
        return 2.0 * move / speeds
    w = sqrt(beta)
    if speeds == 0.0:
        return pi / w
    return 2.0 * atan(w * move / speeds) / w


def undamped_step(v, y, way, gap, beta):
    """To the edge or the turning point without damping: ``(kind, move, velocity, time)``, all in closed form."""
    inf = float("inf")
    if abs(gap) < inf:
        # v^2 changes by twice the integral of the acceleration, which is linear in between.
        square = v * v + gap * (2.0 * y - beta * gap)
        if square >= 0.0:
            after = way * sqrt(square)
            return EDGE, gap, after, glide_time(v + after, gap, beta)
    along = way * y
    if beta == 0.0 and along >= 0.0:
        return LEAVES_FOR_GOOD, way * inf, v, inf
    root = sqrt(y * y + beta * v * v)
    move = way * (v * v / (root - along) if along < 0.0 else (along + root) / beta)
    if abs(move) > abs(gap):
        move = gap
    return TURN, move, 0.0, glide_time(v, move, beta)


def crossing_time(v, y, gap, alpha, beta, latest):
    """Time, before ``latest``, at which a motion that goes one way has moved by ``gap``; to full double precision.

    Newton's method inside a bracket, from the undamped time.
    """
    inf = float("inf")
    way = 1.0 if gap > 0.0 else -1.0
    low, high = 0.0, latest
    speeds = abs(v) + sqrt(max(v * v + gap * (2.0 * y - beta * gap), 0.0))
    t = 2.0 * abs(gap) / speeds if speeds > 0.0 else 1.0
    if not t < high:
        t = 0.5 * high
    for _ in range(200):
        s, g, f = hold_coefficients(alpha, beta, t)
        coast, pushed = s * v, g * y
        miss = way * (coast + pushed - gap)
        speed = way * (f * v + s * y)
        if abs(miss) <= ROUNDING * (abs(coast) + abs(pushed)):
            break
        if miss > 0.0:
            high = t
        else:
            low = t
        following = t - miss / speed if speed > 0.0 else -1.0
        if not low < following < high:
            following = 0.5 * (low + high) if high < inf else 2.0 * t
        if abs(following - t) <= 2.0 * ROUNDING * t:
            t = following
            break
        t = following
    return t


def damped_step(v, y, way, gap, alpha, beta):
    """To the edge, the turning point or the end of a damped motion: ``(kind, move, velocity, time)``."""
    inf = float("inf")
    if v == 0.0:
        turn = zero_spacing(alpha, beta)
    elif beta == 0.0 and way * y >= 0.0:
        turn = inf
    else:
        turn = first_zero(v, y, alpha, beta)
    if turn < inf:
        s, g, _ = hold_coefficients(alpha, beta, turn)
        move = s * v + g * y
        if abs(move) < abs(gap):
            return TURN, move, 0.0, turn
    else:
        if beta > 0.0:
            move = y / beta
        elif y == 0.0:
            move = v / alpha
        else:
            move = way * inf
        if abs(move) <= abs(gap):
            if abs(move) == inf:
                return LEAVES_FOR_GOOD, move, v, inf
            return ENDS, move, 0.0, inf
    t = crossing_time(v, y, gap, alpha, beta, turn)
    s, _, f = hold_coefficients(alpha, beta, t)
    return EDGE, gap, way * max(way * (f * v + s * y), 0.0), t


def place(x, v, loop):
    """Piece, edge and distance from the edge of a position ``x`` at velocity ``v``: ``(n, edge, u)``."""
    if loop.kappa == 0.0 or x > 0.0 or (x == 0.0 and v >= 0.0):
        return 0.0, 0.0, x
    if loop.counted == 0.0:
        return 1.0, 0.0, x
    n = -(x // 1.0)
    if x == -n:
        return (n + 1.0 if v < 0.0 else n), 0.0 - n, 0.0
    edge = 1.0 - n if x + n > 0.5 else 0.0 - n
    return n, edge, x - edge


def acceleration(n, x, way, loop):
    """Acceleration at ``x`` in piece ``n`` while moving in the direction ``way``, except for the damping."""
    return piece_drive(n, loop) - way * loop.phi - piece_stiffness(n, loop) * x


def heading(n, edge, u, loop):
    """Where a knob without velocity goes: ``(n, way)``, ``way`` 0 if it rests.

    On an edge it rests unless the side above pushes up, or the side below pushes down, by more than the friction;
    never both, for the push grows with depth.
    """
    if u == 0.0 and loop.kappa > 0.0:
        above = 0.0 - edge
        if acceleration(above, edge, 1.0, loop) > 0.0:
            return above, 1.0
        if acceleration(above + 1.0, edge, -1.0, loop) < 0.0:
            return above + 1.0, -1.0
        return n, 0.0
    if acceleration(n, edge + u, 1.0, loop) > 0.0:
        return n, 1.0
    if acceleration(n, edge + u, -1.0, loop) < 0.0:
        return n, -1.0
    return n, 0.0


def set_off(n, edge, u, v, loop):
    """Where a knob goes, which moves or does not: ``(n, way)``."""
    if v == 0.0:
        return heading(n, edge, u, loop)
    return n, (1.0 if v > 0.0 else -1.0)


def move_on(n, edge, u, v, way, goal, loop):
    """The next event: ``(kind, n, edge, u, v, time)``, the state as it is just after it.

    ``goal``: a position at which to stop as well, or infinite. ``ENDS`` is a rest approached for ever; the state is
    then the rest.
    """
    stiffness = piece_stiffness(n, loop)
    y = acceleration(n, edge + u, way, loop)
    ahead = upper_end(n) if way > 0.0 else lower_end(n, loop)
    gap = (ahead - edge) - u
    stop = (goal - edge) - u
    early = 0.0 <= way * stop < way * gap
    if early:
        gap = stop
    if loop.alpha == 0.0:
        kind, move, v, t = undamped_step(v, y, way, gap, stiffness)
    else:
        kind, move, v, t = damped_step(v, y, way, gap, loop.alpha, stiffness)
    if kind == EDGE and not early:
        return kind, n - way, ahead, 0.0, v, t
    if (kind == TURN or kind == ENDS) and move == gap and not early:
        return kind, n, ahead, 0.0, v, t
    return kind, n, edge, u + move, v, t


def time_to(n, edge, u, v, goal, loop):
    """Time from a state to the position ``goal``, which is ahead, before the motion turns."""
    n, way = set_off(n, edge, u, v, loop)
    total = 0.0
    while way * (goal - (edge + u)) > 0.0:
        kind, n, edge, u, v, t = move_on(n, edge, u, v, way, goal, loop)
        total += t
        if kind != EDGE:
            break
    return total
