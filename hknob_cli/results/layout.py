"""How tables are laid out in Parquet files."""

from collections.abc import Mapping
from typing import BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq


def write_table(table: pa.Table, stream: BinaryIO) -> None:
    """Write a table to a file. Raises `OSError`.

    Reals are stored as they are, all else through a dictionary: few reals occur twice, and looking for those that do
    takes longer than all the rest, for files that are larger.
    """
    repeated = [field.name for field in table.schema if field.type != pa.float64()]
    pq.write_table(table, stream, compression="zstd", use_dictionary=repeated)


def as_file(table: pa.Table, metadata: Mapping[bytes, bytes]) -> memoryview:
    """The bytes of a file with a table, one row group of it, that says ``metadata`` of itself."""
    stream = pa.BufferOutputStream()
    write_table(table.combine_chunks().replace_schema_metadata(dict(metadata)), stream)
    return memoryview(stream.getvalue())
