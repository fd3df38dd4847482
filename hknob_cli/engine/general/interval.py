"""One sample interval of the general loop: how long it is, sense, command, and move under what is commanded.

A clock that jitters draws each interval evenly between two lengths, in the longest one. It is a flat array: the state
of its random numbers, the shortest interval, by how much the longest is longer, the seed, the number of the first
trial, and the interval that is meant, by which firmware has its numbers. The random numbers are those of Park & Miller
(1988, "minimal standard"), s -> 16807 s mod 2^31 - 1, whose products a double holds exactly: compiled or not, they are
the same.

The compiler makes code of its own for scenes without any part of this kind, in which nothing of this is left: a clock
that is None is known by its type. Beside other such parts it is empty (`search.as_compiled`).
"""

from hknob_cli.engine.general.advance import FREE, advance_hold, advance_span, rub_columns, rub_many
from hknob_cli.engine.general.body import FIRST, SECOND, acceleration
from hknob_cli.engine.general.cogging import has_cogs, has_gone
from hknob_cli.engine.general.columns import Columns, feed, spread_many, spread_two
from hknob_cli.engine.general.controller import command, read_after
from hknob_cli.engine.general.hysteresis import hold_and_count, turn_and_count
from hknob_cli.engine.general.slide_two import step_with_friction

STATE, SHORTEST, SPREAD, SEED, TRIAL, MEANT = range(6)
FACTOR, MODULUS = 16807.0, 2147483647.0
PASSED_OVER = 8  # numbers that are passed over: those of neighbouring trials are alike at first


def jitters(clock):
    """Whether intervals differ."""
    if clock is None:
        return False
    return bool(len(clock))


def next_span(clock):
    """Length of the next interval, in the longest; 1 without jitter."""
    if clock is None or not len(clock):
        return 1.0
    clock[STATE] = (FACTOR * clock[STATE]) % MODULUS
    return clock[SHORTEST] + clock[SPREAD] * (clock[STATE] / MODULUS)


def meant_pace(speed, clock):
    """A speed in counts over the interval that is meant, from counts over the longest; the same without jitter."""
    if clock is None or not len(clock):
        return speed
    return clock[MEANT] * speed


def begin_clock(clock, trial):
    """Set a clock to the beginning of a trial, by its number."""
    if clock is None or not len(clock):
        return
    clock[STATE] = (65539.0 * clock[SEED] + 30269.0 * (trial + clock[TRIAL])) % (MODULUS - 1.0) + 1.0
    for _ in range(PASSED_OVER):
        clock[STATE] = (FACTOR * clock[STATE]) % MODULUS


def hold(z, u, ring, head, body, wall, pad):
    """Move ``z`` over one interval at whose sample ``u`` is commanded; the new head of ``ring``."""
    older = u
    delay = len(ring)
    if delay > 0:
        older = ring[head]
        ring[head] = u
        head = (head + 1) % delay
        u = ring[head]
    if body.order == 2 and not has_cogs(body.cogs):
        x, v = z[0], z[1]
        if body.friction > 0.0:
            if wall.split > 0.0:
                x, v = step_with_friction(x, v, older, wall.split, body.s1, body.g1, body.f1, body)
            x, v = step_with_friction(x, v, u, 1.0 - wall.split, body.s2, body.g2, body.f2, body)
        else:
            if wall.split > 0.0:
                y = older + body.drive - body.beta * x
                x, v = x + (body.s1 * v + body.g1 * y), body.f1 * v + body.s1 * y
            y = u + body.drive - body.beta * x
            x, v = x + (body.s2 * v + body.g2 * y), body.f2 * v + body.s2 * y
        z[0], z[1] = x, v
    elif body.friction > 0.0 or body.play > 0.0 or has_cogs(body.cogs):
        if wall.split > 0.0:
            rub_many(z, older, wall.split, body, pad)
        rub_many(z, u, 1.0 - wall.split, body, pad)
    else:
        if wall.split > 0.0:
            advance_hold(z, older, FIRST, body, pad)
        advance_hold(z, u, SECOND, body, pad)
    return head


