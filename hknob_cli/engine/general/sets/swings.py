"""How far all motions of a set go between two samples, from the corners of a polygon, or the ends of a chord.

The highest place of a motion between two samples is convex in its first state, because at any one time a place is
affine in it; the lowest is concave. So over a polygon the highest place is at most what lies between those of its
corners, and at least the place that each state has when some state is highest.
"""

from hknob_cli.engine.general.controller import read, told
from hknob_cli.engine.general.hysteresis import pass_still
from hknob_cli.engine.general.sets.turns import (
    ABOVE,
    BELOW,
    BOTTOM,
    CLIMB,
    DROP,
    FALL,
    HIGH,
    HIGH_AT,
    LAST,
    LEAST,
    LOW,
    LOW_AT,
    MOST,
    OPEN,
    RISE,
    SLIGHT,
    TOP,
    WRONG,
    find_swing,
    stays_down,
    stays_up,
    turned_count,
)
from hknob_cli.engine.general.slide_two import coefficients

PLACES = 5  # of a corner


def place_at(turns, z, time, holds, body):
    """Place of the motion from ``z`` after a part of an interval of so many holds."""
    for j in range(len(z)):
        turns.z[j] = z[j]
    for k in range(holds):
        span, u = min(turns.course[2 * k], time), turns.course[2 * k + 1]
        time -= span
        if span > 0.0 and body.order > 2:
            pass_still(turns.z, u, span, body, turns.pad)
        elif span > 0.0:
            s, g, f = coefficients(span, body)
            y = u + body.drive - body.beta * turns.z[0]
            turns.z[0], turns.z[1] = turns.z[0] + (s * turns.z[1] + g * y), f * turns.z[1] + s * y
    return turns.z[0]


def measure_swings(turns, z, corners, count, holds, reach, drift, body):
    """Enter to ``turns.places`` how far each corner goes over an interval, and bounds on all, to ``turns.bounds``.

    Of each corner: its highest place, that at the time when their middle is highest, its lowest, that when their middle
    is lowest, and its last. ``reach``: by which states may truly lie elsewhere, in position. Returns the room that all
    bounds have.
    """
    n = len(z)
    for j in range(n):
        turns.other[j] = z[j]
    for k in range(count):
        for j in range(n):
            turns.other[j] += corners[k * n + j] / count
    find_swing(turns, turns.other, holds, drift, body)
    up, down, wrong = turns.swing[HIGH_AT], turns.swing[LOW_AT], turns.swing[WRONG]
    bounds = turns.bounds
    for k in range(count):
        for j in range(n):
            turns.other[j] = z[j] + corners[k * n + j]
        find_swing(turns, turns.other, holds, drift, body)
        wrong = max(wrong, turns.swing[WRONG])
        last = turns.swing[LAST]
        one = turns.swing[HIGH], place_at(turns, turns.other, up, holds, body)
        other = turns.swing[LOW], place_at(turns, turns.other, down, holds, body)
        turns.places[PLACES * k], turns.places[PLACES * k + 1] = one
        turns.places[PLACES * k + 2], turns.places[PLACES * k + 3] = other
        turns.places[PLACES * k + 4] = last
        if k == 0:
            bounds[TOP], bounds[ABOVE] = one
            bounds[BOTTOM], bounds[BELOW] = other
            bounds[LEAST], bounds[MOST] = last, last
            bounds[RISE], bounds[FALL], bounds[DROP], bounds[CLIMB] = 0.0, 0.0, 0.0, 0.0
        bounds[TOP], bounds[ABOVE] = max(bounds[TOP], one[0]), min(bounds[ABOVE], one[1])
        bounds[BOTTOM], bounds[BELOW] = min(bounds[BOTTOM], other[0]), max(bounds[BELOW], other[1])
        bounds[LEAST], bounds[MOST] = min(bounds[LEAST], last), max(bounds[MOST], last)
        bounds[RISE] = max(bounds[RISE], one[0] - turns.other[0])
        bounds[FALL] = max(bounds[FALL], one[0] - last)
        bounds[DROP] = max(bounds[DROP], turns.other[0] - other[0])
        bounds[CLIMB] = max(bounds[CLIMB], last - other[0])
    room = reach + 4.0 * wrong
    bounds[SLIGHT] = 0.25 * reach
    bounds[TOP] += room
    bounds[ABOVE] -= room
    bounds[BOTTOM] -= room
    bounds[BELOW] += room
    bounds[LEAST] -= room
    bounds[MOST] += room
    return room


def turns_within(turns, way, z, corners, count, holds, drift, body):
    """Whether any state has a highest place (``way`` 1) or a lowest (-1) that is neither its first nor its last.

    By how much it is above either is convex: where one of them is slight at all corners it is everywhere.
    """
    from_first, from_last, n = 0.0, 0.0, len(z)
    for k in range(count):
        for j in range(n):
            turns.other[j] = z[j] + corners[k * n + j]
        find_swing(turns, turns.other, holds, drift, body)
        far = turns.swing[HIGH] if way > 0 else turns.swing[LOW]
        from_first = max(from_first, abs(far - turns.other[0]))
        from_last = max(from_last, abs(far - turns.swing[LAST]))
    return min(from_first, from_last) > turns.bounds[SLIGHT]


def plan_parts(turns, level, wall):
    """By what a set is cut that acts as ``level``: ``(way, first count, last count)``.

    ``way`` 1: by its highest places, -1: by its lowest; 0: not at all, and each of these counts is that of all of it.
    """
    bounds, half = turns.bounds, 0.5 * wall.hysteresis
    # Each is convex: where it is slight at all corners it is everywhere.
    slight = bounds[SLIGHT]
    peaks, dips = min(bounds[RISE], bounds[FALL]) > slight, min(bounds[DROP], bounds[CLIMB]) > slight
    what, count = turned_count(level, bounds, peaks, dips, wall)
    if what != OPEN:
        return 0, count, count
    first, last = told(read(bounds[ABOVE] - half, wall), wall), told(read(bounds[TOP] - half, wall), wall)
    first, last = max(level, first), max(level, last)
    if peaks and (not dips or stays_down(bounds[BOTTOM], bounds[MOST], last, half, wall)):
        return 1, first, last
    low, high = told(read(bounds[BOTTOM] + half, wall), wall), told(read(bounds[BELOW] + half, wall), wall)
    low, high = min(level, low), min(level, high)
    if dips and (not peaks or stays_up(bounds[TOP], bounds[LEAST], low, half, wall)):
        return -1, low, high
    return 0, low, last
