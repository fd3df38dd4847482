"""Teeth with play: the motion from flank to flank, exact; teeth press, they never pull.

The mesh's angle d is counted from the flank on which the wall holds the push; the other flank is at -play. With o, the
overlap of teeth on a flank, they carry max(0, k o + c o') where o > 0, and nothing else: a tooth whose spring and
damper would pull is left, and relaxes. The torque is that of the state alone, so that it needs no memory. It jumps, by
c o', where teeth meet; where they part it is 0 on both sides. So there are three linear modes, and their ends are zeros
of o, or of the torque. As in `slide_many` a step is halved until each can be shown to keep its sign in it or to be
monotone: second derivatives are bounded by the energy of the rates, which never grows within a mode.

With friction the motor slides, one way or the other, or is held: each flank has three modes. What ends one is a zero of
the motor's speed, or of what friction lacks to hold it, beside those of the teeth.
"""

from math import floor, sqrt

from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_HELD,
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
)
from hknob_cli.engine.general.slide_many import FINEST, SHORTEST, accept, held_bound, sliding_bound, stretch
from hknob_cli.engine.general.slide_two import way

APART = 2  # modes of a piece that is written down, by the sign of the speed: 1 on the wall's flank, 2 on none,
BACK = 3  # and 3 on the other; with a motor that friction holds 0,
STUCK_APART, STUCK_BACK = 4, 5  # and these
TURNED, SPRUNG = 1, 2  # ends of a mode: of the motor's way, and of what teeth did


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


def teeth_rate(z, u, side, toward, body, out):
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


def teeth_pull(z, at, u, side, body):
    """Acceleration of the motor without friction, on a flank or on none."""
    n = body.order
    matrix = (HELD if side == 0 else RATES) * n * n
    total = body.vectors[CONSTANT * n + 1]
    if body.lag == 0.0:
        total += u
    for j in range(n):
        total += body.matrices[matrix + n + j] * z[at + j]
    if side < 0:
        total -= body.pad_stiffness * body.play
    return total


def direction(z, u, side, body):
    """Sign of the motor's speed from here on; 0 where friction holds it."""
    pull = teeth_pull(z, 0, u, side, body)
    if body.friction > 0.0:
        return way(z[1], pull, body.friction)
    return 1 if z[1] > 0.0 or (z[1] == 0.0 and pull > 0.0) else -1


def keeps_sign(value, slope, bound, h):
    """Whether a value stays above 0 over ``h``: ``slope`` is its rate now, ``bound`` is on its second derivative."""
    return value + min(slope, 0.0) * h - 0.5 * bound * h * h > 0.0


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


def stuck_told(z, u, pad, side, h, body):
    """Whether it can be told what becomes of a motor that friction holds within ``h``: nothing, or a release, once."""
    n = body.order
    matrix = (HELD if side == 0 else RATES) * n * n
    slope = 0.0
    for j in range(n):
        slope += body.matrices[matrix + n + j] * pad[j]
    bound = held_bound(pad, body)
    value = body.friction - abs(teeth_pull(z, 0, u, side, body))
    return bound == 0.0 or keeps_sign(value, -abs(slope), bound, h) or abs(slope) > bound * h


def told(z, u, pad, side, toward, h, pace, twist, jerk, body):
    """Whether at most one thing happens within ``h``, and once: the mode ends, or the motor turns round."""
    if pace == 0.0:
        return True  # no torque changes, and teeth do not move against each other
    if toward == 0 and body.friction > 0.0:
        turning = stuck_told(z, u, pad, side, h, body)
    elif toward != 0 and jerk > 0.0 and not keeps_sign(toward * z[1], toward * pad[1], jerk, h):
        turning = abs(pad[1]) > jerk * h
    else:
        turning = True  # no turn is asked for, or none comes, or the speed changes evenly: it turns once at most
    if side != 0:
        slope = side * (body.pad_stiffness * pad[2] + body.pad_damping * pad[3])
        return turning and (keeps_sign(pressing(z, 0, side, body), slope, twist, h) or abs(slope) > twist * h)
    one, other = seen(z, pad, 1, h, pace, twist, body), seen(z, pad, -1, h, pace, twist, body)
    return turning and one + other > 2


def teeth_over(z, at, side, body):
    """Whether the state that begins at ``z[at]`` is past the end of what teeth did: they have parted, or met."""
    if side != 0:
        return pressing(z, at, side, body) < 0.0
    return touches(z, at, 1, body) or touches(z, at, -1, body)


