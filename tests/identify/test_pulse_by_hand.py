"""A knob's response to a torque, followed in the interpreter: against matrix exponentials, and ramps by hand."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine import pulse, pulse_friction
from hknob_cli.engine.pulse import Coefficients, Pull
from hknob_cli.engine.pulse_friction import follow_with_friction, turning_time

TORQUE = np.array([0.5, -1.0, 2.0, 0.25, 0.0, -0.75, 1.5, 0.0])
ALPHA, BETA, GAIN, FIRST, SPEED = 0.3, 0.7, 2.0, 0.4, -0.6


def angles(alpha: Any, beta: Any, first: float = FIRST, speed: float = SPEED, torque: Any = TORQUE) -> np.ndarray:
    """Angle at every sample; of complex numbers, too."""
    over = expm(np.array([[0.0, 1.0, 0.0], [-beta, -alpha, 1.0], [0.0, 0.0, 0.0]], dtype=complex))
    state, found = np.array([first, speed, 0.0], dtype=complex), []
    for one in torque:
        found.append(state[0])
        state[2] = GAIN * one
        state = over @ state
    return np.array(found)


def test_a_response_and_its_slopes_are_those_of_the_motion() -> None:
    """By complex steps through the matrix's exponential: by damping and stiffness, by first angle and speed."""
    n = len(TORQUE)
    angle, slopes = np.zeros(n), np.zeros((n, 5))
    pulse.follow_torque(
        Pull(TORQUE, np.zeros(0), 0.0), Coefficients(GAIN, ALPHA, BETA, 0.0), FIRST, SPEED, angle, slopes
    )
    assert angle == pytest.approx(angles(ALPHA, BETA).real, rel=1e-12, abs=1e-13)
    h = 1e-30
    for column, found in (
        (0, angles(ALPHA + 1j * h, BETA).imag / h),
        (1, angles(ALPHA, BETA + 1j * h).imag / h),
        (3, angles(ALPHA, BETA, 1.0, 0.0, 0.0 * TORQUE).real),
        (4, angles(ALPHA, BETA, 0.0, 1.0, 0.0 * TORQUE).real),
    ):
        assert slopes[:, column] == pytest.approx(found, rel=1e-11, abs=1e-12), column


def test_without_friction_one_that_turns_moves_as_one_that_does_not() -> None:
    n = len(TORQUE)
    angle, slopes = np.zeros(n), np.zeros((n, 3))
    follow_with_friction(
        Pull(TORQUE, np.zeros(0), 0.0), Coefficients(GAIN, ALPHA, BETA, 0.0), FIRST, SPEED, angle, slopes
    )
    assert angle == pytest.approx(angles(ALPHA, BETA).real, rel=1e-11, abs=1e-12)


def test_friction_stops_a_knob_that_was_pushed() -> None:
    """Pushed by 6 against 1 for two samples it has come 10, at 10; it takes 10 more to stop, after 50 more."""
    torque, phi = np.array([3.0, 3.0, *[0.0] * 14]), 1.0
    angle, slopes = np.zeros(16), np.zeros((16, 3))
    follow_with_friction(Pull(torque, np.zeros(0), 0.0), Coefficients(2.0, 0.0, 0.0, phi), 0.0, 0.0, angle, slopes)
    wanted = [0.0, 2.5, *(10.0 + 10.0 * t - 0.5 * t * t for t in range(11)), 60.0, 60.0, 60.0]
    assert angle == pytest.approx(wanted, rel=1e-13)
    # The way is 2 (6 - phi), and 2 (6 - phi)^2 / phi more: by friction -2, and -20 - 50 more.
    assert slopes[2, 2] == pytest.approx(-2.0, rel=1e-13)
    assert slopes[-1, 2] == pytest.approx(-72.0, rel=1e-12)


@pytest.mark.parametrize("alpha", [0.0, 0.2, 2.0])
def test_a_turn_is_found_in_a_few_steps_of_newtons_method(alpha: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thrown at 0.6 against 1, damped: at log(1 + 0.6 a) / a. A bracket that is halved would take fifty looks."""
    looks: list[float] = []
    at = pulse_friction.pull_at

    def pull_at(*numbers: float) -> tuple[float, float]:
        looks.append(numbers[-1])
        return at(*numbers)

    monkeypatch.setattr(pulse_friction, "pull_at", pull_at)
    for way in (1.0, -1.0):
        looks.clear()
        time = turning_time(0.6 * way, -way, 0.0, way, alpha, 0.0, 0.0, 1.0)
        assert time == pytest.approx(np.log1p(0.6 * alpha) / alpha if alpha else 0.6, rel=1e-14)
        assert len(looks) <= 8
