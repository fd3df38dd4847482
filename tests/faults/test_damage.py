"""Damage at rest: results that are not as they were written are made again and said so; sources are an error."""

import json
import re
from pathlib import Path
from random import Random

import pytest

from tests.conftest import SPEC

NOT = "is not as it was written: damaged, or changed"
PREDICT = re.sub(r"starts: .*\n", "", SPEC.replace("kind: sweep", "kind: predict").replace("name: small", "name: laws"))
REPORT = "kind: report\nname: page\nresults: {grid: grid}\n"
PIPELINE = """\
kind: pipeline
name: two
stages:
  grid: {spec: spec.yaml}
  page: {spec: report.yaml, set: {results: {from: [grid]}}}
"""


def flip(path: Path, seed: int = 1, *, among: slice = slice(None)) -> bytes:
    """Flip one bit somewhere in a file, or in some of its bytes; the file as it was."""
    before = path.read_bytes()
    place = Random(seed).choice(range(len(before))[among])
    path.write_bytes(before[:place] + bytes([before[place] ^ 1 << seed % 8]) + before[place + 1 :])
    return before


@pytest.mark.parametrize("where", ["the numbers", "the footer"])
def test_a_damaged_result_is_made_again(where: str, hknob, spec_file, tmp_path: Path) -> None:
    spec, out = spec_file(), tmp_path / "out"
    assert hknob("sweep", spec, "-o", "out").returncode == 0
    length = len((out / "cells.parquet").read_bytes())
    among = slice(4, length // 4) if where == "the numbers" else slice(-300, -8)
    before = flip(out / "cells.parquet", among=among)
    told = hknob("sweep", spec, "-o", "out", "--dry-run")
    assert "would run, because: out/cells.parquet is not as it was written" in told.stdout
    done = hknob("sweep", spec, "-o", "out", "--json")
    assert json.loads(done.stdout)["status"] == "computed"
    assert f"out/cells.parquet: {NOT}; it is made again" in done.stderr
    assert (out / "cells.parquet").read_bytes() == before
    again = hknob("sweep", spec, "-o", "out", "--json")
    assert (json.loads(again.stdout)["status"], again.stderr) == ("up to date", "")


@pytest.mark.one_in(2)
@pytest.mark.parametrize("file", ["grid/cells.parquet", "grid/orbits.parquet", "page/report.html", "pipeline.json"])
def test_a_pipeline_makes_again_what_is_damaged(file: str, hknob, spec_file, tmp_path: Path) -> None:
    spec_file()
    (tmp_path / "report.yaml").write_text(REPORT)
    pipeline = spec_file(PIPELINE, "pipeline.yaml")
    root = tmp_path / "results" / "two"
    assert hknob("run", pipeline).returncode == 0
    wanted = {path: path.read_bytes() for path in root.glob("*/*.*") if path.suffix in (".parquet", ".html")}
    flip(root / file, 3)
    assert hknob("verify", root).returncode == 1
    done = hknob("run", pipeline)
    assert done.returncode == 0, done.stderr
    assert (f"{NOT}; it is made again" in done.stderr) == (file != "pipeline.json")
    assert {path: path.read_bytes() for path in wanted} == wanted
    assert hknob("verify", root).returncode == 0


def test_a_damaged_file_that_a_spec_names_is_an_error(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("sweep", spec_file(), "-o", "grid").returncode == 0
    flip(tmp_path / "grid" / "cells.parquet")
    for name, text in {"predict": f"{PREDICT}against: grid\n", "report": REPORT}.items():
        done = hknob(name, spec_file(text, f"{name}.yaml"))
        assert (done.returncode, done.stdout) == (2, "")
        assert "grid/cells.parquet is not as it was written: damaged, or changed" in done.stderr
        assert not (tmp_path / "results").exists()


def test_verify_says_of_each_file_what_it_is(hknob, spec_file, tmp_path: Path) -> None:
    spec, out = spec_file(), tmp_path / "out"
    assert hknob("sweep", spec, "-o", "out", "--plot").returncode == 0
    (out / "notes.txt").write_text("mine")
    (out / "mine.json").write_text("{}")
    done = hknob("verify", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "out/cells.parquet: as written",
        "out/grid.png: as written",
        "out/mine.json: not checked: not written by hknob",
        "out/notes.txt: not checked",
        "out/orbits.parquet: as written",
        "out: 3 as written, 2 not checked",
    ]
    for name in ("orbits.parquet", "grid.png"):
        before = flip(out / name)
        done = hknob("verify", "out", "--json")
        assert done.returncode == 1
        files = {Path(one["file"]).name: one["verdict"] for one in json.loads(done.stdout)["files"]}
        assert [file for file, verdict in files.items() if verdict == "NOT as written"] == [name]
        assert "out: 1 of 5 files are not as written" in done.stderr
        assert hknob("verify", "out", "-q").stdout.startswith(f"out/{name}: NOT as written: ")
        (out / name).write_bytes(before)


def test_verify_of_no_results_is_bad_usage(hknob, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").touch()
    for name, said in {"empty": "holds no results", "file": "is not a folder", "gone": "no such folder"}.items():
        done = hknob("verify", name)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(f"{name}: {said}")
