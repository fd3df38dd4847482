"""How fast nearby motions part: the largest Lyapunov exponent, by the derivative along one motion.

Above 0 neighbours part for good, and a bounded motion that repeats is not to be expected (Benettin et al. 1980). The
derivative goes through every event exactly; the exponent is an average over a time that ends.
"""

from math import log, sqrt

from hknob_cli.engine.general.interval import advance_columns


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
