"""A motion as the estimators take it: uniform in time, one pulse, from rest."""

from typing import NamedTuple

from hknob_cli.recordings.trial import Array


class Motion(NamedTuple):
    """Torque and angle at a uniform interval ``dt_s``, the angle from its rest value before the pulse.

    ``velocity_rad_s`` and ``acceleration_rad_s2`` where differentiation was asked for. ``torque_nm`` is what acts from
    sample i to i + 1 (zero-order hold). ``noise_rad``: standard deviation of the angle's noise, from the part before
    the pulse and the encoder's step; None if unknown. ``averaged``: trials that were averaged into it.
    """

    dt_s: float
    torque_nm: Array
    angle_rad: Array
    velocity_rad_s: Array | None = None
    acceleration_rad_s2: Array | None = None
    noise_rad: float | None = None
    averaged: int = 1
