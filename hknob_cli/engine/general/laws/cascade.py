"""How far two motions with the same readings part: in what is counted, in what fades, and in the plant."""

from math import inf, sqrt

from hknob_cli.engine.general.cogging import far_around, has_cogs, reach_on
from hknob_cli.engine.general.laws.law import PAIR_ACROSS, PAIR_NORM


def same_count(past, other, law):
    """Whether all that is remembered is the same, except what fades or drifts, and the torques under way."""
    for j in range(law.line):
        moves = j == law.fading or j == law.drifts or (len(law.pair) > 0 and j == law.fading + 1)
        if not moves and past[j] != other[j]:
            return False
    return True


def nearly_same(past, other, law, within):
    """Whether all that is remembered differs by at most ``within``, relatively; what drifts does not count."""
    for j in range(law.line):
        if j != law.drifts and not abs(past[j] - other[j]) <= within * (1.0 + abs(other[j])):
            return False
    return True


def faded(past, other, law):
    """Difference of two motions in what fades: of one row, or of two by the norm in which they shrink."""
    if law.fading < 0:
        return 0.0
    first = past[law.fading] - other[law.fading]
    if len(law.pair) == 0:
        return abs(first)
    second = past[law.fading + 1] - other[law.fading + 1]
    one = law.pair[PAIR_NORM] * first + law.pair[PAIR_NORM + 1] * second
    two = law.pair[PAIR_NORM + 2] * first + law.pair[PAIR_NORM + 3] * second
    return sqrt(one * one + two * two)


def settle_faded(past, before, period, law):
    """Put what fades where a period of the same readings brings it back, from where it was ``before`` that period."""
    at = law.fading
    if at < 0:
        return
    first = past[at] - before[at]
    if len(law.pair) == 0:
        past[at] = before[at] + first / (1.0 - law.fade**period)
        return
    second = past[at + 1] - before[at + 1]
    a, b, c, d = 1.0, 0.0, 0.0, 1.0  # the pair's map over a period, by squaring
    p, q, r, s = law.pair[0], law.pair[1], law.pair[2], law.pair[3]
    left = period
    while left > 0:
        if left % 2 == 1:
            a, b, c, d = a * p + b * r, a * q + b * s, c * p + d * r, c * q + d * s
        p, q, r, s = p * p + q * r, p * q + q * s, r * p + s * r, r * q + s * s
        left = left // 2
    whole = (1.0 - a) * (1.0 - d) - b * c
    past[at] = before[at] + ((1.0 - d) * first + b * second) / whole
    past[at + 1] = before[at + 1] + (c * first + (1.0 - a) * second) / whole


def size_faded(past, law):
    """Size of what fades and, of two rows, how far a rounding of either carries in their norm: ``(size, swell)``."""
    if len(law.pair) == 0:
        return abs(past[law.fading]), 1.0
    return abs(past[law.fading]) + abs(past[law.fading + 1]), law.pair[PAIR_ACROSS]


def sums_agree(past, other, room, law):
    """Whether a sum that drifts is in two motions the same, or decides nothing in either.

    ``room``: by how much the sum of ``other`` may rise before the law acts by it, at any time to come.
    """
    if law.drifts < 0 or past[law.drifts] == other[law.drifts]:
        return True
    return past[law.drifts] - other[law.drifts] < room


def torques_apart(past, other, law):
    """Bound on the difference of the torques of two motions with the same readings, summed over all time to come."""
    total = law.weight * faded(past, other, law) / (1.0 - law.fade)
    for j in range(law.line + law.parts, law.line + law.ages * law.parts):
        total += abs(past[j] - other[j])
    return total


def pushed_apart(total, x, body):
    """Bound on the distance in position to which torques that differ by ``total`` in all can push two motions.

    ``x``: where they are, which matters beside cogging.
    """
    if total == 0.0:
        return 0.0
    if has_cogs(body.cogs):
        return reach_on(body.cogs, x, body) * total
    if body.order == 2 and body.beta == 0.0 and body.friction == 0.0:
        return total / body.alpha if body.alpha > 0.0 else inf
    return body.reach * total


def apart(dz, x, past, other, body, law):
    """Bound on how far apart in position two motions with the same readings get, by differences ``dz`` and memory.

    ``x``: where the motion is that they are compared with.
    """
    return far_around(body.cogs, dz, x, body) + pushed_apart(torques_apart(past, other, law), x, body)
