"""Teeth with play: the motion from flank to flank, exact; teeth press, they never pull.

The mesh's angle d is counted from the flank on which the wall holds the push; the other flank is at -play. With o, the
overlap of teeth on a flank, they carry max(0, k o + c o') where o > 0, and nothing else: a tooth whose spring and
damper would pull is left, and relaxes. The torque is that of the state alone, so that it needs no memory. It jumps, by
c o', where teeth meet; where they part it is 0 on both sides. So there are three linear modes, and their ends are zeros
of o, or of the torque. As in `slide_many` a step is halved until each can be shown to keep its sign in it or to be
monotone: second derivatives are bounded by the energy of the rates, which never grows within a mode.

A difference of two motions keeps its direction where teeth part; where they meet, the rates jump by -c o' in the mesh,
and the difference by -c times its own part in d, however fast they meet (Leine & Nijmeijer 2004, sec. 7).
"""

from math import floor, sqrt

from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_HELD,
    ENTRY,
    HALVES,
    HALVES_HELD,
    HALVINGS,
    HELD,
    RATES,
    norm_at,
)
from hknob_cli.engine.general.columns import spread_many
from hknob_cli.engine.general.slide_many import FINEST, SHORTEST, accept, sliding_bound, stretch

APART = 2  # modes of a piece that is written down, by the sign of the speed: 1 on the wall's flank, 2 on none,
BACK = 3  # and 3 on the other


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


def teeth_rate(z, u, side, body, out):
    """Rate of the state under the command ``u``, on a flank or on none."""
    n = body.order
    matrix = (HELD if side == 0 else RATES) * n * n
    vector = (CONSTANT_HELD if side == 0 else CONSTANT) * n
    command = 0.0 if body.lag > 0.0 else u
    for i in range(n):
        total = body.vectors[vector + i] + body.vectors[ENTRY * n + i] * command
        for j in range(n):
            total += body.matrices[matrix + i * n + j] * z[j]
        out[i] = total
    if side < 0:
        away = body.pad_stiffness * body.play
        out[1] -= away
        out[3] -= (1.0 + body.ratio) * away
    if body.lag > 0.0:
        out[n - 1] += body.lag * u


def keeps_sign(value, slope, bound, h):
    """Whether a value stays above 0 over ``h``: ``slope`` is its rate now, ``bound`` is on its second derivative."""
    return value + min(slope, 0.0) * h - 0.5 * bound * h * h > 0.0 or (value > 0.0 and slope == 0.0 and bound == 0.0)


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


def told(z, pad, side, toward, h, pace, twist, jerk, body):
    """Whether at most one thing happens within ``h``, and once: the mode ends, or the motor turns round."""
    if toward != 0 and not keeps_sign(toward * z[1], toward * pad[1], jerk, h):
        turning = abs(pad[1]) > jerk * h
    else:
        turning = True
    if side != 0:
        slope = side * (body.pad_stiffness * pad[2] + body.pad_damping * pad[3])
        return turning and (keeps_sign(pressing(z, 0, side, body), slope, twist, h) or abs(slope) > twist * h)
    one, other = seen(z, pad, 1, h, pace, twist, body), seen(z, pad, -1, h, pace, twist, body)
    return turning and one > 0 and other > 0 and one + other > 2


def over_now(pad, side, toward, body):
    """Whether the state in the second half of ``pad`` is past the end of a mode, or past a turning point."""
    n = body.order
    if toward != 0 and pad[n + 1] * toward < 0.0:
        return True
    if side != 0:
        return pressing(pad, n, side, body) < 0.0
    return touches(pad, n, 1, body) or touches(pad, n, -1, body)


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


