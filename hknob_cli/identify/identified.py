"""From fits to a person: blocks and persons combined, the apparatus taken off, and the ratios that follow.

From fits of blocks to a person's numbers, and from persons to a table: the spread between them is the error.

A fit's own standard error says how well one motion tells its model. The hand itself differs from trial to trial, which
no single fit can know; only repeated blocks show it.
"""

from collections.abc import Iterable, Mapping
from math import hypot, isfinite, nan, sqrt
from statistics import fmean, stdev
from typing import NamedTuple

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.identify.fit import Estimate, Fit, judged

SQUARED_ARM = ("inertia", "damping", "stiffness")


class Spread(NamedTuple):
    """Mean, standard deviation (n - 1; NaN of one), coefficient of variation std/mean, and how many."""

    mean: float
    std: float
    cv: float
    number: int


def over_blocks(estimates: Iterable[Estimate]) -> Estimate:
    """One person's value of one condition: the mean over blocks, its standard error from the spread between them.

    Blocks that are not finite are left out. Of a single block the fit's own standard error, which leaves out the hand's
    variation; of none, NaN. What a misfit of the model makes of the fits' errors is common to the blocks: its mean is
    added. An interval is the mean ± Student's t of (blocks - 1) degrees times this: 4.3 for three.
    """
    kept = [one for one in estimates if isfinite(one.value)]
    if not kept:
        return Estimate(nan, nan, False)
    if len(kept) == 1 or all(one.std == 0.0 for one in kept):  # a single one, or one that is known
        return kept[0]
    values = [one.value for one in kept]
    misfit = fmean(one.misfit for one in kept)
    return judged(fmean(values), hypot(stdev(values) / sqrt(len(values)), misfit), misfit)


def over_subjects(values: Iterable[float]) -> Spread:
    """Mean, standard deviation (n - 1) and coefficient of variation over persons, as Tables 1 to 5; of finite ones."""
    kept = [value for value in values if isfinite(value)]
    if not kept:
        return Spread(nan, nan, nan, 0)
    mean = fmean(kept)
    std = stdev(kept) if len(kept) > 1 else nan
    return Spread(mean, std, std / mean if mean else nan, len(kept))


def damping_ratio(fit: Fit) -> Estimate:
    """Damping ratio B / (2 sqrt(J K)) with its standard error by the delta method; NaN where J, K or J K is not > 0.

    With the fit's covariance where it has one, else as if the errors were independent. Source: Section 4.3.
    """
    one = [fit.parameters[name] for name in SQUARED_ARM]
    inertia, damping, stiffness = (estimate.value for estimate in one)
    if not (inertia > 0.0 and stiffness > 0.0 and inertia * stiffness > 0.0):  # which may underflow
        return Estimate(nan, nan, False)
    ratio = damping / (2.0 * sqrt(inertia * stiffness))
    slope = np.array([-0.5 * ratio / inertia, 1.0 / (2.0 * sqrt(inertia * stiffness)), -0.5 * ratio / stiffness])
    names = list(fit.parameters)
    chosen = [names.index(name) for name in SQUARED_ARM]
    if fit.covariance is not None:
        covariance = np.array(fit.covariance)[np.ix_(chosen, chosen)]
    else:
        covariance = np.diag([estimate.std * estimate.std for estimate in one])
    with np.errstate(invalid="ignore", over="ignore"):
        std = float(np.sqrt(slope @ covariance @ slope))
        part = np.zeros_like(covariance) if fit.misfit is None else np.array(fit.misfit)[np.ix_(chosen, chosen)]
        misfit = float(np.sqrt(np.maximum(slope @ part @ slope, 0.0)))
    told = judged(ratio, std, misfit if isfinite(misfit) else 0.0)
    return told._replace(identifiable=told.identifiable and all(estimate.identifiable for estimate in one))


def without_apparatus(
    estimate: Estimate, apparatus: float | Estimate, *, what: str = "inertia"
) -> tuple[Estimate, tuple[str, ...]]:
    """A parameter of the hand alone: less the apparatus's (Appendix C), the variances added; and a flag if negative.

    An ``apparatus`` without a standard error counts as exact.
    """
    own = apparatus if isinstance(apparatus, Estimate) else Estimate(apparatus, 0.0)
    hand = judged(estimate.value - own.value, sqrt(estimate.std * estimate.std + own.std * own.std), estimate.misfit)
    hand = hand._replace(identifiable=hand.identifiable and estimate.identifiable)
    if hand.value < 0.0:
        return hand, (f"{what} is below the apparatus's own: {estimate.value:.3g} less {own.value:.3g}",)
    return hand, ()


def at_the_skin(parameters: Mapping[str, Estimate], radius_m: float) -> dict[str, Estimate]:
    """Translational model at a knob's circumference: kg, N s/m, N/m; friction, if any, in N.

    Inertia, damping and stiffness over radius squared, Coulomb torque over radius: m x'' + b x' + k x = f with x = r
    theta and f = T / r, of all fingers on the knob together. Source: Section 2.2 (Hajian 1997), Section 5.3, Figure 21.
    Raises `UsageError` unless the radius is positive.
    """
    if not radius_m > 0.0:
        raise UsageError(f"radius must be > 0, got {radius_m:g}")
    found = {}
    for name, one in parameters.items():
        arm = radius_m if name == "coulomb" else radius_m * radius_m
        found[name] = Estimate(one.value / arm, one.std / arm, one.identifiable, one.misfit / arm)
    return found
