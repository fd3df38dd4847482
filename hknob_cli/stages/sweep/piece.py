"""A piece of a sweep: some cells of its grid by number, as bytes that one process can hand to another.

They are the files of its two tables, in the layout of results: a piece that is a whole part is written as it is.
"""

import platform
from collections.abc import Mapping
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from hknob_cli.results.layout import as_file
from hknob_cli.results.parting import Parting
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.tables import SweepTables, cells_table, joined, orbits_table

_HEAD = 8  # bytes, that say how long the first file is
_MOST = 32_768  # cells found at a time, which bounds the memory that a piece takes


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


def unit_of(plan: SweepPlan) -> int:
    """Cells that stay together, however a sweep is cut."""
    if plan.scene.controller is None:
        return 1
    from hknob_cli.stages.sweep.controlled import block_of

    return block_of(plan)


def find_piece(stage: SweepStage, start: int, stop: int) -> SweepTables:
    """Cells ``start`` to ``stop`` of a sweep. Raises `ComputationError`."""
    unit = unit_of(stage.plan)
    step = unit if unit > 1 else _MOST
    return joined([_find(stage, a, min(stop, a + step)) for a in range(start, stop, step)])


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
