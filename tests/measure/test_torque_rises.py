"""Rises of the wall's torque, against pulses whose number is known."""

import numpy as np
import pytest

from hknob_cli.measure.torque_rises import torque_rises_hz


@pytest.mark.parametrize("cycle_s", [0.004, 0.0125])
def test_one_pulse_a_cycle(cycle_s: float) -> None:
    """Sampled at 4 kHz, the first and the last rise are each late by less than a sample."""
    time = np.arange(0.0, 1.0, 0.25e-3)
    torque = np.where((time + 1e-9) % cycle_s < 0.3 * cycle_s, 1e-3, 0.0)
    found = torque_rises_hz(time, torque)
    assert found == pytest.approx(1.0 / cycle_s, rel=2 * 0.25e-3 / 0.9)


def test_a_step_more_is_a_rise_more() -> None:
    time = np.arange(8.0)
    assert torque_rises_hz(time, np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0])) == pytest.approx(4.0 / 6.0)


@pytest.mark.parametrize("torque", [[0.0] * 5, [1.0] * 5, [0.0, 1.0, 1.0, 0.0, 0.0], [], [1.0]])
def test_fewer_than_two_rises_have_no_pitch(torque: list[float]) -> None:
    assert torque_rises_hz(np.arange(float(len(torque))), np.array(torque)) == 0.0
