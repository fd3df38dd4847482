"""``hknob hw-run`` with ``what: pulses`` through the installed command: recorded, gone on with, and identified."""

import json
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from hknob_cli.recordings.columns import KEYS, SAMPLES
from hknob_cli.recordings.read import read
from tests.conftest import EXPERIMENTS, HKNOB, Command
from tests.hardware.pulses import SPEC

FILES = ("samples.parquet", "trials.parquet", "timing.parquet")


@pytest.fixture(scope="module")
def done(tmp_path_factory, forks):
    """A small campaign, run once: its folder and what was printed."""
    folder = tmp_path_factory.mktemp("pulses")
    (folder / "spec.yaml").write_text(SPEC)
    said = Command(forks, folder)("hw-run", folder / "spec.yaml", "-o", folder / "out", "--plot")
    assert said.returncode == 0, said.stderr
    return folder, said


def test_what_is_printed(done) -> None:
    _, said = done
    lines = said.stdout.splitlines()
    assert lines[0] == "pulses: 4 trials, 4 with a pulse"
    assert "The pulses turned the knob by " in said.stdout
    (head,) = [line for line in lines if line.startswith("target N")]
    assert head.split("  ")[0] == "target N"
    assert any(line.split()[:4] == ["0.71", "2", "of", "2"] for line in lines)
    assert "6004 samples, 0 missing, 0 late in the loop" in lines
    assert lines[-1].startswith("next: hknob new sysid ")


def test_samples_are_a_recording(done) -> None:
    folder, _ = done
    table = pq.read_table(folder / "out" / "samples.parquet")
    names = [column.name for column in (*KEYS, *SAMPLES)]
    assert table.column_names == [
        *names,
        "sample_rate_hz",
        "sample",
        "device_time_us",
        "angle_counts",
        "running",
    ]
    trials = read([folder / "out" / "samples.parquet"])
    assert [(one.key.grip_target_n, one.key.trial) for one in trials] == [(0.71, 1), (0.71, 2), (4.3, 3), (4.3, 4)]


def test_pictures_are_drawn(done) -> None:
    folder, _ = done
    assert (folder / "out" / "hw_run.png").stat().st_size > 10_000
    assert (folder / "out" / "timing.png").stat().st_size > 5_000


def test_the_same_seed_gives_the_same_bytes(done, hknob, tmp_path: Path) -> None:
    folder, _ = done
    again = hknob("hw-run", folder / "spec.yaml", "-o", "other")
    assert again.returncode == 0, again.stderr
    for name in FILES:
        assert (tmp_path / "other" / name).read_bytes() == (folder / "out" / name).read_bytes()
    assert not (folder / "out" / "recording").exists()


def test_again_is_up_to_date_and_json(done, hknob) -> None:
    folder, _ = done
    said = hknob("hw-run", folder / "spec.yaml", "-o", folder / "out", "--json")
    found = json.loads(said.stdout)
    assert (found["status"], found["fired"]) == ("up to date", 4)
    assert [row["fired"] for row in found["pulses"]] == [2, 2]


