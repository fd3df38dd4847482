"""A second-order knob's response to a recorded torque, exact hold by hold, with its derivatives by the plant's numbers.

Time in sample periods, angle in rad:  x'' + alpha x' + beta x = gain * torque - phi sign(x'),  where

    alpha = B T / J,   beta = K T^2 / J,   gain = T^2 / J,   phi = (Coulomb torque) T^2 / J.

The torque is held, or decays exponentially within a hold (a motor with a lag). Derivatives are those of the exact
solution: the plant's equation differentiated by alpha, by beta and by phi, and solved by the same series.
"""

from math import exp
from typing import Any, NamedTuple

TERMS = 22  # of Taylor series whose coefficients are at most 1/n!: 1/22! is 1e-21
SERIES = 17  # of a matrix's exponential at norm 1/2: 0.5^17/17! is 2e-20


class Pull(NamedTuple):
    """A recorded torque, N m.

    ``torque`` (n,) is held from sample i to i + 1; ``fading`` (n,) or empty: a part added to it that decays at
    ``decay`` per sample within the hold.
    """

    torque: Any
    fading: Any
    decay: float


class Coefficients(NamedTuple):
    """Those of the equation above: ``gain``, rad per N m, ``alpha``, ``beta``, and ``phi``, rad."""

    gain: float
    alpha: float
    beta: float
    phi: float


def rise_series(alpha, beta, decay):
    """Response from rest to exp(-decay t) at t = 1, for alpha, beta, decay <= 1 in size.

    Value and slope, and the derivatives of both by alpha, then by beta: six floats.
    """
    drive = 1.0
    c0, c1, a0, a1, b0, b1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    q, r, qa, ra, qb, rb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(1, TERMS):
        below = 1.0 / ((n + 1) * n)
        c2 = (drive - alpha * n * c1 - beta * c0) * below
        a2 = -(n * c1 + alpha * n * a1 + beta * a0) * below
        b2 = -(c0 + alpha * n * b1 + beta * b0) * below
        c0, c1, a0, a1, b0, b1 = c1, c2, a1, a2, b1, b2
        q += c1
        r += (n + 1) * c1
        qa += a1
        ra += (n + 1) * a1
        qb += b1
        rb += (n + 1) * b1
        drive *= -decay / n
    return q, r, qa, ra, qb, rb


def hold_derivatives(alpha, beta, decay, t):
    """Coefficients ``(S, G, F, Q, R)`` over a time t, their derivatives by alpha, and by beta: 15 floats.

    ``S, G, F`` as `propagator.hold_coefficients`; ``Q, R`` are position and velocity from rest under exp(-decay t).
    Beyond the series' reach by doubling a shorter time.
    """
    size = max(abs(alpha) * t, max(abs(beta) * t * t, decay * t))
    doublings = 0
    while size > 1.0:
        size *= 0.5
        doublings += 1
    h = t / 2.0**doublings
    hh = h * h
    g, s, ga, sa, gb, sb = rise_series(alpha * h, beta * hh, 0.0)
    q, r, qa, ra, qb, rb = rise_series(alpha * h, beta * hh, decay * h)
    g, s, q, r = g * hh, s * h, q * hh, r * h
    ga, sa, qa, ra = ga * hh * h, sa * hh, qa * hh * h, ra * hh
    gb, sb, qb, rb = gb * hh * hh, sb * hh * h, qb * hh * hh, rb * hh * h
    f = 1.0 - alpha * s - beta * g
    fa = -s - alpha * sa - beta * ga
    fb = -alpha * sb - g - beta * gb
    for k in range(doublings):
        e = exp(-decay * h * 2.0**k)
        p, pa, pb = 1.0 - beta * g, -beta * ga, -g - beta * gb
        m, ma, mb = -beta * s, -beta * sa, -s - beta * sb
        q, r, qa, ra, qb, rb = (
            p * q + s * r + e * q,
            m * q + f * r + e * r,
            pa * q + p * qa + sa * r + s * ra + e * qa,
            ma * q + m * qa + fa * r + f * ra + e * ra,
            pb * q + p * qb + sb * r + s * rb + e * qb,
            mb * q + m * qb + fb * r + f * rb + e * rb,
        )
        g, s, ga, sa, gb, sb = (
            p * g + s * s + g,
            m * g + f * s + s,
            pa * g + p * ga + 2.0 * s * sa + ga,
            ma * g + m * ga + fa * s + f * sa + sa,
            pb * g + p * gb + 2.0 * s * sb + gb,
            mb * g + m * gb + fb * s + f * sb + sb,
        )
        f = 1.0 - alpha * s - beta * g
        fa = -s - alpha * sa - beta * ga
        fb = -alpha * sb - g - beta * gb
    return s, g, f, q, r, sa, ga, fa, qa, ra, sb, gb, fb, qb, rb


def move_freely(alpha, beta, slopes):
    """Fill columns 3, 4 of ``slopes`` (n, 5): the motion without torque from angle 1, and from speed 1."""
    s, g, f, _q, _r, _sa, _ga, _fa, _qa, _ra, _sb, _gb, _fb, _qb, _rb = hold_derivatives(alpha, beta, 0.0, 1.0)
    for k in range(2):
        x, v = 1.0 - k, 1.0 * k
        for i in range(len(slopes)):
            slopes[i, 3 + k] = x
            d = -beta * x
            x += s * v + g * d
            v = f * v + s * d


