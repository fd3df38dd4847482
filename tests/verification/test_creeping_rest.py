"""A knob that creeps for ever, called at rest: at 60 digits it keeps its reading, and ends where the package says.

The motion is run on at 60 digits from the start of a trial. A knob that creeps has no last sample. Its distance from
its end falls by the slowest mode of its sliding, so that after 40 of its time constants it is below rounding.
"""

import random
from math import sqrt
from typing import Any

import pytest

from hknob_cli.engine.attractors import Patience
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.outcome import Outcome
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.scene import SceneSpec

from . import general_reference as reference

TIRELESS = Patience(samples=10**9)
SAMPLES = 400


def firm(seed: int) -> tuple[dict[str, Any], float, int | None]:
    """An overdamped hand, with friction, whose slowest mode ends within a few hundred samples."""
    draw = random.Random(seed)
    inertia, stiffness = 10.0 ** draw.uniform(-6.0, -5.3), 10.0 ** draw.uniform(-1.0, 0.5)
    ratio = draw.uniform(1.02, 3.0)
    damping = 2.0 * ratio * sqrt(inertia * stiffness)
    slowest = stiffness / damping
    scene: dict[str, Any] = {
        "knob": {"inertia": inertia, "coulomb_torque": 10.0 ** draw.uniform(-3.7, -2.7)},
        "hand": {"damping": damping, "stiffness": stiffness},
        "wall": {"stiffness": 10.0 ** draw.uniform(-1.5, -0.5)},
        "bias": {"torque": 10.0 ** draw.uniform(-3.5, -2.7)},
    }
    if seed % 3 == 0:
        scene["encoder"] = "none"
    return scene, slowest * draw.uniform(4.0, 8.0), None if seed % 3 == 0 else 2 ** draw.randint(9, 13)


@pytest.mark.parametrize("seed", range(12))
def test_a_creeping_knob_keeps_its_reading_at_60_digits(seed: int) -> None:
    scene, rate_hz, counts = firm(seed)
    knob = sample_general(SceneSpec.model_validate(scene).plain(), sample_rate_hz=rate_hz, counts_per_rev=counts)
    (one, *others) = (
        GeneralEngine(patience=TIRELESS)
        .search(
            knob.body,
            knob.wall,
            knob.start(0.02, 0.0),
            rate=knob.rate,
            phases=1,
            delay_line=knob.delay_line,
            max_samples=None,
        )
        .attractors
    )
    assert not others
    trial = reference.simulate(
        scene,
        sample_rate_hz=rate_hz,
        counts_per_rev=counts,
        angle_rad=0.02,
        velocity_rad_s=0.0,
        phase=0.5,
        samples=SAMPLES,
    )
    tail = trial.samples[-SAMPLES // 4 :]
    readings = {trial.control.measured(sample.angle) for sample in tail}
    moves = float(max(s.angle for s in tail) - min(s.angle for s in tail))
    if one.outcome is Outcome.REST:
        assert one.certified
        assert counts is None or len(readings) == 1
        assert moves <= 1e-9 * knob.quantum_rad
        # To rounding: of some positions, and of the end's own torques over the stiffness.
        assert abs(float(tail[-1].angle) - knob.angle_rad(one.x)) <= 1e-9 * knob.quantum_rad
    else:
        assert one.outcome is Outcome.CYCLE
        assert moves > 1e-6 * knob.quantum_rad
