"""A recording with a torque pulse under a controller, against the 60-digit model of both.

Random scenes with three features or more beside each controller. The pulse starts with the recording, and ends within a
sample interval. Every sample of the recording is the model's, as far as no sample of the model comes so near to an edge
that rounding may decide.
"""

from typing import Any

import numpy as np
import pytest

from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.record import record_sweep
from tests import digits as mp

from .law_reference import simulate_law
from .law_scenes import Drawn
from .test_laws_in_the_general_loop import CLEAR, ORDER, WITHIN, scenes

SAMPLES = 40
START: dict[str, Any] = {"angle": 0.02, "velocity": -0.5}


def recorded(one: Drawn, pulse: dict[str, float]) -> list[dict[str, Any]]:
    """Rows of the recording of the first trial of a scene."""
    source = Source("spec.yaml")
    duration = (SAMPLES + 1) / one.rate_hz
    source.value = {
        "kind": "sweep",
        "name": "pulse",
        "scene": one.scene,
        "grid": {"sample_rate_hz": [one.rate_hz], "counts_per_rev": [one.counts]},
        "starts": {**START, "phases": 1},
        "record": {"duration": duration, "interval": duration / 7.0, "pulse": pulse},
    }
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    rows: list[dict[str, Any]] = record_sweep(plan).to_pylist()
    return rows


def check_pulse(one: Drawn, pulse: dict[str, float]) -> tuple[int, float]:
    """Samples that could be compared, and how far the pulse moved the knob by then [rad]."""
    rows = recorded(one, pulse)
    samples = [row for row in rows if row["event"] == "sample"]
    ends = [row["time_s"] for row in rows if row["event"] == "pulse ends"]
    assert ends == [pytest.approx(pulse["duration"], rel=1e-12)]
    quantum = 2.0 * np.pi / one.counts
    size = max(abs(row["angle_rad"]) for row in samples)
    model = simulate_law(one.scene, one.rate_hz, one.counts, **START, phase=0.5, pulse=pulse)
    other = simulate_law(one.scene, one.rate_hz, one.counts, **START, phase=0.5)
    moved = 0.0
    for i, row in enumerate(samples):
        theta, omega, clear = next(model)
        if clear < CLEAR:
            return i, moved
        moved = max(moved, abs(float(theta - next(other)[0])))
        assert abs(float(theta - mp.mpf(row["angle_rad"]))) <= WITHIN * (quantum + size), f"sample {i}: {one}"
        fastest = (quantum + size) * one.rate_hz
        assert abs(float(omega - mp.mpf(row["velocity_rad_s"]))) <= WITHIN * fastest, f"sample {i}: {one}"
    return len(samples), moved


def compare(controller: str, count: int, seed: int) -> None:
    """Random scenes of a controller, pushed either way for some samples."""
    found = []
    for k, one in enumerate(scenes(controller, count, seed)):
        torque = 0.01 if k % 2 else -0.006
        found.append(check_pulse(one, {"torque": torque, "duration": (0.3 + 2.9 * (k % 3)) / one.rate_hz}))
    assert any(samples > 10 and moved > 1e-3 for samples, moved in found), "nothing was tested"


@pytest.mark.one_in(16)
@pytest.mark.parametrize("controller", ORDER)
def test_every_sample_is_the_models(controller: str) -> None:
    compare(controller, 3, seed=21)
