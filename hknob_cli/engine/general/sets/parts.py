"""Pieces cut where a sample of them meets a count edge, and with hysteresis where a turning point after it does.

A polygon is cut by bounds on the highest and lowest places of its motions (`swings`): each part holds all states whose
turning points make of the count what is told of the part.
"""

from hknob_cli.engine.general.controller import lower_edge, upper_edge
from hknob_cli.engine.general.sets.memory import watched
from hknob_cli.engine.general.sets.piece import BEFORE, CORNERS, STATE, clip_by, halve, move_piece, piece_size, within
from hknob_cli.engine.general.sets.swings import LEAST, MOST, PLACES, SLIGHT, measure_swings, plan_parts, turns_within
from hknob_cli.engine.general.sets.turns import (
    count_of,
    half_of,
    highest_at,
    levels_between,
    lowest_at,
    next_at,
    plan_holds,
)
from hknob_cli.engine.loop import floor


def cut_by_turns(turns, way, count, first, last, level, room, corners, number, n, wall):
    """The part of a set whose turning points make this ``count``, to ``turns.kept``: ``(corners, whether beyond)``.

    ``way``, ``first``, ``last``: as `plan_parts` has them; ``room``: by which the part goes beyond its edges. It may be
    beyond the part of those whose count stays at ``level``.
    """
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


def set_count(law, stack, base, order, count):
    """Let a piece that waits have this count."""
    if law is None:
        stack[base + BEFORE] = count
        return
    stack[base + STATE + order + law.line - 1] = count


def next_edge(x, wall):
    """The next place above ``x`` at which a count changes on the way up or down, after any count."""
    half = 0.5 * wall.hysteresis
    up, down = floor(x - half) + 1.0 + half, floor(x + half) + 1.0 - half
    edge = min(up, down)
    return edge if edge > x else max(up, down)


def move_counted(room, waiting, piece, corners, number, cell, count):
    """Let a set of so many corners, with the numbers of a ``piece``, move on and have a count; how many wait then."""
    drift, body, wall = cell
    waiting = move_piece(room, waiting, *piece, corners, number, drift, body, wall)
    set_count(room.law, room.stack, (waiting - 1) * piece_size(body.order, len(piece[2])), body.order, count)
    return waiting


def move_parts(room, waiting, piece, corners, number, cell, plan, reach):
    """Let the parts of a set for which there is a ``plan`` move on, one for each count; -1: no room.

    ``piece``: its centre, last reading, commands under way with the oldest of them, error, level, sample and weight.
    """
    drift, body, wall = cell
    z, _, ring, _, _, level, _, _ = piece
    turns, n, watch = room.turns, body.order, watched(room.law, wall)
    way, first, last, holds = plan
    shown = first
    while shown <= last:
        kept, beyond = cut_by_turns(turns, way, shown, first, last, level, reach, corners, number, n, watch)
        then = shown
        other = kept > 0 and way != 0 and shown != level
        if other and not turns_within(turns, way, z, turns.kept, kept, n, holds, drift, body):
            # None has a turning point there: their count stays, and what is not beyond is in the part of those.
            then = level
            kept = kept if beyond else 0
        if (waiting + 2) * piece_size(n, len(ring)) > len(room.stack):
            return -1
        opposite = kept // 2 if kept > CORNERS else kept - 1
        if kept > 0:
            waiting = move_counted(room, waiting, piece, turns.kept, opposite + 1, cell, then)
        if kept > CORNERS:
            for k in range((kept - opposite) * n):
                turns.packed[k] = turns.kept[opposite * n + k]
            for j in range(n):
                turns.packed[(kept - opposite) * n + j] = turns.kept[j]
            waiting = move_counted(room, waiting, piece, turns.packed, kept - opposite + 1, cell, then)
        shown += 1.0
    return waiting


def move_part(room, waiting, z, before, ring, head, error, level, sample, weight, corners, count, drift, body, wall):
    """As `piece.move_piece`; with hysteresis a piece for each count that turning points make; -1: no room.

    Where they do several things to a set it is taken in strips first, which read one thing at the next sample.
    """
    turns, n = room.turns, body.order
    if turns is None:
        return move_piece(
            room, waiting, z, before, ring, head, error, level, sample, weight, corners, count, drift, body, wall
        )
    piece, cell = (z, before, ring, head, error, level, sample, weight), (drift, body, wall)
    watch, off = watched(room.law, wall), body.reach * error
    holds = plan_holds(turns, room.law, level, before, ring, head, wall)
    reach = measure_swings(turns, z, corners, 0, count, n, holds, off, drift, body)
    way, first, last = plan_parts(turns, level, watch)
    if way != 0 or first == last:
        plan = way, first, last, holds
        return move_parts(room, waiting, piece, corners, count, cell, plan, reach)
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
            far = measure_swings(turns, z, turns.strip, 0, kept, n, holds, off, drift, body)
            # Those that are truly in the strip read one thing next.
            turns.bounds[LEAST] = turns.bounds[MOST] = 0.5 * (low + high)
            way, first, last = plan_parts(turns, level, watch)
            plan = way, first, last, holds
            waiting = move_parts(room, waiting, piece, turns.strip, kept, cell, plan, far)
        low, side = (high, 1.0) if side < 0.0 else (low, -1.0)
    return waiting


def part(
    room, waiting, z, before, ring, head, error, reach, sample, weight, corners, count, low, high, drift, body, wall
):
    """Cut a piece at the edges that change the command, and move each part; how many pieces wait then, -1: no room.

    ``low`` and ``high``: the readings it has; ``reach``: position by which each part goes beyond its edges. So whatever
    a state truly reads, a part that acts as this reading holds the state. Parts with too many corners are halved, too.
    """
    n, watch, turns = body.order, watched(room.law, wall), room.turns
    if waiting + 2 * levels_between(turns, low, high, watch) > len(room.stack) // piece_size(n, len(ring)):
        return -1
    level, half, shown = low, half_of(turns, False, watch), count_of(turns, room.law, before, ring)
    while level <= high:
        bottom = lowest_at(turns, level, shown, half, drift.bottom, watch) - reach - z[0]
        piece = z, before, ring, head, error, level, sample, weight
        top = highest_at(turns, level, shown, half, watch) + reach - z[0]
        kept = within(room, corners, count, bottom, top, n)
        if kept > CORNERS:
            kept, other = halve(room, kept, n)
            waiting = move_part(room, waiting, *piece, room.parts, other, drift, body, wall)
        if kept > 0 and waiting >= 0:
            waiting = move_part(room, waiting, *piece, room.halves, kept, drift, body, wall)
        if waiting < 0:
            return -1
        level = next_at(turns, level, watch)
    return waiting
