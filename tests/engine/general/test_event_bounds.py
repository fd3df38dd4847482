"""The bounds that keep a slide, or a hold, from stepping over its end: against the motion by matrix exponentials.

No motion exceeds them, and some come within a few times of them.
"""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general.body import HELD, RATES, Body, rate_of
from hknob_cli.engine.general.slide_many import held_bound, sliding_bound
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import HEAVY, LIGHT, STIFF, TWO_PARTS, scene

LAG = {"time_constant": 2e-4}
MOTOR = {"winding": "shorted", "torque_constant": 0.02, "resistance": 2.0, "inductance": 1e-3}
SCENES = {
    "two parts": scene(knob=LIGHT, hand=TWO_PARTS),
    "heavy finger": scene(knob=LIGHT, hand=HEAVY),
    "stiff finger": scene(knob=LIGHT, hand=STIFF),
    "lag": scene(knob=LIGHT, actuator=LAG),
    "lag, two parts": scene(knob=LIGHT, hand=TWO_PARTS, actuator=LAG),
    "coil": scene(knob=LIGHT, motor=MOTOR),
    "coil, two parts": scene(knob=LIGHT, hand=TWO_PARTS, motor=MOTOR),
}
TIMES = np.concatenate([[0.0], np.geomspace(1e-3, 30.0, 200)])  # sample periods


def body_of(parts: Any) -> Body:
    plan = reduced(SceneSpec.model_validate(parts).plain())
    return sample_general(plan, sample_rate_hz=1000.0, counts_per_rev=1024).body


def shares(name: str, mode: int) -> list[float]:
    """Of random states: the largest second derivative of velocity, or held torque, from then on, over its bound."""
    body = body_of(SCENES[name])
    n = body.order

    def matrix(which: int) -> Any:
        return np.array(body.matrices[which * n * n : (which + 1) * n * n]).reshape(n, n)

    rates, moves = matrix(RATES), matrix(RATES if mode else HELD)
    later = [moves @ expm(moves * time) for time in TIMES]
    found = []
    for draw in np.random.default_rng(7).normal(size=(400, n)) * 10.0 ** np.random.default_rng(8).uniform(
        -2, 2, (400, n)
    ):
        z, pad = draw.tolist(), [0.0] * (4 * n + 8)
        if mode == 0:
            z[1] = 0.0
        rate_of(z, 0.3, mode, body, pad)
        rate = np.array(pad[:n])
        bound = held_bound(pad, body) if mode == 0 else sliding_bound(pad, 0, body)
        bent = np.array([one @ rate for one in later])
        most = np.abs(bent @ rates[1]).max() if mode == 0 else np.abs(bent[:, 1]).max()
        found.append(most / bound)
    return found


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("mode", [-1, 0, 1])
def test_nothing_bends_more_than_its_bound(name: str, mode: int) -> None:
    found = shares(name, mode)
    assert max(found) <= 1.0 + 1e-9
    assert max(found) >= 0.25
