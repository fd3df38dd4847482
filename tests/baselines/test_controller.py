"""Encoder, command law and delay, by hand."""

from math import pi

import pytest

from hknob_cli.baselines.model import Controller
from hknob_cli.specs.plan import Actuator, Encoder, Wall
from tests.baselines.trials import COUNTS, PERIOD, STIFFNESS, trial

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
