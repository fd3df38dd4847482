"""Pieces of angle and speed beside cogging, with friction or without: moved over one interval.

A piece is as in `piece`. Its corners go by the derivative along its centre (`cog_arc.roll_arc`), and it is widened by
all that this leaves out: of the square of its size where its states pass a corner of cogging or stop. Where friction
does not do alike to all of them no state gets farther from the centre than its size, which grows by cogging alone: the
piece is round then. A piece that loses much so is halved first, unless it is small.
"""

from math import cos, inf, pi
from typing import Any, NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.cogging import ROUNDINGS, SLOPE, pull_on, slope_at, unit_reach
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.cog_arc import roll_arc
from hknob_cli.engine.general.sets.cog_fold import cross_rubbing, size_of_piece
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, drop_edge, extent, keep_side, widen
from hknob_cli.engine.general.sets.friction_arc import BALL, BESIDE, ERROR, STANDS
from hknob_cli.engine.general.sets.friction_piece import TINY, stands
from hknob_cli.engine.general.sets.memory import command_all
from hknob_cli.engine.general.sets.piece import put
from hknob_cli.engine.general.sets.readings import remembered

TORQUE, SPAN, _LOOK = range(3)  # numbers of a hold, as `friction_arcs` has them
HOLD = 3
BLUR = 256.0 * EPSILON  # of a piece's size: what cutting, moving and widening it rounds over an interval
ROUND = 8  # corners of a piece that is round
AROUND = 1.0 / cos(pi / ROUND) * (1.0 + 1e-9)  # how far they are from the middle of a ball of 1
SIDES = (1.0, 0.7071067811865476, 0.0, -0.7071067811865476, -1.0, -0.7071067811865476, 0.0, 0.7071067811865476)
LOOSE = 0.25  # of the knob's damping over a hold: a piece that is widened by more, as a part of its size, is halved
FOLD = 1e-3  # of a piece's size: a larger error of the centre is taken into the piece


def put_round(corners, radius, flat, body):
    """Let a piece be around a ball of ``radius``, by `cogging.size_at`; its corners. ``flat``: all of it stands."""
    reach = unit_reach(body) * (1.0 + 1e-12)
    if flat:
        corners[0], corners[1], corners[2], corners[3] = -reach * radius, 0.0, reach * radius, 0.0
        return 2
    for k in range(ROUND):
        corners[2 * k] = reach * radius * AROUND * SIDES[k]
        corners[2 * k + 1] = radius * AROUND * SIDES[(k + 6) % ROUND]
    return ROUND


def take_in_error(centre, room, count, radius, body):
    """Take the error of a centre into its piece, in ``room.corners``, if it is more than little of it.

    ``(error, corners)`` then.
    """
    if not centre.error > FOLD * radius:
        return centre.error, count
    more = centre.error * (1.0 + 1e-12)
    flat = stands(centre.z[1], room.corners, count)
    for k in range(2 * count):
        room.moved[k] = room.corners[k]
    count = widen(room.moved, count, unit_reach(body) * more, 0.0 if flat else more, room.parts)
    for k in range(2 * count):
        room.corners[k] = room.moved[k]
    return 8.0 * EPSILON * (more + radius), count


class Folds(NamedTuple):
    """Work space for corners; ``kept``: those of a piece as a hold begins."""

    one: Any
    other: Any
    points: Any
    kept: Any


