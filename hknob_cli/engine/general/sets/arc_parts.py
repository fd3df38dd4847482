"""Arcs of clock phases that wait, and the parts that they are cut into: at count edges, and at turning points."""

from hknob_cli.engine.general.controller import lower_edge, upper_edge
from hknob_cli.engine.general.sets.ball import step_through
from hknob_cli.engine.general.sets.curve import move_centre
from hknob_cli.engine.general.sets.memory import begin_at, watched
from hknob_cli.engine.general.sets.swings import PLACES, measure_swings, plan_parts
from hknob_cli.engine.general.sets.turns import (
    count_of,
    half_of,
    highest_at,
    keep_count,
    levels_between,
    lowest_at,
    next_at,
    plan_holds,
)

LOW, HIGH, ARC_ERROR, ARC_BEFORE, ARC_LEVEL, ARC_SAMPLE, ARC_STATE = range(7)


def arc_size(n, delay):
    """Numbers of an arc that waits: `LOW` to `ARC_SAMPLE`, its state, and the commands under way, oldest first."""
    return ARC_STATE + n + delay


def wait_arc(room, waiting, low, high, z, before, ring, head, error, level, sample, n):
    """Let an arc wait; how many do then."""
    delay = len(ring)
    base = waiting * arc_size(n, delay)
    room.stack[base + LOW], room.stack[base + HIGH], room.stack[base + ARC_ERROR] = low, high, error
    room.stack[base + ARC_BEFORE], room.stack[base + ARC_LEVEL], room.stack[base + ARC_SAMPLE] = before, level, sample
    for j in range(n):
        room.stack[base + ARC_STATE + j] = z[j]
    for j in range(delay):
        room.stack[base + ARC_STATE + n + j] = ring[(head + j) % delay]
    return waiting + 1


def split_arc(room, waiting, low, high, first, last, z, before, ring, head, error, slack, sample, drift, body):
    """Cut an arc at two of its phases, at most; how many arcs wait then. The parts have not moved on."""
    middle = 0.5 * (low + high)
    for part in range(3):
        begin = low if part == 0 else (first if part == 1 else last)
        end = first if part == 0 else (last if part == 1 else high)
        if begin < end:
            move_centre(z, middle, 0.5 * (begin + end), sample, room, drift, body, room.z)
            waiting = wait_arc(
                room, waiting, begin, end, room.z, before, ring, head, error + slack, 0.0, float(sample), body.order
            )
    return waiting


def fraction_of(a, b, limit, sign, first, last):
    """Which part of a chord, within ``first`` to ``last``, is above a limit, below it by a ``sign`` of -1."""
    here, there = sign * (a - limit), sign * (b - limit)
    if here < 0.0 and there < 0.0:
        return 1.0, 0.0
    if here < 0.0:
        return max(first, here / (here - there)), last
    if there < 0.0:
        return first, min(last, here / (here - there))
    return first, last


def move_arc(room, waiting, low, high, begin, end, z, before, ring, head, error, sample, level, shown, cell):
    """Move the part of an arc from ``begin`` to ``end``, acting as ``level``, and let it wait with a count."""
    law, drift, body, wall = cell
    move_centre(z, 0.5 * (low + high), 0.5 * (begin + end), sample, room, drift, body, room.z)
    for j in range(len(ring)):
        room.ring[j] = ring[(head + j) % len(ring)]
    was = begin_at(law, level, room.ring, wall) if sample == 0 else before
    remembers, grown, to = step_through(
        law, room.z, was, error, level, room.ring, 0 * len(ring), drift, body, wall, room.pad
    )
    remembers = keep_count(room.turns, law, shown, remembers, room.ring)
    return wait_arc(room, waiting, begin, end, room.z, remembers, room.ring, to, grown, level, sample + 1.0, body.order)


