"""Ends of modes of teeth with play: what is known of a step before it is taken, and the motion up to an end.

As in `slide_many` a step is halved until each zero that ends a mode can be shown to come once at most in it:
second derivatives are bounded by the energy of the rates, which never grows within a mode.
"""

from math import floor, sqrt
from typing import NamedTuple

from hknob_cli.engine.general.body import HALVINGS, HELD, RATES, coil_at, norm_at, stiffness
from hknob_cli.engine.general.cogging import (
    FREE,
    ROOT,
    TURNED,
    cog_number,
    corner_passed,
    corner_told,
    has_cogs,
    least_share,
)
from hknob_cli.engine.general.slide_many import (
    FINEST,
    SHORTEST,
    accept,
    held_bound,
    keeps_sign,
    sliding_bound,
    stretch,
)
from hknob_cli.engine.general.teeth import SPRUNG, halves_of, overlap, pressing, teeth_pull, teeth_rate, touches


class Mode(NamedTuple):
    """A mode of teeth.

    ``side``: flank on which they press, 0 none; ``toward``: sign of the motor's speed where its turning points end the
    motion, too, else 0, with friction where that holds the motor until it is released; ``slope``: of cogging.
    """

    side: int
    toward: int
    slope: float


class Bounds(NamedTuple):
    """Bounds on the second derivatives of the mesh's angle, of its torque and of the motor's speed within a step."""

    pace: float
    twist: float
    jerk: float


def seen(z, pad, side, h, pace, twist, body):
    """Whether it can be told what becomes of a flank within ``h``: 2 nothing, 1 one change at most, 0 not told.

    ``side``: of the flank. ``pad`` has the rates of a mode in which no tooth presses there; ``pace`` and ``twist``
    bound the second derivatives of the mesh's angle and of its torque.
    """
    over = overlap(z[2], side, body)
    if keeps_sign(-over, -side * pad[2], pace, h):
        return 2
    if not over > 0.0:
        return 1 if abs(pad[2]) > pace * h else 0
    slope = side * (body.pad_stiffness * pad[2] + body.pad_damping * pad[3])
    if keeps_sign(-pressing(z, 0, side, body), -slope, twist, h):
        return 2
    return 1 if abs(slope) > twist * h else 0


def stuck_told(z, u, pad, side, h, body, slope=0.0):
    """Whether it can be told what becomes of a motor that friction holds within ``h``: nothing, or a release, once."""
    n = body.order
    matrix = (HELD if side == 0 else RATES) * n * n
    rate = 0.0
    for j in range(n):
        rate += body.matrices[matrix + n + j] * pad[j]
    bound = held_bound(pad, body)
    value = body.friction - abs(teeth_pull(z, 0, u, side, body, slope))
    return bound == 0.0 or keeps_sign(value, -abs(rate), bound, h) or abs(rate) > bound * h


def told(z, u, pad, mode, h, bounds, body):
    """Whether each of these happens at most once within ``h``: teeth part or meet, a corner is passed, the motor turns.

    ``bounds`` are on an unstable slope as the rates are now.
    """
    side, toward, slope = mode
    pace, twist, jerk = bounds
    if pace == 0.0:
        return True  # no torque changes, and teeth do not move against each other
    stuck = toward == 0 and body.friction > 0.0
    if has_cogs(body.cogs) and not stuck:
        share = least_share(body.cogs, slope, h)
        if share == 0.0:
            return False
        pace, twist, jerk = pace / share, twist / share, jerk / share
        if not corner_told(body.cogs, z[0], pad[0], pace, slope, FREE if toward == 0 else toward, h):
            return False
    if stuck:
        turning = stuck_told(z, u, pad, side, h, body, slope)
    elif toward != 0 and jerk > 0.0 and not keeps_sign(toward * z[1], toward * pad[1], jerk, h):
        turning = abs(pad[1]) > jerk * h
    else:
        turning = True  # no turn is asked for, or none comes, or the speed changes evenly: it turns once at most
    if side != 0:
        rate = side * (body.pad_stiffness * pad[2] + body.pad_damping * pad[3])
        return turning and (keeps_sign(pressing(z, 0, side, body), rate, twist, h) or abs(rate) > twist * h)
    one, other = seen(z, pad, 1, h, pace, twist, body), seen(z, pad, -1, h, pace, twist, body)
    return turning and one + other > 2


def teeth_over(z, at, side, body):
    """Whether the state that begins at ``z[at]`` is past the end of what teeth did: they have parted, or met."""
    if side != 0:
        return pressing(z, at, side, body) < 0.0
    return touches(z, at, 1, body) or touches(z, at, -1, body)


