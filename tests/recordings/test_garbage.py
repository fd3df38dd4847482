"""Garbage read: trials or faults, never another exception."""

import contextlib
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hknob_cli.recordings.columns import RecordingError
from hknob_cli.recordings.read import read
from tests.recordings.test_read import TEXT
from tests.spoilt_parquet import odd_text, write_odd_names

QUIET = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def put(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with contextlib.suppress(RecordingError):
        read([path])


@QUIET
@given(
    edits=st.lists(
        st.tuples(st.integers(0, len(TEXT)), st.integers(0, 3), st.binary(max_size=3)), min_size=1, max_size=5
    )
)
def test_csv_with_bytes_put_in_and_taken_out(edits, tmp_path: Path) -> None:
    content = TEXT.encode()
    for at, gone, new in edits:
        content = content[:at] + new + content[at + gone :]
    put(tmp_path / "r.csv", content)


@QUIET
@given(content=st.binary(max_size=200))
def test_any_bytes(content: bytes, tmp_path: Path) -> None:
    put(tmp_path / "r.csv", content)
    put(tmp_path / "r.parquet", content)
    put(tmp_path / "s.csv", b"PAR1" + content)


COLUMNS = {
    "subject": ["S1"], "experiment": ["pinch"], "block": [1], "trial": [1], "grip_target_n": [0.72], "time_s": [0.0],
    "torque_nm": [0.0], "angle_rad": [0.0], "grip_n": [0.7], "measured_torque_nm": [0.0],
}  # fmt: skip
ODD = {
    "flag": pa.array([True]),
    "null": pa.nulls(1),
    "time": pa.array([1], pa.timestamp("us")),
    "list": pa.array([[1.0, 2.0]]),
    "struct": pa.array([{"a": 1}]),
    "bytes": pa.array([b"\xff"]),
    "decimal": pa.array([1]).cast(pa.decimal128(24, 2)),
    "half": pa.array([1.0]).cast(pa.float16()),
    "unsigned": pa.array([2**64 - 1], pa.uint64()),
    "view": pa.array(["1"], pa.string_view()),
    "dictionary": pa.array(["x"]).dictionary_encode(),
    "dictionary of nothing": pa.array([None], pa.string()).dictionary_encode(),
}


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("kind", ODD)
def test_columns_of_odd_types(kind: str, column: str, tmp_path: Path) -> None:
    table = pa.table({**COLUMNS, column: ODD[kind]})
    path = tmp_path / "r.parquet"
    try:
        pq.write_table(table, path)
    except pa.ArrowException:
        pytest.skip("Parquet has no such type")
    with contextlib.suppress(RecordingError):
        read([path])
    if column in {"subject", "experiment"} and kind in {"list", "struct", "bytes"}:
        with pytest.raises(RecordingError, match=f"{column}: is of type .*; must be text or whole numbers"):
            read([path])
    wrong = {"flag", "list", "dictionary"} if column == "grip_n" else {"flag", "null", "list", "dictionary"}
    if column not in {"subject", "experiment", "measured_torque_nm"} and kind in wrong:
        with pytest.raises(RecordingError, match=rf"row 1: {column}: must be a finite number, got "):
            read([path])


@pytest.mark.parametrize("column", ["subject", "experiment"])
def test_cells_that_are_no_text_are_a_fault(column: str, tmp_path: Path) -> None:
    path = tmp_path / "r.parquet"
    pq.write_table(pa.table({**COLUMNS, column: odd_text()}), path)
    with pytest.raises(RecordingError, match=rf"r\.parquet: cannot be read: {column}: text that is not UTF-8"):
        read([path])


def test_names_of_columns_that_are_no_text_are_a_fault(tmp_path: Path) -> None:
    path = tmp_path / "r.parquet"
    write_odd_names(pa.table({**COLUMNS, "name": [1]}), path, "name")
    with pytest.raises(RecordingError, match="cannot be read as Parquet: its columns have names that are not UTF-8"):
        read([path])
