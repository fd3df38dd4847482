"""Recorded trials as a device gave them: read from files, to be played back, and whether they are of a wall asked for.

A folder stands for its ``samples.parquet``. Beside the columns of a recording those of a campaign are used where they
are there: the cell, and what the device itself counted. Without them the angle is put into counts of `FINEST`, the wall
counts as on from the sample before the knob first moves, and the recorded torque tells for how many counts it is.
"""

from collections.abc import Iterable
from math import tau
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc

from hknob_cli.errors import UsageError
from hknob_cli.hardware.port import Array, Counts, Flags, Settings
from hknob_cli.hardware.wall_law import wall_torque
from hknob_cli.recordings.files import RecordingFile, first_line
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Trial
from hknob_cli.specs.named_file import inside
from hknob_cli.specs.parquet import table_of
from hknob_cli.specs.plan import COUNTS, RATE

FINEST = 2**24  # counts per revolution where a recording has an angle in radians only
MOST_COUNTS = 2**31  # that an encoder has
_EXTRA = {
    RATE: pa.float64(),
    COUNTS: pa.int64(),
    "sample": pa.int64(),
    "device_time_us": pa.int64(),
    "angle_counts": pa.int64(),
    "running": pa.bool_(),
}
_RANGES = {
    RATE: (1e-3, 1e9),
    COUNTS: (1, MOST_COUNTS),
    "sample": (0, 2**53),
    "device_time_us": (0, 2**53),
    "angle_counts": (-(2**53), 2**53),
    "running": (0, 1),
}
_ALIKE = 0.98  # share of the samples whose torque must be the wall's: one by an edge may be rounded to the other side


class RecordedTrial(NamedTuple):
    """One recorded trial, arrays (n,) as in a `Block`; ``number``: index of each sample since arming.

    ``counts_per_rev`` of the wall's encoder, None where the recording does not say; ``native_counts`` of the device's.
    """

    name: str
    sample_rate_hz: float
    counts_per_rev: int | None
    native_counts: int
    number: Counts
    time_us: Counts
    angle_counts: Counts
    torque_nm: Array
    grip_n: Array
    running: Flags

    def __str__(self) -> str:
        counts = "counts not said" if self.counts_per_rev is None else f"{self.counts_per_rev} counts"
        return f"{self.sample_rate_hz:g} Hz with {counts}"


def read_takes(paths: Iterable[Path]) -> list[RecordedTrial]:
    """Trials of recordings, CSV or Parquet, or of campaigns' folders, in their order.

    Raises `UsageError` if one cannot be read, or if they are of different encoders.
    """
    takes: list[RecordedTrial] = []
    for path in paths:
        file = inside(path, "samples.parquet")
        trials = read([file])
        if any(np.isnan(trial.grip_n).any() for trial in trials):
            raise UsageError(f"{file}: grip_n: missing, and required of what is replayed")
        extra = _extra_columns(file)
        takes += [_take(trial, extra) for trial in trials]
    natives = sorted({take.native_counts for take in takes})
    if len(natives) > 1:
        raise UsageError(f"the recordings are of different encoders, of {', '.join(map(str, natives))} counts")
    return takes


def is_of_wall(take: RecordedTrial, settings: Settings) -> bool:
    """Whether the recorded torque is that of the wall in docs/reference/wire.md, at the recorded angles.

    A recording in which the knob was never inside the wall fits any.
    """
    on = np.flatnonzero(take.running)
    expected = wall_torque(take.angle_counts, settings, take.native_counts, before=None).torque_nm[on]
    found = take.torque_nm[on]
    acts = (expected != 0.0) | (found != 0.0)
    if not acts.any():
        return True
    alike = np.abs(expected - found) <= 2e-7 * np.maximum(np.abs(expected), np.abs(found))
    return bool(alike[acts].mean() >= _ALIKE)


