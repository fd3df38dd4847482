"""The count of an encoder with hysteresis, of all motions of a set: by how far they go between two samples.

The motions of a set have one count, that of the last turning point. Between two samples a turning point changes it for
good where it lies past an edge that the next sample is not past: so the highest and the lowest place decide.

``turns`` is a `room.TurnRoom`, or None without hysteresis: then a function does what its like in `readings` does.
Counts outside of a wall are told as one, unless each counts by itself.
"""

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.advance import FREE, UNKNOWN, next_mode, slide
from hknob_cli.engine.general.body import acceleration, norm, rate_of
from hknob_cli.engine.general.controller import command, lower_edge, read, told, upper_edge
from hknob_cli.engine.general.hysteresis import commands_of, pass_still, way_at_most
from hknob_cli.engine.general.laws.law import PIECE, SPAN, TORQUE
from hknob_cli.engine.general.laws.step import decide
from hknob_cli.engine.general.sets.memory import step_error, watched
from hknob_cli.engine.general.sets.readings import acting, count_levels, highest, lowest, next_level
from hknob_cli.engine.general.slide_many import sliding_bound
from hknob_cli.engine.general.slide_two import way

STILL = 1e-12  # of a place: what goes no farther is not followed from turning point to turning point
DOUBT = 8.0  # times the error of a place: as near to an edge a sample is read both ways
ROUNDED = 256.0  # times that a highest or lowest place is rounded more than a state after an interval
# Of a motion between two samples: its highest and lowest place, and when; its last; bounds on its velocity and on the
# rounding of its places.
HIGH, HIGH_AT, LOW, LOW_AT, LAST, SLOWEST, FASTEST, WRONG = range(8)
# Of a set: where its highest and its lowest places lie, and its last; by how much the highest is above the first and
# the last place, at most, and the lowest below them; and what of these is slight, because no sample is trusted as near
# to an edge (`ball_reach`).
TOP, ABOVE, BOTTOM, BELOW, LEAST, MOST, RISE, FALL, DROP, CLIMB, SLIGHT = range(11)
CLEAR, UP, DOWN, OPEN = range(4)  # what turning points do to a count: nothing, one thing above or below, or it is open


def is_simple(turns, law):
    """Whether the wall commands by itself, by counts without memory."""
    return turns is None and law is None


def half_of(turns, first, wall):
    """Half of the width of the hysteresis, by which edges are passed later. The first sample has no memory: 0."""
    if turns is None:
        return 0.0
    return 0.0 if first else 0.5 * wall.hysteresis


def ball_reach(turns, radius, error, body):
    """By how much places of a ball differ from its centre's where its reading is asked for.

    That no motion of a set turns is told from its corners as they are computed. True ones may be beside them by the
    error, and turn as far beyond their next place as this allows: a sample that is so near to an edge is not trusted.
    """
    if turns is None:
        return body.reach * (radius + error)
    return body.reach * (radius + DOUBT * error)


def edge_reach(turns, reach):
    """By how much a part that is cut at an edge goes beyond it, for places that are wrong by ``reach``."""
    if turns is None:
        return reach
    return DOUBT * reach


def count_of(turns, law, before, ring):
    """The count of a set at its last turning point."""
    if turns is None:
        return 0.0
    if law is None:
        return before
    return ring[law.line - 1]


def keep_count(turns, law, count, before, ring):
    """Let a set have this count: what is to be remembered beside ``ring``; ``before`` without hysteresis."""
    if turns is None:
        return before
    if law is None:
        return count
    ring[law.line - 1] = count
    return before


def level_at(turns, x, count, half, bottom, wall):
    """The reading as which ``x`` acts after a ``count``."""
    if turns is None:
        return acting(x, bottom, wall)
    return told(min(max(count, read(x - half, wall)), read(x + half, wall)), wall)


def lowest_at(turns, level, count, half, bottom, wall):
    """Lower end of the positions that act as ``level``."""
    if turns is None:
        return lowest(level, bottom, wall)
    return lower_edge(level, wall) + (half if level > count else -half)


def highest_at(turns, level, count, half, wall):
    """Upper end of the positions that act as ``level``."""
    if turns is None:
        return highest(level, wall)
    if told(level + 1.0, wall) == level:
        return float("inf")
    return upper_edge(level, wall) + (-half if level < count else half)


def next_at(turns, level, wall):
    """The reading above ``level`` that stands for the next that act alike."""
    if turns is None:
        return next_level(level, wall)
    return level + 1.0


def levels_between(turns, low, high, wall):
    """How many readings stand for all from ``low`` to ``high``."""
    if turns is None:
        return count_levels(low, high, wall)
    return int(high - low) + 1


def note(x, at, swing):
    """Take in a place of a motion."""
    if x > swing[HIGH]:
        swing[HIGH], swing[HIGH_AT] = x, at
    if x < swing[LOW]:
        swing[LOW], swing[LOW_AT] = x, at


def move_on(z, u, span, begun, moved, swing, body, pad):
    """Move ``z`` over a hold, in which it goes no farther than ``moved``, from turning point to turning point."""
    if moved <= STILL * (1.0 + abs(z[0])):
        note(z[0] + moved, begun, swing)
        note(z[0] - moved, begun, swing)
        pass_still(z, u, span, body, pad)
        return
    left = span
    mode = way(z[1], acceleration(z, u, body), 0.0)
    while left > 0.0:
        t, ended, _ = slide(z, u, mode, left, UNKNOWN, False, body, pad)
        left -= t
        note(z[0], begun + span - left, swing)
        if not ended:
            break
        mode = next_mode(mode, z, u, body)


