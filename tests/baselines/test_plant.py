"""The equations of motion, evaluated by hand from Hasser's Eq. 1."""

import numpy as np
import pytest

from hknob_cli.baselines.model import bias_torque, build_plant, start_state
from hknob_cli.specs.plan import Actuator, Bias, Finger, Fingerpad, Hand, Knob, Scene, Wall
from tests.baselines.trials import trial

FOURTH = Hand(finger=Finger(3e-7, 1e-4, 0.04), fingerpad=Fingerpad(2e-4, 5.0))


def scene(hand: Hand | None, actuator: Actuator | None = None) -> Scene:
    return Scene(Knob(2e-6, 1e-5, 3e-4), Wall(0.3), hand, None, None, actuator)


def slope(plant, state, command, other) -> np.ndarray:
    return np.array(plant.a) @ state + np.array(plant.b) * command + np.array(plant.c) * other


def test_hand_and_knob_are_one_body() -> None:
    plant = build_plant(scene(Hand(3e-7, 2e-4, 0.05)))
    change = slope(plant, [0.1, 2.0], 0.01, -0.002)
    assert change == pytest.approx([2.0, (0.01 - 0.002 - (1e-5 + 2e-4) * 2.0 - 0.05 * 0.1) / 2.3e-6], rel=1e-14)
    assert plant.friction == 3e-4


def test_finger_and_knob_are_two() -> None:
    tb, wb, ta, wa, u = 0.1, 2.0, -0.03, 0.7, 0.01
    change = slope(build_plant(scene(FOURTH)), [tb, wb, ta, wa], u, 0.0)
    pad = 2e-4 * (wb - wa) + 5.0 * (tb - ta)
    knob, finger = (u - pad - 1e-5 * wb) / 2e-6, (pad - 1e-4 * wa - 0.04 * ta) / 3e-7
    assert change == pytest.approx([wb, knob, wa, finger], rel=1e-14)


@pytest.mark.parametrize("hand", [None, FOURTH])
def test_lag_makes_the_torque_a_state(hand: Hand | None) -> None:
    plant = build_plant(scene(hand, Actuator(time_constant=0.5)))
    state = np.zeros(plant.order)
    state[-1] = 0.3
    change = slope(plant, state, 0.1, 0.05)
    assert change[-1] == pytest.approx((0.1 - 0.3) / 0.5)
    assert change[1] == pytest.approx((0.3 + 0.05) / 2e-6)


def test_the_finger_starts_with_the_knob() -> None:
    case = trial(angle=0.1, velocity=2.0)
    assert start_state(case, build_plant(scene(None))) == [0.1, 2.0]
    assert start_state(case, build_plant(scene(FOURTH, Actuator(time_constant=0.5)))) == [0.1, 2.0, 0.1, 2.0, 0.0]


def test_half_quantum_bias() -> None:
    assert bias_torque(scene(None)._replace(bias=Bias(half_quantum=True)), 0.01) == pytest.approx(0.5 * 0.3 * 0.01)
    assert bias_torque(scene(None)._replace(bias=Bias(torque=0.002)), 0.01) == 0.002
    assert bias_torque(scene(None), 0.01) == 0.0