def over_now(pad, u, side, toward, body, slope=0.0):
    """Which end of a mode the state in the second half of ``pad`` is past; 0 of none.

    `TURNED`: a turning point, or the release of a motor that friction holds; `cogging.RISEN`, `cogging.FALLEN`: a
    corner; else `SPRUNG`.
    """
    n = body.order
    if pad[n + 1] * toward < 0.0:
        return TURNED
    if toward == 0 and body.friction > 0.0:
        if abs(teeth_pull(pad, n, u, side, body, slope)) > body.friction:
            return TURNED
    elif has_cogs(body.cogs):
        corner = corner_passed(body.cogs, pad[n], pad[n + 1], slope)
        if corner != 0:
            return corner
    return SPRUNG if teeth_over(pad, n, side, body) else 0


def least_torque(z, pad, side, h, twist, body):
    """Bound from below on the torque of the mesh over a step ``h``, whose end is in the second half of ``pad``.

    A monotone torque is least at an end. Else there are two bounds: the chord less its error, which is at most an
    eighth of ``twist`` times the square of the step, and what shows that it keeps its sign.
    """
    first = pressing(z, 0, side, body)
    slope = side * (body.pad_stiffness * pad[2] + body.pad_damping * pad[3])
    ends = min(first, pressing(pad, body.order, side, body))
    if abs(slope) > twist * h:
        return ends
    return max(ends - 0.125 * twist * h * h, first + min(slope, 0.0) * h - 0.5 * twist * h * h)


def loose_bound(pad, body):
    """As `slide_many.sliding_bound`, of a motor whose teeth do not press: nothing of the knob's motion reaches it."""
    late = abs(pad[body.order - 1]) if body.lag > 0.0 else 0.0
    square = pad[1] * pad[1]
    if body.coil > 0.0:
        square += body.coil * pad[coil_at(body)] * pad[coil_at(body)]
    size = sqrt(square) + (late / body.lag if body.lag > 0.0 else 0.0)
    root = cog_number(body.cogs, ROOT)
    return (size + root * abs(pad[0])) * (body.alpha + sqrt(body.coil) + root) + late


def press(z, u, mode, left, fresh, body, pad):
    """Move ``z`` in a `Mode` until that ends or ``left`` is over: ``(time, end of `over_now`, least)``.

    ``fresh``: whether it begins where another has ended: what is then too near to be told is taken after 2^-20 of a
    sample. An end is left past it, by the last bit of a sample period. ``least``: bound from below on the torque of
    the mesh, on a flank.
    """
    n = body.order
    side, toward, slope = mode
    total, least, carried = 0.0, float("inf"), float("inf")
    half = 0
    left = floor(left * FINEST) / FINEST
    table = halves_of(side, toward, slope, body)
    root, cog_root = sqrt(body.ratio), cog_number(body.cogs, ROOT)
    own = body.ratio * sqrt(body.pad_stiffness) + body.pad_damping * body.ratio * (1.0 + root)
    own += body.finger_damping * root + sqrt(body.finger_stiffness * body.ratio)
    while left > 0.0 and not body.halt[0] > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        teeth_rate(z, u, side, toward, body, pad, slope)
        size, jerk = norm_at(pad, 0, body), sliding_bound(pad, 0, body)
        if has_cogs(body.cogs):
            more = cog_root * abs(pad[0])
            jerk += more * stiffness(body) + (size + more) * cog_root
            size += more
        pace = size * (1.0 + root)
        twist = body.pad_stiffness * pace + body.pad_damping * (jerk + own * size)
        if side == 0 and (body.friction > 0.0 or body.alpha > 1.0):
            jerk = loose_bound(pad, body)  # else a motor that slows down for ever is followed in tiny steps
        bounds = Bounds(pace, twist, jerk)
        deepest = SHORTEST if fresh else HALVINGS - 1
        clear = told(z, u, pad, mode, h, bounds, body)
        while not clear and half < deepest:
            half += 1
            h *= 0.5
            clear = told(z, u, pad, mode, h, bounds, body)
        stretch(z, pad, table + half, body)
        ended = over_now(pad, u, side, toward, body, slope)
        if side != 0:
            share = least_share(body.cogs, slope, h)
            carried = least_torque(z, pad, side, h, twist / share, body) if share > 0.0 else -1.0
        if ended > 0 and clear:
            for deeper in range(half + 1, HALVINGS):
                teeth_rate(z, u, side, toward, body, pad, slope)
                stretch(z, pad, table + deeper, body)
                sooner = over_now(pad, u, side, toward, body, slope)
                if sooner > 0:
                    ended = sooner
                else:
                    accept(z, pad, n)
                    total += 0.5**deeper
            teeth_rate(z, u, side, toward, body, pad, slope)
            stretch(z, pad, table + HALVINGS - 1, body)
            accept(z, pad, n)
            return total + 0.5 ** (HALVINGS - 1), ended, -1.0 if ended == SPRUNG else min(least, carried)
        if side != 0:
            least = min(least, carried)
        accept(z, pad, n)
        total += h
        left -= h
        fresh = False
        if ended > 0:
            return total, ended, -1.0 if ended == SPRUNG else least
        if half > 0:
            half -= 1
    return total, 0, least
