"""``hknob run`` through the installed command: what runs, what does not, why, and what is said."""

import json
import re
import shutil
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.pipeline.steps import found_in
from tests.conftest import SPEC

PREDICT = SPEC.replace("kind: sweep", "kind: predict").replace("name: small", "name: laws").partition("starts:")[0]
PIPELINE = """\
kind: pipeline
name: two
stages:
  grid: {spec: sweep.yaml}
  laws: {spec: predict.yaml, set: {against: {from: grid}}}
  other: {spec: sweep.yaml, set: {starts.phases: 4}}
"""


@pytest.fixture
def pipeline(tmp_path: Path) -> Path:
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "sweep.yaml").write_text(SPEC)
    (tmp_path / "specs" / "predict.yaml").write_text(PREDICT)
    path = tmp_path / "specs" / "pipeline.yaml"
    path.write_text(PIPELINE)
    return path


def statuses(done) -> dict[str, str]:
    assert done.returncode == 0, done.stderr
    return {stage["name"]: stage["status"] for stage in json.loads(done.stdout)["stages"]}


def test_only_what_changed_runs_again(hknob, pipeline: Path, tmp_path: Path) -> None:
    first = statuses(hknob("run", pipeline, "--json"))
    assert first == dict.fromkeys(("grid", "laws", "other"), "computed")
    root = tmp_path / "results" / "two"
    assert {path.name for path in (root / "laws").glob("*.parquet")} == {
        "predict.parquet",
        "passivity.parquet",
        "differences.parquet",
    }
    assert statuses(hknob("run", pipeline, "--json")) == dict.fromkeys(first, "up to date")
    for name in ("sweep.yaml", "predict.yaml", "pipeline.yaml"):
        (pipeline.parent / name).touch()
    assert statuses(hknob("run", pipeline, "--json")) == dict.fromkeys(first, "up to date")
    spec = pipeline.parent / "predict.yaml"
    spec.write_text(PREDICT.replace("stiffness: 0.27", "stiffness: 0.3"))
    again = statuses(hknob("run", pipeline, "--json"))
    assert again == {"grid": "up to date", "laws": "computed", "other": "up to date"}
    (pipeline.parent / "sweep.yaml").write_text(SPEC.replace("0.27", "0.3"))
    assert statuses(hknob("run", pipeline, "--json")) == dict.fromkeys(first, "computed")


@pytest.mark.one_in(2)
@pytest.mark.parametrize("there", ["nothing", "all", "no table", "no pipeline", "a folder"])
def test_what_make_repeats_says_what_a_command_that_is_parsed_says(
    hknob, pipeline: Path, tmp_path: Path, there
) -> None:
    """Once read by hand where nothing is to do, once by typer, which takes an option before the file, too."""
    root = tmp_path / "out"
    if there != "nothing":
        hknob("run", pipeline, "--out", root)
    said = []
    for words in ((pipeline, "-o" if there == "all" else "--out", root), ("--out", root, pipeline)):
        if there == "no table":
            (root / "grid" / "cells.parquet").unlink()
        elif there == "no pipeline":
            pipeline.unlink(missing_ok=True)
        elif there == "a folder" and pipeline.is_file():
            pipeline.unlink()
            pipeline.mkdir()
        elif there == "nothing":
            shutil.rmtree(root, ignore_errors=True)
        done = hknob("run", *words)
        said.append((done.returncode, done.stdout, re.sub(r"in [0-9.]+ s", "in a while", done.stderr)))
    assert sorted(said[0][2].splitlines()) == sorted(said[1][2].splitlines())
    assert said[0][:2] == said[1][:2]
    assert ("3 up to date" in said[0][1]) == (there == "all")


@pytest.mark.parametrize("words", [("--out", " "), ("--out",), ("--out", "-q"), ("--out", "--json")])
def test_faults_of_what_make_repeats_are_left_to_the_parser(hknob, pipeline: Path, words: tuple[str, ...]) -> None:
    _, here, before = (hknob("run", *line) for line in ((pipeline, *words), (pipeline, *words), (*words, pipeline)))
    assert (here.returncode, here.stdout) == (before.returncode, before.stdout)


