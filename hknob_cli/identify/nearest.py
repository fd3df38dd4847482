"""The motion of a model that comes nearest to a measured one, its rest angle free: what all output-error fits share."""

from collections.abc import Callable, Sequence
from functools import partial
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.identify.covariance import cautious
from hknob_cli.identify.levenberg import ENOUGH, STEPS, Minimum, minimise
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.readings import DITHER, Observations, encoder_step, runs, stays
from hknob_cli.recordings.trial import Array


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
