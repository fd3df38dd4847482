"""Parquet files whose seal, names and cells are looked at as they are read.

Arrow takes text as it comes, of other encodings or of a damaged file too, and fails where it is used, with an error of
Python's. Here such a file cannot be read, like any other that is damaged: `pyarrow.ArrowException` or `OSError`. So is
one of this program whose seal does not hold; pages of others with checksums are compared with those.
"""

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO, TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from hknob_cli.specs.seal import State, state_in, state_of

Cells = TypeVar("Cells", pa.Table, pa.RecordBatch)


class ChangedError(pa.ArrowInvalid):  # type: ignore[misc]
    """A file is not as this program wrote it."""


def why_unreadable(error: Exception) -> str:
    """What to say of a file that raised this."""
    if isinstance(error, ChangedError):
        return "is not as it was written: damaged, or changed"
    why = error.strerror if isinstance(error, OSError) and not isinstance(error, pa.ArrowException) else None
    return f"cannot be read: {why}" if why else "cannot be read"


class NotTextError(pa.ArrowInvalid):  # type: ignore[misc]
    """Names in a file, or cells of it, are not text in UTF-8."""


@contextlib.contextmanager
def opened(file: Path | BinaryIO, *, coded: Sequence[str] = ()) -> Iterator[pq.ParquetFile]:
    """A file, or what can be read like one, with names in UTF-8. Raises `OSError`, `pa.ArrowException`.

    ``coded``: columns of text that are read as a dictionary and its codes.
    """
    if (state_of(file) if isinstance(file, Path) else state_in(file)) is State.CHANGED:
        raise ChangedError("it is not as it was written: damaged, or changed")
    try:
        with pq.ParquetFile(file, read_dictionary=list(coded), page_checksum_verification=True) as parquet:
            # All names at once, those inside of types too.
            parquet.schema_arrow.to_string(show_field_metadata=False, show_schema_metadata=False)
            yield parquet
    except UnicodeDecodeError:
        raise NotTextError("its columns have names that are not UTF-8 text") from None


def schema_of(file: Path | BinaryIO) -> pa.Schema:
    """Columns of a file, and what it says of itself. Raises as `opened`."""
    with opened(file) as parquet:
        return parquet.schema_arrow


def table_of(file: Path | BinaryIO, columns: Sequence[str] | None = None, *, coded: Sequence[str] = ()) -> pa.Table:
    """A file's cells; all columns if None, those ``coded`` as of `opened`, which says what is raised."""
    with opened(file, coded=coded) as parquet:  # pyarrow's read_table would load its whole dataset layer
        return sound(parquet.read(columns=None if columns is None else list(columns)))


def sound(cells: Cells) -> Cells:
    """The same cells, of which text is UTF-8 and every value is one that its type has. Raises `pa.ArrowException`."""
    for name, column in zip(cells.schema.names, cells.columns, strict=True):
        try:
            column.validate(full=True)
        except pa.ArrowInvalid as error:
            kind = NotTextError if "UTF8" in str(error) else pa.ArrowInvalid
            what = "text that is not UTF-8" if kind is NotTextError else str(error)
            raise kind(f"{name}: {what}") from None
    return cells