def over_now(pad, u, side, toward, body):
    """Which end of a mode the state in the second half of ``pad`` is past; 0 of none.

    `TURNED`: a turning point, or the release of a motor that friction holds; else `SPRUNG`.
    """
    n = body.order
    if pad[n + 1] * toward < 0.0:
        return TURNED
    if toward == 0 and body.friction > 0.0 and abs(teeth_pull(pad, n, u, side, body)) > body.friction:
        return TURNED
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
    return size * (body.alpha + sqrt(body.coil)) + late


def press(z, u, side, toward, left, fresh, body, pad):
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
    table = HALVES_HELD if side == 0 else HALVES
    if toward == 0 and body.friction > 0.0:
        table = STUCK_HALVES + (HALVINGS if side == 0 else 0)
    root = sqrt(body.ratio)
    own = body.ratio * sqrt(body.pad_stiffness) + body.pad_damping * body.ratio * (1.0 + root)
    own += body.finger_damping * root + sqrt(body.finger_stiffness * body.ratio)
    while left > 0.0 and not body.halt[0] > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        teeth_rate(z, u, side, toward, body, pad)
        size = norm_at(pad, 0, body)
        pace, jerk = size * (1.0 + root), sliding_bound(pad, 0, body)
        twist = body.pad_stiffness * pace + body.pad_damping * (jerk + own * size)
        if side == 0 and (body.friction > 0.0 or body.alpha > 1.0):
            jerk = loose_bound(pad, body)  # else a motor that slows down for ever is followed in tiny steps
        deepest = SHORTEST if fresh else HALVINGS - 1
        clear = told(z, u, pad, side, toward, h, pace, twist, jerk, body)
        while not clear and half < deepest:
            half += 1
            h *= 0.5
            clear = told(z, u, pad, side, toward, h, pace, twist, jerk, body)
        stretch(z, pad, table + half, body)
        ended = over_now(pad, u, side, toward, body)
        if side != 0:
            carried = least_torque(z, pad, side, h, twist, body)
        if ended > 0 and clear:
            for deeper in range(half + 1, HALVINGS):
                teeth_rate(z, u, side, toward, body, pad)
                stretch(z, pad, table + deeper, body)
                sooner = over_now(pad, u, side, toward, body)
                if sooner > 0:
                    ended = sooner
                else:
                    accept(z, pad, n)
                    total += 0.5**deeper
            teeth_rate(z, u, side, toward, body, pad)
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


def flank_room(torque, body):
    """How far apart motions may be, by `body.distance`, until teeth may part that carry ``torque`` in one of them."""
    if torque <= 0.0:
        return 0.0
    return body.reach * torque / (sqrt(body.pad_stiffness) + body.pad_damping * (1.0 + sqrt(body.ratio)))


def held_in_teeth(z, u, body):
    """Whether friction holds the motor for ever, and the knob settles on the flank, or on none, on which it is now.

    The energy of the knob's motion about where it would settle never grows. It bounds how far the mesh's torque ever
    gets from what it is there, so that teeth which press there do not part; in the gap it bounds the way.
    """
    n = body.order
    late = abs(z[n - 1] - u) if body.lag > 0.0 else 0.0
    if body.coil > 0.0:
        late += body.coil * abs(z[coil_at(body)])
    side = flank(z, body)
    drive = body.vectors[CONSTANT_STUCK * n + 3] + body.finger_stiffness * z[0]
    torque, swing = 0.0, 0.0
    if side == 0:
        if body.finger_damping == 0.0 or body.finger_stiffness == 0.0:
            return False
        rest = drive / body.finger_stiffness
        away = z[2] - rest
        far = sqrt(z[3] * z[3] / body.finger_stiffness + away * away)
        if not (rest + far < 0.0 and rest - far > -body.play):
            return False
    else:
        stiff = body.ratio * body.pad_stiffness + body.finger_stiffness
        if body.finger_damping + body.pad_damping == 0.0 or stiff == 0.0:
            return False
        if side < 0:
            drive -= body.ratio * body.pad_stiffness * body.play
        rest = drive / stiff
        away = z[2] - rest
        energy = sqrt(z[3] * z[3] / body.ratio + stiff / body.ratio * away * away)
        swing = (body.pad_damping * sqrt(body.ratio) + body.pad_stiffness * sqrt(body.ratio / stiff)) * energy
        torque = side * body.pad_stiffness * overlap(rest, side, body)
        if not side * torque > swing:
            return False
    return abs(u + body.vectors[CONSTANT_HELD * n + 1] - torque) + swing + late <= body.friction
