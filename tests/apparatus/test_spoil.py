"""Bad recordings: each has one thing wrong, and the trial it came from is left as it was."""

import numpy as np
import pytest

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.recordings.trial import Trial
from tests.apparatus import spoil

COLUMNS = ("time_s", "torque_nm", "angle_rad", "grip_n", "measured_torque_nm")
CHANGED = {
    spoil.drop_samples: set(COLUMNS),
    spoil.freeze_angle: {"angle_rad"},
    spoil.saturate_angle: {"angle_rad"},
    spoil.reverse_torque: {"torque_nm"},
    spoil.silence: {"torque_nm", "angle_rad"},
    spoil.lose_motion: {"angle_rad"},
    spoil.angle_in_degrees: {"angle_rad"},
    spoil.torque_in_millis: {"torque_nm"},
    spoil.time_in_millis: {"time_s"},
    spoil.swap_columns: {"torque_nm", "angle_rad"},
    spoil.not_a_number: {"angle_rad"},
    spoil.reverse_time: {"time_s"},
}


@pytest.fixture
def trial() -> Trial:
    return record_experiments(Rig(torque_noise_nm=1e-5), Schedule([1], subjects=1, blocks=1, trials=1))[2]


@pytest.mark.parametrize("fault", CHANGED, ids=lambda fault: fault.__name__)
def test_one_thing_is_wrong(fault, trial: Trial) -> None:
    before = [getattr(trial, name).copy() for name in COLUMNS]
    bad = fault(trial)
    changed = {name for name in COLUMNS if not np.array_equal(getattr(bad, name), getattr(trial, name))}
    assert changed == CHANGED[fault]
    assert bad.key == trial.key
    assert len({len(getattr(bad, name)) for name in COLUMNS}) == 1
    assert all(np.array_equal(old, getattr(trial, name)) for old, name in zip(before, COLUMNS, strict=True))


def test_what_is_wrong(trial: Trial) -> None:
    assert np.diff(spoil.drop_samples(trial).time_s).max() == pytest.approx(21e-4)
    assert np.ptp(spoil.freeze_angle(trial).angle_rad[100:120]) == 0.0
    assert np.ptp(spoil.saturate_angle(trial).angle_rad) < np.ptp(trial.angle_rad)
    assert np.isnan(spoil.not_a_number(trial, column="grip_n").grip_n).sum() == 1
    assert (np.diff(spoil.reverse_time(trial).time_s) < 0).sum() == 1
    assert np.ptp(spoil.angle_in_degrees(trial).angle_rad) > 3.0
