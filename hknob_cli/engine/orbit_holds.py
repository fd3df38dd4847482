"""One period of an orbit, hold by hold, and the kinds of its holds: one a sample, or two where a delay splits it.

Of each kind there are integrals over one hold, of the position, its square, and the square of the velocity, as forms of
its start. They are linear and quadratic in z = (x, v, drive), exact for any stiffness: the form over a short piece is
taken by Gauss-Legendre quadrature, exact to rounding there, and doubled, W(2h) = W(h) + Phi(h)^T W(h) Phi(h), adding
positive terms only (Van Loan 1978 gives the same integrals by one exponential, which a stiff plant overflows).

The numbers lie flat, `PART` a kind, in the order in which the kinds follow one another in a sample interval.
"""

from math import sqrt
from typing import Any, NamedTuple

from hknob_cli.engine.loop import copy_line, level_of, push
from hknob_cli.engine.propagator import hold_coefficients

# Gauss-Legendre, 10 nodes: the nodes in pairs and their weights (Abramowitz & Stegun, table 25.4).
RULE = (
    (-0.14887433898163122, 0.2955242247147528),
    (0.14887433898163122, 0.2955242247147528),
    (-0.4333953941292472, 0.2692667193099965),
    (0.4333953941292472, 0.2692667193099965),
    (-0.6794095682990244, 0.219086362515982),
    (0.6794095682990244, 0.219086362515982),
    (-0.8650633666889845, 0.1494513491505804),
    (0.8650633666889845, 0.1494513491505804),
    (-0.9739065285171717, 0.06667134430868814),
    (0.9739065285171717, 0.06667134430868814),
)


def carried(w, p, q):
    """Form ``w`` of the state at the end of a hold, as one of its start: Phi^T W Phi.

    A symmetric form lies as (xx, xv, xu, vv, vu, uu); ``p``, ``q`` are the rows of Phi that give x and v, and the
    drive u stays.
    """
    xx, xv, xu, vv, vu, uu = w
    p1, p2, p3 = p
    q1, q2, q3 = q
    # Columns of W Phi, in its rows for x and v.
    a1, b1 = xx * p1 + xv * q1, xv * p1 + vv * q1
    a2, b2 = xx * p2 + xv * q2, xv * p2 + vv * q2
    a3, b3 = xx * p3 + xv * q3 + xu, xv * p3 + vv * q3 + vu
    c3 = xu * p3 + vu * q3 + uu
    return (
        p1 * a1 + q1 * b1,
        p1 * a2 + q1 * b2,
        p1 * a3 + q1 * b3,
        p2 * a2 + q2 * b2,
        p2 * a3 + q2 * b3,
        p3 * a3 + q3 * b3 + c3,
    )


def hold_forms(alpha, beta, duration):
    """Forms over a hold: of x (3 numbers), of its square (6), and of the square of the velocity (6), in one tuple."""
    h, doublings = duration, 0
    pace = max(alpha, sqrt(beta))
    while pace * h > 1.0:
        h *= 0.5
        doublings += 1
    mx, mv, mu = 0.0, 0.0, 0.0
    square = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    speed = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for node, weight in RULE:
        s, g, f = hold_coefficients(alpha, beta, 0.5 * h * (node + 1.0))
        part = 0.5 * h * weight
        p, q = 1.0 - beta * g, -beta * s
        mx, mv, mu = mx + part * p, mv + part * s, mu + part * g
        xx, xv, xu, vv, vu, uu = square
        square = (
            xx + part * p * p,
            xv + part * p * s,
            xu + part * p * g,
            vv + part * s * s,
            vu + part * s * g,
            uu + part * g * g,
        )
        xx, xv, xu, vv, vu, uu = speed
        speed = (
            xx + part * q * q,
            xv + part * q * f,
            xu + part * q * s,
            vv + part * f * f,
            vu + part * f * s,
            uu + part * s * s,
        )
    for _ in range(doublings):
        s, g, f = hold_coefficients(alpha, beta, h)
        p, q = (1.0 - beta * g, s, g), (-beta * s, f, s)
        mx, mv, mu = (
            mx + (mx * p[0] + mv * q[0]),
            mv + (mx * p[1] + mv * q[1]),
            mu + (mx * p[2] + mv * q[2] + mu),
        )
        xx, xv, xu, vv, vu, uu = carried(square, p, q)
        square = (square[0] + xx, square[1] + xv, square[2] + xu, square[3] + vv, square[4] + vu, square[5] + uu)
        xx, xv, xu, vv, vu, uu = carried(speed, p, q)
        speed = (speed[0] + xx, speed[1] + xv, speed[2] + xu, speed[3] + vv, speed[4] + vu, speed[5] + uu)
        h *= 2.0
    return (mx, mv, mu, *square, *speed)


LENGTH, S, G = 0, 1, 2  # of the hold, and its coefficients
MEAN, SQUARE, SPEED = 3, 6, 12  # forms of `orbit.forms`
PART = 18


def fill_part(parts, kind, alpha, beta, length):
    """Fill in the numbers of one ``kind`` of hold."""
    base = kind * PART
    parts[base + LENGTH] = length
    parts[base + S], parts[base + G], _ = hold_coefficients(alpha, beta, length)
    forms = hold_forms(alpha, beta, length)
    for i in range(len(forms)):
        parts[base + MEAN + i] = forms[i]


def fill_parts(parts, loop):
    """Fill in the numbers of the holds of a loop."""
    if loop.split > 0.0:
        fill_part(parts, 0, loop.alpha, loop.beta, loop.split)
        fill_part(parts, 1, loop.alpha, loop.beta, 1.0 - loop.split)
    else:
        fill_part(parts, 0, loop.alpha, loop.beta, 1.0)


class Holds(NamedTuple):
    """The holds of one period of an orbit, lists or arrays; counts and sample periods.

    ``x``, counts, and ``v``, counts per sample: state at the start of each and, last, at the end; ``drive``, counts per
    sample²: what accelerates the knob in each beside spring and damping, one entry less.
    """

    x: Any
    v: Any
    drive: Any


def holds_per_sample(loop):
    """Holds in a sample interval: two where a delay splits it."""
    return 2 if loop.split > 0.0 else 1


def trace(x, v, ring, head, n, loop, holds):
    """Fill in the holds of ``n`` samples from ``(x, v)``: the state at the start of each, and the drive in it.

    ``holds`` takes n times `holds_per_sample` of them; the last state closes the period. Returns the sums of the
    positions at which holds start, and of the drives.
    """
    xs, vs, drive = holds
    delay = len(ring)
    line = copy_line(ring)
    at, hold = head, 0
    split = loop.split > 0.0
    places, drives = 0.0, 0.0
    for _ in range(n):
        older, newer = push(level_of(x, loop.sense), line, at, loop)
        if split:
            xs[hold], vs[hold], drive[hold] = x, v, older
            places, drives = places + x, drives + older
            hold += 1
            y = older - loop.beta * x
            x, v = x + (loop.s1 * v + loop.g1 * y), loop.f1 * v + loop.s1 * y
        xs[hold], vs[hold], drive[hold] = x, v, newer
        places, drives = places + x, drives + newer
        hold += 1
        y = newer - loop.beta * x
        x, v = x + (loop.s2 * v + loop.g2 * y), loop.f2 * v + loop.s2 * y
        if delay > 0:
            at = (at + 1) % delay
    xs[hold], vs[hold] = x, v
    return places, drives
