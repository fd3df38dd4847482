"""A converter that steps the torque moves the knob as one that steps the angle (experiments/converter.yaml)."""

from math import pi

import numpy as np
import pandas as pd
import pytest

from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.record import record_sweep
from tests.conftest import EXPERIMENTS

STIFFNESS = 0.27
RECORD = ("starts.phases=2", "record={duration: 0.04, interval: 2.0e-4, trials: 2}")


def recorded(*overrides: str) -> pd.DataFrame:
    """Angles at the times that both recordings have: those of the interval."""
    found = record_sweep(load(EXPERIMENTS / "converter.yaml", (*RECORD, *overrides))).to_pandas()
    return found[found.event == ""]


@pytest.mark.parametrize(("rate", "counts"), [(464.1588833612779, 512), (1000.0, 256), (2154.4346900318843, 1024)])
def test_torque_steps_move_the_knob_as_angle_steps_do(rate: float, counts: int) -> None:
    """A D/A step of K q behind a continuous sensor, and q of the angle: equal to the rounding of 200 intervals."""
    step = STIFFNESS * 2.0 * pi / counts
    angle = recorded(f"grid={{sample_rate_hz: {rate!r}, counts_per_rev: {counts}}}")
    torque = recorded(
        f"grid={{sample_rate_hz: {rate!r}}}", "scene.encoder=none", f"scene.actuator={{torque_step: {step!r}}}"
    )
    assert len(angle) > 300
    np.testing.assert_allclose(torque.time_s, angle.time_s, rtol=1e-12)
    assert angle.torque_nm.nunique() > 1  # it met the wall
    np.testing.assert_allclose(torque.angle_rad, angle.angle_rad, rtol=0.0, atol=1e-12)
