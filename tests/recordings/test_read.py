"""Recordings read: as they were written, whatever the file, and every fault with its row."""

import gzip
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import ExitCode
from hknob_cli.recordings.columns import MOST, RecordingError
from hknob_cli.recordings.files import table, write_csv
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Key
from tests.recordings.hands import trial

HEADER = "subject,experiment,block,trial,grip_target_n,time_s,torque_nm,angle_rad,grip_n"
ROWS = [
    "S1,pinch,1,1,0.72,0.0,0,0.1,0.7",
    "S1,pinch,1,1,0.72,0.1,0.01,0.1,0.7",
    "S1,pinch,1,1,0.72,0.2,0,0.2,0.7",
    "S1,pinch,1,2,0.72,0.0,0,0.1,0.7",
    "S1,pinch,1,2,0.72,0.1,0.01,0.1,0.7",
    "7,pinch,1,1,0.72,0.0,0,0.1,0.7",
]
TEXT = "\n".join([HEADER, *ROWS]) + "\n"


@pytest.fixture
def file(tmp_path: Path):
    def write(text: str | bytes = TEXT, name: str = "r.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return write


def faults_of(*paths: Path) -> list[str]:
    with pytest.raises(RecordingError) as caught:
        read(paths)
    assert caught.value.exit_code == ExitCode.USAGE
    assert [str(fault) for fault in caught.value.faults] == str(caught.value).splitlines()[: len(caught.value.faults)]
    return str(caught.value).splitlines()


def test_trials_of_a_file(file) -> None:
    found = read([file()])
    assert [trial.key for trial in found] == [
        Key("S1", "pinch", 0.72, 1, 1), Key("S1", "pinch", 0.72, 1, 2), Key("7", "pinch", 0.72, 1, 1),
    ]  # fmt: skip
    assert [trial.first_row for trial in found] == [1, 4, 6]
    assert found[0].time_s.tolist() == [0.0, 0.1, 0.2]
    assert found[0].torque_nm.tolist() == [0.0, 0.01, 0.0]
    assert found[0].measured_torque_nm is None
    assert found[0].source.endswith("r.csv")


@pytest.mark.parametrize(
    "text",
    [
        TEXT.replace("\n", "\r\n"),
        "\ufeff" + TEXT,
        TEXT.replace("\n", "\n\n"),
        TEXT.rstrip("\n"),
        TEXT.replace(",", ", "),
        TEXT.replace("S1", '"S1"'),
        TEXT.replace("0.01", '"0.01"'),
        TEXT.replace(",1,1,", ",1.0,1,"),
    ],
    ids=["crlf", "byte order mark", "empty lines", "no last newline", "spaces", "quotes", "quoted numbers", "1.0"],
)
def test_kinds_of_csv(text: str, file) -> None:
    plain = read([file()])
    for left, right in zip(read([file(text, "other.csv")]), plain, strict=True):
        assert left.key == right.key
        assert np.array_equal(left.angle_rad, right.angle_rad)
        assert np.array_equal(left.torque_nm, right.torque_nm)


def test_compressed_csv(file) -> None:
    assert len(read([file(gzip.compress(TEXT.encode()), "r.csv.gz")])) == 3
    path = file(gzip.compress(TEXT.replace("0.2,0,0.2", "0.2,x,0.2").encode()), "r.csv.gz")
    assert faults_of(path) == [f"{path}: row 3: torque_nm: must be a finite number, got 'x'"]


def test_columns_in_any_order_with_others_between(file) -> None:
    lines = [",".join(["x", *reversed(line.split(",")), "y"]) for line in TEXT.splitlines()]
    lines[0] = lines[0].replace("x,", "note,").replace(",y", ",remark")
    assert [trial.key for trial in read([file("\n".join(lines))])] == [
        trial.key for trial in read([file(name="b.csv")])
    ]


@pytest.mark.parametrize("kind", ["int", "dictionary", "large", "float", "float32"])
def test_kinds_of_parquet(kind: str, file, tmp_path: Path) -> None:
    found = pc.read_csv(file("\n".join([HEADER, *ROWS[5:]])))
    casts = {
        "int": ("subject", pa.int32()), "dictionary": ("subject", pa.dictionary(pa.int8(), pa.string())),
        "large": ("experiment", pa.large_string()), "float": ("subject", pa.float64()),
        "float32": ("block", pa.float32()),
    }  # fmt: skip
    name, kind_ = casts[kind]
    column = found.column(name)
    if pa.types.is_dictionary(kind_):
        column = column.cast(pa.string()).dictionary_encode()
    found = found.set_column(
        found.schema.get_field_index(name), name, column.cast(kind_) if kind != "dictionary" else column
    )
    path = tmp_path / "a.dat"
    pq.write_table(found, path)
    assert read([path])[0].key == Key("7", "pinch", 0.72, 1, 1)


@pytest.mark.long
def test_trials_across_blocks_of_a_large_file(tmp_path: Path) -> None:
    """A million rows, read in several pieces; the ceiling only tells seconds from minutes."""
    trials = [trial(number=n, length_s=10.0, seed=n) for n in range(1, 11)]
    trials = [one._replace(key=one.key._replace(subject=f"S{s}")) for s in range(1) for one in trials]
    path = tmp_path / "large.csv"
    write_csv(path, trials)
    begin = time.perf_counter()
    back = read([path])
    assert time.perf_counter() - begin < 60.0
    assert sum(one.time_s.size for one in back) == 1_000_000
    for left, right in zip(back, trials, strict=True):
        assert left.key == right.key
        assert np.array_equal(left.angle_rad, right.angle_rad)
    pq.write_table(table(trials), tmp_path / "large.parquet")
    for left, right in zip(read([tmp_path / "large.parquet"]), trials, strict=True):
        assert np.array_equal(left.grip_n, right.grip_n)


# What is replaced, by what, and the line after the file's name.
BROKEN = {
    "text": ("0.2,0,0.2", "0.2,zero,0.2", "row 3: torque_nm: must be a finite number, got 'zero'"),
    "empty cell": ("0.2,0,0.2", "0.2,,0.2", "row 3: torque_nm: must be a finite number, got nothing"),
    "nan": ("0.2,0,0.2", "0.2,0,NaN", "row 3: angle_rad: must be a finite number, got 'NaN'"),
    "infinite": ("0.2,0,0.2", "0.2,0,-inf", "row 3: angle_rad: must be a finite number, got '-inf'"),
    "decimal comma": ("0.2,0,0.2,", '0.2,0,"0,2",', "row 3: angle_rad: must be a finite number, got '0,2'"),
    "time backwards": ("0.72,0.2", "0.72,0.05", "row 3: time_s: runs backwards, 0.05"),
    "time stands still": ("0.72,0.2", "0.72,0.1", "row 3: time_s: stands still, 0.1"),
    "missing column": ("angle_rad", "angle", "angle_rad: column missing, and required; is it 'angle'?"),
    "column twice": ("grip_n\n", "time_s\n", "time_s: column is there 2 times"),
    "half a block": ("pinch,1,2", "pinch,1.5,2", "row 4: block: must be a whole number >= 0, got 1.5"),
    "negative trial": ("pinch,1,2", "pinch,1,-2", "row 4: trial: must be a whole number >= 0, got -2"),
    "no subject": ("7,pinch", ",pinch", "row 6: subject: must be text or a whole number, got nothing"),
    "degrees": ("0.2,0,0.2", "0.2,0,4e6", "row 3: angle_rad: must be within 1e+06 rad, got 4e+06: is it in degrees"),
    "millinewtonmetres": ("0.1,0.01", "0.1,-2e6", "row 2: torque_nm: must be within 1e+06 N m, got -2e+06: is it"),
    "milliseconds": ("0.72,0.2", "0.72,100", "row 3: time_s: step of 99.9 s; must be <= 1 s: is it in ms?"),
    "negative target": ("0.72", "-1", "row 1: grip_target_n: must be >= 0 N, got -1"),
    "grams": ("0.2,0.7", "0.2,1e7", "row 3: grip_n: must be within 1e+06 N, got 1e+07: is it in mN or grams?"),
    "split": (ROWS[4], ROWS[0].replace("0.0", "0.3"), "row 5: trial: trial 1 of block 1 of subject 'S1', experiment"),
    "too few cells": (ROWS[3], "S1,pinch", "row 4: has 2 cells; must have 9, as the header"),
    "too many cells": (ROWS[3], ROWS[3] + ",1", "row 4: has 10 cells; must have 9, as the header"),
    "bars": (",", "|", "has one column, 'subject|experiment|block|trial|grip_target_n|time_s|torq...; cells must"),
    "no rows": (TEXT, HEADER + "\n", "has no rows below its header"),
    "empty": (TEXT, "", "is empty; must have a header and rows"),
}  # fmt: skip


@pytest.mark.parametrize("mark", [";", "\t"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_other_marks_are_read_as_the_same_numbers(mark: str, decimal: str, file) -> None:
    """As spreadsheets of many countries write them: semicolons or tabs between cells, and decimal commas."""
    other = TEXT.replace(",", mark).replace(".", decimal)
    for one, same in zip(read([file(other, "o.csv")]), read([file()]), strict=True):
        assert one.key == same.key
        for name in ("time_s", "torque_nm", "angle_rad", "grip_n"):
            assert getattr(one, name).tolist() == getattr(same, name).tolist()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0,2;0,7", "0.2;0,7", "row 3: angle_rad: must be a finite number, got '0.2'; this file has decimal commas"),
        ("0,2;0,7", "1.000,2;0,7", "row 3: angle_rad: must be a finite number, got '1.000,2'; this file has decimal"),
        ("0,2;0,7", "0,2", "row 3: has 8 cells; must have 9, as the header"),
    ],
)
def test_a_file_has_one_decimal_mark(old: str, new: str, message: str, file) -> None:
    text = TEXT.replace(",", ";").replace(".", ",")
    assert old in text
    path = file(text.replace(old, new))
    (line,) = faults_of(path)
    assert line.startswith(f"{path}: {message}")


@pytest.mark.parametrize("name", BROKEN)
def test_broken_csv(name: str, file) -> None:
    old, new, message = BROKEN[name]
    assert old in TEXT
    path = file(TEXT.replace(old, new))
    lines = faults_of(path)
    assert any(line.startswith(f"{path}: {message}") for line in lines), lines
    assert len(lines) == 1, lines


@pytest.mark.parametrize(
    "name", ["text", "nan", "time backwards", "missing column", "half a block", "no subject", "degrees"]
)
def test_broken_parquet(name: str, file, tmp_path: Path) -> None:
    old, new, message = BROKEN[name]
    path = tmp_path / "r.parquet"
    pq.write_table(pc.read_csv(file(TEXT.replace(old, new))), path)
    (line,) = faults_of(path)
    assert line.startswith(f"{path}: {message}".replace("'NaN'", "")), line


@pytest.mark.parametrize("times", [("inf", "inf"), ("-1e308", "1e308")])
def test_times_that_have_no_difference(times: tuple[str, str], file) -> None:
    first, second = times
    path = file(
        TEXT.replace("0.72,0.1,0.01,0.1,0.7\nS1,pinch,1,1,0.72,0.2", f"0.72,{first},0,0,0\nS1,pinch,1,1,0.72,{second}")
    )
    lines = faults_of(path)
    assert lines
    assert all("time_s: " in line for line in lines), lines


def test_all_faults_at_once_in_the_order_of_rows(file) -> None:
    text = TEXT.replace(ROWS[1], "S1,pinch").replace("0.2,0,0.2", "0.15,x,nan").replace("7,pinch,1", "7,pinch,1.5")
    path = file(text)
    starts = ["row 2: has 2", "row 3: torque_nm", "row 3: angle_rad", "row 6: block"]
    lines = faults_of(path)
    assert len(lines) == len(starts), lines
    for line, start in zip(lines, starts, strict=True):
        assert line.startswith(f"{path}: {start}")


def test_at_most_twenty_are_listed(file) -> None:
    rows = [f"S1,pinch,1,1,0.72,{i / 100},x,0.1,0.7" for i in range(50)]
    lines = faults_of(file("\n".join([HEADER, *rows])))
    assert len(lines) == MOST + 1
    assert lines[-1] == "only the first 20 faults are listed"


def test_one_wrong_unit_is_one_fault(file) -> None:
    rows = [f"S1,pinch,1,{n},0.72,{i / 100},2e7,0.1,0.7" for n in range(30) for i in range(5)]
    (line,) = faults_of(file("\n".join([HEADER, *rows])))
    assert "is it in mN m?" in line


def test_a_trial_in_two_files(file) -> None:
    one, two = file(name="a.csv"), file(name="b.csv")
    lines = faults_of(one, two)
    assert len(lines) == 3
    assert lines[0].startswith(f"{two}: row 1: trial: trial 1 of block 1 of subject 'S1'")
    assert f"is already in {one}, row 1" in lines[0]


def test_faults_of_several_files(file) -> None:
    lines = faults_of(
        file("", "a.csv"), file("x,y\n1,2\n", "b.csv"), file(name="c.csv"), file(TEXT[:-4] + "z\n", "d.csv")
    )
    assert [Path(line.split(":")[0]).name for line in lines] == ["a.csv", *["b.csv"] * 3, *["d.csv"] * 4]


def test_files_that_cannot_be_read(file, tmp_path: Path) -> None:
    whole = tmp_path / "whole.parquet"
    pq.write_table(pa.table({"time_s": [0.0]}), whole)
    torn = file(whole.read_bytes()[:-20], "torn.parquet")
    bad = [
        tmp_path,
        tmp_path / "none.csv",
        torn,
        file("a,b\n", "csv.parquet"),
        file(b"\x00\x01\xff" * 99, "binary.csv"),
    ]
    for path in bad:
        assert faults_of(path)[0].startswith(f"{path}: ")
    assert "Is a directory" in faults_of(bad[0])[0]
    assert "No such file" in faults_of(bad[1])[0]
    latin = file(TEXT.replace("S1", "Jürgen").encode("latin-1"), "latin.csv")
    assert faults_of(latin) == [f"{latin}: line 2: is not UTF-8 text; save it as such"]


def test_measured_torque_is_there_in_whole_trials_or_not_at_all(file) -> None:
    values = ["0.1", "0.2", "0.3", "", "", "nan"]
    lines = [HEADER + ",measured_torque_nm", *(f"{row},{value}" for row, value in zip(ROWS, values, strict=True))]
    found = read([file("\n".join(lines))])
    assert found[0].measured_torque_nm.tolist() == [0.1, 0.2, 0.3]
    assert found[1].measured_torque_nm is None
    assert found[2].measured_torque_nm is None
    (line,) = faults_of(file("\n".join(lines).replace("0.7,0.2", "0.7,")))
    assert "row 2: measured_torque_nm: nothing in 1 rows of this trial" in line
    (line,) = faults_of(file("\n".join(lines).replace("0.7,0.2", "0.7,weak")))
    assert "row 2: measured_torque_nm: must be a finite number, got 'weak'" in line
