"""An inner region that contracts: all later samples provably get one reading, and friction brings the knob to rest.

A knob may creep to the edge of the zone in which friction can hold it, and never reach it: then no sample shows it at
rest. But it rests for ever at any point e of that zone, and the energy of the difference of two motions that get the
same commands never grows (`general.body`). So a motion whose distance from such a rest is below the rest's distance to
the nearest change of reading keeps its reading. Damping and friction take energy as long as anything moves: it settles.

With a continuous sensor inside the wall the command follows the samples. Over a hold of one sample the wall's work is
that of its own spring, kappa, and at most kappa/2 of the square of the way, which is at most the integral of the
velocity squared. So with alpha >= kappa/2 (Colgate & Schenkel 1994) the energy, wall spring included, never grows. That
is so of any linear piece of a torque over the angle whose slope, with the other springs, holds the knob; and of holds
that are shorter, as long as the longest is a sample, so that it holds where the sample clock jitters.
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import distance
from hknob_cli.engine.general.controller import bends, command, edge_gap, follows, slopes
from hknob_cli.engine.general.flank_rest import flank_room
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.engine.general.torque_curve import has_curve, rounded_size
from hknob_cli.engine.propagator import hold_coefficients

ROUNDINGS = 64.0  # of a position that has stopped changing
LONG = 1e15  # samples after which nothing moves that friction can hold


def spring_of_command(shown, wall):
    """Stiffness of the spring that a command is which follows the knob, below 0 where it pushes away."""
    if has_curve(wall.curve):
        slope, last = slopes(shown, shown, wall)
        return -(slope + last)
    return wall.kappa


def hold_zone(u, shown, body, wall):
    """Stiffness of all springs on the knob, and the positions from which to which friction holds it for ever.

    ``(stiffness, low, high)``; low above high where there are none, to within rounding. A finger has settled.
    """
    stiffness, pull = body.beta, u + body.drive
    if body.ratio > 0.0:
        if body.pad_stiffness == 0.0 or body.finger_stiffness == 0.0:
            return 0.0, 1.0, 0.0
        stiffness = body.pad_stiffness * body.finger_stiffness
        stiffness /= body.ratio * body.pad_stiffness + body.finger_stiffness
        pull -= stiffness * body.shift
    own = stiffness
    if follows(shown, wall):
        spring = spring_of_command(shown, wall)
        stiffness += spring
        pull = pull + spring * shown if has_curve(wall.curve) else pull - u
    if not stiffness > 0.0:
        return 0.0, 1.0, 0.0
    slack = ROUNDINGS * EPSILON * (abs(u) + body.push + body.friction + stiffness * abs(body.shift))
    if has_curve(wall.curve):
        slack += ROUNDINGS * EPSILON * (rounded_size(shown, wall.curve) + (own + abs(stiffness - own)) * abs(shown))
    return stiffness, (pull - body.friction + slack) / stiffness, (pull + body.friction - slack) / stiffness


def rest_at(x, u, stiffness, out, body):
    """Leave in ``out`` a body at rest at ``x`` under the torque ``u``; ``stiffness``: as `hold_zone` has it."""
    n = body.order
    for i in range(n):
        out[i] = 0.0
    out[0] = x
    if body.ratio > 0.0:
        out[2] = stiffness * (x + body.shift) / body.pad_stiffness
    if body.lag > 0.0:
        out[n - 1] = u


def gives_nothing(shown, delay, body, wall):
    """Whether a command that follows the knob never adds energy, its spring included: a linear piece, and damping."""
    if body.order > 2 or delay > 0 or wall.damping > 0.0 or bends(wall) > 0.0:
        return False
    return body.alpha >= 0.5 * spring_of_command(shown, wall)


def keeps_reading(z, shown, u, body, wall, delay, orbit, away):
    """Whether a knob with friction, whose commands under way are all ``u``, gets one reading for ever and settles.

    ``(whether, gap)``: the latter of the rest that its motion is compared with, which is left in ``orbit``, to the
    nearest change of reading. ``delay``: commands under way.
    """
    n = body.order
    if body.ratio > 0.0 and body.pad_damping + body.finger_damping == 0.0:
        return False, 0.0  # a finger that nothing damps swings on beside a knob that is held
    linear = follows(shown, wall)
    if linear and not gives_nothing(shown, delay, body, wall):
        return False, 0.0
    stiffness, low, high = hold_zone(u, shown, body, wall)
    if low > high:
        return False, 0.0
    rest = min(max(z[0], low), high)
    rest_at(rest, u, stiffness, orbit, body)
    for i in range(n):
        away[i] = z[i] - orbit[i]
    reach = sqrt(away[0] * away[0] + away[1] * away[1] / stiffness) if linear else distance(away, body)
    seen = rest if wall.analog > 0.0 else shown
    if not linear and command(seen, seen, wall) != u:
        return False, 0.0
    gap = edge_gap(rest, seen, seen, wall)
    reach += ROUNDINGS * EPSILON * (1.0 + abs(rest) + abs(z[0]))
    if body.play > 0.0 and not reach < flank_room(body.pad_stiffness * orbit[2], body):
        return False, gap  # where teeth part, the energy of a difference may grow
    return reach < gap, gap


def stands(z, before, ring, head, body, wall, space):
    """Whether one sample more changes nothing, to the last bit: then none ever will."""
    n = body.order
    for i in range(n):
        space.state[i] = z[i]
    advance(space.state, before, ring, head, body, wall, space.pad)
    for i in range(n):
        if space.state[i] != z[i]:
            return False
    return True


def come_to_rest(z, shown, u, body, wall, orbit):
    """Leave in ``orbit`` where a motion ends that `keeps_reading`; of second order in closed form, however late."""
    if body.order == 2 and not follows(shown, wall):
        s, g, f = hold_coefficients(body.alpha, body.beta, LONG)
        orbit[0], _ = step_with_friction(z[0], z[1], u, LONG, s, g, f, body)
