"""Writes recordings: trials as one table, or as a CSV file."""

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc

from hknob_cli.errors import ComputationError
from hknob_cli.recordings.columns import KEYS, SAMPLES, SENSED
from hknob_cli.recordings.trial import Trial
from hknob_cli.results.columns import Column
from hknob_cli.results.files import create, put_in_place
from hknob_cli.results.store import partial

_WRITE_ROWS = 16_384


def table(trials: Sequence[Trial]) -> pa.Table:
    """One row per sample, trials one after another, each column with unit and meaning.

    The measured torque is a column where any trial has one, null in the others; so is the grip where none was measured.
    Laid out from the arrays' memory.
    """
    columns = [*KEYS, *SAMPLES]
    lengths = np.array([trial.time_s.size for trial in trials], dtype=np.int64)
    arrays = []
    for column in KEYS:
        values = [getattr(trial.key, column.name) for trial in trials]
        if column.type == pa.string():
            arrays.append(_repeated(values, lengths))
        else:
            kind = np.int64 if column.type == pa.int64() else np.float64
            arrays.append(_plain(column.type, np.repeat(np.array(values, dtype=kind), lengths)))
    for column in SAMPLES:
        numbers = _chained([getattr(trial, column.name) for trial in trials])
        there = ~np.isnan(numbers)
        hidden = column.name == "grip_n" and not there.all()
        arrays.append(_plain(column.type, numbers, _mask(there) if hidden else None))
    for column in SENSED:
        if any(getattr(trial, column.name) is not None for trial in trials):
            columns.append(column)
            arrays.append(_measured(column, trials, lengths))
    return pa.Table.from_arrays(arrays, schema=pa.schema([column.field() for column in columns]))


def write_csv(path: Path, trials: Sequence[Trial]) -> None:
    """Write trials as CSV, numbers with the digits that give them back exactly; whole or not at all.

    Raises `ComputationError` if it cannot be written.
    """
    half = partial(path)
    try:
        with create(half) as stream:
            pc.write_csv(table(trials), stream, pc.WriteOptions(batch_size=_WRITE_ROWS))
        put_in_place(half, path)
    except OSError as error:
        raise ComputationError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        with contextlib.suppress(OSError):
            half.unlink(missing_ok=True)


def _chained(parts: Sequence[Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.concatenate([np.empty(0), *parts]).astype(np.float64, copy=False)


def _plain(kind: pa.DataType, values: np.ndarray[Any, Any], valid: pa.Buffer | None = None) -> pa.Array:
    return pa.Array.from_buffers(kind, len(values), [valid, pa.py_buffer(np.ascontiguousarray(values))])


def _repeated(values: Sequence[str], lengths: np.ndarray[Any, np.dtype[np.int64]]) -> pa.Array:
    """Text, each value as often as its trial has samples."""
    pieces = [value.encode() for value in values]
    sizes = np.repeat(np.array([len(piece) for piece in pieces], dtype=np.int64), lengths)
    ends = np.concatenate([[0], np.cumsum(sizes)])
    content = b"".join(piece * int(length) for piece, length in zip(pieces, lengths, strict=True))
    buffers = [None, pa.py_buffer(ends.astype(np.int32)), pa.py_buffer(content)]
    return pa.Array.from_buffers(pa.string(), len(sizes), buffers)


def _measured(column: Column, trials: Sequence[Trial], lengths: np.ndarray[Any, np.dtype[np.int64]]) -> pa.Array:
    found = [getattr(trial, column.name) for trial in trials]
    there = np.repeat(np.array([one is not None for one in found]), lengths)
    values = _chained(
        [np.zeros(trial.time_s.size) if one is None else one for trial, one in zip(trials, found, strict=True)]
    )
    return _plain(column.type, values, None if there.all() else _mask(there))


def _mask(there: np.ndarray[Any, Any]) -> pa.Buffer:
    return pa.py_buffer(np.packbits(there, bitorder="little"))
