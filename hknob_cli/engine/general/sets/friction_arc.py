"""An arc of clock phases with friction and more than angle and speed, moved over a hold.

An arc is a centre, which is a trial, a line, which is how its states differ from that, to first order, from one end of
its phases to the other, and a ball, in which they may be beside that line. The distance of two motions under one torque
never grows, in `body.norm`, whatever friction does to either, for friction is a monotone function of speed. So what is
beside the line never grows by itself. Line and ball are columns, which go through slides and stops as derivatives do
(`columns`), where all states of the arc do the same: slide, stand, or stop once and go on alike. What a stop adds to
that is of the square of the arc's size, and is bounded. Elsewhere nothing is known of the arc but that no state is
farther from the centre than before: all of it is in the ball then.
"""

from math import floor, sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.advance import next_mode, rub_on
from hknob_cli.engine.general.body import (
    HALVINGS,
    HELD,
    RATES,
    acceleration,
    copy_to,
    norm,
    norm_at,
    rate_of,
    stiffness,
)
from hknob_cli.engine.general.cogging import ROOT, cog_number, reach_of, size_at
from hknob_cli.engine.general.columns import Columns, spread_many, turn_round
from hknob_cli.engine.general.slide_many import (
    held_bound,
    held_slope,
    slide_many,
    sliding_bound,
)
from hknob_cli.engine.general.slide_two import way
from hknob_cli.engine.general.slopes import stays_over

# Numbers of an arc: its phases, and those of them that it counts, for arcs overlap; bound on the roundings of its
# centre; radius of the ball beside its line when its columns were begun, and how far states may be beside that; what
# `readings.remembered` has, and the reading, of the sample before; its sample; how many readings of the interval are
# told; whether all states stand; with hysteresis the least and the most of their counts at the last turning point. Then
# its centre, its columns, of which the first is the line, its memory, and the readings of the interval.
LOW, HIGH, FROM, TO, ERROR, BALL, BESIDE, BEFORE, LEVEL, SAMPLE, TOLD, STANDS, COUNT, COUNT_TO, STATE = range(15)
STEPS = 128.0  # in which columns are moved over the two parts of a hold, at most
WHOLE = 2.0 ** (HALVINGS - 1)  # times that a sample period is told apart
WIDE = 0.5  # part of a ball beside its columns above which they are begun anew


