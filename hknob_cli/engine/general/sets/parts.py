"""Pieces cut where a sample of them meets a count edge, and with hysteresis where a turning point after it does.

A polygon is cut by bounds on the highest and lowest places of its motions (`swings`): each part holds all states whose
turning points make of the count what is told of the part.
"""

from hknob_cli.engine.general.controller import lower_edge, upper_edge
from hknob_cli.engine.general.sets.cell import acting_as
from hknob_cli.engine.general.sets.memory import watched
from hknob_cli.engine.general.sets.piece import CORNERS, clip_by, halve, move_piece, piece_size, within
from hknob_cli.engine.general.sets.swings import PLACES, measure_swings, plan_parts, turns_within
from hknob_cli.engine.general.sets.turns import (
    LEAST,
    MOST,
    SLIGHT,
    count_of,
    half_of,
    highest_at,
    levels_between,
    lowest_at,
    next_at,
    plan_holds,
)
from hknob_cli.engine.loop import floor


def cut_by_turns(turns, plan, count, level, room, corners, number, wall):
    """The part of a set whose turning points make this ``count``, to ``turns.kept``: ``(corners, whether beyond)``.

    ``plan``: as `plan_parts` has it; ``room``: by which the part goes beyond its edges. It may be beyond the part of
    those whose count stays at ``level``.
    """
    way, first, last = plan
    n = len(turns.z)
    wide, half = n + 2, 0.5 * wall.hysteresis
    farthest, meanwhile = (0, 1) if way > 0 else (2, 3)
    for k in range(number):
        for j in range(n):
            turns.kept[k * wide + j] = corners[k * n + j]
        turns.kept[k * wide + n] = turns.places[PLACES * k + farthest]
        turns.kept[k * wide + n + 1] = turns.places[PLACES * k + meanwhile]
    kept, beyond, short = number, count > first, count < last
    edge, next_edge = lower_edge(count, wall) + half, lower_edge(count + 1.0, wall) + half
    sign = 1.0
    if way < 0:
        beyond, short, sign = count < last, count > first, -1.0
        edge, next_edge = upper_edge(count, wall) - half, upper_edge(count - 1.0, wall) - half
    if way != 0 and short:
        kept = clip_by(n + 1, turns.kept, kept, next_edge + sign * room, -sign, turns.packed, 0, wide)
        for k in range(kept * wide):
            turns.kept[k] = turns.packed[k]
    if way != 0 and beyond and kept > 0:
        kept = clip_by(n, turns.kept, kept, edge - sign * room, sign, turns.packed, 0, wide)
        for k in range(kept * wide):
            turns.kept[k] = turns.packed[k]
    own = lower_edge(level + 1.0, wall) + half if way > 0 else upper_edge(level - 1.0, wall) - half
    beyond = False
    for k in range(kept):
        beyond = beyond or sign * (turns.kept[k * wide + n + 1] - own) > 0.5 * room
        for j in range(n):
            turns.kept[k * n + j] = turns.kept[k * wide + j]
    return kept, beyond


def next_edge(x, wall):
    """The next place above ``x`` at which a count changes on the way up or down, after any count."""
    half = 0.5 * wall.hysteresis
    up, down = floor(x - half) + 1.0 + half, floor(x + half) + 1.0 - half
    edge = min(up, down)
    return edge if edge > x else max(up, down)


def move_parts(room, waiting, centre, corners, number, holds, reach, cell):
    """Let the parts of a set that is measured move on, one for each count its turning points make; -1: no room.

    ``holds``: of its interval; ``reach``: by which a part goes beyond its edges, as `measure_swings` returned it.
    """
    drift, body, turns, level = cell.drift, cell.body, cell.known.turns, centre.level
    n, watch = body.order, watched(cell.known.law, cell.wall)
    plan = plan_parts(turns, level, watch)
    way, shown, last = plan
    while shown <= last:
        kept, beyond = cut_by_turns(turns, plan, shown, level, reach, corners, number, watch)
        then = shown
        other = kept > 0 and way != 0 and shown != level
        if other and not turns_within(turns, way, centre.z, turns.kept, kept, holds, drift, body):
            # None has a turning point there: their count stays, and what is not beyond is in the part of those.
            then = level
            kept = kept if beyond else 0
        if (waiting + 2) * piece_size(n, len(centre.ring)) > len(room.stack):
            return -1
        opposite = kept // 2 if kept > CORNERS else kept - 1
        if kept > 0:
            waiting = move_piece(room, waiting, centre, turns.kept, opposite + 1, then, cell)
        if kept > CORNERS:
            for k in range((kept - opposite) * n):
                turns.packed[k] = turns.kept[opposite * n + k]
            for j in range(n):
                turns.packed[(kept - opposite) * n + j] = turns.kept[j]
            waiting = move_piece(room, waiting, centre, turns.packed, kept - opposite + 1, then, cell)
        shown += 1.0
    return waiting


