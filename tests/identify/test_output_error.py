"""Output error: exact without noise, honest where the data are silent."""

import numpy as np
import pytest

from hknob_cli.identify.motion import Motion
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.second_order import Plant, integrated_start, respond
from tests.identify.pulses import FIRM, LIGHT, motion, pulse, seen

NAMES = ("inertia", "damping", "stiffness")


def values(fit):
    return [one.value for one in fit.parameters.values()]


@pytest.mark.parametrize("hand", [LIGHT, FIRM, (2e-6, 2e-3, 0.05), (2e-6, 1e-5, 0.2)])
def test_it_recovers_a_noiseless_hand(hand) -> None:
    fit = output_error(motion(hand))
    assert values(fit) == pytest.approx(hand, rel=1e-9)
    assert fit.vaf == pytest.approx(1.0, abs=1e-15)
    assert not [flag for flag in fit.flags if "damped" not in flag]


def test_it_recovers_from_the_dissertations_short_window() -> None:
    assert values(output_error(motion(LIGHT, pulse(321, 20)))) == pytest.approx(LIGHT, rel=1e-9)


@pytest.mark.parametrize("coulomb", [1e-4, 5.6e-4, 2e-3])
def test_it_recovers_friction(coulomb: float) -> None:
    torque = pulse()
    angle = respond(Plant(*LIGHT, coulomb), torque, 1e-4)
    fit = output_error(Motion(1e-4, torque, angle), fit_coulomb=True)
    assert values(fit) == pytest.approx((*LIGHT, coulomb), rel=1e-8)
    known = output_error(Motion(1e-4, torque, angle), coulomb_nm=coulomb)
    assert values(known) == pytest.approx(LIGHT, rel=1e-8)


def test_friction_that_is_not_there_comes_out_as_none() -> None:
    rng = np.random.default_rng(3)
    fit = output_error(seen(motion(LIGHT), rng, 1e-4, 0, 3, 50), fit_coulomb=True)
    one = fit.parameters["coulomb"]
    assert 0.0 <= one.value < 3.0 * one.std
    assert values(fit)[:3] == pytest.approx(LIGHT, rel=0.02)


def test_friction_left_out_shows_as_misfit() -> None:
    torque, rng = pulse(), np.random.default_rng(1)
    true = Motion(1e-4, torque, respond(Plant(*LIGHT, 5.6e-4), torque, 1e-4))
    fit = output_error(seen(true, rng, 1e-5, 0, 3, 50)._replace(noise_rad=1e-5))
    assert any(flag.startswith("the model does not fit: residuals are not white") for flag in fit.flags)
    assert fit.parameters["damping"].value > 1.05 * LIGHT[1]


def test_a_known_lag_is_allowed_for() -> None:
    torque = pulse()
    angle = respond(Plant(*LIGHT), torque, 1e-4, lag_s=5e-4)
    assert values(output_error(Motion(1e-4, torque, angle), lag_s=5e-4)) == pytest.approx(LIGHT, rel=1e-9)


def test_the_rest_angle_is_free() -> None:
    true = motion(LIGHT)
    fit = output_error(true._replace(angle_rad=true.angle_rad + 0.01))
    assert values(fit) == pytest.approx(LIGHT, rel=1e-9)
    assert fit.offset_rad == pytest.approx(0.01, rel=1e-9)


def test_a_bare_apparatus_has_damping_and_stiffness_of_nothing() -> None:
    """Estimates may fall below zero: an interval about zero must."""
    rng = np.random.default_rng(5)
    fit = output_error(seen(motion((1.98e-6, 0.0, 0.0), pulse(321, 20)), rng, 1e-5, 0, 3, 20))
    assert fit.parameters["inertia"].value == pytest.approx(1.98e-6, rel=1e-3)
    for name in ("damping", "stiffness"):
        one = fit.parameters[name]
        assert abs(one.value) < 4.0 * one.std


def test_a_window_too_short_for_stiffness_is_said_so() -> None:
    torque = pulse(35, 20, 200)  # 1.5 ms of the pulse: the spring has hardly been wound
    fit = output_error(seen(motion(LIGHT, torque), np.random.default_rng(0), 1e-5, 0, 1, 20))
    assert not fit.parameters["stiffness"].identifiable
    assert any(flag.startswith("stiffness is not identifiable: not told from zero in 1.5 ms") for flag in fit.flags)


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (lambda m: m._replace(torque_nm=0.0 * m.torque_nm), "no torque"),
        (lambda m: m._replace(angle_rad=0.0 * m.angle_rad + 0.3), "does not change"),
        (lambda m: m._replace(angle_rad=np.full_like(m.angle_rad, np.nan)), "not finite"),
        (lambda m: Motion(1e-4, m.torque_nm[:5], m.angle_rad[:5]), "only 5 samples"),
    ],
)
def test_what_tells_nothing_is_flagged(broken, words: str) -> None:
    fit = output_error(broken(motion(LIGHT)))
    assert words in fit.flags[0]
    assert not any(fit.parameters[name].identifiable for name in NAMES)
    assert np.isnan(fit.vaf)


def test_an_angle_against_the_torque_does_not_crash() -> None:
    true = motion(LIGHT)
    fit = output_error(true._replace(angle_rad=-true.angle_rad))
    assert set(fit.parameters) == set(NAMES)
    assert fit.flags


def test_pure_noise_does_not_crash() -> None:
    noise = np.random.default_rng(0).normal(size=400)
    fit = output_error(Motion(1e-4, pulse(400), noise))
    assert fit.flags


def test_the_start_needs_no_derivative() -> None:
    rough = seen(motion(LIGHT), np.random.default_rng(0), 1e-4, 4000, 3, 50)
    assert integrated_start(rough)[:3] == pytest.approx(LIGHT, rel=0.1)
