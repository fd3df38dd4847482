"""A long sweep in pieces: spread over processes or a cluster, kept in any order, and put together in whole parts.

A piece is some cells of its grid by number, as bytes that one process can hand to another: the files of its two tables,
in the layout of results, so that a piece that is a whole part is written as it is. Sampled cells are computed twice.
"""

import platform
from collections.abc import Callable, Iterable, Mapping
from math import isclose
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.parquet as pq

from hknob_cli.errors import ComputationError, unwritable
from hknob_cli.report.table import short
from hknob_cli.results.files import Staging, make_folder
from hknob_cli.results.parted import Parting, as_file, is_written, part_numbers, put_part, read_parted, take_back
from hknob_cli.results.versions import grid_versions
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.spread.forks import usable_cores
from hknob_cli.stages.job import Job
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.tables import SweepTables, cells_table, joined, orbits_table
from hknob_cli.terminal import heed, spread_progress

if TYPE_CHECKING:
    from hknob_cli.spread.gather import Range, Ranges, Workers

_HEAD = 8  # bytes, that say how long the first file is
_MOST = 32_768  # cells found at a time, which bounds the memory that a piece takes

TABLES = ("cells", "orbits")


class PieceFinder:
    """Finds pieces of a sweep; small to send from process to process, and keeps its engine between pieces."""

    def __init__(self, plan: SweepPlan, parting: Parting, versions: dict[str, str]) -> None:
        """Make ready; ``parting`` of the cells, ``versions`` that the results will be said to be of."""
        self.plan = plan
        self.parting = parting
        self.versions = versions
        self._stage: SweepStage | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_stage": None}

    def prepare(self, stage: SweepStage) -> None:
        """Use the engine of a stage, which may be compiled already."""
        self._stage = stage

    def __call__(self, start: int, stop: int) -> bytes:
        """Find cells ``start`` to ``stop``. Raises `ComputationError`, also where the versions here are others."""
        if self._stage is None:
            self._check()
            self._stage = SweepStage(self.plan, jobs=1)
        part = self.parting.whole(start, stop)
        metadata = {} if part is None else self.parting.metadata(part)
        return encode(find_piece(self._stage, start, stop), metadata)

    def _check(self) -> None:
        from hknob_cli.errors import ComputationError
        from hknob_cli.results.versions import grid_versions

        here = grid_versions(self.plan.points)
        if other := [
            f"{name} {here.get(name)}, not {value}" for name, value in self.versions.items() if here.get(name) != value
        ]:
            raise ComputationError(
                f"a worker, on {platform.node()}, has other versions, so its results would differ: {'; '.join(other)}; "
                "install the same there, and run the same command again"
            )


def find_piece(stage: SweepStage, start: int, stop: int) -> SweepTables:
    """Cells ``start`` to ``stop`` of a sweep. Raises `ComputationError`."""
    return joined([_find(stage, a, min(stop, a + _MOST)) for a in range(start, stop, _MOST)])


def _find(stage: SweepStage, start: int, stop: int) -> SweepTables:
    if stage.plain:
        return stage.find_plain(start, stop)
    found = stage.find(list(cells_of(stage.plan).run(start, stop)))
    samples = sum(one.samples for one in found)
    return SweepTables(cells_table(stage.plan, found), orbits_table(stage.plan, found), samples)


def encode(tables: SweepTables, metadata: Mapping[bytes, bytes]) -> bytes:
    """Tables as the bytes of two files, each of which says ``metadata`` of itself."""
    cells, orbits = (as_file(table, metadata) for table in (tables.cells, tables.orbits))
    return b"".join((len(cells).to_bytes(_HEAD, "little"), cells, orbits))


def files_of(data: bytes) -> tuple[memoryview, memoryview]:
    """The files of cells and orbits in a piece."""
    length, rest = int.from_bytes(data[:_HEAD], "little"), memoryview(data)[_HEAD:]
    return rest[:length], rest[length:]


def decode(data: bytes) -> tuple[pa.Table, ...]:
    """Cells and orbits of a piece. Raises `pa.ArrowException` or `OSError` where it is none."""
    return tuple(pq.ParquetFile(pa.BufferReader(file)).read().replace_schema_metadata() for file in files_of(data))


