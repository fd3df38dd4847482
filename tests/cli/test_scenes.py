"""Scenes beside the plain one, through the installed command: what they add, and what they must not leave behind."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import SPEC

HAND = "  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n"
RECORD = "record={duration: 20 ms, interval: 1 ms}"


@pytest.mark.parametrize(
    "added",
    ["encoder: none", "wall: {stiffness: 0.27, damping: 1.0e-6}", "actuator: {torque_limit: 1.0e-3}", ""],
)
def test_nothing_damps_the_knob(added: str, hknob, spec_file) -> None:
    """No distance bounds how far two undamped motions part: no cycle is proven, and nothing breaks."""
    text = SPEC.replace(HAND, "").replace(
        "  wall: {stiffness: 0.27}\n", "" if "wall" in added else "  wall: {stiffness: 0.27}\n"
    )
    done = hknob(
        "sweep", spec_file(text.replace("scene:\n", f"scene:\n  {added}\n" if added else "scene:\n")), "--json"
    )
    assert done.returncode == 0, done.stderr
    cell = json.loads(done.stdout)["cells"][0]
    assert cell["certified_fraction"] in (0.0, None)
    assert cell["undecided_fraction"] + cell["diverged_fraction"] == 1.0


def test_columns_come_with_what_the_scene_has(hknob, spec_file, tmp_path: Path) -> None:
    """Friction adds its loss, a continuous sensor takes the counts' columns away, no clock takes those of samples."""
    columns = {}
    for name, setting in {
        "plain": [],
        "friction": ["--set", "scene.knob.coulomb_torque=1e-4"],
        "sensor": ["--set", "scene.encoder=none"],
        "clockless": ["--set", "scene.sampling=continuous"],
    }.items():
        done = hknob("sweep", spec_file(SPEC), "-o", name, *setting)
        assert done.returncode == 0, done.stderr
        columns[name] = set(pq.read_schema(tmp_path / name / "orbits.parquet").names)
    assert columns["friction"] - columns["plain"] == {"friction_loss_j"}
    assert columns["plain"] - columns["sensor"] == {"margin_counts"}
    assert columns["clockless"] - columns["plain"] == {"contact_s", "settling_s", "bounces", "energy_drift"}
    assert {"period_samples", "margin_counts", "wall_work_j"} <= columns["plain"] - columns["clockless"]


def test_recordings_of_another_spec_do_not_stay(hknob, spec_file, tmp_path: Path) -> None:
    path = spec_file(SPEC)
    done = hknob("sweep", path, "-o", "out", "--set", RECORD, "--plot")
    assert done.returncode == 0, done.stderr
    assert {"trajectories.parquet", "trajectories.png"} <= {file.name for file in (tmp_path / "out").iterdir()}
    assert hknob("sweep", path, "-o", "out").returncode == 0
    left = {file.name for file in (tmp_path / "out").iterdir() if not file.name.startswith(".")}
    assert left == {"cells.parquet", "orbits.parquet"}


def test_a_grid_without_axes(hknob, spec_file) -> None:
    """A continuous controller with a continuous sensor is one cell, whose picture is its motion."""
    text = SPEC[: SPEC.index("grid:")] + "grid: {}\n"
    text = text.replace("scene:\n", "scene:\n  encoder: none\n  sampling: continuous\n")
    done = hknob("sweep", spec_file(text), "--plot")
    assert done.returncode == 0, done.stderr
    assert "1 rest point, all proven" in done.stdout
    assert done.stderr == ""
    assert "grid.png" in done.stdout


def test_dry_run_as_json(hknob, spec_file) -> None:
    path = spec_file(SPEC)
    first = json.loads(hknob("sweep", path, "--dry-run", "--json").stdout)
    assert first["status"] == "would run"
    assert "no cells.parquet yet" in first["why"]
    assert hknob("sweep", path).returncode == 0
    assert json.loads(hknob("sweep", path, "--dry-run", "--json").stdout)["status"] == "up to date"


def test_a_torque_limit_of_nothing_is_a_limit(hknob, spec_file) -> None:
    """0 limits the torque to nothing; it does not mean that there is no limit, and the laws refuse it."""
    text = SPEC[: SPEC.index("starts:")].replace("kind: sweep", "kind: predict")
    done = hknob("predict", spec_file(text), "--set", "scene.actuator={torque_limit: 0}")
    assert done.returncode == 2
    assert "scene.actuator.torque_limit: must be absent: a torque limit is not in predict" in done.stderr


def test_a_hand_from_a_table_is_the_hand_written_out(hknob, spec_file, tmp_path: Path) -> None:
    written = SPEC.replace("inertia: 3.0e-7, damping", "inertia: 1.3e-7, damping")
    row = SPEC.replace(HAND, "  hand: {table: 1, grip_n: 0.71}\n")
    for name, text in (("written", written), ("row", row)):
        done = hknob("sweep", spec_file(text, f"{name}.yaml"), "-o", name)
        assert done.returncode == 0, done.stderr
    for name in ("cells.parquet", "orbits.parquet"):
        one, other = (pq.read_table(tmp_path / folder / name) for folder in ("written", "row"))
        assert one.replace_schema_metadata().equals(other.replace_schema_metadata())
    inputs = [json.loads(other.schema.metadata[b"hknob.provenance"])["inputs"] for other in (one, other)]
    assert set(inputs[1]) - set(inputs[0]) == {"table_1_sha256", "table_10_sha256"}
    heavy = hknob("sweep", "row.yaml", "--set", "scene.hand.inertia=1e-7")
    assert heavy.returncode == 2
    assert (
        "--set scene.hand.inertia=1e-7: scene.hand.inertia: must be absent where the hand has a table" in heavy.stderr
    )
