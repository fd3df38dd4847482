"""Powers of the derivative of a period map: whether differences vanish, and what they can grow to before they do.

Column c of the derivative is at ``cols[c * stride]``. Positions count one, speeds (odd entries of the state)
``1 / scale``.

An ellipse bounds differences that decay however slowly. Of a map M whose powers vanish, P = sum of (M^k)' M^k over all
k has M' P M = P - 1 (Lyapunov's equation): the norm w' P w falls from turn to turn, and no later difference leaves the
ellipse that the first one is on. The sum doubles its length with each step.
"""

from math import inf, sqrt

from hknob_cli.engine.certificate import EPSILON

POWERS = 4096  # of the derivative, until a difference is gone
GONE = 1e-3
TAIL = 1.01  # of the sum of 1, `GONE`, its square, ...
DOUBLINGS = 60
ROUNDINGS = 64.0  # of a product of m terms, m times as many


def invert(a, cols, m, stride):
    """Inverse of identity minus the matrix of columns, by Gauss-Jordan with pivoting; False if singular.

    Column c of the derivative is at ``cols[c * stride]``; the inverse is left in the right half of ``a`` (m, 2 m).
    """
    width = 2 * m
    for i in range(m):
        for j in range(m):
            one = 1.0 if i == j else 0.0
            a[i * width + j] = one - cols[j * stride + i]
            a[i * width + m + j] = one
    for k in range(m):
        best = k
        for i in range(k + 1, m):
            if abs(a[i * width + k]) > abs(a[best * width + k]):
                best = i
        pivot = a[best * width + k]
        if abs(pivot) < 1e-14:
            return False
        for j in range(width):
            kept = a[k * width + j]
            a[k * width + j] = a[best * width + j] / pivot
            if best != k:
                a[best * width + j] = kept
        for i in range(m):
            factor = a[i * width + k]
            if i != k and factor != 0.0:
                for j in range(width):
                    a[i * width + j] -= factor * a[k * width + j]
    return True


def unit(i, scale):
    """Unit of entry ``i`` of a difference: 1 of a position, ``scale`` of a speed (odd entries)."""
    return scale if i % 2 == 1 else 1.0


def scaled(cols, stride, i, j, scale):
    """Entry of the derivative where speeds count ``1 / scale``."""
    return cols[j * stride + i] * unit(j, scale) / unit(i, scale)


def square(power, spare, m):
    """Replace a matrix (m, m) by its square; overwrites ``spare``."""
    for i in range(m):
        for j in range(m):
            entry = 0.0
            for k in range(m):
                entry += power[i * m + k] * power[k * m + j]
            spare[i * m + j] = entry
    for i in range(m * m):
        power[i] = spare[i]


def largest_row(power, m, scale):
    """Largest sum of absolute entries of a row, where speeds count ``1 / scale``; infinite beyond 1e100, or if none."""
    worst = 0.0
    for i in range(m):
        row = 0.0
        for j in range(m):
            row += abs(power[i * m + j]) * unit(j, scale)
        row /= unit(i, scale)
        worst = max(worst, row) if row < 1e100 else inf
    return worst


def dissipates(cols, width, power, spare, m, scale, samples):
    """Whether a power of the derivative shrinks every difference to less than half; ``scale``: unit of speed.

    The derivative is that of a map over ``samples`` samples, each of which rounds it. A power so high that the
    roundings alone could shrink it proves nothing.
    """
    for i in range(m):
        for j in range(m):
            power[i * m + j] = scaled(cols, width, i, j, scale)
    rounding = ROUNDINGS * EPSILON * m * samples
    while rounding < 0.25:
        worst = largest_row(power, m, 1.0)
        if worst < 0.5:
            return True
        if worst == inf:
            return False
        square(power, spare, m)
        rounding *= 2.0
    return False


def growth_bound(cols, width, power, spare, total, m, scale):
    """Sum of the absolute powers of the derivative, in ``total`` (m, m): what a difference can ever grow to."""
    for i in range(m):
        for j in range(m):
            power[i * m + j] = 1.0 if i == j else 0.0
            total[i * m + j] = 0.0
    for _ in range(POWERS):
        for i in range(m * m):
            total[i] += abs(power[i])
        if largest_row(power, m, scale) < GONE:
            return True
        for i in range(m):
            for j in range(m):
                entry = 0.0
                for k in range(m):
                    entry += power[i * m + k] * cols[j * width + k]
                spare[i * m + j] = entry
        for i in range(m * m):
            power[i] = spare[i]
    return False


