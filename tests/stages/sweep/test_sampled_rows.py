"""Cells computed again: the same in any piece, to the last bit; a number that is wrong in one is noticed."""

from pathlib import Path

import pyarrow as pa
import pytest

from hknob_cli.results.parted import Parting
from hknob_cli.results.versions import grid_versions
from hknob_cli.specs.cells import cells_of
from hknob_cli.stages.sweep.assembly import PieceFinder, decode, encode, nearly_same, rows_of, same
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.tables import SweepTables
from tests.conftest import SPEC, loaded
from tests.faults.spread_runs import SWEEP, left, run

GRID = SPEC.replace("[1000]", "[500, 1000, 1500]").replace("[1024]", "[512, 1024]").replace("phases: 8", "phases: 3")
WALL = "wall: {stiffness: 0.27}"
PLANS = {
    "plain": GRID,
    "friction": GRID.replace("inertia: 1.9e-6", "inertia: 1.9e-6, coulomb_torque: 1.0e-4"),
    "controller": GRID.replace(WALL, f"{WALL}\n  controller: {{kind: bounded_lag, keep: 0.15, time_constant: 0.02}}"),
    "every phase": GRID.replace(", phases: 3", ""),
    "third axis": GRID.replace("counts_per_rev:", "hand.damping: [3.45e-4, 7.0e-4]\n  counts_per_rev:"),
}
# A worker that tells every second piece with a number that is a millionth too large in each cell.
LIAR = """
from hknob_cli.spread import gather, processes
from hknob_cli.stages.sweep import assembly
import pyarrow.compute as pc
gather.SAMPLED = 1
plain, calls = assembly.find_piece, []
def lying(stage, start, stop):
    found = plain(stage, start, stop)
    calls.append(start)
    if len(calls) % 2:
        return found
    wrong = pc.multiply(found.cells["p2p_rad"], 1.000001)
    at = found.cells.schema.get_field_index("p2p_rad")
    return found._replace(cells=found.cells.set_column(at, found.cells.schema.field(at), wrong))
assembly.find_piece = lying
"""


@pytest.mark.parametrize("text", PLANS.values(), ids=PLANS)
def test_a_cell_is_the_same_in_any_piece(text: str) -> None:
    plan = loaded(text)
    stage = SweepStage(plan, jobs=1)
    cells = cells_of(plan)
    finder = PieceFinder(plan, Parting(len(cells), b""), grid_versions(plan.points))
    finder.prepare(stage)
    whole = finder(0, len(cells))
    for start in range(len(cells)):
        stop = start + 1
        some = [list(cells.run(start, stop)) for _ in range(2)]
        rows = rows_of(whole, start, some[0])
        assert len(rows) >= 2 * (stop - start)  # a cell, and its orbits
        again = rows_of(finder(start, stop), 0, some[1])
        assert same(rows, again)
        assert nearly_same(rows, again)


@pytest.mark.parametrize("table", [0, 1])
def test_a_number_that_is_wrong_is_noticed(table: int) -> None:
    plan = loaded(GRID)
    stage = SweepStage(plan, jobs=1)
    finder = PieceFinder(plan, Parting(6, b""), grid_versions(plan.points))
    finder.prepare(stage)
    whole, cells = finder(0, 6), list(cells_of(plan).run(2, 3))
    tables = list(decode(whole))
    numbers = tables[table]["p2p_rad"].to_pylist()
    row = next(i for i, one in enumerate(tables[table].to_pylist()) if all(one[k] == v for k, v in cells[0].items()))
    for factor, near in ((1.0 + 2.0**-52, True), (1.0001, False)):
        wrong = [one * factor if i == row else one for i, one in enumerate(numbers)]
        at = tables[table].schema.get_field_index("p2p_rad")
        spoilt = list(tables)
        spoilt[table] = tables[table].set_column(at, tables[table].schema.field(at), pa.array(wrong))
        other = rows_of(encode(SweepTables(*spoilt, 0), {}), 2, cells)
        assert not same(rows_of(whole, 2, cells), other)
        assert nearly_same(rows_of(whole, 2, cells), other) is near


@pytest.mark.long
def test_a_worker_that_lies_ends_the_run(tmp_path: Path) -> None:
    """And one that does not leaves the same bytes, however much is computed again."""
    spec = tmp_path / "spec.yaml"
    spec.write_text(SWEEP)
    code, errors = run(spec, tmp_path / "lies", "-j", "2", "-q", fault=LIAR)
    assert code == 1
    assert "was computed twice, and the results differ" in errors
    assert errors.startswith("cell ")
    assert run(spec, tmp_path / "one", "-j", "2", "-q") == (0, "")
    honest = "from hknob_cli.spread import gather; gather.SAMPLED = 1"
    assert run(spec, tmp_path / "two", "-j", "2", "-q", fault=honest) == (0, "")
    assert left(tmp_path / "one") == left(tmp_path / "two")
