"""The second-order model's answer to a recorded torque: angle and its derivatives by inertia, damping, stiffness."""

from math import exp
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.pulse import Coefficients, Pull
from hknob_cli.recordings.trial import Array

RAMP = 1e-7  # per sample: what is left of a straight line's curvature


class Plant(NamedTuple):
    """Inertia kg·m², damping N·m·s/rad, stiffness N·m/rad, Coulomb friction N·m: of hand and apparatus together."""

    inertia: float
    damping: float
    stiffness: float
    coulomb: float = 0.0


class Start(NamedTuple):
    """Where a motion begins: angle rad from the spring's rest, and velocity rad/s."""

    angle_rad: float = 0.0
    velocity_rad_s: float = 0.0


AT_REST = Start()


def respond(
    plant: Plant,
    torque_nm: Array,
    dt_s: float,
    *,
    lag_s: float = 0.0,
    friction: bool = False,
    ramps: bool = False,
    start: Start = AT_REST,
) -> Array:
    """Angle (n,) rad at every sample, from rest at 0 or ``start``, under a torque held from sample i to i + 1.

    ``lag_s``: time constant of a first-order lag between command and torque. ``ramps``: the torque is not held, but
    runs straight from sample to sample, without a lag. ``friction``: its turns are followed even
    where ``coulomb`` is 0. Exact from turn to turn, with friction and a lag, too.
    """
    return respond_with_slopes(plant, torque_nm, dt_s, lag_s=lag_s, friction=friction, ramps=ramps, start=start)[0]


def respond_with_slopes(
    plant: Plant,
    torque_nm: Array,
    dt_s: float,
    *,
    lag_s: float = 0.0,
    friction: bool = False,
    ramps: bool = False,
    start: Start | None = None,
) -> tuple[Array, Array]:
    """As `respond`; and derivatives (n, 4) of the angle by log inertia, damping, stiffness and Coulomb friction.

    With a ``start``, (n, 6): by its angle and velocity, too.
    """
    from hknob_cli.engine.jit import compiled

    kernels = compiled("pulse")
    torque = np.ascontiguousarray(torque_nm, dtype=float)
    gain = dt_s * dt_s / plant.inertia
    alpha, beta, phi = plant.damping * dt_s / plant.inertia, plant.stiffness * gain, plant.coulomb * gain
    angle, slopes = np.empty(len(torque)), np.zeros((len(torque), 3 if start is None else 5))
    friction = friction or plant.coulomb > 0.0
    first, speed = start or AT_REST
    speed *= dt_s
    decay, fading = _fading(torque, dt_s / lag_s if lag_s > 0.0 else 0.0, ramps=ramps)
    if decay > 0.0:
        torque = torque - fading if ramps else torque
    with np.errstate(over="ignore", invalid="ignore"):
        follow = kernels["follow_with_friction" if friction else "follow_torque"]
        follow(Pull(torque, fading, decay), Coefficients(gain, alpha, beta, phi), first, speed, angle, slopes)
        by_alpha, by_beta, by_phi = slopes.T[:3]
        # The response is of first degree in torque, friction and start together: gain d/dgain + phi d/dphi
        # + first d/dfirst + speed d/dspeed leaves it as is.
        forced = angle if start is None else angle - first * slopes[:, 3] - speed * slopes[:, 4]
        by = np.empty((len(torque), 4 if start is None else 6))
        by[:, 0] = -(forced + alpha * by_alpha + beta * by_beta)
        by[:, 1], by[:, 2], by[:, 3] = by_alpha * (dt_s / plant.inertia), by_beta * gain, by_phi * gain
        if start is not None:
            by[:, 4], by[:, 5] = slopes[:, 3], slopes[:, 4] * dt_s
    return angle, by


def _fading(torque: Array, decay: float, *, ramps: bool) -> tuple[float, Array]:
    """Decay per sample and part (n,) of the torque that decays so in each hold, of ramps or of a lag (0: none).

    A straight line is the end of a slow exponential: with `RAMP` per sample it is met to that share of its rise.
    """
    if ramps:
        return RAMP, np.append(torque[:-1] - torque[1:], 0.0) / RAMP
    return (decay, lagged_part(torque, decay)) if decay > 0.0 else (0.0, np.empty(0))


def lagged_part(torque_nm: Array, decay: float) -> Array:
    """What a lag adds to the command at the start of each hold: (n,) N m, decaying by exp(-decay) over the hold."""
    from scipy.signal import lfilter

    keep = exp(-decay)
    reached = lfilter([0.0, 1.0 - keep], [1.0, -keep], torque_nm)
    return np.asarray(reached - torque_nm, dtype=float)
