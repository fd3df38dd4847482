"""Where the energy leaks in: the work of the wall, split by when it is done.

A wall that answered at once would give back what it takes: its torque depends on the angle alone, and its potential U
comes back over a cycle. What the sampled one adds, it adds late (Hasser, secs. 6.2 and 9.1):

- *late entry*: the knob is inside the wall, and no torque acts yet;
- *late exit*: the knob is outside again, and torque still acts;
- *staircase*: the knob is inside, and the torque is that of an earlier angle.

While the torque u is constant, its work less that of the wall that answers at once is u (x1 - x0) + U(x1) - U(x0), with
x clipped to the part in question: no crossing times are needed. The three add up to the work of the wall over a cycle.
"""

from hknob_cli.engine.loop import floor


def potential(depth, kappa, offset, analog):
    """Work to push the knob ``depth`` counts into a wall that answers at once; 0 outside.

    ``kappa``: stiffness of the wall, K T^2 / J; ``offset``: angle that an encoder level reports, less the level, in
    counts; ``analog``: whether the sensor has no counts.
    """
    if depth <= 0.0:
        return 0.0
    if analog:
        return 0.5 * kappa * depth * depth
    whole = floor(depth)
    full = whole * (0.5 * (whole + 1.0) - offset)
    return kappa * (full + (depth - whole) * (whole + 1.0 - offset))


def find_leak(x, drive, count, push, edge, kappa, offset, analog):
    """Split the work of the wall over ``count`` holds into ``(late entry, late exit, staircase)``.

    The torque of the wall is ``drive`` plus ``push``, as an acceleration; ``edge``: the position below which a wall
    that answers at once would act.
    """
    entry, left, staircase = 0.0, 0.0, 0.0
    deep, stored = max(edge - x[0], 0.0), potential(edge - x[0], kappa, offset, analog)
    for i in range(count):
        torque = drive[i] + push
        deeper = max(edge - x[i + 1], 0.0)
        after = potential(deeper, kappa, offset, analog)
        inside = deep - deeper
        if torque == 0.0:
            entry += after - stored
        else:
            left += torque * (x[i + 1] - x[i] - inside)
            staircase += torque * inside + (after - stored)
        deep, stored = deeper, after
    return entry, left, staircase
