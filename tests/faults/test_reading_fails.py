"""A disk that fails as something is read: said, and never taken for a file that is not there, or for an empty one."""

import errno
import os
from pathlib import Path

import pyarrow as pa
import pytest

from hknob_cli.errors import ComputationError, UsageError
from hknob_cli.results import parted, result_set
from hknob_cli.results.files import digest, input_digest
from hknob_cli.results.parted import part_metadata, part_name, put_part, read_parted, read_result, result_file
from hknob_cli.results.result_set import MissingError, Result
from hknob_cli.specs.parquet import why_unreadable

FAILS = OSError(errno.EIO, os.strerror(errno.EIO))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A table of two parts."""
    place = tmp_path / "cells.parquet"
    place.mkdir()
    for number in range(2):
        put_part(result_file(pa.table({"a": [number]}), part_metadata(number, 2, b"it")), place, number)
    return place


def fail_at(path: Path, monkeypatch: pytest.MonkeyPatch, error: OSError = FAILS) -> None:
    """Whoever opens that file meets an error of the disk."""
    plain = Path.open

    def opened(self: Path, *args: object, **kwargs: object) -> object:
        if self == path:
            raise error
        return plain(self, *args, **kwargs)

    monkeypatch.setattr(Path, "open", opened)
    monkeypatch.setattr(parted, "schema_of", lambda file: opened(file, "rb") if file == path else pa.schema([], {}))
    monkeypatch.setattr(result_set, "result_schema", lambda file: opened(file, "rb"))


def test_no_digest_of_a_folder_that_lacks_a_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = digest(folder)
    assert whole == input_digest(folder)
    fail_at(folder / part_name(1), monkeypatch)
    assert digest(folder) is None
    with pytest.raises(UsageError, match="cannot be read: Input/output error"):
        input_digest(folder)


def test_no_digest_of_nothing_is_an_input(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is not there"):
        input_digest(tmp_path / "none")


def test_a_part_that_cannot_be_read_is_not_one_that_is_not_there(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fail_at(folder / part_name(0), monkeypatch)
    assert read_parted(folder) is None
    for read in (lambda: read_parted(folder, strict=True), lambda: read_result(folder)):
        with pytest.raises(OSError, match="Input/output error") as caught:
            read()
        assert caught.value.errno == errno.EIO


def test_a_part_that_is_not_there(folder: Path) -> None:
    assert read_parted(folder, strict=True) is not None
    (folder / part_name(1)).unlink()
    assert read_parted(folder, strict=True) is None


@pytest.mark.parametrize("number", [errno.EIO, errno.EMFILE, errno.EACCES])
def test_no_page_is_written_without_what_could_not_be_read(
    number: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A page that lacks a picture for a moment's sake would count as done."""
    fail_at(folder, monkeypatch, OSError(number, os.strerror(number)))
    with pytest.raises(ComputationError, match=f"cannot be read: {os.strerror(number)}; run"):
        Result("grid", folder.parent).schema("cells")


def test_what_is_not_there_is_said_to_be_missing(folder: Path) -> None:
    with pytest.raises(MissingError, match=r"no orbits\.parquet"):
        Result("grid", folder.parent).schema("orbits")


def test_why_a_file_cannot_be_read() -> None:
    assert why_unreadable(FAILS) == "cannot be read: Input/output error"
    assert why_unreadable(pa.ArrowInvalid("torn")) == why_unreadable(OSError("torn")) == "cannot be read"
