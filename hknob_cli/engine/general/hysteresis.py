"""The count between samples, where an encoder has hysteresis: a turning point there can change it for good.

A count that only the samples could change would miss what the motion does between them. The extremes of a motion
decide (its count goes by them alone, as all rate-independent memory does: Brokate & Sprekels 1996), so that
the count is taken at each of its turning points, which are exact.
"""

from hknob_cli.engine.general.advance import FREE, UNKNOWN, advance_hold, next_mode, slide
from hknob_cli.engine.general.body import HALVES, HALVINGS, acceleration, distance, rate_of
from hknob_cli.engine.general.cogging import TURNED, has_cogs, slope_at, slope_of
from hknob_cli.engine.general.controller import edge_gap, read_after
from hknob_cli.engine.general.flanks import STILL, pass_any_end, play_many, still_in_teeth
from hknob_cli.engine.general.slide_two import way
from hknob_cli.engine.general.slopes import cog_many, pass_on, roll, settled, way_from
from hknob_cli.engine.general.teeth import direction, flank
from hknob_cli.engine.general.teeth_ends import Mode, press


def way_at_most(z, u, span, body, pad):
    """How far a body of more states without friction moves at most over ``span`` under ``u``; inf of another.

    Its rates are a motion without a torque, whose energy never grows.
    """
    if body.order == 2 or body.friction > 0.0:
        return float("inf")
    rate_of(z, u, FREE, body, pad)
    return distance(pad, body) * span


def pass_still(z, u, span, body, pad):
    """Move a body of more states without friction over ``span``, by its binary digits, past all turning points."""
    half, h = 0, 1.0
    while span > 0.0 and half < HALVINGS:
        if span >= h:
            advance_hold(z, u, HALVES + half, body, pad)
            span -= h
        half += 1
        h *= 0.5


def turn_teeth(z, u, span, shown, body, wall, pad):
    """As `turn_and_count`, from flank to flank."""
    left, margin = span, float("inf")
    side, slope = flank(z, body), slope_of(body.cogs, z[0])
    moved = still_in_teeth(z, u, side, slope, span, body, pad)
    if moved <= STILL * (1.0 + abs(z[0])):
        margin = edge_gap(z[0], shown, shown, wall) - moved
        play_many(z, u, span, body, pad)
        return shown, margin
    toward = direction(z, u, side, body, slope)
    fresh = body.friction > 0.0 and toward != 0 and z[1] == 0.0
    while left > 0.0:
        t, ended, _ = press(z, u, Mode(side, toward, slope), left, fresh, body, pad)
        left -= t
        if ended == 0:
            break
        ago = toward
        side, toward, slope = pass_any_end(z, u, side, toward, slope, ended, body)
        fresh = True
        if ago != 0 and toward != ago:
            before = shown
            shown = read_after(z[0], before, wall)
            margin = min(margin, edge_gap(z[0], shown, before, wall))
    return shown, margin


def turn_on_cogs(cogs, z, u, span, shown, body, wall, pad):
    """As `turn_and_count`, from corner to corner."""
    if cogs is None or not len(cogs):
        return shown, float("inf")
    left, margin = span, float("inf")
    slope = slope_at(z[0], cogs)
    still, moved = settled(cogs, z, u, slope, span, body, pad)
    if still:
        margin = edge_gap(z[0], shown, shown, wall) - moved
        cog_many(cogs, z, u, span, body, pad)
        return shown, margin
    mode = way_from(z, u, slope, body)
    fresh = mode != 0 and z[1] == 0.0
    while left > 0.0:
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        left -= t
        if end == 0:
            break
        if end == TURNED and mode != 0:
            before = shown
            shown = read_after(z[0], before, wall)
            margin = min(margin, edge_gap(z[0], shown, before, wall))
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True
    return shown, margin


def turn_and_count(z, u, span, shown, body, wall, pad):
    """Move ``z`` over a hold from event to event: ``(count after the last turning point, margin)``.

    ``shown``: the count at the start; the margin is how far the turning points may move until the command changes.
    """
    if body.play > 0.0:
        return turn_teeth(z, u, span, shown, body, wall, pad)
    if has_cogs(body.cogs):
        return turn_on_cogs(body.cogs, z, u, span, shown, body, wall, pad)
    left, margin = span, float("inf")
    moved = way_at_most(z, u, span, body, pad)
    if moved <= STILL * (1.0 + abs(z[0])):
        margin = edge_gap(z[0], shown, shown, wall) - moved
        pass_still(z, u, span, body, pad)
        return shown, margin
    mode = way(z[1], acceleration(z, u, body), body.friction)
    while left > 0.0:
        t, ended, _ = slide(z, u, mode, left, UNKNOWN, False, body, pad)
        left -= t
        if not ended:
            break
        before = shown
        shown = read_after(z[0], before, wall)
        margin = min(margin, edge_gap(z[0], shown, before, wall))
        mode = next_mode(mode, z, u, body)
    return shown, margin


def commands_of(u, ring, head):
    """Commands of both parts of an interval at whose sample ``u`` is commanded; ``ring`` does not hold it yet."""
    delay = len(ring)
    if delay == 0:
        return u, u
    return ring[head], u if delay == 1 else ring[(head + 1) % delay]


def hold_and_count(z, u, shown, ring, head, body, wall, pad):
    """As `interval.hold`, but ``ring`` is left as it is: ``(count after the last turning point, margin)``."""
    older, later = commands_of(u, ring, head)
    margin = float("inf")
    if wall.split > 0.0:
        shown, margin = turn_and_count(z, older, wall.split, shown, body, wall, pad)
    shown, more = turn_and_count(z, later, 1.0 - wall.split, shown, body, wall, pad)
    return shown, min(margin, more)
