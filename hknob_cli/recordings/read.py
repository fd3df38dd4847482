"""Reads recordings: CSV or Parquet files into trials, or all that is wrong with them, with rows."""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa

from hknob_cli.recordings.blocks import Block, blocks
from hknob_cli.recordings.checks import check_trial
from hknob_cli.recordings.columns import MEASURED_TORQUE, OPTIONAL, REQUIRED, SAMPLES
from hknob_cli.recordings.faults import Faults, RecordingError, RowFault
from hknob_cli.recordings.files import NotReadableError, RecordingFile
from hknob_cli.recordings.trial import Array, Key, Trial
from hknob_cli.spec.messages import closest

_SAMPLES = tuple(column.name for column in (*SAMPLES, MEASURED_TORQUE))


def read(paths: Iterable[Path | str]) -> list[Trial]:
    """Trials of all files, in their order.

    Columns as `hknob_cli.recordings.columns` lists them, in any order, others ignored; the rows of a trial are
    consecutive. Raises `RecordingError` with up to 20 faults.
    """
    trials: list[Trial] = []
    found: list[RowFault] = []
    seen: dict[Key, Trial] = {}
    for path in paths:
        faults = Faults(str(path))
        lost: list[int] = []
        try:
            file = RecordingFile(Path(path))
            raw = _columns(file, faults)
            here = _trials_of(file, raw, faults, lost) if raw else []
        except NotReadableError as error:
            faults.add(0, "", str(error))
            here = []
        for trial in here:
            twin = seen.setdefault(trial.key, trial)
            if twin is not trial:
                place = f"{twin.source}, row {twin.first_row}"
                faults.add(trial.first_row, "trial", f"{_said(trial.key)} is already in {place}; must be there once")
        trials += here
        found += faults.listed(lost)
    if found:
        raise RecordingError(found)
    return trials


def _columns(file: RecordingFile, faults: Faults) -> dict[str, str]:
    """Name in the header of each known column; empty if a required one is missing, which is noted."""
    stripped = [name.strip() for name in file.names]
    others = [name for name in stripped if name not in REQUIRED]
    absent = [name for name in REQUIRED if name not in stripped]
    if len(stripped) == 1 and absent:
        for mark, what in ((";", "semicolons"), ("\t", "tabs")):
            if mark in stripped[0]:
                raise NotReadableError(f"has cells separated by {what}; must be by commas")
    for name in absent:
        close = closest(name, others)
        hint = f"; is it '{close}'?" if close else ""
        faults.add(0, name, f"column missing, and required{hint}")
    for name in (*REQUIRED, *OPTIONAL):
        if stripped.count(name) > 1:
            faults.add(0, name, f"column is there {stripped.count(name)} times; must be there once")
    if faults:
        return {}
    return {name: file.names[stripped.index(name)] for name in (*REQUIRED, *OPTIONAL) if name in stripped}


def _trials_of(file: RecordingFile, raw: dict[str, str], faults: Faults, lost: list[int]) -> list[Trial]:
    """Trials of one file; its faults are noted, from its text if it is CSV."""
    if not file.is_parquet:
        try:
            clean = Faults(faults.file)
            trials = _gathered(file.typed(raw), clean)
            if not clean:
                return trials
        except (pa.ArrowException, OSError):
            pass
    trials = _gathered(file.texts(raw), faults)
    for row, cells, expected in file.lost:
        lost.append(row)
        faults.add_row(row, f"has {cells} cells; must have {expected}, as the header")
    return trials


def _gathered(batches: Iterable[dict[str, pa.Array]], faults: Faults) -> list[Trial]:
    """Trials of the rows of one file, checked; stops when there are more faults than are listed."""
    trials: list[Trial] = []
    seen: dict[Key, Trial] = {}
    rows = 0
    for whole in _runs(blocks(batches, faults), faults.file):
        trial = _with_measured(whole, faults)
        rows += trial.time_s.size
        check_trial(trial, faults)
        twin = seen.setdefault(trial.key, trial)
        if twin is not trial:
            end = twin.first_row + twin.time_s.size - 1
            message = f"{_said(trial.key)} has rows {twin.first_row} to {end} already; must be in one piece, and once"
            faults.add(trial.first_row, "trial", message)
        else:
            trials.append(trial)
        if faults.full:
            return []
    if not rows and not faults:
        faults.add(0, "", "has no rows below its header")
    return trials


def _runs(rows: Iterable[Block], source: str) -> Iterator[Trial]:
    """Rows of one key in a row, as trials."""
    key: Key | None = None
    first = 1
    pieces: list[dict[str, Array]] = []
    for block in rows:
        for start, stop in pairwise([*block.starts(), len(block.numbers["time_s"])]):
            here = block.key(start)
            if key is not None and here != key:
                yield _joined(key, pieces, source, first)
                pieces = []
            if not pieces:
                key, first = here, block.first + start
            pieces.append({name: values[start:stop] for name, values in block.numbers.items()})
    if key is not None:
        yield _joined(key, pieces, source, first)


def _joined(key: Key, pieces: list[dict[str, Array]], source: str, first: int) -> Trial:
    """Trial of its pieces, in memory of its own."""
    samples = {name: np.concatenate([piece[name] for piece in pieces]) for name in _SAMPLES if name in pieces[0]}
    return Trial(key=key, **samples, source=source, first_row=first)


def _with_measured(trial: Trial, faults: Faults) -> Trial:
    """Trial without the measured torque if it has none; one with holes is noted."""
    if trial.measured_torque_nm is None:
        return trial
    holes = np.flatnonzero(np.isnan(trial.measured_torque_nm))
    if holes.size == trial.time_s.size:
        return trial._replace(measured_torque_nm=None)
    if holes.size and not faults.has(MEASURED_TORQUE.name):
        message = f"nothing in {holes.size} rows of this trial; must be in all of them, or in none"
        faults.add(trial.first_row + int(holes[0]), MEASURED_TORQUE.name, message)
    return trial


def _said(key: Key) -> str:
    return (
        f"trial {key.trial} of block {key.block} of subject '{key.subject}', experiment '{key.experiment}', "
        f"{key.grip_target_n:g} N"
    )
