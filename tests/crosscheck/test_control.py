"""The linear part of the fourth-order scene against python-control: step, free motion, frequency response.

Without a wall the bias is a step of torque. python-control has the network as transfer functions put together, not as
the state equations that the engine starts from.
"""

from typing import Any

import control
import numpy as np
import pytest

from hknob_cli.scene.general_knob import Trial, simulate
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import HEAVY, KNOB, RINGING, STIFF, TWO_PARTS

HANDS = {"two parts": TWO_PARTS, "ringing": RINGING, "stiff": STIFF, "heavy": HEAVY}
RATE_HZ = 2000.0
BIAS = 0.001
WITHIN = 1e-9  # python-control's state-space realisation of a transfer function loses some six digits


def network(hand: dict[str, Any]) -> control.TransferFunction:
    """Angle per torque of the knob: its own impedance, in parallel with the fingerpad's in series with the finger's."""
    finger, pad = hand["finger"], hand["fingerpad"]
    s = control.tf("s")
    alone = KNOB["inertia"] * s**2 + KNOB["damping"] * s
    held = finger["inertia"] * s**2 + finger.get("damping", 0.0) * s + finger.get("stiffness", 0.0)
    between = pad.get("damping", 0.0) * s + pad.get("stiffness", 0.0)
    # between * held / (between + held) is the impedance that the knob feels.
    numerator = (between + held).num[0][0]
    denominator = (alone * (between + held) + between * held).num[0][0]
    return control.tf(numerator, denominator)


def run(hand: dict[str, Any], samples: int, *, velocity: float = 0.0, bias: float = BIAS) -> Trial:
    """The engine without a wall, its first sample one period after the start."""
    scene = {"knob": dict(KNOB), "hand": hand, "wall": {"stiffness": 0.0}, "bias": {"torque": bias}}
    return simulate(
        SceneSpec.model_validate(scene).plain(),
        sample_rate_hz=RATE_HZ,
        counts_per_rev=1024,
        angle_rad=0.0,
        velocity_rad_s=velocity,
        phase=1.0,
        samples=samples - 1,
    )


@pytest.mark.parametrize("hand", HANDS.values(), ids=HANDS)
def test_step(hand: dict[str, Any]) -> None:
    times = np.arange(201) / RATE_HZ
    expected = np.asarray(control.step_response(network(hand), times).outputs) * -BIAS
    assert run(hand, 200).angle_rad == pytest.approx(expected[1:], rel=0, abs=WITHIN * np.abs(expected).max())


@pytest.mark.parametrize("hand", HANDS.values(), ids=HANDS)
def test_free_motion(hand: dict[str, Any]) -> None:
    """Knob and finger start together: the response to an impulse on both."""
    finger, pad = hand["finger"], hand["fingerpad"]
    s = control.tf("s")
    b1, k1, j1 = finger.get("damping", 0.0), finger.get("stiffness", 0.0), finger["inertia"]
    b2, k2 = pad.get("damping", 0.0), pad.get("stiffness", 0.0)
    # An impulse J1 on the finger reaches the knob through the pad.
    knob = network(hand)
    across = (b2 * s + k2) * j1 + KNOB["inertia"] * ((j1 * s**2 + b1 * s + k1) + b2 * s + k2)
    both = control.tf(across.num[0][0], knob.den[0][0])
    times = np.arange(201) / RATE_HZ
    expected = np.asarray(control.impulse_response(both, times).outputs)
    got = run(hand, 200, velocity=1.0, bias=0.0).angle_rad
    assert got == pytest.approx(expected[1:], rel=0, abs=WITHIN * np.abs(expected).max())


@pytest.mark.parametrize("hand", [TWO_PARTS, RINGING, STIFF], ids=["two parts", "ringing", "stiff"])
def test_frequency_response(hand: dict[str, Any]) -> None:
    """Of the knob behind a hold: (1 - 1/z) times the z-transform of the step response."""
    samples = 10_000  # the slowest mode of these hands has then decayed
    angle = np.concatenate([[0.0], run(hand, samples).angle_rad]) / -BIAS
    steps = np.diff(angle)
    assert np.abs(steps[-20:]).max() < 1e-11 * np.abs(angle).max()
    radians = 2 * np.pi * np.geomspace(1.0, 0.4 * RATE_HZ, 40) / RATE_HZ
    got = np.array([np.sum(steps * np.exp(-1j * w * np.arange(1, samples + 1))) for w in radians])
    held = control.sample_system(control.ss(network(hand)), 1 / RATE_HZ, method="zoh")
    expected = held(np.exp(1j * radians))
    assert np.abs(got - expected).max() < 1e-8 * np.abs(expected).max()
