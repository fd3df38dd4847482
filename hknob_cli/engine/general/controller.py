"""The controller: from the angle at a sample to the torque commanded, as an acceleration of the knob.

In this order: the encoder's count, the virtual wall and the torque over the angle, the wall's damping on the
differenced measured angle, the dead band, the step of the D/A converter, the saturation of the amplifier. Units are
those of `engine.loop`: counts and sample periods.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.general.torque_curve import bend_of, curve_at, curve_torque, has_curve, rounded_size
from hknob_cli.engine.general.torque_table import command_at, is_there, run_at
from hknob_cli.engine.loop import floor


class Controller(NamedTuple):
    """The wall as programmed and driven; every number is a float, 0 (``limit``: infinite) where it does not exist."""

    kappa: float  # virtual stiffness, K T^2 / J
    damping: float  # virtual damping on the difference of two samples, B T / J
    sense: float  # +1: a level holds its lower edge (floor); -1: its upper edge (ceil)
    truncate: float  # 1: outside the wall the encoder rounds down all the same
    offset: float  # the angle an encoder level reports, less the level, in counts
    analog: float  # 1: a continuous sensor, without counts
    step: float  # D/A step
    limit: float  # saturation
    split: float  # part of an interval that still runs under the older command
    table: Any = None  # torque over the angle, wall included, as `torque_table` has it: list or array
    band: float = 0.0  # a smaller torque is not sent
    hysteresis: float = 0.0  # counts by which the knob turns back until the count does
    clock: Any = None  # of jittering samples, as `interval` has it: list or array
    curve: Any = None  # torque over the angle beside the wall, of a continuous sensor, as `torque_curve` has it


def read(x, wall):
    """What the sensor shows at ``x``: its count, or ``x`` itself."""
    if wall.analog > 0.0:
        return x
    if wall.truncate > 0.0 and x > 0.0:
        return floor(x)
    return wall.sense * floor(wall.sense * x)


def read_after(x, before, wall):
    """What the sensor shows at ``x`` after ``before``: with hysteresis the count stays until ``x`` is far enough.

    Every edge of the way up lies half the width above that of the way down. ``before`` is the count at the last turning
    point, or anywhere on the way from there. The angle behind a slack of that width, counted, is the same (the play of
    Krasnosel'skii & Pokrovskii 1989, whose count is a sum of relays).
    """
    if wall.hysteresis == 0.0:
        return read(x, wall)
    half = 0.5 * wall.hysteresis
    return min(max(before, read(x - half, wall)), read(x + half, wall))


def round_to_step(u, step):
    """What the D/A converter makes of a torque."""
    return step * floor(u / step + 0.5)


def send(u, wall):
    """What is sent of a torque: nothing in the dead band; then the steps of the D/A converter, and the amplifier."""
    if abs(u) < wall.band:
        u = 0.0
    if wall.step > 0.0:
        u = round_to_step(u, wall.step)
    return min(wall.limit, max(-wall.limit, u))


def command(shown, before, wall):
    """Command when the sensor shows ``shown``, and showed ``before`` one sample ago: the wall, D/A, amplifier."""
    if is_there(wall.table):
        u = command_at(shown, wall.table)
    elif has_curve(wall.curve):
        u = curve_torque(shown, wall.curve)
        if shown < 0.0:
            u -= wall.kappa * shown
    elif not shown < 0.0:
        return 0.0
    else:
        u = -wall.kappa * (shown + wall.offset)
    if wall.damping > 0.0 and shown < 0.0:
        u -= wall.damping * (shown - before)
    return send(u, wall)


def curve_wanted(shown, before, wall):
    """Torque over the angle and of the wall, before the D/A converter, by a curve.

    ``(torque, slope, room, steepest, damping)``: the room ends at the wall's edge, too, and the slopes are the wall's
    and the curve's; ``damping``: the wall's virtual damping where it acts.
    """
    u, slope, room, steepest, _ = curve_at(shown, wall.curve)
    if wall.kappa + wall.damping > 0.0:
        room = min(room, abs(shown))
    if not shown < 0.0:
        return u, slope, room, steepest, 0.0
    u -= wall.kappa * shown + wall.damping * (shown - before)
    return u, slope - wall.kappa, room, steepest + wall.kappa, wall.damping


def is_sent(u, wall):
    """Whether the amplifier follows a torque: no step, no dead band, and not at its limit."""
    return wall.step == 0.0 and abs(u) < wall.limit and abs(u) >= wall.band


def slopes(shown, before, wall):
    """Derivatives of the command by ``shown`` and by ``before``: zero except for a continuous sensor."""
    if has_curve(wall.curve):
        u, slope, _, _, damping = curve_wanted(shown, before, wall)
        return (slope - damping, damping) if is_sent(u, wall) else (0.0, 0.0)
    if wall.analog == 0.0 or not shown < 0.0 or wall.step > 0.0:
        return 0.0, 0.0
    u = -wall.kappa * (shown + wall.offset) - wall.damping * (shown - before)
    if abs(u) >= wall.limit or abs(u) < wall.band:
        return 0.0, 0.0
    return -wall.kappa - wall.damping, wall.damping


def follows(shown, wall):
    """Whether the command follows every move of the knob: a continuous sensor on a slope, nothing saturated."""
    if has_curve(wall.curve):
        u, _, _, steepest, damping = curve_wanted(shown, shown, wall)
        return steepest + damping > 0.0 and is_sent(u, wall)
    slope, _ = slopes(shown, shown, wall)
    return slope != 0.0


def bends(wall):
    """The most by which the slope of a command changes along the angle, within the room of `edge_gap`."""
    return 0.0 if wall.step > 0.0 else bend_of(wall.curve)


def table_size(shown, wall):
    """Size of the command of a table, or a curve, for bounds on roundings; 0 for a wall, which goes by the depth."""
    if has_curve(wall.curve):
        return rounded_size(shown, wall.curve)
    return abs(command_at(shown, wall.table)) if is_there(wall.table) else 0.0


def inside(shown, wall):
    """How deep inside the wall, or in which run of a table, as a level that is compared from sample to sample."""
    if is_there(wall.table):
        return run_at(shown, wall.table)[0]
    return shown if shown < 0.0 else 0.0


def told(shown, wall):
    """The count that stands behind hysteresis for all that are told as one: those outside, if none is differenced."""
    return shown if wall.damping > 0.0 or is_there(wall.table) else min(shown, 0.0)


def depth_level(shown, wall):
    """How deep a reading is, as a level that falls on the way into the wall; a change may begin a turn of an orbit.

    With a continuous sensor the command jumps at the wall's edge, at the end of the dead band, and from step to step.
    """
    if wall.analog == 0.0:
        return inside(shown, wall)
    if not shown < 0.0:
        return 0.0
    u = -wall.kappa * shown
    if u < wall.band or wall.band + wall.step == 0.0:
        return -1.0
    return -2.0 - (floor(u / wall.step + 0.5) if wall.step > 0.0 else 0.0)


def goes_on(v, shown, wall):
    """Whether no change of command lies ahead of a knob that turns at ``v``, however far.

    Virtual damping acts below 0 at every count that is passed, on the way in and on the way out.
    """
    if wall.damping > 0.0 and (v < 0.0 or shown < 0.0):
        return False
    if has_curve(wall.curve):
        return False  # it may have more parts ahead
    if is_there(wall.table):
        low, high = run_at(shown, wall.table)
        return low == -float("inf") if v < 0.0 else high == float("inf")
    return v > 0.0 and not shown < 0.0


def lower_edge(shown, wall):
    """Position at which a count begins."""
    return shown if wall.sense > 0.0 or (wall.truncate > 0.0 and shown > 0.0) else shown - 1.0


def upper_edge(shown, wall):
    """Position at which a count ends."""
    return shown + 1.0 if wall.sense > 0.0 or (wall.truncate > 0.0 and not shown < 0.0) else shown


def sent_gap(u, slope, wall):
    """How far an angle may move, whose torque ``u`` has a slope, until what is sent has another, or jumps."""
    gap = abs(abs(u) - wall.limit) / slope
    if wall.band > 0.0:
        gap = min(gap, abs(abs(u) - wall.band) / slope)
    if wall.step > 0.0 and abs(u) >= wall.band:
        part = (u / wall.step + 0.5) % 1.0
        gap = min(gap, min(part, 1.0 - part) * wall.step / slope)
    return gap


def edge_gap(x, shown, before, wall):
    """How far ``x``, and ``before``, may move until the command, or its slope, changes, in counts.

    With hysteresis ``before`` is the count of `read_after`, and does not move.
    """
    if has_curve(wall.curve):
        u, _, gap, steepest, damping = curve_wanted(shown, before, wall)
        slope = steepest + 2.0 * damping
        return min(gap, sent_gap(u, slope, wall)) if slope > 0.0 else gap
    if wall.analog > 0.0:
        gap = abs(x)
        slope = wall.kappa + 2.0 * wall.damping
        if shown < 0.0 and slope > 0.0:
            u = -wall.kappa * shown - wall.damping * (shown - before)
            gap = min(gap, sent_gap(u, slope, wall))
        return gap
    low = high = shown
    if wall.damping == 0.0:
        if is_there(wall.table):
            low, high = run_at(shown, wall.table)
        elif not shown < 0.0:
            low, high = 0.0, float("inf")
    below = x - lower_edge(low, wall)
    above = upper_edge(high, wall) - x
    if wall.hysteresis > 0.0:
        half = 0.5 * wall.hysteresis
        # What has just been passed is an edge of that way, all others turn the count back.
        below -= half if before < low else -half
        above -= half if before > high else -half
    return min(below, above)


def count_gap(x, wall):
    """Distance from ``x`` to the nearest count edge; without an encoder to the wall's edge, or a knee of a curve."""
    if has_curve(wall.curve):
        return curve_wanted(x, x, wall)[2]
    if wall.analog > 0.0:
        return abs(x)
    part = (x - 0.5 * wall.hysteresis) % 1.0
    gap = min(part, 1.0 - part)
    if wall.hysteresis > 0.0:
        part = (x + 0.5 * wall.hysteresis) % 1.0
        gap = min(gap, part, 1.0 - part)
    return gap
