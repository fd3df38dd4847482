"""Output error: the second-order model whose exact motion under the torque comes nearest to the measured angle.

The noise is in the angle alone, so nothing is differentiated, and no estimate is pulled towards zero as those of the
equation's least squares are (Section 4.4, implicit regularization). Inertia is fitted as its logarithm; damping and
stiffness as themselves, for an apparatus without a hand has none, and an estimate that may not fall below zero has no
honest interval there.
"""

from collections.abc import Mapping, Sequence
from math import exp, log
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.identify.fit import (
    PARAMETERS,
    Fit,
    blank,
    doubts,
    estimated,
    misfit,
    of_all,
    unidentified,
    vaf,
    whiteness,
    widen,
)
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.nearest import Minimum, cost, nearest
from hknob_cli.identify.second_order import Begin, Plant, Start, integrated_start, respond_with_slopes, running_starts
from hknob_cli.recordings.trial import Array

NAME = "output_error"
FRICTION_NAME = "output_error_friction"
FIRST_FRICTION = 0.02  # of the highest torque, where friction's own search begins
BACKWARDS = "the angle accelerates against the torque: nothing can be identified; is a sign wrong?"
STATE = ("start_angle", "start_velocity")
ALL = ("inertia", "damping", "stiffness", "coulomb", *STATE)  # as `respond_with_slopes` has them
NONE: Mapping[str, float] = {}


def output_error(
    motion: Motion,
    *,
    start: Plant | None = None,
    lag_s: float = 0.0,
    coulomb_nm: float = 0.0,
    fit_coulomb: bool = False,
    fixed: Mapping[str, float] = NONE,
) -> Fit:
    """Inertia, damping, stiffness (and Coulomb friction) by the least squares of measured less modelled angle.

    ``lag_s``: known time constant between command and torque. ``coulomb_nm``: known friction, or where the search for
    it begins if ``fit_coulomb``. ``fixed``: parameters that are known, by name. The rest angle is fitted too, and the
    first angle and velocity where the motion does not begin at rest. Standard errors are `fit.cautious`, and
    allow for a misfit (`fit.widen`); what an encoder repeats counts once (`motion.stays`). What the data cannot tell is
    flagged, never raised.
    """
    name = FRICTION_NAME if fit_coulomb else NAME
    names = PARAMETERS if fit_coulomb else PARAMETERS[:3]
    if why := blank(motion):
        return unidentified(name, names, why)
    known = {**fixed, **({} if fit_coulomb else {"coulomb": coulomb_nm})}
    searched = [one for one in names if one not in known]
    if motion.free_start:
        # Without a spring the first angle is the rest angle.
        searched += STATE[1:] if known.get("stiffness") == 0.0 else STATE
    if not searched:
        return unidentified(name, names, "every parameter is fixed: nothing is left to identify")
    friction = coulomb_nm or (FIRST_FRICTION * float(np.max(np.abs(motion.torque_nm))) if fit_coulomb else 0.0)
    model = _Model(motion, known, searched, 0.0 if motion.measured else lag_s)
    begins = _begins(motion, start, known, friction, model.lag_s)
    if not begins:
        pushed = "the torque moves nothing: nothing can be identified"
        return unidentified(name, names, pushed if motion.pulsed else BACKWARDS)

    def from_all(fit: Any, _begin: Array) -> Sequence[Minimum]:
        ends = [fit(np.append(_vector(one, searched), one.rest_rad), steps=25, enough=1e-6) for one in begins]
        return sorted(ends, key=cost)[:1]

    first = _vector(begins[0], searched)
    lowest = np.array([0.0 if one == "coulomb" else -np.inf for one in searched])
    found = nearest(motion, model.answer, first, lowest=lowest, elsewhere=from_all if len(begins) > 1 else None)
    values = model.parts(found.parameters)
    # The derivative by inertia is that by its logarithm over it.
    by = np.array([values["inertia"] if one == "inertia" else 1.0 for one in searched])
    share, white = vaf(motion.angle_rad, found.angle_rad), whiteness(found.residuals)
    flags = misfit(white, share, found.rms_rad, motion)
    covariance = found.covariance * np.outer(by, by)
    part = np.zeros_like(covariance)
    if flags:
        total, part, more = widen(found.covariance, found.slopes, found.residuals, white)
        covariance, part, flags = total * np.outer(by, by), part * np.outer(by, by), (*flags, *more)
    if motion.torque_noise_nm:
        slopes = model.answer(found.parameters)[1]
        covariance = covariance + np.outer(by, by) * by_torque(motion, _plant(values), slopes)
    covariance, part = (of_all(one, names, searched) for one in (covariance, part))
    estimates = estimated(names, values, known, covariance, part)
    lost = () if found.converged else ("the search did not converge",)
    return Fit(
        name,
        estimates,
        share,
        white,
        (*lost, *flags, *doubts(estimates, motion)),
        rms_rad=found.rms_rad,
        offset_rad=found.offset_rad,
        covariance=tuple(map(tuple, covariance.tolist())),
        misfit=tuple(map(tuple, part.tolist())) if np.any(part) else None,
    )


