"""Reads recordings: CSV or Parquet files into trials, or all that is wrong with them, with rows."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.recordings.blocks import Block, blocks
from hknob_cli.recordings.columns import (
    EVERY,
    MAY_MISS,
    REQUIRED,
    SAMPLES,
    SENSED,
    TORQUES,
    UNNAMED,
    Faults,
    RecordingError,
    RowFault,
    check_trial,
)
from hknob_cli.recordings.files import CELLS, NotReadableError, RecordingFile
from hknob_cli.recordings.trial import Array, Key, Trial
from hknob_cli.specs.identification import ColumnPlan
from hknob_cli.specs.messages import closest, shown

NOTHING: Mapping[str, Any] = {}
_SAMPLES = tuple(column.name for column in (*SAMPLES, *SENSED))


def read(
    paths: Iterable[Path | str],
    *,
    columns: Mapping[str, ColumnPlan] = NOTHING,
    limits: Mapping[str, float] = NOTHING,
    warn: Callable[[str], None] = lambda _text: None,
) -> list[Trial]:
    """Trials of all files, in their order.

    Columns as `hknob_cli.recordings.columns` lists them, in any order, others ignored; the rows of a trial are
    consecutive. ``columns`` says what is otherwise in the files; ``limits``: by column, the size beyond which ``warn``
    is told. A file without a column ``block`` is a block of its own, of its number in ``paths``, and so is one without
    ``trial`` a trial. Raises `RecordingError` with up to 20 faults.
    """
    trials: list[Trial] = []
    found: list[RowFault] = []
    seen: dict[Key, Trial] = {}
    for number, path in enumerate(paths, 1):
        sources = {name: one.source for name, one in columns.items() if one.source}
        faults = Faults(str(path), sources)
        lost: list[int] = []
        try:
            file = RecordingFile(Path(path))
            raw = _columns(file, faults, columns)
            here = _trials_of(file, Layout(raw, columns, number, limits, file.decimal), faults, lost) if raw else []
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
        if not faults:
            for warning in faults.warnings:
                warn(str(warning))
    if found:
        raise RecordingError(found)
    return trials


class Layout(NamedTuple):
    """How a file is read: names in its header by name of column, what is said of columns, its number and its marks."""

    raw: dict[str, str]
    given: Mapping[str, ColumnPlan]
    number: int
    limits: Mapping[str, float]
    decimal: str = "."

    @property
    def factors(self) -> dict[str, float]:
        """By which columns become SI."""
        return {name: one.factor for name, one in self.given.items() if one.source}

    @property
    def constants(self) -> dict[str, str | float]:
        """Keys that are no columns of the file."""
        default: dict[str, str | float] = {"subject": UNNAMED, "experiment": UNNAMED, "grip_target_n": 0.0}
        default |= {"block": self.number, "trial": self.number}
        said = {name: one.value for name, one in self.given.items() if one.value is not None}
        return {name: said.get(name, value) for name, value in default.items() if name not in self.raw}


def _columns(file: RecordingFile, faults: Faults, given: Mapping[str, ColumnPlan]) -> dict[str, str]:
    """Name in the header of each column that is there; empty if a needed one is missing, which is noted."""
    stripped = [name.strip() for name in file.names]
    wanted = {name: given[name].source if name in given else name for name in EVERY}
    found = {name: there for name, there in wanted.items() if there and there in stripped}
    if len(stripped) == 1 and not found:
        raise NotReadableError(f"has one column, {shown(stripped[0])}; cells must be parted by {CELLS}")
    others = [name for name in stripped if name not in found.values()]
    for name, there in wanted.items():
        if there and name not in found:
            required = name in REQUIRED or (name == TORQUES[0] and TORQUES[1] not in found)
            _missing(name, closest(there, others), faults, given=name in given, required=required, there=stripped)
    for name, there in found.items():
        if stripped.count(there) > 1:
            faults.add(0, name, f"column is there {stripped.count(there)} times; must be there once")
    faults.absent |= {name for name in EVERY if name not in found}
    if faults:
        return {}
    return {name: file.names[stripped.index(there)] for name, there in found.items()}


def _missing(name: str, close: str | None, faults: Faults, *, given: bool, required: bool, there: list[str]) -> None:
    """Note a column that is not ``there``, with the name that is ``close`` to it, if any.

    ``given``: whether the spec says how it is called.
    """
    if given:
        hint = f"is it '{close}'?" if close else f"there are {', '.join(map(shown, there[:20]))}"
        faults.add(0, name, f"missing, though columns names it; {hint}")
    elif required:
        hint = f"; is it '{close}'?" if close else f"; columns: {{{name}: NAME}} says how it is called"
        faults.add(0, name, f"column missing, and required{hint}")
    elif close:
        faults.warn(0, name, f"there is no such column, but '{close}', which is not read; is it meant?")


def _trials_of(file: RecordingFile, layout: Layout, faults: Faults, lost: list[int]) -> list[Trial]:
    """Trials of one file; its faults are noted, from its text if it is CSV."""
    if not file.is_parquet:
        try:
            clean = Faults(faults.file, faults.sources)
            clean.absent |= faults.absent
            trials = _gathered(file.typed(layout.raw), layout, clean)
            if not clean:
                faults.warnings += clean.warnings
                return trials
        except (pa.ArrowException, OSError):
            pass
    trials = _gathered(file.texts(layout.raw), layout, faults)
    for row, cells, expected in file.lost:
        lost.append(row)
        faults.add_row(row, f"has {cells} cells; must have {expected}, as the header")
    return trials


def _gathered(batches: Iterable[dict[str, pa.Array]], layout: Layout, faults: Faults) -> list[Trial]:
    """Trials of the rows of one file, checked; stops when there are more faults than are listed."""
    trials: list[Trial] = []
    seen: dict[Key, Trial] = {}
    rows = 0
    for whole in _runs(blocks(batches, faults, layout.constants, layout.factors, layout.decimal), faults.file):
        trial = whole if faults.absent >= set(MAY_MISS) else _without_holes(whole, faults)
        rows += trial.time_s.size
        trial = trial._replace(notes=check_trial(trial, faults, layout.limits))
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
    """Trial of its pieces, in memory of its own; commanded torque the measured one where there is no other."""
    samples = {name: np.concatenate([piece[name] for piece in pieces]) for name in _SAMPLES if name in pieces[0]}
    samples.setdefault("grip_n", np.full(samples["time_s"].size, np.nan))
    if TORQUES[0] not in samples:
        samples[TORQUES[0]] = samples[TORQUES[1]]
    return Trial(key=key, source=source, first_row=first, **dict[str, Any](samples))


def _without_holes(trial: Trial, faults: Faults) -> Trial:
    """Trial without what a sensor did not give in any row; holes in it, or in the grip, are noted."""
    for name in MAY_MISS:
        values: Array | None = getattr(trial, name)
        if values is None or name in faults.absent:
            continue
        holes = np.flatnonzero(np.isnan(values))
        spare = name not in TORQUES or TORQUES[0] not in faults.absent
        if holes.size == values.size and name != "grip_n" and spare:
            trial = trial._replace(**dict[str, Any]({name: None}))
        elif holes.size and (name != "grip_n" or holes.size < values.size) and not faults.has(name):
            none = ", or in none" if spare else ""
            message = f"nothing in {holes.size} rows of this trial; must be in all of them{none}"
            faults.add(trial.first_row + int(holes[0]), name, message)
    return trial


def _said(key: Key) -> str:
    return (
        f"trial {key.trial} of block {key.block} of subject '{key.subject}', experiment '{key.experiment}', "
        f"{key.grip_target_n:g} N"
    )
