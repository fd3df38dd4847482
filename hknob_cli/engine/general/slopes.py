"""Motion from slope to slope of cogging: mode after mode, with its derivative, and written down.

The torque has no jump at a corner, so that a difference of two motions goes through it as it is.
"""

from hknob_cli.engine.general.body import HALVES_HELD, HALVINGS, HELD
from hknob_cli.engine.general.cogging import (
    COGGED,
    COGGED_HALVES,
    FALLEN,
    FREE,
    RISEN,
    STABLE,
    TURNED,
    UNSTABLE,
    cog_acceleration,
    cog_rate,
    far_apart,
    is_stable,
    roll,
    room_on,
    slope_at,
)
from hknob_cli.engine.general.columns import spread_by, turn_round
from hknob_cli.engine.general.slide_two import way

STILL = 1e-11  # counts, relative: what moves by less has settled, and meets a velocity of 0 at every rounding


def way_from(z, u, slope, body):
    """Mode of the motion that begins at ``z`` where its turning points matter: +1 or -1 sliding, 0 held."""
    return way(z[1], cog_acceleration(z, u, slope, body), body.friction)


def settled(cogs, z, u, slope, span, body, pad):
    """Whether a knob that nothing rubs has settled on its slope, and how far it moves at most: ``(whether, way)``.

    Its turning points are roundings then. Its rates are a motion without a torque, whose energy bounds the way.
    """
    if body.friction > 0.0:
        return False, 0.0
    cog_rate(z, u, slope, FREE, body, pad)
    moved = far_apart(cogs, pad, z[0], body) * span
    return moved <= STILL * (1.0 + abs(z[0])) and moved < room_on(z[0], slope, cogs), moved


def pass_on(z, u, slope, mode, end, body):
    """Slope and mode after ``end``."""
    if end == RISEN:
        return slope + 1.0, mode
    if end == FALLEN:
        return slope - 1.0, mode
    pull = cog_acceleration(z, u, slope, body)
    if mode == 0:
        return slope, 1 if pull > 0.0 else -1
    z[1] = 0.0
    return slope, way(0.0, pull, body.friction)


def cog_many(cogs, z, u, span, body, pad):
    """Move ``z`` over any time up to a sample period from corner to corner; with friction from event to event."""
    if cogs is None or not len(cogs):
        return
    left = span
    slope = slope_at(z[0], cogs)
    mode = way_from(z, u, slope, body) if body.friction > 0.0 else FREE
    fresh = mode != 0 and z[1] == 0.0
    while left > 0.0:
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        left -= t
        if end == 0:
            break
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True


def spread_cogs(cols, command, count, width, span, slope, mode, body, pad):
    """Move the columns over ``span`` on one slope, in one mode."""
    if mode == 0:
        spread_by(cols, command, count, width, span, HELD, HALVES_HELD, False, body, pad)
    else:
        kind = 0 if is_stable(slope) else 1
        halves = COGGED_HALVES + kind * HALVINGS
        spread_by(cols, command, count, width, span, COGGED + kind, halves, True, body, pad)


def cog_columns(cogs, z, u, span, body, pad, cols, command, count, width, marks):
    """As `advance.rub_columns`, from corner to corner, with its ``marks``.

    ``marks[2]`` keeps the least distance to a corner; below 0 where one is passed.
    """
    if cogs is None or not len(cogs):
        return
    left = span
    slope = slope_at(z[0], cogs)
    rubs = body.friction > 0.0
    still, moved = settled(cogs, z, u, slope, span, body, pad)
    mode = way_from(z, u, slope, body)
    if still or (mode == 0 and not rubs):
        mode = FREE  # it balances, to a rounding, and nothing holds it
    fresh = mode != 0 and z[1] == 0.0
    if rubs and z[1] == 0.0:
        marks[0] = min(marks[0], abs(abs(cog_acceleration(z, u, slope, body)) - body.friction))
    marks[2] = min(marks[2], room_on(z[0], slope, cogs) - (moved if still else 0.0))
    while left > 0.0:
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        spread_cogs(cols, command, count, width, t, slope, mode, body, pad)
        left -= t
        # On its way a knob is nearest to a corner where it turns round, or where the way ends.
        marks[2] = min(marks[2], -1.0 if end > TURNED else room_on(z[0], slope, cogs))
        if end == 0:
            break
        before = mode
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True
        if rubs and end == TURNED and before != 0:
            pull = cog_acceleration(z, u, slope, body)
            marks[0] = min(marks[0], abs(abs(pull) - body.friction))
            rate = pull - before * body.friction
            after = 0.0 if mode == 0 else pull - mode * body.friction
            if rate != 0.0:
                turn_round(cols, count, width, (after - rate) / rate, body)
    if rubs and mode != 0:
        marks[1] = min(marks[1], abs(z[1]))


def cog_chart(cogs, z, u, span, body, pad, rows, pieces):
    """As `trace.chart`, from corner to corner; modes are by the sign of the speed `STABLE` or `UNSTABLE`, 0 held."""
    if cogs is None or not len(cogs):
        return rows
    n = body.order
    left = span
    slope = slope_at(z[0], cogs)
    mode = way_from(z, u, slope, body)
    fresh = mode != 0 and z[1] == 0.0
    while left > 0.0 and rows < len(pieces.spans):
        for j in range(n):
            pieces.states[rows * n + j] = z[j]
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        left -= t
        if t > 0.0:
            pieces.spans[rows], pieces.commands[rows] = t, u
            pieces.modes[rows] = mode * (STABLE if is_stable(slope) else UNSTABLE)
            rows += 1
        if end == 0:
            break
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True
    for j in range(n):
        pieces.states[rows * n + j] = z[j]
    return rows
