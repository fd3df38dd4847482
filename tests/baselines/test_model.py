"""Tests of `baselines.model`, by hand: Hasser's Eq. 1, encoder, command law and delay."""

from math import pi

import numpy as np
import pytest

from hknob_cli.baselines.model import Controller, bias_torque, build_plant, start_state
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Finger, Fingerpad, Hand, Knob, Scene, Wall
from tests.baselines.trials import COUNTS, PERIOD, STIFFNESS, trial

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


Q = 2.0 * pi / COUNTS


@pytest.mark.parametrize(
    ("rounding", "offset", "counts", "shown"),
    [
        ("floor", 0.0, -1.3, -2.0),
        ("floor", 0.0, 0.9, 0.0),
        ("floor", 0.25, 0.2, -0.75),
        ("nearest", 0.0, -1.3, -1.0),
        ("nearest", 0.0, -1.6, -2.0),
        ("nearest", 0.25, -0.2, 0.25),
        ("ceil", 0.0, -1.3, -1.0),
        ("ceil", 0.5, 0.6, 1.5),
        ("truncate", 0.0, -1.9, -1.0),
        ("truncate", 0.0, 1.9, 1.0),
        ("truncate", 0.2, -0.7, 0.2),
    ],
)
def test_roundings(rounding: str, offset: float, counts: float, shown: float) -> None:
    controller = Controller(trial(encoder=Encoder(rounding, offset)))
    assert controller.measured(counts * Q) == pytest.approx(shown * Q, abs=1e-15)
    low, high = controller.edges(controller.level(counts * Q))
    assert low < counts * Q < high
    for inner in (low + 1e-9, high - 1e-9):
        assert controller.measured(inner) == pytest.approx(shown * Q, abs=1e-15)
    for outer in (low - 1e-9, high + 1e-9):
        assert controller.measured(outer) != pytest.approx(shown * Q, abs=1e-15)


def test_continuous_sensor_reports_the_angle() -> None:
    assert Controller(trial(encoder=None)).measured(-0.0123) == -0.0123


def test_virtual_damping_differences_the_measured_angle() -> None:
    controller = Controller(trial(wall=Wall(STIFFNESS, 1e-4), encoder=None))
    assert controller.command(-0.01) == pytest.approx(STIFFNESS * 0.01)  # the first sample has none before it
    assert controller.command(0.02) == 0.0
    assert controller.command(-0.01) == pytest.approx(STIFFNESS * 0.01 + 1e-4 * 0.03 / PERIOD)


def test_step_before_limit() -> None:
    controller = Controller(trial(encoder=None, actuator=Actuator(torque_step=0.4, torque_limit=0.5)))
    assert controller.command(-0.19 / STIFFNESS) == 0.0
    assert controller.command(-0.21 / STIFFNESS) == 0.4
    assert controller.command(-0.61 / STIFFNESS) == 0.5


@pytest.mark.parametrize(
    ("delay", "expected"),
    [
        (0.0, [[(1, 1.0)], [(2, 1.0)], [(3, 1.0)]]),
        (1.0, [[(0, 1.0)], [(1, 1.0)], [(2, 1.0)]]),
        (0.25, [[(0, 0.25), (1, 0.75)], [(1, 0.25), (2, 0.75)], [(2, 0.25), (3, 0.75)]]),
        (2.5, [[(0, 0.5), (0, 0.5)], [(0, 0.5), (0, 0.5)], [(0, 0.5), (1, 0.5)]]),
    ],
)
def test_delay_holds_commands_back(delay: float, expected: list) -> None:
    controller = Controller(trial(encoder=None, actuator=Actuator(delay)))
    for number, pieces in enumerate(expected):
        found = controller.sample(-(number + 1) / STIFFNESS)
        assert [command for command, _ in found] == pytest.approx([command for command, _ in pieces])
        assert [duration / PERIOD for _, duration in found] == pytest.approx([part for _, part in pieces])
