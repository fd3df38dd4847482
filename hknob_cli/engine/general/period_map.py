"""Proof of a limit cycle of the general loop: closure of the period map, and its contraction.

From a trial whose readings seem to repeat, Newton's method finds the fixed point of the map over the period; the map's
derivative is carried through every event. Where the encoder has counts, two motions that get the same readings get the
same commands, and the energy of their difference never grows, friction or not. So a trial that is nearer to the orbit
than any sample of it is to an edge has the same readings for ever; the derivative says that it then converges. With a
continuous sensor the command follows the motion, and the growth of a difference is bounded by the derivative's powers.
Teeth with play keep that energy while they stay on one flank, which is one more margin; where they part it may grow,
and the derivative alone says that nearby motions come closer: that is no proof. So it is with cogging, whose corners
are such a margin, as long as the springs of one slope hold the knob. A torque over the angle of a continuous sensor is
linear between its knees and steps, which are such margins, too; where it bends, `bent` bounds what that adds.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.bent import holds_though_bent
from hknob_cli.engine.general.body import norm, stiffness, turn_finger
from hknob_cli.engine.general.cogging import ROOT, SIZE, cog_number, far_apart, has_cogs, reach_on
from hknob_cli.engine.general.controller import (
    bends,
    command,
    count_gap,
    edge_gap,
    inside,
    read,
    read_after,
    table_size,
)
from hknob_cli.engine.general.flank_rest import flank_room_on
from hknob_cli.engine.general.hysteresis import hold_and_count
from hknob_cli.engine.general.interval import advance_columns
from hknob_cli.engine.general.powers import bound_growth, dissipates, growth_bound, invert
from hknob_cli.engine.general.torque_curve import has_curve

AT_EVENT = 5  # a standstill of the motion could, within rounding, go another way
EXPANDS = 6  # the period map does not contract
PARTS = 7  # teeth part within the period, or cogging does not hold the knob: its map contracts to first order
NEWTON_STEPS = 8
STILL = 16.0  # times its error bound, by which a motion must move at least to be a cycle, beside a curve
AS_NEAR = 1e-9  # of an orbit's size: a trial so near to it is as near as it may come
LEAST_SCALE = 1e-3  # of speeds against positions, in a norm of differences; a rest point has no speed


class Space(NamedTuple):
    """Work space of the general loop, lists or arrays; ``width`` of a column: state, delay line, last reading."""

    width: int
    pad: Any  # (2 * order), rates and new states
    cols: Any  # (width * (width + 2)), columns of derivatives, and those of the commands
    marks: Any  # (4)
    matrix: Any  # (2 * width * width)
    power: Any  # (width * width)
    total: Any  # (width * width)
    spare: Any  # (width * width)
    residual: Any  # (width)
    away: Any  # (width)
    state: Any  # (order), a motion beside the trial
    orbit: Any  # (order), the periodic one
    line: Any  # (delay)
    orbit_line: Any  # (delay)
    trail: Any  # readings since the checkpoint, the first of them
    reading: Any  # (1), the orbit's reading one sample before


def turn_lines(line, cols, away, m, delay, first, head):
    """Turn the delay lines, and their derivatives, back to where they began: oldest at ``first``."""
    n = m - delay - 1
    for c in range(-1, m):
        for j in range(delay):
            away[j] = line[(head + j) % delay] if c < 0 else cols[c * m + n + (head + j) % delay]
        for j in range(delay):
            if c < 0:
                line[(first + j) % delay] = away[j]
            else:
                cols[c * m + n + (first + j) % delay] = away[j]


def begin_period(ring, body, space, m):
    """Set the motion in ``space`` to the orbit's start, and its derivative by m numbers of the state to 1."""
    width = space.width
    for c in range(m):
        for i in range(width):
            space.cols[c * width + i] = 1.0 if i == c else 0.0
    for i in range(body.order):
        space.state[i] = space.orbit[i]
    for j in range(len(ring)):
        space.line[j] = space.orbit_line[j]


def turn(before, ring, head, period, body, wall, space, m):
    """Run the orbit in ``space`` over one period with its derivative: ``(margin, edge, reach, pace, before, head)``.

    ``margin``: least distance of a sample to a change of command, ``edge``: to any count edge.
    """
    n, width = body.order, space.width
    begin_period(ring, body, space, m)
    for i in range(4):
        space.marks[i] = float("inf")
    margin, edge = float("inf"), float("inf")
    reach, pace = cog_number(body.cogs, SIZE), 0.0
    first = head
    for _ in range(period):
        x = space.state[0]
        shown = read_after(x, before, wall)
        margin = min(margin, edge_gap(x, shown, before, wall))
        counted = shown
        if wall.hysteresis > 0.0:
            for i in range(n):
                space.away[i] = space.state[i]
            u = command(shown, before, wall)
            counted, gap = hold_and_count(space.away, u, shown, space.line, head, body, wall, space.pad)
            margin = min(margin, gap)
        edge = min(edge, count_gap(x, wall))
        reach = max(reach, abs(x), table_size(shown, wall))
        pace = max(pace, abs(space.state[1]))
        before, head = advance_columns(
            space.state, before, space.line, head, body, wall, space.pad, space.cols, m, width, space.marks
        )
        pace = max(pace, abs(space.state[0] - x))
        if wall.hysteresis > 0.0:
            before = counted
    if m > n:
        turn_lines(space.line, space.cols, space.away, m, len(ring), first, head)
    return margin, edge, reach, pace, before, head


