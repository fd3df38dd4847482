"""Recordings of a hand that is known exactly: a second-order knob, stepped by its matrix exponential."""

import math

import numpy as np
from scipy.linalg import expm

from hknob_cli.recordings.trial import Key, Trial

# Table 1, 2.4 N.
INERTIA, DAMPING, STIFFNESS = 2.08e-6, 5.09e-4, 0.08


def swing(torque: np.ndarray, dt_s: float) -> np.ndarray:
    """Angle at the samples, from rest, of a knob whose torque is held from sample to sample."""
    block = np.zeros((3, 3))
    block[0, 1] = 1.0
    block[1] = [-STIFFNESS / INERTIA, -DAMPING / INERTIA, 1.0 / INERTIA]
    step = expm(block * dt_s)
    state, angle = np.zeros(2), np.zeros(torque.size)
    for i in range(torque.size - 1):
        state = step[:2, :2] @ state + step[:2, 2] * torque[i]
        angle[i + 1] = state[0]
    return angle


def trial(
    *,
    number: int = 1,
    block: int = 1,
    rate_hz: float = 10_000.0,
    torque_nm: float = 0.01,
    before_s: float = 0.05,
    length_s: float = 0.15,
    grip_n: float = 2.4,
    counts: int | None = None,
    noise_rad: float = 0.0,
    rest_rad: float = 0.0,
    seed: int = 0,
) -> Trial:
    """One trial of a 20 ms pulse, by default without noise and of a continuous sensor."""
    time = np.arange(round(length_s * rate_hz)) / rate_hz
    first = round(before_s * rate_hz)
    torque = np.zeros(time.size)
    torque[first : first + round(0.02 * rate_hz)] = torque_nm
    random = np.random.default_rng([seed, number])
    angle = rest_rad + swing(torque, 1.0 / rate_hz) + noise_rad * random.standard_normal(time.size)
    if counts is not None:
        step = 2.0 * math.pi / counts
        angle = np.floor(angle / step) * step
    grip = grip_n + 0.01 * random.standard_normal(time.size)
    return Trial(Key("S1", "pinch", 2.4, block, number), time, torque, angle, grip)
