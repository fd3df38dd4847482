"""A spec of three lines that starts from a preset, as a user runs it."""

import json

import pandas as pd

SPEC = """\
kind: sweep
name: mine
scene: {from: idrive, hand: {table: 1, grip_n: 0.71}, bias: {torque: 0.001}}
"""


def test_three_lines_say_whether_the_knob_buzzes(hknob, tmp_path) -> None:
    (tmp_path / "mine.yaml").write_text(SPEC)
    done = hknob("sweep", "mine.yaml", "-o", "out", "--json")
    assert done.returncode == 0, done.stderr
    cells = pd.read_parquet(tmp_path / "out" / "cells.parquet")
    assert cells.sample_rate_hz.tolist() == [1000.0]
    assert cells.counts_per_rev.tolist() == [2650]
    assert cells.at_rest_fraction.item() == 0.0
    assert cells.complete.item()
    again = hknob("sweep", "mine.yaml", "-o", "out", "-v")
    assert "up to date" in again.stdout + again.stderr


def test_check_says_where_the_numbers_are_from(hknob, tmp_path) -> None:
    (tmp_path / "mine.yaml").write_text(SPEC)
    done = hknob("check", "mine.yaml")
    assert done.returncode == 0
    assert done.stdout == "mine.yaml: sweep 'mine', 1 cell: good\n"
    assert done.stderr.startswith("mine.yaml: preset idrive: BMW iDrive")
    assert "mine.yaml:   scene.wall.stiffness = 0.27: assumed: " in done.stderr
    assert "mine.yaml:   grid.counts_per_rev = 2650: Section 10.5" in done.stderr
    assert "mine.yaml:   left out: backlash" in done.stderr
    assert hknob("check", "-q", "mine.yaml").stderr == ""
    changed = hknob("check", "mine.yaml", "--set", "scene.wall.stiffness=0.3")
    assert "wall.stiffness" not in changed.stderr


def test_a_preset_that_changes_makes_results_old(hknob, tmp_path) -> None:
    own = {"title": "mine", "scene": {"knob": {"inertia": 2e-6}, "wall": {"stiffness": 0.2}}}
    own["grid"] = {"sample_rate_hz": 1000, "counts_per_rev": 512}
    (tmp_path / "own.yaml").write_text(json.dumps(own))
    (tmp_path / "mine.yaml").write_text(SPEC.replace("idrive", "own.yaml"))
    assert hknob("sweep", "mine.yaml", "-o", "out").returncode == 0
    first = (tmp_path / "out" / "cells.parquet").read_bytes()
    own["scene"]["wall"]["stiffness"] = 0.25
    (tmp_path / "own.yaml").write_text(json.dumps(own))
    done = hknob("sweep", "mine.yaml", "-o", "out", "--dry-run")
    assert "wall.stiffness" in done.stdout + done.stderr
    assert hknob("sweep", "mine.yaml", "-o", "out").returncode == 0
    assert (tmp_path / "out" / "cells.parquet").read_bytes() != first


def test_a_misspelling_stops_before_anything_is_written(hknob, tmp_path) -> None:
    (tmp_path / "mine.yaml").write_text(SPEC.replace("idrive", "idrve"))
    done = hknob("sweep", "mine.yaml", "-o", "out")
    assert done.returncode == 2
    assert done.stderr.startswith(
        "mine.yaml:3:15: scene.from: unknown preset 'idrve'; did you mean 'idrive'? allowed: "
    )
    assert not (tmp_path / "out").exists()