def speed_bounds(z, corners, count, u, span, error, body):
    """Bounds on places and speeds of a piece's states after a hold: ``(low x, high x, low v, high v)``.

    By the most that acts on the knob beside damping, where it may be: an upward speed rises by no more than that less
    friction allows, and none crosses 0 where friction is stronger.
    """
    cogs, reach = body.cogs, unit_reach(body)
    low_x, high_x, low, high = extent(corners, count)
    low_x, high_x = z[0] + low_x - reach * error, z[0] + high_x + reach * error
    low, high = z[1] + low - error, z[1] + high + error
    stiff, middle = body.beta + cogs[SLOPE], 0.5 * (low_x + high_x)
    slope = slope_at(middle, cogs)
    here = body.drive + u - body.beta * middle + pull_on(middle, slope, cogs)
    # The most speed in the hold is at most v with v = most + span (|here| + stiff (wide + span v) + friction).
    wide, share = 0.5 * (high_x - low_x), 1.0 - stiff * span * span
    if not share > 0.5:
        return -inf, inf, -inf, inf
    most = max(abs(low), abs(high)) + span * (abs(here) + stiff * wide + body.friction)
    half = (wide + span * most / share) * (1.0 + 1e-9)
    slack = ROUNDINGS * EPSILON * (abs(u) + abs(body.drive) + body.beta * abs(middle) + stiff * half)
    push, pull = here + stiff * half + slack, here - stiff * half - slack
    top = max(high, 0.0) + (push - body.friction) * span
    bottom = min(low, 0.0) + (pull + body.friction) * span
    top, bottom = max(top, 0.0), min(bottom, 0.0)
    return low_x + span * min(low, bottom, 0.0), high_x + span * max(high, top, 0.0), bottom, top


def clip_piece(z, corners, count, bounds, error, folds, body):
    """What of a piece is within bounds on places and speeds of its states: ``(corners, whether all stand)``."""
    low_x, high_x, low, high = bounds
    if low == 0.0 and high == 0.0:
        least, most, _, _ = extent(corners, count)
        more = unit_reach(body) * error
        least, most = max(least, low_x - z[0] - more), min(most, high_x - z[0] + more)
        z[1] = 0.0
        corners[0], corners[1], corners[2], corners[3] = min(least, most), 0.0, max(least, most), 0.0
        return 2, True
    sides = (
        (1.0, 0.0, low_x - z[0] - unit_reach(body) * error),
        (-1.0, 0.0, z[0] - high_x - unit_reach(body) * error),
        (0.0, 1.0, low - z[1] - error),
        (0.0, -1.0, z[1] - high - error),
    )
    for k in range(4):
        a, b, c = sides[k]
        if c > -inf:
            kept = keep_side(corners, count, a, b, c, folds.one)
            if kept > 0:
                count = kept
                for j in range(2 * kept):
                    corners[j] = folds.one[j]
    return count, False


def cross_hold(rub, folds, corners, count, u, span, drift, body):
    """Move a piece, whose centre is ``rub.z``, over a hold: ``(corners, loose)``; ``loose``: by what part it grew more.

    ``rub.arc`` has the error of its centre.
    """
    arc, z, reach = rub.arc, rub.z, unit_reach(body)
    stood = stands(z[1], corners, count)
    radius = size_of_piece(corners, count, body)
    bounded, bounds = body.friction > 0.0 and not stood, (0.0, 0.0, 0.0, 0.0)
    if bounded:
        bounds = speed_bounds(z, corners, count, u, span, arc[ERROR], body)
        error, begun = arc[ERROR], count
        copy_to(rub.own_z, z)
        for k in range(2 * count):
            folds.kept[k] = corners[k]
        told, flat, count = cross_rubbing(rub, folds, corners, count, u, span, drift, body)
        if told:
            if not flat and stands(z[1], corners, count):
                count = widen(corners, count, 0.0, TINY + EPSILON * abs(z[1]), folds.points)
            arc[ERROR] += BLUR * (size_of_piece(corners, count, body) + radius)
            return count, arc[BESIDE] / radius
        arc[ERROR], count = error, begun
        copy_to(z, rub.own_z)
        for k in range(2 * count):
            corners[k] = folds.kept[k]
    arc[BALL], arc[BESIDE], arc[STANDS] = radius, 0.0, 1.0 if stood else 0.0
    columns = rub.columns
    columns[0], columns[1] = 0.0, 0.0
    columns[2], columns[3] = radius * reach, 0.0
    columns[4], columns[5] = 0.0, radius
    alike = roll_arc(rub, z, u, span, drift, body)
    flat = arc[STANDS] > 0.0 and z[1] == 0.0
    if not alike or arc[BESIDE] == 0.0:
        loose = 1.0
        count = put_round(corners, arc[BALL], flat, body)
        if bounded and not flat:
            count, flat = clip_piece(z, corners, count, bounds, arc[ERROR], folds, body)
    else:
        for k in range(count):
            a, b = corners[2 * k] / (radius * reach), corners[2 * k + 1] / radius
            corners[2 * k] = a * columns[2] + b * columns[4]
            corners[2 * k + 1] = 0.0 if flat else a * columns[3] + b * columns[5]
        loose = arc[BESIDE] / radius
        count = widen(corners, count, reach * arc[BESIDE], 0.0 if flat else arc[BESIDE], folds.points)
    if not flat and stands(z[1], corners, count):
        count = widen(corners, count, 0.0, TINY + EPSILON * abs(z[1]), folds.points)
    arc[ERROR] += BLUR * size_of_piece(corners, count, body)
    return count, loose


