"""The count of an encoder with hysteresis, of all states of an arc: by where they may turn round.

As long as a motion goes one way its count may wait: what it shows follows from how far it comes. The speed of a state
differs from that of the centre by no more than the arc is large. So a state turns round only in a window of time in
which the centre is as slow; and its places there are as near to those of the centre. Where all states stop once and go
on alike, that is near the stop, and its line tells their places. What a state counts after a window lies between two
counts. Where these differ the arc is halved, unless it is one of the narrowest: then it has both.

``turns`` is a `room.TurnRoom`, or None without hysteresis.
"""

from math import exp, floor

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.advance import next_mode
from hknob_cli.engine.general.body import acceleration, copy_to
from hknob_cli.engine.general.cogging import FREE, TURNED, has_cogs, size_at, slope_at, unit_reach
from hknob_cli.engine.general.controller import read, read_after, told
from hknob_cli.engine.general.corners import growth_rate
from hknob_cli.engine.general.sets.cog_arc import pass_over
from hknob_cli.engine.general.sets.cog_stop import Spread, slides_on, stop_on_slope
from hknob_cli.engine.general.sets.friction_arc import (
    COUNT,
    COUNT_TO,
    ERROR,
    WHOLE,
    apart_of,
    beside_of,
)
from hknob_cli.engine.general.slide_many import slide_many
from hknob_cli.engine.general.slide_two import way
from hknob_cli.engine.general.slopes import cog_rate, roll, stays_over, way_from

ROUNDED = 1.0 + 1e-9  # times how far states are from a line: what moving it over a hold rounds
PARTS_TRIED = 3  # of a slide, of which all but the last 1/64, 1/16 or 1/4 is shown to be fast


def begin_counts(turns, level, arc):
    """Let all states of an arc have this count: their reading, whichever came before."""
    if turns is None:
        return
    arc[COUNT], arc[COUNT_TO] = level, level


def keep_start(turns, room, body):
    """Keep where the hold begins over which the arc in ``room`` is to be moved, and how large the arc is: ``(N, x)``.

    How far states may be from its centre, in `body.norm`, and their places.
    """
    if turns is None:
        return 0.0, 0.0
    copy_to(room.turning, room.z)
    return apart_of(room, body), abs(room.columns[0]) + beside_of(room, body)


def pass_window(start, end, span, far, arc, watch):
    """Take into the counts of an arc what turning points in a window may do to them.

    ``start`` and ``end``: place of the centre then, and ``span``: from where to where it goes between them; ``far``: by
    how much that of a state may differ from it.
    """
    half, low, high = 0.5 * watch.hysteresis, arc[COUNT], arc[COUNT_TO]
    low, high = read_after(start - far, low, watch), read_after(start + far, high, watch)
    low, high = min(low, read(span[0] - far + half, watch)), max(high, read(span[1] + far - half, watch))
    low, high = max(low, read(end - far - half, watch)), min(high, read(end + far + half, watch))
    arc[COUNT], arc[COUNT_TO] = told(low, watch), told(high, watch)


def is_fast(room, z, u, mode, span, apart, body):
    """Whether no state turns round over ``span`` whose centre begins at ``z`` and slides in ``mode``."""
    if not span > 0.0:
        return True
    copy_to(room.begun, z)
    return stays_over(room.begun, u, 0.0, mode, span, apart, body, room.pad)


def window_of(room, u, mode, slide, apart, body):
    """When in a slide states may turn round, and places of the centre then: ``(begins, ends, x then, x then)``.

    The slide is from ``room.first`` on; ``slide``: how long it is, and whether it ends in a stop. ``begins`` is not
    below ``ends`` where none turns.
    """
    time, stops = slide
    begins, ends = 0.0, time
    if not stops and is_fast(room, room.first, u, mode, time, apart, body):
        return time, time, 0.0, 0.0
    for k in range(PARTS_TRIED):
        part = floor(time * (1.0 - 0.25 ** (PARTS_TRIED - k)) * WHOLE) / WHOLE
        if is_fast(room, room.first, u, mode, part, apart, body):
            begins = part
            break
    copy_to(room.ahead, room.first)
    if begins > 0.0:
        slide_many(room.ahead, u, mode, begins, body, room.pad)
    first = room.ahead[0]
    for k in range(PARTS_TRIED):
        if stops or begins > 0.0:
            break
        part = floor(time * 0.25 ** (PARTS_TRIED - k) * WHOLE) / WHOLE
        copy_to(room.ahead, room.first)
        slide_many(room.ahead, u, mode, part, body, room.pad)
        if part > 0.0 and is_fast(room, room.ahead, u, mode, time - part, apart, body):
            ends = part
            return begins, ends, first, room.ahead[0]
    copy_to(room.ahead, room.first)
    slide_many(room.ahead, u, mode, time, body, room.pad)
    return begins, ends, first, room.ahead[0]


