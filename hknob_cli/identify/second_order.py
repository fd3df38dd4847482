"""The second-order model's answer to a recorded torque: angle and its derivatives by inertia, damping, stiffness."""

from math import exp
from typing import NamedTuple

import numpy as np

from hknob_cli.recordings.trial import Array


class Plant(NamedTuple):
    """Inertia kg·m², damping N·m·s/rad, stiffness N·m/rad, Coulomb friction N·m: of hand and apparatus together."""

    inertia: float
    damping: float
    stiffness: float
    coulomb: float = 0.0


def respond(plant: Plant, torque_nm: Array, dt_s: float, *, lag_s: float = 0.0, friction: bool = False) -> Array:
    """Angle (n,) rad at every sample, from rest at 0, under a torque held from sample i to i + 1.

    ``lag_s``: time constant of a first-order lag between command and torque. With friction (``friction``, or a
    ``coulomb`` above 0) the lagged torque is its mean over each hold; else it is exact.
    """
    return respond_with_slopes(plant, torque_nm, dt_s, lag_s=lag_s, friction=friction)[0]


def respond_with_slopes(
    plant: Plant, torque_nm: Array, dt_s: float, *, lag_s: float = 0.0, friction: bool = False
) -> tuple[Array, Array]:
    """As `respond`; and derivatives (n, 4) of the angle by log inertia, damping, stiffness and Coulomb friction."""
    from hknob_cli.engine.jit import compiled

    kernels = compiled("pulse")
    torque = np.ascontiguousarray(torque_nm, dtype=float)
    gain = dt_s * dt_s / plant.inertia
    alpha, beta, phi = plant.damping * dt_s / plant.inertia, plant.stiffness * gain, plant.coulomb * gain
    angle, slopes = np.empty(len(torque)), np.zeros((len(torque), 3))
    friction = friction or plant.coulomb > 0.0
    decay = dt_s / lag_s if lag_s > 0.0 else 0.0
    fading = lagged_part(torque, decay) if lag_s > 0.0 else np.empty(0)
    with np.errstate(over="ignore", invalid="ignore"):
        if friction:
            if lag_s > 0.0:
                torque = torque + fading * ((1.0 - exp(-decay)) / decay)
            kernels["follow_with_friction"](torque, gain, alpha, beta, phi, angle, slopes)
        else:
            kernels["follow_torque"](torque, fading, decay, gain, alpha, beta, angle, slopes)
        by_alpha, by_beta, by_phi = slopes.T
        # The response is of first degree in torque and friction together: gain d/dgain + phi d/dphi leaves it as is.
        by_log_inertia = -(angle + alpha * by_alpha + beta * by_beta)
        by = (by_log_inertia, by_alpha * (dt_s / plant.inertia), by_beta * gain, by_phi * gain)
    return angle, np.stack(by, axis=1)


def lagged_part(torque_nm: Array, decay: float) -> Array:
    """What a lag adds to the command at the start of each hold: (n,) N m, decaying by exp(-decay) over the hold."""
    from scipy.signal import lfilter

    keep = exp(-decay)
    reached = lfilter([0.0, 1.0 - keep], [1.0, -keep], torque_nm)
    return np.asarray(reached - torque_nm, dtype=float)
