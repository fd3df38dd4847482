"""Rows of a recording in blocks: its cells made numbers and names, and where one trial ends and the next begins.

Cells of a recording as numbers and names, and which of them are neither.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as compute

from hknob_cli.recordings.columns import MAY_MISS, MOST, TEXTS, Faults
from hknob_cli.recordings.files import NotReadableError
from hknob_cli.recordings.trial import Array, Key
from hknob_cli.specs.messages import shown

_MISSING = ["", "na", "nan", "null", "n/a", "none"]

_WHOLE = ("block", "trial")
_NUMBERS = ("grip_target_n", *_WHOLE)
_LARGEST_WHOLE = 2.0**53


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


def numbers(cells: pa.Array, decimal: str = ".") -> Array:
    """Reals of a column; NaN where a cell is missing or no number. ``decimal``: the mark of fractions in text."""
    if _is_text(cells.type):
        texts = compute.utf8_trim_whitespace(cells.cast(pa.string()))
        if decimal == ",":
            points = compute.match_substring(texts, ".")
            texts = compute.if_else(points, None, compute.replace_substring(texts, ",", "."))
        cells = _parsed(texts)
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


class Block(NamedTuple):
    """Consecutive rows as numbers and names; ``first`` is the row of the first."""

    first: int
    numbers: dict[str, Array]
    names: dict[str, Names]

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.numbers["time_s"])

    def key(self, index: int) -> Key:
        """Key of a row."""
        subject, experiment = (self.names[name].at(index) for name in TEXTS)
        grip, block, trial = (float(self.numbers[name][index]) for name in _NUMBERS)
        return Key(subject, experiment, grip, int(block), int(trial))

    def starts(self) -> list[int]:
        """Rows of this block at which the key changes, and the first."""
        changes = np.zeros(len(self.numbers["time_s"]), dtype=bool)
        changes[:1] = True
        keys: list[np.ndarray[Any, Any]] = [self.numbers[name] for name in _NUMBERS]
        keys += [column.codes for column in self.names.values()]
        for values in keys:
            changes[1:] |= values[1:] != values[:-1]
        return [int(start) for start in np.flatnonzero(changes)]


def blocks(
    batches: Iterable[dict[str, pa.Array]],
    faults: Faults,
    constants: Mapping[str, str | float],
    factors: Mapping[str, float],
    decimal: str = ".",
) -> Iterator[Block]:
    """Rows of batches as numbers and names; cells that are neither are noted, and keys stay as in the row before.

    ``constants``: keys that are no columns of the file; ``factors``: by which a column's numbers become SI;
    ``decimal``: the mark of fractions in cells that are text. Raises `NotReadableError` for names of another type.
    """
    first = 1
    why = "; this file has decimal commas" if decimal == "," else ""
    for batch in batches:
        count = len(batch["time_s"])
        texts = {name: _names(name, batch[name]) for name in TEXTS if name in batch}
        for name, column in texts.items():
            for index in column.empty()[: MOST + 1]:
                faults.add(first + int(index), name, "must be text or a whole number, got nothing")
        reals = {name: numbers(cells, decimal) for name, cells in batch.items() if name not in TEXTS}
        for name, values in reals.items():
            if not np.isfinite(values).all():
                for bad in bad_cells(batch[name], values, may_miss=name in MAY_MISS):
                    faults.add(first + bad.row, name, f"must be a finite number, got {bad.value}{why}")
        reals |= {name: factors[name] * reals[name] for name in reals if factors.get(name, 1.0) != 1.0}
        for name in _WHOLE:
            if name in reals:
                _check_whole(name, reals[name], first, faults)
        reals |= {name: _filled(reals[name]) for name in _NUMBERS if name in reals}
        for name, value in constants.items():
            if isinstance(value, str):
                texts[name] = Names([value], np.zeros(count, dtype=np.int32))
            else:
                reals[name] = np.full(count, float(value))
        texts = {name: texts[name] for name in TEXTS}
        if faults.full:
            return
        if len(reals["time_s"]):
            yield Block(first, reals, texts)
        first += len(reals["time_s"])


def _names(column: str, cells: pa.Array) -> Names:
    try:
        return names(cells)
    except pa.ArrowException:
        raise NotReadableError(f"{column}: is of type {cells.type}; must be text or whole numbers") from None


def _check_whole(name: str, values: Array, first: int, faults: Faults) -> None:
    with np.errstate(invalid="ignore"):
        whole = (values == np.floor(values)) & (values >= 0.0) & (values < _LARGEST_WHOLE)
    same = np.concatenate([[False], values[1:] == values[:-1]])  # said once, not in every row of a trial
    for index in np.flatnonzero(np.isfinite(values) & ~whole & ~same)[: MOST + 1]:
        faults.add(first + int(index), name, f"must be a whole number >= 0, got {values[index]:g}")


def _filled(values: Array) -> Array:
    """Values with each that is not finite replaced by the one before it, so that a bad cell does not part a trial."""
    good = np.isfinite(values)
    if good.all():
        return values
    last = np.maximum.accumulate(np.where(good, np.arange(values.size), 0))
    return np.nan_to_num(values[last], nan=0.0, posinf=0.0, neginf=0.0)
