"""Rows of a recording in blocks: cells made numbers and names, and where one trial ends and the next begins."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.recordings.cells import Names, bad_cells, names, numbers
from hknob_cli.recordings.columns import MAY_MISS, TEXTS
from hknob_cli.recordings.faults import MOST, Faults
from hknob_cli.recordings.files import NotReadableError
from hknob_cli.recordings.trial import Array, Key

_WHOLE = ("block", "trial")
_NUMBERS = ("grip_target_n", *_WHOLE)
_LARGEST_WHOLE = 2.0**53


class Block(NamedTuple):
    """Consecutive rows as numbers and names; ``first`` is the row of the first."""

    first: int
    numbers: dict[str, Array]
    names: dict[str, Names]

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.numbers["time_s"])

    def key(self, index: int) -> Key:
        """Key of a row."""
        subject, experiment = (self.names[name].at(index) for name in TEXTS)
        grip, block, trial = (float(self.numbers[name][index]) for name in _NUMBERS)
        return Key(subject, experiment, grip, int(block), int(trial))

    def starts(self) -> list[int]:
        """Rows of this block at which the key changes, and the first."""
        changes = np.zeros(len(self.numbers["time_s"]), dtype=bool)
        changes[:1] = True
        keys: list[np.ndarray[Any, Any]] = [self.numbers[name] for name in _NUMBERS]
        keys += [column.codes for column in self.names.values()]
        for values in keys:
            changes[1:] |= values[1:] != values[:-1]
        return [int(start) for start in np.flatnonzero(changes)]


def blocks(
    batches: Iterable[dict[str, pa.Array]],
    faults: Faults,
    constants: Mapping[str, str | float],
    factors: Mapping[str, float],
) -> Iterator[Block]:
    """Rows of batches as numbers and names; cells that are neither are noted, and keys stay as in the row before.

    ``constants``: keys that are no columns of the file; ``factors``: by which a column's numbers become SI. Raises
    `NotReadableError` for names of another type.
    """
    first = 1
    for batch in batches:
        count = len(batch["time_s"])
        texts = {name: _names(name, batch[name]) for name in TEXTS if name in batch}
        for name, column in texts.items():
            for index in column.empty()[: MOST + 1]:
                faults.add(first + int(index), name, "must be text or a whole number, got nothing")
        reals = {name: numbers(cells) for name, cells in batch.items() if name not in TEXTS}
        for name, values in reals.items():
            if not np.isfinite(values).all():
                for bad in bad_cells(batch[name], values, may_miss=name in MAY_MISS):
                    faults.add(first + bad.row, name, f"must be a finite number, got {bad.value}")
        reals |= {name: factors[name] * reals[name] for name in reals if factors.get(name, 1.0) != 1.0}
        for name in _WHOLE:
            if name in reals:
                _check_whole(name, reals[name], first, faults)
        reals |= {name: _filled(reals[name]) for name in _NUMBERS if name in reals}
        for name, value in constants.items():
            if isinstance(value, str):
                texts[name] = Names([value], np.zeros(count, dtype=np.int32))
            else:
                reals[name] = np.full(count, float(value))
        texts = {name: texts[name] for name in TEXTS}
        if faults.full:
            return
        if len(reals["time_s"]):
            yield Block(first, reals, texts)
        first += len(reals["time_s"])


def _names(column: str, cells: pa.Array) -> Names:
    try:
        return names(cells)
    except pa.ArrowException:
        raise NotReadableError(f"{column}: is of type {cells.type}; must be text or whole numbers") from None


def _check_whole(name: str, values: Array, first: int, faults: Faults) -> None:
    with np.errstate(invalid="ignore"):
        whole = (values == np.floor(values)) & (values >= 0.0) & (values < _LARGEST_WHOLE)
    same = np.concatenate([[False], values[1:] == values[:-1]])  # said once, not in every row of a trial
    for index in np.flatnonzero(np.isfinite(values) & ~whole & ~same)[: MOST + 1]:
        faults.add(first + int(index), name, f"must be a whole number >= 0, got {values[index]:g}")


def _filled(values: Array) -> Array:
    """Values with each that is not finite replaced by the one before it, so that a bad cell does not part a trial."""
    good = np.isfinite(values)
    if good.all():
        return values
    last = np.maximum.accumulate(np.where(good, np.arange(values.size), 0))
    return np.nan_to_num(values[last], nan=0.0, posinf=0.0, neginf=0.0)
