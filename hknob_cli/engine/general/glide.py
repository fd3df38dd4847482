"""Gliding: the motion under one constant command, exact, from event to event.

With Coulomb friction the motion is piecewise linear: it slides one way until the velocity vanishes, and then turns
round or is held, until the other torques exceed the friction level. For a second-order body the time to the next zero
of the velocity has a closed form. With more states the step is halved until the velocity, or the torque on a held knob,
can be shown to keep its sign in it or to be monotone: its second derivative is bounded by the energy of the rates,
which never grows. A monotone change of sign is then bracketed by halving down to the last bit of a sample period.
"""

from math import expm1, floor, log, log1p, sqrt

from hknob_cli.engine.general.body import HALVINGS, acceleration, rate_of
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero

FREE = 2  # mode of a motion whose turning points do not matter
SHORTEST = 20  # a slide that begins with next to no acceleration takes at least 2^-20 of a sample
FINEST = 2.0 ** (HALVINGS - 1)
MANY_TURNS = 8.0  # half cycles of ringing left in a hold beyond which they are taken in one


def direction(z, u, body):
    """Mode of the motion that begins at ``z``: +1 or -1 sliding, 0 held."""
    if z[1] > 0.0:
        return 1
    if z[1] < 0.0:
        return -1
    a = acceleration(z, u, body)
    if abs(a) <= body.friction:
        return 0
    return 1 if a > 0.0 else -1


def carry(z, u, span, s, g, f, body):
    """Second order: move ``z`` over ``span`` with coefficients (s, g, f), ``u`` holding all constant torques."""
    y = u - body.beta * z[0]
    x = z[0] + (s * z[1] + g * y)
    z[1] = f * z[1] + s * y
    z[0] = x


def spread(cols, du, count, width, s, g, f, body):
    """Move the columns of derivatives by the same coefficients; ``du``: the part of each in the command."""
    for c in range(count):
        at = c * width
        y = du[c] - body.beta * cols[at]
        x = cols[at] + (s * cols[at + 1] + g * y)
        cols[at + 1] = f * cols[at + 1] + s * y
        cols[at] = x


def skip_turns(z, u, left, body):
    """Time taken by a whole number of half cycles from a standstill, all but the last few; ``z`` moves with them.

    At its turning points a ringing knob is A from where it would rest without friction, and A falls to r A - (1 + r) q
    per half cycle, q = friction / stiffness, r = exp(-alpha/2 spacing).
    """
    rest = u / body.beta
    q = body.friction / body.beta
    away = abs(z[0] - rest)
    k = 0.5 * body.alpha * body.spacing
    if k > 0.0:
        fall = -expm1(-k)
        bound = (2.0 - fall) * q / fall
        last = log((away + bound) / (q + bound)) / k if q > 0.0 else left / body.spacing
    else:
        last = (away - q) / (2.0 * q)
    turns = floor(min(last, left / body.spacing)) - 2.0
    if turns < 1.0:
        return 0.0
    if k > 0.0:
        decay = expm1(-k * turns)
        away = (decay + 1.0) * away - q * (2.0 + expm1(-k)) * decay / expm1(-k)
    else:
        away -= 2.0 * q * turns
    side = 1.0 if z[0] > rest else -1.0
    z[0] = rest + (side if turns % 2.0 == 0.0 else -side) * away
    return turns * body.spacing


def slide_two(z, u, mode, left, span, s, g, f, body, cols, du, count, width):
    """Second order: slide until the velocity vanishes or ``left`` is over; ``(time, whether it vanished)``.

    (s, g, f) are the coefficients over ``span``, used where nothing happened in it; a ``span`` of 0 if there are none.
    """
    if mode == 0:
        return left, False
    u = u + body.constant[1] - mode * body.friction
    if left != span or body.spacing < left:
        t = first_zero(z[1], u - body.beta * z[0], body.alpha, body.beta)
        if t >= left:
            t = left
        s, g, f = hold_coefficients(body.alpha, body.beta, t)
    else:
        t = left
        y = u - body.beta * z[0]
        if (f * z[1] + s * y) * mode < 0.0 or (z[1] == 0.0 and y * mode < 0.0):
            t = min(first_zero(z[1], y, body.alpha, body.beta), left)
            s, g, f = hold_coefficients(body.alpha, body.beta, t)
    carry(z, u, t, s, g, f, body)
    spread(cols, du, count, width, s, g, f, body)
    if t < left or z[1] * mode < 0.0:
        z[1] = 0.0
        return t, t < left
    return t, False


