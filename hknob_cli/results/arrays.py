"""Arrow tables from rows or columns, laid out directly.

`pyarrow.array` loads pandas, where it is installed, to ask whether a list is a Series; that takes longer than a small
sweep. The few types that results have are laid out here by Arrow's columnar format instead.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from hknob_cli.results.columns import Column


def build_table(columns: Sequence[Column], rows: Sequence[dict[str, Any]]) -> pa.Table:
    """Table with one field per column; None and NaN, which mean that there is no value, become null."""
    return join_columns(columns, {column.name: [row[column.name] for row in rows] for column in columns})


def join_columns(columns: Sequence[Column], values: Mapping[str, Any]) -> pa.Table:
    """Table of whole columns by name: lists as in `build_table`, arrays as `lay_out` takes them, or Arrow's own."""
    arrays = [_array(column.type, values[column.name]) for column in columns]
    return pa.Table.from_arrays(arrays, schema=pa.schema([column.field() for column in columns]))


def _array(kind: pa.DataType, values: Any) -> pa.Array:
    if isinstance(values, pa.Array):
        return values
    return lay_out(kind, values) if isinstance(values, np.ndarray) else build_array(kind, values)


def build_array(kind: pa.DataType, values: Sequence[Any]) -> pa.Array:
    """Array of reals, whole numbers, flags or text; or of lists of records, dictionaries by their fields' names."""
    if pa.types.is_list(kind):
        return _lists(kind, values)
    present = np.array([value is not None and value == value for value in values], dtype=bool)
    filled = [value if there else 0 for value, there in zip(values, present, strict=True)]
    if kind == pa.string():
        pieces = [value.encode() if there else b"" for value, there in zip(values, present, strict=True)]
        return _text(b"".join(pieces), np.array([len(piece) for piece in pieces], dtype=np.int64), present)
    return _numbers(kind, np.array(filled, dtype=_kept(kind)), present)


def lay_out(kind: pa.DataType, values: NDArray[Any]) -> pa.Array:
    """Array of reals, whole numbers or flags, from an array; NaN, also in the place of a whole number, is null."""
    present = values == values
    if not present.all():
        values = np.where(present, values, 0.0)
    return _numbers(kind, values, present)


def spell(words: Sequence[str], codes: NDArray[np.int64]) -> pa.Array:
    """Array of text: of the ``words``, those with these numbers."""
    pieces = [word.encode() for word in words]
    letters = np.array(pieces, dtype=bytes)
    letters = letters.view(np.uint8).reshape(len(pieces), letters.itemsize)
    lengths = np.array([len(piece) for piece in pieces])
    kept = np.arange(letters.shape[1]) < lengths[:, np.newaxis]
    return _text(letters[codes][kept[codes]].tobytes(), lengths[codes], np.ones(len(codes), dtype=bool))


def tally(column: pa.ChunkedArray) -> Counter[str]:
    """How often each word is in a column of codes; Arrow itself would load all that it can compute with."""
    counts: Counter[str] = Counter()
    for chunk in column.chunks:
        here = slice(chunk.offset, chunk.offset + len(chunk))
        codes = np.frombuffer(chunk.indices.buffers()[1], np.int32)[here]
        words = chunk.dictionary.to_pylist()
        counts.update(dict(zip(words, np.bincount(codes, minlength=len(words)).tolist(), strict=True)))
    return counts


def reals(column: pa.ChunkedArray) -> NDArray[np.float64]:
    """Values of a column of numbers or flags, NaN for none; Arrow would load pandas to hand them over."""
    pieces = [_reals(chunk) for chunk in column.chunks if len(chunk)]
    return np.concatenate(pieces) if pieces else np.empty(0)


def _reals(chunk: pa.Array) -> NDArray[np.float64]:
    if chunk.type not in (pa.float64(), pa.int64(), pa.bool_()):
        converted: NDArray[np.float64] = chunk.to_numpy(zero_copy_only=False).astype(np.float64)
        return converted
    valid, data = chunk.buffers()
    here = slice(chunk.offset, chunk.offset + len(chunk))
    kept = _bits(data) if chunk.type == pa.bool_() else np.frombuffer(data, _kept(chunk.type))
    values = kept[here].astype(np.float64)
    if chunk.null_count:
        values[_bits(valid)[here] == 0] = np.nan
    return values


def _bits(buffer: pa.Buffer) -> NDArray[np.uint8]:
    return np.unpackbits(np.frombuffer(buffer, np.uint8), bitorder="little")


def _kept(kind: pa.DataType) -> Any:
    return bool if kind == pa.bool_() else np.int64 if kind == pa.int64() else np.float64


def _numbers(kind: pa.DataType, filled: NDArray[Any], present: NDArray[np.bool_]) -> pa.Array:
    numbers = np.ascontiguousarray(filled, dtype=_kept(kind))
    if kind == pa.bool_():
        numbers = np.packbits(numbers, bitorder="little")
    return pa.Array.from_buffers(kind, len(present), [_valid(present), pa.py_buffer(numbers)])


def _text(letters: bytes, lengths: NDArray[np.int64], present: NDArray[np.bool_]) -> pa.Array:
    ends = np.zeros(len(lengths) + 1, dtype=np.int32)
    np.cumsum(lengths, out=ends[1:])
    buffers = [_valid(present), pa.py_buffer(ends), pa.py_buffer(letters)]
    return pa.Array.from_buffers(pa.string(), len(lengths), buffers)


def _lists(kind: pa.ListType, values: Sequence[Any]) -> pa.Array:
    """Array of lists of records; none of the lists is null."""
    record, rows = kind.value_type, [row for value in values for row in value]
    fields = [record.field(i) for i in range(record.num_fields)]
    parts = [build_array(field.type, [row[field.name] for row in rows]) for field in fields]
    ends = np.zeros(len(values) + 1, dtype=np.int32)
    np.cumsum([len(value) for value in values], out=ends[1:])
    records = pa.StructArray.from_arrays(parts, fields=fields)
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(ends)], children=[records])


def _valid(present: NDArray[np.bool_]) -> pa.Buffer | None:
    return None if present.all() else pa.py_buffer(np.packbits(present, bitorder="little"))
