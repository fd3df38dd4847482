"""Karason and Srinivasan's hand of third order: the limit of the network without a knob, and what a fit finds of it.

The reference is two models, each by SciPy's matrix exponential: the pad, 1 / (B2 s + K2), and the finger, 1 / (J1 s^2 +
B1 s + K1), carry the same torque, so that their angles add.
"""

import numpy as np
import pytest

from hknob_cli.identify.fourth_order import fourth_order, respond_fourth, split
from hknob_cli.identify.motion import Motion
from tests.identify.pulses import propagate, pulse, second

HAND = {"inertia": 0.0, "finger_inertia": 3e-7, **split(1.15e-3, 0.23, 2.0)}
TORQUE = pulse(600, 20, 200, 0.03)
DT = 1e-4


def network_without_knob() -> tuple[np.ndarray, np.ndarray]:
    """Matrix (3, 3) and input (3,) of pad angle, finger angle, finger velocity: the hand alone, of third order.

    Karason and Srinivasan's (1995) model, to which Section 4.4.1 compares the network less the actuator's mass: the
    pad's damper takes what the torque leaves to it, so that the pad's angle has a rate and no acceleration.
    """
    names = ("finger_inertia", "finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness")
    tip, b1, k1, b2, k2 = (HAND[name] for name in names)
    matrix = np.array(
        [
            [-k2 / b2, k2 / b2, 1.0],
            [0.0, 0.0, 1.0],
            [0.0, -k1 / tip, -b1 / tip],  # the pad passes on the torque, whole
        ]
    )
    return matrix, np.array([1.0 / b2, 0.0, 1.0 / tip])


def reference() -> np.ndarray:
    """Angle (n,) rad of the pad's outer side under the held torque."""
    goes = HAND["pad_stiffness"] / HAND["pad_damping"]
    pad = propagate(np.array([[-goes]]), np.array([1.0 / HAND["pad_damping"]]), TORQUE, DT)
    finger = propagate(*second(*(HAND[f"finger_{one}"] for one in ("inertia", "damping", "stiffness"))), TORQUE, DT)
    return np.asarray(pad[:, 0] + finger[:, 0])


def test_the_hand_alone_is_of_third_order() -> None:
    moved = propagate(*network_without_knob(), TORQUE, DT)[:, 0]
    angle = reference()
    assert np.max(np.abs(moved - angle)) <= 1e-9 * np.max(angle)
    assert np.linalg.matrix_rank(network_without_knob()[0]) == 3


def test_it_is_the_limit_of_the_network_with_a_knob() -> None:
    """What is left goes with the knob's inertia: a tenth of it is a tenth of the difference."""
    angle = reference()
    left = [np.max(np.abs(respond_fourth({**HAND, "inertia": one}, TORQUE, DT) - angle)) for one in (1e-9, 1e-10)]
    assert left[0] <= 2e-3 * np.max(angle)
    assert left[1] == pytest.approx(0.1 * left[0], rel=0.1)


def test_a_fit_without_a_knob_finds_the_hand() -> None:
    """A knob of 1e-12 kg m^2 is off the limit by below 1e-6 of the motion, and the parameters by 1e-3 at most."""
    fit = fourth_order(Motion(DT, TORQUE, reference()), inertia=1e-12)
    for name in ("finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness"):
        found = fit.parameters[name]
        assert found.identifiable
        assert found.value == pytest.approx(HAND[name], rel=1e-3)
