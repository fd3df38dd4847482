"""Gliding: the motion under one constant command, exact, from event to event.

With Coulomb friction the motion is piecewise linear: it slides one way until the velocity vanishes, and then turns
round or is held, until the other torques exceed the friction level.
"""

from hknob_cli.engine.general.body import acceleration, rate_of
from hknob_cli.engine.general.cogging import has_cogs
from hknob_cli.engine.general.columns import LEVEL, SPEED, spread_many, spread_two, turn_round
from hknob_cli.engine.general.flanks import play_columns, play_many
from hknob_cli.engine.general.slide_many import slide_many, stretch
from hknob_cli.engine.general.slide_two import coefficients, step_with_friction, until_zero, way
from hknob_cli.engine.general.slope_columns import cog_columns
from hknob_cli.engine.general.slopes import cog_many

FREE = 2  # mode of a motion whose turning points do not matter
UNKNOWN = (0.0, 0.0, 0.0)  # in place of coefficients of second order that are not known yet


def advance_hold(z, u, matrix, body, pad):
    """Move ``z`` over the time of ``matrix`` without friction."""
    n = body.order
    rate_of(z, u, FREE, body, pad)
    stretch(z, pad, matrix, body)
    for i in range(n):
        z[i] = pad[n + i]


def next_mode(mode, z, u, body):
    """Mode after ``mode`` has ended at ``z``."""
    pull = acceleration(z, u, body)
    if mode == 0:
        return 1 if pull > 0.0 else -1
    return way(z[1], pull, body.friction)


def rub_on(z, u, span, body, pad):
    """Move ``z`` of more states over a hold from event to event of friction; in how many steps."""
    left, steps = span, 0
    mode = way(z[1], acceleration(z, u, body), body.friction)
    while left > 0.0:
        t, ended, more = slide_many(z, u, mode, left, body, pad)
        left -= t
        steps += more
        if not ended:
            break
        mode = next_mode(mode, z, u, body)
    return steps


def rub_many(z, u, span, body, pad):
    """More states, with friction or play, or any beside cogging: move ``z`` over a hold from event to event."""
    if body.play > 0.0:
        play_many(z, u, span, body, pad)
        return
    if has_cogs(body.cogs):
        cog_many(body.cogs, z, u, span, body, pad)
        return
    rub_on(z, u, span, body, pad)


def advance_span(z, u, span, body, pad):
    """Move ``z`` over any time up to a sample period, friction or not."""
    if body.order > 2 or has_cogs(body.cogs):
        rub_many(z, u, span, body, pad)
        return
    s, g, f = coefficients(span, body)
    if body.friction > 0.0:
        z[0], z[1] = step_with_friction(z[0], z[1], u, span, s, g, f, body)
    else:
        y = u + body.drive - body.beta * z[0]
        z[0], z[1] = z[0] + (s * z[1] + g * y), f * z[1] + s * y


def slide(z, u, mode, left, sgf, known, body, pad):
    """Move ``z`` in one ``mode`` until it ends or ``left`` is over: ``(time, whether it ended, sgf)``.

    ``sgf``: coefficients (s, g, f) of second order over ``left``, if ``known``; those of the slide are returned.
    """
    if body.order > 2:
        t, ended, _ = slide_many(z, u, mode, left, body, pad)
        return t, ended, sgf
    if mode == 0:
        return left, False, (0.0, 0.0, 1.0)
    drive = u + body.drive - mode * body.friction
    sgf, t, ended = until_zero(z[0], z[1], drive, mode, left, sgf, known, body)
    s, g, f = sgf
    y = drive - body.beta * z[0]
    x = z[0] + (s * z[1] + g * y)
    z[1] = f * z[1] + s * y
    z[0] = x
    if ended or z[1] * mode < 0.0:
        z[1] = 0.0
    return t, ended, sgf


def rub_columns(z, u, span, sgf, body, pad, columns, marks):
    """Move ``z`` and columns of derivatives (`columns.Columns`) over a hold under ``u`` from event to event.

    ``sgf``: coefficients (s, g, f) of second order over ``span``. The columns follow the motion through its events
    (Leine & Nijmeijer 2004, sec. 7); ``marks`` as `columns` has them.
    """
    if body.play > 0.0:
        play_columns(z, u, span, body, pad, columns, marks)
        return
    if has_cogs(body.cogs):
        cog_columns(body.cogs, z, u, span, body, pad, columns, marks)
        return
    if body.order == 2 and z[1] != 0.0 and body.spacing >= span:
        # Most holds have no event.
        s, g, f = sgf
        x, v, ahead = z[0], z[1], 1.0 if z[1] > 0.0 else -1.0
        y = u + body.drive - ahead * body.friction - body.beta * x
        slow = f * v + s * y
        if slow * ahead >= 0.0:
            z[0], z[1] = x + (s * v + g * y), slow
            spread_two(columns, sgf, body)
            marks[SPEED] = min(marks[SPEED], abs(slow))
            return
    left = span
    known = left > 0.0
    pull = acceleration(z, u, body)
    mode = way(z[1], pull, body.friction)
    if z[1] == 0.0:
        marks[LEVEL] = min(marks[LEVEL], abs(abs(pull) - body.friction))
    while left > 0.0:
        t, ended, sgf = slide(z, u, mode, left, sgf, known, body, pad)
        if body.order > 2:
            spread_many(columns, t, mode, body, pad)
        elif mode != 0:
            spread_two(columns, sgf, body)
        known = left < 0.0
        left -= t
        if not ended:
            break
        pull = acceleration(z, u, body)
        then = next_mode(mode, z, u, body)
        if mode != 0:
            marks[LEVEL] = min(marks[LEVEL], abs(abs(pull) - body.friction))
            rate = pull - mode * body.friction
            after = 0.0 if then == 0 else pull - then * body.friction
            if rate != 0.0:
                turn_round(columns, (after - rate) / rate, body)
        mode = then
    if mode != 0:
        marks[SPEED] = min(marks[SPEED], abs(z[1]))
