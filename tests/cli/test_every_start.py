"""`hknob sweep` with every clock phase of a start, and with every start in a range, through the installed command."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import SPEC

Run = Callable[..., subprocess.CompletedProcess[str]]

PHASES = SPEC.replace("starts: {angle: 0.02, phases: 8}", "starts: {angle: 0.02}")
RANGES = SPEC.replace("starts: {angle: 0.02, phases: 8}", "starts: {angle: [-50 mrad, 50 mrad], velocity: [-5, 5]}")


@pytest.fixture
def write(spec_file: Callable[..., Path]) -> Callable[[str], Path]:
    return spec_file


def test_every_clock_phase_is_the_default(hknob: Run, write: Callable[[str], Path]) -> None:
    """Shares are lengths, the list is complete, and the sentence says for which starts."""
    done = hknob("sweep", write(PHASES), "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "Complete: every clock phase of the start is proven to end in one of these." in done.stdout
    folder = write(PHASES).parent / "out"
    cell = pq.read_table(folder / "cells.parquet").to_pylist()[0]
    orbits = pq.read_table(folder / "orbits.parquet").to_pylist()
    assert cell["complete"]
    assert cell["undecided_fraction"] == 0.0
    assert cell["piece_count"] == 9
    assert [one["period_samples"] for one in orbits] == [10, 47]
    # 6400 phases sampled: 0.8566 and 0.1434, to the arcs' ends over 6400.
    assert orbits[0]["basin_fraction"] == pytest.approx(0.8566, abs=9 / 6400)


def test_sampled_phases_have_no_column_of_completeness(hknob: Run, write: Callable[[str], Path]) -> None:
    """What is not asked for takes no column and no line."""
    path = write(SPEC)
    done = hknob("sweep", path, "--out", "out")
    assert "omplete" not in done.stdout
    assert not {"complete", "piece_count"} & set(pq.read_schema(path.parent / "out" / "cells.parquet").names)


def test_every_start_in_a_range(hknob: Run, write: Callable[[str], Path]) -> None:
    """The list is complete, shares are counted, and the map of basins has every start and the orbits themselves."""
    path = write(RANGES + "basins: {points: 20}\n")
    done = hknob("sweep", path, "--out", "out", "--json", "--plot")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["completeness"]["complete"] == 1
    assert found["completeness"]["starts"] == "every start from -50 to 50 mrad and -5 to 5 rad/s at a sample"
    folder = path.parent / "out"
    orbits = pq.read_table(folder / "orbits.parquet").to_pylist()
    assert {one["period_samples"] for one in orbits} == {10, 47}
    assert sum(one["basin_fraction"] for one in orbits) == pytest.approx(1.0)
    basins = pq.read_table(folder / "basins.parquet").to_pylist()
    assert len([row for row in basins if not row["on_orbit"]]) == 400
    assert len([row for row in basins if row["on_orbit"]]) == 57
    assert {row["orbit"] for row in basins} <= {0, 1}
    assert (folder / "basins.png").stat().st_size > 10_000


LATE = "{delay_samples: 0.5, torque_limit: 0.005}"


def test_every_clock_phase_of_a_scene_with_more_in_it(hknob: Run, write: Callable[[str], Path]) -> None:
    """Delay, limit and virtual damping: shares are lengths, and the list is complete."""
    path = write(PHASES)
    more = ("--set", f"scene.actuator={LATE}", "--set", "scene.wall.damping=2e-5")
    done = hknob("sweep", path, *more, "--out", "out", "--json")
    assert done.returncode == 0, done.stderr
    cell = json.loads(done.stdout)["cells"][0]
    assert cell["complete"]
    assert cell["piece_count"] > 1
    assert cell["incomplete_reason"] == ""
    sampled = hknob("sweep", path, *more, "--set", "starts.phases=400", "--out", "sampled", "--json")
    assert json.loads(sampled.stdout)["cells"][0]["p2p_rad"] == pytest.approx(cell["p2p_rad"], rel=0.02)


@pytest.mark.long
def test_every_start_in_a_range_of_a_scene_with_more_in_it(hknob: Run, write: Callable[[str], Path]) -> None:
    """A delay beside ranges: the list is complete. Work that is cut short says so, and how much is left."""
    path = write(RANGES)
    done = hknob("sweep", path, "--set", f"scene.actuator={LATE}", "--out", "out", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["completeness"]["complete"] == 1
    few = ("--set", "limits.max_samples=150", "--out", "few")
    done = hknob("sweep", path, "--set", f"scene.actuator={LATE}", *few)
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "In 1 of 1 cells some starts have no proven end, at most" in words
    assert "1 cell: no level sequence repeated within the sample limit (limits.max_samples)." in words


def test_maps_of_scenes_with_more_in_them_are_refused(hknob: Run, write: Callable[[str], Path]) -> None:
    """A map tells starts by angle and velocity alone."""
    done = hknob("sweep", write(RANGES + "basins: {points: 20}\n"), "--set", "scene.wall.damping=1e-5")
    assert done.returncode == 2
    assert "scene.wall.damping: must be absent where basins are mapped" in done.stderr


def test_what_cannot_be_cut_is_sampled_and_said(hknob: Run, write: Callable[[str], Path]) -> None:
    """With friction and a lag, 64 phases; the list is not called complete."""
    friction, lag = "scene.knob.coulomb_torque=1e-4", "scene.actuator={time_constant: 3e-4}"
    done = hknob("sweep", write(PHASES), "--set", friction, "--set", lag, "--out", "out")
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "The list is not proven to be complete." in words
    assert "starts cannot be followed all at once; 64 clock phases were sampled there." in words


FAULTS = [
    ("starts.velocity=0", "starts.velocity: must be a range, [least, largest], as the other one is, got 0"),
    ("starts.angle=[0.1, 0]", "starts.angle: must have its least value first, got [0.1, 0]"),
    ("starts.phases=8", "starts.phases: must be absent where angle and velocity are ranges"),
    ("starts.angle=[0.1, 0.2, 0.3]", "starts.angle: must have at most 2 items"),
    ("starts.angle=[1 kg, 0.2]", "is in kilogram, which is not a kind of rad"),
    ("scene.encoder=none", "scene.encoder: must not be none where starts are a range"),
    ("scene.hand=null", "starts: must be one start without a hand"),
    ("record={duration: 0.1}", "record: must be absent where starts are a range"),
    ("basins={points: 5000}", "basins.points: must be <= 2000"),
]


@pytest.mark.parametrize(("setting", "words"), FAULTS)
def test_faults_of_ranges(hknob: Run, write: Callable[[str], Path], setting: str, words: str) -> None:
    """Each is told at its key, and nothing is written."""
    path = write(RANGES)
    done = hknob("sweep", path, "--set", setting, "--out", "out")
    assert done.returncode == 2, done.stdout
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (path.parent / "out").exists()


def test_friction_with_a_lag_is_refused_for_ranges(hknob: Run, write: Callable[[str], Path]) -> None:
    """At the key of the lag: friction alone is followed."""
    friction, lag = "scene.knob.coulomb_torque=1e-4", "scene.actuator={time_constant: 3e-4}"
    done = hknob("sweep", write(RANGES), "--set", friction, "--set", lag, "--out", "out")
    assert done.returncode == 2, done.stdout
    why = "must be absent where starts are a range and the knob has friction"
    assert f"scene.actuator.time_constant: {why}" in done.stderr


def test_every_clock_phase_with_friction(hknob: Run, write: Callable[[str], Path]) -> None:
    """Complete, as without."""
    done = hknob("sweep", write(PHASES), "--set", "scene.knob.coulomb_torque=5.6e-4", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "Complete: every clock phase of the start is proven to end in one of these." in done.stdout


def test_maps_need_ranges(hknob: Run, write: Callable[[str], Path]) -> None:
    """A map of one start would be a point."""
    done = hknob("sweep", write(PHASES + "basins: {points: 20}\n"))
    assert done.returncode == 2
    assert "basins: must be absent where starts are not ranges" in done.stderr