def follow_torque(pull, plant, first, speed, angle, slopes):
    """Angle at every sample, and its derivatives by alpha and beta at a fixed gain, without Coulomb friction.

    ``pull``: a `Pull`; ``plant``: its `Coefficients`; ``first`` angle, rad, and ``speed``, rad per sample. Fills
    ``angle`` (n,) rad and columns 0, 1 of ``slopes`` (n, 3), and of (n, 5) columns 3, 4: by first angle and speed.
    """
    torque, fading, decay = pull
    gain, alpha, beta, _phi = plant
    s, g, f, q, r, sa, ga, fa, qa, ra, sb, gb, fb, qb, rb = hold_derivatives(alpha, beta, decay, 1.0)
    x, v, xa, va, xb, vb = first, speed, 0.0, 0.0, 0.0, 0.0
    lagging = len(fading) > 0
    if slopes.shape[1] > 3:
        move_freely(alpha, beta, slopes)
    for i in range(len(torque)):
        angle[i], slopes[i, 0], slopes[i, 1] = x, xa, xb
        d = gain * torque[i] - beta * x
        da, db = -beta * xa, -x - beta * xb
        w = gain * fading[i] if lagging else 0.0
        xa += sa * v + s * va + ga * d + g * da + qa * w
        va = fa * v + f * va + sa * d + s * da + ra * w
        xb += sb * v + s * vb + gb * d + g * db + qb * w
        vb = fb * v + f * vb + sb * d + s * db + rb * w
        x += s * v + g * d + q * w
        v = f * v + s * d + r * w


def follow_linear(drive, move, push, moves, pushes, work, angle, slopes):
    """First state of a linear plant from rest under a held drive, and its derivatives by any parameters.

    ``move`` (m, m) and ``push`` (m,): state after a hold is move @ state + push * drive; ``moves`` (p, m, m) and
    ``pushes`` (p, m): their derivatives by each parameter; ``work`` (p + 2, m): zeros, overwritten. Fills ``angle``
    (n,) and ``slopes`` (n, p).
    """
    m, p = len(push), len(moves)
    for i in range(len(drive)):
        angle[i] = work[p, 0]
        for k in range(p):
            slopes[i, k] = work[k, 0]
            for a in range(m):
                total = pushes[k, a] * drive[i]
                for b in range(m):
                    total += moves[k, a, b] * work[p, b] + move[a, b] * work[k, b]
                work[p + 1, a] = total
            for a in range(m):
                work[k, a] = work[p + 1, a]
        for a in range(m):
            total = push[a] * drive[i]
            for b in range(m):
                total += move[a, b] * work[p, b]
            work[p + 1, a] = total
        for a in range(m):
            work[p, a] = work[p + 1, a]


def set_product(found, one, other, divisor):
    """Set ``found`` (m, m) to the product of two matrices over ``divisor``."""
    m = len(found)
    for a in range(m):
        for b in range(m):
            total = 0.0
            for c in range(m):
                total += one[a, c] * other[c, b]
            found[a, b] = total / divisor


def set_both(found, first, second, third, fourth, divisor):
    """Set ``found`` (m, m) to two products, ``first`` by ``second`` and ``third`` by ``fourth``, over ``divisor``."""
    m = len(found)
    for a in range(m):
        for b in range(m):
            total = 0.0
            for c in range(m):
                total += first[a, c] * second[c, b] + third[a, c] * fourth[c, b]
            found[a, b] = total / divisor


def exponential(whole, wholes, squarings, value, slopes, term, terms, spare):
    """Exponential of 2^squarings times ``whole`` (m, m), and its derivatives for ``wholes`` (p, m, m), its own.

    By Taylor series, scaling and squaring, of norm 1/2 at most (Higham, *Functions of Matrices*, sec. 10.3); the
    derivatives are those of the series, term by term. Fills ``value`` (m, m) and ``slopes`` (p, m, m); ``term`` (m, m),
    ``terms`` (p, m, m) and ``spare`` (m, m) are overwritten.
    """
    m, p = len(whole), len(wholes)
    for a in range(m):
        for b in range(m):
            term[a, b] = value[a, b] = whole[a, b]
        value[a, a] += 1.0
    for k in range(p):
        for a in range(m):
            for b in range(m):
                terms[k, a, b] = slopes[k, a, b] = wholes[k, a, b]
    for n in range(2, SERIES):
        for k in range(p):
            set_both(spare, terms[k], whole, term, wholes[k], n)
            for a in range(m):
                for b in range(m):
                    terms[k, a, b] = spare[a, b]
                    slopes[k, a, b] += spare[a, b]
        set_product(spare, term, whole, n)
        for a in range(m):
            for b in range(m):
                term[a, b] = spare[a, b]
                value[a, b] += spare[a, b]
    for _ in range(squarings):
        for k in range(p):
            set_both(spare, slopes[k], value, value, slopes[k], 1)
            for a in range(m):
                for b in range(m):
                    slopes[k, a, b] = spare[a, b]
        set_product(spare, value, value, 1)
        for a in range(m):
            for b in range(m):
                value[a, b] = spare[a, b]
