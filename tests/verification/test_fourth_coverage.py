"""Stated 95 % intervals of finger and pad hold the truth as often as they say, wherever one is called identifiable.

Truths drawn like those of Section 4.4.1: the lightest or firmest grip of Table 1, K1/K2 from 1 to 20, B1/B2 equal to it
or up to 3 times off, noise from a fine encoder's to a coarse one's, the knob's inertia known or fitted. The intervals
are conservative where the valley bends (`nearest.spread`). Of 90 at 95 % the share that holds the truth has a standard
deviation of 2.3 %: it is above 89 % unless it is 2.6 of them off, or the intervals are not what they say.
"""

import numpy as np
import pytest

from hknob_cli.identify.fourth_order import FINGER_INERTIA, ORDER, fourth_order, respond_fourth
from hknob_cli.identify.motion import Motion
from tests.identify.pulses import FIRM, LIGHT, pulse

KNOB = 1.98e-6
TRIALS = 30
TORQUE = pulse(600, 20, 200, 1.0)


def drawn(rng: np.random.Generator) -> tuple[dict[str, float], float, bool]:
    """A hand in parts, the noise in rad, and whether the knob's inertia is known."""
    _, damping, stiffness = (LIGHT, FIRM)[rng.integers(2)]
    springs = 20.0 ** rng.uniform()
    dampers = springs * (3.0 ** rng.uniform(-1.0, 1.0) if rng.integers(2) else 1.0)
    values = (
        KNOB,
        FINGER_INERTIA,
        (1.0 + dampers) * damping,
        (1.0 + springs) * stiffness,
        (1.0 + dampers) / dampers * damping,
        (1.0 + springs) / springs * stiffness,
    )
    return dict(zip(ORDER, values, strict=True)), 2e-6 * 50.0 ** rng.uniform(), bool(rng.integers(2))


@pytest.mark.long
def test_intervals_hold_the_truth() -> None:
    rng = np.random.default_rng(11)
    held, told, asked = 0, 0, 0
    for _ in range(TRIALS):
        parts, noise, known = drawn(rng)
        shape = respond_fourth(parts, TORQUE, 1e-4)
        scale = 0.08 / shape.max()
        angle = scale * shape + noise * rng.normal(size=len(shape))
        fit = fourth_order(Motion(1e-4, scale * TORQUE, angle, noise_rad=noise), inertia=KNOB if known else None)
        for name, one in fit.parameters.items():
            asked += 1
            if one.identifiable:
                told += 1
                held += abs(one.value - parts[name]) <= 1.96 * one.std
    print(f"{held} of {told} told, of {asked}")
    assert told >= 70  # the share is of something
    assert told < asked  # and what the data cannot tell is not claimed
    assert held >= 0.89 * told