def apart_at_sample(body, space, m):
    """Leave in ``space.spare`` bounds on the difference at a sample of each number of the state, by ``residual``."""
    for i in range(body.order):
        total = 0.0
        for c in range(m):
            total += abs(space.cols[c * space.width + i]) * space.residual[c]
        space.spare[i] = total


def far_between_samples(body, space, m):
    """Bound on how far apart two motions get in position up to the next sample, from `apart_at_sample`.

    Their torques differ by no more than their commands in this interval, whose derivatives are still in ``cols``: that
    adds as much to the root of the energy of their difference, a speed.
    """
    width = space.width
    older, newer = 0.0, 0.0
    for c in range(m):
        older += abs(space.cols[width * width + c]) * space.residual[c]
        newer += abs(space.cols[width * width + width + c]) * space.residual[c]
    turn_finger(space.spare, body)
    far = far_apart(body.cogs, space.spare, space.orbit[0], body)
    return far + reach_on(body.cogs, space.orbit[0], body) * max(older, newer)


def room_left(body, space):
    """How far apart motions may be until teeth part, or a corner of cogging is passed, anywhere in the period."""
    room = flank_room_on(body.cogs, space.marks[2], space.orbit[0], body) if body.play > 0.0 else float("inf")
    return min(room, space.marks[3]) if has_cogs(body.cogs) else room


def within(before, ring, head, period, body, wall, space, m):
    """Whether differences up to ``away`` at the start of every period leave each sample on its side of every edge.

    Teeth that press must then not part, nor any corner of cogging be passed, between samples either. Returns
    ``(whether, bound)``: the latter on the error of every sample that an error up to ``power`` at the start means.
    ``space.trail`` is left with how far each sample may be off, as far as it reaches.
    """
    width = space.width
    stays = body.play > 0.0 or has_cogs(body.cogs)
    begin_period(ring, body, space, m)
    for i in range(m):
        space.residual[i] = space.away[i]
    last, bound = space.residual[width - 1], 0.0
    for k in range(period):
        x = space.state[0]
        reach, error = 0.0, 0.0
        for c in range(m):
            reach += abs(space.cols[c * width]) * space.residual[c]
            error += abs(space.cols[c * width]) * space.power[c]
        bound = max(bound, error)
        if not max(reach, last) < edge_gap(x, read(x, wall), before, wall):
            return False, bound
        last = reach
        if k < len(space.trail):
            space.trail[k] = reach
        if stays:
            apart_at_sample(body, space, m)
        before, head = advance_columns(
            space.state, before, space.line, head, body, wall, space.pad, space.cols, m, width, space.marks
        )
        if stays:
            far = far_between_samples(body, space, m)
            if bends(wall) > 0.0:  # all numbers may be off by as much again (`bent`), and the command by what it bends
                far = 2.0 * far + reach_on(body.cogs, space.orbit[0], body) * bends(wall) * (2.0 * reach) ** 2
            if not far < room_left(body, space):
                return False, bound
    return True, bound