def press(z, u, side, toward, left, fresh, body, pad):
    """Move ``z`` on one flank, or on none, until that ends or ``left`` is over: ``(time, whether it ended, least)``.

    ``toward``: sign of the motor's speed where its turning points end the motion, too; else 0. ``fresh``: whether it
    begins where another has ended: what is then too near to be told is taken after 2^-20 of a sample. An end is left
    past it, by the last bit of a sample period. ``least``: bound from below on the torque of the mesh, on a flank.
    """
    n = body.order
    total, least = 0.0, float("inf")
    half = 0
    left = floor(left * FINEST) / FINEST
    table = HALVES_HELD if side == 0 else HALVES
    root = sqrt(body.ratio)
    own = body.ratio * sqrt(body.pad_stiffness) + body.pad_damping * body.ratio * (1.0 + root)
    own += body.finger_damping * root + sqrt(body.finger_stiffness * body.ratio)
    while left > 0.0 and not body.halt[0] > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        teeth_rate(z, u, side, body, pad)
        size = norm_at(pad, 0, body)
        pace, jerk = size * (1.0 + root), sliding_bound(pad, 0, body)
        twist = body.pad_stiffness * pace + body.pad_damping * (jerk + own * size)
        deepest = SHORTEST if fresh else HALVINGS - 1
        clear = told(z, pad, side, toward, h, pace, twist, jerk, body)
        while not clear and half < deepest:
            half += 1
            h *= 0.5
            clear = told(z, pad, side, toward, h, pace, twist, jerk, body)
        stretch(z, pad, table + half, body)
        ended = over_now(pad, side, toward, body)
        if ended and (clear or not fresh):
            for deeper in range(half + 1, HALVINGS):
                teeth_rate(z, u, side, body, pad)
                stretch(z, pad, table + deeper, body)
                if not over_now(pad, side, toward, body):
                    accept(z, pad, n)
                    total += 0.5**deeper
            teeth_rate(z, u, side, body, pad)
            stretch(z, pad, table + HALVINGS - 1, body)
            accept(z, pad, n)
            return total + 0.5 ** (HALVINGS - 1), True, -1.0
        if side != 0:
            least = min(least, least_torque(z, pad, side, h, twist, body))
        accept(z, pad, n)
        total += h
        left -= h
        fresh = False
        if ended:
            return total, True, -1.0
        if half > 0:
            half -= 1
    return total, False, least


def next_flank(z, side, body):
    """Flank after a mode has ended at ``z``: none after one, else the nearer."""
    if side != 0:
        return 0
    return 1 if z[2] > -0.5 * body.play else -1


def play_many(z, u, span, body, pad):
    """Move ``z`` over any time up to a sample period from flank to flank."""
    left = span
    side = flank(z, body)
    fresh = False
    while left > 0.0:
        t, ended, _ = press(z, u, side, 0, left, fresh, body, pad)
        left -= t
        if not ended:
            break
        side = next_flank(z, side, body)
        fresh = True


def meet(z, side, cols, count, width, body):
    """The columns where teeth meet: the rates of both bodies jump by the damper's torque (saltation matrix)."""
    if not side * z[3] > 0.0:
        return
    for c in range(count):
        jump = body.pad_damping * cols[c * width + 2]
        cols[c * width + 1] -= jump
        cols[c * width + 3] -= (1.0 + body.ratio) * jump


def play_columns(z, u, span, body, pad, cols, command, count, width, marks):
    """As `advance.rub_columns`, from flank to flank.

    ``marks[2]`` keeps the least torque of the mesh; below 0 where teeth have parted.
    """
    left = span
    side = flank(z, body)
    fresh = False
    while left > 0.0:
        t, ended, least = press(z, u, side, 0, left, fresh, body, pad)
        spread_many(cols, command, count, width, t, side, body, pad)
        marks[2] = min(marks[2], least if side != 0 else -1.0)
        left -= t
        if not ended:
            break
        side = next_flank(z, side, body)
        fresh = True
        if side != 0:
            meet(z, side, cols, count, width, body)


def flank_room(torque, body):
    """How far apart motions may be, by `body.distance`, until teeth may part that carry ``torque`` in one of them."""
    if torque <= 0.0:
        return 0.0
    return body.reach * torque / (sqrt(body.pad_stiffness) + body.pad_damping * (1.0 + sqrt(body.ratio)))


def play_chart(z, u, span, body, pad, rows, pieces):
    """As `trace.chart`, from flank to flank; modes are by the sign of the speed 1, `APART` or `BACK`."""
    n = body.order
    left = span
    side = flank(z, body)
    fresh = False
    while left > 0.0 and rows < len(pieces.spans):
        for j in range(n):
            pieces.states[rows * n + j] = z[j]
        teeth_rate(z, u, side, body, pad)
        toward = 1 if z[1] > 0.0 or (z[1] == 0.0 and pad[1] > 0.0) else -1
        t, ended, _ = press(z, u, side, toward, left, fresh, body, pad)
        left -= t
        kind = 1 if side > 0 else (APART if side == 0 else BACK)
        if t > 0.0:
            pieces.spans[rows], pieces.modes[rows], pieces.commands[rows] = t, toward * kind, u
            rows += 1
        if not ended:
            break
        if z[1] * toward < 0.0:
            z[1] = 0.0
        else:
            side = next_flank(z, side, body)
        fresh = True
    for j in range(n):
        pieces.states[rows * n + j] = z[j]
    return rows