def go_on(z, u, span, begun, swing, body, pad):
    """Move ``z`` over a hold, and take in its turning points and its end."""
    moved = way_at_most(z, u, span, body, pad)
    rate_of(z, u, FREE, body, pad)
    swing[WRONG] += norm(pad, body)
    bend = 0.125 * span * span * sliding_bound(pad, 0, body)  # of the velocity, from the line between its ends
    begin = z[1]
    move_on(z, u, span, begun, moved, swing, body, pad)
    swing[SLOWEST] = min(swing[SLOWEST], min(begin, z[1]) - bend)
    swing[FASTEST] = max(swing[FASTEST], max(begin, z[1]) + bend)


def plan_holds(turns, law, centre, wall):
    """Leave in ``turns.course`` the lengths and torques of the interval after a centre; how many there are."""
    level, ring = centre.level, centre.ring
    if law is None:
        older, later = commands_of(command(level, centre.before, wall), ring, centre.head)
        turns.course[0], turns.course[1] = wall.split, older
        turns.course[2], turns.course[3] = 1.0 - wall.split, later
        return 2
    for j in range(len(ring)):
        turns.ring[j] = ring[j]
    decide(level, 0.0, turns.ring, wall, law)
    for piece in range(law.pieces):
        turns.course[2 * piece] = law.sched[piece * PIECE + SPAN]
        turns.course[2 * piece + 1] = turns.ring[int(law.sched[piece * PIECE + TORQUE])]
    return law.pieces


def find_swing(turns, z, holds, drift, body):
    """Leave in ``turns.swing`` how far the motion from ``z`` goes over so many holds, and where it is in the end."""
    swing, at, largest = turns.swing, 0.0, 0.0
    swing[HIGH], swing[LOW], swing[HIGH_AT], swing[LOW_AT], swing[WRONG] = z[0], z[0], 0.0, 0.0, 0.0
    swing[SLOWEST], swing[FASTEST] = z[1], z[1]
    for j in range(len(z)):
        turns.z[j] = z[j]
    for k in range(holds):
        span, u = turns.course[2 * k], turns.course[2 * k + 1]
        largest = max(largest, abs(u))
        if span > 0.0:
            go_on(turns.z, u, span, at, swing, body, turns.pad)
            at += span
    swing[LAST] = turns.z[0]
    swing[WRONG] = body.reach * ROUNDED * (step_error(z, largest, largest, drift, body) + drift.coast * swing[WRONG])
    swing[WRONG] += 8.0 * EPSILON * (abs(swing[HIGH]) + abs(swing[LOW]))


def stays_up(highest_place, last, count, half, wall):
    """Whether no edge above ``count`` lies between the next sample and the highest place, if that is so high."""
    return told(read(highest_place - half, wall), wall) <= max(count, told(read(last - half, wall), wall))


def stays_down(lowest_place, last, count, half, wall):
    """The same of edges below it, down to the lowest place."""
    return told(read(lowest_place + half, wall), wall) >= min(count, told(read(last + half, wall), wall))


def turned_count(count, bounds, peaks, dips, wall):
    """What turning points do to a ``count``: ``(what, count then)``, `OPEN` where it is not one thing.

    ``bounds``: `TOP` to `MOST`, with room for roundings; ``peaks``, ``dips``: whether any motion of the set has a
    highest place, or a lowest, that is neither its first nor its last.
    """
    half, least, most = 0.5 * wall.hysteresis, bounds[LEAST], bounds[MOST]
    up = not peaks or stays_up(bounds[TOP], least, count, half, wall)
    if up and (not dips or stays_down(bounds[BOTTOM], most, count, half, wall)):
        return CLEAR, count
    above, below = told(read(bounds[ABOVE] - half, wall), wall), told(read(bounds[BELOW] + half, wall), wall)
    one_above = above > count and told(read(bounds[TOP] - half, wall), wall) == above
    if peaks and one_above and (not dips or stays_down(bounds[BOTTOM], most, above, half, wall)):
        return UP, above
    one_below = below < count and told(read(bounds[BOTTOM] + half, wall), wall) == below
    if dips and one_below and (not peaks or stays_up(bounds[TOP], least, below, half, wall)):
        return DOWN, below
    return OPEN, count


def peek(centre, reach, cell):
    """The count before the next sample of all states within ``reach`` of a centre: ``(whether it is one, count)``.

    Nothing moves. Its level is the reading as which all act now, which is their count.
    """
    drift, known, body, wall = cell.drift, cell.known, cell.body, cell.wall
    turns = known.turns
    if turns is None:
        return True, 0.0
    level, swing, bounds = centre.level, turns.swing, turns.bounds
    holds = plan_holds(turns, known.law, centre, wall)
    find_swing(turns, centre.z, holds, drift, body)
    room = body.reach * reach + swing[WRONG]
    if swing[SLOWEST] > room / body.reach or swing[FASTEST] < -room / body.reach:
        return True, level  # none of them turns
    bounds[TOP], bounds[ABOVE] = swing[HIGH] + room, swing[HIGH] - room
    bounds[BOTTOM], bounds[BELOW] = swing[LOW] - room, swing[LOW] + room
    bounds[LEAST], bounds[MOST] = swing[LAST] - room, swing[LAST] + room
    what, count = turned_count(level, bounds, True, True, watched(known.law, wall))
    return what != OPEN, count
