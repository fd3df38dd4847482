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

ANYWHERE = SPEC.replace("starts: {angle: 0.02, phases: 8}", "starts: anywhere")


@pytest.fixture
def write(spec_file: Callable[..., Path]) -> Callable[[str], Path]:
    return spec_file


def test_every_clock_phase_is_the_default(hknob: Run, write: Callable[[str], Path]) -> None:
    """Shares are lengths, the list is complete, and the sentence says for which starts."""
    done = hknob("sweep", write(PHASES), "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "Complete: every clock phase of the start is proven to end in one of these." in done.stdout
    assert "This is one start. Another may end in a larger cycle." in done.stdout
    advice = done.stdout.split("To look for one, add\n  --set ")[1].splitlines()[0].strip("'")
    assert hknob("check", write(PHASES), "--set", advice).returncode == 0
    folder = write(PHASES).parent / "out"
    cell = pq.read_table(folder / "cells.parquet").to_pylist()[0]
    orbits = pq.read_table(folder / "orbits.parquet").to_pylist()
    assert cell["complete"]
    assert cell["undecided_fraction"] == 0.0
    assert cell["piece_count"] == 9
    assert 0.0 < cell["share_error"] < 1e-9
    assert [one["period_samples"] for one in orbits] == [10, 47]
    # 6400 phases sampled: 0.8566 and 0.1434, to the arcs' ends over 6400.
    assert orbits[0]["basin_fraction"] == pytest.approx(0.8566, abs=9 / 6400)


def test_rest_from_one_start_says_so(hknob: Run, write: Callable[[str], Path]) -> None:
    """One start that rests does not speak for others."""
    soft = ("--set", "scene.wall.stiffness=0.001", "--set", "scene.knob.damping=0.01")
    done = hknob("sweep", write(PHASES), *soft, "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "comes to rest" in done.stdout
    assert "This is one start. Another may end in a limit cycle. To look for one, add" in done.stdout


def test_sampled_phases_have_no_column_of_completeness(hknob: Run, write: Callable[[str], Path]) -> None:
    """What is not asked for takes no column and no line."""
    path = write(SPEC)
    done = hknob("sweep", path, "--out", "out")
    assert "omplete" not in done.stdout
    assert not {"complete", "piece_count", "share_error"} & set(
        pq.read_schema(path.parent / "out" / "cells.parquet").names
    )


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
    assert "share_error" not in pq.read_schema(folder / "cells.parquet").names
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
    few = ("--set", "limits.max_samples=100", "--out", "few")
    done = hknob("sweep", path, "--set", f"scene.actuator={LATE}", *few)
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "In 1 of 1 cells some starts have no proven end" in words
    assert "1 cell: no level sequence repeated within the sample limit (limits.max_samples)." in words


def test_maps_of_scenes_with_more_in_them_are_refused(hknob: Run, write: Callable[[str], Path]) -> None:
    """A map tells starts by angle and velocity alone."""
    done = hknob("sweep", write(RANGES + "basins: {points: 20}\n"), "--set", "scene.wall.damping=1e-5")
    assert done.returncode == 2
    assert "scene.wall.damping: must be absent where basins are mapped" in done.stderr


FINGER = (
    "scene.hand={finger: {inertia: 3.0e-7, damping: 2.9e-3, stiffness: 0.4}, "
    "fingerpad: {damping: 3.8e-4, stiffness: 0.05}}"
)


def test_what_cannot_be_cut_is_sampled_and_said(hknob: Run, write: Callable[[str], Path], tmp_path: Path) -> None:
    """With teeth that part, 64 phases; the list is not called complete.

    Nothing is compiled where it looks, and 64 trials are interpreted.
    """
    gear = "scene.gear={ratio: 2.5, motor_inertia: 3e-7, stiffness: 5.0, mesh_damping: 1e-3, backlash: 1e-3}"
    words = ("sweep", write(PHASES), "--set", gear, "--out", "out")
    done = hknob(*words, HKNOB_CACHE_DIR=str(tmp_path / "cache"))
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "The list is not proven to be complete." in said
    assert "starts cannot be followed all at once; 64 clock phases were sampled there." in said


CONTROLLED = RANGES.replace("scene:\n", "scene:\n  controller: {kind: bounded_lag, keep: 0.15}\n")


@pytest.mark.long
def test_every_start_with_a_controller(hknob: Run, write: Callable[[str], Path]) -> None:
    """Shares are areas, and nowhere said to be counted."""
    path = write(CONTROLLED)
    done = hknob("sweep", path, "--out", "out", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["completeness"]["complete"] == 1
    cell = pq.read_table(path.parent / "out" / "cells.parquet").to_pylist()[0]
    assert cell["complete"]
    assert cell["undecided_fraction"] == 0.0
    assert cell["piece_count"] > 10
    orbits = pq.read_table(path.parent / "out" / "orbits.parquet").to_pylist()
    assert all(one["certified"] for one in orbits)
    assert sum(one["basin_fraction"] for one in orbits) == pytest.approx(1.0)
    text = " ".join(hknob("sweep", path, "--out", "again").stdout.split())
    assert "buzz is no larger than the largest cycle above" in text
    assert "Shares are counted" not in text


def test_a_controller_that_senses_the_velocity_is_sampled(hknob: Run, write: Callable[[str], Path]) -> None:
    """Random starts of a range are simulated, which is said; a map of basins is refused."""
    sensed = CONTROLLED.replace("bounded_lag, keep: 0.15", "half_sample, velocity: sensor")
    # So is a tracking filter that is so slow that no norm is known in which its memory fades.
    slow = CONTROLLED.replace(
        "bounded_lag, keep: 0.15", "velocity_damping, damping: 1e-4, velocity: tracking, bandwidth: 1e-11"
    )
    for text in (sensed, slow):
        done = hknob("sweep", write(text), "--set", "starts.random=20", "--out", "out", "--force")
        assert done.returncode == 0, done.stderr
        assert "20 random ones were simulated there" in " ".join(done.stdout.split())
    done = hknob("sweep", write(CONTROLLED + "basins: {points: 20}\n"))
    assert done.returncode == 2
    assert "scene.controller: must be absent where basins are mapped" in done.stderr


FAULTS = [
    ("starts.velocity=0", "starts.velocity: must be a range, [least, largest], as the other one is, got 0"),
    ("starts.angle=[0.1, 0]", "starts.angle: must have its least value first, got [0.1, 0]"),
    ("starts.phases=8", "starts.phases: must be absent where angle and velocity are ranges"),
    ("starts.angle=[0.1, 0.2, 0.3]", "starts.angle: must have at most 2 items"),
    ("starts.angle=[1 kg, 0.2]", "is in kilogram, which is not a kind of rad"),
    ("scene.sampling=continuous", "scene.sampling: must not be continuous where starts are a range"),
    ("record={duration: 0.1}", "record: must be absent where starts are a range"),
    ("basins={points: 5000}", "basins.points: must be <= 2000"),
    ("starts={angle: 0.02, random: 8}", "starts.random: must be absent where angle and velocity are not ranges"),
    ("starts.random=0", "starts.random: must be >= 1, got 0"),
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


def test_every_clock_phase_with_friction(hknob: Run, write: Callable[[str], Path]) -> None:
    """Complete, as without."""
    done = hknob("sweep", write(PHASES), "--set", "scene.knob.coulomb_torque=5.6e-4", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "Complete: every clock phase of the start is proven to end in one of these." in done.stdout


@pytest.mark.long
def test_every_clock_phase_with_friction_and_a_finger(hknob: Run, write: Callable[[str], Path]) -> None:
    """Complete, too."""
    friction = "scene.knob.coulomb_torque=1e-4"
    done = hknob("sweep", write(PHASES), "--set", friction, "--set", FINGER, "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "Complete: every clock phase of the start is proven to end in one of these." in done.stdout


@pytest.mark.long
def test_every_start_with_friction_and_a_lag(hknob: Run, write: Callable[[str], Path]) -> None:
    """Complete from the ranges, too; the torque that lags is no state of its own."""
    friction, late = "scene.knob.coulomb_torque=2e-4", "scene.actuator={time_constant: 50 us, delay_samples: 1}"
    done = hknob("sweep", write(RANGES), "--set", friction, "--set", late, "--out", "out", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["completeness"]["complete"] == 1


def test_maps_need_ranges(hknob: Run, write: Callable[[str], Path]) -> None:
    """A map of one start would be a point."""
    done = hknob("sweep", write(PHASES + "basins: {points: 20}\n"))
    assert done.returncode == 2
    assert "basins: must be absent where starts are not ranges" in done.stderr


UNCUT = [
    ("scene.knob.coulomb_torque=1e-4", FINGER),
    ("scene.hand.stiffness=0", "scene.knob.coulomb_torque=0"),
    ("scene.controller={kind: half_sample, velocity: sensor}", "scene.knob.coulomb_torque=0"),
]


@pytest.mark.parametrize("settings", UNCUT)
def test_starts_are_drawn_where_they_cannot_be_followed(
    hknob: Run, write: Callable[[str], Path], settings: tuple[str, str]
) -> None:
    """Of so many random starts, which is said; the list is not called complete."""
    path = write(RANGES.replace("velocity: [-5, 5]", "velocity: [-5, 5], random: 20"))
    done = hknob("sweep", path, "--set", settings[0], "--set", settings[1], "--out", "out")
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "The list is not proven to be complete." in words
    assert "starts cannot be followed all at once; 20 random ones were simulated there" in words
    cell = pq.read_table(path.parent / "out" / "cells.parquet").to_pylist()[0]
    assert (cell["complete"], cell["piece_count"]) == (False, 0)
    assert "random starts were simulated" in cell["incomplete_reason"]
    shares = pq.read_table(path.parent / "out" / "orbits.parquet")["basin_fraction"].to_pylist()
    assert [20 * share for share in shares] == pytest.approx([round(20 * share) for share in shares])


def test_where_all_can_be_followed_none_is_drawn(hknob: Run, write: Callable[[str], Path]) -> None:
    """The files are those of ranges alone, except for the spec that they name."""
    every = write(RANGES)
    folder = every.parent
    assert hknob("sweep", every, "--out", "all").returncode == 0
    assert hknob("sweep", every, "--set", "starts.random=20", "--out", "drawn").returncode == 0
    for name in ("cells", "orbits"):
        one, other = (pq.read_table(folder / out / f"{name}.parquet") for out in ("all", "drawn"))
        assert one.equals(other)


def test_every_start_there_is(hknob: Run, write: Callable[[str], Path]) -> None:
    """The list is complete for every state, and the region that all come into is in the table and the summary."""
    path = write(SPEC)
    done = hknob("sweep", path, "--set", "starts=anywhere", "--out", "out", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)["completeness"]
    assert found["complete"] == 1
    assert found["starts"] == "every start at a sample, however far,"
    cell = pq.read_table(path.parent / "out" / "cells.parquet").to_pylist()[0]
    assert found["regions"]["angle_rad"] == [cell["region_rad"]] * 2
    assert 2e-3 < cell["region_rad"] < 20e-3
    assert 0.5 < cell["region_rad_s"] < 5.0
    assert cell["grows_rad"] is None
    assert cell["complete"]
    orbits = pq.read_table(path.parent / "out" / "orbits.parquet").to_pylist()
    assert {one["period_samples"] for one in orbits} == {10, 47}
    assert max(one["max_rad"] for one in orbits) < cell["region_rad"]


def test_a_wall_too_stiff_for_its_rate_is_said(hknob: Run, write: Callable[[str], Path]) -> None:
    """From where on motions grow; the cell beside it is complete."""
    path = write(ANYWHERE.replace("sample_rate_hz: [1000]", "hand.damping: [3.45e-4, 4e-6]"))
    done = hknob("sweep", path, "--set", "grid.sample_rate_hz=[1000]", "--out", "out")
    assert done.returncode == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "Complete in 1 of 2 cells: every start at a sample, however far, is proven" in words
    assert "In 1 of 2 cells every motion from beyond" in words
    assert "grows without bound: the wall is too stiff for its rate." in words
    rows = pq.read_table(path.parent / "out" / "cells.parquet").to_pylist()
    assert [row["complete"] for row in rows] == [True, False]
    assert rows[0]["grows_rad"] is None
    assert rows[1]["grows_rad"] > 0.0
    assert rows[1]["region_rad"] is None
    assert rows[1]["diverged_fraction"] == 1.0
    assert [row["incomplete_reason"] for row in rows] == ["", "leaves, and nothing brings it back"]


ANYWHERE_FAULTS = [
    ("starts=everywhere", "starts: must be 'anywhere'"),
    ("scene.knob.coulomb_torque=1e-4", "scene.knob.coulomb_torque: must be absent where starts are anywhere"),
    ("scene.hand=null", "starts: must not be anywhere without a hand"),
    ("record={duration: 0.1}", "record: must be absent where starts are anywhere"),
    ("basins={points: 20}", "basins: must be absent where starts are not ranges"),
]


@pytest.mark.parametrize(("setting", "words"), ANYWHERE_FAULTS)
def test_faults_of_every_start(hknob: Run, write: Callable[[str], Path], setting: str, words: str) -> None:
    """Each is told at its key, and nothing is written."""
    path = write(ANYWHERE)
    done = hknob("sweep", path, "--set", setting, "--out", "out")
    assert done.returncode == 2, done.stdout
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (path.parent / "out").exists()


def test_ranges_have_no_column_of_a_region(hknob: Run, write: Callable[[str], Path]) -> None:
    """What is not asked for takes no column."""
    path = write(PHASES)
    assert hknob("sweep", path, "--out", "out").returncode == 0
    names = set(pq.read_schema(path.parent / "out" / "cells.parquet").names)
    assert not {"region_rad", "region_rad_s", "grows_rad", "grows_rad_s"} & names


def test_of_a_knob_at_rest_no_largest_cycle_is_spoken_of(hknob: Run, write: Callable[[str], Path]) -> None:
    rests = ("--set", "scene.wall.stiffness=0.01", "--set", "scene.knob.damping=0.01")
    for starts in ("starts={angle: 0.02}", "starts={angle: [-0.01, 0.01], velocity: [-1, 1]}"):
        done = hknob("sweep", write(PHASES), "--out", "out", *rests, "--set", starts)
        assert "It does not buzz" in done.stdout
        assert "Complete" in done.stdout
        assert "larger cycle" not in done.stdout
        assert "largest cycle" not in done.stdout
