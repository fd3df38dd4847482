"""Names and cells of Parquet files are looked at as they are read."""

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.specs.parquet import NotTextError, opened, schema_of, sound, table_of
from tests.spoilt_parquet import ODD, odd_text, write_odd_names

GOOD = pa.table({"one": [1.0, 2.0], "two": ["a", None]}).replace_schema_metadata({b"said": b"\xff"})


def test_a_good_file_is_read_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    pq.write_table(GOOD, path)
    assert table_of(path) == GOOD
    assert table_of(path, ["two"]).column_names == ["two"]
    assert schema_of(path).equals(pq.read_schema(path), check_metadata=True)
    assert schema_of(path).metadata == {b"said": b"\xff"}


@pytest.mark.parametrize(
    "column", [pa.array([1.0]), pa.array([{"a": 1}]), pa.array([[1]]), pa.array(["x"])], ids=lambda one: str(one.type)
)
def test_names_that_are_no_text(tmp_path: Path, column: pa.Array) -> None:
    path = tmp_path / "a.parquet"
    write_odd_names(pa.table({"name": column}), path, "name")
    assert ODD in path.read_bytes()
    with pytest.raises(NotTextError, match="names that are not UTF-8"):
        schema_of(path)
    with pytest.raises(NotTextError, match="names that are not UTF-8"), opened(path):
        pass


def test_names_inside_of_a_column_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    write_odd_names(pa.table({"outer": pa.array([{"name": 1}])}), path, "name")
    with pytest.raises(NotTextError, match="names that are not UTF-8"):
        table_of(path)


@pytest.mark.parametrize("wrapped", [False, True])
def test_cells_that_are_no_text(tmp_path: Path, wrapped: bool) -> None:
    path = tmp_path / "a.parquet"
    text = odd_text(2)
    column = pa.DictionaryArray.from_arrays(pa.array([0, 0, 0]), text[:1]) if wrapped else text
    pq.write_table(pa.table({"word": column}), path)
    with pytest.raises(pa.ArrowInvalid, match="Invalid UTF8" if wrapped else "word: text that is not UTF-8"):
        table_of(path)


def test_values_that_their_type_has_not() -> None:
    too_large = pa.Array.from_buffers(pa.decimal128(3, 0), 1, [None, pa.py_buffer((10**6).to_bytes(16, "little"))])
    with pytest.raises(pa.ArrowInvalid, match="price: ") as caught:
        sound(pa.table({"price": too_large}))
    assert not isinstance(caught.value, NotTextError)
