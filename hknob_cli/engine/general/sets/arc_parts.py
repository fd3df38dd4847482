"""Arcs of clock phases that wait, and the parts that they are cut into: at count edges, and at turning points."""

from hknob_cli.engine.general.controller import lower_edge, upper_edge
from hknob_cli.engine.general.sets.ball import step_through
from hknob_cli.engine.general.sets.cell import Centre, acting_as
from hknob_cli.engine.general.sets.curve import move_centre
from hknob_cli.engine.general.sets.memory import begin_at, watched
from hknob_cli.engine.general.sets.swings import PLACES, measure_swings, plan_parts
from hknob_cli.engine.general.sets.turns import (
    count_of,
    half_of,
    highest_at,
    levels_between,
    lowest_at,
    next_at,
    plan_holds,
)

LOW, HIGH, ARC_ERROR, ARC_BEFORE, ARC_LEVEL, ARC_SAMPLE, ARC_STATE = range(7)


def arc_size(n, delay):
    """Numbers of an arc that waits: `LOW` to `ARC_SAMPLE`, its state, and the commands under way, oldest first."""
    return ARC_STATE + n + delay


def wait_arc(room, waiting, span, centre):
    """Let an arc wait, from a low to a high phase; how many do then."""
    z, ring, delay = centre.z, centre.ring, len(centre.ring)
    base, n = waiting * arc_size(len(z), delay), len(z)
    room.stack[base + LOW], room.stack[base + HIGH] = span
    room.stack[base + ARC_ERROR], room.stack[base + ARC_BEFORE] = centre.error, centre.before
    room.stack[base + ARC_LEVEL], room.stack[base + ARC_SAMPLE] = centre.level, centre.sample
    for j in range(n):
        room.stack[base + ARC_STATE + j] = z[j]
    for j in range(delay):
        room.stack[base + ARC_STATE + n + j] = ring[(centre.head + j) % delay]
    return waiting + 1


def take_arc(room, waiting):
    """The arc that waits at this place: its low and high phase, and its centre in ``room``."""
    z, ring, delay = room.own_z, room.own_ring, len(room.own_ring)
    base, n = waiting * arc_size(len(z), delay), len(z)
    for j in range(n):
        z[j] = room.stack[base + ARC_STATE + j]
    for j in range(delay):
        ring[j] = room.stack[base + ARC_STATE + n + j]
    span = room.stack[base + LOW], room.stack[base + HIGH]
    error, before = room.stack[base + ARC_ERROR], room.stack[base + ARC_BEFORE]
    level, sample = room.stack[base + ARC_LEVEL], room.stack[base + ARC_SAMPLE]
    return span, Centre(z, before, ring, 0 * delay, error, level, sample, span[1] - span[0])


def split_arc(room, waiting, span, first, last, centre, cell):
    """Cut an arc at two of its phases, at most; how many arcs wait then. The parts have not moved on."""
    low, high = span
    middle = 0.5 * (low + high)
    for part in range(3):
        begin = low if part == 0 else (first if part == 1 else last)
        end = first if part == 0 else (last if part == 1 else high)
        if begin < end:
            move_centre(centre, middle, 0.5 * (begin + end), room, cell.drift, cell.body, room.z)
            here = Centre(
                room.z, centre.before, centre.ring, centre.head, centre.error, 0.0, centre.sample, centre.weight
            )
            waiting = wait_arc(room, waiting, (begin, end), here)
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


def move_arc(room, waiting, span, part, centre, shown, cell):
    """Move the part of an arc that has these phases, acting as its level, and let it wait with a count."""
    law, ring, delay = cell.known.law, centre.ring, len(centre.ring)
    move_centre(centre, 0.5 * (span[0] + span[1]), 0.5 * (part[0] + part[1]), room, cell.drift, cell.body, room.z)
    for j in range(delay):
        room.ring[j] = ring[(centre.head + j) % delay]
    before = begin_at(law, centre.level, room.ring, cell.wall) if centre.sample == 0 else centre.before
    here = Centre(room.z, before, room.ring, 0 * delay, centre.error, centre.level, centre.sample, centre.weight)
    return wait_arc(room, waiting, part, step_through(here, shown, cell, room.pad))


def move_by_turns(room, waiting, span, chord, centre, reach, cell):
    """As `move_arc`, of a ``chord`` from one fraction to another; with hysteresis for each count of turning points."""
    drift, body, turns, law = cell.drift, cell.body, cell.known.turns, cell.known.law
    low, n = span[0], body.order
    way, (first, last) = span[1] - low, chord
    if turns is None:
        return move_arc(room, waiting, span, (low + first * way, low + last * way), centre, 0.0, cell)
    if centre.sample == 0:
        begin_at(law, centre.level, centre.ring, cell.wall)
    for j in range(n):
        ahead = room.above[j] - room.below[j]
        turns.kept[j], turns.kept[n + j] = room.below[j] + first * ahead, room.below[j] + last * ahead
    watch, places = watched(law, cell.wall), turns.places
    holds = plan_holds(turns, law, centre, cell.wall)
    beyond = measure_swings(turns, centre.z, turns.kept, 2, holds, reach, drift, body)
    side, least, most = plan_parts(turns, centre.level, watch)
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
            if waiting + 1 > len(room.stack) // arc_size(n, len(centre.ring)):
                return -1
            part = low + way * (first + a * (last - first)), low + way * (first + b * (last - first))
            waiting = move_arc(room, waiting, span, part, centre, shown, cell)
        shown += 1.0
    return waiting


def turns_apart(room, centre, reach, least, most, cell):
    """Whether turning points tell the states of a chord apart by places that are none of a chord, beyond roundings."""
    drift, body, turns, law = cell.drift, cell.body, cell.known.turns, cell.known.law
    if turns is None:
        return False
    n, watch, level = body.order, watched(law, cell.wall), least
    while level <= most:
        if centre.sample == 0:
            begin_at(law, level, centre.ring, cell.wall)
        for j in range(n):
            turns.kept[j], turns.kept[n + j] = room.below[j], room.above[j]
        holds = plan_holds(turns, law, acting_as(centre, level, centre.before, centre.error), cell.wall)
        beyond = measure_swings(turns, centre.z, turns.kept, 2, holds, reach, drift, body)
        side, first, last = plan_parts(turns, level, watch)
        at = 0 if side > 0 else 2
        bent = abs(turns.places[at] - turns.places[at + 1])
        bent = max(bent, abs(turns.places[PLACES + at] - turns.places[PLACES + at + 1]))
        if first < last and (side == 0 or bent > 4.0 * beyond):
            return True
        level += 1.0
    return False


def part_arc(room, waiting, span, centre, reach, least, most, cell):
    """Cut an arc that is a chord at its edges, and move each part; how many arcs wait then, -1: no room.

    ``reach``: position by which each part goes beyond its edges; ``least``, ``most``: the readings of the arc.
    """
    drift, turns, law, ring = cell.drift, cell.known.turns, cell.known.law, centre.ring
    n, watch = cell.body.order, watched(law, cell.wall)
    if waiting + levels_between(turns, least, most, watch) > len(room.stack) // arc_size(n, len(ring)):
        return -1
    left, right = centre.z[0] + room.below[0], centre.z[0] + room.above[0]
    level, half = least, half_of(turns, centre.sample == 0, watch)
    shown = count_of(turns, law, centre.before, ring)
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
            acts = acting_as(centre, level, centre.before, centre.error)
            waiting = move_by_turns(room, waiting, span, (first, last), acts, reach, cell)
        level = next_at(turns, level, watch)
    return waiting
