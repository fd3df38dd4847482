"""Proof of a limit cycle of the general loop: closure of the period map, its contraction, and a torque that bends.

A difference d of two motions with a continuous sensor goes from sample to sample by M d, M being the derivative along
one of them, and by what the torque there is off its tangent: at most bend d^2 / 2, where its slope changes by at most
``bend`` along the angle. What that comes to is bounded by its size, interval by interval, and over later periods by the
sum of the absolute powers of the period's derivative. Where the bound is no larger than the difference by the tangents,
no motion in question ever gets further, and any two of them come together: the bound holds with twice that remainder,
so that it is at most half of any difference that is left, in the end (as a contraction has it, whose constant is a
half). So one of them is periodic, and all others come to it.

Where the encoder has counts, two motions that get the same readings get the same commands, and the energy of their
difference never grows, friction or not. So a trial that is nearer to the orbit than any sample of it is to an edge has
the same readings for ever; the derivative says that it then converges. With a continuous sensor the command follows the
motion, and the growth of a difference is bounded by the derivative's powers. Teeth with play keep that energy while
they stay on one flank, which is one more margin; where they part it may grow, and the derivative alone says that nearby
motions come closer: that is no proof. With cogging a corner is such a margin, as long as the springs of one slope hold
the knob; over corners, and where they do not, `corners` bounds what that adds. A torque over the angle of a continuous
sensor is linear between its knees and steps, which are such margins, too; where it bends, what that adds is bounded.
"""

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.body import copy_to, norm, stiffness, turn_finger
from hknob_cli.engine.general.cogging import ROOT, cog_number, far_apart, far_around, has_cogs
from hknob_cli.engine.general.columns import CORNER_ROOM, LEVEL, PRESSED, SPEED
from hknob_cli.engine.general.controller import bends, command, edge_gap, read_after
from hknob_cli.engine.general.corners import NEAREST, goes_over, room_over_corners
from hknob_cli.engine.general.flank_rest import flank_room_on
from hknob_cli.engine.general.interval import advance_columns, move_columns
from hknob_cli.engine.general.period_map import find_orbit, within
from hknob_cli.engine.general.powers import GONE, TAIL, bound_growth, dissipates, growth_bound, unit
from hknob_cli.engine.general.torque_curve import has_curve


def answer_to_torque(before, head, body, wall, space, at):
    """Leave in ``matrix[at]`` on how the state a sample later depends on the torque of the sample's command.

    With a delay it is a command under way, at ``head``; with less than a sample of it, or none, the body answers, too.
    """
    n, width, delay = body.order, space.width, len(space.line)
    for i in range(width):
        space.matrix[at + i] = 0.0
    if delay > 0:
        space.matrix[at + n + head] = 1.0
    if delay > 1:
        return
    for i in range(width):
        space.cols[i] = 0.0
    space.cols[width * width] = 0.0
    space.cols[width * width + width] = 1.0
    for i in range(n):
        space.residual[i] = space.state[i]
    u = command(read_after(space.state[0], before, wall), before, wall)
    # Without friction the answer is the same whichever torque acts, and beside it no motion is proven here.
    move_columns(space.residual, u, u, body, wall, space, 1)
    for i in range(n):
        space.matrix[at + i] = abs(space.cols[i])


def push_on(space, at, width):
    """Take a bound at ``matrix[at]`` through an interval whose derivative is in ``space.cols``."""
    for i in range(width):
        total = 0.0
        for c in range(width):
            total += abs(space.cols[c * width + i]) * space.matrix[at + c]
        space.spare[i] = total
    for i in range(width):
        space.matrix[at + i] = space.spare[i]


def turn_bound(space, at, delay, first, head):
    """Turn the delay line of a bound at ``matrix[at]`` back to where it began."""
    n = space.width - delay - 1
    for j in range(delay):
        space.spare[j] = space.matrix[at + n + (head + j) % delay]
    for j in range(delay):
        space.matrix[at + n + (first + j) % delay] = space.spare[j]


def run_bent(start, head, period, body, wall, space):
    """Run the orbit in ``space`` over a period with what the bends add: ``(whether, most)``.

    ``matrix`` has in its first row what they may have added by the start of any period; in the third is left what they
    add in one more. ``space.trail`` has for each sample how far the tangents let a difference get. Whether no sample
    comes to the end of its room, and what is added is nowhere more than by the tangents; ``most``: of that at a sample.
    """
    width, delay = space.width, len(space.line)
    whole, new, answer = width, 2 * width, 3 * width
    for i in range(width):
        space.matrix[whole + i], space.matrix[new + i] = space.matrix[i], 0.0
    for i in range(body.order):
        space.state[i] = space.orbit[i]
    for j in range(delay):
        space.line[j] = space.orbit_line[j]
    before, first, most, kept, last = start, head, 0.0, True, 0.0
    for k in range(period):
        x = space.state[0]
        added = space.matrix[whole]
        far = space.trail[k] + added
        gap = edge_gap(x, read_after(x, before, wall), before, wall)
        kept = kept and added <= space.trail[k] and max(far, last) < gap
        most, last = max(most, added), far
        answer_to_torque(before, head, body, wall, space, answer)
        for c in range(width):
            for i in range(width):
                space.cols[c * width + i] = 1.0 if i == c else 0.0
        before, head = advance_columns(space.state, before, space.line, head, body, wall, space, width)
        push_on(space, whole, width)
        push_on(space, new, width)
        off = bends(wall) * far * far
        for i in range(width):
            space.matrix[whole + i] += off * space.matrix[answer + i]
            space.matrix[new + i] += off * space.matrix[answer + i]
    turn_bound(space, new, delay, first, head)
    return kept, most


def sum_over_periods(space, scale, at):
    """Leave in ``matrix[at]`` on what bends come to that add the third row of ``matrix`` in each period."""
    width = space.width
    new = 2 * width
    largest = 0.0
    for i in range(width):
        largest = max(largest, space.matrix[new + i] / unit(i, scale))
    for i in range(width):
        total = 0.0
        for j in range(width):
            part = space.matrix[new + j] + TAIL * GONE * largest * unit(j, scale)
            total += space.total[i * width + j] * part
        space.matrix[at + i] = total


def holds_though_bent(start, head, period, body, wall, space, scale):
    """Whether a proof by tangents holds where the torque bends, and what that adds to an error of a sample.

    ``space.away`` bounds differences at the start of every period by the tangents, ``space.trail`` at its samples;
    ``space.total``: the sum of the absolute powers of the derivative. Overwrites ``matrix``, ``spare``, ``residual``
    and ``cols``.
    """
    width = space.width
    for i in range(width):
        space.matrix[i] = 0.0
    run_bent(start, head, period, body, wall, space)
    sum_over_periods(space, scale, 0)
    for i in range(width):
        space.matrix[i] *= 2.0
    kept, most = run_bent(start, head, period, body, wall, space)
    if not kept:
        return False, most
    sum_over_periods(space, scale, width)
    for i in range(width):
        if not space.matrix[width + i] <= space.matrix[i] or not space.matrix[i] <= space.away[i]:
            return False, most
    return True, most


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
