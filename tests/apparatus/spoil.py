"""Bad recordings to order: each function takes a trial and returns it with one thing wrong."""

from math import degrees, nan
from typing import Any

import numpy as np

from hknob_cli.recordings.trial import Trial


def drop_samples(trial: Trial, *, first: int = 100, count: int = 20) -> Trial:
    """``count`` rows from ``first`` on are missing: a gap in time."""
    keep = np.ones(len(trial.time_s), dtype=bool)
    keep[first : first + count] = False
    measured = None if trial.measured_torque_nm is None else trial.measured_torque_nm[keep]
    return trial._replace(
        time_s=trial.time_s[keep],
        torque_nm=trial.torque_nm[keep],
        angle_rad=trial.angle_rad[keep],
        grip_n=trial.grip_n[keep],
        measured_torque_nm=measured,
    )


def freeze_angle(trial: Trial, *, first: int = 100, count: int = 20) -> Trial:
    """The encoder's value does not change for ``count`` samples: they repeat that of sample ``first``."""
    angle = trial.angle_rad.copy()
    angle[first : first + count] = angle[first]
    return trial._replace(angle_rad=angle)


def saturate_angle(trial: Trial, *, share: float = 0.6) -> Trial:
    """The angle stops at a ``share`` of its largest excursion from the first sample, as at the end of a counter."""
    start = trial.angle_rad[0]
    most = share * float(np.abs(trial.angle_rad - start).max())
    return trial._replace(angle_rad=np.clip(trial.angle_rad, start - most, start + most))


def reverse_torque(trial: Trial) -> Trial:
    """The torque has the wrong sign."""
    return trial._replace(torque_nm=-trial.torque_nm)


def silence(trial: Trial) -> Trial:
    """The pulse never fires: no torque, and the angle stays where it was."""
    return trial._replace(
        torque_nm=np.zeros_like(trial.torque_nm), angle_rad=np.full_like(trial.angle_rad, trial.angle_rad[0])
    )


def lose_motion(trial: Trial) -> Trial:
    """The pulse is commanded and nothing moves: amplifier off, or encoder unplugged."""
    return trial._replace(angle_rad=np.full_like(trial.angle_rad, trial.angle_rad[0]))


def angle_in_degrees(trial: Trial) -> Trial:
    """The angle is in degrees where radians belong."""
    return trial._replace(angle_rad=trial.angle_rad * degrees(1.0))


def torque_in_millis(trial: Trial) -> Trial:
    """The torque is in mN·m where N·m belong."""
    return trial._replace(torque_nm=1e3 * trial.torque_nm)


def time_in_millis(trial: Trial) -> Trial:
    """The time is in ms where s belong."""
    return trial._replace(time_s=1e3 * trial.time_s)


def swap_columns(trial: Trial) -> Trial:
    """Angle and torque are in each other's column."""
    return trial._replace(torque_nm=trial.angle_rad, angle_rad=trial.torque_nm)


def not_a_number(trial: Trial, *, at: int = 100, column: str = "angle_rad") -> Trial:
    """One value of a column is not a number."""
    changed: dict[str, Any] = {column: getattr(trial, column).copy()}
    changed[column][at] = nan
    return trial._replace(**changed)


def reverse_time(trial: Trial, *, at: int = 100) -> Trial:
    """The time runs backwards between two samples, ``at`` and the one before."""
    time = trial.time_s.copy()
    time[[at - 1, at]] = time[[at, at - 1]]
    return trial._replace(time_s=time)
