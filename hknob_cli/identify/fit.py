"""What an estimator says: parameters with standard errors, how well they explain the motion, and what is wrong."""

from typing import NamedTuple

PARAMETERS = ("inertia", "damping", "stiffness", "coulomb")


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
