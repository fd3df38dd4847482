"""Cogging: a torque of the true angle, a triangle wave, which turns the knob to places at equal distances.

Corner to corner it is a spring to ground, in turn a stable one about a place of rest and an unstable one about the top
between two of them. So on a slope the motion is linear, and friction's modes are as without cogging; a corner is one
more end of a mode. The torque is continuous there: a derivative goes through a corner as it is. Slopes are numbered,
the even ones stable; the number follows from the angle, so that cogging needs no memory.

The energy of the rates, with the spring of a stable slope, never grows on a stable slope; on an unstable one its root
grows by exp(sqrt(slope) t) at most. Two motions with the same commands on one slope keep closer than the energy of
their difference allows, as long as all springs on the knob together hold it (`hold_stiffness`); where one of them comes
past a corner, `corners` bounds what that adds.

The compiler makes code of its own for scenes without any part of this kind, in which nothing of this is left: cogs that
are None are known by their type. Beside other such parts they are empty (`search.as_compiled`).
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import ADDED, HALVINGS, distance, norm_at
from hknob_cli.engine.general.slide_many import keeps_sign
from hknob_cli.engine.loop import floor

# Numbers of a body's cogs: slope of the torque, as an acceleration by a count; counts from a corner to the next; a
# place of rest; the largest acceleration; the root of the slope; and the size of a number by which it is computed.
SLOPE, LENGTH, CENTRE, PEAK, ROOT, SIZE = range(6)
COGGED = ADDED  # in `Body.matrices`: A on a stable slope and on an unstable one, then D as `HALVES` of both
COGGED_HALVES = COGGED + 2
# The same with play: A of teeth that press and of teeth apart, each on both slopes, behind the numbers of a motor that
# friction holds.
TOOTHED = ADDED + 2 + 2 * HALVINGS
TOOTHED_HALVES = TOOTHED + 4
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


def slope_of(cogs, x):
    """As `slope_at`; 0 without cogging."""
    if cogs is None or not len(cogs):
        return 0.0
    return slope_at(x, cogs)


def slope_pull(cogs, x, slope):
    """As `pull_on`; 0 without cogging."""
    if cogs is None or not len(cogs):
        return 0.0
    return pull_on(x, slope, cogs)


def cog_number(cogs, which):
    """One of the numbers of cogs; 0 without any."""
    if cogs is None or not len(cogs):
        return 0.0
    return cogs[which]


def room_on(x, slope, cogs):
    """How far a position on a slope is from the nearer corner."""
    return 0.5 * cogs[LENGTH] - abs(x - middle_of(slope, cogs))


def cog_room(cogs, x, slope):
    """As `room_on`; inf without cogging."""
    if cogs is None or not len(cogs):
        return float("inf")
    return room_on(x, slope, cogs)


def own_stiffness(body):
    """Stiffness of the springs of hand and finger, as the knob feels them; 0 without."""
    return 1.0 / (body.reach * body.reach)


def unit_reach(body):
    """Position of a unit root of energy with the spring of a stable slope."""
    return 1.0 / sqrt(own_stiffness(body) + body.cogs[SLOPE])


def reach_of(cogs, body):
    """As ``body.reach``, by `size_at`."""
    if cogs is None or not len(cogs):
        return body.reach
    return unit_reach(body)


def size_at(cogs, dz, at, body):
    """As `body.norm_at`, with the spring of a stable slope; without cogging it is that."""
    if cogs is None or not len(cogs):
        return norm_at(dz, at, body)
    late = abs(dz[at + body.order - 1]) / body.lag if body.lag > 0.0 else 0.0
    root = norm_at(dz, at, body) - late
    return sqrt(root * root + cogs[SLOPE] * dz[at] * dz[at]) + late


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


def gap_apart(cogs, dz, body):
    """As `body.distance`, of states that may lie on any slope: no bound, but small where they are close."""
    if cogs is None or not len(cogs):
        return distance(dz, body)
    return (norm_at(dz, 0, body) + cogs[ROOT] * abs(dz[0])) / sqrt(own_stiffness(body) + cogs[SLOPE])


def far_around(cogs, dz, x, body):
    """As `far_apart`, for an orbit that `corners` proves where the springs of the slope at ``x`` do not hold.

    The energy is then that with the spring of a stable slope. Where they do hold, it is at most as far as `far_apart`.
    """
    if cogs is None or not len(cogs) or hold_stiffness(cogs, x, body) > 0.0:
        return far_apart(cogs, dz, x, body)
    return gap_apart(cogs, dz, body)


def reach_on(cogs, x, body):
    """Position of a unit root of energy on the slope at ``x``, counts; of a stable slope where this does not hold."""
    if cogs is None or not len(cogs):
        return body.reach
    hold = hold_stiffness(cogs, x, body)
    if not hold > 0.0:
        hold = hold_stiffness(cogs, middle_of(0.0, cogs), body)
    return 1.0 / sqrt(hold)


def least_share(cogs, slope, h):
    """What part the root of the energy of rates is now, at least, of what it grows to on a slope within ``h``.

    It is 1 on a stable slope, and without cogging; 0 where it is not bounded.
    """
    if cogs is None or not len(cogs) or is_stable(slope):
        return 1.0
    grown = cogs[ROOT] * h
    return 1.0 - grown if grown <= 0.5 else 0.0


def corner_told(cogs, x, speed, pace, slope, mode, h):
    """Whether a motion in ``mode`` reaches no corner of a slope within ``h``, or passes one, once.

    ``pace`` bounds the acceleration.
    """
    if cogs is None or not len(cogs):
        return True
    away = x - middle_of(slope, cogs)
    passes = abs(speed) > pace * h
    for side in (1, -1):
        ahead = mode in (FREE, side)
        if ahead and not passes and not keeps_sign(0.5 * cogs[LENGTH] - side * away, -side * speed, pace, h):
            return False
    return True


def corner_passed(cogs, x, v, slope):
    """Which corner of a slope a motion has passed, `RISEN` or `FALLEN`; 0 of none."""
    if cogs is None or not len(cogs):
        return 0
    away = x - middle_of(slope, cogs)
    if not abs(away) > 0.5 * cogs[LENGTH]:
        return 0
    if away > 0.0:
        return RISEN if v > 0.0 else 0
    return FALLEN if v < 0.0 else 0
