"""``hknob remedies`` through the installed command."""

import json
import subprocess
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import HKNOB

SMALL = """\
kind: remedies
name: small
base:
  scene:
    knob: {inertia: 19.8 g*cm^2}
    wall: {stiffness: 0.27}
    bias: {torque: 0.001}
  grid:
    sample_rate_hz: [1000, 2000]
    counts_per_rev: [360, 1024]
  starts: {phases: 4}
hands:
  light: {table: 1, grip_n: 0.71}
  firm: {inertia: 3.0e-7, damping: 1.0e-3, stiffness: 0.1}
cases:
  coarse: {sample_rate_hz: 1000, counts_per_rev: 360}
remedies:
  plain wall: {}
  bounded lag:
    change: {scene: {controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.05}}}
    needs: a running mean
"""


def test_tables_picture_and_summary(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("remedies", spec_file(SMALL), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "small: 2 remedies, 2 hands, a grid of 4 cells" in done.stdout
    assert "coarse: of the hand that buzzes most" in done.stdout
    assert (tmp_path / "out" / "remedies.png").read_bytes()[:4] == b"\x89PNG"
    grid, cases = (pq.read_table(tmp_path / "out" / f"{name}.parquet") for name in ("remedies", "cases"))
    for table in (grid, cases):
        assert all(field.metadata[b"meaning"] for field in table.schema)
        assert table.schema.field("p2p_rad").metadata[b"unit"] == b"rad"
        assert b"hknob.provenance" in table.schema.metadata
    assert len(grid) == 2 * 2 * 4
    rows = {(row["remedy"], row["hand"]): row for row in cases.to_pylist()}
    assert set(rows) == {(r, h) for r in ("plain wall", "bounded lag") for h in ("light", "firm")}
    plain, lag = rows["plain wall", "light"], rows["bounded lag", "light"]
    assert plain["p2p_ratio"] == plain["stiffness_kept"] == plain["knock_ratio"] == 1.0
    assert lag["p2p_ratio"] == pytest.approx(plain["p2p_rad"] / lag["p2p_rad"], rel=1e-12)
    assert lag["p2p_ratio"] > 2.0
    # At rest the wall is as stiff as before; a quick knock meets a softer one.
    assert lag["stiffness_kept"] == pytest.approx(1.0, abs=0.02)
    assert lag["knock_ratio"] > 1.0
    assert lag["needs"] == "a running mean"


def test_the_reference_is_what_a_sweep_finds(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("remedies", spec_file(SMALL), "-o", "out").returncode == 0
    sweep = (
        "kind: sweep\nname: s\nscene:\n  knob: {inertia: 19.8 g*cm^2}\n  wall: {stiffness: 0.27}\n"
        "  bias: {torque: 0.001}\n  hand: {table: 1, grip_n: 0.71}\n"
        "grid: {sample_rate_hz: [1000, 2000], counts_per_rev: [360, 1024]}\nstarts: {phases: 4}\n"
    )
    assert hknob("sweep", spec_file(sweep, "sweep.yaml"), "-o", "swept").returncode == 0
    cells = pq.read_table(tmp_path / "swept" / "cells.parquet").to_pylist()
    ours = [
        row
        for row in pq.read_table(tmp_path / "out" / "remedies.parquet").to_pylist()
        if (row["remedy"], row["hand"]) == ("plain wall", "light")
    ]
    for column in ("sample_rate_hz", "counts_per_rev", "p2p_rad", "frequency_hz", "certified_fraction"):
        assert [row[column] for row in ours] == [row[column] for row in cells]


@pytest.mark.long
def test_jobs_up_to_date_and_json(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(SMALL.replace("phases: 4", "phases: 128"))  # enough to be worth two processes
    first = hknob("remedies", spec, "-o", "one", "-j", "1", "--json")
    assert first.returncode == 0, first.stderr
    assert hknob("remedies", spec, "-o", "two", "-j", "2", "-q").returncode == 0
    for name in ("remedies", "cases"):
        files = [(tmp_path / folder / f"{name}.parquet").read_bytes() for folder in ("one", "two")]
        assert files[0] == files[1]
    summary = json.loads(first.stdout)
    assert summary["kind"] == "remedies"
    assert summary["grid"]["bounded lag"]["cells"] == 8
    assert [row["remedy"] for row in summary["cases"]["coarse"]] == ["bounded lag", "plain wall"]
    again = hknob("remedies", spec, "-o", "one", "--json")
    assert json.loads(again.stdout)["status"] == "up to date"
    assert "nothing would run" in hknob("remedies", spec, "-o", "one", "--dry-run").stdout
    changed = hknob("remedies", spec, "-o", "one", "--dry-run", "--set", "press.speed=1")
    assert "has changed" in changed.stdout


def test_without_cases_there_is_no_picture(hknob, spec_file, tmp_path: Path) -> None:
    text = SMALL[: SMALL.index("cases:")] + SMALL[SMALL.index("remedies:\n  plain") :]
    done = hknob("remedies", spec_file(text), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "no picture: no cases are given" in done.stderr
    assert not (tmp_path / "out" / "remedies.png").exists()
    assert len(pq.read_table(tmp_path / "out" / "cases.parquet")) == 0


def test_a_sweep_with_a_controller_and_its_recording(hknob, spec_file, tmp_path: Path) -> None:
    text = (
        "kind: sweep\nname: s\nscene:\n  knob: {inertia: 19.8 g*cm^2}\n  wall: {stiffness: 0.27}\n"
        "  bias: {torque: 0.001}\n  hand: {table: 1, grip_n: 0.71}\n"
        "  controller: {kind: impulse_damping}\n"
        "grid: {sample_rate_hz: [1000], counts_per_rev: [2650]}\nstarts: {phases: 4}\n"
        "record: {duration: 0.02, interval: 0.1 ms, trials: 1}\n"
    )
    done = hknob("sweep", spec_file(text), "-o", "out")
    assert done.returncode == 0, done.stderr
    rows = pq.read_table(tmp_path / "out" / "trajectories.parquet").to_pylist()
    events = [row["event"] for row in rows]
    # The wall's torque and the pulse's end: two commands an interval, of which one is at the sample.
    assert events.count("sample") == events.count("command") == 20


def test_check_says_how_many(hknob, spec_file) -> None:
    assert "2 remedies" in hknob("check", spec_file(SMALL)).stdout


def test_bench_refuses_a_controller(hknob, spec_file) -> None:
    text = (
        "kind: bench\nname: b\nbase:\n  scene:\n    knob: {inertia: 1.9e-6}\n    wall: {stiffness: 0.27}\n"
        "    controller: {kind: stiffening}\n  sample_rate_hz: 1000\n  counts_per_rev: 512\n"
        "  starts: {angle: 0.01}\n  duration: 0.02\nscenes: {one: {}}\n"
    )
    done = hknob("bench", spec_file(text), "-o", "out")
    assert done.returncode == 2
    assert "scene.controller: must be absent: bench has no rival with a controller" in done.stderr


def test_a_killed_run_leaves_no_processes(spec_file, tmp_path: Path) -> None:
    busy = SMALL.replace("phases: 4", "phases: 2000").replace("[1000, 2000]", "{lin: [1000, 2000, 30]}")
    args = [HKNOB, "remedies", spec_file(busy), "-o", tmp_path / "out", "-j", "2", "-q"]
    with subprocess.Popen(args) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        deadline = time.monotonic() + 60
        while len(children.read_text().split()) < 2:
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.01)
        workers = children.read_text().split()
        time.sleep(0.2)  # they have begun
        process.kill()
    deadline = time.monotonic() + 120
    while left := [one for one in workers if _runs(one)]:
        assert time.monotonic() < deadline, left
        time.sleep(0.05)


def _runs(pid: str) -> bool:
    """Whether a process is there, and no mere entry that nobody has asked about yet."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
