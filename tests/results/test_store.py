"""The results folder: whole files or none, one writer, nothing foreign overwritten."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import ComputationError, RefusedError
from hknob_cli.results import store
from hknob_cli.results.arrays import build_array, build_table, lay_out, reals, spell
from hknob_cli.results.columns import CELLS, ORBITS, Column
from hknob_cli.results.provenance import KEY, describe
from tests.spoilt_parquet import write_odd_names

STAMP = describe(stage="sweep", values={"name": "one"}, overrides=())


def table(value: float = 1.0) -> pa.Table:
    return build_table([Column("a", pa.float64(), "m", "a length")], [{"a": value}, {"a": None}])


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (pa.float64(), [1.5, None, float("nan"), -0.0, float("inf")]),
        (pa.int64(), [1, None, -(2**62)]),
        (pa.bool_(), [True, None, False] * 5),
        (pa.string(), ["", None, "Δθ", "x" * 300]),
        (pa.string(), []),
        (pa.float64(), [1.0] * 17),
    ],
)
def test_arrays_are_what_pyarrow_builds(kind: pa.DataType, values: list[object]) -> None:
    array = build_array(kind, values)
    array.validate(full=True)
    assert array.to_pylist() == [None if value != value else value for value in values]
    assert array.equals(pa.array(values, kind, from_pandas=True))


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (pa.float64(), [1.5, float("nan"), -0.0, float("inf")]),
        (pa.int64(), [1.0, float("nan"), 2.0**40]),
        (pa.int64(), [1, -(2**62)]),
        (pa.bool_(), [True, False, False] * 5),
        (pa.float64(), []),
    ],
)
def test_columns_are_what_lists_give(kind: pa.DataType, values: list[object]) -> None:
    array = lay_out(kind, np.array(values)[::-1])
    array.validate(full=True)
    assert array.equals(build_array(kind, values[::-1]))


def test_words_by_number() -> None:
    array = spell(["", "Δθ", "rest"], np.array([2, 0, 1, 2]))
    array.validate(full=True)
    assert array.equals(build_array(pa.string(), ["rest", "", "Δθ", "rest"]))


@pytest.mark.parametrize(
    "column",
    [
        pa.chunked_array([pa.array([1.5, None, -0.0, 2.0]), pa.array([], pa.float64()), pa.array([None, 3.0])]),
        pa.chunked_array([pa.array([1, None, 3, 4, 5, 6, 7, 8, None, 10]).slice(1, 8)]),
        pa.chunked_array([pa.array([True, None, False] * 5).slice(2)]),
        pa.chunked_array([pa.array([1.5, None], pa.float32())]),
        pa.chunked_array([], pa.float64()),
    ],
    ids=["reals", "whole numbers", "flags", "others", "none"],
)
def test_columns_as_numbers(column: pa.ChunkedArray) -> None:
    wanted = np.array([np.nan if value is None else value for value in column.to_pylist()], dtype=float)
    assert np.array_equal(reals(column), wanted, equal_nan=True)


def test_written_files_carry_units_and_provenance(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    store.write({path: table()}, STAMP)
    read = pq.read_table(path)
    assert json.loads(read.schema.metadata[KEY])["name"] == "one"
    assert read.schema.field("a").metadata[b"unit"] == b"m"
    assert [p.name for p in tmp_path.iterdir()] == ["a.parquet"]


def test_provenance_has_no_time() -> None:
    assert describe(stage="sweep", values={"name": "one"}, overrides=()) == STAMP


def test_only_the_same_provenance_is_current(tmp_path: Path) -> None:
    paths = [tmp_path / "a.parquet", tmp_path / "b.parquet"]
    assert store.read_current(paths, STAMP) is None
    store.write({path: table() for path in paths}, STAMP)
    assert store.read_current(paths, STAMP) is not None
    assert store.read_current(paths, STAMP + b" ") is None
    paths[1].write_bytes(paths[1].read_bytes()[:-9])
    assert store.read_current(paths, STAMP) is None


def test_a_second_writer_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with store.hold(out, []), pytest.raises(RefusedError, match="another run"), store.hold(out, []):
        pass


def test_leftovers_of_an_interrupted_run_are_removed(tmp_path: Path) -> None:
    left, foreign = tmp_path / ".cells.parquet.partial", tmp_path / ".download.partial"
    left.write_bytes(b"PAR1")
    foreign.write_bytes(b"mine")
    with store.hold(tmp_path, [tmp_path / "cells.parquet"]):
        assert not left.exists()
    assert foreign.exists()


def test_a_folder_made_for_a_run_that_failed_is_removed(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="x"), store.hold(tmp_path / "a" / "b", []):
        raise ValueError("x")
    assert list(tmp_path.iterdir()) == []


def test_foreign_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "cells.parquet"
    pq.write_table(pa.table({"a": [1]}), path)
    with pytest.raises(RefusedError, match="not written by hknob"):
        store.refuse_foreign([path], stage="sweep", name="one")
    path.write_text("some notes of mine")
    with pytest.raises(RefusedError, match="not written by hknob"):
        store.refuse_foreign([path], stage="sweep", name="one")
    store.write({path: table()}, STAMP)
    store.refuse_foreign([path], stage="sweep", name="one")
    with pytest.raises(RefusedError, match="holds the sweep 'one'"):
        store.refuse_foreign([path], stage="sweep", name="two")


def test_torn_files_may_be_replaced(tmp_path: Path) -> None:
    path = tmp_path / "cells.parquet"
    store.write({path: table()}, STAMP)
    path.write_bytes(path.read_bytes()[:40])
    store.refuse_foreign([path], stage="sweep", name="one")


def test_files_with_names_of_another_encoding_are_not_torn(tmp_path: Path) -> None:
    """A table of ours has no such names, and no tear makes them."""
    path = tmp_path / "cells.parquet"
    write_odd_names(pa.table({"name": [1]}), path, "name")
    with pytest.raises(RefusedError, match="not written by hknob"):
        store.refuse_foreign([path], stage="sweep", name="one")
    assert store.read_current([path], STAMP) is None


def test_nothing_stays_when_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(pq, "write_table", full)
    with pytest.raises(ComputationError, match="No space left"):
        store.write({tmp_path / "a.parquet": table()}, STAMP)
    assert list(tmp_path.iterdir()) == []


def test_columns_say_unit_and_meaning() -> None:
    for column in (*CELLS, *ORBITS):
        assert column.meaning
        if column.name.endswith("_rad"):
            assert column.unit == "rad"
        if column.name.endswith("_hz"):
            assert column.unit == "Hz"