def _extra_columns(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Those of `_EXTRA` that a file has. Raises `UsageError` where one has no value, or one of another type."""
    file = RecordingFile(path)
    names = {name.strip(): name for name in file.names if name.strip() in _EXTRA}
    if not names:
        return {}
    for name in names:
        if (count := [one.strip() for one in file.names].count(name)) > 1:
            raise UsageError(f"{path}: {name}: column is there {count} times; must be there once")
    try:
        if file.is_parquet:
            table = table_of(path, list(names.values()))
        else:
            table = pc.read_csv(path, convert_options=pc.ConvertOptions(include_columns=list(names.values())))
    except (pa.ArrowException, OSError) as error:
        raise UsageError(f"{path}: cannot be read: {first_line(error)}") from None
    found = {}
    for name, written in names.items():
        try:
            column = table[written].cast(_EXTRA[name])
        except pa.ArrowException:
            raise UsageError(f"{path}: {name}: must be of type {_EXTRA[name]}, is {table[written].type}") from None
        if column.null_count:
            raise UsageError(f"{path}: {name}: nothing in {column.null_count} rows; must be in all of them")
        found[name] = column.to_numpy()
        low, high = _RANGES[name]
        odd = np.flatnonzero(~((found[name] >= low) & (found[name] <= high)))
        if odd.size:
            text = f"must be from {low:g} to {high:g}, got {found[name][odd[0]]:g}"
            raise UsageError(f"{path}: row {odd[0] + 1}: {name}: {text}")
    return found


def _take(trial: Trial, extra: dict[str, np.ndarray[Any, Any]]) -> RecordedTrial:
    rows = slice(trial.first_row - 1, trial.first_row - 1 + trial.time_s.size)
    own = {name: values[rows] for name, values in extra.items()}
    name = f"{trial.source}, trial {trial.key.trial} of block {trial.key.block}"
    if trial.time_s.size < 2:
        raise UsageError(f"{name}: has one sample; it takes more to tell its sample rate")
    counts = own.get("angle_counts")
    native = FINEST if counts is None else _native_counts(counts, trial.angle_rad, name)
    if counts is None:
        counts = np.floor(trial.angle_rad * (FINEST / tau)).astype(np.int64)
    time_us = own.get("device_time_us")
    if time_us is None:
        time_us = np.floor((trial.time_s - trial.time_s[0]) * 1e6 + 0.5).astype(np.int64)
    running = own.get("running")
    if running is None:
        moved = np.flatnonzero(counts != counts[0])
        running = np.arange(counts.size) >= (moved[0] - 1 if moved.size else 0)
    rate = own[RATE][0] if RATE in own else _round_rate(trial.time_s)
    return RecordedTrial(
        name=name,
        sample_rate_hz=float(rate),
        counts_per_rev=int(own[COUNTS][0]) if COUNTS in own else None,
        native_counts=native,
        number=own.get("sample", np.arange(counts.size, dtype=np.int64)),
        time_us=time_us,
        angle_counts=counts,
        torque_nm=trial.torque_nm,
        grip_n=trial.grip_n,
        running=running,
    )


def _native_counts(counts: Counts, angle_rad: Array, name: str) -> int:
    """Counts per revolution by which angles were told, from the largest of them. Raises `UsageError`."""
    at = int(np.abs(counts).argmax())
    count, angle = float(counts[at]), float(angle_rad[at])
    if count == 0.0:
        return FINEST
    if angle == 0.0 or not 0.5 <= tau * count / angle <= MOST_COUNTS:
        raise UsageError(f"{name}: {count:.0f} angle_counts where angle_rad is {angle:g}: no encoder has so many")
    return round(tau * count / angle)


def _round_rate(time_s: Array) -> float:
    """Sample rate of recorded times: a whole number of hertz where they are within a thousandth of one."""
    rate = 1.0 / float(np.median(np.diff(time_s)))
    whole = float(round(rate))
    return whole if abs(rate - whole) <= 1e-3 * rate else rate
