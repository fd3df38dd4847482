"""Parquet files that say what is no text in UTF-8, as another program or a disk's fault may leave them."""

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

ODD = b"caf\xe9"  # Latin-1


def odd_text(count: int = 1) -> pa.Array:
    """Cells of text that is not UTF-8."""
    offsets = pa.array([len(ODD) * i for i in range(count + 1)], pa.int32())
    return pa.StringArray.from_buffers(count, offsets.buffers()[1], pa.py_buffer(ODD * count))


def write_odd_names(table: pa.Table, path: Path, *columns: str) -> None:
    """Write a table whose ``columns`` (four letters each) have names that are not UTF-8."""
    pq.write_table(table, path, compression="none", store_schema=False)
    data = path.read_bytes()
    for name in columns:
        assert len(name) == len(ODD)
        data = data.replace(name.encode(), ODD)
    path.write_bytes(data)
