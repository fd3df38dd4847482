"""The derivative of a motion from slope to slope of cogging, and marks of what it comes near to.

The torque has no jump at a corner, so that a difference of two motions goes through it as it is.
"""

from math import exp, inf

from hknob_cli.engine.general.body import HALVES_HELD, HALVINGS, HELD, norm_at
from hknob_cli.engine.general.cogging import (
    COGGED,
    COGGED_HALVES,
    FREE,
    ROOT,
    TURNED,
    is_stable,
    room_on,
    slope_at,
)
from hknob_cli.engine.general.columns import (
    CORNER_ROOM,
    FASTEST,
    LEAST_TURN,
    LEVEL,
    LOOSE,
    SLOWEST,
    SLOWNESS,
    SPEED,
    STUCK_FOR,
    TURN_ROOM,
    TURNING,
    spread_by,
    turn_round,
)
from hknob_cli.engine.general.corners import rate_bound
from hknob_cli.engine.general.piece_marks import FIRST, Piece, keep, mark_piece
from hknob_cli.engine.general.slopes import cog_acceleration, cog_rate, pass_on, roll, settled, way_from


def spread_cogs(columns, span, slope, mode, body, pad):
    """Move the columns over ``span`` on one slope, in one mode."""
    if mode == 0:
        spread_by(columns, span, HELD, HALVES_HELD, False, body, pad)
    else:
        kind = 0 if is_stable(slope) else 1
        halves = COGGED_HALVES + kind * HALVINGS
        spread_by(columns, span, COGGED + kind, halves, True, body, pad)


def begin_hold(z, u, slope, span, body, pad, marks):
    """Mode in which a hold begins, and marks of that."""
    rubs = body.friction > 0.0
    still, moved = settled(body.cogs, z, u, slope, span, body, pad)
    mode = way_from(z, u, slope, body)
    unseen = mode == 0 and not rubs and not still  # where it turns round later is not seen
    if still or (mode == 0 and not rubs):
        mode = FREE  # it balances, to a rounding, and nothing holds it
    room = room_on(z[0], slope, body.cogs) - (moved if still else 0.0)
    marks[CORNER_ROOM] = min(marks[CORNER_ROOM], room)
    if still or z[1] == 0.0:
        marks[TURN_ROOM] = -1.0 if unseen else min(marks[TURN_ROOM], room)
    if rubs and z[1] == 0.0:
        level = abs(abs(cog_acceleration(z, u, slope, body)) - body.friction)
        marks[LEVEL] = min(marks[LEVEL], level)
        marks[STUCK_FOR] = min(marks[STUCK_FOR], level * span)
    return mode


def mark_start(z, u, slope, span, mode, body, pad, marks):
    """Mark a bound on the size of the rates, and so on accelerations, within ``span``; return it."""
    cog_rate(z, u, slope, mode, body, pad)
    size = (norm_at(pad, 0, body) + body.cogs[ROOT] * abs(pad[0])) * exp(body.cogs[ROOT] * span)
    marks[FASTEST] = max(marks[FASTEST], size)
    return size


def mark_end(z, slope, end, span, cogs, marks):
    """Mark a piece of ``span`` on a slope, and its end."""
    if not is_stable(slope):
        marks[LOOSE] += span
    room = room_on(z[0], slope, cogs)
    if end == TURNED:
        marks[TURN_ROOM] = min(marks[TURN_ROOM], room)
    if end > TURNED:
        speed = abs(z[1])
        marks[SLOWNESS] += 1.0 / speed if speed > 0.0 else float("inf")
        marks[SLOWEST] = min(marks[SLOWEST], speed)
    # On its way a knob is nearest to a corner where it turns round, or where the way ends.
    marks[CORNER_ROOM] = min(marks[CORNER_ROOM], -1.0 if end > TURNED else room)


def mark_turn(pull, rate, mode, left, body, marks):
    """Mark where friction turns round a motion that decelerated by ``rate``, to another ``mode``."""
    marks[LEVEL] = min(marks[LEVEL], abs(abs(pull) - body.friction))
    slowed = abs(rate)
    marks[TURNING] += 1.0 / slowed if slowed > 0.0 else float("inf")
    marks[LEAST_TURN] = min(marks[LEAST_TURN], slowed)
    if mode == 0:
        marks[STUCK_FOR] = min(marks[STUCK_FOR], slowed * left)


def cog_columns(cogs, z, u, span, body, pad, columns, marks):
    """As `advance.rub_columns`, from corner to corner, with its ``marks``."""
    if cogs is None or not len(cogs):
        return
    left = span
    slope = slope_at(z[0], cogs)
    rubs = body.friction > 0.0
    more = rubs and body.order > 2
    steep = rate_bound(body, pad) if more else 0.0
    mode = begin_hold(z, u, slope, span, body, pad, marks)
    fresh = mode != 0 and z[1] == 0.0
    slowed, let_go = inf, 0.0
    while left > 0.0:
        fast = 0.0
        if mode != 0 or more:
            fast = mark_start(z, u, slope, left, mode, body, pad, marks)
        if more:
            keep(z, FIRST, pad)
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        spread_cogs(columns, t, slope, mode, body, pad)
        left -= t
        mark_end(z, slope, end, t, cogs, marks)
        if more:
            piece = Piece(slope, mode, t, end, left, fast, steep, slowed, let_go)
            let_go = mark_piece(z, u, piece, body, pad, marks)
        if end == 0:
            break
        before = mode
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh, slowed = True, inf
        if rubs and end == TURNED and before != 0:
            pull = cog_acceleration(z, u, slope, body)
            rate = pull - before * body.friction
            slowed = abs(rate)
            mark_turn(pull, rate, mode, left, body, marks)
            after = 0.0 if mode == 0 else pull - mode * body.friction
            if rate != 0.0:
                turn_round(columns, (after - rate) / rate, body)
    if rubs and mode != 0:
        marks[SPEED] = min(marks[SPEED], abs(z[1]))