def advance(z, before, ring, head, body, wall, pad):
    """One interval from a sample to the next: ``(reading, head)``; ``ring`` holds the commands under way.

    With hysteresis the reading is that of the last turning point within the interval.
    """
    shown = read_after(z[0], before, wall)
    u = command(shown, before, wall)
    if wall.hysteresis > 0.0:
        shown, _ = hold_and_count(z, u, shown, ring, head, body, wall, pad)
        if len(ring) > 0:
            ring[head] = u
            head = (head + 1) % len(ring)
        return shown, head
    head = hold(z, u, ring, head, body, wall, pad)
    return shown, head


def advance_jittering(z, before, ring, head, body, wall, pad):
    """As `advance`, over an interval of random length; delays are of whole samples."""
    shown = read_after(z[0], before, wall)
    u = command(shown, before, wall)
    delay = len(ring)
    if delay > 0:
        ring[head] = u
        head = (head + 1) % delay
        u = ring[head]
    span = next_span(wall.clock)
    if wall.hysteresis > 0.0:
        shown, _ = turn_and_count(z, u, span, shown, body, wall, pad)
    else:
        advance_span(z, u, span, body, pad)
    return shown, head


def rubs_alone(ring, body, wall):
    """Whether a scene of angle and speed has no more than a plain one but friction, or a torque over the angle."""
    alone = body.order == 2 and len(ring) == 0 and body.friction > 0.0 and not has_cogs(body.cogs)
    return alone and wall.hysteresis == 0.0 and wall.damping == 0.0 and wall.analog == 0.0 and not jitters(wall.clock)


def pass_over(z, before, ring, head, budget, body, wall, pad):
    """The intervals that ``budget`` skips at once, as long as ``z`` stays within its limit: ``(reading, head)``."""
    limit = budget.limit
    delay = len(ring)
    if jitters(wall.clock):
        for _ in range(budget.skip):
            before, head = advance_jittering(z, before, ring, head, body, wall, pad)
            if has_gone(body.cogs, z, limit) or body.halt[0] > 0.0:
                break
        return before, head
    if body.order > 2 or body.friction == 0.0 or delay > 0 or wall.hysteresis > 0.0 or has_cogs(body.cogs):
        for _ in range(budget.skip):
            before, head = advance(z, before, ring, head, body, wall, pad)
            if has_gone(body.cogs, z, limit) or body.halt[0] > 0.0:
                break
        return before, head
    x, v = z[0], z[1]
    for _ in range(budget.skip):
        shown = read_after(x, before, wall)
        x, v = step_with_friction(x, v, command(shown, before, wall), 1.0, body.s2, body.g2, body.f2, body)
        before = shown
        if not -limit < x < limit:
            break
    z[0], z[1] = x, v
    return before, head


def balances(z, u, body):
    """Whether a body without friction stands still, to the last bit: friction's modes would say that it is held."""
    if body.friction > 0.0 or body.play > 0.0 or has_cogs(body.cogs):
        return False
    return z[1] == 0.0 and acceleration(z, u, body) == 0.0


def move_columns(z, older, u, body, wall, space, count):
    """Move ``z`` and ``count`` columns over an interval: under ``older`` up to the split, then under ``u``."""
    width, pad = space.width, space.pad
    parts = 2 if wall.split > 0.0 else 1
    for part in range(parts):
        # The part under the older command, if there is one, and the rest.
        first = part < parts - 1
        span = wall.split if first else 1.0 - wall.split
        sgf = (body.s1, body.g1, body.f1) if first else (body.s2, body.g2, body.f2)
        columns = Columns(space.cols, width * width if first else width * width + width, count, width)
        acting = older if first else u
        if wall.analog > 0.0 and balances(z, acting, body):
            advance_span(z, acting, span, body, pad)
            if body.order > 2:
                spread_many(columns, span, FREE, body, pad)
            else:
                spread_two(columns, sgf, body)
        else:
            rub_columns(z, acting, span, sgf, body, pad, columns, space.marks)


def advance_columns(z, before, ring, head, body, wall, space, count):
    """Like `advance`, with ``count`` columns of derivatives in ``space``, and there `rub_columns`'s ``marks``.

    With hysteresis, too, the reading is that of the sample.
    """
    shown = read_after(z[0], before, wall)
    u = command(shown, before, wall)
    delay = len(ring)
    feed(shown, before, delay, head, wall, space.cols, count, space.width)
    older = u
    if delay > 0:
        older = ring[head]
        ring[head] = u
        head = (head + 1) % delay
        u = ring[head]
    move_columns(z, older, u, body, wall, space, count)
    return shown, head