def ball_of(room, body):
    """Radius of the ball beside the line of the arc in ``room``, in `cogging.size_at`."""
    n, square = body.order, 0.0
    for at in range(n, len(room.columns) - len(room.columns) // n, n):
        length = size_at(body.cogs, room.columns, at, body)
        square += length * length
    return min(room.arc[BALL], sqrt(square) * (1.0 + 1e-12)) + room.arc[BESIDE]


def apart_of(room, body):
    """How far states of the arc in ``room`` may be from its computed centre, in `cogging.size_at`."""
    return size_at(body.cogs, room.columns, 0, body) + ball_of(room, body) + room.arc[ERROR]


def beside_of(room, body):
    """How far positions of the arc in ``room`` may be beside its line, its computed centre's rounding included."""
    n, square = body.order, 0.0
    for at in range(n, len(room.columns) - len(room.columns) // n, n):
        square += room.columns[at] * room.columns[at]
    reach = reach_of(body.cogs, body)
    beside = min(reach * room.arc[BALL], sqrt(square) * (1.0 + 1e-12))
    beside += reach * (room.arc[BESIDE] + room.arc[ERROR])
    return beside + 8.0 * EPSILON * (abs(room.z[0]) + abs(room.columns[0]))


def begin_ball(room, radius, body):
    """Let the ball beside the line of the arc in ``room`` have this radius, and its columns span it."""
    room.arc[BALL], room.arc[BESIDE] = radius, 0.0
    for j in range(len(room.unit)):
        room.columns[body.order + j] = radius * room.unit[j]


def all_slide(room, z, u, mode, span, ball, body):
    """Whether all states of an arc slide in ``mode`` over ``span``, whose centre is ``z`` and whose line `room.line`.

    Their speeds are between those at the ends of the line, to within ``ball``.
    """
    if not span > 0.0:
        return False
    for sign in (-1.0, 1.0):
        for j in range(body.order):
            room.begun[j] = z[j] + sign * room.line[j]
        if not stays_over(room.begun, u, 0.0, mode, span, ball, body, room.pad):
            return False
    return True


def stop_bound(rate, jump, bend, slope, apart, window, room, body):
    """Bound on what derivatives at a stop leave out, of states up to ``apart`` from one that stops at this ``rate``.

    They stop within ``window`` of it. ``jump``: of the rate; ``bend``: bound on the rate of the rate; ``slope``: of the
    torque on a knob that then stands, below 0 where it turns.
    """
    off = (stiffness(body) + cog_number(body.cogs, ROOT)) * apart + bend * window
    total = jump * (off * window / rate + 2.0 * window * window * room.fast[0])
    if slope >= 0.0:
        total += (off + slope * window) * window + window * apart * (2.0 * room.fast[2] + room.fast[1])
    return total


def stop_alike(room, z, u, span, before, mode, apart, body):
    """Go on where the centre ``z`` has stopped that slid in ``mode`` for ``before`` of a hold: ``(alike, steps)``.

    ``alike``: whether all states of the arc, which are up to ``apart`` from it, stop once and go on alike.
    ``room.first``, ``room.line``: centre and line as the hold began. The columns are moved to the end of the hold.
    ``room.stop`` takes the place of the stop, and how far from it those of states are that do alike.
    """
    n, pad, own, left = body.order, room.pad, stiffness(body), span - before
    count = len(room.columns) // (n + 1)
    columns = Columns(room.columns, count * n, count, n)
    pull = acceleration(z, u, body)
    rate, then = pull - mode * body.friction, next_mode(mode, z, u, body)
    if rate == 0.0:
        return False, rub_on(z, u, left, body, pad)
    after = 0.0 if then == 0 else pull - then * body.friction
    # Others stop within the window of it; twice as far from it none is at rest.
    ball = ball_of(room, body) + room.arc[ERROR]
    window = 2.0 * (abs(room.columns[1]) + ball) / abs(rate)
    rate_of(z, u, mode, body, pad)
    bend = 2.0 * sliding_bound(pad, 0, body) + own * room.fast[1] * apart
    alike = 2.0 * window < min(before, left) and 2.0 * room.fast[1] * window <= 0.5
    alike = alike and 2.0 * (own * apart + 2.0 * bend * window) <= abs(rate)
    alike = alike and all_slide(room, room.first, u, mode, before - 2.0 * window, ball, body)
    turn_round(columns, (after - rate) / rate, body)
    rate_of(z, u, then, body, pad)
    slope, need = -1.0, 0.0
    if then == 0:
        slope = abs(held_slope(pad, body)) + held_bound(pad, body) * window
        need = own * apart + (bend + slope) * window
    else:
        later = sliding_bound(pad, 0, body) + own * room.fast[1] * apart
        bend = max(bend, later)
        alike = alike and 2.0 * (own * apart + 2.0 * later * window) <= abs(after)
    more = stop_bound(abs(rate), abs(after - rate), bend, slope, apart, window, room, body)
    room.stop[0] = z[0]
    room.stop[1] = abs(room.columns[0]) + beside_of(room, body) + 4.0 * (abs(rate) + abs(after)) * window * window
    copy_to(room.first, z)
    for j in range(n):
        room.line[j] = room.columns[j]
    t, ended, steps = slide_many(z, u, then, left, body, pad)
    if ended:
        return False, steps + rub_on(z, u, left - t, body, pad)
    spread_many(columns, t, then, body, pad)
    if alike and then != 0:
        near, _, _ = slide_many(room.first, u, then, 2.0 * window, body, pad)
        spread_many(Columns(room.line, n, 1, n), near, then, body, pad)
        alike = all_slide(room, room.first, u, then, t - near, ball + more, body)
    elif alike:
        alike = stays_over(room.first, u, 0.0, then, left, need, body, pad)
    if alike:
        room.arc[STANDS] = 1.0 if then == 0 else 0.0
        room.arc[BESIDE] += more
    return alike, steps


def rub_arc(room, z, u, span, drift, body):
    """Move the arc in ``room``, its centre in ``z``, over a hold under ``u``; whether its states do alike in it.

    No state gets farther from the centre.
    """
    arc, pad, n = room.arc, room.pad, body.order
    count = len(room.columns) // (n + 1)
    columns = Columns(room.columns, count * n, count, n)
    begin, stands = z[1], arc[STANDS] > 0.0
    wide, own = norm_at(room.columns, 0, body) + ball_of(room, body), stiffness(body)
    apart, pull = wide + arc[ERROR], acceleration(z, u, body)
    mode = way(begin, pull, body.friction)
    rate_of(z, u, mode, body, pad)
    fast, steep = norm(pad, body), sliding_bound(pad, 0, body) + own * room.fast[1] * apart
    wrong, skewed = drift.once[0] + drift.once[1] * abs(u), 0.0
    for j in range(n):
        wrong += drift.once[2 + j] * (abs(z[j]) + room.spans[j] * fast)
        for k in range(count):
            skewed += drift.once[2 + j] * abs(room.columns[k * n + j])
    arc[STANDS] = 0.0
    copy_to(room.first, z)
    for j in range(n):
        room.line[j] = room.columns[j]
    t, ended, steps = slide_many(z, u, mode, span, body, pad)
    alike = body.friction == 0.0
    if alike:
        if ended:
            steps += rub_on(z, u, span - t, body, pad)
        spread_many(columns, floor(span * WHOLE) / WHOLE, 1, body, pad)
    elif not ended:
        spread_many(columns, t, mode, body, pad)
        if mode == 0:
            alike = stands and stays_over(room.first, u, 0.0, mode, span, own * apart, body, pad)
            arc[STANDS] = 1.0 if alike else 0.0
            if not stands and stays_over(room.first, u, 0.0, mode, span, own * apart + apart / span, body, pad):
                arc[STANDS] = 1.0
        elif begin == 0.0:
            alike = stands and abs(pull) - body.friction - own * apart > steep * span
        else:
            alike = all_slide(room, room.first, u, mode, span, ball_of(room, body) + arc[ERROR], body)
    elif mode == 0 or begin == 0.0:
        steps += rub_on(z, u, span - t, body, pad)
    else:
        spread_many(columns, t, mode, body, pad)
        alike, more = stop_alike(room, z, u, span, t, mode, apart, body)
        steps += more
    arc[ERROR] += wrong * (1.0 + steps)
    if alike:
        arc[BESIDE] += STEPS * skewed
        radius = ball_of(room, body)
        if arc[BESIDE] > WIDE * radius:
            begin_ball(room, radius, body)
    else:
        begin_ball(room, wide, body)
        for j in range(n):
            room.columns[j] = 0.0
    return alike


def begin_arc(start, rate, room, drift, body):
    """Leave in ``room`` the states of its arc's phases at the first sample: ``rate``, `start_rate`, bounds how far.

    They are all places of one motion, of which a stop may be at one of its phases.
    """
    arc, z, pad, n = room.arc, room.z, room.pad, body.order
    low, high = arc[LOW], arc[HIGH]
    half = 0.5 * (high - low)
    for j in range(n):
        z[j] = start[j]
        room.columns[j] = 0.0
        arc[ERROR] += 8.0 * EPSILON * drift.units[j] * abs(start[j])
    rub_on(z, 0.0, low, body, pad)
    mode = way(z[1], acceleration(z, 0.0, body), body.friction)
    rate_of(z, 0.0, mode, body, pad)
    matrix, bend = (HELD if mode == 0 else RATES) * n * n, room.line
    for i in range(n):
        bend[i] = 0.0
        for j in range(n):
            bend[i] += body.matrices[matrix + i * n + j] * pad[j]
    curved = norm(bend, body)
    _, stops, _ = slide_many(z, 0.0, mode, high - low, body, pad)
    for j in range(n):
        z[j] = start[j]
    rub_arc(room, z, 0.0, low + half, drift, body)
    arc[STANDS], radius = 0.0, half * rate
    if not stops:
        # The rate of the rate never grows, either.
        radius = 0.5 * half * half * (curved + room.fast[1] * room.fast[1] * arc[ERROR]) * (1.0 + 1e-9)
        rate_of(z, 0.0, mode, body, pad)
        for j in range(n):
            room.columns[j] = half * pad[j]
        radius += half * room.fast[1] * arc[ERROR]
    begin_ball(room, radius, body)


def start_rate(start, body, pad):
    """Bound on the distance, in `body.norm`, of the states of two phases of a start, by that of the phases."""
    rate_of(start, 0.0, way(start[1], acceleration(start, 0.0, body), body.friction), body, pad)
    return norm(pad, body) * (1.0 + 1e-9)
