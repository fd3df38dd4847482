"""The curve of all states that one start may have at its first sample: one for every clock phase.

The rate of the curve, q(phi), goes by exp(A phi), and, while all of a part of it acts alike, by Phi from sample to
sample.
So two states of that part differ by D(t) q, in which nothing cancels, and the energy of the rate never grows.
"""

from hknob_cli.engine.general.body import CONSTANT, HALVES, HALVINGS, norm
from hknob_cli.engine.general.sets.piece import power_of
from hknob_cli.engine.propagator import hold_coefficients


def drift_over(t, rate, out, body, pad):
    """D(t) times ``rate``, to ``out``, for a time from 0 to 1; not in place."""
    n = body.order
    if n == 2:
        s, g, _ = hold_coefficients(body.alpha, body.beta, t)
        out[0] = (s + body.alpha * g) * rate[0] + g * rate[1]
        out[1] = s * rate[1] - body.beta * g * rate[0]
        return
    for i in range(n):
        out[i] = 0.0
    h, left = 1.0, t
    for half in range(HALVINGS):
        if left >= h:
            left -= h
            base = (HALVES + half) * n * n
            for i in range(n):
                total = rate[i]
                for j in range(n):
                    total += body.matrices[i * n + j] * out[j]
                pad[i] = total
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += body.matrices[base + i * n + j] * pad[j]
                out[i] += total
        h *= 0.5


def apply(matrix, vector, n, out):
    """``matrix`` times ``vector``, to ``out``."""
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += matrix[i * n + j] * vector[j]
        out[i] = total


def place_on(phase, start, z, room, body):
    """State at the first sample, of a start that has moved freely for ``phase`` of a period."""
    n = body.order
    for i in range(n):
        total = body.vectors[CONSTANT * n + i]
        for j in range(n):
            total += body.matrices[i * n + j] * start[j]
        room.rate[i] = total
    drift_over(phase, room.rate, z, body, room.pad)
    for i in range(n):
        z[i] += start[i]


def rate_at(phase, room, body, out):
    """Rate of the curve at a phase, to ``out``: `place_on` has left that at phase 0 in ``room.rate``."""
    n = body.order
    drift_over(phase, room.rate, room.spare, body, room.pad)
    for i in range(n):
        total = room.rate[i]
        for j in range(n):
            total += body.matrices[i * n + j] * room.spare[j]
        out[i] = total


def measure_arc(low, high, sample, room, drift, body):
    """How an arc lies ``sample`` samples on: ``(radius, bulge)`` in the norm; `room.below`, `room.above`: its ends.

    The ends are told from its middle. ``radius``: half the length, at most. ``bulge``: from the chord.
    """
    n = body.order
    half = 0.5 * (high - low)
    power_of(sample, drift, n, room.matrix, room.power)
    rate_at(low, room, body, room.speed)
    drift_over(half, room.speed, room.spare, body, room.pad)
    for j in range(n):
        room.spare[j] = -room.spare[j]
    apply(room.matrix, room.spare, n, room.below)
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += body.matrices[i * n + j] * room.speed[j]
        room.turn[i] = total
    apply(room.matrix, room.turn, n, room.spare)
    bulge = 0.5 * half * half * norm(room.spare, body)
    apply(room.matrix, room.speed, n, room.spare)
    radius = half * norm(room.spare, body)
    rate_at(low + half, room, body, room.speed)
    drift_over(half, room.speed, room.spare, body, room.pad)
    apply(room.matrix, room.spare, n, room.above)
    return radius * (1.0 + drift.blur), bulge * (1.0 + drift.blur)


def move_centre(centre, middle, to, room, drift, body, out):
    """The state of an arc's phase ``to``, from its centre, which is that of its ``middle``; to ``out``."""
    n, z = body.order, centre.z
    power_of(int(centre.sample), drift, n, room.matrix, room.power)
    first = min(middle, to)
    rate_at(first, room, body, room.speed)
    drift_over(abs(to - middle), room.speed, room.spare, body, room.pad)
    apply(room.matrix, room.spare, n, out)
    sign = 1.0 if to > middle else -1.0
    for j in range(n):
        out[j] = z[j] + sign * out[j]
