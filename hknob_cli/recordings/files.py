"""Recording files: read as batches of Arrow columns, in bounded memory, and written as one table or as CSV.

Readings of a calibration are a table, too.
"""

import codecs
import contextlib
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.csv as pc

from hknob_cli.errors import ComputationError, UsageError
from hknob_cli.recordings.columns import KEYS, SAMPLES, SENSED, TEXTS
from hknob_cli.recordings.trial import Array, Trial
from hknob_cli.results.columns import Column
from hknob_cli.results.files import create, put_in_place
from hknob_cli.results.store import partial
from hknob_cli.specs.messages import shown
from hknob_cli.specs.named_file import is_endless
from hknob_cli.specs.parquet import opened, schema_of, sound, table_of

BLOCK_BYTES = 8_000_000
BATCH_ROWS = 100_000
LONGEST_HEADER = 100_000
CELLS = "commas, semicolons or tabs"
SEPARATORS = (",", ";", "\t")  # the first that a header has
_DECIMAL_COMMA = re.compile(rb"(?:^|[;\t\n])[ \"]*[-+]?\d*,\d+(?:[eE][-+]?\d+)?[ \"]*(?=[;\t\n])")
_CODED = pa.dictionary(pa.int32(), pa.string())


class NotReadableError(Exception):
    """A file as a whole cannot be read, and why."""


class RecordingFile:
    """A CSV or Parquet file.

    ``names``: the header as it stands. Cells are parted by commas, or by the semicolons or tabs of a header without
    commas; ``decimal`` is then a comma if a number among the first rows has one. ``lost``: after `texts`, rows with
    too many or too few cells, which it leaves
    out, with their number of cells.
    """

    def __init__(self, path: Path) -> None:
        """Open the header. Raises `NotReadableError`."""
        self.path = path
        self.lost: list[tuple[int, int, int]] = []
        if is_endless(path):
            raise NotReadableError("is not a file; must be CSV or Parquet")
        try:
            with path.open("rb") as stream:
                head = stream.read(4)
        except OSError as error:
            raise NotReadableError(f"cannot be read: {error.strerror or error}") from None
        if not head:
            raise NotReadableError("is empty; must have a header and rows")
        self.is_parquet = head == b"PAR1"
        if not self.is_parquet and path.suffix.lower() in {".parquet", ".pq"}:
            raise NotReadableError("is not a Parquet file, though its name says so")
        self.separator, self.decimal = ",", "."
        self.names = self._header()

    def _header(self) -> list[str]:
        try:
            if self.is_parquet:
                return list(schema_of(self.path).names)
            with pa.input_stream(str(self.path)) as stream:
                line, _, below = stream.read(LONGEST_HEADER).lstrip(b"\r\n").replace(b"\r", b"\n").partition(b"\n")
            there = [mark for mark in SEPARATORS if mark.encode() in line]
            self.separator = there[0] if there else ","
            if self.separator != "," and _DECIMAL_COMMA.search(below):
                self.decimal = ","
            with pc.open_csv(io.BytesIO(line + b"\n"), parse_options=self._parse()) as header:
                return list(header.schema.names)
        except UnicodeDecodeError:
            raise NotReadableError("is neither Parquet nor CSV in UTF-8") from None
        except (pa.ArrowException, OSError) as error:
            kind = "Parquet" if self.is_parquet else "CSV"
            raise NotReadableError(f"cannot be read as {kind}: {first_line(error)}") from None

    def _parse(self, **options: Any) -> pc.ParseOptions:
        return pc.ParseOptions(delimiter=self.separator, **options)

    def typed(self, raw: dict[str, str]) -> Iterator[dict[str, pa.Array]]:
        """Batches of the columns ``raw`` (name to name in the header): reals and, of the keys that are text, codes.

        Raises `pyarrow.ArrowException` where a cell of a CSV file is no number: then ask for `texts`.
        """
        if self.is_parquet:
            yield from self._parquet(raw)
            return
        kinds = {there: _CODED if name in TEXTS else pa.float64() for name, there in raw.items()}
        read = pc.ReadOptions(block_size=BLOCK_BYTES)
        convert = pc.ConvertOptions(column_types=kinds, include_columns=list(raw.values()), decimal_point=self.decimal)
        parse = self._parse()
        with pc.open_csv(self.path, read_options=read, parse_options=parse, convert_options=convert) as stream:
            for batch in stream:
                yield dict(zip(raw, batch.columns, strict=True))

    def texts(self, raw: dict[str, str]) -> Iterator[dict[str, pa.Array]]:
        """The same, but the cells of a CSV file as text; slower. Raises `NotReadableError`."""
        try:
            if self.is_parquet:
                yield from self._parquet(raw)
                return
            self._check_utf8()
            parse = self._parse(invalid_row_handler=self._lose)
            kinds = dict.fromkeys(raw.values(), pa.string())
            convert = pc.ConvertOptions(column_types=kinds, include_columns=list(raw.values()))
            # One thread, for only then are rows numbered.
            read = pc.ReadOptions(block_size=BLOCK_BYTES, use_threads=False)
            stream = pc.open_csv(self.path, read_options=read, parse_options=parse, convert_options=convert)
            with stream:
                for batch in stream:
                    yield dict(zip(raw, batch.columns, strict=True))
        except (pa.ArrowException, OSError) as error:
            raise NotReadableError(f"cannot be read: {first_line(error)}") from None

    def _check_utf8(self) -> None:
        """Raise `NotReadableError` for other bytes; Arrow, where it finds them in a row it gives up, does not."""
        decoder = codecs.getincrementaldecoder("utf-8")()
        lines = 1
        with pa.input_stream(str(self.path)) as stream:
            while True:
                chunk = stream.read(BLOCK_BYTES)
                try:
                    decoder.decode(chunk, final=not chunk)
                except UnicodeDecodeError as error:
                    lines += error.object[: error.start].count(b"\n")
                    raise NotReadableError(f"line {lines}: is not UTF-8 text; save it as such") from None
                if not chunk:
                    return
                lines += chunk.count(b"\n")

    def _lose(self, row: pc.InvalidRow) -> str:
        self.lost.append((row.number - 1, row.actual_columns, row.expected_columns))
        return "skip"

    def _parquet(self, raw: dict[str, str]) -> Iterator[dict[str, pa.Array]]:
        with opened(self.path) as stream:
            for batch in stream.iter_batches(batch_size=BATCH_ROWS, columns=list(raw.values())):
                sound(batch)
                yield {name: batch.column(there) for name, there in raw.items()}


