"""The columns of a recording, what every trial must be, and faults with file, row and column.

What every trial must be: time that rises, magnitudes that a knob and a hand can have; larger ones are said.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.errors import UsageError, printable
from hknob_cli.recordings.trial import Array, Trial
from hknob_cli.results.campaign_files import ACCELERATION
from hknob_cli.results.columns import Column

KEYS = (
    Column("subject", pa.string(), "", "who held the knob"),
    Column("experiment", pa.string(), "", "grasp and knob"),
    Column("grip_target_n", pa.float64(), "N", "target of the grip force"),
    Column("block", pa.int64(), "1", "block of trials, between which the hand let go"),
    Column("trial", pa.int64(), "1", "number of the trial in its block"),
)
SAMPLES = (
    Column("time_s", pa.float64(), "s", "time, rising within a trial"),
    Column("torque_nm", pa.float64(), "N*m", "commanded torque, from this sample to the next, positive as the angle"),
    Column("angle_rad", pa.float64(), "rad", "measured angle of the knob"),
    Column("grip_n", pa.float64(), "N", "measured grip force"),
)
MEASURED_TORQUE = Column("measured_torque_nm", pa.float64(), "N*m", "measured torque; null where there is no sensor")

TEXTS = ("subject", "experiment")
REQUIRED = ("time_s", "angle_rad")
TORQUES = ("torque_nm", MEASURED_TORQUE.name)  # of which one must be there
SENSED = (MEASURED_TORQUE, ACCELERATION)  # of sensors that few have
MAY_MISS = ("grip_n", *(column.name for column in SENSED))  # in all rows of a trial
EVERY = tuple(column.name for column in (*KEYS, *SAMPLES, *SENSED))
UNNAMED = "unnamed"  # subject and experiment of a file without such columns


class Limit(NamedTuple):
    """Largest magnitude that is no surprise, and the unit that a larger one was probably given in.

    ``key``: of the spec's ``limits``, which raises it.
    """

    most: float
    unit: str
    likely: str
    key: str


LIMITS = {
    "angle_rad": Limit(100.0, "rad", "degrees or counts", "angle"),
    "torque_nm": Limit(10.0, "N m", "mN m", "torque"),
    "measured_torque_nm": Limit(10.0, "N m", "mN m", "torque"),
    ACCELERATION.name: Limit(1e5, "rad/s^2", "deg/s^2", "acceleration"),
    "grip_n": Limit(1000.0, "N", "mN or grams", "force"),
    "grip_target_n": Limit(1000.0, "N", "mN or grams", "force"),
}
LARGEST = 1e6  # of any number, in SI units: beyond it is no knob
LONGEST_STEP_S = 1.0
LONGEST_TRIAL_S = 1000.0


MOST = 20


class RowFault(NamedTuple):
    """One fault; ``row`` counts from 1 below the header, 0 for the file as a whole."""

    file: str
    row: int
    column: str
    message: str

    def __str__(self) -> str:
        row = f"row {self.row}" if self.row else ""
        return printable(": ".join(part for part in (self.file, row, self.column, self.message) if part))


class RecordingError(UsageError):
    """Recordings with faults, one line each; at most 20 are listed, by file and row."""

    def __init__(self, faults: Sequence[RowFault]) -> None:
        self.faults = tuple(faults[:MOST])
        lines = [str(fault) for fault in self.faults]
        if len(faults) > MOST:
            lines.append(f"only the first {MOST} faults are listed")
        super().__init__("\n".join(lines))


class Faults:
    """Collects the faults of one file, in the order of its rows."""

    def __init__(self, file: str, sources: Mapping[str, str] | None = None) -> None:
        """``sources``: names of columns in the file, where they differ."""
        self.file = file
        self.sources = {} if sources is None else sources
        self.absent: set[str] = set()  # keys that are no columns of the file
        self.warnings: list[RowFault] = []
        self._found: list[RowFault] = []
        self._of_rows: list[RowFault] = []
        self._said: set[tuple[str, str]] = set()

    def add(self, row: int, column: str, message: str) -> None:
        """Note a fault."""
        self._found.append(RowFault(self.file, row, self._shown(column), message))

    def warn(self, row: int, column: str, message: str) -> None:
        """Note what is read all the same; only the first of a column."""
        if ("warning", column) not in self._said:
            self._said.add(("warning", column))
            self.warnings.append(RowFault(self.file, row, self._shown(column), message))

    def _shown(self, column: str) -> str:
        there = self.sources.get(column, column)
        return column if there == column else f"{column} (column '{there}')"

    def add_row(self, row: int, message: str) -> None:
        """Note a fault of a row as a whole, ``row`` as the file counts it."""
        self._of_rows.append(RowFault(self.file, row, "", message))

    def add_once(self, rule: str, row: int, column: str, message: str) -> None:
        """Note a fault that one mistake makes in every row, such as a wrong unit: only the first of a column."""
        if (rule, column) not in self._said:
            self._said.add((rule, column))
            self.add(row, column, message)

    def has(self, column: str) -> bool:
        """Whether a fault of ``column`` was noted."""
        return any(fault.column in (column, self._shown(column)) for fault in self._found)

    @property
    def full(self) -> bool:
        """Whether there are more than are listed; reading on tells nothing."""
        return len(self._found) > MOST

    def listed(self, lost: Sequence[int] = ()) -> list[RowFault]:
        """All faults by row, where the rows ``lost`` (as the file counts them) were left out in counting the others."""
        found = [fault._replace(row=_in_file(fault.row, lost)) for fault in self._found]
        found += self._of_rows
        return sorted(found, key=lambda fault: fault.row)

    def __bool__(self) -> bool:
        return bool(self._found or self._of_rows)


def _in_file(row: int, lost: Sequence[int]) -> int:
    """Row as the file counts it."""
    for gone in sorted(lost):
        if 0 < gone <= row:
            row += 1
    return row


def check_trial(trial: Trial, faults: Faults, limits: Mapping[str, float]) -> tuple[str, ...]:
    """Note what is wrong with a trial; what is surprising. Not finite values are noted elsewhere and pass here.

    ``limits``: largest size of a column that is no surprise, by default `columns.LIMITS`.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        _check_time(trial, faults)
    notes: list[str] = []
    for column in ("torque_nm", "angle_rad", "grip_n", *(one.name for one in SENSED)):
        values: Array | None = getattr(trial, column)
        if values is not None:
            notes += _check_size(column, values, trial.first_row, faults, limits)
    target = trial.key.grip_target_n
    if target < 0.0:
        faults.add_once("sign", trial.first_row, "grip_target_n", f"must be >= 0 N, got {target:g}")
    notes += _check_size("grip_target_n", np.array([target]), trial.first_row, faults, limits)
    return tuple(notes)