def lyapunov_sum(cols, stride, p, power, spare, m, scale):
    """Sum of (M^k)' M^k over all k in ``p`` (m, m); False where it does not converge."""
    for i in range(m):
        for j in range(m):
            power[i * m + j] = scaled(cols, stride, i, j, scale)
            p[i * m + j] = 1.0 if i == j else 0.0
    for _ in range(DOUBLINGS):
        largest = 0.0
        for i in range(m * m):
            largest = max(largest, abs(power[i]))
        if largest < GONE / m:
            return True
        if not largest < 1e100:
            return False
        # P + A' P A, then A A: the sum over twice as many.
        for i in range(m):
            for j in range(m):
                entry = 0.0
                for k in range(m):
                    entry += p[i * m + k] * power[k * m + j]
                spare[i * m + j] = entry
        for i in range(m):
            for j in range(m):
                for k in range(m):
                    p[i * m + j] += power[k * m + i] * spare[k * m + j]
        square(power, spare, m)
    return False


def falls(cols, stride, p, power, spare, m, scale, samples):
    """Whether the norm w' P w of every difference falls from turn to turn, roundings included.

    P - M' P M has a diagonal above the sum of what else is in its row (Gershgorin). ``spare`` takes P M. ``samples``:
    of the map, each of which rounds the derivative.
    """
    small = ROUNDINGS * EPSILON * m * samples
    for i in range(m):
        for j in range(m):
            entry, size = 0.0, 0.0
            for k in range(m):
                part = p[i * m + k] * scaled(cols, stride, k, j, scale)
                entry += part
                size += abs(part)
            spare[i * m + j], power[i * m + j] = entry, size
    for i in range(m):
        left = 0.0
        for j in range(m):
            entry, size = p[i * m + j], abs(p[i * m + j])
            for k in range(m):
                factor = scaled(cols, stride, k, i, scale)
                entry -= factor * spare[k * m + j]
                size += abs(factor) * power[k * m + j]
            left += (entry if i == j else -abs(entry)) - small * size
        if not left > 0.0:
            return False
    return True


def ellipse_bound(space, m, scale, samples):
    """Bound by an ellipse what ``space.residual``, a difference known to within ``space.away``, can ever grow to.

    True, and the bound in ``away``, its former self in ``power``, where the ellipse is proven to be kept. Overwrites
    ``spare`` and ``total`` (m, m), which has the ellipse's matrix P, and ``matrix`` (m, 2 m).
    """
    cols, stride, power, spare = space.cols, space.width, space.power, space.spare
    p, a, residual, away = space.total, space.matrix, space.residual, space.away
    if not lyapunov_sum(cols, stride, p, power, spare, m, scale):
        return False
    if not falls(cols, stride, p, power, spare, m, scale, samples):
        return False
    size, rounding, error = 0.0, 0.0, 0.0
    for i in range(m):
        one = unit(i, scale)
        for j in range(m):
            other = unit(j, scale)
            entry = p[i * m + j]
            part = residual[i] / one * entry * residual[j] / other
            size += part
            rounding += abs(part)
            error += away[i] / one * abs(entry) * away[j] / other
            spare[j * m + i] = (1.0 if i == j else 0.0) - entry
    if not invert(a, spare, m, m):
        return False
    small = ROUNDINGS * EPSILON * m
    root = sqrt(max(size, 0.0) + small * rounding) + sqrt(error)
    for i in range(m):
        # The largest entry of the ellipse w' P w = 1, from P's inverse X, whose error by a rounding of P is X |P| X.
        entry = a[i * 2 * m + m + i]
        for k in range(m):
            for j in range(m):
                entry += small * abs(a[i * 2 * m + m + k] * p[k * m + j] * a[j * 2 * m + m + i])
        power[i] = away[i]
        away[i] += unit(i, scale) * root * sqrt(entry)
    return True


def bound_growth(space, m, scale, samples):
    """Bound what ``space.residual``, a difference known to within ``space.away``, can ever grow to, from turn to turn.

    True, and the bound in ``away``, its former self in ``power``, where there is one. Overwrites ``residual``,
    ``spare`` and ``total`` (m, m) and ``matrix`` (m, 2 m).
    """
    cols, stride, power, spare, total = space.cols, space.width, space.power, space.spare, space.total
    residual, away = space.residual, space.away
    if not growth_bound(cols, stride, power, spare, total, m, scale):
        return ellipse_bound(space, m, scale, samples)
    largest = 0.0
    for i in range(m):
        power[i] = away[i]
        residual[i] = abs(residual[i]) + away[i]
        largest = max(largest, residual[i] / unit(i, scale))
    for i in range(m):
        # What is left of the difference when the powers end counts, too.
        residual[i] = max(residual[i], GONE * largest * unit(i, scale))
    for i in range(m):
        entry = power[i]
        for j in range(m):
            entry += total[i * m + j] * residual[j]
        away[i] = entry
    return True
