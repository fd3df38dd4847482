"""Tests of `theory.relay`: the crossing of the Nyquist curve, and what is attached, against quadrature."""

import cmath
from math import pi

import numpy as np
import pytest

from hknob_cli.scene.general_knob import sample_general
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Finger, Fingerpad, Hand, Knob, Scene, Wall
from hknob_cli.theory.relay import Attached, Relay, attached_to, crossing, describing_function, plant_curve, response
from tests.conftest import loaded


@pytest.mark.parametrize("rate_hz", [100.0, 1000.0, 10000.0])
def test_the_crossing_is_on_the_curve_and_on_the_ray(rate_hz: float) -> None:
    scene = loaded().scene
    knob = sample_knob(scene, sample_rate_hz=rate_hz, counts_per_rev=1024)
    found = crossing(knob)
    assert found is not None
    inertia, damping = scene.knob.inertia + scene.hand.inertia, scene.hand.damping
    direct = 1.0 / (scene.hand.stiffness - inertia * found.omega**2 + 1j * damping * found.omega)
    assert found.point == pytest.approx(direct, rel=1e-9)
    assert complex(plant_curve(knob, np.array([found.omega]))[0]) == pytest.approx(direct, rel=1e-9)
    # Half a sample of delay turns the negative real axis counter-clockwise, in the plane where G's phase is negative.
    assert cmath.phase(-found.point) == pytest.approx(0.5 * found.omega / rate_hz, rel=1e-9)
    assert found.frequency_hz == pytest.approx(found.omega / (2.0 * pi))


def test_the_amplitude_is_that_of_a_relay_of_half_a_counts_torque() -> None:
    scene = loaded().scene
    found = crossing(sample_knob(scene, sample_rate_hz=1000.0, counts_per_rev=1024))
    assert found is not None
    level = 0.5 * scene.wall.stiffness * 2.0 * pi / 1024
    assert found.amplitude_rad == pytest.approx(4.0 * level / pi * abs(found.point), rel=1e-9)


PERIOD, COUNTS = 1e-3, 1024
FINGER, PAD = Finger(inertia=3e-7, damping=2e-3, stiffness=0.5), Fingerpad(damping=1e-3, stiffness=5.0)


def attached(*, finger: bool = False, lag: float = 0.0, friction: float = 0.0) -> Attached | None:
    hand = Hand(finger=FINGER, fingerpad=PAD) if finger else Hand(3e-7, 3.45e-4, 0.04)
    scene = Scene(
        knob=Knob(1.9e-6, 1e-4, friction),
        wall=Wall(0.27),
        hand=hand,
        bias=Bias(half_quantum=True),
        encoder=Encoder(),
        actuator=Actuator(time_constant=lag),
    )
    return attached_to(sample_general(scene, sample_rate_hz=1.0 / PERIOD, counts_per_rev=COUNTS).body)


def test_nothing_attached_is_nothing() -> None:
    assert attached() is None


@pytest.mark.parametrize("lag", [0.0, 4e-4])
def test_the_response_is_that_of_four_states_and_a_lag(lag: float) -> None:
    """In SI units: angle and velocity of knob and finger, and the torque behind the lag."""
    knob, damping = 1.9e-6, 1e-4
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-PAD.stiffness / knob, -(damping + PAD.damping) / knob, PAD.stiffness / knob, PAD.damping / knob],
            [0.0, 0.0, 0.0, 1.0],
            [PAD.stiffness, PAD.damping, -(PAD.stiffness + FINGER.stiffness), -(PAD.damping + FINGER.damping)],
        ]
    )
    matrix[3] /= FINGER.inertia
    found = attached(finger=True, lag=lag)
    relay = Relay(damping * PERIOD / knob, 0.0, 1.0, 0.75, found)
    omegas = np.array([0.01, 0.3, 1.0, 2.5])
    for omega, value in zip(omegas, response(relay, omegas), strict=True):
        s = 1j * omega / PERIOD
        angle = np.linalg.solve(s * np.eye(4) - matrix, [0.0, 1.0 / knob, 0.0, 0.0])[0]
        late = np.exp(-0.75j * omega) / (1.0 + s * lag)
        assert value == pytest.approx(angle * late * knob / PERIOD**2, rel=1e-10)


def test_friction_s_torque_by_quadrature() -> None:
    """First Fourier coefficient of -F sign(v) over a sine: 4 F/pi, a quarter of a turn behind -x."""
    phase = (np.arange(4096) + 0.5) * 2.0 * pi / 4096
    torque = -np.sign(np.cos(phase))
    coefficient = 2.0 * np.mean(torque * np.sin(phase)) + 2.0j * np.mean(torque * np.cos(phase))
    assert coefficient == pytest.approx(-4.0j / pi, abs=1e-6)
    bare = Relay(0.1, 0.05, 1.0, 0.5)
    rough = bare._replace(attached=Attached(friction=0.2))
    omega = np.array([0.7])
    plant = response(bare._replace(delay=0.0), omega)
    # response() is over 4/pi and the sign of the relay: the part that friction adds to it is 0.2 of the coefficient's.
    added = response(rough, omega) - response(bare, omega)
    assert complex(added[0] / plant[0]) == pytest.approx(-0.2 * pi / 4.0 * coefficient)


def test_the_cycle_of_one_harmonic_balances_in_time() -> None:
    """The fundamental of the torques of relay and friction, by quadrature, drives the plant through that very sine."""
    relay = Relay(0.16, 0.018, 1.0, 0.5, Attached(friction=0.1, lag=2.0))
    (cycle,) = describing_function(relay, 1)
    phase = (np.arange(1 << 16) + 0.5) * 2.0 * pi / (1 << 16)
    s = 1j * cycle.omega
    late = np.exp(-0.5 * s) * 2.0 / (2.0 + s)
    wall = -np.sign(np.sin(phase + np.angle(late))) * abs(late)
    torque = wall - 0.1 * np.sign(np.cos(phase))
    fundamental = 2.0 * np.mean(torque * np.sin(phase)) + 2.0j * np.mean(torque * np.cos(phase))
    held = s * s + 0.16 * s + 0.018
    assert held * cycle.amplitude == pytest.approx(fundamental, rel=1e-4)


@pytest.mark.parametrize("friction", [1e-3, 0.05, 0.1])
def test_friction_makes_the_cycle_smaller_and_faster(friction: float) -> None:
    relay = Relay(0.16, 0.018, 1.0, 0.5)
    (bare,) = describing_function(relay, 1)
    (rough,) = describing_function(relay._replace(attached=Attached(friction=friction)), 1)
    assert rough.amplitude < bare.amplitude
    assert rough.omega > bare.omega
    assert abs(rough.amplitude / bare.amplitude - 1.0) < 12.0 * friction


def test_a_stiff_pad_makes_finger_and_knob_one_body() -> None:
    """As the pad stiffens, the cycle becomes that of the sum of the inertias."""
    one = Relay(0.16 / 1.5, 0.018 / 1.5, 1.0 / 1.5, 0.5)
    finger = {"ratio": 2.0, "finger_damping": 0.0, "finger_stiffness": 0.036}
    (whole,) = describing_function(one, 2)
    stiff = Attached(pad_stiffness=1e5, pad_damping=0.0, **finger)
    (split,) = describing_function(Relay(0.16, 0.0, 1.0, 0.5, stiff), 2)
    assert split.omega == pytest.approx(whole.omega, rel=1e-3)
    assert split.amplitude == pytest.approx(whole.amplitude, rel=1e-3)
