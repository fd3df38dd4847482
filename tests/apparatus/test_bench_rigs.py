"""Appendices A-C on the virtual rigs: what was put in comes out by the dissertation's own procedures."""

import numpy as np
import pytest

from hknob_cli.apparatus.experiment import (
    POSITIONS_M,
    cell_sensitivity,
    record_apparatus,
    record_grip_cell,
    record_motor_calibration,
    setups,
)
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.errors import UsageError


def test_torque_constants_and_friction_of_both_ranges() -> None:
    """Slopes of the mean of both directions, within five standard errors of a least-squares slope."""
    rows = record_motor_calibration(Rig(), seed=1)
    for index, constant in ((0, 26.4e-3), (1, 28.4e-3)):
        chosen = rows.range_index == index
        current, torque, way = rows.current_a[chosen], rows.torque_nm[chosen], rows.direction[chosen]
        error = 2e-5 / (np.sqrt(chosen.sum()) * current.std())
        assert np.polyfit(current, torque - way * 0.56e-3, 1)[0] == pytest.approx(constant, abs=5 * error)
        friction = 0.5 * (torque[way > 0].mean() - torque[way < 0].mean())
        assert friction == pytest.approx(0.56e-3, abs=5 * 2e-5 / np.sqrt(chosen.sum()))
        assert (constant * current).max() == pytest.approx(2e-3 if index == 0 else 30e-3)
    assert np.diff(rows.time_s[:10]) == pytest.approx(0.1)
    assert rows.angle_rad.max() < 3 * 2 * np.pi + 1e-9


def test_a_ripple_averages_out_over_whole_turns() -> None:
    still = record_motor_calibration(Rig(), noise_nm=0.0)
    rippled = record_motor_calibration(Rig(), noise_nm=0.0, ripple_nm=1e-3)
    assert np.abs(rippled.torque_nm - still.torque_nm).max() > 0.9e-3
    assert rippled.torque_nm.mean() == pytest.approx(still.torque_nm.mean(), abs=1e-9)


def test_the_grip_cells_coefficient_depends_on_where_it_is_pressed() -> None:
    rows = record_grip_cell(seed=2)
    slopes = {}
    for position in POSITIONS_M:
        chosen = rows.position_m == position
        force, voltage = rows.force_n[chosen], rows.voltage_v[chosen]
        error = 1e-3 / (np.sqrt(chosen.sum()) * force.std())
        slopes[position] = np.polyfit(force, voltage, 1)[0]
        assert slopes[position] == pytest.approx(cell_sensitivity(position), abs=5 * error)
    assert slopes[3.18e-3] / slopes[9.53e-3] == pytest.approx(1.9, rel=0.02)
    assert slopes[3.18e-3] > slopes[6.35e-3] > slopes[9.53e-3]
    with pytest.raises(UsageError, match="not on the grip cell's shell"):
        record_grip_cell(positions_m=[0.02])


def test_setups_are_those_of_table_10() -> None:
    found = setups()
    assert found["shaft"] == pytest.approx(12.0e-7)
    assert found["small_experimental"] == pytest.approx(19.8e-7)
    assert found["medium_experimental"] == pytest.approx(32.7e-7)
    assert len(found) == 7


def test_inertia_of_knobs_that_nobody_holds() -> None:
    """Speed after a pulse on an ideal rig without bearings: torque times duration over inertia."""
    recorded = record_apparatus(Rig.ideal(), damping=0.0, stiffness=0.0)
    assert len(recorded) == 3 * 6 * 3
    for trial in recorded:
        speed = (trial.angle_rad[-1] - trial.angle_rad[250]) / (trial.time_s[-1] - trial.time_s[250])
        impulse = trial.torque_nm.sum() * 1e-4
        step = 2 * np.pi / 640_000 / (trial.time_s[-1] - trial.time_s[250])
        assert speed == pytest.approx(impulse / setups()[trial.key.subject], abs=2 * step)
        assert not trial.grip_n.any()
    with pytest.raises(UsageError, match="no setup 'tiny'; there are: shaft, small_proof"):
        record_apparatus(Rig(), chosen=["tiny"])


def test_benches_are_the_same_every_time_and_part_by_part() -> None:
    rig = Rig()
    whole = {trial.key: trial for trial in record_apparatus(rig)}
    for trial in record_apparatus(rig, chosen=["medium_experimental"], trials=1):
        assert np.array_equal(trial.angle_rad, whole[trial.key].angle_rad)
    assert np.array_equal(record_grip_cell().voltage_v, record_grip_cell().voltage_v)
    assert np.array_equal(record_motor_calibration(rig).torque_nm, record_motor_calibration(rig).torque_nm)
