"""Output error against SciPy: lsim's motion, and curve_fit of a closed-form pulse response written by hand."""

import numpy as np
import pytest
from scipy.optimize import curve_fit
from scipy.signal import StateSpace, lsim

from hknob_cli.identify.fourth_order import network, respond_fourth, split
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.second_order import Plant, respond
from tests.identify.pulses import LIGHT, pulse, second

DT = 1e-4
TIMES = DT * np.arange(600)
WIDTH, HEIGHT = 0.02, 0.02


def step_response(t: np.ndarray, inertia: float, damping: float, stiffness: float) -> np.ndarray:
    """Underdamped, to a unit torque from t = 0 on."""
    rate = damping / (2.0 * inertia)
    wave = np.sqrt(stiffness / inertia - rate * rate)
    t = np.maximum(t, 0.0)
    return (1.0 - np.exp(-rate * t) * (np.cos(wave * t) + rate / wave * np.sin(wave * t))) / stiffness


def pulse_response(t: np.ndarray, inertia: float, damping: float, stiffness: float, rest: float) -> np.ndarray:
    hand = inertia, damping, stiffness
    return HEIGHT * (step_response(t, *hand) - step_response(t - WIDTH, *hand)) + rest


@pytest.mark.parametrize("noise", [1e-6, 1e-5, 1e-4])
def test_curve_fit_finds_the_same_hand(noise: float) -> None:
    rng = np.random.default_rng(int(1e7 * noise))
    angle = pulse_response(TIMES, *LIGHT, 0.0) + noise * rng.normal(size=len(TIMES))
    torque = pulse(len(TIMES), 0, round(WIDTH / DT), HEIGHT)
    fit = output_error(Motion(DT, torque, angle))
    scaled = lambda t, j, b, k, rest: pulse_response(t, j * LIGHT[0], b * LIGHT[1], k * LIGHT[2], 1e-3 * rest)  # noqa: E731
    best, covariance = curve_fit(scaled, TIMES, angle, p0=(1.2, 0.8, 1.1, 0.0), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    ours = [one.value / size for one, size in zip(fit.parameters.values(), LIGHT, strict=True)]
    assert ours == pytest.approx(best[:3], rel=1e-6)
    # White noise: the cautious standard errors are the classical ones, up or down by what 600 samples leave open.
    stds = [one.std / size for one, size in zip(fit.parameters.values(), LIGHT, strict=True)]
    assert stds == pytest.approx(np.sqrt(np.diagonal(covariance))[:3], rel=0.25)


def test_lsim_moves_alike() -> None:
    """lsim with a held input: its own matrix exponential."""
    torque = np.random.default_rng(0).normal(size=500) * 0.01
    for system, ours in (
        (second(*LIGHT), respond(Plant(*LIGHT), torque, DT)),
        (network(FOUR), respond_fourth(FOUR, torque, DT)),
    ):
        matrix, entry = system
        reading = np.zeros((1, len(entry)))
        reading[0, 0] = 1.0
        plant = StateSpace(matrix, entry[:, None], reading, np.zeros((1, 1)))
        theirs = lsim(plant, torque, DT * np.arange(500), interp=False)[1]
        assert np.max(np.abs(ours - theirs)) <= 1e-10 * np.max(np.abs(theirs))


FOUR = {"inertia": 1.98e-6, "finger_inertia": 3e-7, **split(1.15e-3, 0.23)}
