"""How slow a motion over corners slides, and how nearly friction holds it, with more states than angle and speed.

Of angle and speed alone a slide under one torque is slowest where it begins or ends, and what is held stays so. With a
lag, a finger or a winding it may be slow on its way, and be let go on its way. So each piece is followed once more, and
a bound from below is marked on its speed, or on what friction can hold beside the torque, for all but the time beside
its ends:

- Where it stops at a deceleration r, that is at least r / 2 for a time of r / (2 bend) before, where ``bend`` bounds
  the rate of accelerations. Where it starts from rest under an acceleration, the same holds after.
- Where it is held as a hold begins, what stops another motion is at least half of what it is then for a time of that
  over 2 bend.
- Where it is let go, the torque grows at a rate p. That is at least 3 p / 4 for a time of p / (4 bend) on either side,
  where ``bend`` bounds how fast the rate changes.

`turn_alike` is what a proof makes of such marks.
"""

from typing import NamedTuple

from hknob_cli.engine.general.body import stiffness
from hknob_cli.engine.general.cogging import ROOT, TURNED, unit_reach
from hknob_cli.engine.general.columns import (
    FASTEST,
    LEAST_RELEASE,
    LEAST_TURN,
    LEVEL,
    RELEASED_FOR,
    RELEASING,
    SPEED,
    STUCK_FOR,
    TURNING,
)
from hknob_cli.engine.general.slide_many import held_slope
from hknob_cli.engine.general.slopes import cog_acceleration, cog_rate, roll, stays_over

FIRST, LAST = 2, 3  # places behind the work space of a step: the state in which a piece begins, and its end
TRIED = 8  # bounds, each half of the one before
WITHIN = 0.9  # of what there is room for


class Piece(NamedTuple):
    """A piece of a motion on one slope of cogging, in one mode.

    ``slope``, ``mode``, ``span``; ``end``: how it ends, 0 if the hold does; ``left``: of the hold, behind it; ``fast``:
    bound on the size of its rates; ``steep``: `corners.rate_bound`; ``slowed``: deceleration at the stop in which it
    begins, inf of others; ``let_go``: rate of the torque at the release in which it begins, 0 of others.
    """

    slope: float
    mode: int
    span: float
    end: int
    left: float
    fast: float
    steep: float
    slowed: float
    let_go: float


def keep(z, place, pad):
    """Keep a state at a place of ``pad``."""
    for j in range(len(z)):
        pad[place * len(z) + j] = z[j]


def bring(z, place, pad):
    """Bring a state back from a place of ``pad``."""
    for j in range(len(z)):
        z[j] = pad[place * len(z) + j]


def least_value(z, u, wait, span, most, piece, body, pad):
    """Bound from below on the speed, or what friction can hold, from ``wait`` behind the beginning on, over ``span``.

    ``most``: a value that it has somewhere. Overwrites ``z``.
    """
    need = most
    for _ in range(TRIED):
        need *= 0.5
        bring(z, FIRST, pad)
        if wait > 0.0:
            roll(z, u, piece.slope, piece.mode, wait, True, body, pad)
        if stays_over(z, u, piece.slope, piece.mode, span, need, body, pad):
            return need
    return 0.0


def mark_held(z, u, piece, body, pad, marks):
    """As `mark_piece`, of a piece in which friction holds the knob. Overwrites ``z``."""
    span, let_go, slope = piece.span, 0.0, piece.slope
    last = body.friction - abs(cog_acceleration(z, u, slope, body))
    if piece.end == TURNED:
        cog_rate(z, u, slope, 0, body, pad)
        let_go = abs(held_slope(pad, body))
        marks[RELEASING] += 1.0 / let_go if let_go > 0.0 else float("inf")
        marks[LEAST_RELEASE] = min(marks[LEAST_RELEASE], let_go)
        marks[RELEASED_FOR] = min(marks[RELEASED_FOR], let_go * min(span, piece.left))
        before = let_go / (4.0 * piece.steep * piece.steep * piece.fast) if piece.fast > 0.0 else span
        span -= before
        last = 0.5 * let_go * before
    bring(z, FIRST, pad)
    first = body.friction - abs(cog_acceleration(z, u, slope, body))
    stuck, bend = piece.span, piece.steep * piece.fast
    if piece.slowed == float("inf") and bend > 0.0:
        stuck = min(stuck, first / (2.0 * bend))  # what stops another motion that begins here is half of it until then
    marks[STUCK_FOR] = min(marks[STUCK_FOR], 0.5 * min(piece.slowed, first) * stuck)
    if span > 0.0:
        marks[LEVEL] = min(marks[LEVEL], least_value(z, u, 0.0, span, min(first, last), piece, body, pad))
    return let_go