def test_a_comment_in_a_spec_makes_nothing_that_hangs_on_it_run(hknob, pipeline: Path) -> None:
    hknob("run", pipeline)
    (pipeline.parent / "sweep.yaml").write_text(SPEC + "# a remark\n")
    done = hknob("run", pipeline, "--json")
    assert statuses(done)["laws"] == "up to date"
    assert "grid: as it was" in done.stderr


def test_a_lost_or_damaged_result_is_made_again(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("run", pipeline)
    cells = tmp_path / "results" / "two" / "grid" / "cells.parquet"
    before = cells.read_bytes()
    cells.unlink()
    again = statuses(hknob("run", pipeline, "--json"))
    assert again == {"grid": "computed", "laws": "up to date", "other": "up to date"}
    assert cells.read_bytes() == before
    cells.write_bytes(before[: len(before) // 2])
    assert statuses(hknob("run", pipeline, "--json"))["grid"] == "computed"
    assert cells.read_bytes() == before


def test_plans_say_what_would_run_and_why_and_write_nothing(hknob, pipeline: Path, tmp_path: Path) -> None:
    done = hknob("run", pipeline, "--dry-run")
    assert done.stdout.splitlines() == [
        "grid: would run, because no cells.parquet yet",
        "laws: would run, because grid would run",
        "other: would run, because no cells.parquet yet",
    ]
    assert not (tmp_path / "results").exists()
    hknob("run", pipeline)
    assert "up to date" in hknob("run", pipeline, "--explain").stdout
    (pipeline.parent / "predict.yaml").write_text(PREDICT + "# a remark\n")
    explained = hknob("run", pipeline, "--explain", "--set", "stages.other.set.starts.phases=5")
    assert explained.stdout.replace(f"{tmp_path}/", "").splitlines() == [
        "grid: up to date",
        "laws: would run, because",
        "  specs/predict.yaml has changed",
        "other: would run, because",
        "  what the pipeline sets in the spec has changed",
        "    starts.phases 4 -> 5",
    ]
    forced = hknob("run", pipeline, "--dry-run", "--force")
    assert forced.stdout.count("would run, because forced") == 3


def test_until_runs_one_stage_and_what_it_needs(hknob, pipeline: Path, tmp_path: Path) -> None:
    assert list(statuses(hknob("run", pipeline, "--until", "laws", "--json"))) == ["grid", "laws"]
    assert not (tmp_path / "results" / "two" / "other").exists()
    rest = statuses(hknob("run", pipeline, "--json"))
    assert rest == {"grid": "up to date", "laws": "up to date", "other": "computed"}
    wrong = hknob("run", pipeline, "--until", "nothing")
    assert wrong.returncode == 2
    assert "unknown stage 'nothing'" in wrong.stderr
    assert "grid, laws, other" in wrong.stderr


def test_force_computes_everything_to_the_same_bytes(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("run", pipeline)
    files = sorted((tmp_path / "results").rglob("*.parquet"))
    before = [path.read_bytes() for path in files]
    assert set(statuses(hknob("run", pipeline, "--force", "--json")).values()) == {"computed"}
    assert [path.read_bytes() for path in files] == before


def test_results_do_not_depend_on_where_they_lie(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("run", pipeline, "-o", "here")
    moved = tmp_path / "elsewhere"
    shutil.copytree(pipeline.parent, moved)
    hknob("run", moved / "pipeline.yaml", "-o", "there/deeper")
    for file in ("grid/cells.parquet", "laws/differences.parquet", "laws/predict.parquet"):
        assert (tmp_path / "here" / file).read_bytes() == (tmp_path / "there/deeper" / file).read_bytes()


def test_stages_are_what_the_commands_make_of_the_same_spec(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("run", pipeline)
    hknob("sweep", "specs/sweep.yaml", "-o", "alone")
    for name in ("cells.parquet", "orbits.parquet"):
        assert (tmp_path / "alone" / name).read_bytes() == (tmp_path / "results/two/grid" / name).read_bytes()


def test_a_spec_alone_is_a_pipeline_of_one_stage(hknob, pipeline: Path, tmp_path: Path) -> None:
    assert statuses(hknob("run", "specs/sweep.yaml", "--json")) == {"sweep": "computed"}
    assert (tmp_path / "results" / "small" / "sweep" / "cells.parquet").exists()


def test_a_stage_command_takes_its_only_stage_of_a_pipeline(hknob, pipeline: Path) -> None:
    many = hknob("sweep", pipeline)
    assert many.returncode == 2
    assert "is a pipeline; hknob run runs it. Specs of its sweep stages: specs/sweep.yaml, specs/sweep.yaml" in (
        many.stderr.replace(str(pipeline.parent), "specs")
    )
    pipeline.write_text("kind: pipeline\nname: one\nstages:\n  grid: {spec: sweep.yaml, set: {starts.phases: 3}}\n")
    done = hknob("sweep", pipeline, "--json")
    assert json.loads(done.stdout)["cells"][0]["certified_fraction"] == 1.0


def test_a_folder_is_a_source(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("sweep", "specs/sweep.yaml", "-o", "specs/measured")
    pipeline.write_text(PIPELINE.replace("grid: {spec: sweep.yaml}", "grid: {folder: measured}"))
    assert list(statuses(hknob("run", pipeline, "--json"))) == ["laws", "other"]
    assert not (tmp_path / "results" / "two" / "grid").exists()
    shutil.rmtree(pipeline.parent / "measured")
    gone = hknob("run", pipeline)
    assert gone.returncode == 2
    assert "stages.grid" in gone.stderr
    assert "no results in" in gone.stderr


def test_check_looks_into_every_stage(hknob, pipeline: Path) -> None:
    assert "pipeline 'two', 3 stages: good" in hknob("check", pipeline).stdout
    (pipeline.parent / "predict.yaml").write_text(PREDICT.replace("0.27", "-0.27"))
    done = hknob("check", pipeline)
    assert done.returncode == 2
    assert "predict.yaml:6:21: scene.wall.stiffness: must be >= 0, got -0.27" in done.stderr


def test_a_stage_that_fails_stops_what_hangs_on_it_and_nothing_else(hknob, pipeline: Path, tmp_path: Path) -> None:
    (tmp_path / "results" / "two" / "grid").mkdir(parents=True)
    (tmp_path / "results" / "two" / "grid" / "cells.parquet").write_text("mine")
    done = hknob("run", pipeline)
    assert done.returncode == 3
    assert "grid: failed: results/two/grid/cells.parquet: not written by hknob" in done.stderr
    assert "not reached: laws" in done.stderr
    assert (tmp_path / "results" / "two" / "other" / "cells.parquet").exists()
    assert "Traceback" not in done.stderr


def test_results_given_as_folders_are_seen_to_change(hknob, pipeline: Path, tmp_path: Path) -> None:
    """Those of no stage: a folder to compare with, a source, a report's list; a file more in one of them."""
    hknob("sweep", "specs/sweep.yaml", "-o", "measured")
    (tmp_path / "specs" / "page.yaml").write_text("kind: report\nname: page\nresults: [measured]\n")
    pipeline.write_text(
        "kind: pipeline\nname: two\nstages:\n  source: {folder: ../measured}\n"
        "  laws: {spec: predict.yaml, set: {against: measured}}\n"
        "  page: {spec: page.yaml}\n  other: {spec: page.yaml, set: {results: {from: source}}}\n"
    )
    everything = {"laws", "page", "other"}
    assert set(statuses(hknob("run", pipeline, "--json"))) == everything
    assert set(statuses(hknob("run", pipeline, "--json")).values()) == {"up to date"}
    hknob("sweep", "specs/sweep.yaml", "-o", "measured", "--set", "starts.phases=3")
    again = statuses(hknob("run", pipeline, "--json"))
    assert {name for name, status in again.items() if status == "computed"} == everything
    (tmp_path / "measured" / "more.parquet").write_bytes((tmp_path / "measured" / "cells.parquet").read_bytes())
    assert "page: would run" in hknob("run", pipeline, "--dry-run").stdout
    assert statuses(hknob("run", pipeline, "--json"))["page"] == "computed"


def test_the_same_words_elsewhere_are_another_pipeline(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("run", pipeline, "-o", "out")
    shutil.copytree(pipeline.parent, tmp_path / "moved")
    (tmp_path / "moved" / "sweep.yaml").write_text(SPEC.replace("0.27", "0.3"))
    assert statuses(hknob("run", "moved/pipeline.yaml", "-o", "out", "--json"))["grid"] == "computed"


def test_a_moved_folder_says_where_its_files_are(hknob, pipeline: Path, tmp_path: Path) -> None:
    hknob("run", pipeline, "-o", "out/deeper")
    (tmp_path / "out").rename(tmp_path / "moved")
    for stage in json.loads(hknob("run", pipeline, "-o", "moved/deeper", "--json").stdout)["stages"]:
        assert all((tmp_path / file).exists() for file in stage["files"])


def test_figures_of_a_page_that_lists_none_are_made_again(hknob, pipeline: Path, tmp_path: Path) -> None:
    grid = SPEC.replace("[1000]", "[500, 1000]").replace("[1024]", "[512, 1024]")
    (pipeline.parent / "sweep.yaml").write_text(grid)
    (pipeline.parent / "page.yaml").write_text("kind: report\nname: page\nresults: [grid]\n")
    pipeline.write_text(
        "kind: pipeline\nname: two\nstages:\n  grid: {spec: sweep.yaml}\n"
        "  page: {spec: page.yaml, set: {results: {from: [grid]}}}\n"
    )
    hknob("run", pipeline)
    figures = sorted((tmp_path / "results/two/page/figures").iterdir())
    assert len(figures) == 2  # size, pitch; means are in brackets
    assert "hknob run pipeline.yaml" in (tmp_path / "results/two/page/report.html").read_text()
    figures[0].unlink()
    assert statuses(hknob("run", pipeline, "--json")) == {"grid": "up to date", "page": "computed"}
    assert figures[0].exists()


def test_a_plan_touches_nothing(hknob, pipeline: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    hknob("run", pipeline, "-o", "out", "--dry-run")
    assert not list((tmp_path / "out").iterdir())
    hknob("run", pipeline, "-o", "out")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")}
    hknob("run", pipeline, "-o", "out", "--explain", "--force")
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")} == before


def test_a_stage_that_is_done_says_what_it_found(hknob, pipeline: Path, tmp_path: Path) -> None:
    """In a sentence or two, once: a run with nothing to do says nothing of it, and a quiet one never."""
    done = hknob("run", pipeline)
    said = dict(line.split(": ", 1) for line in done.stderr.splitlines())
    assert re.match(r"computed in \S+ s\. It buzzes in this cell, from the starts tried: \S+ mrad at ", said["grid"])
    assert ". The wall is not passive at this rate and these counts: " in said["laws"]
    assert hknob("run", pipeline).stderr == ""
    assert hknob("run", pipeline, "--force", "-q").stderr == ""
    (tmp_path / "results" / "two" / "grid" / "cells.parquet").write_bytes(b"")
    assert found_in("grid", tmp_path / "results" / "two" / "grid") == ""
    assert found_in("none", tmp_path) == ""


def test_a_page_that_is_done_says_its_verdicts(tmp_path: Path) -> None:
    texts = {"claim": ["a", "b", "c"], "verdict": ["contradicted", "reproduced", "reproduced"]}
    record = json.dumps({"stage": "report", "spec": {}, "overrides": [], "inputs": {"spec_sha256": ""}}).encode()
    pq.write_table(pa.table(texts).replace_schema_metadata({"hknob.provenance": record}), tmp_path / "claims.parquet")
    assert found_in("page", tmp_path) == "Of 3 claims: 2 reproduced, 1 contradicted."
