"""Integrals of the motion over one period: mean, mean square, and the square of the velocity."""

from hknob_cli.engine.orbit.holds import MEAN, PART, SPEED, SQUARE


def form_of(parts, at, a, b, c):
    """Value of the symmetric form that begins at ``at``, for z = (a, b, c)."""
    return (
        a * (parts[at] * a + 2.0 * (parts[at + 1] * b + parts[at + 2] * c))
        + b * (parts[at + 3] * b + 2.0 * parts[at + 4] * c)
        + parts[at + 5] * c * c
    )


def find_moments(x, v, drive, count, parts, kinds, beta, reference):
    """Integrals over ``count`` holds of x less ``reference`` (a position near the motion), of its square, and of v²."""
    total, square, speed = 0.0, 0.0, 0.0
    level = beta * reference
    base, other = 0, (kinds - 1) * PART
    for i in range(count):
        a, b, c = x[i] - reference, v[i], drive[i] - level
        total += parts[base + MEAN] * a + parts[base + MEAN + 1] * b + parts[base + MEAN + 2] * c
        square += form_of(parts, base + SQUARE, a, b, c)
        speed += form_of(parts, base + SPEED, a, b, c)
        base = other - base
    return total, square, speed
