"""The motion of a model that comes nearest to a measured one, its rest angle free: what all output-error fits share."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.covariance import cautious, classical
from hknob_cli.identify.levenberg import STEPS, Minimum, minimise
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.readings import DITHER, Observations, encoder_step, runs, stays
from hknob_cli.recordings.trial import Array

FEW = 6  # steps of a search with one parameter held, from where the quadratic's valley has the others
FAR = 5.0  # in logarithms, beyond which no quadratic holds


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
    fit: Callable[..., Minimum]

    def misjudged(self, which: int, factor: float) -> bool:
        """Whether a parameter's standard error is too small by more than ``factor``.

        The parameter is held two standard errors up, then down, and the others are fitted anew: the sum of squares
        must rise by as much as a quadratic says, or by its share of 1/factor^2 at least (profile likelihood).
        """
        count = len(self.parameters)
        plain = classical(self.slopes, self.residuals)
        variance = self.covariance[which, which]
        if not (variance > 0.0 and plain[which, which] > 0.0):
            return True
        cost = float(self.residuals @ self.residuals)
        rise = 4.0 * variance / plain[which, which] * cost / max(len(self.residuals) - count - 1, 1)
        for way in (2.0, -2.0):
            begin = np.append(self.parameters, self.offset_rad)
            begin += way * plain[:, which] / plain[which, which] * np.sqrt(variance)
            if np.any(np.abs(begin[:count] - self.parameters) > FAR):
                return True
            left = self.fit(begin, held=which).residuals
            if float(left @ left) - cost < rise / factor**2:
                return True
        return False


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

    def fit(seen: Observations, begin: Array, held: int | None = None) -> Minimum:
        def model(p: Array) -> tuple[Array, Array]:
            angle, slopes = answer(p[:count])
            means = seen.take(np.column_stack([angle + p[count], slopes, np.ones(len(angle))]))
            return means[:, 0], means[:, 1:]

        free = np.full(count + 1, -np.inf), np.full(count + 1, np.inf)
        free[0][:count], free[1][:count] = lowest, highest
        if held is not None:
            free[0][held] = free[1][held] = begin[held]
        steps = STEPS if held is None else FEW
        return minimise(seen.take(motion.angle_rad), model, begin, lowest=free[0], highest=free[1], steps=steps)

    def left_by(p: Array) -> tuple[Array, float]:
        angle = answer(p[:count])[0]
        return angle, float(np.sqrt(np.mean((motion.angle_rad - angle - p[count]) ** 2)))

    seen = runs(motion.angle_rad)
    found = fit(seen, np.append(start, 0.0))
    angle, rms = left_by(found.parameters)
    step = encoder_step(motion)
    if 0.0 < rms * np.sqrt(motion.averaged) < DITHER * step:
        rest = int(np.flatnonzero(motion.torque_nm)[0])
        seen = stays(angle, step, rms, motion.averaged, rest)
        found = fit(seen, found.parameters)
        angle, rms = left_by(found.parameters)
    at, residuals, slopes, converged = found
    covariance = cautious(slopes, residuals)[:count, :count]
    return Nearest(
        at[:count], float(at[count]), covariance, angle, residuals, slopes, rms, converged, partial(fit, seen)
    )
