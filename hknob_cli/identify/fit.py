"""What an estimator says, how sure it is of that, and what is wrong with it.

Standard errors where the model does not fit: the misfit counts as one error, not as one error a sample.

Residuals that noise makes average out over a record, and `cautious` allows for it. What a model leaves out
(friction, a lag, a finger behind its pad) does not: it pulls the parameters as far as it can, and only the part that
no parameter can imitate is left in the residuals. So a fit with a misfit gets, in addition, the covariance of a single
observation whose error is as large as the whole residual: one standard error moves the best motion by as much as the
misfit itself. What in the residuals is white, by the differences of neighbours, is noise and no misfit.
"""

from collections.abc import Mapping, Sequence
from math import isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.motion import Motion
from hknob_cli.recordings.trial import Array

LEVERAGE = 0.9  # the most that one residual's leverage counts for
WINDOW = 5.0  # correlation times that the kernel spans

CHANCE = 1e-6  # p-value of white residuals above which they may be white after all, in one fit of very many


def cautious(slopes: Array, residuals: Array) -> Array:
    """Covariance (p, p) of least squares: the `sandwich`, its variances no less than the `classical` ones.

    The sandwich sees correlated and uneven residuals, but rests on the few that matter where an encoder's count is
    coarse; the classical rests on all, but takes them for white and even. Intervals of ±1.96 of the larger held the
    truth in 94 to 98 % of synthetic pulses, fine and coarse, noisy and not; of the classical alone in as few as 72 %.
    Of a smoothed record of 30 ms, a few dozen correlation times, in 84 to 96 %: fit what was recorded.
    """
    robust, plain = sandwich(slopes, residuals), classical(slopes, residuals)
    with np.errstate(invalid="ignore", divide="ignore"):
        own = np.sqrt(np.diagonal(robust))
        wider = np.sqrt(np.maximum(np.diagonal(robust), np.diagonal(plain))) / np.where(own > 0.0, own, 1.0)
    return robust * np.outer(wider, wider) if np.all(own > 0.0) else plain


def sandwich(slopes: Array, residuals: Array) -> Array:
    """Covariance (p, p) of least squares with derivatives ``slopes`` (r, p) and ``residuals`` (r,).

    Newey and West's (1987), Bartlett kernel of `bandwidth`; each residual over one less its leverage, as in the
    jackknife (HC3). A kernel that spans the share b of the record is itself uncertain: its errors are widened by Kiefer
    and Vogelsang's (2005) 1.96 + 2.9694 b + 0.4160 b^2 - 0.5324 b^3 over 1.96, so that ±1.96 of them is an interval of
    95 %. NaN where the derivatives do not tell the parameters apart.
    """
    count, width = slopes.shape
    bread = bread_of(slopes)
    if count <= width:
        return np.full((width, width), np.nan)
    leverage = np.einsum("ij,ij->i", slopes @ bread, slopes)
    scores = slopes * (residuals / (1.0 - np.minimum(leverage, LEVERAGE)))[:, None]
    lags = min(bandwidth(residuals), count // 4)
    # Bartlett's kernel is the mean square of sums over all windows of that length, those at the ends included.
    total = np.zeros((count + 2 * lags + 2, width))
    np.cumsum(scores, axis=0, out=total[lags + 1 : lags + 1 + count])
    total[lags + 1 + count :] = total[lags + count]
    window = lags + 1
    sums = total[window:] - total[:-window]
    b = lags / count
    wider = 1.0 + (2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    return np.asarray(bread @ (sums.T @ sums / window) @ bread * wider**2)


def classical(slopes: Array, residuals: Array) -> Array:
    """Covariance (p, p) if the residuals were white and of one size: too small where they are not."""
    count, width = slopes.shape
    return np.asarray(bread_of(slopes) * float(residuals @ residuals) / max(count - width, 1))


def bread_of(slopes: Array) -> Array:
    """Inverse (p, p) of slopes' slopes, NaN where there is none."""
    normal = slopes.T @ slopes
    scale = np.sqrt(np.diagonal(normal))
    if not np.all(scale > 0.0) or not np.all(np.isfinite(scale)):
        return np.full_like(normal, np.nan)
    try:
        return np.asarray(np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale))
    except np.linalg.LinAlgError:
        return np.full_like(normal, np.nan)


def condition(slopes: Array) -> float:
    """Condition number of slopes' slopes with columns of one length: how alike the parameters' effects are."""
    lengths = np.sqrt(np.sum(slopes * slopes, axis=0))
    if not np.all(lengths > 0.0) or not np.all(np.isfinite(lengths)):
        return float("inf")
    return float(np.linalg.cond(slopes / lengths)) ** 2


def bandwidth(residuals: Array) -> int:
    """Lags that Bartlett's kernel spans: the first m that is at least `WINDOW` correlation times, summed up to m.

    Source: Madras & Sokal (1988), for Monte Carlo series. Unlike a plug-in from the correlation of neighbours it knows
    smoothed noise, whose neighbours are nearly alike and which is forgotten a few samples later.
    """
    count = len(residuals)
    power = float(residuals @ residuals)
    most = count // 4
    if not power > 0.0 or not np.isfinite(power):
        return 0
    time = 0.5
    for lag in range(1, most + 1):
        if lag > WINDOW * time:
            return lag
        time += float(residuals[lag:] @ residuals[:-lag]) / power
    return most


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


def of_all(covariance: Array, names: Sequence[str], searched: Sequence[str]) -> Array:
    """Covariance (n, n) of all ``names`` in their order, from that (p, p) of those ``searched``; 0 of the others."""
    found = np.zeros((len(names), len(names)))
    there = [i for i, one in enumerate(names) if one in searched]
    of = [searched.index(names[i]) for i in there]
    found[np.ix_(there, there)] = covariance[np.ix_(of, of)]
    return found


def share_of(part: Array, index: int) -> float:
    """Standard error that the misfit alone makes of a parameter; 0 where it is not known."""
    own = float(part[index, index])
    return sqrt(own) if own > 0.0 and np.isfinite(own) else 0.0


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