def move_by_turns(room, waiting, low, high, first, last, z, before, ring, head, error, reach, sample, level, cell):
    """As `move_arc`, from a fraction of a chord to another; with hysteresis for each count that turning points make."""
    law, drift, body, wall = cell
    turns, n, span = room.turns, body.order, high - low
    if turns is None:
        begin, end = low + first * span, low + last * span
        return move_arc(room, waiting, low, high, begin, end, z, before, ring, head, error, sample, level, 0.0, cell)
    if sample == 0:
        begin_at(law, level, ring, wall)
    for j in range(n):
        way = room.above[j] - room.below[j]
        turns.kept[j], turns.kept[n + j] = room.below[j] + first * way, room.below[j] + last * way
    watch, places = watched(law, wall), turns.places
    holds = plan_holds(turns, law, level, before, ring, head, wall)
    beyond = measure_swings(turns, z, turns.kept, 0, 2, n, holds, reach, drift, body)
    side, least, most = plan_parts(turns, level, watch)
    sign, half, shown = float(side), 0.5 * watch.hysteresis, least
    farthest, meanwhile = (0, 1) if side > 0 else (2, 3)
    while shown <= most:
        a, b = 0.0, 1.0
        edge, farther = lower_edge(shown, watch) + half, lower_edge(shown + 1.0, watch) + half
        before_it, after_it = shown > least, shown < most
        if side < 0:
            edge, farther = upper_edge(shown, watch) - half, upper_edge(shown - 1.0, watch) - half
            before_it, after_it = shown < most, shown > least
        if side != 0 and before_it:
            a, b = fraction_of(places[farthest], places[PLACES + farthest], edge - sign * beyond, sign, a, b)
        if side != 0 and after_it:
            a, b = fraction_of(places[meanwhile], places[PLACES + meanwhile], farther + sign * beyond, -sign, a, b)
        if a <= b:
            if waiting + 1 > len(room.stack) // arc_size(n, len(ring)):
                return -1
            begin, end = low + span * (first + a * (last - first)), low + span * (first + b * (last - first))
            waiting = move_arc(
                room, waiting, low, high, begin, end, z, before, ring, head, error, sample, level, shown, cell
            )
        shown += 1.0
    return waiting


def turns_apart(room, z, before, ring, head, reach, sample, least, most, cell):
    """Whether turning points tell the states of a chord apart by places that are none of a chord, beyond roundings."""
    law, drift, body, wall = cell
    turns, n = room.turns, body.order
    if turns is None:
        return False
    watch, level = watched(law, wall), least
    while level <= most:
        if sample == 0:
            begin_at(law, level, ring, wall)
        for j in range(n):
            turns.kept[j], turns.kept[n + j] = room.below[j], room.above[j]
        holds = plan_holds(turns, law, level, before, ring, head, wall)
        beyond = measure_swings(turns, z, turns.kept, 0, 2, n, holds, reach, drift, body)
        side, first, last = plan_parts(turns, level, watch)
        at = 0 if side > 0 else 2
        bent = abs(turns.places[at] - turns.places[at + 1])
        bent = max(bent, abs(turns.places[PLACES + at] - turns.places[PLACES + at + 1]))
        if first < last and (side == 0 or bent > 4.0 * beyond):
            return True
        level += 1.0
    return False


def part_arc(room, waiting, low, high, z, before, ring, head, error, slack, reach, sample, least, most, cell):
    """Cut an arc that is a chord at its edges, and move each part; how many arcs wait then, -1: no room.

    ``reach``: position by which each part goes beyond its edges; ``least``, ``most``: the readings of the arc.
    """
    law, drift, body, wall = cell
    n, watch, turns = body.order, watched(law, wall), room.turns
    if waiting + levels_between(turns, least, most, watch) > len(room.stack) // arc_size(n, len(ring)):
        return -1
    left, right = z[0] + room.below[0], z[0] + room.above[0]
    level, half, shown = least, half_of(turns, sample == 0, watch), count_of(turns, law, before, ring)
    while level <= most and waiting >= 0:
        bottom = lowest_at(turns, level, shown, half, drift.bottom, watch) - reach
        top = highest_at(turns, level, shown, half, watch) + reach
        first, last = 0.0, 1.0
        if left != right:
            one, other = (bottom - left) / (right - left), (top - left) / (right - left)
            first, last = max(first, min(one, other)), min(last, max(one, other))
        elif left < bottom or left > top:
            last = -1.0
        if first <= last:
            waiting = move_by_turns(
                room, waiting, low, high, first, last, z, before, ring, head, error + slack, reach, sample, level, cell
            )
        level = next_at(turns, level, watch)
    return waiting