def certify(z, before, ring, head, period, body, wall, space):
    """Try to prove an orbit of ``period`` samples from a trial at ``z`` whose readings seem to repeat.

    Returns ``(status, margin, edge, closure, bound)`` as `engine.certificate.certify` does; the orbit's state at this
    sample is left in ``space.orbit``, its delay line in ``space.orbit_line``, its last reading in ``space.reading``.
    """
    n, width = body.order, space.width
    delay = len(ring)
    m = width if wall.analog > 0.0 else n
    start, last = before, before
    space.reading[0] = before
    for i in range(n):
        space.orbit[i] = z[i]
    for j in range(delay):
        space.orbit_line[j] = ring[j]
    margin, edge, reach, pace, closure, size = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    solved, best = True, float("inf")
    for step in range(NEWTON_STEPS):
        margin, edge, reach, pace, last, at = turn(start, ring, head, period, body, wall, space, m)
        for i in range(n):
            space.residual[i] = space.state[i] - space.orbit[i]
        for j in range(delay):
            if wall.analog > 0.0:
                space.residual[n + j] = space.line[j] - space.orbit_line[j]
            elif space.line[(at + j) % delay] != space.orbit_line[(head + j) % delay]:
                return DIFFERENT, 0.0, 0.0, 0.0, 0.0
        if wall.analog > 0.0:
            space.residual[width - 1] = last - start
        elif (wall.damping > 0.0 and last != start) or (
            wall.hysteresis > 0.0 and inside(last, wall) != inside(start, wall)
        ):
            return DIFFERENT, 0.0, 0.0, 0.0, 0.0
        closure = 0.0
        for i in range(n):
            closure += space.residual[i] * space.residual[i]
        closure = closure**0.5
        size = 4.0 * EPSILON * (reach + pace)
        solved = invert(space.matrix, space.cols, m, width)
        # The orbit that the last step leaves is the one whose residual is known.
        if not solved or closure <= size or closure >= 0.5 * best or step == NEWTON_STEPS - 1:
            break
        best = min(best, closure)
        for i in range(m):
            change = 0.0
            for j in range(m):
                change += space.matrix[i * 2 * m + m + j] * space.residual[j]
            if i < n:
                space.orbit[i] += change
            elif i < width - 1:
                space.orbit_line[i - n] += change
            else:
                start += change
                space.reading[0] = start
    if not closure < 1e-6 * (reach + pace):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    stands = has_curve(wall.curve) and period > 1
    if stands and pace <= size:
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0  # at rest
    if not solved:
        return NEUTRAL, margin, edge, closure, 0.0
    # Every interval adds some roundings; those of one have decayed, or add up at most, over a period.
    rounding = 8.0 * EPSILON * period
    for i in range(m):
        total = 0.0
        for j in range(m):
            slow = j % 2 == 1 and not (body.lag > 0.0 and j == n - 1)
            part = abs(space.residual[j]) + rounding * (2.0 * pace if slow else reach + pace)
            total += abs(space.matrix[i * 2 * m + m + j]) * part
        space.away[i] = total
    bound = space.away[0]
    if stands and pace <= STILL * bound:
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    scale = max(pace / (reach + pace), LEAST_SCALE) if pace > 0.0 else 1.0
    turn_finger(space.away, body)
    far, spread = far_apart(body.cogs, space.away, space.orbit[0], body), norm(space.away, body)
    turn_finger(space.away, body)
    if wall.analog == 0.0 and (has_cogs(body.cogs) or body.reach < float("inf")) and far < float("inf"):
        bound = max(bound, far)  # at every sample of the period, not only at the first
    if body.friction > 0.0:
        # A difference of speeds, and of torques, that the error allows at any time: its energy does not grow.
        root = cog_number(body.cogs, ROOT)
        speed = spread + root * space.away[0]
        late = space.away[n - 1] if body.lag > 0.0 else 0.0
        if not (space.marks[0] > 2.0 * ((stiffness(body) + root) * speed + late) and space.marks[1] > speed):
            return AT_EVENT, margin, edge, closure, bound
    parts = False
    if body.play > 0.0:
        room = flank_room_on(body.cogs, space.marks[2], space.orbit[0], body)
        parts = not room > bound
        if not parts:
            margin = min(margin, room)
    if has_cogs(body.cogs):
        parts = parts or not (space.marks[3] > bound and far < float("inf"))
        if not parts:
            margin = min(margin, space.marks[3])
    if not margin > bound:
        return ON_EDGE, margin, edge, closure, bound
    if not dissipates(space.cols, width, space.power, space.spare, m, scale, period):
        # With a continuous sensor, or teeth that part, motions part: the trial passed by an orbit that it will leave
        # again.
        return (EXPANDS if wall.analog == 0.0 and not parts else DIFFERENT), margin, edge, closure, bound
    if parts:
        return PARTS, margin, edge, closure, bound
    for i in range(n):
        space.residual[i] = z[i] - space.orbit[i]
    if wall.analog == 0.0:
        if not far_apart(body.cogs, space.residual, space.orbit[0], body) + bound < margin:
            return NOT_CAPTURED, margin, edge, closure, bound
        return PROVEN, margin, edge, closure, bound
    if body.friction > 0.0:
        return EXPANDS, margin, edge, closure, bound
    for j in range(delay):
        space.residual[n + j] = ring[j] - space.orbit_line[j]
    space.residual[width - 1] = before - start
    curved, off = bends(wall) > 0.0, 0.0
    if curved:
        for i in range(m):
            off = max(off, abs(space.residual[i]))
        # Of a motion beside cogging all numbers are bounded at the start of a period alone.
        known = period <= len(space.trail) and (period == 1 or not (body.play > 0.0 or has_cogs(body.cogs)))
        if not known or not growth_bound(space.cols, width, space.power, space.spare, space.total, m, scale):
            return EXPANDS, margin, edge, closure, bound
    if not bound_growth(space, m, scale, period):
        return EXPANDS, margin, edge, closure, bound
    near, bound = within(start, ring, head, period, body, wall, space, m)
    if near and curved:
        near, more = holds_though_bent(start, head, period, body, wall, space, scale)
        bound += more
        if not near and off <= AS_NEAR * (reach + pace):
            return EXPANDS, margin, edge, closure, bound
    return (PROVEN if near else NOT_CAPTURED), margin, edge, closure, bound
