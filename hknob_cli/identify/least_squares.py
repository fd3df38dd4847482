"""The dissertation's estimator: J a + B v + K x = T by linear least squares on differentiated angle.

Section 4.2.3. It minimises the torque's error as if acceleration, velocity and angle were exact. They are not: noise in
a column pulls its coefficient towards zero, most of all the inertia's (Section 4.4, implicit regularization), and the
residuals are correlated, so that the usual standard errors are too small. Those here allow for the correlation
(`covariance.cautious`), which is cheap; nothing allows for the bias.
"""

from math import nan

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.identify.covariance import cautious
from hknob_cli.identify.fit import Estimate, Fit
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.quality import blank, doubts, judged, misfit, unidentified, vaf, whiteness
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.recordings.trial import Array

NAME, FRICTION_NAME = "least_squares", "least_squares_friction"
FOLLOWS = "coulomb is not identifiable: the direction of motion follows the torque, and damping is biased with it"
ALIKE = 10.0  # variance inflation of a column by another above which they cannot be told apart (Kutner et al. 2005)
MOVING = 3.0, 0.01  # a velocity's direction is known above so many times its noise, and this share of its peak


def least_squares(motion: Motion) -> Fit:
    """Inertia, damping and stiffness by J a + B v + K x = T. Raises `UsageError` without velocity and acceleration."""
    return _solve(motion, NAME, friction=False)


def least_squares_friction(motion: Motion) -> Fit:
    """As `least_squares`, with a column sign(v) for Coulomb friction, on the samples whose velocity is above noise.

    A hand that turns back as the pulse ends has a sign(v) that follows the torque, step for step. The smoothed
    acceleration has no such steps, so the column takes the torque's up, and a friction comes out that is not there, of
    some mN·m at firm grips, at the expense of damping. Friction is then said not to be identifiable (`inflation`).
    """
    return _solve(motion, FRICTION_NAME, friction=True)


def _solve(motion: Motion, name: str, *, friction: bool) -> Fit:
    if motion.velocity_rad_s is None or motion.acceleration_rad_s2 is None:
        raise UsageError(f"{name}: the motion has no velocity and acceleration; differentiate it first")
    names = ("inertia", "damping", "stiffness", *(("coulomb",) if friction else ()))
    why = blank(motion)
    if why:
        return unidentified(name, names, why)
    acceleration, velocity = motion.acceleration_rad_s2, motion.velocity_rad_s
    columns = [acceleration, velocity, motion.angle_rad]
    rows = np.isfinite(acceleration) & np.isfinite(velocity)
    if friction:
        columns.append(np.sign(velocity))
        rows &= np.abs(velocity) > still(motion, velocity)
    table = np.stack(columns, axis=1)[rows]
    torque = motion.torque_nm[rows]
    lengths = np.sqrt(np.sum(table * table, axis=0))
    if len(torque) <= len(names) or not np.all(lengths > 0.0):
        return unidentified(name, names, "too few samples move: nothing can be identified")
    solved, _, rank, _ = np.linalg.lstsq(table / lengths, torque, rcond=None)
    values = solved / lengths
    left = torque - table @ values
    covariance = cautious(table, left) if rank == len(names) else np.full((len(names), len(names)), nan)
    spread = np.sqrt(np.diagonal(covariance))
    estimates = {one: judged(value, std) for one, value, std in zip(names, values, spread, strict=True)}
    share, rms = _angle_share(motion, estimates)
    flags = doubts(estimates, motion)
    if friction and inflation(table[:, 3], torque) > ALIKE:
        estimates["coulomb"] = estimates["coulomb"]._replace(identifiable=False)
        flags = (FOLLOWS, *flags)
    white = whiteness(left)
    return Fit(
        name,
        estimates,
        share,
        white,
        (*misfit(white, share, rms, motion), *flags),
        torque_vaf=vaf(torque, table @ values),
        rms_rad=rms,
        covariance=tuple(map(tuple, covariance.tolist())),
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
    before = velocity[: int(np.flatnonzero(motion.torque_nm)[0])]
    before = before[np.isfinite(before)]
    scatter = float(np.std(before)) if len(before) > 1 else 0.0
    return max(MOVING[0] * scatter, MOVING[1] * float(np.nanmax(np.abs(velocity))))


def _angle_share(motion: Motion, estimates: dict[str, Estimate]) -> tuple[float, float]:
    """Variance of the angle that the exact motion with these parameters accounts for, and what is left of it, rms."""
    inertia, damping, stiffness = (estimates[one].value for one in ("inertia", "damping", "stiffness"))
    if not inertia > 0.0:
        return nan, nan
    friction = max(estimates["coulomb"].value, 0.0) if "coulomb" in estimates else 0.0
    angle = respond(Plant(inertia, damping, stiffness, friction), motion.torque_nm, motion.dt_s)
    return vaf(motion.angle_rad, angle), float(np.std(motion.angle_rad - angle))