def test_a_killed_campaign_goes_on_and_gives_the_same_bytes(done, tmp_path: Path) -> None:
    folder, _ = done
    command = [HKNOB, "hw-run", folder / "spec.yaml", "-o", tmp_path / "out"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    first = tmp_path / "out" / "recording" / "01_0.71N.parquet"
    deadline = time.monotonic() + 120
    while not first.exists() and time.monotonic() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    assert first.exists()
    again = subprocess.run([*command, "-v"], capture_output=True, text=True, check=False)
    assert again.returncode == 0, again.stderr
    assert "3 of 4 trials recorded now" in again.stderr or "2 of 4 trials recorded now" in again.stderr
    for name in FILES:
        assert (tmp_path / "out" / name).read_bytes() == (folder / "out" / name).read_bytes()


def test_sysid_finds_the_hand_that_was_simulated(done, hknob, tmp_path: Path) -> None:
    """Friction is fitted, too, and the mean is of two trials: within a few standard errors and trial spreads."""
    folder, _ = done
    spec = (
        f"kind: sysid\nname: found\nrecordings: [{folder}/out]\ncounts_per_rev: 640000\n"
        "prepare: {average: false}\nestimators: [output_error_friction]\n"
    )
    (folder / "sysid.yaml").write_text(spec)
    said = hknob("sysid", folder / "sysid.yaml", "-o", "found")
    assert said.returncode == 0, said.stderr
    fits = pq.read_table(tmp_path / "found" / "trials.parquet").to_pylist()
    truths = pq.read_table(folder / "out" / "trials.parquet").to_pylist()
    for fit, truth in zip(fits, truths, strict=True):
        assert fit["trial"] == truth["order"]
        for name in ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad"):
            assert fit[name] == pytest.approx(truth[f"true_{name}"], rel=0.01)
        assert fit["coulomb_nm"] == pytest.approx(0.56e-3, rel=0.02)


@pytest.mark.long
def test_an_unfired_trial_is_left_out_by_sysid_and_said(hknob, tmp_path: Path) -> None:
    (tmp_path / "weak.yaml").write_text(SPEC.replace("rise: 0.2", "rise: 0.2, strength: 2.0 N"))
    run = hknob("hw-run", tmp_path / "weak.yaml", "-o", tmp_path / "weak")
    assert run.returncode == 0, run.stderr
    assert "pulses: 4 trials, 2 with a pulse" in run.stdout
    assert "trial 3 (4.3 N, block 1): no pulse:" in run.stdout
    text = f"kind: sysid\nname: f\nrecordings: [{tmp_path}/weak/samples.parquet]\ncounts_per_rev: 640000\n"
    (tmp_path / "sysid.yaml").write_text(text)
    found = hknob("sysid", tmp_path / "sysid.yaml", "--json")
    assert found.returncode == 0, found.stderr
    rows = pq.read_table(tmp_path / "results" / "f" / "trials.parquet").to_pylist()
    told = [row for row in rows if row["inertia_kg_m2"] is not None]
    assert {row["grip_target_n"] for row in told} == {0.71}
    assert "left out" in next(row["flags"] for row in rows if row["grip_target_n"] == 4.3)


def test_a_wrong_spec_is_one_line_and_writes_nothing(hknob, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(SPEC + "wall: {stiffness: 1}\n")
    said = hknob("hw-run", tmp_path / "bad.yaml")
    assert said.returncode == 2
    assert said.stderr.strip().endswith("wall: must be absent with what: pulses: it is of a buzz")
    assert not (tmp_path / "results").exists()


def test_a_page_of_pulses(done, hknob, tmp_path: Path) -> None:
    folder, _ = done
    (folder / "page.yaml").write_text(f"kind: report\nname: page\nresults: [{folder}/out]\n")
    said = hknob("report", folder / "page.yaml")
    assert said.returncode == 0, said.stderr
    page = (tmp_path / "results" / "page" / "report.html").read_text()
    assert "every pulse" in page
    assert "The pulses turned the knob by" in page


@pytest.mark.parametrize("name", ["grip_pulses"])
def test_experiments_are_good(hknob, name: str) -> None:
    said = hknob("check", EXPERIMENTS / f"{name}.yaml")
    assert said.returncode == 0
    assert "54 pulses: good" in said.stdout
    assert hknob("explain", EXPERIMENTS / f"{name}.yaml").returncode == 0


def test_times_of_a_trial_are_even(done) -> None:
    folder, _ = done
    timing = pq.read_table(folder / "out" / "timing.parquet").to_pylist()
    assert {row["samples"] for row in timing} == {1501}
    assert max(row["jitter_max_s"] for row in timing) < 1e-9
    assert np.allclose([row["period_s"] for row in timing], 1e-4)
