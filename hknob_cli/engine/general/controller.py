"""The controller: from the angle at a sample to the torque commanded, as an acceleration of the knob.

In this order: the encoder's count, the virtual wall with its damping on the differenced measured angle, the step of the
D/A converter, the saturation of the amplifier. Units are those of `engine.loop`: counts and sample periods.
"""

from typing import NamedTuple

from hknob_cli.engine.loop import floor


class Controller(NamedTuple):
    """The wall as programmed and driven; every field is a float, 0 (``limit``: infinite) where it does not exist."""

    kappa: float  # virtual stiffness, K T^2 / J
    damping: float  # virtual damping on the difference of two samples, B T / J
    sense: float  # +1: a level holds its lower edge (floor); -1: its upper edge (ceil)
    truncate: float  # 1: outside the wall the encoder rounds down all the same
    offset: float  # the angle an encoder level reports, less the level, in counts
    analog: float  # 1: a continuous sensor, without counts
    step: float  # D/A step
    limit: float  # saturation
    split: float  # part of an interval that still runs under the older command


def read(x, wall):
    """What the sensor shows at ``x``: its count, or ``x`` itself."""
    if wall.analog > 0.0:
        return x
    if wall.truncate > 0.0 and x > 0.0:
        return floor(x)
    return wall.sense * floor(wall.sense * x)


def command(shown, before, wall):
    """Command when the sensor shows ``shown``, and showed ``before`` one sample ago: the wall, D/A, amplifier."""
    if not shown < 0.0:
        return 0.0
    u = -wall.kappa * (shown + wall.offset)
    if wall.damping > 0.0:
        u -= wall.damping * (shown - before)
    if wall.step > 0.0:
        u = wall.step * floor(u / wall.step + 0.5)
    return min(wall.limit, max(-wall.limit, u))


def slopes(shown, before, wall):
    """Derivatives of the command by ``shown`` and by ``before``: zero but for a continuous sensor."""
    if wall.analog == 0.0 or not shown < 0.0 or wall.step > 0.0:
        return 0.0, 0.0
    u = -wall.kappa * (shown + wall.offset) - wall.damping * (shown - before)
    if abs(u) >= wall.limit:
        return 0.0, 0.0
    return -wall.kappa - wall.damping, wall.damping


def inside(shown):
    """How deep inside the wall, as a level that is compared from sample to sample."""
    return shown if shown < 0.0 else 0.0


def edge_gap(x, shown, before, wall):
    """How far ``x``, and ``before``, may move until the command, or its slope, changes, in counts."""
    if wall.analog > 0.0:
        gap = abs(x)
        slope = wall.kappa + 2.0 * wall.damping
        if shown < 0.0 and slope > 0.0:
            u = -wall.kappa * shown - wall.damping * (shown - before)
            gap = min(gap, abs(abs(u) - wall.limit) / slope)
            if wall.step > 0.0:
                part = (u / wall.step + 0.5) % 1.0
                gap = min(gap, min(part, 1.0 - part) * wall.step / slope)
        return gap
    if not shown < 0.0 and wall.damping == 0.0:
        return x if wall.sense > 0.0 else x + 1.0
    low = shown if wall.sense > 0.0 else shown - 1.0
    high = low + 1.0
    if wall.truncate > 0.0 and not shown < 0.0:
        low = shown if shown > 0.0 else -1.0
        high = shown + 1.0
    return min(x - low, high - x)


def count_gap(x, wall):
    """Distance from ``x`` to the nearest count edge; to the wall's edge without an encoder."""
    if wall.analog > 0.0:
        return abs(x)
    part = x % 1.0
    return min(part, 1.0 - part)
