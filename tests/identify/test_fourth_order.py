"""Finger and fingerpad: exact motion and derivatives, recovery, and what one pulse cannot tell."""

import numpy as np
import pytest

from hknob_cli.identify.fourth_order import (
    FINGER_INERTIA,
    ORDER,
    fourth_order,
    network,
    respond_fourth,
    respond_with_slopes,
    split,
)
from hknob_cli.identify.motion import Motion
from tests.identify.pulses import propagate, pulse

PARTS = {"inertia": 1.98e-6, "finger_inertia": 3e-7, **split(1.15e-3, 0.23, 2.0)}
TORQUE = pulse(600, 20, 200, 0.03)


def test_the_network_is_equation_1_with_the_dampers_summed() -> None:
    """Equation 1 itself, with any accelerations that satisfy it; Equation 2 prints -(B1 - B2) for the last element."""
    knob, tip, b1, k1, b2, k2 = (PARTS[name] for name in ORDER)
    state, torque = np.array([0.03, -1.2, 0.01, 0.7]), 0.02
    matrix, entry = network(PARTS)
    rate = matrix @ state + entry * torque
    angle, speed, finger, finger_speed = state
    assert knob * rate[1] + b2 * (speed - finger_speed) + k2 * (angle - finger) == pytest.approx(torque, rel=1e-12)
    across = b2 * (speed - finger_speed) + k2 * (angle - finger)
    assert tip * rate[3] + b1 * finger_speed + k1 * finger - across == pytest.approx(0.0, abs=1e-12)
    assert matrix[3, 3] == pytest.approx(-(b1 + b2) / tip)


def test_the_split_is_a_series() -> None:
    parts = split(1.15e-3, 0.23)
    for kind, whole in (("damping", 1.15e-3), ("stiffness", 0.23)):
        finger, pad = parts[f"finger_{kind}"], parts[f"pad_{kind}"]
        assert finger / pad == pytest.approx(10.0)
        assert finger * pad / (finger + pad) == pytest.approx(whole)


def test_motion_is_the_matrix_exponentials() -> None:
    angle = propagate(*network(PARTS), TORQUE, 1e-4)[:, 0]
    assert np.max(np.abs(respond_fourth(PARTS, TORQUE, 1e-4) - angle)) <= 1e-11 * np.max(angle)


@pytest.mark.parametrize("name", ORDER)
def test_derivatives_are_differences(name: str) -> None:
    """Central, relative step 1e-5: an error of 1e-10 by truncation, and 1e-11 by rounding, over the step."""
    slopes = respond_with_slopes(PARTS, TORQUE, 1e-4, np.eye(6))[1][:, ORDER.index(name)]
    ahead, back = (
        respond_fourth({**PARTS, name: PARTS[name] * factor}, TORQUE, 1e-4) for factor in (1 + 1e-5, 1 - 1e-5)
    )
    difference = (ahead - back) / 2e-5
    assert np.max(np.abs(slopes - difference)) <= 1e-6 * np.max(np.abs(difference))


@pytest.mark.parametrize(("ratio", "inertia"), [(0.5, 1.98e-6), (2.0, 1.98e-6), (1.0, None)])
def test_it_recovers_a_noiseless_hand(ratio: float, inertia: float | None) -> None:
    """The knob's own inertia known, or not: then at 1:1 another valley is only 1e-7 rad worse."""
    parts = {**PARTS, **split(1.15e-3, 0.23, ratio)}
    fit = fourth_order(Motion(1e-4, TORQUE, respond_fourth(parts, TORQUE, 1e-4)), inertia=inertia)
    assert {name: one.value for name, one in fit.parameters.items()} == pytest.approx(
        {name: parts[name] for name in fit.parameters}, rel=1e-8
    )


@pytest.mark.parametrize(("dampers", "springs"), [(3.0, 1.0), (10.0, 30.0), (2.0, 0.7)])
def test_it_finds_the_right_one_of_two_valleys(dampers: float, springs: float) -> None:
    """K1/K2 above and below B1/B2 move nearly alike: from one start half of the searches end in the other valley."""
    stiff, loose = split(1.15e-3, 0.23, springs), split(1.15e-3, 0.23, dampers)
    parts = {**PARTS, **{name: (stiff if name.endswith("stiffness") else loose)[name] for name in stiff}}
    angle = respond_fourth(parts, TORQUE, 1e-4) + 1e-5 * np.random.default_rng(2).normal(size=len(TORQUE))
    fit = fourth_order(Motion(1e-4, TORQUE, angle, noise_rad=1e-5), inertia=1.98e-6)
    for name, one in fit.parameters.items():
        assert abs(one.value - parts[name]) <= 4.0 * one.std < 0.5 * parts[name]


def test_a_valley_that_leads_away_is_not_told() -> None:
    """At K1/K2 = B1/B2 with the knob's inertia free: the curvature says ±1 %, yet a hand all of pad fits as well."""
    parts = {**PARTS, **split(1.15e-3, 0.23, 10.0)}
    angle = respond_fourth(parts, TORQUE, 1e-4) + 1e-5 * np.random.default_rng(1).normal(size=len(TORQUE))
    fit = fourth_order(Motion(1e-4, TORQUE, angle, noise_rad=1e-5))
    for name in ("finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness"):
        assert not fit.parameters[name].identifiable
    one = fit.parameters["inertia"]
    assert one.identifiable
    assert abs(one.value - parts["inertia"]) <= 1.96 * one.std


def test_a_stiff_finger_is_not_told() -> None:
    """At 100:1 the finger hardly moves: what it is made of does not show in the knob's motion."""
    parts = {**PARTS, **split(1.15e-3, 0.23, 100.0)}
    angle = respond_fourth(parts, TORQUE, 1e-4) + 1e-5 * np.random.default_rng(0).normal(size=len(TORQUE))
    fit = fourth_order(Motion(1e-4, TORQUE, angle, noise_rad=1e-5), inertia=1.98e-6, finger_inertia=None)
    for name in ("finger_inertia", "finger_damping", "finger_stiffness"):
        assert not fit.parameters[name].identifiable
        assert any(flag.startswith(f"{name} is not identifiable from this motion") for flag in fit.flags)
    assert fit.vaf > 0.999999


def test_both_inertias_free_are_more_than_a_pulse_tells() -> None:
    parts = {**PARTS, "finger_inertia": FINGER_INERTIA, **split(1.15e-3, 0.23, 10.0)}
    angle = respond_fourth(parts, TORQUE, 1e-4) + 1e-5 * np.random.default_rng(0).normal(size=len(TORQUE))
    fit = fourth_order(Motion(1e-4, TORQUE, angle, noise_rad=1e-5), finger_inertia=None)
    assert not fit.parameters["finger_inertia"].identifiable
    assert any(flag.startswith("neither inertia is known") for flag in fit.flags)
    assert set(fit.parameters) == set(ORDER)


def test_nothing_is_told_of_nothing() -> None:
    still = Motion(1e-4, TORQUE, np.zeros_like(TORQUE))
    assert "does not change" in fourth_order(still).flags[0]
