"""The dissertation's estimator: exact on exact derivatives, pulled to zero by noise in them."""

import math

import numpy as np
import pytest

from hknob_cli.apparatus.people import mean_hand
from hknob_cli.errors import UsageError
from hknob_cli.identify.least_squares import FOLLOWS, inflation, least_squares, least_squares_friction
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.identify.studies import differentiated, pulsed
from tests.identify.pulses import FIRM, LIGHT, motion, pulse


def values(fit):
    return [one.value for one in fit.parameters.values()]


@pytest.mark.parametrize("hand", [LIGHT, FIRM])
def test_it_is_exact_on_exact_derivatives(hand) -> None:
    for estimator in (least_squares, least_squares_friction):
        fit = estimator(motion(hand))
        assert values(fit)[:3] == pytest.approx(hand, rel=1e-9)
        assert fit.vaf == pytest.approx(1.0, abs=1e-12)
        assert fit.torque_vaf == pytest.approx(1.0, abs=1e-12)


def test_friction_has_a_column() -> None:
    """While it moves out, friction is a constant torque less: the same motion under torque less friction."""
    torque, coulomb = pulse(250, 50) + pulse(250, 150, 100), 8e-4
    less = motion(LIGHT, np.where(torque > 0.0, torque - coulomb, 0.0))
    assert np.allclose(respond(Plant(*LIGHT, coulomb), torque, 1e-4), less.angle_rad, rtol=0.0, atol=1e-12)
    fit = least_squares_friction(less._replace(torque_nm=torque))
    assert values(fit) == pytest.approx((*LIGHT, coulomb), rel=1e-8)


def test_friction_is_not_told_during_a_constant_torque() -> None:
    """A column of ones explains a constant torque by itself."""
    fit = least_squares_friction(motion(LIGHT, pulse(250, 50)))
    assert not fit.parameters["coulomb"].identifiable
    assert "coulomb is not identifiable: the data do not tell it from the others" in fit.flags


def test_noise_in_the_acceleration_pulls_inertia_down() -> None:
    """Section 4.4: with error e in the acceleration alone, J falls by the share that e has in what J alone explains."""
    true = motion(LIGHT)
    rng = np.random.default_rng(0)
    noisy = true._replace(acceleration_rad_s2=true.acceleration_rad_s2 + 700.0 * rng.normal(size=1000))
    fit = least_squares(noisy)
    others = np.stack([true.velocity_rad_s, true.angle_rad], axis=1)
    own = true.acceleration_rad_s2 - others @ np.linalg.lstsq(others, true.acceleration_rad_s2, rcond=None)[0]
    expected = LIGHT[0] * (own @ own) / (own @ own + 1000 * 700.0**2)
    assert fit.parameters["inertia"].value == pytest.approx(expected, rel=0.03)
    assert fit.parameters["inertia"].value < 0.95 * LIGHT[0]


def test_standard_errors_grow_with_correlated_residuals() -> None:
    """Means of 20 neighbours make slow errors 4.5 times larger; the classical errors would stay as they are."""
    true, rng = motion(LIGHT), np.random.default_rng(0)
    ratios = []
    for _ in range(20):
        white = 1e-4 * rng.normal(size=1000)
        slow = np.convolve(white, np.ones(20) / 20**0.5, mode="same")
        fits = [least_squares(true._replace(torque_nm=true.torque_nm + error)) for error in (white, slow)]
        noise = [math.sqrt(one.std**2 - one.misfit**2) for one in (fit.parameters["stiffness"] for fit in fits)]
        ratios.append(noise[1] / noise[0])
    assert 2.0 < np.mean(ratios) < 4.5


def test_it_needs_derivatives() -> None:
    with pytest.raises(UsageError, match="no velocity and acceleration"):
        least_squares(Motion(1e-4, pulse(), pulse()))


def test_what_tells_nothing_is_flagged() -> None:
    true = motion(LIGHT)
    assert "no torque" in least_squares(true._replace(torque_nm=0.0 * true.torque_nm)).flags[0]
    still = true._replace(velocity_rad_s=0.0 * true.velocity_rad_s)
    assert "too few samples move" in least_squares_friction(still).flags[0]


def test_friction_that_follows_the_torque_is_not_told() -> None:
    """A firm hand turns back as the pulse ends: a mN*m of friction where there is none, and it is not given out."""
    light, firm = (
        least_squares_friction(differentiated(pulsed(Plant(*mean_hand(1, grip)), 0.0, np.random.default_rng(1)), 10))
        for grip in (0.71, 14.2)
    )
    assert firm.parameters["coulomb"].value > 1e-3
    one = firm.parameters["coulomb"]
    assert one.value > math.sqrt(one.std**2 - one.misfit**2)  # noise alone would make it a sure thing
    assert not firm.parameters["coulomb"].identifiable
    assert FOLLOWS in firm.flags
    assert FOLLOWS not in light.flags
    for values, wanted in (((1, 1, -1, -1), 1 / np.finfo(float).eps), ((1, -1, 1, -1), 1.0), ((1, 1, 1, 1), 1.0)):
        assert inflation(np.array(values, float), np.array([1.0, 1.0, 0.0, 0.0])) == pytest.approx(wanted)
