"""The map over a period of the general loop, its derivative and fixed point, and how fast nearby motions part.

From a trial whose readings seem to repeat, the map's derivative is carried through every event. Beside it are the least
distances of the motion from what would change its course: edges of counts, and events between samples. The fixed point
is found by Newton's method.

Along any motion the derivative gives the largest Lyapunov exponent, an average over a time that ends. Above 0
neighbours part for good, and a bounded motion that repeats is not to be expected (Benettin et al. 1980).
"""

from math import log, sqrt
from typing import Any, NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import turn_finger
from hknob_cli.engine.general.cogging import SIZE, cog_number, far_apart, has_cogs, reach_on
from hknob_cli.engine.general.columns import CORNER_ROOM, PRESSED, begin_columns, begin_marks
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
from hknob_cli.engine.general.corners import end_sample, join_parts
from hknob_cli.engine.general.flank_rest import flank_room_on
from hknob_cli.engine.general.hysteresis import hold_and_count
from hknob_cli.engine.general.interval import advance_columns
from hknob_cli.engine.general.powers import invert


def normalise(cols, width, m):
    """Bring ``m`` columns, taken together, back to the length 1; their length before."""
    size = 0.0
    for c in range(m):
        for i in range(m):
            size += cols[c * width + i] * cols[c * width + i]
    size = sqrt(size)
    if size > 0.0:
        for c in range(m):
            for i in range(m):
                cols[c * width + i] /= size
    return size


def parting_rate(z, before, ring, samples, body, wall, space):
    """Mean growth of the logarithm of a difference of motions, per sample.

    With an encoder they have the same readings; a continuous sensor's torques follow the difference.

    Args:
        z: State at the start, left at the end.
        before: Reading one sample before.
        ring: Commands under way, oldest first.
        samples: How long the motion is followed.
        body: What moves.
        wall: What commands.
        space: Work space of the general loop.
    """
    width = space.width
    n = width if wall.analog > 0.0 else body.order
    for c in range(n):
        for i in range(width):
            space.cols[c * width + i] = 1.0 if i == c else 0.0
    total, head = 0.0, 0 * len(ring)
    for _ in range(samples):
        before, head = advance_columns(z, before, ring, head, body, wall, space, n)
        size = normalise(space.cols, width, n)
        if not size > 0.0:
            return -float("inf")
        total += log(size)
    return total / samples


NEWTON_STEPS = 8


class Space(NamedTuple):
    """Work space of the general loop, lists or arrays; ``width`` of a column: state, delay line, last reading."""

    width: int
    pad: Any  # (2 * order), rates and new states
    cols: Any  # (width * (width + 2)), columns of derivatives, and those of the commands
    marks: Any  # (`columns.MARKS`)
    chain: Any  # ((`corners.MOST_PARTS` + 2) * order * order), derivatives of parts of a period
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
    begin_columns(space, m)
    for i in range(body.order):
        space.state[i] = space.orbit[i]
    for j in range(len(ring)):
        space.line[j] = space.orbit_line[j]


def turn(before, ring, head, period, body, wall, space, m):
    """Run the orbit in ``space`` over one period with its derivative: ``(margin, edge, reach, pace, before, head)``.

    ``margin``: least distance of a sample to a change of command, ``edge``: to any count edge.
    """
    n = body.order
    begin_period(ring, body, space, m)
    begin_marks(space.marks)
    margin, edge = float("inf"), float("inf")
    reach, pace = cog_number(body.cogs, SIZE), 0.0
    first = head
    for k in range(period):
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
        before, head = advance_columns(space.state, before, space.line, head, body, wall, space, m)
        if m == n:
            end_sample(k, period, body, space, m)
        pace = max(pace, abs(space.state[0] - x))
        if wall.hysteresis > 0.0:
            before = counted
    if m == n:
        join_parts(body, space, m)
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
    room = flank_room_on(body.cogs, space.marks[PRESSED], space.orbit[0], body) if body.play > 0.0 else float("inf")
    return min(room, space.marks[CORNER_ROOM]) if has_cogs(body.cogs) else room


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
        before, head = advance_columns(space.state, before, space.line, head, body, wall, space, m)
        if stays:
            far = far_between_samples(body, space, m)
            if bends(wall) > 0.0:  # all numbers may be off by as much again, and the command by what it bends
                far = 2.0 * far + reach_on(body.cogs, space.orbit[0], body) * bends(wall) * (2.0 * reach) ** 2
            if not far < room_left(body, space):
                return False, bound
    return True, bound


def comes_back(start, last, at, head, body, wall, space):
    """Whether all that must be the same after a period is; what else the motion in ``space`` differs by, to `residual`.

    ``start`` and ``last``: the last reading before it and at its end; ``head`` and ``at``: the oldest command then.
    """
    n, delay = body.order, len(space.line)
    for i in range(n):
        space.residual[i] = space.state[i] - space.orbit[i]
    for j in range(delay):
        if wall.analog > 0.0:
            space.residual[n + j] = space.line[j] - space.orbit_line[j]
        elif space.line[(at + j) % delay] != space.orbit_line[(head + j) % delay]:
            return False
    if wall.analog > 0.0:
        space.residual[space.width - 1] = last - start
        return True
    if wall.damping > 0.0 and last != start:
        return False
    return not (wall.hysteresis > 0.0 and inside(last, wall) != inside(start, wall))


def closure_of(space, n):
    """Length of the residual of a state."""
    closure = 0.0
    for i in range(n):
        closure += space.residual[i] * space.residual[i]
    return closure**0.5


def step_orbit(start, n, m, space):
    """Move the orbit in ``space`` by a step of Newton's method, and the reading before it; which is returned."""
    for i in range(m):
        change = 0.0
        for j in range(m):
            change += space.matrix[i * 2 * m + m + j] * space.residual[j]
        if i < n:
            space.orbit[i] += change
        elif i < space.width - 1:
            space.orbit_line[i - n] += change
        else:
            start += change
            space.reading[0] = start
    return start


def find_orbit(ring, head, period, body, wall, space, m):
    """Find a fixed point of the map over a period, near the state in ``space.orbit``, by Newton's method.

    Returns ``(same, solved, margin, edge, reach, pace, closure)``: whether all that must be the same comes back;
    whether the derivative could be inverted; the next four as `turn`.
    """
    start, best = space.reading[0], float("inf")
    margin, edge, reach, pace, closure, solved = 0.0, 0.0, 0.0, 0.0, 0.0, True
    for step in range(NEWTON_STEPS):
        margin, edge, reach, pace, last, at = turn(start, ring, head, period, body, wall, space, m)
        if not comes_back(start, last, at, head, body, wall, space):
            return False, solved, margin, edge, reach, pace, closure
        closure = closure_of(space, body.order)
        solved = invert(space.matrix, space.cols, m, space.width)
        # The orbit that the last step leaves is the one whose residual is known.
        small = closure <= 4.0 * EPSILON * (reach + pace)
        if not solved or small or closure >= 0.5 * best or step == NEWTON_STEPS - 1:
            break
        best = min(best, closure)
        start = step_orbit(start, body.order, m, space)
    return True, solved, margin, edge, reach, pace, closure
