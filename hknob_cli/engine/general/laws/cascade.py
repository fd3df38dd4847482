"""How far two motions with the same readings part: in what is counted, in what fades, and in the plant."""

from math import inf

from hknob_cli.engine.general.body import distance


def same_count(past, other, law):
    """Whether all that is remembered is the same, but for what fades or drifts and the torques under way."""
    for j in range(law.line):
        if j != law.fading and j != law.drifts and past[j] != other[j]:
            return False
    return True


def nearly_same(past, other, law, within):
    """Whether all that is remembered differs by at most ``within``, relatively, but for what drifts."""
    for j in range(law.line):
        if j != law.drifts and not abs(past[j] - other[j]) <= within * (1.0 + abs(other[j])):
            return False
    return True


def faded(past, other, law):
    """Difference of two motions in the row that fades."""
    return abs(past[law.fading] - other[law.fading]) if law.fading >= 0 else 0.0


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


def pushed_apart(total, body):
    """Bound on the distance in position to which torques that differ by ``total`` in all can push two motions."""
    if total == 0.0:
        return 0.0
    if body.order == 2 and body.beta == 0.0 and body.friction == 0.0:
        return total / body.alpha if body.alpha > 0.0 else inf
    return body.reach * total


def apart(dz, past, other, body, law):
    """Bound on how far apart in position two motions with the same readings get, by differences ``dz`` and memory."""
    return distance(dz, body) + pushed_apart(torques_apart(past, other, law), body)
