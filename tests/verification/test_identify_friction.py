"""A pulse through a lag and against friction: the exact motion of the estimators against 40 digits.

The model here moves knob and torque together by mpmath's matrix exponential, looks eight times a sample for a turn or
a release, and bisects for its instant. It shares no formula with the package.
"""

from typing import Any

import numpy as np
import pytest
from mpmath import mp

from hknob_cli.identify.second_order import Plant, respond
from tests.identify.pulses import FIRM, LIGHT, pulse

DT = 1e-4
LOOKS, HALVINGS, DIGITS = 8, 90, 40
# Some 64 roundings a sample add up over at most 240 samples; seen: 5e-15.
BOUND = 240 * 64 * 2.0**-53


def of_torque(plant: Plant, torque: np.ndarray, lag: float) -> np.ndarray:
    """Angle (n,) rad at the samples, of a knob from rest whose torque follows the command by a lag s.

    Without a lag the torque runs straight from sample to sample.
    """
    inertia, damping, stiffness, coulomb = (mp.mpf(one) for one in plant)
    dt = mp.mpf(DT)

    def matrix(way: int) -> Any:
        """Of angle, speed, torque, command and 1."""
        pull = [-stiffness / inertia, -damping / inertia, 1 / inertia, mp.zero, -way * coulomb / inertia]
        moves = [mp.zero, mp.one, mp.zero, mp.zero, mp.zero] if way else [mp.zero] * 5
        fall = (
            [mp.zero, mp.zero, -1 / mp.mpf(lag), 1 / mp.mpf(lag), mp.zero] if lag else [mp.zero] * 3 + [1 / dt, mp.zero]
        )
        return mp.matrix([moves, pull if way else [mp.zero] * 5, fall, [mp.zero] * 5, [mp.zero] * 5])

    matrices = {way: matrix(way) for way in (-1, 0, 1)}
    step = dt / LOOKS
    usual = {way: mp.expm(one * step) for way, one in matrices.items()}

    def ends(state: Any, way: int) -> bool:
        """Whether it no longer moves as it did: turned, or come loose."""
        return state[1] * way < 0 if way else abs(state[2] - stiffness * state[0]) > coulomb

    def advance(state: Any, way: int, time: Any) -> Any:
        return (usual[way] if time == step else mp.expm(matrices[way] * time)) * state

    state, way, found = mp.matrix([0, 0, 0, 0, 1]), 0, np.zeros(len(torque))
    for i, command in enumerate(torque):
        found[i] = float(state[0])
        state[3] = mp.mpf(float(command))
        if not lag:
            state[2], state[3] = state[3], mp.mpf(float(torque[min(i + 1, len(torque) - 1)])) - state[3]
        for _ in range(LOOKS):
            left = step
            while left > 0:
                then = advance(state, way, left)
                if not ends(then, way):
                    state, left = then, mp.zero
                    continue
                low, high = mp.zero, left
                for _ in range(HALVINGS):
                    middle = (low + high) / 2
                    low, high = (low, middle) if ends(advance(state, way, middle), way) else (middle, high)
                state, left = advance(state, way, high), left - high
                state[1] = mp.zero
                drive = state[2] - stiffness * state[0]
                way = int(mp.sign(drive)) if abs(drive) > coulomb else 0
    return found


def steps(numbers: np.random.Generator, count: int = 60) -> np.ndarray:
    """A torque that jumps every few samples, N·m."""
    return np.repeat(numbers.uniform(-0.02, 0.02, count // 5), 5)


CASES = [
    *((hand, coulomb, lag) for hand in (LIGHT, FIRM) for coulomb in (5.6e-4, 3e-3) for lag in (2e-5, 5e-5, 1e-3)),
    ((2e-6, 0.0, 0.05), 2e-3, 3e-4),
]


@pytest.mark.one_in(15)
@pytest.mark.parametrize(("hand", "coulomb", "lag"), CASES)
def test_a_pulse_through_a_lag_against_friction_is_that_of_forty_digits(hand: Any, coulomb: float, lag: float) -> None:
    with mp.workdps(DIGITS):
        plant, torque = Plant(*hand, coulomb), pulse(240, 5, 90)
        true = of_torque(plant, torque, lag)
    ours = respond(plant, torque, DT, lag_s=lag)
    assert np.max(np.abs(true)) > 0.0
    assert np.max(np.abs(ours - true)) <= BOUND * np.max(np.abs(true))


@pytest.mark.one_in(27)
@pytest.mark.parametrize("seed", range(24))
def test_jumps_through_a_lag_against_friction_are_those_of_forty_digits(seed: int) -> None:
    """Turns, stops and releases within a sample, many of them; lags from a fifth of a sample to thirty of them."""
    numbers = np.random.default_rng(seed)
    hand = (2e-6, 10.0 ** numbers.uniform(-5.0, -2.5), 10.0 ** numbers.uniform(-2.0, 0.0))
    plant, lag = Plant(*hand, 10.0 ** numbers.uniform(-3.5, -1.9)), 10.0 ** numbers.uniform(-4.7, -2.5)
    torque = steps(numbers)
    with mp.workdps(DIGITS):
        true = of_torque(plant, torque, lag)
    ours = respond(plant, torque, DT, lag_s=lag)
    assert np.max(np.abs(ours - true)) <= BOUND * np.max(np.abs(true))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(6))
def test_straight_lines_against_friction_are_those_of_forty_digits(seed: int) -> None:
    """A line is the end of a decay of 1e-7 a sample, and its rounding 1e7 times as large: ten a sample; seen: 4e-9."""
    numbers = np.random.default_rng(100 + seed)
    hand = (2e-6, 10.0 ** numbers.uniform(-5.0, -2.5), 10.0 ** numbers.uniform(-2.0, 0.0))
    plant = Plant(*hand, 10.0 ** numbers.uniform(-3.5, -2.2))
    torque = np.interp(np.arange(60), np.arange(0, 61, 5), np.append(0.0, numbers.uniform(-0.02, 0.02, 12)))
    with mp.workdps(DIGITS):
        true = of_torque(plant, torque, 0.0)
    ours = respond(plant, torque, DT, ramps=True)
    assert np.max(np.abs(true)) > 0.0
    assert np.max(np.abs(ours - true)) <= (1e-7 + 60 * 10 * 1e7 * 2.0**-53) * np.max(np.abs(true))
