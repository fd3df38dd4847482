"""Arrow tables from rows, laid out directly.

`pyarrow.array` loads pandas, where it is installed, to ask whether a list is a Series; that takes longer than a small
sweep. The few types that results have are laid out here by Arrow's columnar format instead.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from hknob_cli.results.columns import Column


def build_table(columns: Sequence[Column], rows: Sequence[dict[str, Any]]) -> pa.Table:
    """Table with one field per column; None and NaN, which mean that there is no value, become null."""
    arrays = [build_array(column.type, [row[column.name] for row in rows]) for column in columns]
    return pa.Table.from_arrays(arrays, schema=pa.schema([column.field() for column in columns]))


def build_array(kind: pa.DataType, values: Sequence[Any]) -> pa.Array:
    """Array of reals, whole numbers, flags or text."""
    count = len(values)
    present = np.array([value is not None and value == value for value in values], dtype=bool)
    valid = None if present.all() else pa.py_buffer(np.packbits(present, bitorder="little").tobytes())
    filled = [value if there else 0 for value, there in zip(values, present, strict=True)]
    if kind == pa.string():
        pieces = [value.encode() if there else b"" for value, there in zip(values, present, strict=True)]
        ends = np.cumsum([0, *(len(piece) for piece in pieces)], dtype=np.int32)
        buffers = [valid, pa.py_buffer(ends.tobytes()), pa.py_buffer(b"".join(pieces))]
    elif kind == pa.bool_():
        bits = np.packbits(np.array(filled, dtype=bool), bitorder="little")
        buffers = [valid, pa.py_buffer(bits.tobytes())]
    else:
        numbers = np.array(filled, dtype=np.int64 if kind == pa.int64() else np.float64)
        buffers = [valid, pa.py_buffer(numbers.tobytes())]
    return pa.Array.from_buffers(kind, count, buffers)
