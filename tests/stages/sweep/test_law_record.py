"""Tests of recordings under a controller in the general loop: the same motion as that which is searched."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.law_record import follow_law
from tests.conftest import SPEC, loaded

SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6, "coulomb_torque": 6e-5},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27, "damping": 1e-5},
    "bias": {"torque": 0.001},
    "actuator": {"delay_samples": 1.4, "time_constant": 1e-4},
    "controller": {"kind": "impulse_damping", "pulse": 0.3, "detections": 4},
}
FINGER = {
    "finger": {"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.5},
    "fingerpad": {"damping": 1e-3, "stiffness": 20.0},
}


@pytest.mark.parametrize("encoder", [{}, {"hysteresis_counts": 0.8}], ids=["", "hysteresis"])
@pytest.mark.parametrize("hand", [SCENE["hand"], FINGER], ids=["hand", "finger"])
def test_samples_are_those_of_the_search(hand: Any, encoder: Any) -> None:
    scene = {**SCENE, "hand": hand, "encoder": encoder}
    made = make_law(SceneSpec.model_validate(scene).plain(), sample_rate_hz=1000.0, counts_per_rev=512)
    knob, law = made.knob, made.law
    start, phase = knob.start(0.02, 0.0), 0.25
    points = [one for one in follow_law(made, start, phase=phase, until=60.0, every=0.5) if one.event == "sample"]
    z, pad, past = list(start), [0.0] * (2 * knob.body.order), [0.0] * len(law.beside)
    advance_span(z, 0.0, phase, knob.body, pad)
    begin_past(past, read(z[0], knob.wall), law)
    for point in points:
        assert point.state == pytest.approx(z, rel=1e-9, abs=1e-9)
        advance_with_law(z, past, knob.body, knob.wall, law, pad)
    assert len(points) == 60
    assert min(point.state[0] for point in points) < 0.0


def test_a_recording_of_a_sweep_has_the_parts_of_an_interval() -> None:
    text = SPEC.replace("{inertia: 1.9e-6}", "{inertia: 1.9e-6, coulomb_torque: 1e-4}", 1)
    text = text.replace("grid:", "  controller: {kind: impulse_damping, pulse: 0.25}\ngrid:", 1)
    plan = loaded(text + "record: {duration: 0.02, interval: 0.01}\n")
    from hknob_cli.stages.sweep.record import record_sweep

    rows = [row for row in record_sweep(plan).to_pylist() if row["trial"] == 0]
    at = {event: [row["time_s"] for row in rows if row["event"] == event] for event in ("sample", "command")}
    assert np.subtract(at["command"], at["sample"][: len(at["command"])]) == pytest.approx(0.25e-3, abs=1e-12)


def test_a_look_between_samples_is_no_row_of_its_own() -> None:
    speed = {"kind": "velocity_damping", "damping": 2e-4, "velocity": "timed", "detections": 8}
    scene = {key: value for key, value in SCENE.items() if key != "actuator"}
    made = make_law(
        SceneSpec.model_validate({**scene, "controller": speed}).plain(), sample_rate_hz=1000.0, counts_per_rev=512
    )
    points = list(follow_law(made, made.knob.start(0.02, 0.0), phase=0.25, until=10.0, every=0.5))
    assert made.law.pieces == 8
    assert [point.event for point in points].count("sample") == 10
    assert [point.event for point in points].count("") == 21  # those asked for: none where the encoder only looks
    assert len(points) == 31
