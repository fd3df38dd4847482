"""Output error: the second-order model whose exact motion under the torque comes nearest to the measured angle.

The angle's noise is in the angle alone, so nothing is differentiated and no estimate is pulled towards zero, as
those of the equation's least squares are (Section 4.4, implicit regularization). Inertia is fitted as its logarithm;
damping and stiffness as themselves, for an apparatus without a hand has none, and an estimate that may not fall
below zero has no honest interval there.
"""

from functools import partial
from math import exp, log, sqrt

import numpy as np

from hknob_cli.identify.covariance import cautious
from hknob_cli.identify.fit import Fit
from hknob_cli.identify.levenberg import minimise
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.quality import blank, doubts, judged, misfit, unidentified, vaf, whiteness
from hknob_cli.identify.readings import DITHER, Observations, encoder_step, runs, stays
from hknob_cli.identify.second_order import Plant, respond, respond_with_slopes
from hknob_cli.identify.start import integrated_start
from hknob_cli.recordings.trial import Array

NAME = "output_error"
FRICTION_NAME = "output_error_friction"
FIRST_FRICTION = 0.02  # of the highest torque, where friction's own search begins


def output_error(
    motion: Motion,
    *,
    start: Plant | None = None,
    lag_s: float = 0.0,
    coulomb_nm: float = 0.0,
    fit_coulomb: bool = False,
) -> Fit:
    """Inertia, damping, stiffness (and Coulomb friction) by the least squares of measured less modelled angle.

    ``lag_s``: known time constant between command and torque. ``coulomb_nm``: known friction, or where the search for
    it begins if ``fit_coulomb``. The rest angle is fitted too. Standard errors are `cautious`; what an encoder repeats
    counts once (`readings`). What the data cannot tell is flagged, never raised.
    """
    name = FRICTION_NAME if fit_coulomb else NAME
    names = ("inertia", "damping", "stiffness", *(("coulomb",) if fit_coulomb else ()))
    why = blank(motion)
    if why:
        return unidentified(name, names, why)
    first = start or integrated_start(motion)
    if not first.inertia > 0.0:
        return unidentified(name, names, "the torque moves nothing: nothing can be identified")
    width = len(names)

    def plant_at(p: Array) -> Plant:
        return Plant(exp(min(p[0], 50.0)), p[1], p[2], p[3] if fit_coulomb else coulomb_nm)

    def model(p: Array, seen: Observations) -> tuple[Array, Array]:
        angle, slopes = respond_with_slopes(
            plant_at(p), motion.torque_nm, motion.dt_s, lag_s=lag_s, friction=fit_coulomb
        )
        both = np.column_stack([angle + p[width], slopes[:, :width], np.ones(len(angle))])
        means = seen.take(both)
        return means[:, 0], means[:, 1:]

    def answer(p: Array) -> Array:
        return respond(plant_at(p), motion.torque_nm, motion.dt_s, lag_s=lag_s, friction=fit_coulomb)

    begin = [log(first.inertia), first.damping, first.stiffness]
    if fit_coulomb:
        begin.append(coulomb_nm or FIRST_FRICTION * float(np.max(np.abs(motion.torque_nm))))
    lowest = np.full(width + 1, -np.inf)
    lowest[3:width] = 0.0
    seen = runs(motion.angle_rad)
    found = minimise(seen.take(motion.angle_rad), partial(model, seen=seen), np.array([*begin, 0.0]), lowest=lowest)
    step = encoder_step(motion)
    if step > 0.0:
        angle = answer(found.parameters)
        rms = _rms(motion.angle_rad - angle - found.parameters[width])
        if rms * sqrt(motion.averaged) < DITHER * step:
            rest = int(np.flatnonzero(motion.torque_nm)[0])
            seen = stays(angle, step, rms, motion.averaged, rest)
            found = minimise(seen.take(motion.angle_rad), partial(model, seen=seen), found.parameters, lowest=lowest)
    plant = plant_at(found.parameters)
    # Of the logarithm to that of the inertia: the derivative by inertia is that by its logarithm over it.
    by = np.ones(width + 1)
    by[0] = plant.inertia
    covariance = cautious(found.slopes, found.residuals) * np.outer(by, by)
    spread = np.sqrt(np.diagonal(covariance))
    values = [plant.inertia, *found.parameters[1:width]]
    estimates = {one: judged(value, std) for one, value, std in zip(names, values, spread[:width], strict=True)}
    angle = answer(found.parameters)
    left = motion.angle_rad - angle - found.parameters[width]
    share, white = vaf(motion.angle_rad, angle), whiteness(found.residuals)
    rms = _rms(left)
    flags = () if found.converged else ("the search did not converge",)
    return Fit(
        name,
        estimates,
        share,
        white,
        (*flags, *misfit(white, share, rms, motion.noise_rad), *doubts(estimates, motion)),
        rms_rad=rms,
        offset_rad=float(found.parameters[width]),
        covariance=tuple(map(tuple, covariance[:width, :width].tolist())),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values * values)))
