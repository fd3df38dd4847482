"""Standard errors where the model does not fit: the misfit counts as one error, not as one error a sample.

Residuals that noise makes average out over a record, and `covariance.cautious` allows for it. What a model leaves out
(friction, a lag, a finger behind its pad) does not: it pulls the parameters as far as it can, and only the part that
no parameter can imitate is left in the residuals. So a fit with a misfit gets, in addition, the covariance of a single
observation whose error is as large as the whole residual: one standard error moves the best motion by as much as the
misfit itself. What in the residuals is white, by the differences of neighbours, is noise and no misfit.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.covariance import bread_of
from hknob_cli.recordings.trial import Array

CHANCE = 1e-6  # p-value of white residuals above which they may be white after all, in one fit of very many


class Widened(NamedTuple):
    """Covariance (p, p) with the misfit's added, the misfit's ``part`` (p, p), and what to say of it."""

    covariance: Array
    part: Array
    flags: tuple[str, ...]


def widen(covariance: Array, slopes: Array, residuals: Array, white: float | None) -> Widened:
    """Add the misfit's part to a covariance (p, p) of the first p parameters.

    ``slopes`` (r, q), q >= p: derivatives of the model, those of other fitted parameters (a rest angle) last;
    ``residuals`` (r,); ``white``: p-value of their being white.
    """
    width = len(covariance)
    steps = np.diff(residuals)
    power = float(residuals @ residuals) - 0.5 * float(steps @ steps)
    if white is None or white > CHANCE or not power > 0.0:
        return Widened(covariance, np.zeros_like(covariance), ())
    part = bread_of(slopes)[:width, :width] * power
    total = covariance + part
    with np.errstate(invalid="ignore", divide="ignore"):
        factors = np.sqrt(np.diagonal(total) / np.diagonal(covariance))
    factors = factors[np.isfinite(factors)]
    if not factors.size:
        return Widened(total, part, ())
    low, high = float(factors.min()), float(factors.max())
    times = f"{high:.2g}" if high < 1.1 * low else f"{low:.2g} to {high:.2g}"
    return Widened(total, part, (f"standard errors are {times} times wider: they allow for the misfit",))


def share_of(part: Array, index: int) -> float:
    """Standard error that the misfit alone makes of a parameter; 0 where it is not known."""
    own = float(part[index, index])
    return sqrt(own) if own > 0.0 and np.isfinite(own) else 0.0
