"""Pieces of angle and speed beside cogging that friction stops: folded where their speed changes its sign.

All states of a piece that decelerate at about one rate r stop one after the other. Let a state slide on as if it never
did: then it has another speed w when others stop, of the other sign. In truth it has turned round within |w| / r, and
has gone on at about a rate q since then, or stands. So its speed is w q / r, or 0: the piece is folded along its line
of speed 0. A state that has yet to stop goes on as one that slid the other way all along, and had the speed w q / r.
What this leaves out is of the square of w, as rates are known to what springs and damping make of the piece's size and
of the time within which all stop. Speeds change their sign nowhere else, because they all fall, or all rise, or are
larger than they may differ by.
"""

from math import exp, inf

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import HALVINGS, copy_to
from hknob_cli.engine.general.cogging import (
    COGGED_HALVES,
    SLOPE,
    TURNED,
    is_stable,
    room_on,
    size_at,
    slope_at,
    unit_reach,
)
from hknob_cli.engine.general.columns import Columns
from hknob_cli.engine.general.corners import growth_rate
from hknob_cli.engine.general.sets.cog_arc import ROUNDED, rounded_by, time_of_piece
from hknob_cli.engine.general.sets.cog_stop import Spread
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, drop_edge, hull, keep_side, widen
from hknob_cli.engine.general.sets.friction_arc import BESIDE, ERROR, STEPS, WHOLE
from hknob_cli.engine.general.slide_many import accept, stretch
from hknob_cli.engine.general.slope_columns import spread_cogs
from hknob_cli.engine.general.slopes import cog_acceleration, cog_rate, pass_on, roll_in_steps, stays_over, stiff_of
from hknob_cli.engine.loop import floor

LEAST = 1e-30  # radius of a piece that is a point
HELD, MIXED, NOT_TOLD = 0, 2, 3  # what states do after a stop, beside sliding in a mode: all stand; each does either


def size_of_piece(corners, count, body):
    """Largest distance of a piece's states from its centre, by `cogging.size_at`."""
    radius = 0.0
    for k in range(count):
        radius = max(radius, size_at(body.cogs, corners, 2 * k, body))
    return radius * (1.0 + 1e-12) + LEAST


def speeds_of(z, corners, count, error):
    """The least and the most speed of a piece's states."""
    low, high = inf, -inf
    for k in range(count):
        low, high = min(low, z[1] + corners[2 * k + 1]), max(high, z[1] + corners[2 * k + 1])
    return low - error, high + error


def places_of(corners, count):
    """How far places of a piece may be from that of its centre."""
    far = 0.0
    for k in range(count):
        far = max(far, abs(corners[2 * k]))
    return far


def fold_at(z, u, slope, mode, most, apart, pace, body):
    """What becomes of states that stop near ``z``, having slid in ``mode``: ``(then, ratio, window, dx, dv)``.

    Args:
        z: The centre, about where they stop.
        u: Torque.
        slope: Of cogging, its number.
        mode: +1 or -1.
        most: The largest of their speeds w, as the module has it.
        apart: How far they are from the centre, by `cogging.size_at`.
        pace: Bound on the size of their rates.
        body: What moves.

    ``then``: the mode after it, `HELD`, `MIXED` or `NOT_TOLD`; ``ratio``: q / r, or a bound on it where mixed;
    ``window``: within which they stop; ``dx``, ``dv``: what is left out.
    """
    pull = mode * cog_acceleration(z, u, slope, body)
    rate = body.friction - pull
    if not rate > 0.0:
        return NOT_TOLD, 0.0, 0.0, 0.0, 0.0
    window = 2.0 * most / rate
    off = stiff_of(body) * (apart + pace * window)
    if not 2.0 * off <= rate:
        return NOT_TOLD, 0.0, 0.0, 0.0, 0.0
    least = rate - off
    dx = 0.5 * (rate + off) * (most / least) * (most / least) * ROUNDED
    after = -pull - body.friction
    if after > off:
        dv = most * off * (rate + after) / (rate * least) * ROUNDED
        return -mode, after / rate, window, dx, dv
    if after < -off:
        return HELD, 0.0, window, dx, 0.0
    return MIXED, (max(after, 0.0) + off) / least * ROUNDED, window, dx, 0.0


def fold(z, corners, count, mode, numbers, room):
    """Fold the states of a piece whose speed is not that of ``mode``; its corners, in ``corners``.

    ``numbers``: ``(then, ratio, window, dx, dv)``, of `fold_at`. ``room``: with ``one``, ``other`` and ``points``.
    """
    then, ratio, _, dx, dv = numbers
    one = keep_side(corners, count, 0.0, float(mode), -mode * z[1], room.one)
    other = keep_side(corners, count, 0.0, -float(mode), mode * z[1], room.other)
    at = z[1] * ratio if z[1] * mode < 0.0 else z[1]
    made = 0
    for k in range(one):
        room.points[2 * made], room.points[2 * made + 1] = room.one[2 * k], z[1] + room.one[2 * k + 1] - at
        made += 1
    for k in range(other):
        speed = z[1] + room.other[2 * k + 1]
        room.points[2 * made], room.points[2 * made + 1] = room.other[2 * k], speed * ratio - at
        made += 1
        if then == MIXED:
            room.points[2 * made], room.points[2 * made + 1] = room.other[2 * k], -at
            made += 1
    z[1] = at
    count = hull(room.points, made, corners)
    while count > MOST_CORNERS:
        count = drop_edge(corners, count)
    return widen(corners, count, dx, dv, room.points)


