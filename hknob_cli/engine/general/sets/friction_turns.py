"""The count of an encoder with hysteresis, of all states of a set that friction may stop: by where they stop.

As long as a motion goes one way its count may wait: what it shows follows from how far it comes. Where it stops, or
may, the count is that of the place, after the one before. A count may be taken at any place where a motion truly is, so
that one too many does no harm.

A motion that slides up is highest where it stops. As long as it slides its place is, at any one time, affine in its
first state. So the highest place is convex in that, as without friction (`swings`), and the parts of a set are cut by
the same bounds (`parts.cut_by_turns`), before it moves.
"""

from typing import NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.controller import read, told
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, drop_edge, keep_side
from hknob_cli.engine.general.sets.friction_set import (
    DEPTH,
    LATE,
    LEG,
    SHOWN,
    SIDE,
    SPAN,
    TOLD,
    TORQUE,
    F,
    G,
    S,
    begin_set,
    room_for_sets,
)
from hknob_cli.engine.general.sets.friction_step import MOST_CUTS, Hold, Shape
from hknob_cli.engine.general.sets.lagged_step import DEEPEST
from hknob_cli.engine.general.sets.lagged_stops import LAGS, LEFT, plain_of
from hknob_cli.engine.general.sets.memory import watched
from hknob_cli.engine.general.sets.parts import cut_by_turns
from hknob_cli.engine.general.sets.swings import PLACES
from hknob_cli.engine.general.sets.turns import DOUBT
from hknob_cli.engine.general.slide_two import coefficients
from hknob_cli.engine.turning import first_zero

ROUNDED = 64.0  # units in the last place of all terms of a place
# Of the states of a set that begin by moving one way: whether one of them may stop, and where the farthest places lie.
NONE_STOPS = False, 0.0, 0.0


class Ahead(NamedTuple):
    """The part of a hold that a set is to be moved over.

    ``hold``: its length and the plant's coefficients over it; ``free``: the least and the most torque in it, with what
    drives the knob, counts per sample².
    """

    hold: Hold
    free: tuple[float, float]


def farthest(px, pv, pull, hold, body):
    """The farthest place of a motion that slides on at ``pull`` over a hold, and when: ``(place, time)``."""
    end, at = hold.f * pv + hold.s * pull, 0.0
    if pv > 0.0:
        at = hold.span
        if end < 0.0:
            at = min(first_zero(pv, pull, body.alpha, body.beta), hold.span)
    elif px + (hold.s * pv + hold.g * pull) > px:
        at = hold.span
    s, g, _ = coefficients(at, body)
    return px + (s * pv + g * pull), at


def may_stop(sign, shape, pull_free, slack, hold, body):
    """Whether a state of a set begins by moving in direction ``sign``, or standing, and stops within a hold, or may."""
    x, v, corners, count = shape
    begins, others = False, False
    for k in range(count):
        px, pv = sign * (x + corners[2 * k]), sign * (v + corners[2 * k + 1])
        if pv < -slack:
            others = True
            continue
        begins = True
        if hold.f * pv + hold.s * (pull_free - body.beta * px) < slack:
            return True
    return begins and others


def measure_stops(sign, shape, ahead, slack, body, places):
    """Enter where the states stop that slide in direction ``sign``: ``(whether one may, farthest, least far)``.

    The farthest motion slides under the greater torque; one that is held for a time, and then goes on, comes less far.
    ``places`` takes, of each corner, its farthest place, and
    that at the time when the middle of all is there: the first two of `swings.PLACES` in direction 1, the next two in
    direction -1. All are told in that direction.
    """
    x, v, corners, count = shape
    hold, free = ahead
    beta = body.beta
    near, far = sign * free[0] - body.friction, sign * free[1] - body.friction
    if sign < 0.0:
        near, far = far, near
    if not may_stop(sign, shape, near, slack, hold, body):
        return NONE_STOPS
    mid_x, mid_v = x, v
    for k in range(count):
        mid_x, mid_v = mid_x + corners[2 * k] / count, mid_v + corners[2 * k + 1] / count
    _, at = farthest(sign * mid_x, sign * mid_v, near - beta * (sign * mid_x), hold, body)
    s, g, _ = coefficients(at, body)
    first = 0 if sign > 0.0 else 2
    most, least = -float("inf"), float("inf")
    for k in range(count):
        px, pv = sign * (x + corners[2 * k]), sign * (v + corners[2 * k + 1])
        place, _ = farthest(px, pv, far - beta * px, hold, body)
        meanwhile = px + (s * pv + g * (near - beta * px))
        places[PLACES * k + first], places[PLACES * k + first + 1] = sign * place, sign * meanwhile
        most, least = max(most, place), min(least, meanwhile)
    return True, most, least


def counts_after(sign, stops, count, room, wall):
    """The counts of a set after the stops in direction ``sign``, as `measure_stops` told them: ``(nearest, farthest)``.

    ``room``: by which places may lie elsewhere.
    """
    some, most, least = stops
    if not some:
        return count, count
    half = 0.5 * wall.hysteresis
    if sign > 0.0:
        near, far = told(read(least - room - half, wall), wall), told(read(most + room - half, wall), wall)
        return max(count, near), max(count, far)
    near, far = told(read(room - least + half, wall), wall), told(read(-most - room + half, wall), wall)
    return min(count, near), min(count, far)


