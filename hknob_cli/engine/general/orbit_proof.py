"""Proof of a limit cycle of the general loop: closure of the period map, and its contraction.

Where the encoder has counts, two motions that get the same readings get the same commands, and the energy of their
difference never grows, friction or not. So a trial that is nearer to the orbit than any sample of it is to an edge has
the same readings for ever; the derivative says that it then converges. With a continuous sensor the command follows the
motion, and the growth of a difference is bounded by the derivative's powers. Teeth with play keep that energy while
they stay on one flank, which is one more margin; where they part it may grow, and the derivative alone says that nearby
motions come closer: that is no proof. With cogging a corner is such a margin, as long as the springs of one slope hold
the knob; over corners, and where they do not, `corners` bounds what that adds. A torque over the angle of a continuous
sensor is linear between its knees and steps, which are such margins, too; where it bends, `bent` bounds what that adds.
"""

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.bent import holds_though_bent
from hknob_cli.engine.general.body import copy_to, norm, stiffness, turn_finger
from hknob_cli.engine.general.cogging import ROOT, cog_number, far_apart, far_around, has_cogs
from hknob_cli.engine.general.columns import CORNER_ROOM, LEVEL, PRESSED, SPEED
from hknob_cli.engine.general.controller import bends
from hknob_cli.engine.general.corners import NEAREST, goes_over, room_over_corners
from hknob_cli.engine.general.flank_rest import flank_room_on
from hknob_cli.engine.general.period_map import find_orbit, within
from hknob_cli.engine.general.powers import bound_growth, dissipates, growth_bound
from hknob_cli.engine.general.torque_curve import has_curve

AT_EVENT = 5  # a standstill of the motion could, within rounding, go another way
EXPANDS = 6  # the period map does not contract
PARTS = 7  # teeth part within the period, or cogging does not hold the knob: its map contracts to first order
STILL = 16.0  # times its error bound, by which a motion must move at least to be a cycle, beside a curve
AS_NEAR = 1e-9  # of an orbit's size: a trial so near to it is as near as it may come
LEAST_SCALE = 1e-3  # of speeds against positions, in a norm of differences; a rest point has no speed


def bound_error(fast, slow, body, space, m):
    """Bound the error of an orbit whose residual is known, to ``space.away``, and how far it goes: ``(far, spread)``.

    ``fast``, ``slow``: what a period may add to the residual of positions and of speeds. ``far``: of the position at
    any time, infinite where nothing holds it; ``spread``: of the whole, in `body.norm`.
    """
    n = body.order
    for i in range(m):
        total = 0.0
        for j in range(m):
            is_slow = j % 2 == 1 and not (body.lag > 0.0 and j == n - 1)
            part = abs(space.residual[j]) + (slow if is_slow else fast)
            total += abs(space.matrix[i * 2 * m + m + j]) * part
        space.away[i] = total
    turn_finger(space.away, body)
    far, spread = far_apart(body.cogs, space.away, space.orbit[0], body), norm(space.away, body)
    turn_finger(space.away, body)
    return far, spread


def at_every_sample(bound, far, body):
    """Bound on an error of a position, not only at the first sample of a period, where it is known to be ``far``."""
    if (has_cogs(body.cogs) or body.reach < float("inf")) and far < float("inf"):
        return max(bound, far)
    return bound


def meets_event(spread, wrong, period, body, space):
    """Whether friction may hold, or let go, what is off by ``spread``, otherwise than it does in ``space.marks``.

    ``wrong``: by which torques may be off. A difference of speeds, and of torques, that the error allows at any time:
    its energy does not grow.
    """
    root = cog_number(body.cogs, ROOT)
    speed = spread + root * space.away[0] + wrong * period
    late = space.away[body.order - 1] if body.lag > 0.0 else 0.0
    most = 2.0 * ((stiffness(body) + root) * speed + late + wrong)
    return not (space.marks[LEVEL] > most and space.marks[SPEED] > speed)


def margin_of_parts(margin, bound, holds, body, space):
    """Whether teeth may part, or corners of cogging be passed, by what an orbit may be off: ``(whether, margin)``.

    ``margin``: with theirs, where they do not. ``holds``: whether springs hold the knob on a slope of cogging.
    """
    parts = False
    if body.play > 0.0:
        room = flank_room_on(body.cogs, space.marks[PRESSED], space.orbit[0], body)
        parts = not room > bound
        if not parts:
            margin = min(margin, room)
    if has_cogs(body.cogs):
        parts = parts or not (space.marks[CORNER_ROOM] > bound and holds)
        if not parts:
            margin = min(margin, space.marks[CORNER_ROOM])
    return parts, margin


def scale_of(reach, pace):
    """How speeds compare to positions in a norm of differences."""
    return max(pace / (reach + pace), LEAST_SCALE) if pace > 0.0 else 1.0


