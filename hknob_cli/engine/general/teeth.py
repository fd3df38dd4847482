"""Teeth with play: the motion from flank to flank, exact; teeth press, they never pull.

The mesh's angle d is counted from the flank on which the wall holds the push; the other flank is at -play. With o, the
overlap of teeth on a flank, they carry max(0, k o + c o') where o > 0, and nothing else: a tooth whose spring and
damper would pull is left, and relaxes. The torque is that of the state alone, so that it needs no memory. It jumps, by
c o', where teeth meet; where they part it is 0 on both sides. So there are three linear modes, and their ends are zeros
of o, or of the torque. As in `slide_many` a step is halved until each can be shown to keep its sign in it or to be
monotone: second derivatives are bounded by the energy of the rates, which never grows within a mode.

With friction the motor slides, one way or the other, or is held: each flank has three modes. What ends one is a zero of
the motor's speed, or of what friction lacks to hold it, beside those of the teeth. Cogging of the motor has two linear
modes of each in which it moves, and a corner of its torque is one more end; ``slope`` is its number.
"""

from math import floor, sqrt

from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_STUCK,
    ENTRY,
    HALVES,
    HALVES_HELD,
    HALVINGS,
    HELD,
    RATES,
    STUCK,
    STUCK_HALVES,
    coil_at,
    norm_at,
    stiffness,
)
from hknob_cli.engine.general.cogging import (
    FREE,
    ROOT,
    TOOTHED_HALVES,
    TURNED,
    cog_number,
    corner_passed,
    corner_told,
    has_cogs,
    is_stable,
    least_share,
    slope_pull,
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
from hknob_cli.engine.general.slide_two import way

APART = 2  # modes of a piece that is written down, by the sign of the speed: 1 on the wall's flank, 2 on none,
BACK = 3  # and 3 on the other; with a motor that friction holds 0,
STUCK_APART, STUCK_BACK = 4, 5  # and these
ON_STABLE, ON_UNSTABLE = 7, 10  # what is added to one of a motor that moves on a slope of cogging
SPRUNG = 4  # end of a mode, beside `TURNED`, that of the motor's way, and corners of cogging: of what teeth did


def overlap(d, side, body):
    """How far teeth overlap on a flank, +1 the wall's and -1 the other; below 0 they do not touch."""
    return d if side > 0 else -(d + body.play)


def pressing(z, at, side, body):
    """Torque of the mesh on a flank if teeth touch there, as an acceleration of the motor, out of the gap."""
    return body.pad_stiffness * overlap(z[at + 2], side, body) + side * body.pad_damping * z[at + 3]


def touches(z, at, side, body):
    """Whether teeth press on a flank: they overlap, and spring and damper do not pull."""
    return overlap(z[at + 2], side, body) > 0.0 and pressing(z, at, side, body) > 0.0


def flank(z, body):
    """Flank on which teeth press: +1 the wall's, -1 the other, 0 none."""
    if touches(z, 0, 1, body):
        return 1
    return -1 if touches(z, 0, -1, body) else 0


def teeth_rate(z, u, side, toward, body, out, slope=0.0):
    """Rate of the state under the command ``u``, on a flank or on none.

    ``toward``: sign of the motor's speed, against which friction acts; 0 where there is none, or where it holds.
    """
    n = body.order
    if toward == 0 and body.friction > 0.0:
        matrix = (STUCK + (1 if side == 0 else 0)) * n * n
        for i in range(n):
            total = body.vectors[CONSTANT_STUCK * n + i]
            for j in range(n):
                total += body.matrices[matrix + i * n + j] * z[j]
            out[i] = total
        if side < 0:
            out[3] -= body.ratio * body.pad_stiffness * body.play
        if body.lag > 0.0:
            out[n - 1] += body.lag * u
        return
    matrix = (HELD if side == 0 else RATES) * n * n
    command = (0.0 if body.lag > 0.0 else u) - toward * body.friction
    if has_cogs(body.cogs):
        command += slope_pull(body.cogs, z[0], slope)
    for i in range(n):
        total = body.vectors[CONSTANT * n + i] + body.vectors[ENTRY * n + i] * command
        for j in range(n):
            total += body.matrices[matrix + i * n + j] * z[j]
        out[i] = total
    if side < 0:
        away = body.pad_stiffness * body.play
        out[1] -= away
        out[3] -= (1.0 + body.ratio) * away
    if body.lag > 0.0:
        out[n - 1] += body.lag * u


def teeth_pull(z, at, u, side, body, slope=0.0):
    """Acceleration of the motor without friction, on a flank or on none."""
    n = body.order
    matrix = (HELD if side == 0 else RATES) * n * n
    total = body.vectors[CONSTANT * n + 1]
    if has_cogs(body.cogs):
        total += slope_pull(body.cogs, z[at], slope)
    if body.lag == 0.0:
        total += u
    for j in range(n):
        total += body.matrices[matrix + n + j] * z[at + j]
    if side < 0:
        total -= body.pad_stiffness * body.play
    return total


def direction(z, u, side, body, slope=0.0):
    """Sign of the motor's speed from here on; 0 where friction holds it."""
    pull = teeth_pull(z, 0, u, side, body, slope)
    if body.friction > 0.0:
        return way(z[1], pull, body.friction)
    return 1 if z[1] > 0.0 or (z[1] == 0.0 and pull > 0.0) else -1


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


def told(z, u, pad, side, toward, h, pace, twist, jerk, body, slope=0.0):
    """Whether each of these happens at most once within ``h``: teeth part or meet, a corner is passed, the motor turns.

    ``pace``, ``twist`` and ``jerk`` bound the second derivatives of the mesh's angle, of its torque and of the motor's
    speed, on an unstable slope as the rates are now.
    """
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


def halves_of(side, toward, slope, body):
    """Where `Body.matrices` has D, as `HALVES`, of a mode."""
    if toward == 0 and body.friction > 0.0:
        return STUCK_HALVES + (HALVINGS if side == 0 else 0)
    if has_cogs(body.cogs):
        return TOOTHED_HALVES + ((0 if side != 0 else 2) + (0 if is_stable(slope) else 1)) * HALVINGS
    return HALVES_HELD if side == 0 else HALVES


def press(z, u, side, toward, left, fresh, body, pad, slope=0.0):
    """Move ``z`` on one flank, or on none, until that ends or ``left`` is over: ``(time, end of `over_now`, least)``.

    ``toward``: sign of the motor's speed where its turning points end the motion, too; else 0. With friction it is 0
    where that holds the motor, until it is released. ``fresh``: whether it
    begins where another has ended: what is then too near to be told is taken after 2^-20 of a sample. An end is left
    past it, by the last bit of a sample period. ``least``: bound from below on the torque of the mesh, on a flank.
    """
    n = body.order
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
        deepest = SHORTEST if fresh else HALVINGS - 1
        clear = told(z, u, pad, side, toward, h, pace, twist, jerk, body, slope)
        while not clear and half < deepest:
            half += 1
            h *= 0.5
            clear = told(z, u, pad, side, toward, h, pace, twist, jerk, body, slope)
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