def first_line(error: Exception) -> str:
    """What an error says, in one line."""
    return (str(error).splitlines() or [type(error).__name__])[0]


MOTOR = ("range_index", "current_a", "direction", "torque_nm")
GRIP_CELL = ("position_m", "force_n", "voltage_v")
_MOST = 20  # faults that are said
_LARGEST = 1e6  # of any reading, in its SI unit


def read_columns(paths: Iterable[Path], names: tuple[str, ...]) -> dict[str, Array]:
    """Columns of all files, one after the other. Raises `UsageError` with the file, row and column of every fault."""
    parts: dict[str, list[Array]] = {name: [] for name in names}
    faults: list[str] = []
    for path in paths:
        table = _table(path)
        for name in names:
            if (count := table.column_names.count(name)) != 1:
                there = f"; there are {', '.join(map(shown, table.column_names))}"
                wrong = f"missing, and required{there}" if not count else f"is there {count} times; must be there once"
                faults.append(f"{path}: {name}: {wrong}")
                continue
            try:
                values = table.column(name).cast(pa.float64()).to_numpy(zero_copy_only=False)
            except pa.ArrowException:
                faults.append(f"{path}: {name}: must be numbers")
                continue
            for row in np.flatnonzero(~(np.abs(values) <= _LARGEST))[:_MOST]:
                allowed = f"within {_LARGEST:g}" if np.isfinite(values[row]) else "a finite number"
                faults.append(f"{path}: row {row + 1}: {name}: must be {allowed}, got {values[row]:g}")
            parts[name].append(values)
    if faults:
        raise UsageError("\n".join(faults[:_MOST]))
    found = {name: np.concatenate(columns) for name, columns in parts.items()}
    if not len(found[names[0]]):
        raise UsageError(f"{', '.join(map(str, paths))}: no rows")
    return found


def _table(path: Path) -> pa.Table:
    if is_endless(path):
        raise UsageError(f"{path}: is not a file; must be CSV or Parquet")
    try:
        with path.open("rb") as stream:
            parquet = stream.read(4) == b"PAR1"
        table = table_of(path) if parquet else pa.csv.read_csv(path)
        _ = table.column_names
        return table
    except UnicodeDecodeError:
        raise UsageError(f"{path}: is neither Parquet nor CSV in UTF-8") from None
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from None
    except pa.ArrowException as error:
        raise UsageError(f"{path}: cannot be read: {first_line(error)}") from None


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