def stretch(z, rate, half, table, n, out):
    """State after 2^-``half`` of a sample."""
    base = half * n * n
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += table[base + i * n + j] * rate[j]
        out[i] = z[i] + total


def spread_many(cols, du, count, width, half, mode, body, work):
    """Move the columns of derivatives over 2^-``half`` of a sample."""
    n = body.order
    base = half * n * n
    for c in range(count):
        at = c * width
        for i in range(n):
            total = 0.0
            if mode != 0 and body.lag == 0.0:
                total = body.entry[i] * du[c]
            for j in range(n):
                total += (body.held[i * n + j] if mode == 0 else body.rates[i * n + j]) * cols[at + j]
            work[i] = total
        if body.lag > 0.0:
            work[n - 1] += body.lag * du[c]
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += (body.halves_held[base + i * n + j] if mode == 0 else body.halves[base + i * n + j]) * work[j]
            cols[at + i] += total


def sliding_bound(rate, body):
    """Bound on the second derivative of the velocity from here on, by the energy of the rates."""
    n = body.order
    late = abs(rate[n - 1]) if body.lag > 0.0 else 0.0
    grown = late / body.lag if body.lag > 0.0 else 0.0
    if body.ratio > 0.0:
        finger, tip = rate[1] - rate[3], rate[0] - rate[2]
        square = rate[1] * rate[1] + body.pad_stiffness * rate[2] * rate[2]
        square += (finger * finger + body.finger_stiffness * tip * tip) / body.ratio
        stiff = body.alpha + body.pad_damping * (1.0 + sqrt(body.ratio)) + sqrt(body.pad_stiffness)
    else:
        square = rate[1] * rate[1] + body.beta * rate[0] * rate[0]
        stiff = body.alpha + sqrt(body.beta)
    return (sqrt(square) + grown) * stiff + late


def held_bound(rate, body):
    """Bound on the second derivative of the torque on a held knob."""
    n = body.order
    bound = body.lag * abs(rate[n - 1]) if body.lag > 0.0 else 0.0
    if body.ratio > 0.0:
        r, p = body.ratio, body.pad_stiffness
        energy = sqrt(rate[3] * rate[3] / r + (p + body.finger_stiffness / r) * rate[2] * rate[2])
        jerk = sqrt(r) * (r * body.pad_damping + body.finger_damping) + r * sqrt(p) + sqrt(body.finger_stiffness * r)
        bound += energy * (body.pad_damping * jerk + p * sqrt(r))
    return bound


def crossed(z, u, mode, body):
    """Whether a motion in ``mode`` is past its end: turned round, or no longer held."""
    if mode == 0:
        return abs(acceleration(z, u, body)) > body.friction
    return z[1] * mode < 0.0


