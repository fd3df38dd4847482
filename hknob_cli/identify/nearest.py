"""The motion of a model that comes nearest to a measured one, its rest angle free: what all output-error fits share."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.covariance import cautious
from hknob_cli.identify.levenberg import minimise
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.readings import DITHER, Observations, encoder_step, runs, stays
from hknob_cli.recordings.trial import Array


class Nearest(NamedTuple):
    """The nearest motion, and how sure its parameters are.

    ``parameters`` (p,); ``offset_rad``: rest angle; ``covariance`` (p, p) of the parameters; ``angle_rad`` (n,) without
    the offset; ``residuals`` (s,) and ``slopes`` (s, p + 1) of the observations, weighted; ``rms_rad``: of measured
    less modelled.
    """

    parameters: Array
    offset_rad: float
    covariance: Array
    angle_rad: Array
    residuals: Array
    slopes: Array
    rms_rad: float
    converged: bool


def nearest(
    motion: Motion,
    answer: Callable[[Array], tuple[Array, Array]],
    start: Array,
    *,
    lowest: Array | float = -np.inf,
    highest: Array | float = np.inf,
) -> Nearest:
    """Nearest motion of a model whose ``answer(p)`` is an angle (n,) rad and its derivatives (n, p).

    First with every run of equal readings as one observation; then, if the encoder's count shows through the noise,
    with what the count leaves open as weights.
    """
    count = len(start)

    def fit(seen: Observations, begin: Array) -> tuple[Array, Array, Array, bool]:
        def model(p: Array) -> tuple[Array, Array]:
            angle, slopes = answer(p[:count])
            means = seen.take(np.column_stack([angle + p[count], slopes, np.ones(len(angle))]))
            return means[:, 0], means[:, 1:]

        free = np.full(count + 1, -np.inf), np.full(count + 1, np.inf)
        free[0][:count], free[1][:count] = lowest, highest
        return minimise(seen.take(motion.angle_rad), model, begin, lowest=free[0], highest=free[1])

    def left_by(p: Array) -> tuple[Array, float]:
        angle = answer(p[:count])[0]
        return angle, float(np.sqrt(np.mean((motion.angle_rad - angle - p[count]) ** 2)))

    at, residuals, slopes, converged = fit(runs(motion.angle_rad), np.append(start, 0.0))
    angle, rms = left_by(at)
    step = encoder_step(motion)
    if 0.0 < rms * np.sqrt(motion.averaged) < DITHER * step:
        rest = int(np.flatnonzero(motion.torque_nm)[0])
        at, residuals, slopes, converged = fit(stays(angle, step, rms, motion.averaged, rest), at)
        angle, rms = left_by(at)
    covariance = cautious(slopes, residuals)[:count, :count]
    return Nearest(at[:count], float(at[count]), covariance, angle, residuals, slopes, rms, converged)
