"""Sliding, or being held, with more than two states: the end of a mode is bracketed, never stepped over.

The step is halved until the velocity, or the torque on a held knob, can be shown to keep its sign in it or to be
monotone: its second derivative is bounded by the energy of the rates, which never grows. A monotone change of sign is
then bracketed by halving down to the last bit of a sample period.
"""

from math import floor, sqrt

from hknob_cli.engine.general.body import (
    HALVES,
    HALVES_HELD,
    HALVINGS,
    RATES,
    acceleration,
    coil_at,
    norm_at,
    rate_of,
    stiffness,
)

SHORTEST = 20  # a slide that begins with next to no acceleration takes at least 2^-20 of a sample
NIL = 1e-13  # acceleration, by the friction level, that rounding can make of none
FINEST = 2.0 ** (HALVINGS - 1)


def stretch(z, pad, matrix, body):
    """State after the time of ``matrix``, in the second half of ``pad``; its first half has the rate."""
    n = body.order
    base = matrix * n * n
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += body.matrices[base + i * n + j] * pad[j]
        pad[n + i] = z[i] + total


def keeps_sign(value, slope, bound, h):
    """Whether a value stays above 0 over ``h``: ``slope`` is its rate now, ``bound`` is on its second derivative."""
    return value + min(slope, 0.0) * h - 0.5 * bound * h * h > 0.0


def sliding_bound(rate, at, body):
    """Bound on the second derivative of the velocity from here on, by the energy of the rates; these begin at ``at``.

    From the rates of the rates, it is a bound on the third.
    """
    late = abs(rate[at + body.order - 1]) if body.lag > 0.0 else 0.0
    return norm_at(rate, at, body) * stiffness(body) + late


def held_slope(rate, body):
    """Rate of the torque on a held knob, by the rates of lag, finger and winding."""
    slope = rate[body.order - 1] if body.lag > 0.0 else 0.0
    if body.ratio > 0.0:
        slope -= body.pad_damping * rate[3] + body.pad_stiffness * rate[2]
    if body.coil > 0.0:
        slope -= body.coil * rate[coil_at(body)]
    return slope


def held_bound(rate, body):
    """Bound on the second derivative of the torque on a held knob."""
    n = body.order
    bound = body.lag * abs(rate[n - 1]) if body.lag > 0.0 else 0.0
    if body.ratio > 0.0:
        r, p = body.ratio, body.pad_stiffness
        energy = sqrt(rate[3] * rate[3] / r + (p + body.finger_stiffness / r) * rate[2] * rate[2])
        jerk = sqrt(r) * (r * body.pad_damping + body.finger_damping) + r * sqrt(p) + sqrt(body.finger_stiffness * r)
        bound += energy * (body.pad_damping * jerk + p * sqrt(r))
    if body.coil > 0.0:
        bound += body.coil * body.coil_rate * abs(rate[coil_at(body)])
    return bound


def outlook(z, u, mode, body, pad):
    """What keeps a mode going, and how it changes: ``(value, slope, fall, bound)``; ``pad`` is left with the rates.

    ``value``: speed, or what friction can hold beside the torque; ``fall``: its slope, at worst; ``bound``: on the rate
    of that.
    """
    rate_of(z, u, mode, body, pad)
    if mode == 0:
        slope = held_slope(pad, body)
        return body.friction - abs(acceleration(z, u, body)), slope, -abs(slope), held_bound(pad, body)
    slope = pad[1] * mode
    return z[1] * mode, slope, min(slope, 0.0), sliding_bound(pad, 0, body)


def crossed(pad, u, mode, body):
    """Whether the state in the second half of ``pad`` is past the end of ``mode``: turned round, or no longer held."""
    n = body.order
    if mode != 0:
        return pad[n + 1] * mode < 0.0
    total = body.drive
    for j in range(n):
        total += body.matrices[n + j] * pad[n + j]
    if body.lag == 0.0:
        total += u
    return abs(total) > body.friction


def accept(z, pad, n):
    """Take the state in the second half of ``pad``."""
    for i in range(n):
        z[i] = pad[n + i]


def creep(z, mode, left, body, pad):
    """Begin a slide whose acceleration is nil but grows, as after a slow release: its length, as halvings; -1 if none.

    The velocity is then half of its second derivative times the square of the time, up to a third of it. ``pad`` has
    the rates in its first half; the velocity is set where rounding would lose it.
    """
    n = body.order
    base = RATES * n * n
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += body.matrices[base + i * n + j] * pad[j]
        pad[n + i] = total
    bend = pad[n + 1] * mode
    bound = sliding_bound(pad, n, body)
    if not bend > 0.0:
        return -1
    half = 0
    h = 1.0
    while (h > left or bound * h > bend) and half < SHORTEST:
        half += 1
        h *= 0.5
    if h > left:
        return -1
    stretch(z, pad, HALVES + half, body)
    accept(z, pad, n)
    least = 0.3 * bend * h * h
    if not z[1] * mode > least:
        z[1] = mode * least
    return half


def slide_many(z, u, mode, left, body, pad):
    """Move ``z`` in one ``mode`` until it ends or ``left`` is over: ``(time, whether it ended, steps)``.

    A body that rings thousands of times in a sample takes a hundred thousand steps: each looks at ``body.halt``.
    """
    n = body.order
    total, steps = 0.0, 0
    half = 0
    left = floor(left * FINEST) / FINEST
    table = HALVES_HELD if mode == 0 else HALVES
    while left > 0.0 and not body.halt[0] > 0.0:
        steps += 1
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        value, slope, fall, bound = outlook(z, u, mode, body, pad)
        starting = mode != 0 and value == 0.0
        if starting and slope <= NIL * body.friction:
            taken = creep(z, mode, left, body, pad)
            if taken >= 0:
                total += 0.5**taken
                left -= 0.5**taken
                half = taken
                continue
        deepest = SHORTEST if starting else HALVINGS - 1
        safe = value + fall * h - 0.5 * bound * h * h > 0.0 or (slope == 0.0 and bound == 0.0)
        while not safe and abs(slope) <= bound * h and half < deepest:
            half += 1
            h *= 0.5
            safe = value + fall * h - 0.5 * bound * h * h > 0.0
        stretch(z, pad, table + half, body)
        if not safe and crossed(pad, u, mode, body):
            if starting:
                accept(z, pad, n)
                z[1] = 0.0
                return total + h, True, steps
            for deeper in range(half + 1, HALVINGS):
                rate_of(z, u, mode, body, pad)
                stretch(z, pad, table + deeper, body)
                if not crossed(pad, u, mode, body):
                    accept(z, pad, n)
                    total += 0.5**deeper
            if mode != 0:
                z[1] = 0.0
            return total, True, steps + HALVINGS
        accept(z, pad, n)
        total += h
        left -= h
        if half > 0:
            half -= 1
    return total, False, steps
