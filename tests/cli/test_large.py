"""A sweep of more cells than a file holds: folders of parts, which every reader and every later stage takes."""

import json
import subprocess
from pathlib import Path

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pytest

from tests.conftest import EXPERIMENTS, HKNOB

PATCHED = (
    "import sys; import hknob_cli.results.parted as p; p.PART_CELLS = 20; p.Parting.__new__.__defaults__ = (20,); "
    "sys.argv[0] = 'hknob'; "
    "from hknob_cli.cli.main import main; main()"
)
pytestmark = pytest.mark.long

GRID = EXPERIMENTS / "hand_on_knob_half_quantum.yaml"


def in_parts(*args: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a command of the program for which 20 cells fill a part."""
    command = [HKNOB.with_name("python"), "-c", PATCHED, *map(str, args)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The grid in one file as ``whole``, in parts as ``parts``."""
    place = tmp_path_factory.mktemp("large")
    subprocess.run([HKNOB, "sweep", GRID, "-o", place / "whole", "-q"], check=True, capture_output=True)
    done = in_parts("sweep", GRID, "-o", "parts", "--jobs", "2", cwd=place)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (place / "parts").iterdir()} == {"cells.parquet", "orbits.parquet", ".hknob.lock"}
    return place


@pytest.mark.parametrize("name", ["cells.parquet", "orbits.parquet"])
def test_readers_take_the_folder_for_one_table(both: Path, name: str) -> None:
    whole, folder = pd.read_parquet(both / "whole" / name), both / "parts" / name
    assert len(list(folder.iterdir())) == 3
    pd.testing.assert_frame_equal(pd.read_parquet(folder), whole)
    assert pl.read_parquet(folder)["p2p_rad"].to_list() == whole["p2p_rad"].to_list()
    found = duckdb.sql(f"SELECT sum(p2p_rad), count(*) FROM '{folder}/*.parquet'").fetchall()[0]
    assert found == (pytest.approx(whole["p2p_rad"].sum(), rel=1e-15), len(whole))


def test_the_summary_counts_what_nobody_lists(both: Path) -> None:
    done = in_parts("sweep", GRID, "-o", "parts", "--json", cwd=both)
    summary = json.loads(done.stdout)
    cells, orbits = (pd.read_parquet(both / "whole" / f"{name}.parquet") for name in ("cells", "orbits"))
    assert (summary["status"], summary["cell_count"]) == ("up to date", 49)
    assert summary["orbits"] == {kind: int((orbits["outcome"] == kind).sum()) for kind in summary["orbits"]}
    assert summary["certified_fraction"] == pytest.approx(cells["certified_fraction"].mean(), rel=1e-12)
    most = cells.loc[cells["p2p_max_rad"].idxmax()]
    assert summary["extremes"]["most_p2p_max_rad"] == {
        name: most[name] for name in ("p2p_max_rad", "p2p_rad", "sample_rate_hz", "counts_per_rev")
    }
    least = cells["frequency_at_max_hz"].min()
    assert summary["extremes"]["least_frequency_at_max_hz"]["frequency_at_max_hz"] == least
    text = in_parts("sweep", GRID, "-o", "parts", cwd=both).stdout
    assert "49 cells (up to date)" in text
    size, mean = (f"{1e3 * most[name]:.4g}" for name in ("p2p_max_rad", "p2p_rad"))
    assert f"greatest peak to peak: {size} mrad{f' (mean of the cell {mean})' if mean != size else ''}, at" in text
    assert ", at sample_rate_hz = 100" in text


def test_later_stages_take_it(both: Path) -> None:
    spec = EXPERIMENTS / "predict_hand_on_knob.yaml"
    for which in ("whole", "parts"):
        settings = ("--set", "scene.bias={half_quantum: true}", "--set", f"against={which}")
        done = in_parts("predict", spec, "-o", f"predict-{which}", *settings, cwd=both)
        assert done.returncode == 0, done.stderr
    one, other = (pd.read_parquet(both / f"predict-{which}" / "predict.parquet") for which in ("whole", "parts"))
    pd.testing.assert_frame_equal(one, other)
    assert np.isfinite(one["p2p_difference"]).any()
    (both / "p.yaml").write_text(
        f"kind: pipeline\nname: p\nstages:\n  grid: {{spec: {GRID}}}\n"
        f"  page: {{spec: {EXPERIMENTS / 'smoke_report.yaml'}, set: {{results: {{from: [grid]}}, claims: null}}}}\n"
    )
    for status in ("computed", "up to date"):
        done = in_parts("run", "p.yaml", "-o", "piped", "--json", cwd=both)
        assert done.returncode == 0, done.stderr
        assert {stage["status"] for stage in json.loads(done.stdout)["stages"]} == {status}


def test_one_file_takes_the_place_of_parts_and_back(both: Path) -> None:
    wanted = (both / "whole" / "cells.parquet").read_bytes()
    assert in_parts("sweep", GRID, "-o", "swap", cwd=both).returncode == 0
    assert (both / "swap" / "cells.parquet").is_dir()
    subprocess.run([HKNOB, "sweep", GRID, "-o", both / "swap", "--force"], check=True, capture_output=True)
    assert (both / "swap" / "cells.parquet").read_bytes() == wanted
    assert in_parts("sweep", GRID, "-o", "swap", "--force", cwd=both).returncode == 0
    assert (both / "swap" / "cells.parquet").is_dir()
    assert {path.name for path in (both / "swap").iterdir()} == {"cells.parquet", "orbits.parquet", ".hknob.lock"}


def test_what_another_spec_had_finished_is_not_removed_in_silence(tmp_path: Path) -> None:
    said = "out: what a run of another spec, --set or version had finished here goes when this one is done"
    for more, spoken in (((), True), (("-q",), False)):
        left = tmp_path / "out" / ".hknob.partial-0123456789abcdef"
        left.mkdir(parents=True)
        (left / "0-2.piece").write_bytes(b"")
        done = subprocess.run(
            [HKNOB, "sweep", GRID, "-o", "out", "--force", *more],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        assert (said in done.stderr) == spoken
        assert not left.exists()