def finished(staging: Staging, parting: Parting) -> int:
    """Cells that an earlier run has finished, as far as names tell; nothing is read or changed. Raises `OSError`."""
    folders = [staging.folder / name for name in TABLES]
    parts = set.intersection(*(set(part_numbers(folder)) if folder.is_dir() else set() for folder in folders))
    ranges = [*map(parting.range, parts), *(one for one in staging.names() if one[0] // parting.items not in parts)]
    return sum(stop - start for start, stop in ranges)


class Assembly:
    """The results of a sweep, cut as ``parting`` says. Raises `OSError`."""

    def __init__(self, staging: Staging, parting: Parting) -> None:
        self.staging = staging
        self.parting = parting
        self._folders = [staging.folder / name for name in TABLES]
        self._pieces: list[tuple[int, int]] = []

    def begin(self, *, afresh: bool = False) -> list[tuple[int, int]]:
        """Make ready, and go on from what an earlier run has finished: which cells that is."""
        self.staging.begin(afresh=afresh)
        for folder in self._folders if self.parting.parted else ():
            if not afresh:
                take_back(self.staging.folder.parent / f"{folder.name}.parquet", folder, self.parting.provenance)
            make_folder(folder)
        done = [self.parting.range(number) for number in self._numbers() if self._is_written(number)]
        for start, stop in self.staging.pieces():
            if any(one[0] <= start and stop <= one[1] for one in done) or not self._fits(start, stop):
                self.staging.drop(start, stop)
            else:
                self._pieces.append((start, stop))
        done += self._pieces
        for number in {start // self.parting.items for start, _ in self._pieces}:
            self._finish(number)
        return done

    def take(self, start: int, stop: int, data: bytes) -> None:
        """Take in the results of cells ``start`` to ``stop``, as `PieceFinder` gives them."""
        part = self.parting.whole(start, stop)
        if part is not None:
            self._put(part, files_of(data))
            return
        self.staging.put(start, stop, data)
        self._pieces.append((start, stop))
        self._finish(start // self.parting.items)

    def tables(self) -> tuple[Any, ...]:
        """Cells and orbits, once all are there: tables, or `Parted` ones.

        Raises `ComputationError` for damage, and where the disk fails.
        """
        if not self.parting.parted:
            return self._joined(0)
        try:
            found = tuple(read_parted(folder, self.parting.provenance, strict=True) for folder in self._folders)
        except OSError as error:
            raise ComputationError(
                f"{error.filename or self.staging.folder}: cannot be read: {error.strerror or error}; what is finished "
                "is kept, run the same command again"
            ) from None
        if not all(found):
            raise ComputationError(
                f"{self.staging.folder}: something else has changed what was finished here; run the same command again"
            )
        return found

    def _numbers(self) -> list[int]:
        """Parts that may be there."""
        return part_numbers(self._folders[0]) if self.parting.parted else []

    def _is_written(self, number: int) -> bool:
        parts, provenance = self.parting.parts, self.parting.provenance
        return all(is_written(folder, number, parts, provenance) for folder in self._folders)

    def _fits(self, start: int, stop: int) -> bool:
        """Whether a piece that was found is one of this sweep."""
        items = self.parting.items
        if not start < stop <= self.parting.total or start // items != (stop - 1) // items:
            return False
        try:
            return bool(decode(self.staging.get(start, stop))[0].num_rows == stop - start)
        except (ValueError, OSError, pa.ArrowException):
            return False

    def _of(self, number: int) -> list[tuple[int, int]]:
        first, last = self.parting.range(number)
        return sorted(one for one in self._pieces if first <= one[0] < last)

    def _joined(self, number: int) -> tuple[pa.Table, ...]:
        found = zip(*(decode(self.staging.get(*one)) for one in self._of(number)), strict=True)
        return tuple(pa.concat_tables(tables).combine_chunks() for tables in found)

    def _finish(self, number: int) -> None:
        """Write a part, if it is whole, and drop its pieces."""
        first, last = self.parting.range(number)
        pieces = self._of(number)
        if not self.parting.parted or sum(stop - start for start, stop in pieces) < last - first:
            return
        metadata = self.parting.metadata(number)
        self._put(number, tuple(as_file(table, metadata) for table in self._joined(number)))
        for start, stop in pieces:
            self.staging.drop(start, stop)
        self._pieces = [one for one in self._pieces if not first <= one[0] < last]

    def _put(self, number: int, files: tuple[memoryview, ...]) -> None:
        for folder, file in zip(self._folders, files, strict=True):
            put_part(file, folder, number)


# Of numbers from processors whose C libraries round `exp` and `sin` differently: what a fault changes is seldom less.
NEAR, NOTHING = 1e-6, 1e-9  # relative; and absolute, in SI units

Rows = list[dict[str, Any]]


def rows_of(data: bytes, place: int, some: Iterable[Mapping[str, Any]]) -> Rows:
    """Rows that a piece has of ``some`` of its cells, the first at ``place``, and of their orbits.

    Cells are given by their axes.
    """
    cells, orbits = decode(data)
    wanted = list(some)
    rows: Rows = cells.slice(place, len(wanted)).to_pylist()
    names = [name for name in wanted[0] if name in orbits.schema.names]
    keys = zip(*(orbits[name].to_pylist() for name in names), strict=True)
    there = {tuple(row[name] for name in names) for row in rows}
    return rows + [orbits.slice(i, 1).to_pylist()[0] for i, key in enumerate(keys) if key in there]


def same(one: Rows, other: Rows) -> bool:
    """Whether all rows are the same to the last bit, as workers of one machine find them."""
    return repr(one) == repr(other)


def nearly_same(one: Rows, other: Rows) -> bool:
    """Whether they are, apart from the last digits of real numbers, as workers of several machines find them."""
    return len(one) == len(other) and all(
        a.keys() == b.keys() and all(_near(a[name], b[name]) for name in a) for a, b in zip(one, other, strict=True)
    )


def _near(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return isclose(one, other, rel_tol=NEAR, abs_tol=NOTHING) or (one != one and other != other)
    return bool(one == other)


def spread_sweep(job: Job, stage: SweepStage, stamp: bytes, notify: Callable[[str], None]) -> tuple[Any, ...]:
    """Cells and orbits of a sweep whose results will have the provenance ``stamp``. Raises `ComputationError`."""
    from hknob_cli.spread.gather import Ranges

    total, staging = stage.cell_count, Staging(job.out, stamp)
    parting = Parting(total, stamp)
    try:
        assembly = Assembly(staging, parting)
        done = assembly.begin(afresh=job.force)
        left = Ranges(total, done=done, part=parting.items)
        if done and left:
            notify(f"{total - len(left)} of {total} cells are there from an earlier run")
        if left:
            _gather(job, stage, assembly, left, notify)
        return assembly.tables()
    except OSError as error:
        raise unwritable(job.out, error, kept=True) from None
    finally:
        staging.leave()


def _gather(job: Job, stage: SweepStage, assembly: Assembly, left: "Ranges", notify: Callable[[str], None]) -> None:
    from hknob_cli.spread.gather import Sample, gather

    parting = assembly.parting
    finder = PieceFinder(job.plan, parting, grid_versions(job.plan.points))
    with spread_progress(parting.total, show=not job.quiet, done=parting.total - len(left)) as progress:

        def deliver(start: int, stop: int, data: bytes) -> None:
            assembly.take(start, stop, data)
            progress(stop - start)

        def tick() -> None:
            heed()
            progress(0)

        def part_of(one: "Range", data: bytes, some: "Range") -> Rows:
            return rows_of(data, some.start - one.start, cells_of(job.plan).run(some.start, some.stop))

        sample = Sample(part_of, nearly_same if job.scheduler else same)
        workers = _workers(job, stage, finder, notify)
        gather(workers, left, deliver, tick=tick, name=lambda one: _named(job.plan, one), sample=sample)


def _workers(job: Job, stage: SweepStage, finder: PieceFinder, notify: Callable[[str], None]) -> "Workers":
    if job.scheduler:
        from hknob_cli.spread.cluster import Cluster

        return Cluster(finder, job.scheduler, notify)
    from hknob_cli.spread.processes import Processes, keep_memory

    keep_memory()
    stage.compile()
    finder.prepare(stage)
    return Processes(finder, job.jobs or usable_cores())


def _named(plan: Any, one: "Range") -> str:
    """Cells by number, and the first by its values."""
    cell = next(cells_of(plan).run(one.start, one.start + 1))
    values = ", ".join(f"{name} = {short(value)}" for name, value in cell.items())
    which = f"cell {one.start}," if one.items == 1 else f"cells {one.start} to {one.stop - 1}, from"
    return f"{which} {values}"