def _check_time(trial: Trial, faults: Faults) -> None:
    time, first = trial.time_s, trial.first_row
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        at = int(back[0]) + 1
        how = "stands still" if steps[at - 1] == 0.0 else "runs backwards"
        alone = ", and a file without a column 'trial' is one trial" if "trial" in faults.absent else ""
        more = f" ({back.size} times in this trial)" if back.size > 1 else ""
        message = f"{how}{more}, {time[at]:.17g} after {time[at - 1]:.17g}; must rise within a trial{alone}"
        faults.add(first + at, "time_s", message)
    far = np.flatnonzero(steps > LONGEST_STEP_S)
    if far.size:
        at = int(far[0]) + 1
        message = f"step of {steps[at - 1]:g} s; must be <= {LONGEST_STEP_S:g} s: is it in ms?"
        faults.add_once("unit", first + at, "time_s", message)
    elif time.size and time[-1] - time[0] > LONGEST_TRIAL_S:
        at = int(np.flatnonzero(time - time[0] > LONGEST_TRIAL_S)[0])
        message = f"trial of {time[-1] - time[0]:g} s; must be <= {LONGEST_TRIAL_S:g} s: is it in ms?"
        faults.add_once("unit", first + at, "time_s", message)


def _check_size(column: str, values: Array, first: int, faults: Faults, limits: Mapping[str, float]) -> Iterator[str]:
    """Note numbers that are none of a knob; say those that are surprising."""
    limit = LIMITS[column]
    most = limits.get(column, limit.most)
    over = np.flatnonzero((np.abs(values) > most) & ~np.isinf(values))
    if not over.size:
        return
    at = int(over[0])
    size = float(np.max(np.abs(values[over])))
    if size > LARGEST:
        message = f"must be within {LARGEST:g} {limit.unit}, got {values[at]:g}: is it in {limit.likely}?"
        faults.add_once("unit", first + at, column, message)
        return
    message = f"{values[at]:g} {limit.unit} is beyond {most:g} {limit.unit}: is it in {limit.likely}?"
    allowed = f"limits: {{{limit.key}: {float(f'{2.0 * size:.1g}'):g}}} says that it is right"
    faults.warn(first + at, column, f"{message} {allowed}")
    yield f"{column} up to {size:.3g} {limit.unit}, beyond {most:g} {limit.unit}: is it in {limit.likely}?"
