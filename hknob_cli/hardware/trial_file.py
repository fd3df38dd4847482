"""The samples of a finished trial, and its file: rows of a recording, and how it went in the file's metadata.

The samples of one trial as they were received, all blocks in one.
"""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.errors import ComputationError
from hknob_cli.hardware.order import Trial
from hknob_cli.hardware.port import Array, Block, Counts, Flags
from hknob_cli.recordings.columns import KEYS, MEASURED_TORQUE, SAMPLES
from hknob_cli.recordings.files import table as recording_table
from hknob_cli.recordings.trial import Key
from hknob_cli.recordings.trial import Trial as RecordedTrial
from hknob_cli.results.arrays import build_array
from hknob_cli.results.campaign_files import ACCELERATION, MORE_SAMPLES
from hknob_cli.results.columns import Column
from hknob_cli.results.files import create, put_in_place
from hknob_cli.results.parted import sealed_file
from hknob_cli.results.provenance import KEY
from hknob_cli.results.store import partial
from hknob_cli.specs.parquet import table_of
from hknob_cli.specs.plan import COUNTS
from hknob_cli.specs.pulses import Window

ABOUT = b"hknob.trial"
_NOT_BESIDE = ("trial", "table", "started_sample")
_HALF_US = 0.5e-6


class Samples(NamedTuple):
    """Samples of a trial, arrays (n,) as in a `Block`; ``number`` of each since arming, ``overruns`` in all."""

    number: Counts
    time_us: Counts
    angle_counts: Counts
    torque_nm: Array
    grip_n: Array
    running: Flags
    overruns: int
    measured_torque_nm: Array | None = None
    acceleration_rad_s2: Array | None = None

    def angle_rad(self, native_counts: int) -> Array:
        """Angle by the device's own encoder, rad."""
        return np.asarray(self.angle_counts * (2.0 * math.pi / native_counts), dtype=np.float64)


def joined(blocks: Sequence[Block]) -> Samples:
    """All blocks in one."""
    whole = [np.arange(block.first, block.first + len(block.time_us), dtype=np.int64) for block in blocks]
    return Samples(
        number=np.concatenate([np.empty(0, dtype=np.int64), *whole]),
        time_us=np.concatenate([np.empty(0, dtype=np.int64), *(block.time_us for block in blocks)]),
        angle_counts=np.concatenate([np.empty(0, dtype=np.int64), *(block.angle_counts for block in blocks)]),
        torque_nm=np.concatenate([np.empty(0), *(block.torque_nm for block in blocks)]),
        grip_n=np.concatenate([np.empty(0), *(block.grip_n for block in blocks)]),
        running=np.concatenate([np.empty(0, dtype=bool), *(block.running for block in blocks)]),
        overruns=max((block.overruns for block in blocks), default=0),
        measured_torque_nm=_sensed([block.measured_torque_nm for block in blocks]),
        acceleration_rad_s2=_sensed([block.acceleration_rad_s2 for block in blocks]),
    )


def _sensed(parts: Sequence[Array | None]) -> Array | None:
    """What a sensor told in all blocks; None if there is none."""
    found = [part for part in parts if part is not None]
    return np.concatenate(found) if found and len(found) == len(parts) else None


def about_pulse(samples: Samples, fired: int | None, window: Window) -> Samples:
    """The samples from ``window.before`` before the sample ``fired`` to ``window.after`` after it, by their times.

    Where no pulse came, the last ones, for as long a time.
    """
    time_s = samples.time_us * 1e-6
    if fired is None:
        first, last = time_s[-1] - window.before - window.after, time_s[-1]
    else:
        at = time_s[int(np.searchsorted(samples.number, fired))]
        first, last = at - window.before, at + window.after
    kept = slice(int(np.searchsorted(time_s, first - _HALF_US)), int(np.searchsorted(time_s, last + _HALF_US)))
    cut: dict[str, Any] = {
        name: values[kept] for name, values in samples._asdict().items() if isinstance(values, np.ndarray)
    }
    return samples._replace(**cut)


class Recorded(NamedTuple):
    """A trial that is on the disk: its samples as a table, and what is known of it beside.

    ``ended`` and ``settled_sample`` as in an `Outcome`; ``device``: what it calls itself; ``drift`` of its clock by the
    computer's, with its uncertainty, None for one in its own time. ``started_sample``: the first after the start, of a
    trial of a pulse, whose table is `about_pulse`.
    """

    trial: Trial
    table: pa.Table
    ended: str
    settled_sample: int | None
    gaps: int
    overruns: int
    zero_n: float
    device: str
    native_counts: int
    drift: float | None = None
    drift_uncertainty: float | None = None
    started_sample: int | None = None

    @property
    def is_sane(self) -> bool:
        """Whether what is known of it beside is of the kinds that the program writes."""
        words = isinstance(self.ended, str) and isinstance(self.device, str)
        settled = 0 if self.settled_sample is None else self.settled_sample
        wholes = (settled, self.started_sample or 0, self.gaps, self.overruns, self.native_counts)
        return (
            words
            and all(isinstance(one, int) and abs(one) < 2**63 for one in wholes)
            and self.native_counts > 0
            and isinstance(self.zero_n, float)
            and math.isfinite(self.zero_n)
            and all(one is None or isinstance(one, float) for one in (self.drift, self.drift_uncertainty))
        )


