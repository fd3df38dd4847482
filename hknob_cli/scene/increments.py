"""The linear motion of a body over spans of time: integrals of its exponential, power series, and its slowest decay.

D(t) is the integral of exp(A s) over [0, t]: a state z under z' = A z + c moves by D (A z + c). An increment keeps its
digits where a span is short. Of stiff bodies each doubling of a span loses some: they are made with the longest floats
of the machine (19 digits on x86) and rounded once, so that proofs may take them for exact to a rounding.
"""

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import HALVINGS
from hknob_cli.engine.propagator import hold_coefficients

Array = NDArray[np.float64]
NEGLIGIBLE = 1e-24  # of a sum's terms, beside the sum


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


def _rounded(fine: NDArray[np.longdouble]) -> Array:
    """What was computed with the longest floats; not finite, in silence, where it is too large."""
    with np.errstate(over="ignore", invalid="ignore"):
        return fine.astype(np.float64)


def _series(a: NDArray[np.longdouble], times: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
    """D(t) of short times by its series, shape (times, n, n); the longest time is the first."""
    times = times[:, None, None]
    total = term = times * np.eye(len(a), dtype=np.longdouble)
    for k in range(2, 40):
        term = term @ a * (times / k)
        total = total + term
        if np.abs(term[0]).max() <= NEGLIGIBLE * np.abs(total[0]).max():
            break
    return total


def _doublings(size: float) -> int:
    """How often a span is halved before its series is taken, by its length in units of the fastest mode."""
    return max(0, int(np.ceil(np.log2(size))) + 2) if size > 0.25 else 0


def increment(a: Array, t: float, alpha: float, beta: float) -> Array:
    """D(t), the integral of exp(A s) over [0, t]: closed form of second order, else by doubling a short one."""
    if len(a) == 2:
        s, g, _ = hold_coefficients(alpha, beta, t)
        return np.array([[s + alpha * g, g], [-beta * g, s]])
    doublings = _doublings(float(np.abs(a).sum(axis=1).max()) * t)
    fine = a.astype(np.longdouble)
    d = _series(fine, np.array([t / 2.0**doublings], np.longdouble))[0]
    for _ in range(doublings):
        d = d + d @ (np.eye(len(a)) + fine @ d)
    return _rounded(d)


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
    fine, one = a.astype(np.longdouble), np.eye(len(a))
    times = 0.5 ** np.arange(HALVINGS, dtype=np.longdouble)
    first = min(HALVINGS - 1, _doublings(float(np.abs(a).sum(axis=1).max())))
    found = np.zeros((HALVINGS, *a.shape), np.longdouble)
    found[first:] = _series(fine, times[first:])
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(first - 1, -1, -1):
            found[k] = found[k + 1] + found[k + 1] @ (one + fine @ found[k + 1])
    return _rounded(found)
