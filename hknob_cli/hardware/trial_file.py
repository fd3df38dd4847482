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
from hknob_cli.recordings.columns import KEYS, SAMPLES
from hknob_cli.recordings.trial import Key
from hknob_cli.recordings.trial import Trial as RecordedTrial
from hknob_cli.recordings.write import table as recording_table
from hknob_cli.results.arrays import build_array
from hknob_cli.results.campaign_files import MORE_SAMPLES
from hknob_cli.results.files import create, put_in_place
from hknob_cli.results.parted import sealed_file
from hknob_cli.results.provenance import KEY
from hknob_cli.results.store import partial
from hknob_cli.specs.parquet import table_of

ABOUT = b"hknob.trial"
_COLUMNS = (*KEYS, *SAMPLES, *MORE_SAMPLES)


class Samples(NamedTuple):
    """Samples of a trial, arrays (n,) as in a `Block`; ``number`` of each since arming, ``overruns`` in all."""

    number: Counts
    time_us: Counts
    angle_counts: Counts
    torque_nm: Array
    grip_n: Array
    running: Flags
    overruns: int

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
    )


class Recorded(NamedTuple):
    """A trial that is on the disk: its samples as a table, and what is known of it beside.

    ``ended`` and ``settled_sample`` as in an `Outcome`; ``device``: what it calls itself; ``drift`` of its clock by the
    computer's, with its uncertainty, None for one in its own time.
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

    @property
    def is_sane(self) -> bool:
        """Whether what is known of it beside is of the kinds that the program writes."""
        words = isinstance(self.ended, str) and isinstance(self.device, str)
        settled = 0 if self.settled_sample is None else self.settled_sample
        wholes = (settled, self.gaps, self.overruns, self.native_counts)
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


def sample_table(samples: Samples, key: Key, trial: Trial, native_counts: int) -> pa.Table:
    """Samples as rows: the columns of a recording, then `MORE_SAMPLES`; the zero is subtracted from the grip force."""
    recorded = RecordedTrial(
        key=key,
        time_s=np.asarray(samples.time_us * 1e-6, dtype=np.float64),
        torque_nm=samples.torque_nm,
        angle_rad=samples.angle_rad(native_counts),
        grip_n=samples.grip_n - zero_of(samples),
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
    for column in MORE_SAMPLES:
        found = found.append_column(column.field(), build_array(column.type, values[column.name].tolist()))
    return found


def write_trial(path: Path, recorded: Recorded, provenance: bytes) -> None:
    """Write a trial, whole or not at all. Raises `ComputationError` if it cannot be written."""
    about = {
        "trial": recorded.trial.values,
        **{name: getattr(recorded, name) for name in Recorded._fields if name not in ("trial", "table")},
    }
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
    return found if found.is_sane and _are_samples(found.table) else None


def _are_samples(table: pa.Table) -> bool:
    """Whether a table is of samples one after the other, every one of them whole."""
    kinds = [(column.name, column.type) for column in _COLUMNS]
    if [(field.name, field.type) for field in table.schema] != kinds or not table.num_rows:
        return False
    if any(column.null_count for column in table.columns):
        return False
    numbers = [table[column.name].to_numpy() for column in SAMPLES]
    return all(np.isfinite(one).all() for one in numbers) and bool((np.diff(table["time_s"].to_numpy()) > 0.0).all())
