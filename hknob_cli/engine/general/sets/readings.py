"""Which positions act alike: those with one reading, as far as readings make a difference to what is commanded.

Outside the wall all readings act alike, unless virtual damping differences them. Deeper than ``bottom`` the amplifier
is saturated, and all act alike again. Elsewhere each count acts by itself. Under a torque over the angle the counts of
a run act alike, one of which stands for them all.
"""

from hknob_cli.engine.general.controller import command, lower_edge, read, upper_edge
from hknob_cli.engine.general.torque_table import is_there, run_at


def deepest_level(wall):
    """The least deep reading at which the amplifier is saturated by position alone; minus infinity without one.

    Below a dead band nothing is saturated; where there is one, each count acts by itself. A torque over the angle may
    be less again farther on.
    """
    if not wall.limit < float("inf") or wall.damping > 0.0 or wall.band > 0.0 or not wall.kappa > 0.0:
        return -float("inf")
    if is_there(wall.table):
        return -float("inf")
    level = min(-1.0, -(wall.limit / wall.kappa + wall.offset) // 1.0 + 3.0)
    while command(level, level, wall) < wall.limit:
        level -= 1.0
    return level


def by_runs(wall):
    """Whether the counts of a run act alike: under a torque over the angle, where nothing differences them."""
    return is_there(wall.table) and not wall.damping > 0.0


def acting(x, bottom, wall):
    """The reading that stands for all that act as the one at ``x`` does; it never falls where ``x`` rises."""
    shown = read(x, wall)
    if wall.damping > 0.0:
        return shown
    if is_there(wall.table):
        low, high = run_at(shown, wall.table)
        if low > -float("inf"):
            return low
        return high if high < float("inf") else 0.0
    if shown > 0.0:
        return 0.0
    return max(shown, bottom)


def lowest(level, bottom, wall):
    """Lower end of the positions that act as ``level``."""
    if by_runs(wall):
        return lower_edge(run_at(level, wall.table)[0], wall)
    if level <= bottom:
        return -float("inf")
    return lower_edge(level, wall)


def highest(level, wall):
    """Upper end of the positions that act as ``level``."""
    if by_runs(wall):
        return upper_edge(run_at(level, wall.table)[1], wall)
    if wall.damping == 0.0 and level >= 0.0:
        return float("inf")
    return upper_edge(level, wall)


def next_level(level, wall):
    """The reading above ``level`` that stands for the next that act alike; infinite above a run that does not end."""
    if by_runs(wall):
        return run_at(level, wall.table)[1] + 1.0
    return level + 1.0


def count_levels(low, high, wall):
    """How many readings stand for all from ``low`` to ``high``, which are two of them."""
    if not by_runs(wall):
        return int(high - low) + 1
    count = 1
    while low < high:
        low = next_level(low, wall)
        count += 1
    return count


def steps_deeper(level, last, wall):
    """Whether a sample acts as a reading below the last one's, inside the wall or under a torque over the angle."""
    return level < last and (level < 0.0 or is_there(wall.table))


def remembered(level, wall):
    """What of a reading is needed at the next sample: all of it with virtual damping or hysteresis, else nothing."""
    return level if wall.damping > 0.0 or wall.hysteresis > 0.0 else 0.0
