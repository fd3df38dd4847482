"""Whole lists, proven anew in intervals apart from the engine, are those of the sweep: a few cells; as `long`, many."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from tests.crosscheck.every_start.listed import ONE_START, READINGS, Listed, sweep
from tests.verification.every_start.compare import differences, prove_cell, prove_listed

FEW = "grid.counts_per_rev=[128, 1024]"
PROVE = Path(__file__).with_name("prove.py")


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Listed:
    """Cells of few cuts, of all starts in the ranges."""
    settings = (*READINGS["0.04-torque"], "grid.sample_rate_hz=[100, 464.2]", FEW)
    return Listed.read(sweep(tmp_path_factory.mktemp("few") / "out", *settings))


@pytest.mark.long
def test_every_start_in_the_ranges(few: Listed) -> None:
    """Each list is the proven one, and every orbit captured some piece."""
    for number in range(len(few.cells)):
        proof, said = prove_cell(few, number)
        assert said == []
        assert proof.complete
        assert all(proof.captured)
    assert sum(len(rows) for rows in few.orbits) > len(few.cells)


@pytest.mark.long
def test_another_list_is_told(few: Listed) -> None:
    """The comparison can fail: an orbit too few, one too many, one that is a little off, starts left over."""
    proof, said = prove_cell(few, 1)
    assert said == []
    rows = few.orbits[1]
    for spoilt, words in (
        (rows[1:], "not listed: "),
        ([*rows, rows[0]], f"not proven: orbit {rows[0]['orbit']}"),
        ([{**rows[0], "margin_counts": rows[0]["margin_counts"] + 1e-7}, *rows[1:]], "not listed: "),
        ([{**rows[0], "min_rad": rows[0]["min_rad"] * (1.0 + 1e-7)}, *rows[1:]], "not listed: "),
        ([{**rows[0], "certified": False}, *rows[1:]], "not listed: "),
    ):
        lists = list(few.orbits)
        lists[1] = spoilt
        assert any(one.startswith(words) for one in differences(replace(few, orbits=lists), 1, proof))
    assert differences(replace(few, complete=[False] * len(few.cells)), 1, proof) == ["not listed as complete"]
    proof.complete = False
    assert differences(few, 1, proof) == ["starts are left"]


@pytest.mark.long
def test_listed_orbits_alone(tmp_path: Path) -> None:
    """All orbits of a cell are proven from their samples; with the samples of another one they are not."""
    settings = (*READINGS["0.04-half"], "grid.sample_rate_hz=[1000]", "grid.counts_per_rev=[512]", "basins={points: 2}")
    listed = Listed.read(sweep(tmp_path / "out", *settings))
    assert len(listed.orbits[0]) > 2
    assert prove_listed(listed, 0) == []
    first, second = listed.samples[0][0], listed.samples[0][1]
    mixed = [{**listed.samples[0], 0: second, 1: first[:-1]}]
    assert prove_listed(replace(listed, samples=mixed), 0)[0].startswith("orbit 0")
    assert len(prove_listed(replace(listed, samples=mixed), 0)) == 2


def test_every_clock_phase(tmp_path: Path) -> None:
    """Lists are the same, and shares within what halving leaves undecided; a share that is off by more is told."""
    settings = (*READINGS["0.04-half"], "grid.sample_rate_hz=[100]", FEW, ONE_START)
    listed = Listed.read(sweep(tmp_path / "out", *settings))
    assert not listed.is_box
    for number in range(len(listed.cells)):
        proof, said = prove_cell(listed, number)
        assert said == []
        assert sum(proof.shares) + proof.undecided == 1.0  # of powers of two, exactly
        assert proof.undecided < 1e-10
    wrong = [[{**row, "basin_fraction": row["basin_fraction"] + 1e-9} for row in rows] for rows in listed.orbits]
    assert all(one.startswith("orbit ") for one in differences(replace(listed, orbits=wrong), number, proof))
    assert differences(replace(listed, orbits=wrong), number, proof)


@pytest.mark.long
@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize(("settings", "cells"), [((), "0:26,42"), ((ONE_START,), "0:49")])
def test_grid(reading: str, settings: tuple[str, ...], cells: str, tmp_path: Path) -> None:
    """All starts of 27 cells, one of 10 kHz among them, and all clock phases of one start of 49; compiled."""
    folder = sweep(tmp_path / reading, *READINGS[reading], *settings)
    done = subprocess.run(
        [sys.executable, PROVE, folder, "--cells", cells], capture_output=True, text=True, check=False, timeout=3000
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith("0 cells whose list is another\n")
