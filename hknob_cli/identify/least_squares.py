"""The dissertation's estimator: J a + B v + K x = T by linear least squares on differentiated angle.

Section 4.2.3. It minimises the torque's error as if acceleration, velocity and angle were exact. They are not: noise in
a column pulls its coefficient towards zero, most of all the inertia's (Section 4.4, implicit regularization), and the
residuals are correlated, so that the usual standard errors are too small. Those here allow for the correlation
(`fit.cautious`), which is cheap; nothing allows for the bias.
"""

from collections.abc import Mapping
from math import nan
from typing import NamedTuple

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.identify.fit import (
    PARAMETERS,
    Fit,
    blank,
    cautious,
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
from hknob_cli.identify.second_order import Plant, best_motion, respond_with_slopes
from hknob_cli.recordings.trial import Array

NAME, FRICTION_NAME, ACCELERATION_NAME = "least_squares", "least_squares_friction", "least_squares_acceleration"
FOLLOWS = "coulomb is not identifiable: the direction of motion follows the torque, and damping is biased with it"
ALIKE = 10.0  # variance inflation of a column by another above which they cannot be told apart (Kutner et al. 2005)
REST = "rest"  # torque that the spring has where the angle is zero
NONE: Mapping[str, float] = {}
MOVING = 3.0, 0.01  # a velocity's direction is known above so many times its noise, and this share of its peak


def least_squares(motion: Motion, *, fixed: Mapping[str, float] = NONE) -> Fit:
    """Inertia, damping and stiffness by J a + B v + K x = T, ``fixed`` ones taken off the torque.

    Raises `UsageError` without velocity and acceleration.
    """
    return _solve(motion, NAME, fixed, friction=False)


def least_squares_friction(motion: Motion, *, fixed: Mapping[str, float] = NONE) -> Fit:
    """As `least_squares`, with a column sign(v) for Coulomb friction, on the samples whose velocity is above noise.

    A hand that turns back as the pulse ends has a sign(v) that follows the torque, step for step. The smoothed
    acceleration has no such steps, so the column takes the torque's up, and a friction comes out that is not there, of
    some mN·m at firm grips, at the expense of damping. Friction is then said not to be identifiable (`inflation`).
    """
    return _solve(motion, FRICTION_NAME, fixed, friction=True)


def least_squares_acceleration(motion: Motion, *, fixed: Mapping[str, float] = NONE) -> Fit:
    """As `least_squares`, with the acceleration of an accelerometer in place of the angle's second derivative.

    Chapter 3 calls that beneficial. Nothing smooths it, so that the edges of a pulse stay where they are; its noise
    pulls the inertia towards zero, by the noise's power over the acceleration's. A commanded torque is that before the
    sample, as the acceleration is.
    """
    if motion.felt_rad_s2 is None:
        return unidentified(ACCELERATION_NAME, PARAMETERS[:3], "no accelerometer: nothing can be identified")
    torque = motion.torque_nm
    if not motion.measured and not motion.ramps:
        torque = np.append(torque[:1], torque[:-1])
    return _solve(motion, ACCELERATION_NAME, fixed, friction=False, felt=(motion.felt_rad_s2, torque))


def _solve(
    motion: Motion,
    name: str,
    fixed: Mapping[str, float],
    *,
    friction: bool,
    felt: tuple[Array, Array] | None = None,
) -> Fit:
    """``felt``: a measured acceleration (n,), and the torque (n,) that goes with it."""
    if motion.velocity_rad_s is None or motion.acceleration_rad_s2 is None:
        raise UsageError(f"{name}: the motion has no velocity and acceleration; differentiate it first")
    names = PARAMETERS if friction else PARAMETERS[:3]
    if why := blank(motion):
        return unidentified(name, names, why)
    velocity = motion.velocity_rad_s
    acceleration, acts = felt or (motion.acceleration_rad_s2, motion.torque_nm)
    columns = {"inertia": acceleration, "damping": velocity, "stiffness": motion.angle_rad}
    rows = np.isfinite(acceleration) & np.isfinite(velocity)
    if friction:
        columns["coulomb"] = np.sign(velocity)
        rows &= np.abs(velocity) > still(motion, velocity)
    torque = acts - sum(value * columns[one] for one, value in fixed.items())
    searched = [one for one in names if one not in fixed]
    if not motion.pulsed and "stiffness" in searched:
        columns[REST] = np.ones_like(velocity)  # the spring's rest is not where the recording begins
        searched.append(REST)
    if not searched:
        return unidentified(name, names, "every parameter is fixed: nothing is left to identify")
    table = np.stack([columns[one] for one in searched], axis=1)[rows]
    torque = torque[rows]
    lengths = np.sqrt(np.sum(table * table, axis=0))
    if len(torque) <= len(searched) or not np.all(lengths > 0.0):
        return unidentified(name, names, "too few samples move: nothing can be identified")
    solved, _, rank, _ = np.linalg.lstsq(table / lengths, torque, rcond=None)
    values = solved / lengths
    left = torque - table @ values
    width = len(searched)
    covariance = cautious(table, left) if rank == width else np.full((width, width), nan)
    found = dict(fixed) | dict(zip(searched, map(float, values), strict=True))
    moved = _moved(motion, found)
    white = whiteness(left)
    flags = misfit(white, moved.vaf, moved.rms_rad, motion)
    total, part = (of_all(one, names, searched) for one in (covariance, np.zeros_like(covariance)))
    if flags and moved.slopes is not None:
        own = [i for i, one in enumerate(names) if one not in fixed]
        more = widen(total[np.ix_(own, own)], moved.slopes[:, [*own, -1]], moved.left, white)
        total[np.ix_(own, own)], part[np.ix_(own, own)] = more.covariance, more.part
        flags = (*flags, *more.flags)
    estimates = estimated(names, found, fixed, total, part)
    doubtful = doubts(estimates, motion)
    if friction and inflation(table[:, searched.index("coulomb")], torque) > ALIKE:
        estimates["coulomb"] = estimates["coulomb"]._replace(identifiable=False)
        doubtful = (FOLLOWS, *doubtful)
    return Fit(
        name,
        estimates,
        moved.vaf,
        white,
        (*flags, *doubtful),
        torque_vaf=vaf(torque, table @ values),
        rms_rad=moved.rms_rad,
        covariance=tuple(map(tuple, total.tolist())),
        misfit=tuple(map(tuple, part.tolist())) if np.any(part) else None,
    )


def inflation(column: Array, other: Array) -> float:
    """Variance inflation of a coefficient by another column, 1 / (1 - r²) of their correlation; 1 of a constant one."""
    spread = float(np.std(column) * np.std(other))
    if not spread > 0.0:
        return 1.0
    both = float(np.mean((column - column.mean()) * (other - other.mean()))) / spread
    return 1.0 / max(1.0 - both * both, np.finfo(float).eps)


def still(motion: Motion, velocity: Array) -> float:
    """Velocity rad/s up to which its direction is not known: from its scatter before the torque, and its peak."""
    before = velocity[: motion.onset]
    before = before[np.isfinite(before)]
    scatter = float(np.std(before)) if len(before) > 1 else 0.0
    return max(MOVING[0] * scatter, MOVING[1] * float(np.nanmax(np.abs(velocity))))


class _Moved(NamedTuple):
    """The exact motion with the parameters found: what it accounts for, what is left, and its derivatives (n, p + 1).

    Derivatives by the parameters in their order, and by the rest angle; None where there is no such motion.
    """

    vaf: float
    rms_rad: float
    left: Array
    slopes: Array | None


def _moved(motion: Motion, found: Mapping[str, float]) -> _Moved:
    inertia = found["inertia"]
    if not inertia > 0.0:
        return _Moved(nan, nan, np.empty(0), None)
    friction = max(found.get("coulomb", 0.0), 0.0)
    plant = Plant(inertia, found["damping"], found["stiffness"], friction)
    if motion.pulsed and not motion.free_start:
        angle, slopes = respond_with_slopes(plant, motion.torque_nm, motion.dt_s, ramps=motion.ramps)
    else:
        angle, slopes = best_motion(motion, plant)
    slopes = np.column_stack([slopes[:, 0] / inertia, slopes[:, 1:4], np.ones(len(angle))])
    left = motion.angle_rad - angle
    with np.errstate(over="ignore", invalid="ignore"):
        left = left - np.mean(left)
        rms = float(np.sqrt(np.mean(left * left)))
        return _Moved(vaf(motion.angle_rad, angle), rms, left, slopes if np.all(np.isfinite(slopes)) else None)
