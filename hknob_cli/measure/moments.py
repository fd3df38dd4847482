"""Integrals of the motion over one period: mean, mean square, and the square of the velocity.

Over a hold they are quadratic forms of (x, v, drive), exact for any stiffness: the form over a short piece is taken by
Gauss-Legendre quadrature, exact to rounding there, and doubled, W(2h) = W(h) + Phi(h)^T W(h) Phi(h), adding positive
terms only (Van Loan 1978 gives the same integrals by one exponential, which a stiff plant overflows).
"""

from math import ceil, log2, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.measure.period import Array, Period

# Gauss-Legendre, 10 nodes: the positive ones and their weights (Abramowitz & Stegun, table 25.4).
_HALF = (0.14887433898163122, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845, 0.9739065285171717)
_HALF_WEIGHTS = (0.2955242247147528, 0.2692667193099965, 0.219086362515982, 0.1494513491505804, 0.06667134430868814)
RULE = [(sign * node, weight) for node, weight in zip(_HALF, _HALF_WEIGHTS, strict=True) for sign in (-1.0, 1.0)]


class Forms(NamedTuple):
    """Integrals over one hold of z = (x, v, drive): ``mean`` (3,) of x; ``square`` and ``speed`` (3, 3) of x², v²."""

    mean: Array
    square: Array
    speed: Array


class Moments(NamedTuple):
    """Over one period: ``mean`` position and ``rms`` about it in counts; ``speed`` = integral of v² dt."""

    mean: float
    rms: float
    speed: float


def transition(alpha: float, beta: float, t: float) -> Array:
    """Transition matrix of (x, v, drive) over a time ``t``, shape (3, 3)."""
    s, g, f = hold_coefficients(alpha, beta, t)
    return np.array([[1.0 - beta * g, s, g], [-beta * s, f, s], [0.0, 0.0, 1.0]])


def hold_forms(alpha: float, beta: float, duration: float) -> Forms:
    """Forms over a hold of length ``duration``."""
    pace = max(alpha, sqrt(beta)) * duration
    doublings = max(0, ceil(log2(pace)) + 1) if pace > 0.0 else 0
    h = duration / 2.0**doublings
    mean, square, speed = np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3))
    for node, weight in RULE:
        phi = transition(alpha, beta, 0.5 * h * (node + 1.0))
        mean += 0.5 * h * weight * phi[0]
        square += 0.5 * h * weight * np.outer(phi[0], phi[0])
        speed += 0.5 * h * weight * np.outer(phi[1], phi[1])
    for _ in range(doublings):
        phi = transition(alpha, beta, h)
        mean = mean + mean @ phi
        square = square + phi.T @ square @ phi
        speed = speed + phi.T @ speed @ phi
        h *= 2.0
    return Forms(mean=mean, square=square, speed=speed)


def find_moments(period: Period, forms: dict[float, Forms], reference: float) -> Moments:
    """Moments of one period; ``forms`` by hold length, ``reference`` (counts) any position near the motion."""
    loop = period.loop
    z = np.stack([period.x[:-1] - reference, period.v[:-1], period.drive - loop.beta * reference])
    total = square = speed = 0.0
    for kind, form in forms.items():
        part = z[:, period.duration == kind] if len(forms) > 1 else z
        total += float((form.mean @ part).sum())
        square += float((part * (form.square @ part)).sum())
        speed += float((part * (form.speed @ part)).sum())
    mean = total / period.samples
    return Moments(mean=reference + mean, rms=sqrt(max(square / period.samples - mean * mean, 0.0)), speed=speed)
