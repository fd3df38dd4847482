"""Fixed steps of three methods for y' = A y + r with Coulomb friction, as plain loops for numba.

State: knob angle and speed, then finger angle and speed or not, then torque or not. Friction is a deceleration ``d`` of
the knob against its speed; a step that would turn the speed stops it, and at rest it holds what is not above ``d``
(Karnopp). This is of first order at a stop, as in the programs of users.
"""

import numpy as np


def way_of(a, r, d, y):
    """Sign of the sliding; 0 without friction; 2 where the knob sticks."""
    if d == 0.0:
        return 0.0
    if y[1] != 0.0:
        return 1.0 if y[1] > 0.0 else -1.0
    pull = r[1]
    for j in range(len(y)):
        pull += a[1, j] * y[j]
    if abs(pull) <= d:
        return 2.0
    return 1.0 if pull > 0.0 else -1.0


def slope(a, r, d, way, y, out):
    """Right-hand side into ``out``."""
    n = len(y)
    for i in range(n):
        total = r[i]
        for j in range(n):
            total += a[i, j] * y[j]
        out[i] = total
    if way == 2.0:
        out[1] = 0.0
    else:
        out[1] -= way * d


def euler(a, r, d, y, h, steps, _solved):
    """Semi-implicit (symplectic) Euler, order 1: speeds first, angles by the new speeds; damping explicit."""
    n = len(y)
    k = np.empty(n)
    for _ in range(steps):
        way = way_of(a, r, d, y)
        slope(a, r, d, way, y, k)
        for i in range(n):
            if i != 0 and not (i == 2 and n > 3):
                y[i] += h * k[i]
        if way * y[1] < 0.0:
            y[1] = 0.0
        y[0] += h * y[1]
        if n > 3:
            y[2] += h * y[3]


def rk4(a, r, d, y, h, steps, _solved):
    """The classical Runge-Kutta method, order 4."""
    n = len(y)
    k1, k2, k3, k4, z = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for _ in range(steps):
        way = way_of(a, r, d, y)
        slope(a, r, d, way, y, k1)
        for i in range(n):
            z[i] = y[i] + 0.5 * h * k1[i]
        slope(a, r, d, way, z, k2)
        for i in range(n):
            z[i] = y[i] + 0.5 * h * k2[i]
        slope(a, r, d, way, z, k3)
        for i in range(n):
            z[i] = y[i] + h * k3[i]
        slope(a, r, d, way, z, k4)
        for i in range(n):
            y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        if way * y[1] < 0.0:
            y[1] = 0.0


def midpoint(a, r, d, y, _h, steps, solved):
    """Implicit midpoint, order 2, solved beforehand: y+ = M y + N r; ``solved``: M, N, and those where it sticks."""
    n = len(y)
    z, drive = np.empty(n), np.empty(n)
    for _ in range(steps):
        way = way_of(a, r, d, y)
        first = 2 if way == 2.0 else 0
        for i in range(n):
            drive[i] = r[i]
        drive[1] = 0.0 if way == 2.0 else r[1] - way * d
        for i in range(n):
            z[i] = 0.0
            for j in range(n):
                z[i] += solved[first, i, j] * y[j] + solved[first + 1, i, j] * drive[j]
        for i in range(n):
            y[i] = z[i]
        if way * y[1] < 0.0 or way == 2.0:
            y[1] = 0.0