def slack_of(shape, free, error, body):
    """By which a speed may lie elsewhere, or at the end of a hold: bound on what errors and roundings come to."""
    size = abs(shape.v) + max(abs(free[0]), abs(free[1])) + body.friction + body.beta * abs(shape.x)
    return DOUBT * error + ROUNDED * EPSILON * size


def plan_counts(turns, count, side, shape, ahead, error, body, wall):
    """By what a set is cut over a hold, as `swings.plan_parts`, and the room of its places: ``(plan, room, unsure)``.

    ``side``: 1 or -1 where only what begins by moving up or down stops; ``error``: of the set's states, in `body.norm`;
    ``unsure``: whether torques that are nearer to each other would tell more. Where they differ by less than the
    friction level, no state that has turned round leaves again once it stands: that would take twice the friction.
    """
    apart = ahead.free[1] - ahead.free[0]
    slack = slack_of(shape, ahead.free, error, body)
    room = body.reach * slack + ROUNDED * EPSILON * abs(shape.x)
    up, down = NONE_STOPS, NONE_STOPS
    if side >= 0.0:
        up = measure_stops(1.0, shape, ahead, slack, body, turns.places)
    if side <= 0.0:
        down = measure_stops(-1.0, shape, ahead, slack, body, turns.places)
    above, top = counts_after(1.0, up, count, room, wall)
    below, bottom = counts_after(-1.0, down, count, room, wall)
    unsure = (up[0] or down[0]) and apart > body.friction
    if top > count and bottom < count:
        return (0, bottom, top), room, unsure
    # By how much torques part places, beside how far those of the set lie apart.
    far = ahead.hold.g * apart
    if bottom < count:
        return (-1, bottom, below), room, unsure or (bottom < below and far > room and 4.0 * far > down[1] - down[2])
    return (1, above, top), room, unsure or (above < top and far > room and 4.0 * far > up[1] - up[2])


def part_ahead(work, part, body):
    """The part of a hold that a set is to be moved over: an `Ahead`.

    ``work.acts`` tells the torque, and which half of the hold.
    """
    leg = int(part) * LEG
    u = work.torques[int(work.course[leg + TORQUE])] + body.drive
    if work.lags is None:
        hold = Hold(work.course[leg + SPAN], work.course[leg + S], work.course[leg + G], work.course[leg + F])
        return Ahead(hold, (u, u))
    at = int(work.halves[int(part)]) + int(work.acts[DEPTH - LATE]) * LAGS
    lagged = plain_of(work.lags[at : at + LAGS])
    a, apart = work.acts[0] + body.drive, work.acts[1]
    end = u + (a - u) * work.lags[at + LEFT]
    return Ahead(lagged, (min(a, end) - apart, max(a, end) + apart))


def part_ways(work, at, place, cuts, count, slack):
    """Put what moves up in the set in ``work.corners``, and what moves down, in its place; how many sets there are."""
    for side in range(2):
        sign = 1.0 - 2.0 * side
        kept = keep_side(work.corners, count, 0.0, sign, -slack - sign * place[2], work.one)
        if kept > 0:
            work.acts[SIDE - LATE] = sign
            begin_set(work, at, place, cuts + 1, work.one, kept)
            at += 1
    return at


def tell_count(work, at, place, cuts, count, error, cell):
    """Tell the count of the set in ``work.corners`` at the stops of its part of an interval: ``(sets, parted)``.

    Where it is one, it is left in ``work.acts``, and there are ``at`` sets as before. Else a set waits for each count,
    with what it is cut to, and there are so many ``sets`` then; -1: no room.
    """
    turns, body, watch = cell.known.turns, cell.body, watched(cell.known.law, cell.wall)
    part, x, v, _ = place
    if work.acts[TOLD - LATE] == part + 1.0:
        return at, False
    shown, side, shape = work.acts[SHOWN - LATE], work.acts[SIDE - LATE], Shape(x, v, work.corners, count)
    ahead = part_ahead(work, part, body)
    plan, reach, unsure = plan_counts(turns, shown, side, shape, ahead, error, body, watch)
    while unsure and work.lags is not None and work.acts[DEPTH - LATE] < DEEPEST:
        work.acts[DEPTH - LATE] += 1.0
        ahead = part_ahead(work, part, body)
        plan, reach, unsure = plan_counts(turns, shown, side, shape, ahead, error, body, watch)
    if unsure and ahead.free[1] - ahead.free[0] > body.friction:
        return -1, False
    way, level, last = plan
    room_for = room_for_sets(work)
    if way == 0 and cuts < MOST_CUTS and at + 2 <= room_for:
        return part_ways(work, at, place, cuts, count, slack_of(shape, ahead.free, error, body)), True
    work.acts[TOLD - LATE], work.acts[SIDE - LATE] = part + 1.0, 0.0
    if level == last:
        work.acts[SHOWN - LATE] = level
        return at, False
    while level <= last:
        kept, _ = cut_by_turns(turns, plan, level, shown, reach, work.corners, count, watch)
        if kept > 0:
            if at + 2 > room_for:
                return -1, False
            while kept > MOST_CORNERS:
                kept = drop_edge(turns.kept, kept)
            work.acts[SHOWN - LATE] = level
            begin_set(work, at, place, cuts, turns.kept, kept)
            at += 1
        level += 1.0
    return at, True