def move_part(room, waiting, centre, corners, count, cell):
    """As `piece.move_piece`; with hysteresis a piece for each count that turning points make; -1: no room.

    Where they do several things to a set it is taken in strips first, which read one thing at the next sample.
    """
    turns = cell.known.turns
    if turns is None:
        return move_piece(room, waiting, centre, corners, count, 0.0, cell)
    z, drift, body, law = centre.z, cell.drift, cell.body, cell.known.law
    n, watch, off = body.order, watched(law, cell.wall), body.reach * centre.error
    holds = plan_holds(turns, law, centre, cell.wall)
    reach = measure_swings(turns, z, corners, count, holds, off, drift, body)
    way, first, last = plan_parts(turns, centre.level, watch)
    if way != 0 or first == last:
        return move_parts(room, waiting, centre, corners, count, holds, reach, cell)
    wide = n + 2
    for k in range(count):
        for j in range(n):
            turns.whole[k * wide + j] = corners[k * n + j]
        turns.whole[k * wide + n] = turns.places[PLACES * k + 4]
        turns.whole[k * wide + n + 1] = turns.places[PLACES * k + 4] - (z[0] + corners[k * n])
    low, end, side = turns.bounds[LEAST], turns.bounds[MOST], 1.0
    slight = turns.bounds[SLIGHT]
    while low < end and waiting >= 0:
        high = min(next_edge(low, watch), end)
        # Those that come farther up, and those that come back: none of the former has a dip, unless below its first.
        kept = clip_by(n + 1, turns.whole, count, -0.8 * side * slight, side, turns.strip, 0, wide)
        if kept > 0:
            kept = clip_by(n, turns.strip, kept, low - reach, 1.0, turns.packed, 0, wide)
        if kept > 0:
            kept = clip_by(n, turns.packed, kept, high + reach, -1.0, turns.strip, 0, wide)
        for k in range(kept):
            for j in range(n):
                turns.strip[k * n + j] = turns.strip[k * wide + j]
        if kept > 0:
            far = measure_swings(turns, z, turns.strip, kept, holds, off, drift, body)
            # Those that are truly in the strip read one thing next.
            turns.bounds[LEAST] = turns.bounds[MOST] = 0.5 * (low + high)
            waiting = move_parts(room, waiting, centre, turns.strip, kept, holds, far, cell)
        low, side = (high, 1.0) if side < 0.0 else (low, -1.0)
    return waiting


def part(room, waiting, centre, count, low, high, reach, cell):
    """Cut the piece in ``room.corners`` where the command changes, and move each part; how many wait then, -1: no room.

    ``low`` and ``high``: the readings it has; ``reach``: position by which each part goes beyond its edges. So whatever
    a state truly reads, a part that acts as this reading holds the state. Parts with too many corners are halved, too.
    """
    drift, turns, law = cell.drift, cell.known.turns, cell.known.law
    n, watch, ring, x = cell.body.order, watched(law, cell.wall), centre.ring, centre.z[0]
    if waiting + 2 * levels_between(turns, low, high, watch) > len(room.stack) // piece_size(n, len(ring)):
        return -1
    level, half, shown = low, half_of(turns, False, watch), count_of(turns, law, centre.before, ring)
    while level <= high:
        bottom = lowest_at(turns, level, shown, half, drift.bottom, watch) - reach - x
        top = highest_at(turns, level, shown, half, watch) + reach - x
        acts = acting_as(centre, level, centre.before, centre.error)
        kept = within(room, room.corners, count, bottom, top, n)
        if kept > CORNERS:
            kept, other = halve(room, kept, n)
            waiting = move_part(room, waiting, acts, room.parts, other, cell)
        if kept > 0 and waiting >= 0:
            waiting = move_part(room, waiting, acts, room.halves, kept, cell)
        if waiting < 0:
            return -1
        level = next_at(turns, level, watch)
    return waiting