def count_on_slopes(room, u, span, before, body, watch):
    """As `count_turns` does, from corner to corner of cogging: one turn of all states after the other, as `cog_stop`.

    From where it is not known on that all do alike, they may turn round anywhere.
    """
    cogs, z, pad, left = body.cogs, room.turning, room.pad, span
    slope = slope_at(z[0], cogs)
    mode = way_from(z, u, slope, body)
    cog_rate(z, u, slope, mode, body, pad)
    grown = exp(growth_rate(body) * span) * ROUNDED
    fast, apart = size_at(cogs, pad, 0, body) * grown, max(before[0] * grown, apart_of(room, body))
    far = min(unit_reach(body) * apart, before[1] * ROUNDED + apart * span) + 8.0 * EPSILON * (abs(z[0]) + 1.0)
    moved = (abs(z[1]) + 0.5 * fast * span) * span  # by the centre, at most
    if body.friction == 0.0 and (mode == 0 or moved <= far):  # it balances, or turns round by roundings
        pass_window(z[0], z[0], (z[0], z[0]), far + moved, room.arc, watch)
        return
    spread, wait, known, fresh = Spread(apart, far, fast), 0.0, mode != 0, mode != 0 and z[1] == 0.0
    first, low, high = z[0], z[0], z[0]
    while left > 0.0:
        if known:
            first, low, high = z[0], z[0], z[0]
        copy_to(room.first, z)
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        left -= t
        turns, window = end == TURNED and mode != 0, 0.0
        if turns and known:
            known, window, _, _, _ = stop_on_slope(room, z, u, slope, mode, left, spread, body)
            known = known and 2.0 * window < left
        known = known and mode != 0 and slides_on(room, u, slope, mode, t, (wait, window), spread, body)
        low, high = min(low, z[0]), max(high, z[0])
        if turns and known:
            off = far + 8.0 * (fast + 2.0 * body.friction) * window * window
            pass_window(z[0], z[0], (z[0], z[0]), off, room.arc, watch)
        wait = 2.0 * window
        if end == 0:
            break
        slope, mode = pass_over(z, u, slope, mode, end, body)
        if mode == FREE:  # it balances where it has turned round
            pass_window(first, z[0], (min(low, z[0]), max(high, z[0])), far + moved, room.arc, watch)
            return
        fresh = True
    if not known:
        pass_window(first, z[0], (low, high), far, room.arc, watch)


def count_turns(turns, room, u, span, alike, before, body, watch):
    """Take in where states of the arc in ``room`` may have turned round in the hold that has moved it.

    Args:
        turns: Whether an encoder has hysteresis, as the module has it.
        room: `friction_arc_search.RubRoom`; as the hold began its centre was ``room.turning``.
        u: Torque in the hold.
        span: Its length.
        alike: Whether all states did alike, as `friction_arc.rub_arc` has it.
        before: How large the arc was as the hold began, by `keep_start`.
        body: What moves.
        watch: The controller by whose edges arcs are cut.
    """
    if turns is None:
        return
    z, begun = room.turning, room.turning[1]
    if body.friction > 0.0 and alike and begun == 0.0:
        return  # all stand, or slide on from there
    if has_cogs(body.cogs):
        count_on_slopes(room, u, span, before, body, watch)
        return
    if body.friction > 0.0 and alike and begun * room.z[1] > 0.0:
        return  # all slide, one way
    if body.friction > 0.0 and alike:
        at, far = room.stop[0], room.stop[1] * ROUNDED + body.reach * room.arc[ERROR]
        pass_window(at, at, (at, at), far, room.arc, watch)
        return
    apart = max(before[0], apart_of(room, body))
    far = min(body.reach * apart, before[1] * ROUNDED + apart * span + body.reach * room.arc[ERROR])
    far += 8.0 * EPSILON * (abs(z[0]) + abs(room.z[0]))
    left = floor(span * WHOLE) / WHOLE
    mode = way(z[1], acceleration(z, u, body), body.friction)
    while left > 0.0 and not body.halt[0] > 0.0:
        copy_to(room.first, z)
        time, stops, _ = slide_many(z, u, mode, left, body, room.pad)
        begins, ends, first, last = 0.0, time, room.first[0], z[0]
        if mode != 0:
            begins, ends, first, last = window_of(room, u, mode, (time, stops), apart, body)
            if stops:
                last = z[0]
        if begins < ends or stops:
            pass_window(first, last, (min(first, last), max(first, last)), far, room.arc, watch)
        left -= time
        if not stops:
            return
        mode = next_mode(mode, z, u, body)


def tells_counts(turns, arc):
    """Whether all states of an arc have one count."""
    if turns is None:
        return True
    return arc[COUNT] == arc[COUNT_TO]
