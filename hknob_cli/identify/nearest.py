"""The motion of a model that comes nearest to a measured one: how it is found, and how far it is told.

It is found by Levenberg and Marquardt's method, for few parameters with derivatives at hand.

Standard errors from the curvature at the best fit say nothing of a valley that bends or flattens, nor of a second
one. Here the quantity is held ever farther away, everything else fitted anew, until the sum of squares has risen by
more than chance explains in 19 cases of 20 (Venzon & Moolgavkar 1988; Raue et al. 2009, who call a parameter whose
profile never rises that far not identifiable).
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import exp, isfinite, log, log1p, sqrt
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.identify.fit import bread_of, cautious
from hknob_cli.identify.motion import DITHER, Motion, Observations, encoder_step, runs, stays
from hknob_cli.recordings.trial import Array

STEPS = 60
ENOUGH = 1e-14  # share of the sum of squares that a step may still gain
ROUNDING = 1e-29  # share of the data's sum of squares that arithmetic leaves


class Minimum(NamedTuple):
    """Parameters (p,), residuals (r,) data less model, derivatives (r, p) of the model, and whether it converged."""

    parameters: Array
    residuals: Array
    slopes: Array
    converged: bool


@np.errstate(over="ignore", invalid="ignore")  # a step too far overflows, and is not taken
def minimise(
    data: Array,
    model: Callable[[Array], tuple[Array, Array]],
    start: Array,
    *,
    lowest: Array | float = -np.inf,
    highest: Array | float = np.inf,
    steps: int = STEPS,
    enough: float = ENOUGH,
    until: float = 0.0,
) -> Minimum:
    """The least sum of squares of ``data`` (r,) less ``model(p)``, which gives values (r,) and derivatives (r, p).

    ``lowest``, ``highest``: bounds, (p,) or one for all; ``enough``: share of the sum of squares that a step may still
    gain at the end; ``until``: a sum of squares that is low enough to end the search. Source: Moré, *The
    Levenberg-Marquardt algorithm* (1978), with the derivatives' lengths as scale, and bounds by projection.
    """
    at = np.clip(np.asarray(start, dtype=float), lowest, highest)
    values, slopes = model(at)
    residuals = data - values
    cost = float(residuals @ residuals)
    rounding = ROUNDING * float(data @ data)
    ease, converged = 1e-3, False
    for _ in range(steps):
        pull = slopes.T @ residuals
        lengths = np.sqrt(np.sum(slopes * slopes, axis=0))
        free = ((at > lowest) | (pull > 0.0)) & ((at < highest) | (pull < 0.0)) & (lengths > 0.0)
        scale = lengths[free]
        if not scale.size or not np.all(np.isfinite(scale)):
            break
        base, triangle = np.linalg.qr(slopes[:, free] / scale)
        aim = np.append(base.T @ residuals, np.zeros(len(scale)))
        better = False
        while ease < 1e12:
            step = np.zeros_like(at)
            damped = np.vstack([triangle, np.sqrt(ease) * np.eye(len(scale))])
            step[free] = np.linalg.lstsq(damped, aim, rcond=None)[0] / scale
            tried = np.clip(at + step, lowest, highest)
            values, ahead = model(tried)
            left = data - values
            less = float(left @ left)
            if less < cost:
                better = True
                break
            if float(step @ pull) <= enough * cost:
                break
            ease = max(10.0 * ease, 1e-12)
        gain = float(step @ pull)
        if better:
            at, residuals, slopes, cost, ease = tried, left, ahead, less, 0.01 * ease
        if not better or gain <= enough * cost or cost <= max(rounding, until):
            converged = True
            break
    return Minimum(at, residuals, slopes, converged)


class Pin(NamedTuple):
    """A function of the parameters, value and derivatives (p,), held at ``target`` as by one heavy observation."""

    function: Callable[[Array], tuple[float, Array]]
    target: float
    weight: float


class Nearest(NamedTuple):
    """The nearest motion, and how sure its parameters are.

    ``parameters`` (p,); ``offset_rad``: rest angle; ``covariance`` (p, p) of the parameters; ``angle_rad`` (n,) without
    the offset; ``residuals`` (s,) and ``slopes`` (s, p + 1) of the observations, weighted; ``rms_rad``: of measured
    less modelled; ``others``: where searches from elsewhere ended; ``fit(begin)``: a search of the same observations,
    the rest angle last in ``begin``; with a `Pin` if given.
    """

    parameters: Array
    offset_rad: float
    covariance: Array
    angle_rad: Array
    residuals: Array
    slopes: Array
    rms_rad: float
    converged: bool
    others: tuple[Minimum, ...]
    fit: Callable[..., Minimum]


def nearest(
    motion: Motion,
    answer: Callable[[Array], tuple[Array, Array]],
    start: Array,
    *,
    lowest: Array | float = -np.inf,
    highest: Array | float = np.inf,
    elsewhere: Callable[[Callable[..., Minimum], Array], Sequence[Minimum]] | None = None,
) -> Nearest:
    """Nearest motion of a model whose ``answer(p)`` is an angle (n,) rad and its derivatives (n, p).

    First with every run of equal readings as one observation; then, if the encoder's count shows through the noise,
    with what the count leaves open as weights. ``elsewhere``: for a model that may be nearest in several places, where
    searches from several starts end, by the `Nearest.fit` and the start that it is given; the best of them counts.
    """
    count = len(start)
    free = np.full(count + 1, -np.inf), np.full(count + 1, np.inf)
    free[0][:count], free[1][:count] = lowest, highest

    def fit(
        seen: Observations,
        begin: Array,
        *,
        pin: Pin | None = None,
        steps: int = STEPS,
        enough: float = ENOUGH,
        until: float = 0.0,
    ) -> Minimum:
        data = seen.take(motion.angle_rad)

        def model(p: Array) -> tuple[Array, Array]:
            angle, slopes = answer(p[:count])
            means = seen.take(np.column_stack([angle + p[count], slopes, np.ones(len(angle))]))
            if pin is None:
                return means[:, 0], means[:, 1:]
            value, by = pin.function(p[:count])
            held = pin.weight * np.concatenate([[value], by, [0.0]])
            return np.append(means[:, 0], held[0]), np.vstack([means[:, 1:], held[1:]])

        if pin is not None:
            data = np.append(data, pin.weight * pin.target)
        ends: dict[str, Any] = {"lowest": free[0], "highest": free[1], "steps": steps, "enough": enough, "until": until}
        found = minimise(data, model, begin, **ends)
        return found if pin is None else found._replace(residuals=found.residuals[:-1], slopes=found.slopes[:-1])

    def search(seen: Observations, begin: Array) -> tuple[Minimum, tuple[Minimum, ...]]:
        if elsewhere is None:
            return fit(seen, begin), ()
        others = tuple(elsewhere(partial(fit, seen), begin))
        return fit(seen, min(others, key=cost).parameters), others

    def left_by(p: Array) -> tuple[Array, float]:
        angle = answer(p[:count])[0]
        return angle, float(np.sqrt(np.mean((motion.angle_rad - angle - p[count]) ** 2)))

    seen = runs(motion.angle_rad)
    found, others = search(seen, np.append(start, 0.0))
    angle, rms = left_by(found.parameters)
    step = encoder_step(motion)
    if 0.0 < rms * np.sqrt(motion.averaged) < DITHER * step:
        seen = stays(angle, step, rms, motion.averaged, motion.onset)
        found, others = search(seen, found.parameters)
        angle, rms = left_by(found.parameters)
    at, residuals, slopes, converged = found
    covariance = cautious(slopes, residuals)[:count, :count]
    again = partial(fit, seen)
    return Nearest(at[:count], float(at[count]), covariance, angle, residuals, slopes, rms, converged, others, again)


def cost(found: Minimum | Nearest) -> float:
    """Sum of squares, inf where the motion overflowed."""
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(found.residuals @ found.residuals)
    return total if isfinite(total) else float("inf")


RISE = 1.96**2  # of chi-square with one degree of freedom, exceeded in 5 %
STEPS_HELD, ENOUGH_HELD = 15, 3e-5  # of a search with the quantity held; a share of the sum of squares
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
        held = found.fit(begin, pin=pin, steps=STEPS_HELD, enough=ENOUGH_HELD, until=cost(found) + FLAT * allowed)
        begin = held.parameters
        rise = cost(held) - cost(found)
        if isfinite(rise) and rise >= NEARLY * allowed:
            return std
        if far >= FARTHEST or not isfinite(rise):
            return float("inf")
        std *= 1.02 * sqrt(allowed / max(rise, FLAT * allowed))
    return float("inf")
