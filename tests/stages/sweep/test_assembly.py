"""A sweep in pieces and in parts: the same bytes as in one go, whatever the cuts, the order, and what was there."""

from itertools import pairwise
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hknob_cli.errors import ComputationError
from hknob_cli.results.files import Staging, clear_staged
from hknob_cli.results.parted import Parted, Parting
from hknob_cli.results.versions import grid_versions
from hknob_cli.stages.sweep.assembly import Assembly, PieceFinder, decode, encode, find_piece, finished
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import SPEC, loaded

STAMP = b'{"stage":"sweep","name":"x"}'
CELLS = 20
WHOLE = Parting(CELLS, STAMP)
PARTS = Parting(CELLS, STAMP, most=8)


@pytest.fixture(scope="module")
def stage() -> SweepStage:
    text = SPEC.replace("[1000]", "{log: [200, 5000, 5]}").replace("[1024]", "[64, 256, 1024, 4096]")
    return SweepStage(loaded(text), jobs=1)


def pieces(stage: SweepStage, cuts: list[int]) -> list[tuple[int, int, bytes]]:
    ends = [0, *cuts, CELLS]
    return [(a, b, encode(find_piece(stage, a, b), {})) for a, b in pairwise(ends) if a < b]


def parted(stage: SweepStage, cuts: list[int]) -> list[tuple[int, int, bytes]]:
    """Pieces as a worker gives them that knows of the parts."""
    finder = PieceFinder(stage.plan, PARTS, {})
    finder.prepare(stage)
    return [(a, b, finder(a, b)) for a, b in pairwise([0, *cuts, CELLS]) if a < b]


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cuts=st.sets(st.integers(1, CELLS - 1), max_size=6), chance=st.randoms(use_true_random=False))
def test_pieces_in_any_order_make_the_tables_of_one_go(stage, tmp_path: Path, cuts: set[int], chance) -> None:
    whole = stage.run()
    assembly = Assembly(Staging(tmp_path, STAMP), WHOLE)
    assert assembly.begin(afresh=True) == []
    order = pieces(stage, sorted(cuts))
    chance.shuffle(order)
    for one in order:
        assembly.take(*one)
    cells, orbits = assembly.tables()
    assert cells.equals(whole.cells, check_metadata=True)
    assert orbits.equals(whole.orbits, check_metadata=True)
    for name, table in {"cells": cells, "orbits": orbits}.items():
        pq.write_table(table, tmp_path / f"{name}-pieces.parquet")
        pq.write_table(getattr(whole, name), tmp_path / f"{name}-whole.parquet")
        one, other = (tmp_path / f"{name}-{which}.parquet" for which in ("pieces", "whole"))
        assert one.read_bytes() == other.read_bytes()


def test_parts_hold_so_many_cells_each_and_do_not_depend_on_the_pieces(stage, tmp_path: Path) -> None:
    found = {}
    for run, cuts in {"a": [8, 16], "b": [3, 8, 9, 10, 16, 17]}.items():
        (tmp_path / run).mkdir()
        assembly = Assembly(Staging(tmp_path / run, STAMP), PARTS)
        assembly.begin()
        for one in reversed(parted(stage, cuts)):
            assembly.take(*one)
        cells, orbits = assembly.tables()
        assert isinstance(cells, Parted)
        assert (cells.parts, cells.num_rows) == (3, CELLS)
        assert [table.num_rows for table in cells.tables()] == [8, 8, 4]
        assert cells.table().equals(stage.run().cells)
        assert orbits.table(["p2p_rad"]).equals(stage.run().orbits.select(["p2p_rad"]))
        assert assembly.staging.pieces() == []
        found[run] = [path.read_bytes() for path in sorted((tmp_path / run).rglob("*.parquet"))]
    assert found["a"] == found["b"]
    assert len(found["a"]) == 6


def test_an_earlier_run_is_gone_on_with(stage, tmp_path: Path) -> None:
    first = Assembly(Staging(tmp_path, STAMP), PARTS)
    first.begin()
    every = parted(stage, [3, 8, 12, 16])
    for one in (every[0], every[1], every[3]):
        first.take(*one)
    second = Assembly(Staging(tmp_path, STAMP), PARTS)
    assert sorted(second.begin()) == [(0, 8), (12, 16)]
    for one in (every[2], every[4]):
        second.take(*one)
    assert second.tables()[0].table().equals(stage.run().cells)


def test_what_is_finished_is_told_without_touching_it(stage, tmp_path: Path) -> None:
    staging = Staging(tmp_path, STAMP)
    assert finished(staging, PARTS) == 0
    assembly = Assembly(staging, PARTS)
    assembly.begin()
    every = parted(stage, [8, 12, 16])
    for one in (every[0], every[1], every[3]):
        assembly.take(*one)
    staging.put(3, 5, b"of a part that is there")
    before = sorted(tmp_path.rglob("*"))
    assert finished(staging, PARTS) == 16
    assert sorted(tmp_path.rglob("*")) == before
    (staging.folder / "orbits" / "part-000000.parquet").unlink()
    assert finished(staging, PARTS) == 10


