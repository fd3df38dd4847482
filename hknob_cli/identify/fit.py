"""What an estimator says, how far it can be trusted, and what is wrong with it."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.covariance import share_of
from hknob_cli.identify.motion import Motion
from hknob_cli.recordings.trial import Array

PARAMETERS = ("inertia", "damping", "stiffness", "coulomb")

LAGS = 20
ODDS = 0.01  # p-value below which residuals are called not white
MISFIT = "the model does not fit"
EXCESS = 1.5  # residuals this many times the known noise are more than noise
ROUNDING = 1e-14  # share of variance below which what is left is the arithmetic's own
OVERDAMPED, UNDAMPED = 1.5, 0.05  # damping ratios beyond which a pulse tells two of the parameters badly


class Estimate(NamedTuple):
    """A value and its standard error, in SI units; ``identifiable`` False where the data cannot tell it.

    ``misfit``: the part of the standard error that a misfit of the model makes, which repeats do not average out.
    """

    value: float
    std: float
    identifiable: bool = True
    misfit: float = 0.0


class Fit(NamedTuple):
    """A fit of one motion.

    ``parameters`` by name (inertia kg·m², damping N·m·s/rad, stiffness N·m/rad, coulomb N·m; of a fourth-order model
    finger_inertia, finger_damping, finger_stiffness, pad_damping, pad_stiffness beside inertia of the knob); ``vaf``:
    share of the variance of the angle accounted for, 1 at best; ``white``: p-value of the residuals being white;
    ``flags``: what is wrong with it, in words, empty where nothing is. ``torque_vaf``: the same share of the torque,
    of an estimator that fits torque. ``rms_rad``: root mean square of measured less modelled angle. ``offset_rad``:
    the fitted rest angle, of an estimator that fits one. ``covariance`` of the parameters in their order, if known;
    ``misfit``: the part of it that a misfit makes, None where the model fits (`misfit.widen`).
    """

    estimator: str
    parameters: dict[str, Estimate]
    vaf: float
    white: float | None = None
    flags: tuple[str, ...] = ()
    torque_vaf: float | None = None
    rms_rad: float | None = None
    offset_rad: float = 0.0
    covariance: tuple[tuple[float, ...], ...] | None = None
    misfit: tuple[tuple[float, ...], ...] | None = None


def vaf(measured: Array, modelled: Array) -> float:
    """Variance accounted for: 1 - var(measured - modelled) / var(measured); NaN if nothing varies."""
    power = float(np.var(measured))
    if power == 0.0 or not np.all(np.isfinite(modelled)):
        return nan
    return 1.0 - float(np.var(measured - modelled)) / power


def whiteness(residuals: Array, fitted: int = 0, lags: int = LAGS) -> float | None:
    """P-value of residuals (r,) being white, ``fitted`` parameters having been taken from them; None if too few.

    Source: Ljung & Box (1978): r (r + 2) sum rho_k^2 / (r - k) against chi-square of ``lags`` - ``fitted`` degrees.
    """
    from scipy.special import chdtrc

    count = len(residuals)
    centred = residuals - np.mean(residuals)
    power = float(centred @ centred)
    lags = min(lags, count // 4)
    if lags <= fitted or power <= 0.0 or not isfinite(power):
        return None
    rho = np.array([float(centred[k:] @ centred[:-k]) / power for k in range(1, lags + 1)])
    statistic = count * (count + 2) * float(np.sum(rho * rho / (count - np.arange(1, lags + 1))))
    return float(chdtrc(lags - fitted, statistic))


def judged(value: float, std: float, misfit: float = 0.0) -> Estimate:
    """An estimate, not identifiable where its standard error is not below its size."""
    return Estimate(float(value), float(std), bool(isfinite(std) and std < abs(value)), float(misfit))


def estimated(
    names: Sequence[str], values: Mapping[str, float], known: Mapping[str, float], covariance: Array, part: Array
) -> dict[str, Estimate]:
    """Estimates of ``names``: values with their covariance (n, n), and the misfit's ``part`` of it; or as ``known``."""
    with np.errstate(invalid="ignore"):
        spread = np.sqrt(np.diagonal(covariance))
    return {
        one: Estimate(known[one], 0.0) if one in known else judged(values[one], spread[i], share_of(part, i))
        for i, one in enumerate(names)
    }


def blank(motion: Motion) -> str | None:
    """Why a motion tells nothing at all, if so: no torque, no motion, too short, or not finite."""
    if len(motion.torque_nm) < 8:
        return f"only {len(motion.torque_nm)} samples: nothing can be identified"
    if not np.all(np.isfinite(motion.torque_nm)) or not np.all(np.isfinite(motion.angle_rad)):
        return "torque or angle is not finite: nothing can be identified"
    if not np.any(motion.torque_nm):
        return "no torque: nothing can be identified"
    if np.ptp(motion.angle_rad) == 0.0:
        return "the angle does not change: nothing can be identified"
    return None


def unidentified(estimator: str, names: Sequence[str], why: str) -> Fit:
    """A fit that tells nothing."""
    return Fit(estimator, {name: Estimate(nan, nan, False) for name in names}, nan, None, (why,))


def misfit(white: float | None, share: float, rms: float, motion: Motion) -> tuple[str, ...]:
    """That the model does not fit, in words: residuals not white and larger than what is known to make them.

    That is the motion's noise, and what averaging leaves of trials that differ (`Motion.blend_rad`).
    """
    noise = motion.noise_rad
    known = max(EXCESS * (noise or 0.0), motion.blend_rad)
    if white is None or white >= ODDS or 1.0 - share < ROUNDING or rms <= known:
        return ()
    size = f", {rms / noise:.1f} times the noise" if noise and isfinite(rms) else ""
    explained = (
        f"VAF {100.0 * share:.2f} %" if isfinite(share) else "no VAF, because the fitted model has no bounded motion"
    )
    return (f"{MISFIT}: residuals are not white (p = {white:.1g}){size}, {explained}",)


def doubts(estimates: Mapping[str, Estimate], motion: Motion) -> tuple[str, ...]:
    """What a second-order fit's own numbers warn of, in words."""
    found = []
    window = (len(motion.angle_rad) - motion.onset) * motion.dt_s
    where = f"{1e3 * window:.3g} ms from the pulse on" if motion.pulsed else f"{window:.3g} s"
    for name, one in estimates.items():
        if one.std == 0.0 and one.identifiable:  # it is known
            continue
        if not isfinite(one.std):
            found.append(f"{name} is not identifiable: the data do not tell it from the others")
        elif not one.identifiable:
            zero = "" if name == "inertia" else " from zero"
            found.append(f"{name} is not identifiable: not told{zero} in {where} ({one.value:.2g} ± {one.std:.2g})")
        elif one.value < 0.0:
            found.append(f"{name} came out negative: {one.value:.2g}")
    inertia, damping, stiffness = (estimates[name].value for name in ("inertia", "damping", "stiffness"))
    if motion.pulsed and inertia > 0.0 and stiffness > 0.0 and damping > 0.0:
        ratio = damping / (2.0 * sqrt(inertia) * sqrt(stiffness))  # a product of both may be too small for a number
        slow = damping / stiffness
        if ratio > OVERDAMPED:
            found.append(f"overdamped (damping ratio {ratio:.2g}): inertia shows only in the first milliseconds")
            if window < slow:
                found.append(f"the window of {1e3 * window:.3g} ms ends before the slow return ({1e3 * slow:.3g} ms)")
        elif ratio < UNDAMPED:
            found.append(f"hardly damped (damping ratio {ratio:.2g})")
    return tuple(found)
