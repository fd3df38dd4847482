"""Cogging: a torque of the true angle, a triangle wave, which turns the knob to places at equal distances.

Corner to corner it is a spring to ground, in turn a stable one about a place of rest and an unstable one about the top
between two of them. So on a slope the motion is linear, and friction's modes are as without cogging; a corner is one
more end of a mode. The torque is continuous there: a derivative goes through a corner as it is. Slopes are numbered,
the even ones stable; the number follows from the angle, so that cogging needs no memory.

As in `slide_many` a step is halved until it can be shown what becomes of the mode in it. The energy of the rates, with
the spring of a stable slope, never grows on a stable slope; on an unstable one its root grows by exp(sqrt(slope) t) at
most. Two motions with the same commands on one slope keep closer than the energy of their difference allows, as long as
all springs on the knob together hold it (`hold_stiffness`); where one of them comes past a corner, nothing is known.

The compiler makes code of its own for scenes without any part of this kind, in which nothing of this is left: cogs that
are None are known by their type. Beside other such parts they are empty (`search.as_compiled`).
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import (
    ADDED,
    ENTRY,
    HALVES_HELD,
    HALVINGS,
    acceleration,
    distance,
    norm_at,
    rate_of,
    stiffness,
)
from hknob_cli.engine.general.slide_many import FINEST, SHORTEST, accept, held_bound, held_slope, stretch
from hknob_cli.engine.general.teeth import keeps_sign
from hknob_cli.engine.loop import floor

# Numbers of a body's cogs: slope of the torque, as an acceleration by a count; counts from a corner to the next; a
# place of rest; the largest acceleration; the root of the slope; and the size of a number by which it is computed.
SLOPE, LENGTH, CENTRE, PEAK, ROOT, SIZE = range(6)
COGGED = ADDED  # in `Body.matrices`: A on a stable slope and on an unstable one, then D as `HALVES` of both
COGGED_HALVES = COGGED + 2
FREE = 2  # mode of a motion whose turning points do not matter
STABLE, UNSTABLE = 6, 7  # modes of a piece that is written down, by the sign of the speed
TURNED, RISEN, FALLEN = 1, 2, 3  # ends: of the way, or of being held; and of a slope, on the way up or down
ROUNDINGS = 64.0
FAR = 1e-3  # of the limit at which a trial has left
MANY = 1024.0  # corners that are passed between two samples
SPRINGS = 16.0  # roundings of two springs that may cancel, as they come from a scene


def has_cogs(cogs):
    """Whether there is cogging."""
    if cogs is None:
        return False
    return bool(len(cogs))


def has_gone(cogs, z, limit):
    """Whether a trial has left: it is past ``limit``; or far, and so fast that it would be followed for ever."""
    if not -limit < z[0] < limit:
        return True
    if cogs is None or not len(cogs):
        return False
    return abs(z[0]) > FAR * limit and abs(z[1]) > MANY * cogs[LENGTH]


def slope_at(x, cogs):
    """Number of the slope on which a position lies."""
    return floor((x - cogs[CENTRE]) / cogs[LENGTH] + 0.5)


def is_stable(slope):
    """Whether a slope is a stable one."""
    return slope == 2.0 * floor(0.5 * slope)


def spring_of(slope, cogs):
    """Stiffness of the spring that cogging is on a slope; below 0 on an unstable one."""
    return cogs[SLOPE] if is_stable(slope) else -cogs[SLOPE]


def middle_of(slope, cogs):
    """Position at which there is no torque."""
    return cogs[CENTRE] + slope * cogs[LENGTH]


def pull_on(x, slope, cogs):
    """Torque at a position on a slope, as an acceleration."""
    return -spring_of(slope, cogs) * (x - middle_of(slope, cogs))


def cog_pull(cogs, x):
    """Torque of cogging at a position, as an acceleration; 0 without any."""
    if cogs is None or not len(cogs):
        return 0.0
    return pull_on(x, slope_at(x, cogs), cogs)


def cog_number(cogs, which):
    """One of the numbers of cogs; 0 without any."""
    if cogs is None or not len(cogs):
        return 0.0
    return cogs[which]


def room_on(x, slope, cogs):
    """How far a position on a slope is from the nearer corner."""
    return 0.5 * cogs[LENGTH] - abs(x - middle_of(slope, cogs))


def own_stiffness(body):
    """Stiffness of the springs of hand and finger, as the knob feels them; 0 without."""
    return 1.0 / (body.reach * body.reach)


def hold_stiffness(cogs, x, body):
    """Stiffness of all springs that hold the knob on the slope at ``x``; at most 0 where they do not.

    Of springs that may cancel it is a bound from below. Infinite without cogging, where nothing needs to hold it.
    """
    if cogs is None or not len(cogs):
        return float("inf")
    own, spring = own_stiffness(body), spring_of(slope_at(x, cogs), cogs)
    if spring > 0.0:
        return own + spring
    return own + spring - SPRINGS * EPSILON * own


def energy_apart(cogs, dz, x, body):
    """Root of the energy of a difference on the slope at ``x``, springs and cogging included; lag as `body.norm` has.

    Only where `hold_stiffness` is above 0 is it one.
    """
    late = abs(dz[body.order - 1]) / body.lag if body.lag > 0.0 else 0.0
    root = norm_at(dz, 0, body) - late
    square = root * root
    spring = spring_of(slope_at(x, cogs), cogs) * dz[0] * dz[0]
    return sqrt(max(square + spring, 0.0) + ROUNDINGS * EPSILON * (square + abs(spring))) + late


def far_apart(cogs, dz, x, body):
    """As `body.distance`, of two motions on the slope at ``x`` that stay on it; inf where its springs do not hold."""
    if cogs is None or not len(cogs):
        return distance(dz, body)
    hold = hold_stiffness(cogs, x, body)
    if not hold > 0.0:
        return float("inf")
    return energy_apart(cogs, dz, x, body) / sqrt(hold)


def reach_on(cogs, x, body):
    """Position of a unit root of energy on the slope at ``x``, counts; of a stable slope where this does not hold."""
    if cogs is None or not len(cogs):
        return body.reach
    hold = hold_stiffness(cogs, x, body)
    if not hold > 0.0:
        hold = hold_stiffness(cogs, middle_of(0.0, cogs), body)
    return 1.0 / sqrt(hold)


def gap_apart(cogs, dz, body):
    """As `body.distance`, of states that may lie on any slope: no bound, but small where they are close."""
    if cogs is None or not len(cogs):
        return distance(dz, body)
    return (norm_at(dz, 0, body) + cogs[ROOT] * abs(dz[0])) / sqrt(own_stiffness(body) + cogs[SLOPE])


def cog_acceleration(z, u, slope, body):
    """Acceleration of the knob without friction."""
    return acceleration(z, u, body) + pull_on(z[0], slope, body.cogs)


def cog_rate(z, u, slope, mode, body, out):
    """As `body.rate_of`, on a slope."""
    rate_of(z, u, mode, body, out)
    if mode != 0:
        pull = pull_on(z[0], slope, body.cogs)
        for i in range(body.order):
            out[i] += body.vectors[ENTRY * body.order + i] * pull


def held_told(z, u, pad, slope, h, body):
    """Whether it can be told what becomes of a knob that friction holds within ``h``: nothing, or a release, once."""
    rate = held_slope(pad, body)
    bound = held_bound(pad, body)
    value = body.friction - abs(cog_acceleration(z, u, slope, body))
    return bound == 0.0 or keeps_sign(value, -abs(rate), bound, h) or abs(rate) > bound * h


def told(z, u, pad, slope, mode, h, size, body):
    """Whether at most one thing happens within ``h``, and once: a corner is passed, or the mode ends.

    ``pad`` has the rates in its first half; ``size`` bounds the root of their energy now.
    """
    if mode == 0:
        return held_told(z, u, pad, slope, h, body)
    if size == 0.0:
        return True  # nothing moves
    root = body.cogs[ROOT]
    pace = size
    if not is_stable(slope):
        if root * h > 0.5:
            return False
        pace /= 1.0 - root * h
    away = z[0] - middle_of(slope, body.cogs)
    speed = pad[0]
    passes = abs(speed) > pace * h
    for side in (1, -1):
        ahead = mode in (FREE, side)
        if ahead and not passes and not keeps_sign(0.5 * body.cogs[LENGTH] - side * away, -side * speed, pace, h):
            return False
    if mode == FREE:
        return True
    bend = pace * (stiffness(body) + root)
    if body.lag > 0.0:
        bend += abs(pad[body.order - 1])
    rate = pad[1] * mode
    return keeps_sign(z[1] * mode, rate, bend, h) or abs(rate) > bend * h


def over(pad, u, slope, mode, body):
    """Which end the state in the second half of ``pad`` is past; 0 of none."""
    n = body.order
    x, v = pad[n], pad[n + 1]
    if mode == 0:
        total = body.drive + pull_on(x, slope, body.cogs)
        for j in range(n):
            total += body.matrices[n + j] * pad[n + j]
        if body.lag == 0.0:
            total += u
        return TURNED if abs(total) > body.friction else 0
    if mode != FREE and v * mode < 0.0:
        return TURNED
    away = x - middle_of(slope, body.cogs)
    if not abs(away) > 0.5 * body.cogs[LENGTH]:
        return 0
    if away > 0.0:
        return RISEN if v > 0.0 else 0
    return FALLEN if v < 0.0 else 0


def roll(z, u, slope, mode, left, fresh, body, pad):
    """Move ``z`` on one slope in one ``mode`` until either ends or ``left`` is over: ``(time, end)``.

    ``fresh``: whether it begins where another has ended: what is then too near to be told is taken after 2^-20 of a
    sample. An end is left past it, by the last bit of a sample period.
    """
    n = body.order
    total, half = 0.0, 0
    left = floor(left * FINEST) / FINEST
    table = HALVES_HELD
    if mode != 0:
        table = COGGED_HALVES if is_stable(slope) else COGGED_HALVES + HALVINGS
    root = body.cogs[ROOT]
    while left > 0.0 and not body.halt[0] > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        cog_rate(z, u, slope, mode, body, pad)
        size = norm_at(pad, 0, body) + root * abs(pad[0])
        deepest = SHORTEST if fresh else HALVINGS - 1
        clear = told(z, u, pad, slope, mode, h, size, body)
        while not clear and half < deepest:
            half += 1
            h *= 0.5
            clear = told(z, u, pad, slope, mode, h, size, body)
        stretch(z, pad, table + half, body)
        ended = over(pad, u, slope, mode, body)
        if ended > 0 and (clear or not fresh):
            for deeper in range(half + 1, HALVINGS):
                cog_rate(z, u, slope, mode, body, pad)
                stretch(z, pad, table + deeper, body)
                sooner = over(pad, u, slope, mode, body)
                if sooner > 0:
                    ended = sooner
                else:
                    accept(z, pad, n)
                    total += 0.5**deeper
            cog_rate(z, u, slope, mode, body, pad)
            stretch(z, pad, table + HALVINGS - 1, body)
            accept(z, pad, n)
            return total + 0.5 ** (HALVINGS - 1), ended
        accept(z, pad, n)
        total += h
        left -= h
        fresh = False
        if ended > 0:
            return total, ended
        if half > 0:
            half -= 1
    return total, 0
