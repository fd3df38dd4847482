"""How far off each estimator is, and why: known hands, pulsed by simulation, with one nuisance at a time.

Noise of the angle (Section 4.4's implicit regularization), Coulomb friction that the model leaves out, and the
smoothing that differentiation needs, each from nothing upwards, the others at rest.
"""

from collections.abc import Callable, Sequence
from math import nan, pi
from typing import NamedTuple

import numpy as np

from hknob_cli.identify.fit import Fit
from hknob_cli.identify.least_squares import least_squares, least_squares_friction
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.identify.smooth import differentiate, smooth

# Table 1, lightest and firmest grip, by grip force in N.
GRIPS = {0.71: Plant(2.11e-6, 3.45e-4, 0.04), 14.2: Plant(1.67e-6, 1.15e-3, 0.23)}
NUISANCES: dict[str, tuple[float, ...]] = {
    "noise_rad": (0.0, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3),
    "coulomb_nm": (0.0, 1e-4, 3e-4, 5.6e-4, 1e-3),
    "decimation": (1.0, 2.0, 5.0, 10.0, 20.0, 40.0),
}
COUNTS, PULSE_S, PEAK_RAD, DT_S, TRIALS = 640_000, 0.02, 0.09, 1e-4, 3
DECIMATION, QUIET_RAD = 10, 1e-5  # smoothing while noise or friction varies; noise while smoothing does
BEFORE, AFTER, MARGIN = 20, 300, 400  # samples kept before and after the onset, and taken up by the filter's ends


class Bias(NamedTuple):
    """An estimate's mean error and standard deviation, in per cent of the truth (of friction: of its level)."""

    grip_n: float
    nuisance: str
    level: float
    estimator: str
    parameter: str
    bias_percent: float
    std_percent: float


def bias_study(repeats: int = 50, *, nuisances: dict[str, Sequence[float]] | None = None, seed: int = 1) -> list[Bias]:
    """Biases by Monte Carlo, ``repeats`` conditions each of three averaged trials of 10 kHz and 640,000 counts.

    ``nuisances``: levels by name, of `NUISANCES`. The least squares get the angle smoothed and differentiated; output
    error gets it as averaged.
    """
    found = []
    for grip_n, plant in GRIPS.items():
        for nuisance, levels in (nuisances or NUISANCES).items():
            for level in levels:
                found += _at(grip_n, plant, nuisance, level, repeats, np.random.default_rng(seed))
    return found


def pulsed(plant: Plant, noise_rad: float, rng: np.random.Generator) -> Motion:
    """Mean of three trials of a 20 ms pulse to 0.09 rad, through noise and encoder; margins, no derivatives."""
    onset = BEFORE + MARGIN
    torque = np.zeros(onset + AFTER + MARGIN + 1)
    torque[onset : onset + round(PULSE_S / DT_S)] = 1.0
    push = PEAK_RAD / float(np.max(respond(plant._replace(coulomb=0.0), torque, DT_S)))
    if plant.coulomb:  # the push that reaches the angle in spite of friction, by fixed-point steps
        for _ in range(8):
            push *= PEAK_RAD / max(float(np.max(respond(plant, torque * push, DT_S))), 0.1 * PEAK_RAD)
    angle = respond(plant, torque * push, DT_S)
    step = 2.0 * pi / COUNTS
    total = np.zeros_like(angle)
    for _ in range(TRIALS):
        seen = angle + rng.uniform(0.0, step) + rng.normal(0.0, 1.0, len(angle)) * noise_rad
        counts = np.floor(seen / step) * step
        total += counts - np.mean(counts[:onset])
    noise = (noise_rad**2 / TRIALS + step**2 / (12.0 * TRIALS)) ** 0.5
    return Motion(DT_S, torque * push, total / TRIALS, noise_rad=noise, averaged=TRIALS)


def differentiated(motion: Motion, factor: int) -> Motion:
    """Motion with angle and velocity smoothed by filtered decimation, and the margins cut."""
    angle = smooth(motion.angle_rad, factor)
    velocity = smooth(differentiate(angle, motion.dt_s), factor)
    acceleration = differentiate(velocity, motion.dt_s)
    kept = slice(MARGIN, -MARGIN)
    return motion._replace(
        torque_nm=motion.torque_nm[kept],
        angle_rad=angle[kept],
        velocity_rad_s=velocity[kept],
        acceleration_rad_s2=acceleration[kept],
    )


def _at(grip_n: float, plant: Plant, nuisance: str, level: float, repeats: int, rng: np.random.Generator) -> list[Bias]:
    noise = {"noise_rad": level, "decimation": QUIET_RAD}.get(nuisance, 0.0)
    factor = int(level) if nuisance == "decimation" else DECIMATION
    true = plant._replace(coulomb=level if nuisance == "coulomb_nm" else 0.0)
    kept = slice(MARGIN, -MARGIN)
    errors: dict[tuple[str, str], list[float]] = {}
    for _ in range(repeats):
        raw = pulsed(true, noise, rng)
        cut = raw._replace(torque_nm=raw.torque_nm[kept], angle_rad=raw.angle_rad[kept])
        smoothed = differentiated(raw, factor)
        jobs: tuple[tuple[Callable[..., Fit], Motion, dict[str, bool]], ...] = (
            (least_squares, smoothed, {}),
            (least_squares_friction, smoothed, {}),
            (output_error, cut, {}),
            (output_error, cut, {"fit_coulomb": True}),
        )
        for estimator, motion, options in jobs:
            fit = estimator(motion, **options)
            for name, one in fit.parameters.items():
                truth = getattr(true, name)
                error = 100.0 * (one.value / truth - 1.0) if truth else nan
                errors.setdefault((fit.estimator, name), []).append(error)
    rows = []
    for (estimator_name, parameter), values in errors.items():
        if np.all(np.isfinite(values)):
            std = float(np.std(values, ddof=1)) if repeats > 1 else nan
            rows.append(Bias(grip_n, nuisance, level, estimator_name, parameter, float(np.mean(values)), std))
    return rows
