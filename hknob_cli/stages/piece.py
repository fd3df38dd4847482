"""A piece of a sweep: some cells of its grid by number, as bytes that one process can hand to another."""

import platform
from struct import Struct
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.spec.cells import cells_of
from hknob_cli.spec.plan import SweepPlan
from hknob_cli.stages.plain_chunk import GROUP, plain_chunk
from hknob_cli.stages.sweep import SweepStage
from hknob_cli.stages.sweep_tables import cells_table, orbits_table

_HEAD = Struct("<QQ")  # trial-samples, length of the first table


class Piece(NamedTuple):
    """Tables of some cells, and the trial-samples they took."""

    cells: pa.Table
    orbits: pa.Table
    samples: int


class PieceFinder:
    """Finds pieces of a sweep; small to send from process to process, and keeps its engine between pieces."""

    def __init__(self, plan: SweepPlan, versions: dict[str, str]) -> None:
        """Make ready; ``versions`` that the results will be said to be of."""
        self.plan = plan
        self.versions = versions
        self._stage: SweepStage | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {"plan": self.plan, "versions": self.versions, "_stage": None}

    def prepare(self, stage: SweepStage) -> None:
        """Use the engine of a stage, which may be compiled already."""
        self._stage = stage

    def __call__(self, start: int, stop: int) -> bytes:
        """Find cells ``start`` to ``stop``. Raises `ComputationError`, also where the versions here are others."""
        if self._stage is None:
            self._check()
            self._stage = SweepStage(self.plan, jobs=1)
        return encode(find_piece(self._stage, start, stop))

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
    from hknob_cli.stages.remedied import block_of

    return block_of(plan)


def find_piece(stage: SweepStage, start: int, stop: int) -> Piece:
    """Cells ``start`` to ``stop`` of a sweep. Raises `ComputationError`."""
    grid, unit = cells_of(stage.plan), unit_of(stage.plan)
    if stage.plain:
        return Piece(*plain_chunk(stage.plan, grid.columns(start, stop), stage.functions(GROUP), stage.stopped))
    step = unit if unit > 1 else max(1, stop - start)
    found = [one for a in range(start, stop, step) for one in stage.find(list(grid.run(a, min(stop, a + step))))]
    return Piece(cells_table(stage.plan, found), orbits_table(stage.plan, found), sum(one.samples for one in found))


def encode(piece: Piece) -> bytes:
    """A piece as bytes: its tables as Arrow streams."""
    cells, orbits = (_stream(table) for table in (piece.cells, piece.orbits))
    return _HEAD.pack(piece.samples, len(cells)) + cells + orbits


def decode(data: bytes) -> Piece:
    """A piece from its bytes."""
    samples, length = _HEAD.unpack_from(data)
    whole = pa.py_buffer(data)
    cells = whole.slice(_HEAD.size, length)
    orbits = whole.slice(_HEAD.size + length)
    tables = [pa.ipc.open_stream(one).read_all() for one in (cells, orbits)]
    return Piece(tables[0], tables[1], samples)


def _stream(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table)
    return bytes(sink.getvalue())
