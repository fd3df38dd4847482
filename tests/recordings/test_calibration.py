"""Readings of a calibration: a table of numbers, or every fault with its row."""

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.recordings.files import GRIP_CELL, read_columns

GOOD = "position_m,force_n,voltage_v\n0.003,0,0\n0.003,1,0.1\n"


def read(path: Path, content: str | bytes) -> str:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(UsageError) as caught:
        read_columns([path], GRIP_CELL)
    return str(caught.value)


def test_readings_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(GOOD)
    assert read_columns([tmp_path / "a.csv"], GRIP_CELL)["voltage_v"].tolist() == [0.0, 0.1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.1", "nan", "row 2: voltage_v: must be a finite number, got nan"),
        ("0.1", "1e300", "row 2: voltage_v: must be within 1e+06, got 1e+300"),
        ("0.1", "x", "voltage_v: must be numbers"),
        ("voltage_v", "force_n", "force_n: is there 2 times; must be there once"),
        ("force_n", "\x1b[2J", "force_n: missing, and required; there are 'position_m', '?[2J', 'voltage_v'"),
    ],
)
def test_faults_say_where(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert message in read(tmp_path / "a.csv", GOOD.replace(old, new, 1))


def test_other_encodings_are_told(tmp_path: Path) -> None:
    assert "is neither Parquet nor CSV in UTF-8" in read(
        tmp_path / "a.csv", GOOD.encode().replace(b"force_n", b"f\xe5")
    )


def test_torn_parquet_is_told(tmp_path: Path) -> None:
    pq.write_table(pa.table({name: [0.0] for name in GRIP_CELL}), tmp_path / "a.parquet")
    whole = (tmp_path / "a.parquet").read_bytes()
    assert "cannot be read" in read(tmp_path / "b.parquet", whole[: len(whole) // 2])