def halve_piece(room, corners, count, body):
    """Cut a piece in two across where it is longest: corners of both, in ``room.halves`` and ``room.parts``."""
    cx, cv = 0.0, 0.0
    for k in range(count):
        cx += corners[2 * k] / count
        cv += corners[2 * k + 1] / count
    stiff, far, best = 1.0 / unit_reach(body) ** 2, -1.0, 0
    for k in range(count):
        dx, dv = corners[2 * k] - cx, corners[2 * k + 1] - cv
        length = stiff * dx * dx + dv * dv
        if length > far:
            far, best = length, k
    a, b = stiff * (corners[2 * best] - cx), corners[2 * best + 1] - cv
    c = a * cx + b * cv
    one = keep_side(corners, count, a, b, c, room.halves)
    return one, keep_side(corners, count, -a, -b, -c, room.parts)


def move_piece(room, rub, folds, waiting, centre, count, size_told, cell):
    """Move the piece in ``room.corners`` over an interval and let it wait: how many do then, -1: no room.

    It acts as its level. Its centre is left alone. ``size_told``: whether it is small, and whether
    it has lasted so long that it is halved; one that is not small is halved, too, where too much would be lost.
    """
    drift, body, law = cell.drift, cell.body, cell.known.law
    small, lasts = size_told
    z, ring, delay, size = centre.z, centre.ring, len(centre.ring), len(room.own)
    if (waiting + 2) * size > len(room.stack):
        return -1
    for j in range(delay):
        rub.ring[j] = ring[(centre.head + j) % delay]
    head, _ = command_all(law, centre.level, centre.before, rub.ring, cell.wall, rub.torques)
    for j in range(len(z)):
        rub.z[j] = z[j]
    for k in range(2 * count):
        room.moved[k] = room.corners[k]
    kept = count
    rub.arc[ERROR] = centre.error
    for at in range(0, len(rub.course), HOLD):
        u, span = rub.torques[int(rub.course[at + TORQUE])], rub.course[at + SPAN]
        kept, loose = cross_hold(rub, folds, room.moved, kept, u, span, drift, body)
        if (lasts or loose > LOOSE * body.alpha * span) and not small:
            one, other = halve_piece(room, room.corners, count, body)
            if one > 0 and other > 0:
                sample = centre.sample + 0.5
                acts = Centre(z, centre.before, ring, centre.head, centre.error, centre.level, sample, centre.weight)
                while one > MOST_CORNERS:
                    one = drop_edge(room.halves, one)
                while other > MOST_CORNERS:
                    other = drop_edge(room.parts, other)
                put(room.stack, waiting * size, acts, room.halves, one, room.middle, drift, 2)
                put(room.stack, (waiting + 1) * size, acts, room.parts, other, room.middle, drift, 2)
                return waiting + 2
    while kept > MOST_CORNERS:
        kept = drop_edge(room.moved, kept)
    before = remembered(centre.level, cell.wall)
    end = Centre(rub.z, before, rub.ring, head, rub.arc[ERROR], centre.level, centre.sample + 1.0, centre.weight)
    put(room.stack, waiting * size, end, room.moved, kept, room.middle, drift, 2)
    return waiting + 1
