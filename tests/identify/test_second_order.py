"""The exact motion and its derivatives: against complex steps through the same source, and differences."""

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine import pulse as source
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.identify.second_order import Plant, respond, respond_with_slopes
from tests.identify.pulses import FIRM, LIGHT, motion, propagate, pulse


@pytest.mark.parametrize("hand", [LIGHT, FIRM, (2e-6, 0.0, 0.0), (2e-6, 1e-2, 0.5), (2e-6, 1e-6, 5.0)])
@pytest.mark.parametrize("dt", [1e-4, 1e-3])
def test_motion_is_the_matrix_exponentials(hand, dt) -> None:
    true = motion(hand, pulse(300, 20, 40), dt)
    ours = respond(Plant(*hand), true.torque_nm, dt)
    assert np.max(np.abs(ours - true.angle_rad)) <= 1e-12 * np.max(np.abs(true.angle_rad))


@pytest.mark.parametrize(("alpha", "beta"), [(0.01, 1e-4), (3.0, 0.2), (0.1, 40.0), (0.0, 0.0), (-0.1, -0.01)])
def test_hold_coefficients_are_the_engines_and_their_derivatives_a_complex_steps(alpha: float, beta: float) -> None:
    found = source.hold_derivatives(alpha, beta, 0.3, 0.7)
    if alpha >= 0.0:
        assert found[:3] == pytest.approx(hold_coefficients(alpha, beta, 0.7), rel=1e-12, abs=1e-14)
    nudge = 1e-30
    by_alpha = [z.imag / nudge for z in source.hold_derivatives(alpha + nudge * 1j, beta, 0.3, 0.7)[:5]]
    by_beta = [z.imag / nudge for z in source.hold_derivatives(alpha, beta + nudge * 1j, 0.3, 0.7)[:5]]
    assert found[5:10] == pytest.approx(by_alpha, rel=1e-12, abs=1e-14)
    assert found[10:] == pytest.approx(by_beta, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("lag", [0.0, 5e-4])
def test_slopes_of_the_angle_are_a_complex_steps(lag: float) -> None:
    torque = pulse(150, 10, 60)
    slopes = respond_with_slopes(Plant(*LIGHT), torque, 1e-4, lag_s=lag)[1]
    fading = np.zeros(0)
    if lag:
        from hknob_cli.identify.second_order import lagged_part

        fading = lagged_part(torque, 1e-4 / lag)
    for column, which in enumerate(range(3)):
        p = np.array(LIGHT, dtype=complex)
        size = 1.0 if which else p[0].real
        p[which] += 1e-30j * size if which == 0 else 1e-30j
        angle, scratch = np.zeros(len(torque), complex), np.zeros((len(torque), 3), complex)
        gain = 1e-8 / p[0]
        pull = source.Pull(torque, fading, 1e-4 / lag if lag else 0.0)
        plant = source.Coefficients(gain, p[1] * 1e-4 / p[0], p[2] * gain, 0.0)
        source.follow_torque(pull, plant, 0.0, 0.0, angle, scratch)
        exact = angle.imag * 1e30
        assert np.max(np.abs(slopes[:, column] - exact)) <= 1e-11 * np.max(np.abs(exact))


def test_lag_is_exact() -> None:
    lag, torque = 7e-4, pulse(400, 20, 200)
    inertia, damping, stiffness = LIGHT
    matrix = np.array(
        [[0.0, 1.0, 0.0], [-stiffness / inertia, -damping / inertia, 1.0 / inertia], [0.0, 0.0, -1.0 / lag]]
    )
    angle = propagate(matrix, np.array([0.0, 0.0, 1.0 / lag]), torque, 1e-4)[:, 0]
    ours = respond(Plant(*LIGHT), torque, 1e-4, lag_s=lag)
    assert np.max(np.abs(ours - angle)) <= 1e-12 * np.max(angle)
    turned = respond(Plant(*LIGHT), torque, 1e-4, lag_s=lag, friction=True)
    assert np.max(np.abs(turned - angle)) <= 1e-12 * np.max(angle)


def test_ramps_against_no_friction_are_ramps() -> None:
    torque = pulse(300, 20, 100)
    angle, turned = (respond(Plant(*LIGHT), torque, 1e-4, ramps=True, friction=one) for one in (False, True))
    assert np.max(np.abs(turned - angle)) <= 1e-8 * np.max(angle)  # `RAMP` leaves its rounding


@pytest.mark.parametrize("lag", [0.0, 5e-5, 1e-3])
@pytest.mark.parametrize("coulomb", [3e-4, 2e-3])
def test_slopes_with_friction_are_differences(coulomb: float, lag: float) -> None:
    """Smooth but where a turn passes a sample or friction starts to hold; there differences differ."""
    torque, here = pulse(600, 20, 200), np.array([*LIGHT, coulomb])
    angle, slopes = respond_with_slopes(Plant(*here), torque, 1e-4, lag_s=lag)
    for k in range(4):
        step = np.zeros(4)
        step[k] = 1e-6 * here[k]
        ahead, back = (respond(Plant(*(here + sign * step)), torque, 1e-4, lag_s=lag) for sign in (1.0, -1.0))
        size = here[0] if k == 0 else 1.0
        difference = (ahead - back) / (2.0 * step[k]) * size
        assert np.max(np.abs(slopes[:, k] - difference)) <= 2e-5 * np.max(np.abs(difference))
    assert angle.max() > 0.0


def test_friction_holds_what_cannot_overcome_it() -> None:
    assert not np.any(respond(Plant(*LIGHT, 0.03), pulse(), 1e-4))


def test_friction_stops_a_knob_off_its_rest() -> None:
    """It sticks where the spring is weaker than friction: |K x| <= T_c, and stays there."""
    angle = respond(Plant(*LIGHT, 1.5e-3), pulse(2000), 1e-4)
    assert np.ptp(angle[-500:]) == 0.0
    assert 0.0 < abs(angle[-1]) <= 1.5e-3 / 0.04


@pytest.mark.parametrize(
    ("alpha", "beta", "decay", "t"),
    [(0.01, 1e-4, 0.3, 0.7), (3.0, 0.2, 2.0, 1.0), (0.1, 2.0, 0.5, 4.0), (0.0, 0.0, 1.0, 1.0)],
)
def test_the_answer_to_a_torque_that_decays_is_the_matrix_exponentials(
    alpha: float, beta: float, decay: float, t: float
) -> None:
    """From rest under exp(-decay t), itself a state; and times much longer than the series reach."""
    matrix = np.array([[0.0, 1.0, 0.0], [-beta, -alpha, 1.0], [0.0, 0.0, -decay]])
    place, speed, _ = expm(matrix * t) @ np.array([0.0, 0.0, 1.0])
    s, g, f, q, r = source.hold_derivatives(alpha, beta, decay, t)[:5]
    assert (q, r) == (pytest.approx(place, rel=1e-13), pytest.approx(speed, rel=1e-13))
    matrix[2, 2] = 0.0
    held = expm(matrix * t)
    assert (s, g, f) == pytest.approx((held[0, 1], held[0, 2], held[1, 1]), rel=1e-13, abs=1e-15)