def glide(z, u, slope, mode, span, body, pad):
    """Let ``z`` slide in ``mode`` over ``span``, as `WHOLE` tells times apart, on one slope, past its stop."""
    half, left = 0, span
    table = COGGED_HALVES if is_stable(slope) else COGGED_HALVES + HALVINGS
    while left > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        cog_rate(z, u, slope, mode, body, pad)
        stretch(z, pad, table + half, body)
        accept(z, pad, body.order)
        left -= h


def falls_or_rises(rates, span, apart, pace, body):
    """Whether the speeds of all states change one way over ``span``, at whose ends the centre's have these rates."""
    first, last = rates
    if first * last < 0.0:
        return False
    return 0.5 * (abs(first) + abs(last) - stiff_of(body) * pace * span) > stiff_of(body) * apart


def keeps_way(room, u, slope, mode, span, signs, sizes, body):
    """Whether no state that slides in ``mode`` from ``room.first`` to ``room.z`` changes the sign of its speed.

    ``signs``: whether some may have another sign where it begins, where all are to rise; and whether some may change it
    where it ends, where all fall. ``sizes``: how far states are from the centre, and a bound on their rates.
    """
    z, (begins, turns), (apart, pace) = room.z, signs, sizes
    first = mode * cog_acceleration(room.first, u, slope, body) - body.friction
    last = mode * cog_acceleration(z, u, slope, body) - body.friction
    if falls_or_rises((first, last), span, apart, pace, body):
        return not begins if first < 0.0 else not turns
    lead, wait, stiff = 0.0, 0.0, stiff_of(body)
    if begins or room.first[1] * mode < 2.0 * apart:
        if not first > 0.0:
            return False
        lead = floor(4.0 * apart / first * WHOLE + 1.0) / WHOLE
        if not first > 2.0 * stiff * (apart + pace * lead):
            return False
    if turns:
        if not last < 0.0:
            return False
        wait = 4.0 * apart / -last
        if not -last > 2.0 * stiff * (apart + pace * wait):
            return False
    if not span > lead + wait:
        return False
    copy_to(room.begun, room.first)
    glide(room.begun, u, slope, mode, lead, body, room.pad)
    return stays_over(room.begun, u, slope, mode, span - lead - wait, apart, body, room.pad)


def carry(columns, corners, count):
    """Move the corners of a piece by two columns of a derivative."""
    for k in range(count):
        a, b = corners[2 * k], corners[2 * k + 1]
        corners[2 * k] = a * columns[0] + b * columns[2]
        corners[2 * k + 1] = a * columns[1] + b * columns[3]


def fold_first(room, folds, corners, count, u, span, error, body):
    """Fold a piece that begins a hold with speeds of both signs: ``(mode, corners)``, the mode in which all go on.

    `HELD`: all stop; `NOT_TOLD`: they do not all do alike.
    """
    z = room.z
    slope = slope_at(z[0], body.cogs)
    low, high = speeds_of(z, corners, count, error)
    radius = size_of_piece(corners, count, body) + abs(z[1]) + error
    at = z[1]
    z[1] = 0.0
    for k in range(count):
        corners[2 * k + 1] += at
    pull = cog_acceleration(z, u, slope, body)
    cog_rate(z, u, slope, 1 if pull > 0.0 else -1, body, room.pad)
    apart = radius * exp(growth_rate(body) * span) * ROUNDED
    grown = exp(growth_rate(body) * span) * ROUNDED
    pace = size_at(body.cogs, room.pad, 0, body) * grown + room.fast[1] * apart + 2.0 * body.friction
    mode = 1 if pull > 0.0 else -1
    against = max(-low, 0.0) if mode > 0 else max(high, 0.0)
    along = max(high, 0.0) if mode > 0 else max(-low, 0.0)
    numbers = fold_at(z, u, slope, -mode, against, apart, pace, body)
    then, _, window, dx, dv = numbers
    if then == mode and window < span:
        room.arc[BESIDE] += dx / unit_reach(body) + dv
        # Those of the other sign: fold keeps what slides in ``mode``.
        return mode, fold(z, corners, count, mode, numbers, folds)
    if then == HELD and window < span:
        others = fold_at(z, u, slope, mode, along, apart, pace, body)
        if others[0] == HELD and others[2] < span:
            for k in range(count):
                corners[2 * k + 1] = 0.0
            return HELD, widen(corners, count, max(dx, others[3]), 0.0, folds.points)
    return NOT_TOLD, count


