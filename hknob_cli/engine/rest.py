"""Rest: a trial that stays inside one level for ever and comes to a standstill there.

Under a constant drive the plant relaxes to x = drive / beta. If no later position can leave the level, by the
energy bound of `certificate.distance` or because an overdamped approach never passes its end, rest is proven.
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON, distance
from hknob_cli.engine.loop import drive_of, lower_edge, upper_edge

MOVING = 0
AT_REST = 1
REST_ON_EDGE = 2
LEAVES = 3
RINGS = 4


def monotone(gap, speed, loop):
    """Whether an approach from ``gap`` at ``speed`` to the rest point keeps its side for ever (overdamped only)."""
    if gap == 0.0 and speed == 0.0:
        return True
    a = 0.5 * loop.alpha
    if a * a < loop.beta:
        return False
    fast = a + sqrt(a * a - loop.beta)
    if gap >= 0.0:
        return speed + fast * gap >= 0.0
    return speed + fast * gap <= 0.0


def settles(x, v, level, loop):
    """Fate of a trial at ``(x, v)`` if ``level`` goes on acting: ``(fate, x_rest, margin, bound)`` in counts.

    ``margin`` is the rest point's distance to the nearest edge that changes the torque; ``bound`` its rounding error.
    """
    drive = drive_of(level, loop)
    low, high = lower_edge(level, loop.sense), upper_edge(level, loop.sense)
    if loop.kappa == 0.0:
        low, high = -float("inf"), float("inf")
    if loop.beta > 0.0:
        rest = drive / loop.beta
        scale = (abs(loop.kappa * (level + loop.offset)) if level < 0.0 else 0.0) + abs(loop.gamma)
        bound = 8.0 * EPSILON * (scale / loop.beta + abs(rest))
        margin = min(rest - low, high - rest)
        reach = distance(x - rest, v, loop)
        if reach + bound < margin:
            return (AT_REST if loop.alpha > 0.0 or reach == 0.0 else RINGS), rest, margin, bound
        # On an edge: it may be approached for ever and never passed. Proven only where no rounding is involved, and the
        # edge belongs to the level: at 0, where neither wall nor bias acts.
        if abs(margin) <= bound and loop.alpha > 0.0 and low <= x <= high and monotone(x - rest, v, loop):
            return (AT_REST if scale == 0.0 and rest == low else REST_ON_EDGE), rest, 0.0, bound
        return MOVING, rest, margin, bound
    if drive != 0.0:
        return MOVING, x, 0.0, 0.0
    if loop.alpha > 0.0:
        rest = x + v / loop.alpha
        margin = min(rest - low, high - rest)
        bound = 4.0 * EPSILON * (abs(x) + abs(v / loop.alpha))
        if not low <= x <= high or margin < -bound:
            return MOVING, rest, margin, bound
        return (AT_REST if margin > bound else REST_ON_EDGE), rest, margin, bound
    if v == 0.0:
        return AT_REST, x, min(x - low, high - x), 0.0
    if v > 0.0 and high == float("inf"):
        return LEAVES, x, 0.0, 0.0
    return MOVING, x, 0.0, 0.0
