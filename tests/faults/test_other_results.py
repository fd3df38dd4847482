"""Results of another spec in the folder: replaced and said, or refused; one folder keeps one kind and one name."""

import json
from pathlib import Path

import pytest

from tests.conftest import SPEC

DFA = SPEC.replace("kind: sweep", "kind: dfa").replace("starts: {angle: 0.02, phases: 8}\n", "")
STIFFER = ("--set", "scene.wall.stiffness=0.5")


def kept(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != ".hknob.lock"}


def test_a_spec_with_another_stiffness_replaces_the_results_and_says_so_in_one_line(hknob, spec_file) -> None:
    spec = spec_file()
    assert hknob("sweep", spec, "-o", "out").stderr == ""
    done = hknob("sweep", spec, "-o", "out", *STIFFER)
    assert done.returncode == 0
    assert done.stderr == "out: these results are replaced; changed since: scene.wall.stiffness 0.27 -> 0.5\n"
    assert hknob("sweep", spec, "-o", "out", *STIFFER).stderr == ""
    assert hknob("sweep", spec, "-o", "out", "-q").stderr == ""


def test_what_has_changed_is_in_the_plan_and_in_json(hknob, spec_file) -> None:
    spec = spec_file()
    hknob("sweep", spec, "-o", "out")
    changed = [{"key": "scene.wall.stiffness", "old": "0.27", "new": "0.5"}]
    dry = hknob("sweep", spec, "-o", "out", *STIFFER, "--dry-run")
    assert "changed since: scene.wall.stiffness 0.27 -> 0.5; it would write" in dry.stdout
    assert json.loads(hknob("sweep", spec, "-o", "out", *STIFFER, "--dry-run", "--json").stdout)["changed"] == changed
    assert json.loads(hknob("sweep", spec, "-o", "out", *STIFFER, "--json").stdout)["changed"] == changed
    assert "changed" not in json.loads(hknob("sweep", spec, "-o", "out", *STIFFER, "--json").stdout)


@pytest.mark.parametrize("more", [(), ("--force",)])
def test_a_dfa_is_never_put_beside_a_sweep(hknob, spec_file, tmp_path: Path, more: tuple[str, ...]) -> None:
    """Of the same name, too, and though not one file of the sweep would be overwritten."""
    hknob("sweep", spec_file(), "-o", "out", "--plot")
    before = kept(tmp_path / "out")
    done = hknob("dfa", spec_file(DFA, "dfa.yaml"), "-o", "out", *more)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1)
    assert "holds the sweep 'small'" in done.stderr
    assert "choose another --out" in done.stderr
    assert kept(tmp_path / "out") == before


def test_a_plan_says_so_too(hknob, spec_file) -> None:
    hknob("sweep", spec_file(), "-o", "out")
    assert hknob("dfa", spec_file(DFA, "dfa.yaml"), "-o", "out", "--dry-run").returncode == 3


def test_a_sweep_is_never_put_beside_recordings(hknob, spec_file, tmp_path: Path) -> None:
    (tmp_path / "out" / "recording").mkdir(parents=True)
    (tmp_path / "out" / "recording" / "campaign.json").write_text('{"identity": "x", "source": true}')
    done = hknob("sweep", spec_file(), "-o", "out")
    assert done.returncode == 3
    assert "holds the recordings of a campaign" in done.stderr
    assert not (tmp_path / "out" / "cells.parquet").exists()


def test_a_dfa_is_never_put_beside_a_sweep_that_was_cut_short(hknob, spec_file, tmp_path: Path) -> None:
    (tmp_path / "out" / ".hknob.partial-0123456789abcdef").mkdir(parents=True)
    done = hknob("dfa", spec_file(DFA, "dfa.yaml"), "-o", "out")
    assert done.returncode == 3
    assert "holds what a sweep that was cut short has finished" in done.stderr


def test_files_of_the_user_in_the_folder_are_left_alone(hknob, spec_file, tmp_path: Path) -> None:
    mine = tmp_path / "out"
    mine.mkdir()
    (mine / "notes.txt").write_text("mine")
    (mine / "photo.png").write_bytes(b"\x89PNG, but not of hknob")
    (mine / "mine.parquet").write_bytes(b"PAR1 torn")
    done = hknob("sweep", spec_file(), "-o", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert (mine / "notes.txt").read_text() == "mine"


def test_a_link_that_was_planted_in_the_folder_is_not_followed(hknob, spec_file, tmp_path: Path) -> None:
    hknob("dfa", spec_file(DFA, "dfa.yaml"), "-o", "other")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "dfa.parquet").symlink_to(tmp_path / "other" / "dfa.parquet")
    (tmp_path / "out" / "endless.parquet").symlink_to("/dev/zero")
    assert hknob("sweep", spec_file(), "-o", "out").returncode == 0


def test_explain_names_the_value_that_changed_with_old_and_new(hknob, spec_file) -> None:
    spec = spec_file()
    hknob("run", spec, "-o", "out")
    spec.write_text(SPEC.replace("stiffness: 0.27", "stiffness: 0.6"))
    done = hknob("run", spec, "-o", "out", "--explain")
    assert "    scene.wall.stiffness 0.27 -> 0.6" in done.stdout.splitlines()
    stages = json.loads(hknob("run", spec, "-o", "out", "--explain", "--json").stdout)["stages"]
    assert stages[0]["changed"] == [{"key": "scene.wall.stiffness", "old": "0.27", "new": "0.6"}]
