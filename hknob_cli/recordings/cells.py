"""Cells of a recording as numbers and names, and which of them are neither."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as compute

from hknob_cli.recordings.faults import MOST
from hknob_cli.recordings.trial import Array
from hknob_cli.specs.messages import shown

_MISSING = ["", "na", "nan", "null", "n/a", "none"]


class Bad(NamedTuple):
    """A cell that is wrong: its row in the array, and the value as it is shown."""

    row: int
    value: str


class Names(NamedTuple):
    """A column of text: distinct ``values`` without space around them, and the ``codes`` of the rows."""

    values: list[str]
    codes: np.ndarray[Any, np.dtype[np.int32]]

    def at(self, row: int) -> str:
        """Name of a row."""
        return self.values[int(self.codes[row])]

    def empty(self) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Rows without a name."""
        nameless = [code for code, value in enumerate(self.values) if not value]
        return np.flatnonzero(np.isin(self.codes, nameless)) if nameless else np.empty(0, dtype=np.int64)


def numbers(cells: pa.Array) -> Array:
    """Reals of a column; NaN where a cell is missing or no number."""
    if _is_text(cells.type):
        cells = _parsed(compute.utf8_trim_whitespace(cells.cast(pa.string())))
    elif pa.types.is_boolean(cells.type) or pa.types.is_temporal(cells.type):
        return np.full(len(cells), np.nan)
    elif cells.type != pa.float64():
        try:
            cells = cells.cast(pa.float64(), safe=False)
        except pa.ArrowException:
            return np.full(len(cells), np.nan)
    return np.asarray(cells.to_numpy(zero_copy_only=False))


def bad_cells(cells: pa.Array, values: Array, *, may_miss: bool = False) -> Iterator[Bad]:
    """First cells that are not finite numbers, no more than are listed; ``may_miss`` allows missing ones and NaN."""
    wrong = np.isinf(values) if may_miss else ~np.isfinite(values)
    if may_miss and _is_text(cells.type):
        lower = compute.utf8_lower(compute.utf8_trim_whitespace(cells.cast(pa.string())))
        missing = compute.is_in(lower, value_set=pa.array(_MISSING)).to_numpy(zero_copy_only=False)
        wrong |= np.isnan(values) & ~missing & ~cells.is_null().to_numpy(zero_copy_only=False)
    elif may_miss and not pa.types.is_floating(cells.type):
        wrong |= np.isnan(values) & ~cells.is_null().to_numpy(zero_copy_only=False)
    for index in np.flatnonzero(wrong)[: MOST + 1]:
        cell = cells[int(index)].as_py()
        empty = cell is None or (isinstance(cell, str) and not cell.strip())
        yield Bad(int(index), "nothing" if empty else shown(cell))


def names(cells: pa.Array) -> Names:
    """Names of a column of text or whole numbers; a missing one is empty."""
    kind = cells.type.value_type if pa.types.is_dictionary(cells.type) else cells.type
    if pa.types.is_floating(kind):
        whole = numbers(cells)
        if np.all(whole == np.floor(whole)):
            cells = cells.cast(pa.float64()).cast(pa.int64())
    if not pa.types.is_dictionary(cells.type):
        cells = cells.cast(pa.string()).dictionary_encode()
    values = [str(value).strip() if value is not None else "" for value in cells.dictionary.to_pylist()]
    if cells.null_count:
        values.append("")
    codes = cells.indices.fill_null(len(values) - 1).to_numpy(zero_copy_only=False)
    return Names(values, codes.astype(np.int32, copy=False))


def _parsed(texts: pa.Array) -> pa.Array:
    """Reals from text; where it fails, halves are tried until the cells that are no numbers are left, as null."""
    try:
        return texts.cast(pa.float64())
    except pa.ArrowException:
        if len(texts) == 1:
            return pa.nulls(1, pa.float64())
    half = len(texts) // 2
    return pa.concat_arrays([_parsed(texts.slice(0, half)), _parsed(texts.slice(half))])


def _is_text(kind: pa.DataType) -> bool:
    if pa.types.is_dictionary(kind):
        kind = kind.value_type
    return any(test(kind) for test in (pa.types.is_string, pa.types.is_large_string, pa.types.is_string_view))
