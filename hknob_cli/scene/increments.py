"""The linear motion of a body over spans of time: integrals of its exponential, power series, and its slowest decay.

D(t) is the integral of exp(A s) over [0, t]: a state z under z' = A z + c moves by D (A z + c). An increment keeps its
digits where a span is short.
"""

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import HALVINGS
from hknob_cli.engine.propagator import hold_coefficients

Array = NDArray[np.float64]


def power_series(alpha: float, beta: float) -> Array:
    """Power series of S(t) / t and of G(t) / t^2, t up to 1, half of the result each; empty where they are long.

    The impulse response s of x'' + alpha x' + beta x has the derivatives s_(k+1) = -alpha s_k - beta s_(k-1) at 0.
    """
    if alpha > 1.0 or beta > 1.0:
        return np.zeros(0)
    speed, pull = [], []
    before, now, factorial = 0.0, 1.0, 1.0
    for k in range(40):
        factorial *= k + 1
        speed.append(now / factorial)
        pull.append(now / factorial / (k + 2))
        before, now = now, -alpha * now - beta * before
        if k > 1 and abs(now) + abs(before) <= 1e-19 * factorial:
            break
    return np.array(speed + pull)


def slowest_decay(a: Array) -> float:
    """Decay rate of the slowest mode that decays."""
    rates = -np.linalg.eigvals(a).real
    decaying = rates[rates > 1e-13 * np.abs(a).max()]
    return float(decaying.min()) if decaying.size else 0.0


def _short_increment(a: Array, t: float) -> Array:
    """D(t) by its series; for a short time."""
    total = term = t * np.eye(len(a))
    for k in range(2, 30):
        term = term @ a * (t / k)
        total = total + term
        if np.abs(term).max() <= 1e-20 * np.abs(total).max():
            break
    return total


def increment(a: Array, t: float, alpha: float, beta: float) -> Array:
    """D(t), the integral of exp(A s) over [0, t]: closed form of second order, else by doubling a short one."""
    if len(a) == 2:
        s, g, _ = hold_coefficients(alpha, beta, t)
        return np.array([[s + alpha * g, g], [-beta * g, s]])
    size = float(np.abs(a).sum(axis=1).max()) * t
    doublings = max(0, int(np.ceil(np.log2(size))) + 2) if size > 0.25 else 0
    d = _short_increment(a, t / 2.0**doublings)
    for _ in range(doublings):
        d = d + d @ (np.eye(len(a)) + a @ d)
    return d


def increments(a: Array, held: Array, split: float, alpha: float, beta: float, *, stepped: bool = False) -> list[Array]:
    """D over both parts of an interval, and D(1), D(1/2), D(1/4), ..., sliding and held.

    Of second order without the latter, unless it is ``stepped``, and not by closed forms.
    """
    if len(a) == 2 and not stepped:
        return [increment(a, split, alpha, beta).ravel(), increment(a, 1.0 - split, alpha, beta).ravel()]
    both = [halves(a), halves(held)]
    whole = both[0][0] if split == 0.0 else increment(a, 1.0 - split, alpha, beta)
    first = np.zeros_like(a) if split == 0.0 else increment(a, split, alpha, beta)
    return [first.ravel(), whole.ravel(), *(part.ravel() for part in both)]


def halves(a: Array) -> Array:
    """D(1), D(1/2), D(1/4), ..., shape (HALVINGS, n, n): the short ones by their series, the rest by doubling.

    Not finite, in silence, where an unstable slope of cogging is too steep: whoever uses them looks at that.
    """
    one = np.eye(len(a))
    times = 0.5 ** np.arange(HALVINGS)
    size = float(np.abs(a).sum(axis=1).max())
    first = min(HALVINGS - 1, max(0, int(np.ceil(np.log2(size))) + 2) if size > 0.25 else 0)
    found = np.zeros((HALVINGS, *a.shape))
    total = term = times[first:, None, None] * one
    for k in range(2, 30):
        term = term @ a * (times[first:, None, None] / k)
        total = total + term
        if np.abs(term[0]).max() <= 1e-20 * np.abs(total[0]).max():
            break
    found[first:] = total
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(first - 1, -1, -1):
            found[k] = found[k + 1] + found[k + 1] @ (one + a @ found[k + 1])
    return found
