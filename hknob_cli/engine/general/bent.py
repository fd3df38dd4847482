"""A torque over the angle that bends: what the proof of a periodic motion owes to that its slope changes.

A difference d of two motions with a continuous sensor goes from sample to sample by M d, M being the derivative along
one of them, and by what the torque there is off its tangent: at most bend d^2 / 2, where its slope changes by at most
``bend`` along the angle. What that comes to is bounded by its size, interval by interval, and over later periods by the
sum of the absolute powers of the period's derivative. Where the bound is no larger than the difference by the tangents,
no motion in question ever gets further, and any two of them come together: the bound holds with twice that remainder,
so that it is at most half of any difference that is left, in the end (as a contraction has it, whose constant is a
half). So one of them is periodic, and all others come to it.
"""

from hknob_cli.engine.general.controller import bends, command, edge_gap, read_after
from hknob_cli.engine.general.interval import advance_columns, move_columns
from hknob_cli.engine.general.powers import GONE, TAIL, unit


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