def cross_rubbing(room, folds, corners, count, u, span, drift, body):
    """Move a piece that does not stand, whose centre is ``room.z``, over a hold: ``(told, stands, corners)``.

    ``told``: whether it was known what all states do; else nothing that is left is of use. ``room.arc`` has the error.
    """
    arc, z, pad, cogs = room.arc, room.z, room.pad, body.cogs
    arc[BESIDE] = 0.0
    columns, reach = Columns(room.columns, 3 * body.order, 2, body.order), unit_reach(body)
    low, high = speeds_of(z, corners, count, arc[ERROR])
    if low > 0.0 or high < 0.0:
        mode = 1 if low > 0.0 else -1
    else:
        mode, count = fold_first(room, folds, corners, count, u, span, arc[ERROR], body)
        if mode == NOT_TOLD:
            return False, False, count
        if mode == HELD:
            return True, True, count
    if z[1] * mode < 0.0:
        for k in range(count):
            corners[2 * k + 1] += z[1]
        z[1] = 0.0
    began = low > 0.0 or high < 0.0
    slope, left, rate = slope_at(z[0], cogs), span, growth_rate(body)
    fresh, passed = z[1] == 0.0, False
    for _ in range(64):
        radius = size_of_piece(corners, count, body) + arc[ERROR]
        grown = exp(rate * left) * ROUNDED
        apart = radius * grown
        cog_rate(z, u, slope, mode, body, pad)
        fast = size_at(cogs, pad, 0, body) * grown
        pace = fast + room.fast[1] * apart + 2.0 * body.friction
        far = min(reach * apart, places_of(corners, count) + reach * arc[ERROR] + apart * left)
        far += 8.0 * EPSILON * abs(z[0])
        wrong, skewed = rounded_by(room, z, u, fast * left, radius * grown, drift, body)
        room.columns[0], room.columns[1], room.columns[2], room.columns[3] = 1.0, 0.0, 0.0, 1.0
        copy_to(room.first, z)
        t, end, steps = roll_in_steps(z, u, slope, mode, left, fresh, body, pad)
        spread_cogs(columns, t, slope, mode, body, pad)
        carry(room.columns, corners, count)
        left -= t
        turns = end == TURNED
        near = time_of_piece(room, z, slope, mode, (passed, end > TURNED), Spread(apart, far, fast), t, cogs)
        more = 2.0 * cogs[SLOPE] * far * near * grown
        arc[ERROR] = (arc[ERROR] + wrong * (1.0 + steps) + STEPS * skewed) * grown
        if more > 0.0:
            arc[BESIDE] += more
            count = widen(corners, count, reach * more, more, folds.points)
        low, high = speeds_of(z, corners, count, arc[ERROR])
        least = low if mode > 0 else -high
        stops = turns or least < 0.0
        # Where some have yet to stop, or have stopped, all speeds are to rise.
        if turns and not began:
            return False, False, count
        if not keeps_way(room, u, slope, mode, t, (not began, stops and began), (apart, pace), body):
            return False, False, count
        if not began:
            if end == 0:
                return True, False, count
            began = least > 0.0
            stops = False
        passed = end > TURNED
        if stops:
            most = max(-least, high if mode > 0 else -low, 0.0)
            if end > TURNED:
                return False, False, count
            if turns:
                z[1] = 0.0
                numbers = fold_at(z, u, slope, mode, most, apart, pace, body)
                then, ratio, window, dx, dv = numbers
                if then == NOT_TOLD:
                    return False, False, count
                if then != MIXED and window < left:
                    for k in range(count):
                        corners[2 * k + 1] *= ratio
                    arc[BESIDE] += dx / reach + dv
                    count = widen(corners, count, dx, dv, folds.points)
                    if then == HELD:
                        for k in range(count):
                            corners[2 * k + 1] = 0.0
                        return True, True, count
                    mode, fresh, began = then, True, False
                    continue
                if window < left or not room_on(z[0], slope, cogs) > far + pace * left * left:
                    return False, False, count
                room.columns[0], room.columns[1], room.columns[2], room.columns[3] = 1.0, 0.0, 0.0, 1.0
                arc[ERROR] += 64.0 * wrong
                left = floor(left * WHOLE) / WHOLE
                glide(z, u, slope, mode, left, body, pad)
                spread_cogs(columns, left, slope, mode, body, pad)
                carry(room.columns, corners, count)
                low, high = speeds_of(z, corners, count, arc[ERROR])
                least = low if mode > 0 else -high
                left = 0.0
            numbers = fold_at(z, u, slope, mode, max(-least, 0.0), apart, pace, body)
            if numbers[0] == NOT_TOLD:
                return False, False, count
            arc[BESIDE] += numbers[3] / reach + numbers[4]
            if numbers[0] == MIXED:
                arc[BESIDE] += numbers[1] * max(-least, 0.0)
            return True, False, fold(z, corners, count, mode, numbers, folds)
        if end == 0:
            return True, False, count
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True
    return False, False, count
