"""``hknob sweep`` through the installed command: exit codes, both streams, and files."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import EXPERIMENTS, SPEC


def test_smoke_grid(hknob, tmp_path: Path) -> None:
    done = hknob("sweep", EXPERIMENTS / "smoke_grid.yaml")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.startswith("smoke-grid: 9 cells, ")
    assert "all proven" in done.stdout
    assert "peak to peak, mrad" in done.stdout
    assert "frequency, Hz" in done.stdout
    assert "wrote results/smoke-grid/cells.parquet" in done.stdout
    names = {path.name for path in (tmp_path / "results" / "smoke-grid").iterdir()}
    assert names == {"cells.parquet", "orbits.parquet", ".hknob.lock"}


def test_json_is_one_object_on_stdout(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(), "--json", "-o", "out")
    summary = json.loads(done.stdout)
    assert summary["name"] == "small"
    assert summary["status"] == "computed"
    assert summary["certified_fraction"] == 1.0
    assert summary["cells"][0]["sample_rate_hz"] == 1000.0
    assert summary["files"] == ["out/cells.parquet", "out/orbits.parquet"]


def test_same_work_gives_the_same_bytes(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(SPEC.replace("[1000]", "[500, 1000, 2000]"))
    for out, jobs in (("a", 1), ("b", 2)):
        assert hknob("sweep", spec, "-o", out, "-j", jobs).returncode == 0
    for name in ("cells.parquet", "orbits.parquet"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_up_to_date_results_are_not_computed_again(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file()
    hknob("sweep", spec, "-o", "out")
    before = (tmp_path / "out" / "cells.parquet").stat()
    again = hknob("sweep", spec, "-o", "out")
    assert "(up to date)" in again.stdout
    assert (tmp_path / "out" / "cells.parquet").stat().st_mtime_ns == before.st_mtime_ns
    forced = hknob("sweep", spec, "-o", "out", "--force")
    assert "(up to date)" not in forced.stdout
    assert (tmp_path / "out" / "cells.parquet").stat().st_mtime_ns > before.st_mtime_ns


def test_dry_run_says_why_and_writes_nothing(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file()
    assert "because: no cells.parquet yet" in hknob("sweep", spec, "-o", "out", "--dry-run").stdout
    assert not (tmp_path / "out").exists()
    hknob("sweep", spec, "-o", "out")
    assert "nothing would run" in hknob("sweep", spec, "-o", "out", "--dry-run").stdout
    changed = hknob("sweep", spec, "-o", "out", "--dry-run", "--set", "starts.phases=9")
    assert "has changed" in changed.stdout
    assert "forced" in hknob("sweep", spec, "-o", "out", "--dry-run", "--force").stdout


def test_overrides_are_validated_and_recorded(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("sweep", spec_file(), "-o", "out", "--set", "scene.hand.stiffness=0.08 N*m/rad", "--set", "name=other")
    assert done.returncode == 0, done.stderr
    record = json.loads(pq.read_schema(tmp_path / "out" / "cells.parquet").metadata[b"hknob.provenance"])
    assert record["overrides"] == ["scene.hand.stiffness=0.08 N*m/rad", "name=other"]
    assert record["spec"]["scene"]["hand"]["stiffness"] == "0.08 N*m/rad"
    bad = hknob("sweep", spec_file(), "--set", "scene.wall.stiffness=-1", "--set", "grid.sample_rate_hz=[0]")
    assert bad.returncode == 2
    assert "--set scene.wall.stiffness=-1: scene.wall.stiffness: must be >= 0, got -1" in bad.stderr
    assert "--set grid.sample_rate_hz=[0]: grid.sample_rate_hz[0]: must be >= 0.001, got 0" in bad.stderr


def test_picture(hknob, spec_file, tmp_path: Path) -> None:
    text = SPEC.replace("[1000]", "[500, 1000]").replace("[1024]", "[512, 1024, 2048]")
    done = hknob("sweep", spec_file(text), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "wrote out/grid.png" in done.stdout
    assert (tmp_path / "out" / "grid.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    three = text.replace("counts_per_rev:", "hand.stiffness: [0.04, 0.08]\n  counts_per_rev:")
    done = hknob("sweep", spec_file(three), "-o", "out3", "--plot")
    assert done.returncode == 0
    assert "no grid.png: more than two axes" in done.stderr


def test_outcomes_are_named_in_the_table(hknob, spec_file) -> None:
    text = SPEC.replace("stiffness: 0.04", "stiffness: 0.08").replace("[1024]", "[1024, 2048]")
    done = hknob("sweep", spec_file(text), "-o", "out")
    assert "rest point" in done.stdout
    assert "r trials come to rest" in done.stdout
    undecided = SPEC.replace("damping: 3.45e-4, ", "").replace("phases: 8", "phases: 1")
    done = hknob("sweep", spec_file(undecided), "-o", "out2")
    assert "% of trials proven" in done.stdout


def test_verbose_and_quiet(hknob, spec_file) -> None:
    assert "trial-samples, interpreted" in hknob("sweep", spec_file(), "-o", "a", "-v").stderr
    assert hknob("sweep", spec_file(), "-o", "b", "-q").stderr == ""


@pytest.mark.parametrize("every", [12, pytest.param(1, marks=pytest.mark.long)])
def test_experiments_are_good(hknob, every: int) -> None:
    """Every twelfth of them, and all."""
    given = sorted(EXPERIMENTS.glob("*.yaml"))[::every]
    good = hknob("check", *given)
    assert good.returncode == 0
    assert good.stdout.count(": good") == len(given)


def test_other_commands(hknob) -> None:
    assert hknob("--version").stdout.startswith("hknob ")
    assert json.loads(hknob("schema", "sweep").stdout)["title"] == "hknob sweep spec"
    assert hknob("schema", "nonsense").returncode == 2


def test_usage_errors(hknob, spec_file) -> None:
    assert hknob("sweep").returncode == 2
    assert hknob("sweep", spec_file(), "--jobs", "0").returncode == 2
    assert hknob("sweep", "nowhere.yaml").returncode == 2
    for options, wanted in {
        ("--executor", "dask"): "--executor dask: needs --scheduler",
        ("--scheduler", "tcp://here:8786"): "--scheduler: needs --executor dask",
        ("--executor", "dask", "--scheduler", "nonsense://x"): "--scheduler: must be an address",
    }.items():
        done = hknob("sweep", spec_file(), *options)
        assert (done.returncode, wanted in done.stderr) == (2, True), done.stderr
    done = hknob("dfa", spec_file(), "--executor", "dask", "--scheduler", "tcp://here:8786")
    assert (done.returncode, "dfa is not spread; dask is for sweep and run" in done.stderr) == (2, True)
