"""The replay device: recorded trials, read from files and played back through the device port.

A folder stands for its ``samples.parquet``. Beside the columns of a recording those of a campaign are used where they
are there: the cell, and what the device itself counted. Without them the angle is put into counts of `FINEST`, the wall
counts as on from the sample before the knob first moves, and the recorded torque tells for how many counts it is.

The replay device: plays recorded trials back through the device port, each for the settings it was made with.
"""

from collections.abc import Iterable
from math import tau
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc

from hknob_cli.errors import DeviceError, UsageError
from hknob_cli.hardware.port import Array, Block, ComputedDevice, Counts, Flags, Identity, Settings, Simulated
from hknob_cli.hardware.safety import AgreedWall
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

_SAME_RATE = 1e-3  # by how much a recorded sample rate may be off


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
    expected = AgreedWall(settings, take.native_counts).follow(take.angle_counts, take.running).torque_nm[on]
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
    if angle == 0.0 or not 0.5 < tau * count / angle <= MOST_COUNTS:
        raise UsageError(f"{name}: {count:.0f} angle_counts where angle_rad is {angle:g}: no encoder has so many")
    return round(tau * count / angle)


def _round_rate(time_s: Array) -> float:
    """Sample rate of recorded times: a whole number of hertz where they are within a thousandth of one."""
    rate = 1.0 / float(np.median(np.diff(time_s)))
    whole = float(round(rate))
    return whole if abs(rate - whole) <= 1e-3 * rate else rate


class ReplayDevice(ComputedDevice):
    """A device that gives what was recorded, as fast as it is read.

    A trial is found by its sample rate, its counts per revolution and the torque of its wall; where there are several,
    they take turns, in the order of the files. Overruns are not in a recording's samples: none are told.
    """

    def __init__(self, paths: Iterable[Path]) -> None:
        """Read recordings, or folders of campaigns. Raises `UsageError` where that cannot be done."""
        self._takes = read_takes(paths)
        if not self._takes:
            raise UsageError("there is nothing to replay")
        self._identity = Identity("replay", self._takes[0].native_counts, 1, False, 1, knows_control=True)
        self._turns: dict[Settings, int] = {}
        self._chosen: tuple[RecordedTrial, Settings] | None = None
        self._playing: _Playing | None = None
        self._started = False

    @property
    def identity(self) -> Identity:
        """Who answers: nobody any more; ``native_counts`` are those of the recording's encoder."""
        return self._identity

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:  # noqa: ARG002 - was somebody
        """Find the recording for a trial's settings. Raises `DeviceError`, with what is there, if there is none."""
        self._must(self._playing is None, "be idle")
        rate = 1e9 / settings.period_ns
        near = [take for take in self._takes if abs(take.sample_rate_hz / rate - 1.0) <= _SAME_RATE]
        near = [take for take in near if take.counts_per_rev in (settings.counts_per_rev, None)]
        fitting = [take for take in near if is_of_wall(take, settings)]
        if not fitting:
            raise DeviceError(_not_there(settings, near, self._takes))
        turn = self._turns.get(settings, 0)
        self._turns[settings] = turn + 1
        self._chosen = fitting[turn % len(fitting)], settings

    def arm(self) -> None:
        """Go to the first sample of the recording. Raises `DeviceError` if it is not idle, or has no settings."""
        self._must(self._playing is None, "be idle")
        if self._chosen is None:
            raise DeviceError("the replay device cannot be armed: it was given no settings")
        self._playing, self._started = _Playing(*self._chosen), False

    def start(self) -> None:
        """Go on to the first sample with the wall on. Raises `DeviceError` if the device is not armed."""
        if self._playing is None or self._started:
            raise DeviceError("the replay device must be armed for that")
        self._playing.start()
        self._started = True

    def read(self, timeout_s: float) -> Block | None:  # noqa: ARG002 - nothing takes time here
        """The next recorded samples, at once; None where there are no more, none before `start`, or after `stop`."""
        return self._playing.block(started=self._started) if self._playing else None

    def stop(self) -> None:
        """End it; what was not read is left. Raises `DeviceError` if the device is not armed."""
        self._must(self._playing is not None, "be armed")
        self._playing = None

    def release(self) -> None:
        """End it, whatever state it is in."""
        self._playing = None

    def _must(self, is_so: bool, what: str) -> None:
        if not is_so:
            raise DeviceError(f"the replay device must {what} for that")


class _Playing:
    """A recording as it is played: how far, and what was skipped.

    What is left before the start is skipped, and index and time go on without a gap. Gaps that were recorded are gaps.
    """

    def __init__(self, take: RecordedTrial, settings: Settings) -> None:
        self._take, self._settings = take, settings
        on = np.flatnonzero(take.running)
        self._first_on = int(on[0]) if on.size else take.number.size
        self._at = self._skipped = self._skipped_us = 0

    def start(self) -> None:
        take, at, first = self._take, self._at, self._first_on
        if at < first < take.number.size:
            number, time_us = int(take.number[at]), int(take.time_us[at])
            self._skipped, self._skipped_us = int(take.number[first]) - number, int(take.time_us[first]) - time_us
        self._at = first

    def block(self, *, started: bool) -> Block | None:
        take = self._take
        end = min(self._at + self._settings.block_samples, take.number.size if started else self._first_on)
        if end <= self._at:
            return None
        holes = np.flatnonzero(np.diff(take.number[self._at : end]) != 1)
        end = self._at + int(holes[0]) + 1 if holes.size else end
        part = slice(self._at, end)
        self._at = end
        return Block(
            first=int(take.number[part.start]) - self._skipped,
            time_us=take.time_us[part] - self._skipped_us,
            angle_counts=take.angle_counts[part],
            torque_nm=take.torque_nm[part],
            grip_n=take.grip_n[part],
            running=take.running[part],
            overruns=0,
        )


def _not_there(settings: Settings, near: list[RecordedTrial], takes: list[RecordedTrial]) -> str:
    """Why no recording is of these settings, and what there is."""
    asked = f"{1e9 / settings.period_ns:g} Hz with {settings.counts_per_rev} counts"
    if near:
        wall = f"{settings.wall_stiffness:g} N·m/rad and {settings.wall_damping:g} N·m·s/rad"
        return f"the recording of {asked} is not of a wall of {wall}: its torque is another ({near[0].name})"
    there = dict.fromkeys(str(take) for take in takes)
    return f"no recording of {asked}; there are: {', '.join(there)}"