def slide_many(z, u, mode, left, body, rate, work, cols, du, count, width):
    """More states: move in one ``mode`` until it ends or ``left`` is over; ``(time, whether it ended)``."""
    n = body.order
    total = 0.0
    half = 0
    left = floor(left * FINEST) / FINEST
    while left > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        rate_of(z, u, mode, body, rate)
        if mode == 0:
            value = body.friction - abs(acceleration(z, u, body))
            slope = rate[n - 1] if body.lag > 0.0 else 0.0
            if body.ratio > 0.0:
                slope -= body.pad_damping * rate[3] + body.pad_stiffness * rate[2]
            bound = held_bound(rate, body)
            fall = -abs(slope)
        else:
            value = z[1] * mode
            slope = rate[1] * mode
            bound = sliding_bound(rate, body)
            fall = min(slope, 0.0)
        starting = mode != 0 and value == 0.0
        deepest = SHORTEST if starting else HALVINGS - 1
        safe = value + fall * h - 0.5 * bound * h * h > 0.0
        while not safe and abs(slope) <= bound * h and half < deepest:
            half += 1
            h *= 0.5
            safe = value + fall * h - 0.5 * bound * h * h > 0.0
        table = body.halves_held if mode == 0 else body.halves
        stretch(z, rate, half, table, n, work)
        if not safe and crossed(work, u, mode, body):
            if not starting:
                for deeper in range(half + 1, HALVINGS):
                    stretch(z, rate, deeper, table, n, work)
                    if not crossed(work, u, mode, body):
                        for i in range(n):
                            z[i] = work[i]
                        spread_many(cols, du, count, width, deeper, mode, body, work)
                        rate_of(z, u, mode, body, rate)
                        total += 0.5**deeper
                if mode != 0:
                    z[1] = 0.0
                return total, True
            for i in range(n):
                z[i] = work[i]
            z[1] = 0.0
            spread_many(cols, du, count, width, half, mode, body, work)
            return total + h, True
        for i in range(n):
            z[i] = work[i]
        spread_many(cols, du, count, width, half, mode, body, work)
        total += h
        left -= h
        if half > 0:
            half -= 1
    return total, False


def glide(z, u, span, part, body, rate, work):
    """Move ``z`` over a hold without friction; ``part`` 0: under the older command, 1: the rest of the interval."""
    n = body.order
    rate_of(z, u, FREE, body, rate)
    table = body.first if part == 0 else body.second
    stretch(z, rate, 0, table, n, work)
    for i in range(n):
        z[i] = work[i]


def rub(z, u, span, s, g, f, body, rate, work, cols, du, count, width, marks):
    """Move ``z`` over a hold from event to event; the number of events.

    (s, g, f): coefficients of a second-order body over ``span``. ``cols`` holds ``count`` columns of derivatives of the
    state, ``width`` apart, and ``du`` the derivative of the command in each: they follow the motion through its events
    (saltation, Leine & Nijmeijer 2004, sec. 7). ``marks`` keeps the least distance of a torque from the friction level
    where that decides [0], and of a velocity from zero at the end of a hold [1]. All may be empty.
    """
    left = span
    mode = direction(z, u, body)
    watched = len(marks) > 0
    if watched and z[1] == 0.0:
        marks[0] = min(marks[0], abs(abs(acceleration(z, u, body)) - body.friction))
    events = 0
    while left > 0.0:
        if body.order == 2:
            if not watched and z[1] == 0.0 and mode != 0 and left > MANY_TURNS * body.spacing:
                t = skip_turns(z, u + body.constant[1], left, body)
                if t > 0.0:
                    left -= t
                    mode = direction(z, u, body)
                    events += 1
                    continue
            t, hit = slide_two(z, u, mode, left, span, s, g, f, body, cols, du, count, width)
        else:
            t, hit = slide_many(z, u, mode, left, body, rate, work, cols, du, count, width)
        left -= t
        if not hit:
            break
        events += 1
        a = acceleration(z, u, body)
        if mode == 0:
            mode = 1 if a > 0.0 else -1
            continue
        then = 0
        if abs(a) > body.friction:
            then = 1 if a > 0.0 else -1
        if watched:
            marks[0] = min(marks[0], abs(abs(a) - body.friction))
        if count > 0:
            before = a - mode * body.friction
            after = 0.0 if then == 0 else a - then * body.friction
            if before != 0.0:
                jump = (after - before) / before
                for c in range(count):
                    speed = cols[c * width + 1]
                    for i in range(body.order):
                        cols[c * width + i] += body.entry[i] * speed * jump
        mode = then
    if watched and mode != 0:
        marks[1] = min(marks[1], abs(z[1]))
    return events
