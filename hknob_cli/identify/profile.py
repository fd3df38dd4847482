"""How far a quantity may be from where the fit is best: its profile likelihood, and other places that fit as well.

Standard errors from the curvature at the best fit say nothing of a valley that bends or flattens, nor of a second
one. Here the quantity is held ever farther away, everything else fitted anew, until the sum of squares has risen by
more than chance explains in 19 cases of 20 (Venzon & Moolgavkar 1988; Raue et al. 2009, who call a parameter whose
profile never rises that far not identifiable).
"""

from collections.abc import Callable
from math import exp, isfinite, log, log1p, sqrt

import numpy as np

from hknob_cli.identify.covariance import bread_of
from hknob_cli.identify.nearest import Nearest, Pin, cost
from hknob_cli.recordings.trial import Array

RISE = 1.96**2  # of chi-square with one degree of freedom, exceeded in 5 %
STEPS, ENOUGH = 15, 3e-5  # of a search with the quantity held; a share of the sum of squares
HELD = 1e4  # weight of what is held, in its own standard errors
TRIES = 6
FARTHEST = log(3.0)  # a quantity known to no better than this, either way, is not called known
FLAT = 0.25  # of the rise that is asked for: below it the profile is flat, and a closer look does not pay
NEARLY = 0.97  # of the rise that is asked for


def spread(found: Nearest, logarithm: Callable[[Array], tuple[float, Array]]) -> float:
    """Standard error, as a share of the value, whose ±1.96 hold all that fits as well as chance allows.

    ``logarithm(p)``: the quantity's natural logarithm, and its derivatives (p,). At least that of ``found.covariance``;
    inf where the fit is as good with three times the value or a third of it, or elsewhere that far away.
    """
    count = len(found.parameters)
    here, by = logarithm(found.parameters)
    plain = bread_of(found.slopes)
    own, cautious = float(by @ plain[:count, :count] @ by), float(by @ found.covariance @ by)
    if not (own > 0.0 and isfinite(cautious) and cautious < 1.0):
        return float("inf") if not cautious >= 0.0 else sqrt(cautious)
    noise = cost(found) / max(len(found.residuals) - count - 1, 1)
    allowed = RISE * max(cautious / own, noise)
    std = sqrt(cautious)
    for way in (1.0, -1.0):
        std = _side(found, logarithm, here, by, plain, way, allowed, std)
        if std >= 1.0:
            return float("inf")
    for other in found.others:
        rise = cost(other) - cost(found)
        if rise >= allowed:
            continue
        there, slope = logarithm(other.parameters[:count])
        if abs(there - here) > FARTHEST:
            return float("inf")
        far = abs(exp(there - here) - 1.0)
        if far > 1.96 * std:
            width = float(slope @ bread_of(other.slopes)[:count, :count] @ slope) * (allowed - rise)
            std = (far + exp(there - here) * sqrt(width)) / 1.96 if width >= 0.0 else float("inf")
            if std >= 1.0:
                return float("inf")
    return std


def _side(
    found: Nearest,
    logarithm: Callable[[Array], tuple[float, Array]],
    here: float,
    by: Array,
    plain: Array,
    way: float,
    allowed: float,
    std: float,
) -> float:
    """``std``, or more if the profile to one side asks for it; inf where it stays low as far as `FARTHEST`."""
    count = len(found.parameters)
    own = float(by @ plain[:count, :count] @ by)
    weight = HELD / sqrt(own)
    base = np.append(found.parameters, found.offset_rad)
    along = plain[:, :count] @ by / own
    begin, left = base, 0.0
    for _ in range(TRIES):
        far = min(log1p(1.96 * std) if way > 0.0 else -log1p(-min(1.96 * std, 0.9)), FARTHEST)
        begin = begin + way * (far - left) * along
        left = far
        pin = Pin(logarithm, here + way * far, weight)
        held = found.fit(begin, pin=pin, steps=STEPS, enough=ENOUGH, until=cost(found) + FLAT * allowed)
        begin = held.parameters
        rise = cost(held) - cost(found)
        if isfinite(rise) and rise >= NEARLY * allowed:
            return std
        if far >= FARTHEST or not isfinite(rise):
            return float("inf")
        std *= 1.02 * sqrt(allowed / max(rise, FLAT * allowed))
    return float("inf")
