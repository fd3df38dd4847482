"""Describing functions of a relay with hysteresis, against the textbook's balance and a matrix exponential."""

from itertools import product
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.theory.relay import Attached, Relay, RelayCycle, describing_function, tsypkin

# Plants from light to heavy, held and not; delays; half widths of the hysteresis per relay level.
CASES = [
    Relay(alpha, beta, 1.0, delay, turn=turn)
    for (alpha, beta), delay, turn in product([(0.15, 0.02), (0.02, 2e-4), (0.05, 0.0)], [0.5, 1.7], [0.1, 3.0, 40.0])
]


def only(cycles: list[RelayCycle]) -> RelayCycle:
    """The one cycle that there is."""
    (cycle,) = cycles
    return cycle


@pytest.mark.parametrize("relay", CASES)
def test_one_harmonic_balances_the_textbooks_describing_function(relay: Relay) -> None:
    """N(A) G e^(-s delay) = -1, N = 4 / (pi A) (sqrt(1 - (d/A)^2) - j d/A): Gelb & Vander Velde 1968."""
    cycle = only(describing_function(relay, 1))
    s, share = 1j * cycle.omega, relay.turn / cycle.amplitude
    plant = np.exp(-s * relay.delay) / (s * s + relay.alpha * s + relay.beta)
    gain = 4.0 / (pi * cycle.amplitude) * (sqrt(1.0 - share**2) - 1j * share)
    assert gain * plant == pytest.approx(-1.0, abs=1e-9)


def test_the_textbooks_describing_function_is_the_fundamental_of_two_switches_a_turn() -> None:
    phase = np.linspace(0.0, 2.0 * pi, 400_000, endpoint=False)
    x = 2.0 * np.sin(phase)
    on, shown = -1.0, np.zeros_like(x)
    for _ in range(2):  # the first turn only sets the relay
        for i, at in enumerate(x):
            on = 1.0 if at >= 0.7 else -1.0 if at < -0.7 else on
            shown[i] = on
    fundamental = 2.0 * (shown * np.exp(-1j * phase)).mean() * 1j / 2.0
    assert fundamental == pytest.approx(4.0 / (2.0 * pi) * (sqrt(1 - 0.35**2) - 0.35j), abs=2e-5)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("relay", CASES)
def test_all_harmonics_are_a_cycle_by_a_matrix_exponential(relay: Relay) -> None:
    """The state half a turn later is the opposite one, and the knob passes the switch the delay before the torque."""
    cycle = only(tsypkin(relay))
    half = pi / cycle.omega
    a = np.array([[0.0, 1.0, 0.0], [-relay.beta, -relay.alpha, 1.0], [0.0, 0.0, 0.0]])

    def moved(state: Any, t: float, torque: float) -> Any:
        return (expm(a * t) @ np.array([*state, torque]))[:2]

    start = np.linalg.solve(np.eye(2) + expm(a * half)[:2, :2], -expm(a * half)[:2, 2])  # the torque turns outward
    assert moved(start, half, 1.0) == pytest.approx(-start, rel=1e-9, abs=1e-9)
    late = relay.delay % half
    turned = moved(start, half - late, 1.0) if relay.delay < half else moved(-start, half - late, -1.0)
    assert turned[0] == pytest.approx(relay.turn, rel=1e-7, abs=1e-9 * cycle.amplitude)
    assert turned[1] > 0.0
    times = np.linspace(0.0, half, 2001)
    wave = np.array([moved(start, float(t), 1.0)[0] for t in times])
    assert cycle.amplitude == pytest.approx(np.abs(wave).max(), rel=1e-5)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("relay", CASES)
def test_many_harmonics_come_near_to_all(relay: Relay) -> None:
    many, every = only(describing_function(relay, 200)), only(tsypkin(relay))
    assert many.omega == pytest.approx(every.omega, rel=2e-4)
    assert many.amplitude == pytest.approx(every.amplitude, rel=1e-3)


def test_a_finger_and_a_lag_stand_beside_it() -> None:
    """One harmonic of a knob with a finger behind its pad and a late torque, from their own equations."""
    more = Attached(ratio=6.0, pad_damping=0.1, pad_stiffness=0.01, finger_damping=0.4, finger_stiffness=0.06, lag=3.0)
    relay = Relay(0.03, 0.0, 1.0, 0.5, more, 2.0)
    cycle = only(describing_function(relay, 1))
    s = 1j * cycle.omega
    # Knob x, finger y: s^2 x + a s x + (c + p s)(x - y) = u; s^2 y / r + (f s + g) y / r = (c + p s)(x - y).
    pad = more.pad_stiffness + more.pad_damping * s
    own = (s * s + more.finger_damping * s + more.finger_stiffness) / more.ratio
    x = np.linalg.solve(np.array([[s * s + relay.alpha * s + pad, -pad], [-pad, own + pad]]), np.array([1.0, 0.0]))[0]
    plant = x * more.lag / (more.lag + s) * np.exp(-0.5 * s)
    share = relay.turn / cycle.amplitude
    gain = 4.0 / (pi * cycle.amplitude) * (sqrt(1.0 - share**2) - 1j * share)
    assert gain * plant == pytest.approx(-1.0, abs=1e-9)