def room_beside(added, margin, period, body, wall, space, scale):
    """Room of an orbit over corners, 0 where it is not proven, and how far the orbit may be off: ``(room, bound)``.

    ``added``: to the residual of positions and of speeds, by a period.
    """
    if not goes_over(body) or wall.analog > 0.0:
        return 0.0, 0.0
    room, bound, _ = room_over_corners(added[0], added[1], margin, 0.0, period, body, space, scale)
    return room, bound


def captures_by_counts(margin, bound, nearest, body, space):
    """Whether an orbit, known to within ``bound``, captures the trial that differs from it by ``space.residual``.

    ``nearest``: how near a trial may come at most to an orbit over corners, which is then not proven; 0 of others.
    """
    away = far_around(body.cogs, space.residual, space.orbit[0], body)
    if away + bound < margin:
        return PROVEN
    return PARTS if away <= nearest and nearest > 0.0 else NOT_CAPTURED


def captures_alike(ring, head, period, size, bound, body, wall, space):
    """With a continuous sensor, whether the orbit is proven and captures the trial: ``(status, bound)``.

    ``space.residual`` has what their states and last readings differ by; ``size``: of the orbit, ``(reach, pace)``.
    """
    n, m, width = body.order, space.width, space.width
    reach, pace = size
    start, scale = space.reading[0], scale_of(reach, pace)
    for j in range(len(ring)):
        space.residual[n + j] = ring[j] - space.orbit_line[j]
    curved, off = bends(wall) > 0.0, 0.0
    if curved:
        for i in range(m):
            off = max(off, abs(space.residual[i]))
        # Of a motion beside cogging all numbers are bounded at the start of a period alone.
        known = period <= len(space.trail) and (period == 1 or not (body.play > 0.0 or has_cogs(body.cogs)))
        if not known or not growth_bound(space.cols, width, space.power, space.spare, space.total, m, scale):
            return EXPANDS, bound
    if not bound_growth(space, m, scale, period):
        return EXPANDS, bound
    near, bound = within(start, ring, head, period, body, wall, space, m)
    if near and curved:
        near, more = holds_though_bent(start, head, period, body, wall, space, scale)
        bound += more
        if not near and off <= AS_NEAR * (reach + pace):
            return EXPANDS, bound
    return (PROVEN if near else NOT_CAPTURED), bound


def certify(z, before, ring, head, period, body, wall, space):
    """Try to prove an orbit of ``period`` samples from a trial at ``z`` whose readings seem to repeat.

    Returns ``(status, margin, edge, closure, bound)`` as `engine.certificate.certify` does; the orbit's state at this
    sample is left in ``space.orbit``, its delay line in ``space.orbit_line``, its last reading in ``space.reading``.
    """
    n, width = body.order, space.width
    m = width if wall.analog > 0.0 else n
    copy_to(space.orbit, z)
    copy_to(space.orbit_line, ring)
    space.reading[0] = before
    same, solved, margin, edge, reach, pace, closure = find_orbit(ring, head, period, body, wall, space, m)
    if not same or not closure < 1e-6 * (reach + pace):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    stands = has_curve(wall.curve) and period > 1
    if stands and pace <= 4.0 * EPSILON * (reach + pace):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0  # at rest
    if not solved:
        return NEUTRAL, margin, edge, closure, 0.0
    # Every interval adds some roundings; those of one have decayed, or add up at most, over a period.
    rounding = 8.0 * EPSILON * period
    fast, slow = rounding * (reach + pace), rounding * (2.0 * pace)
    far, spread = bound_error(fast, slow, body, space, m)
    bound = space.away[0]
    if stands and pace <= STILL * bound:
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    if wall.analog == 0.0:
        bound = at_every_sample(bound, far, body)
    if body.friction > 0.0 and meets_event(spread, 0.0, period, body, space):
        return AT_EVENT, margin, edge, closure, bound
    parts, margin = margin_of_parts(margin, bound, far < float("inf"), body, space)
    if not margin > bound:
        return ON_EDGE, margin, edge, closure, bound
    scale = scale_of(reach, pace)
    if not dissipates(space.cols, width, space.power, space.spare, m, scale, period):
        # With a continuous sensor, or teeth that part, motions part: the trial passed by an orbit that it will leave
        # again.
        return (EXPANDS if wall.analog == 0.0 and not parts else DIFFERENT), margin, edge, closure, bound
    if parts:
        room, off = room_beside((fast, slow), margin, period, body, wall, space, scale)
        if not room > 0.0:
            return PARTS, margin, edge, closure, bound
        margin, bound = room + off, off
    for i in range(n):
        space.residual[i] = z[i] - space.orbit[i]
    if wall.analog == 0.0:
        status = captures_by_counts(margin, bound, NEAREST * (reach + pace) if parts else 0.0, body, space)
        return status, margin, edge, closure, bound
    if body.friction > 0.0:
        return EXPANDS, margin, edge, closure, bound
    space.residual[width - 1] = before - space.reading[0]
    status, bound = captures_alike(ring, head, period, (reach, pace), bound, body, wall, space)
    return status, margin, edge, closure, bound
