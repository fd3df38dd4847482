"""``hknob design`` through the command: its answer, files, picture, what they depend on, and in a pipeline."""

import json
import re
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.designs import DESIGN


def test_the_answer_is_said_first_and_kept_in_files(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(DESIGN)
    done = hknob("design", spec, "-o", "out", "--plot")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0].startswith("small: ")
    assert lines[0].endswith(" of 30 designs evaluated for 2 people")
    assert lines[1] == "  stiffness at least 0.26 N*m/rad"
    answer = next(
        at for at, line in enumerate(lines) if line.startswith("The cheapest design that meets every limit: ")
    )
    assert "bounded lag, " in lines[answer]
    assert lines[answer + 1].startswith("  It costs ")
    assert lines[answer + 1].endswith(". Every orbit of everyone is proven.")
    said = " ".join(line.strip() for line in lines)
    assert re.search(r" would save [\d.]+, but misses the limit of touch by [\d.]+ dB", said)
    assert "The present design: plain wall, 1000 Hz, geared, " in said
    assert "all have the same, average" in done.stdout
    table = pq.read_table(tmp_path / "out" / "design.parquet")
    assert sum(table["chosen"].to_pylist()) == sum(table["present"].to_pylist()) == 1
    assert table.schema.field("touch_db").metadata[b"unit"] == b"dB"
    assert (tmp_path / "out" / "design.png").read_bytes().startswith(b"\x89PNG")
    again = hknob("design", spec, "-o", "out")
    assert again.stdout.splitlines()[0] == lines[0] + " (up to date)"
    assert again.stdout.splitlines()[1:20] == lines[1:20]


def test_json_has_the_answer_and_what_less_would_cost(hknob, spec_file) -> None:
    done = hknob("design", spec_file(DESIGN), "-o", "out", "--json")
    said = json.loads(done.stdout)
    chosen, cheaper = said["chosen"], said["next_cheaper"]
    assert chosen["feasible"]
    assert chosen["fails"] == ""
    assert cheaper["cost"] < chosen["cost"] < said["present"]["cost"]
    assert said["next_cheaper_touch_db"] == cheaper["touch_db"] - chosen["touch_db"]
    assert set(said["binding"]) == {step["choice"] for step in said["relaxed"]}
    costs = [row["cost"] for row in said["front"]]
    assert costs == sorted(costs)
    assert said["front"][-1]["cost"] <= chosen["cost"]
    assert said["evaluated"] < said["designs"] == 30
    assert not said["exhaustive"]


def test_nothing_feasible_is_an_answer_too(hknob, spec_file) -> None:
    done = hknob("design", spec_file(DESIGN), "-o", "out", "--set", "constraints.stiffness.at_least=1")
    assert (done.returncode, done.stderr) == (0, "")
    assert "No design meets every limit; all were evaluated." in done.stdout
    assert "30 of 30 designs" in done.stdout


@pytest.mark.long
def test_exhaustive_and_jobs_change_neither_answer_nor_bytes(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(DESIGN)
    more = ("--set", "base.starts.phases=40")  # more than one process is worth
    for out, jobs in (("many", 1), ("processes", 2)):
        assert hknob("design", spec, "-o", out, "-j", jobs, *more).returncode == 0
    alone, together = ((tmp_path / out / "design.parquet").read_bytes() for out in ("many", "processes"))
    assert alone == together
    assert hknob("design", spec, "-o", "a").returncode == 0
    whole = json.loads(hknob("design", spec, "-o", "c", "--set", "exhaustive=true", "--json").stdout)
    some = json.loads(hknob("design", spec, "-o", "a", "--json").stdout)
    assert whole["exhaustive"]
    assert whole["chosen"] == some["chosen"]
    record = json.loads(pq.read_schema(tmp_path / "a" / "design.parquet").metadata[b"hknob.provenance"])
    assert set(record["inputs"]) >= {"perception_sha256", "table_1_sha256", "table_2_sha256", "spec_sha256"}


def test_a_bad_spec_writes_nothing(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("design", spec_file(DESIGN), "-o", "out", "--set", "choices.counts_per_rev=[{value: 0}]")
    assert done.returncode == 2
    assert done.stderr.startswith("--set choices.counts_per_rev=[{value: 0}]: ")
    assert "must be >= 1, got 0" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_check_and_a_pipeline_know_it(hknob, spec_file, tmp_path: Path) -> None:
    spec_file(DESIGN, "design.yaml")
    done = hknob("check", "design.yaml")
    assert done.stdout == "design.yaml: design 'small', 30 designs: good\n"
    spec_file("kind: pipeline\nname: line\nstages:\n  knob: {spec: design.yaml}\n", "line.yaml")
    ran = hknob("run", "line.yaml")
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "results" / "line" / "knob" / "design.parquet").exists()
    assert "Traceback" not in hknob("run", "line.yaml").stderr