def zero_of(samples: Samples) -> float:
    """What the grip cell showed before the start, N."""
    before = samples.grip_n[: int(np.argmax(samples.running)) if samples.running.any() else None]
    return float(before.mean()) if before.size else 0.0


def started_of(samples: Samples) -> int | None:
    """The first sample after the start; None if there is none."""
    return int(samples.number[int(np.argmax(samples.running))]) if samples.running.any() else None


def sample_table(
    samples: Samples, key: Key, trial: Trial, native_counts: int, *, zero_n: float | None = None
) -> pa.Table:
    """Samples as rows: the columns of a recording, then `MORE_SAMPLES`; the zero is subtracted from the grip force.

    ``zero_n``: the zero, where it is not that of these samples.
    """
    recorded = RecordedTrial(
        key=key,
        time_s=np.asarray(samples.time_us * 1e-6, dtype=np.float64),
        torque_nm=samples.torque_nm,
        angle_rad=samples.angle_rad(native_counts),
        grip_n=samples.grip_n - (zero_of(samples) if zero_n is None else zero_n),
        measured_torque_nm=samples.measured_torque_nm,
    )
    found = recording_table([recorded])
    count = samples.number.size
    values: dict[str, Any] = {
        "sample_rate_hz": np.full(count, trial.sample_rate_hz),
        "counts_per_rev": np.full(count, trial.counts_per_rev),
        "sample": samples.number,
        "device_time_us": samples.time_us,
        "angle_counts": samples.angle_counts,
        "running": samples.running,
    }
    for column in _more(trial):
        found = found.append_column(column.field(), build_array(column.type, values[column.name].tolist()))
    if samples.acceleration_rad_s2 is not None:
        told = samples.acceleration_rad_s2.tolist()
        found = found.append_column(ACCELERATION.field(), build_array(ACCELERATION.type, told))
    return found


def write_trial(path: Path, recorded: Recorded, provenance: bytes) -> None:
    """Write a trial, whole or not at all. Raises `ComputationError` if it cannot be written."""
    about = {
        "trial": recorded.trial.values,
        **{name: getattr(recorded, name) for name in Recorded._fields if name not in _NOT_BESIDE},
    }
    if recorded.started_sample is not None:
        about["started_sample"] = recorded.started_sample
    half = partial(path)
    try:
        with create(half) as stream:
            said = {KEY: provenance, ABOUT: json.dumps(about, sort_keys=True).encode()}
            stream.write(sealed_file(recorded.table, said))
        put_in_place(half, path)
    except OSError as error:
        half.unlink(missing_ok=True)
        raise ComputationError(f"{path}: cannot be written: {error.strerror or error}") from None


def read_trial(path: Path) -> Recorded | None:
    """The trial in a file; None where it cannot be read, or is not as `write_trial` leaves one."""
    try:
        table = table_of(path)
        about = json.loads((table.schema.metadata or {})[ABOUT])
        found = Recorded(trial=Trial(**about.pop("trial")), table=table.replace_schema_metadata(None), **about)
    except (OSError, pa.ArrowException, KeyError, ValueError, TypeError, AttributeError, RecursionError):
        return None
    return found if found.is_sane and _are_samples(found.table, found.trial) else None


def _more(trial: Trial) -> tuple[Column, ...]:
    """The columns beside those of a recording: of a pulse no encoder is coarser than the device's own."""
    return tuple(one for one in MORE_SAMPLES if one.name != COUNTS) if trial.grip_target_n else MORE_SAMPLES


def _are_samples(table: pa.Table, trial: Trial) -> bool:
    """Whether a table is of samples one after the other, every one of them whole."""
    sensed = [column for column in (MEASURED_TORQUE,) if column.name in table.column_names]
    last = [column for column in (ACCELERATION,) if column.name in table.column_names]
    kinds = [(column.name, column.type) for column in (*KEYS, *SAMPLES, *sensed, *_more(trial), *last)]
    if [(field.name, field.type) for field in table.schema] != kinds or not table.num_rows:
        return False
    if any(column.null_count for column in table.columns):
        return False
    numbers = [table[column.name].to_numpy() for column in SAMPLES]
    return all(np.isfinite(one).all() for one in numbers) and bool((np.diff(table["time_s"].to_numpy()) > 0.0).all())
