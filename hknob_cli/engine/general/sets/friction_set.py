"""A set of states with friction on its way through an interval: how it is kept, while it waits.

With its place in the interval, its centre and its corners it has what its states have in common there: a torque that
lags, the count behind hysteresis, and what a law has read at its looks.
"""

from hknob_cli.engine.general.sets.convex import MOST_CORNERS, area_of
from hknob_cli.engine.general.sets.friction_step import MOST_CUTS

# Numbers of a set within an interval.
PART, CUTS, LATE, APART, DEPTH, SHOWN, TOLD, SIDE, X, V, WEIGHT, COUNT, CORNERS = range(13)
# Of these, with a lag: the torque that acts, by which those of its states may differ from it, and halvings of the part
# of a hold that is to be tried next. With hysteresis: the count at the last stop, the part in which it has been told
# last, counted from 1, and whether only stops of what begins by moving up (1), or down (-1), are to be told in it.
ACTS = 6
MOST = MOST_CORNERS + 2 + MOST_CUTS + 2  # corners of one
SET = CORNERS + 2 * MOST  # numbers of one; then the readings of its looks into the interval so far
SETS = 256  # of one piece within an interval, at most
SETS_LOOKED = 2048  # the same where it is cut within the interval, too
# Numbers of a part of an interval: which of the torques acts, the plant, and which look is at its end, or -1.
TORQUE, SPAN, S, G, F, LOOK = range(6)
LEG = 6
LEAST_PART = 1e-30  # of an area: an end that any state reaches has a share
LEAST_WEIGHT = 1e-300  # of what is followed, or waits: products of such shares would round to none


def part_weight(weight, whole, corners, count, body):
    """Measure of the starts of a part of a set with this ``weight`` and the area ``whole``; or a bound on it.

    Without friction the differences of all states go by one matrix, which keeps ratios of areas.
    """
    if body.friction > 0.0 or not whole > 0.0:
        return weight
    return max(weight * min(max(area_of(corners, count) / whole, LEAST_PART), 1.0), LEAST_WEIGHT)


def begin_set(work, at, place, cuts, corners, count):
    """Enter a set that is cut so often in its part of an interval, and has read ``work.seen``.

    ``place``: how many parts of the interval it has passed, its centre's position and velocity, and its weight. With
    a lag the parts may end in a fraction. ``work.acts`` has the torque that acts, and the count.
    """
    looks = len(work.seen)
    base = at * (SET + looks)
    work.sets[base + PART], work.sets[base + X], work.sets[base + V], work.sets[base + WEIGHT] = place
    work.sets[base + CUTS], work.sets[base + COUNT] = float(cuts), float(count)
    for k in range(ACTS):
        work.sets[base + LATE + k] = work.acts[k]
    for k in range(2 * count):
        work.sets[base + CORNERS + k] = corners[k]
    for k in range(looks):
        work.sets[base + SET + k] = work.seen[k]


def take_set(work, at):
    """Leave in ``work`` the set that waits at this place: its place in the interval, how often it is cut, corners."""
    base = at * (SET + len(work.seen))
    count = int(work.sets[base + COUNT])
    for k in range(ACTS):
        work.acts[k] = work.sets[base + LATE + k]
    for k in range(2 * count):
        work.corners[k] = work.sets[base + CORNERS + k]
    for k in range(len(work.seen)):
        work.seen[k] = work.sets[base + SET + k]
    place = work.sets[base + PART], work.sets[base + X], work.sets[base + V], work.sets[base + WEIGHT]
    return place, int(work.sets[base + CUTS]), count


def room_for_sets(work):
    """How many sets may wait within an interval."""
    return len(work.sets) // (SET + len(work.seen))
