"""Readings of a calibration from a file: a table of numbers, by name of column."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv

from hknob_cli.errors import UsageError
from hknob_cli.recordings.files import first_line
from hknob_cli.recordings.trial import Array
from hknob_cli.specs.messages import shown
from hknob_cli.specs.named_file import is_endless
from hknob_cli.specs.parquet import table_of

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
