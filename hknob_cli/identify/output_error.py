"""Output error: the second-order model whose exact motion under the torque comes nearest to the measured angle.

The noise is in the angle alone, so nothing is differentiated, and no estimate is pulled towards zero as those of the
equation's least squares are (Section 4.4, implicit regularization). Inertia is fitted as its logarithm; damping and
stiffness as themselves, for an apparatus without a hand has none, and an estimate that may not fall below zero has no
honest interval there.
"""

from math import exp, log

import numpy as np

from hknob_cli.identify.fit import Fit
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.nearest import nearest
from hknob_cli.identify.quality import blank, doubts, judged, misfit, unidentified, vaf, whiteness
from hknob_cli.identify.second_order import Plant, respond_with_slopes
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
    it begins if ``fit_coulomb``. The rest angle is fitted too. Standard errors are `covariance.cautious`; what an
    encoder repeats counts once (`readings`). What the data cannot tell is flagged, never raised.
    Give it the angle as recorded and averaged, not smoothed: smoothing rounds the motion but not the torque.
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

    def answer(p: Array) -> tuple[Array, Array]:
        plant = Plant(exp(min(max(p[0], -100.0), 50.0)), p[1], p[2], p[3] if fit_coulomb else coulomb_nm)
        angle, slopes = respond_with_slopes(plant, motion.torque_nm, motion.dt_s, lag_s=lag_s, friction=fit_coulomb)
        return angle, slopes[:, :width]

    begin = [log(first.inertia), first.damping, first.stiffness]
    lowest = np.full(width, -np.inf)
    if fit_coulomb:
        begin.append(coulomb_nm or FIRST_FRICTION * float(np.max(np.abs(motion.torque_nm))))
        lowest[3] = 0.0
    found = nearest(motion, answer, np.array(begin), lowest=lowest)
    # The derivative by inertia is that by its logarithm over it.
    values = np.array([exp(min(max(found.parameters[0], -100.0), 50.0)), *found.parameters[1:]])
    by = np.ones(width)
    by[0] = values[0]
    covariance = found.covariance * np.outer(by, by)
    spread = np.sqrt(np.diagonal(covariance))
    estimates = {one: judged(value, std) for one, value, std in zip(names, values, spread, strict=True)}
    share, white = vaf(motion.angle_rad, found.angle_rad), whiteness(found.residuals)
    flags = () if found.converged else ("the search did not converge",)
    return Fit(
        name,
        estimates,
        share,
        white,
        (*flags, *misfit(white, share, found.rms_rad, motion), *doubts(estimates, motion)),
        rms_rad=found.rms_rad,
        offset_rad=found.offset_rad,
        covariance=tuple(map(tuple, covariance.tolist())),
    )
