"""Recordings written: what is read back is what was written."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.errors import ComputationError
from hknob_cli.recordings.files import table, write_csv
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Key, Trial
from tests.recordings.hands import trial

WORDS = st.text("abcXYZ019 ,.;'\"-_äß", min_size=1, max_size=8).filter(lambda word: word == word.strip())
KEYS = st.builds(
    Key, WORDS, WORDS, st.floats(0.0, 100.0), st.integers(0, 2**40), st.integers(0, 2**40)
)  # fmt: skip


@st.composite
def trials(draw: st.DrawFn) -> list[Trial]:
    made = []
    for key in draw(st.lists(KEYS, min_size=1, max_size=4, unique=True)):
        count = draw(st.integers(1, 6))
        arrays = [
            np.array(draw(st.lists(st.floats(-most, most), min_size=count, max_size=count)))
            for most in (10.0, 100.0, 1000.0, 10.0)
        ]
        steps = draw(st.lists(st.floats(1e-6, 0.5), min_size=count, max_size=count))
        measured = arrays[3] if draw(st.booleans()) else None
        made.append(Trial(key, np.cumsum(steps), *arrays[:3], measured))
    return made


def same(left: Trial, right: Trial) -> None:
    assert left.key == right.key
    for name in ("time_s", "torque_nm", "angle_rad", "grip_n", "measured_torque_nm"):
        one, two = getattr(left, name), getattr(right, name)
        assert (one is None) == (two is None)
        if one is not None:
            assert one.tobytes() == two.tobytes() or np.array_equal(one, two)


@settings(max_examples=100, deadline=None)
@given(made=trials(), kind=st.sampled_from(["csv", "parquet"]))
def test_round_trip(made: list[Trial], kind: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("round") / f"r.{kind}"
    if kind == "csv":
        write_csv(path, made)
    else:
        pq.write_table(table(made), path)
    for left, right in zip(read([path]), made, strict=True):
        same(left, right)


def test_columns_carry_unit_and_meaning() -> None:
    schema = table([trial()]).schema
    for field in schema:
        assert field.metadata[b"meaning"]
    assert schema.field("angle_rad").metadata[b"unit"] == b"rad"
    assert "measured_torque_nm" not in schema.names


def test_no_trials_are_an_empty_table() -> None:
    assert table([]).num_rows == 0
    table([]).validate(full=True)


def test_tables_are_valid() -> None:
    one = trial()
    table([one, one._replace(measured_torque_nm=one.torque_nm)]).validate(full=True)


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ComputationError, match="cannot be written: "):
        write_csv(tmp_path / "none" / "r.csv", [trial()])


def test_what_cannot_be_put_in_place_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "r.csv").mkdir()
    with pytest.raises(ComputationError):
        write_csv(tmp_path / "r.csv", [trial()])
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.csv"]
