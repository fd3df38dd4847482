"""Synthetic pulse responses by SciPy's matrix exponential, which shares no formula with the package."""

import numpy as np
from scipy.linalg import expm

from hknob_cli.identify.motion import Motion

LIGHT = (2.11e-6, 3.45e-4, 0.04)  # Table 1, 0.71 N
FIRM = (1.67e-6, 1.15e-3, 0.23)  # Table 1, 14.2 N
# Table 1 by grip: mean and standard deviation of inertia, damping, stiffness.
TABLE_1 = (
    (2.11e-6, 1.71e-7, 3.45e-4, 6.47e-5, 0.04, 0.02),
    (2.18e-6, 2.05e-7, 4.20e-4, 7.55e-5, 0.06, 0.02),
    (2.08e-6, 1.41e-7, 5.09e-4, 8.33e-5, 0.08, 0.03),
    (1.94e-6, 1.35e-7, 6.53e-4, 8.25e-5, 0.11, 0.03),
    (1.82e-6, 1.16e-7, 8.76e-4, 9.75e-5, 0.16, 0.04),
    (1.67e-6, 6.83e-8, 1.15e-3, 1.08e-4, 0.23, 0.04),
)


def pulse(count: int = 1000, onset: int = 50, width: int = 200, height: float = 0.02) -> np.ndarray:
    torque = np.zeros(count)
    torque[onset : onset + width] = height
    return torque


def propagate(matrix: np.ndarray, entry: np.ndarray, torque: np.ndarray, dt: float) -> np.ndarray:
    """States (n, m) at the samples, from rest, under a held torque."""
    m = len(entry)
    whole = np.zeros((m + 1, m + 1))
    whole[:m, :m], whole[:m, m] = matrix, entry
    step = expm(whole * dt)
    phi, drives = step[:m, :m], np.outer(torque, step[:m, m])
    states = np.zeros((len(torque), m))
    for i in range(len(torque) - 1):
        np.dot(phi, states[i], out=states[i + 1])
        states[i + 1] += drives[i]
    return states


def second(inertia: float, damping: float, stiffness: float) -> tuple[np.ndarray, np.ndarray]:
    return np.array([[0.0, 1.0], [-stiffness / inertia, -damping / inertia]]), np.array([0.0, 1.0 / inertia])


def motion(hand=LIGHT, torque: np.ndarray | None = None, dt: float = 1e-4) -> Motion:
    """Noiseless, with the exact velocity, and the acceleration just after each sample."""
    torque = pulse() if torque is None else torque
    matrix, entry = second(*hand)
    states = propagate(matrix, entry, torque, dt)
    return Motion(dt, torque, states[:, 0], states[:, 1], states @ matrix[1] + entry[1] * torque)


def drawn_hand(rng: np.random.Generator) -> tuple[float, float, float]:
    """A hand of Table 1: a grip at random, each number normal about its mean."""
    row = TABLE_1[rng.integers(6)]
    while True:
        hand = tuple(rng.normal(row[2 * i], row[2 * i + 1]) for i in range(3))
        if hand[0] > 0.0 and hand[1] > 0.0 and hand[2] > 0.01:
            return hand


def seen(true: Motion, rng: np.random.Generator, noise: float, counts: int, trials: int, onset: int) -> Motion:
    """Mean of trials through white noise of ``noise`` rad and an encoder of ``counts``, each with its own phase."""
    total = np.zeros_like(true.angle_rad)
    for _ in range(trials):
        reading = true.angle_rad + noise * rng.normal(size=len(total))
        if counts:
            step = 2.0 * np.pi / counts
            reading = np.floor((reading + rng.uniform(0.0, step)) / step) * step
        total += reading - np.mean(reading[:onset])
    return Motion(true.dt_s, true.torque_nm, total / trials, averaged=trials)