class _Model(NamedTuple):
    """The model of a motion: which of its parameters are known, by name, and which are searched, in their order."""

    motion: Motion
    known: Mapping[str, float]
    searched: Sequence[str]
    lag_s: float

    def parts(self, p: Array) -> dict[str, float]:
        """Every parameter by name; ``p`` (p,) are those searched, an inertia as its logarithm."""
        here: dict[str, float] = {**self.known, **dict(zip(self.searched, map(float, p), strict=True))}
        if "inertia" in self.searched:
            here["inertia"] = exp(min(max(here["inertia"], -100.0), 50.0))
        return here

    def answer(self, p: Array) -> tuple[Array, Array]:
        """Angle (n,) with the parameters ``p`` (p,), and its derivatives (n, p) by them."""
        here, motion = self.parts(p), self.motion
        how: dict[str, Any] = {"lag_s": self.lag_s, "ramps": motion.ramps, "friction": "coulomb" in self.searched}
        if motion.free_start:
            how["start"] = Start(*(here.get(one, 0.0) for one in STATE))
        angle, slopes = respond_with_slopes(_plant(here), motion.torque_nm, motion.dt_s, **how)
        return angle, slopes[:, [ALL.index(one) for one in self.searched]]


def _plant(values: Mapping[str, float]) -> Plant:
    return Plant(*(values[one] for one in ALL[:4]))


def by_torque(motion: Motion, plant: Plant, slopes: Array) -> Array:
    """Covariance (p, p) that the noise of a torque sensor makes of parameters with derivatives ``slopes`` (n, p).

    The knob moves by the torque, and the model by what the sensor says of it. The difference, a noise w of its own in
    each sample, moves the modelled angle by H w, and the parameters by -S⁺ H w, S with a column for the rest angle.
    Friction is left out of H: it makes less of a torque.
    """
    pushed = np.zeros(len(motion.torque_nm))
    pushed[0] = 1.0
    kick, _ = respond_with_slopes(plant._replace(coulomb=0.0), pushed, motion.dt_s, ramps=motion.ramps)
    back = np.linalg.pinv(np.column_stack([slopes, np.ones(len(slopes))]))[:-1]
    # Row k of S⁺ H is the correlation of row k of S⁺ with the answer to a kick.
    moved = np.array([np.correlate(row, kick, "full")[len(kick) - 1 :] for row in back])
    return np.asarray(moved @ moved.T * (motion.torque_noise_nm or 0.0) ** 2)


def _begins(
    motion: Motion, start: Plant | None, known: Mapping[str, float], friction: float, lag_s: float
) -> list[Begin]:
    """Where searches begin, the most promising first; none where the torque does not explain any motion."""
    if not motion.pulsed or (motion.free_start and start is None):
        return running_starts(motion, known, coulomb_nm=friction, lag_s=lag_s)
    first = start or integrated_start(motion)
    plant = first._replace(**{one: known[one] for one in ALL[:3] if one in known}, coulomb=friction)
    return [Begin(plant, Start(), 0.0)] if plant.inertia > 0.0 else []


def _vector(begin: Begin, searched: Sequence[str]) -> Array:
    plant, start = begin.plant, begin.start
    every = [log(plant.inertia), plant.damping, plant.stiffness, plant.coulomb, *start]
    return np.array([every[ALL.index(one)] for one in searched])