def mark_slide(z, u, piece, body, pad, marks):
    """As `mark_piece`, of a piece in which the knob slides. Overwrites ``z``."""
    slope, mode, bend, last, ahead, wait = piece.slope, piece.mode, piece.steep * piece.fast, abs(z[1]), 0.0, 0.0
    if not bend > 0.0:
        marks[SPEED] = 0.0
        return
    if piece.end == TURNED:
        slowed = abs(cog_acceleration(z, u, slope, body) - mode * body.friction)
        ahead = slowed / (2.0 * bend)
        last = 0.5 * slowed * ahead
    bring(z, FIRST, pad)
    if z[1] == 0.0:
        wait = piece.let_go / (4.0 * piece.steep * bend)
        if piece.let_go == 0.0:
            cog_rate(z, u, slope, mode, body, pad)
            wait = abs(pad[1]) / (2.0 * bend)
    span = piece.span - wait - ahead
    if span > 0.0:
        if wait > 0.0:
            roll(z, u, slope, mode, wait, True, body, pad)
        marks[SPEED] = min(marks[SPEED], least_value(z, u, wait, span, min(abs(z[1]), last), piece, body, pad))
    elif wait > 0.0 and ahead > 0.0:
        marks[SPEED] = 0.0


def mark_piece(z, u, piece, body, pad, marks):
    """Mark how slow a piece is, or how nearly friction holds it; return the rate at which it is let go, or 0.

    Args:
        z: Its last state; the first is kept in ``pad``.
        u: Torque.
        piece: `Piece`.
        body: What moves, with friction.
        pad: Work space, of four states.
        marks: As `columns` has them.
    """
    keep(z, LAST, pad)
    let_go = 0.0
    if piece.mode == 0:
        let_go = mark_held(z, u, piece, body, pad, marks)
    else:
        mark_slide(z, u, piece, body, pad, marks)
    bring(z, LAST, pad)
    return let_go


def let_go_alike(pace, steep, late, marks):
    """As `turn_alike`, where the torque grows on a knob that is held until friction lets it go, within a hold.

    ``steep``: `corners.rate_bound`, or more.
    """
    if marks[RELEASING] == 0.0:
        return pace, 0.0
    least, pull = marks[LEAST_RELEASE], steep + late
    pace = min(pace, WITHIN * marks[RELEASED_FOR] / (8.0 * pull), 0.25 * least / (steep * pull))
    pace = min(pace, least * least / (8.0 * pull * steep * steep * marks[FASTEST]))
    return pace, 8.0 * pull * pull * marks[RELEASING]


def turn_alike(pace, steep, late, body, marks):
    """As `corners.pass_corners`, in the speed, where friction turns a motion round, holds it, or lets it go.

    Args:
        pace: How much speeds may differ.
        steep: `corners.rate_bound`; not asked for with angle and speed alone.
        late: Of torques that are still under way, and differ in sum by no more than speeds may, 1; else 0.
        body: What moves.
        marks: Of a period.
    """
    added = 0.0
    pace = min(pace, WITHIN * marks[SPEED], WITHIN * 0.25 * marks[STUCK_FOR])
    stiff, bend = 2.0 / unit_reach(body) + body.alpha, marks[FASTEST] * (stiffness(body) + body.cogs[ROOT])
    if body.order > 2:
        pace, added = let_go_alike(pace, steep, late, marks)
        stiff, bend = 4.0 * steep, marks[FASTEST] * steep
    stiff += late
    if marks[TURNING] == 0.0:
        return min(pace, 0.5 * marks[LEVEL] / stiff), added
    least = marks[LEAST_TURN]  # above 0, as the level there is at least half of it
    pull = stiff + 4.0 * bend / least  # by which torques differ at a turn, times the difference of speeds
    pace = min(pace, 0.5 * min(marks[LEVEL], least) / pull)
    return pace, added + 16.0 * marks[TURNING] * (stiff + bend / least)
