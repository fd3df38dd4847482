"""Which positions act alike: those with one reading, as far as readings make a difference to what is commanded.

Outside the wall all readings act alike, unless virtual damping differences them. Deeper than ``bottom`` the amplifier
is saturated, and all act alike again. Elsewhere each count acts by itself.
"""

from hknob_cli.engine.general.controller import command, read


def deepest_level(wall):
    """The least deep reading at which the amplifier is saturated by position alone; minus infinity without one.

    Below a dead band nothing is saturated; where there is one, each count acts by itself.
    """
    if not wall.limit < float("inf") or wall.damping > 0.0 or wall.band > 0.0 or not wall.kappa > 0.0:
        return -float("inf")
    level = min(-1.0, -(wall.limit / wall.kappa + wall.offset) // 1.0 + 3.0)
    while command(level, level, wall) < wall.limit:
        level -= 1.0
    return level


def acting(x, bottom, wall):
    """The reading that stands for all that act as the one at ``x`` does."""
    shown = read(x, wall)
    if wall.damping > 0.0:
        return shown
    if shown > 0.0:
        return 0.0
    return max(shown, bottom)


def lowest(level, bottom, wall):
    """Lower end of the positions that act as ``level``."""
    if level <= bottom:
        return -float("inf")
    if wall.sense > 0.0 or (wall.truncate > 0.0 and level > 0.0):
        return level
    return level - 1.0


def highest(level, wall):
    """Upper end of the positions that act as ``level``."""
    if wall.damping == 0.0 and level >= 0.0:
        return float("inf")
    if wall.sense > 0.0 or (wall.truncate > 0.0 and level >= 0.0):
        return level + 1.0
    return level


def remembered(level, wall):
    """What of a reading a controller needs at the next sample: all of it with virtual damping, else nothing."""
    return level if wall.damping > 0.0 else 0.0
