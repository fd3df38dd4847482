"""Recordings of others: their names, units and signs; columns that are not there; numbers that surprise."""

import math
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.recordings.columns import RecordingError
from hknob_cli.recordings.files import table, write_csv
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Key
from hknob_cli.specs.identification import ColumnPlan

DEGREE = math.pi / 180.0
FOREIGN = "t [ms],theta,i_q,note\n0,10,1.5,a\n5,20,-0.5,b\n10,40,0,c\n"
COLUMNS = {
    "time_s": ColumnPlan("t [ms]", 1e-3),
    "angle_rad": ColumnPlan("theta", -DEGREE),
    "torque_nm": ColumnPlan("i_q", 0.05),
}


@pytest.fixture
def file(tmp_path: Path):
    def write(text: str = FOREIGN, name: str = "run.csv") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def fault_of(path: Path, **how) -> str:
    with pytest.raises(RecordingError) as caught:
        read([path], **how)
    assert len(caught.value.faults) == 1, caught.value
    return str(caught.value)


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_names_units_and_signs_of_others_are_read(kind: str, file, tmp_path: Path) -> None:
    path = file()
    if kind == "parquet":
        path = tmp_path / "run.parquet"
        pq.write_table(pa.table({"t [ms]": [0, 5, 10], "theta": [10, 20, 40], "i_q": [1.5, -0.5, 0.0]}), path)
    (one,) = read([path], columns=COLUMNS)
    assert one.key == Key("unnamed", "unnamed", 0.0, 1, 1)
    assert one.time_s == pytest.approx([0.0, 0.005, 0.010])
    assert one.angle_rad == pytest.approx([-10 * DEGREE, -20 * DEGREE, -40 * DEGREE])
    assert one.torque_nm == pytest.approx([0.075, -0.025, 0.0])
    assert np.isnan(one.grip_n).all()
    assert one.measured_torque_nm is None


def test_files_without_block_and_trial_are_told_apart(file) -> None:
    found = read([file(name="a.csv"), file(name="b.csv")], columns=COLUMNS)
    assert [(one.key.block, one.key.trial) for one in found] == [(1, 1), (2, 2)]


def test_one_value_stands_for_a_column(file) -> None:
    given = {"subject": ColumnPlan("", value="motor 3"), "block": ColumnPlan("", value=7.0)}
    (one,) = read([file()], columns=COLUMNS | given)
    assert one.key == Key("motor 3", "unnamed", 0.0, 7, 1)


def test_a_misspelt_name_in_columns_is_a_fault_with_what_is_there(file) -> None:
    path = file()
    wrong = COLUMNS | {"angle_rad": ColumnPlan("tetha")}
    text = "angle_rad (column 'tetha'): missing, though columns names it; is it 'theta'?"
    assert fault_of(path, columns=wrong) == f"{path}: {text}"
    wrong = COLUMNS | {"angle_rad": ColumnPlan("position")}
    assert "there are 't [ms]', 'theta', 'i_q', 'note'" in fault_of(path, columns=wrong)


def test_a_bad_cell_is_a_fault_with_row_and_both_names(file) -> None:
    path = file(FOREIGN.replace("20,-0.5", "20,x"))
    wanted = f"{path}: row 2: torque_nm (column 'i_q'): must be a finite number, got 'x'"
    assert fault_of(path, columns=COLUMNS) == wanted


def test_a_file_without_torque_says_how_to_name_it(file) -> None:
    path = file("time_s,angle_rad\n0,0\n")
    wanted = "torque_nm: column missing, and required; columns: {torque_nm: NAME} says how it is called"
    assert fault_of(path) == f"{path}: {wanted}"


def test_a_measured_torque_alone_will_do(file) -> None:
    (one,) = read([file("time_s,angle_rad,measured_torque_nm\n0,0,1\n1,0,2\n")])
    assert one.torque_nm.tolist() == one.measured_torque_nm.tolist() == [1.0, 2.0]
    path = file("time_s,angle_rad,measured_torque_nm\n0,0,\n1,0,\n")
    assert "row 1: measured_torque_nm: nothing in 2 rows of this trial" in fault_of(path)


def test_an_accelerometer_is_there_whole_or_not_at_all(file, tmp_path) -> None:
    path = file("time_s,angle_rad,torque_nm,acceleration_rad_s2\n0,0,1,5\n1,0,2,-6\n")
    (one,) = read([path])
    assert one.acceleration_rad_s2.tolist() == [5.0, -6.0]
    again = tmp_path / "again.csv"
    write_csv(again, [one])
    assert read([again])[0].acceleration_rad_s2.tolist() == [5.0, -6.0]
    (none,) = read([file("time_s,angle_rad,torque_nm,acceleration_rad_s2\n0,0,1,\n1,0,2,\n")])
    assert none.acceleration_rad_s2 is None
    holes = file("time_s,angle_rad,torque_nm,acceleration_rad_s2\n0,0,1,5\n1,0,2,\n")
    assert (
        "row 2: acceleration_rad_s2: nothing in 1 rows of this trial; must be in all of them, or in none"
        in fault_of(holes)
    )


def test_a_wheel_that_turned_far_is_a_warning_and_no_fault(file) -> None:
    """400 rad are 64 turns, which a motor makes in a second."""
    said: list[str] = []
    path = file("time_s,angle_rad,torque_nm\n0,0,1\n0.1,400,-12\n0.2,0,0\n")
    (one,) = read([path], warn=said.append)
    assert said == [
        f"{path}: row 2: torque_nm: -12 N m is beyond 10 N m: is it in mN m? "
        "limits: {torque: 20} says that it is right",
        f"{path}: row 2: angle_rad: 400 rad is beyond 100 rad: is it in degrees or counts? "
        "limits: {angle: 800} says that it is right",
    ]
    assert [note.split(" up to ")[0] for note in one.notes] == ["torque_nm", "angle_rad"]
    said.clear()
    (one,) = read([path], limits={"angle_rad": 500.0, "torque_nm": 20.0}, warn=said.append)
    assert (said, one.notes) == ([], ())


def test_a_key_that_is_nearly_there_is_a_warning(file) -> None:
    said: list[str] = []
    read([file("time_s,angle_rad,torque_nm,subjet\n0,0,1,a\n0.1,0,1,a\n")], warn=said.append)
    assert len(said) == 1
    assert "subject: there is no such column, but 'subjet', which is not read" in said[0]


def test_time_that_starts_again_without_a_column_for_trials_says_so(file) -> None:
    path = file("time_s,angle_rad,torque_nm\n0,0,1\n0.1,0,1\n0,0,1\n")
    assert "row 3: time_s: runs backwards, 0 after 0.1" in fault_of(path)
    assert fault_of(path).endswith("and a file without a column 'trial' is one trial")


def test_no_grip_is_kept_as_no_grip(file, tmp_path: Path) -> None:
    trials = read([file()], columns=COLUMNS)
    assert table(trials).column("grip_n").null_count == 3
    write_csv(tmp_path / "kept.csv", trials)
    (back,) = read([tmp_path / "kept.csv"])
    assert back.key == trials[0].key
    assert np.isnan(back.grip_n).all()
    assert back.angle_rad.tolist() == trials[0].angle_rad.tolist()
