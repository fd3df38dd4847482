"""Readings of a calibration from a file: a table of numbers, by name of column."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from hknob_cli.errors import UsageError
from hknob_cli.recordings.trial import Array
from hknob_cli.spec.regular import is_endless

MOTOR = ("range_index", "current_a", "direction", "torque_nm")
GRIP_CELL = ("position_m", "force_n", "voltage_v")
_MOST = 20  # faults that are said


def read_columns(paths: Iterable[Path], names: tuple[str, ...]) -> dict[str, Array]:
    """Columns of all files, one after the other. Raises `UsageError` with the file, row and column of every fault."""
    parts: dict[str, list[Array]] = {name: [] for name in names}
    faults: list[str] = []
    for path in paths:
        table = _table(path)
        for name in names:
            if name not in table.column_names:
                faults.append(f"{path}: {name}: missing, and required; there are {', '.join(table.column_names)}")
                continue
            try:
                values = table.column(name).cast(pa.float64()).to_numpy(zero_copy_only=False)
            except pa.ArrowException:
                faults.append(f"{path}: {name}: must be numbers")
                continue
            for row in np.flatnonzero(~np.isfinite(values))[:_MOST]:
                faults.append(f"{path}: row {row + 1}: {name}: must be a finite number, got {values[row]}")
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
        return pq.read_table(path) if parquet else pa.csv.read_csv(path)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from None
    except pa.ArrowException as error:
        raise UsageError(f"{path}: cannot be read: {str(error).splitlines()[0]}") from None
