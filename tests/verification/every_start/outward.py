"""Arithmetic on intervals (least, largest) of floats, rounded outward: the true result is never outside.

IEEE 754 addition, subtraction, multiplication, division and square root are the float nearest to the true result, so
that the next float on either side bounds it. Interpreted, or compiled by numba, which neither fuses nor reorders.
"""

import math

from tests.verification.every_start.compiling import compiled


@compiled
def up(x):
    """A float above every number that rounds to x."""
    return math.nextafter(x, math.inf)


@compiled
def down(x):
    """A float below every number that rounds to x."""
    return math.nextafter(x, -math.inf)


@compiled
def point(x):
    """The interval of one float."""
    return x, x


@compiled
def add(a, b):
    """a + b."""
    return down(a[0] + b[0]), up(a[1] + b[1])


@compiled
def subtract(a, b):
    """a - b."""
    return down(a[0] - b[1]), up(a[1] - b[0])


@compiled
def multiply(a, b):
    """a b."""
    w, x, y, z = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return down(min(w, x, y, z)), up(max(w, x, y, z))


@compiled
def divide(a, b):
    """a / b, where b does not contain 0."""
    w, x, y, z = a[0] / b[0], a[0] / b[1], a[1] / b[0], a[1] / b[1]
    return down(min(w, x, y, z)), up(max(w, x, y, z))


@compiled
def middle(a):
    """Some float in the interval."""
    return min(max(a[0], a[0] + 0.5 * (a[1] - a[0])), a[1])


@compiled
def reach(a, x):
    """How far the interval reaches from the float x, at most."""
    return max(up(a[1] - x), up(x - a[0]), 0.0)


@compiled
def size(dx, dv, inverse_beta):
    """At least sqrt(x^2 + v^2 / beta) of all |x| <= dx and |v| <= dv; ``inverse_beta`` is at least 1 / beta."""
    return up(math.sqrt(up(up(dx * dx) + up(up(dv * dv) * inverse_beta))))
