"""From fits to a person: the apparatus calibrated and taken off, blocks and persons combined, ratios that follow.

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
from hknob_cli.recordings.trial import Array

CURVED = 0.999  # share of the variance that a straight line must explain
_LEAST = 1e-12  # range of currents or forces that is more than rounding; slope, that is more than none


class Line(NamedTuple):
    """Points that a line was fitted to: ``x`` (n,) and ``y`` (n,) in these units, and the ``fitted`` (n,) values.

    The fitted line of a slope has an intercept; of a mean it is level.
    """

    x: Array
    x_unit: str
    y: Array
    y_unit: str
    fitted: Array


class Calibrated(NamedTuple):
    """One quantity with its standard error; ``r_squared`` of the line it is the slope of, if it is one.

    ``line``: the points it rests on, where it is a slope or a mean of some.
    """

    quantity: str
    condition: str
    value: float
    std: float
    unit: str
    r_squared: float | None = None
    flags: tuple[str, ...] = ()
    line: Line | None = None


def motor(columns: Mapping[str, Array]) -> list[Calibrated]:
    """Torque constant and dynamic friction by range of torque.

    ``columns``: range_index, current_a, direction (+1, -1), torque_nm, all of one length. Clockwise and
    counter-clockwise torques of a current are averaged apart; their mean is the motor's torque, half their difference
    the friction. Source: Appendix A.1.
    """
    found = []
    for index in np.unique(columns["range_index"]):
        mine = columns["range_index"] == index
        currents = np.unique(columns["current_a"][mine])
        name = f"range {index:g}"
        ways = [
            [columns["torque_nm"][mine & (columns["current_a"] == i) & (columns["direction"] == way)] for i in currents]
            for way in (1.0, -1.0)
        ]
        if any(len(one) == 0 for way in ways for one in way):
            why = ("some currents lack one of the two directions",)
            found.append(Calibrated("torque constant", name, float("nan"), float("nan"), "N*m/A", flags=why))
            continue
        clockwise, counter = (np.array([one.mean() for one in way]) for way in ways)
        torque, friction = 0.5 * (clockwise + counter), 0.5 * (clockwise - counter)
        found.append(_slope("torque constant", name, "N*m/A", currents, torque, ("A", "N*m")))
        error = float(friction.std(ddof=1) / np.sqrt(len(friction))) if len(friction) > 1 else float("nan")
        trend = _slope("", "", "", currents, friction, ("A", "N*m"))
        turned = ("friction changes with the current",) if abs(trend.value) > 4.0 * trend.std else ()
        level = Line(currents, "A", friction, "N*m", np.full(len(friction), friction.mean()))
        found.append(Calibrated("dynamic friction", name, float(friction.mean()), error, "N*m", None, turned, level))
    return found


def grip_cell(columns: Mapping[str, Array]) -> list[Calibrated]:
    """Voltage per force at every position, and how it depends on the position, relative to the middle one per metre.

    ``columns``: position_m, force_n, voltage_v. Source: Appendix B.
    """
    positions = np.unique(columns["position_m"])
    found = []
    for position in positions:
        here = columns["position_m"] == position
        name = f"{1e3 * position:.3g} mm from the end"
        force, voltage = columns["force_n"][here], columns["voltage_v"][here]
        found.append(_slope("grip cell slope", name, "V/N", force, voltage, ("N", "V")))
    return [*found, _evenness(found)] if len(positions) > 1 else found


def _evenness(slopes: list[Calibrated]) -> Calibrated:
    """Largest slope over the least, both from zero."""
    if not (all(one.value >= _LEAST for one in slopes) or all(one.value <= -_LEAST for one in slopes)):
        why = ("a position has no slope, or one of another sign",)
        return Calibrated("largest slope over least", "positions", float("nan"), float("nan"), "1", flags=why)
    least, *_, largest = sorted(slopes, key=lambda one: abs(one.value))
    ratio = largest.value / least.value
    spread = ratio * float(np.hypot(largest.std / largest.value, least.std / least.value))
    return Calibrated("largest slope over least", "positions", ratio, spread, "1")


def _slope(quantity: str, condition: str, unit: str, x: Array, y: Array, units: tuple[str, str]) -> Calibrated:
    """Slope of a straight line with its standard error, by least squares; ``units`` of x and y."""
    if len(np.unique(x)) < 3:
        why = ("fewer than three different readings",)
        return Calibrated(quantity, condition, float("nan"), float("nan"), unit, flags=why)
    if np.ptp(x) < _LEAST * max(1.0, float(np.abs(x).max())):
        why = ("readings that hardly differ",)
        return Calibrated(quantity, condition, float("nan"), float("nan"), unit, flags=why)
    lean = x - x.mean()
    value = float(lean @ y / (lean @ lean))
    residual = y - y.mean() - value * lean
    variance = float(residual @ residual) / (len(x) - 2)
    spread = float((y - y.mean()) @ (y - y.mean()))
    share = 1.0 - float(residual @ residual) / spread if spread > 0.0 else None
    flags = ("not a straight line",) if share is not None and share < CURVED else ()
    error = float(np.sqrt(variance / (lean @ lean)))
    line = Line(x, units[0], y, units[1], y.mean() + value * lean)
    return Calibrated(quantity, condition, value, error, unit, share, flags, line)


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
