"""A sweep put together from its pieces: kept as they come, in any order, and written in parts that are whole."""

from collections.abc import Sequence
from math import ceil
from typing import Any

import pyarrow as pa

from hknob_cli.results.parted import PART_CELLS, is_written, read_parted, take_back, write_part
from hknob_cli.results.place import make_folder
from hknob_cli.results.staging import Staging
from hknob_cli.stages.piece import decode

TABLES = ("cells", "orbits")


class Assembly:
    """The results of ``total`` cells; more than `PART_CELLS` of them are written in parts. Raises `OSError`."""

    def __init__(self, staging: Staging, total: int, provenance: bytes, *, part: int = PART_CELLS) -> None:
        self.staging = staging
        self.total = total
        self.provenance = provenance
        self.parted = total > part
        self.part = part if self.parted else max(1, total)
        self.samples = 0
        self._pieces: list[tuple[int, int]] = []

    def begin(self, *, afresh: bool = False) -> list[tuple[int, int]]:
        """Make ready, and go on from what an earlier run has finished: which cells that is."""
        self.staging.begin(afresh=afresh)
        for name in TABLES if self.parted else ():
            folder = self.staging.folder / name
            if not afresh:
                take_back(self.staging.folder.parent / f"{name}.parquet", folder, self.provenance)
            make_folder(folder)
        done = [self._range(number) for number in range(self._parts) if self.parted and self._is_written(number)]
        for start, stop in self.staging.pieces():
            if any(one[0] <= start and stop <= one[1] for one in done) or not self._fits(start, stop):
                self.staging.drop(start, stop)
            else:
                self._pieces.append((start, stop))
        done += self._pieces
        for number in range(self._parts):
            self._finish(number)
        return done

    def take(self, start: int, stop: int, data: bytes) -> None:
        """Take in the results of cells ``start`` to ``stop``."""
        self.staging.put(start, stop, data)
        self._pieces.append((start, stop))
        self._finish(start // self.part)

    def tables(self) -> tuple[Any, ...]:
        """Cells and orbits, once all are there: tables, or `Parted` ones."""
        if not self.parted:
            return self._joined(0)
        found = tuple(read_parted(self.staging.folder / name, self.provenance) for name in TABLES)
        assert all(found)
        return found

    @property
    def _parts(self) -> int:
        return ceil(self.total / self.part)

    def _range(self, number: int) -> tuple[int, int]:
        return number * self.part, min(self.total, (number + 1) * self.part)

    def _is_written(self, number: int) -> bool:
        folders = (self.staging.folder / name for name in TABLES)
        return all(is_written(folder, number, self._parts, self.provenance) for folder in folders)

    def _fits(self, start: int, stop: int) -> bool:
        """Whether a piece that was found is one of this sweep."""
        if not start < stop <= self.total or start // self.part != (stop - 1) // self.part:
            return False
        try:
            return bool(decode(self.staging.get(start, stop)).cells.num_rows == stop - start)
        except (ValueError, pa.ArrowException):
            return False

    def _of(self, number: int) -> list[tuple[int, int]]:
        first, last = self._range(number)
        return sorted(one for one in self._pieces if first <= one[0] < last)

    def _joined(self, number: int) -> tuple[pa.Table, ...]:
        found = [decode(self.staging.get(*one)) for one in self._of(number)]
        self.samples += sum(piece.samples for piece in found)
        return tuple(_concatenated([getattr(piece, name) for piece in found]) for name in TABLES)

    def _finish(self, number: int) -> None:
        """Write a part, if it is whole, and drop its pieces."""
        first, last = self._range(number)
        pieces = self._of(number)
        if not self.parted or sum(stop - start for start, stop in pieces) < last - first:
            return
        for name, table in zip(TABLES, self._joined(number), strict=True):
            write_part(table, self.staging.folder / name, number, self._parts, self.provenance)
        for start, stop in pieces:
            self.staging.drop(start, stop)
        self._pieces = [one for one in self._pieces if not first <= one[0] < last]


def _concatenated(tables: Sequence[pa.Table]) -> pa.Table:
    return pa.concat_tables(tables).combine_chunks()