def test_a_part_whose_pieces_were_all_there_is_written_at_once(stage, tmp_path: Path) -> None:
    """As after a kill between the last piece and the part."""
    staging = Staging(tmp_path, STAMP)
    staging.begin()
    for start, stop, data in pieces(stage, [8, 16]):
        staging.put(start, stop, data)
    assembly = Assembly(staging, PARTS)
    assert sorted(assembly.begin()) == [(0, 8), (8, 16), (16, 20)]
    assert assembly.tables()[0].num_rows == CELLS


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.write_bytes(path.read_bytes()[:-1]),
        lambda path: path.write_bytes(path.read_bytes()[:-5] + b"junk!"),
        lambda path: path.write_bytes(b""),
        lambda path: path.rename(path.with_name("0-4.piece")),
        lambda path: path.rename(path.with_name("6-9.piece")),
        lambda path: path.rename(path.with_name("18-28.piece")),
        lambda path: path.rename(path.with_name("5-5.piece")),
    ],
    ids=["short", "changed", "empty", "misnamed", "across parts", "beyond", "nothing"],
)
def test_damaged_pieces_are_done_again(stage, tmp_path: Path, spoil) -> None:
    first = Assembly(Staging(tmp_path, STAMP), PARTS)
    first.begin()
    first.take(*pieces(stage, [3])[0])
    spoil(next(first.staging.folder.glob("*.piece")))
    assert Assembly(Staging(tmp_path, STAMP), PARTS).begin() == []
    assert not list(tmp_path.rglob("*.piece"))


def test_what_another_spec_had_finished_is_left_until_results_are_in_place(stage, tmp_path: Path) -> None:
    other = Staging(tmp_path, b"another")
    other.begin()
    other.put(0, 3, b"theirs")
    mine = Staging(tmp_path, STAMP)
    mine.begin()
    mine.put(0, 3, b"mine")
    mine.begin()
    assert mine.get(0, 3) == b"mine"
    mine.begin(afresh=True)
    assert mine.pieces() == []
    assert other.get(0, 3) == b"theirs"
    clear_staged(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_piece_damaged_under_way_says_so(tmp_path: Path) -> None:
    staging = Staging(tmp_path, STAMP)
    staging.begin()
    staging.put(0, 3, b"data")
    path = next(staging.folder.glob("*.piece"))
    path.write_bytes(path.read_bytes()[:-1] + b"?")
    with pytest.raises(ComputationError, match="is damaged; run the same command again"):
        staging.get(0, 3)


def test_a_worker_of_another_version_is_refused(stage) -> None:
    finder = PieceFinder(stage.plan, WHOLE, {"hknob": "0.0"})
    with pytest.raises(ComputationError, match=r"other versions, so its results would differ: hknob .*, not 0\.0"):
        finder(0, 1)


def test_a_worker_draws_a_design_with_the_same_scipy() -> None:
    design = SPEC.replace("  sample_rate_hz: [1000]", "  design: {sobol: 2}\n  sample_rate_hz: {log: [500, 1000]}")
    plan = loaded(design.replace("phases: 8", "phases: 1"))
    assert PieceFinder(plan, WHOLE, grid_versions(plan.points))(0, 2)
    with pytest.raises(ComputationError, match=r"other versions, so its results would differ: scipy .*, not 0\.0"):
        PieceFinder(plan, WHOLE, {**grid_versions(plan.points), "scipy": "0.0"})(0, 2)


@pytest.mark.parametrize(
    "controller",
    [
        "kind: first_order_hold",
        "kind: half_sample",
        "kind: matched_wall",
        "kind: velocity_damping, damping: 1.0e-4",
        "kind: impulse_damping",
        "kind: phase_damping",
        "kind: passivity, damping: 1.0e-3",
        "kind: stiffening, surface: 0.1, depth: 0.01",
        "kind: bounded_lag",
    ],
)
@pytest.mark.parametrize("phases", [", phases: 8", pytest.param("", marks=pytest.mark.long, id="all")])
def test_controlled_cells_are_the_same_in_any_piece(controller: str, phases: str) -> None:
    text = SPEC.replace("[1000]", "[500, 1000]").replace("[1024]", "[64, 128, 256]").replace(", phases: 8", phases)
    stage = SweepStage(loaded(text.replace("wall:", f"controller: {{{controller}}}\n  wall:")), jobs=1)
    whole = stage.run()
    parts = [decode(encode(find_piece(stage, a, b), {})) for a, b in ((0, 1), (1, 6))]
    for table, found in zip((whole.cells, whole.orbits), zip(*parts, strict=True), strict=True):
        assert pa.concat_tables(found).combine_chunks().equals(table)
