"""Nonlinear least squares by Levenberg and Marquardt, for few parameters with derivatives at hand."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

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
