"""Grids that are designs, through the command: sweep, dfa and predict on the same points; provenance; a page."""

import json
from importlib.metadata import version
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from tests.conftest import SPEC

GRID = "  sample_rate_hz: [1000]\n  counts_per_rev: [1024]\n"
DESIGN = SPEC.replace(
    GRID,
    "  design: {sobol: 16}\n  sample_rate_hz: {log: [500, 4000]}\n  counts_per_rev: [256, 512, 1024]\n"
    "  hand.stiffness: {lin: [0.02, 0.2]}\n  bias.torque: 0.001\n",
)
AXES = ["sample_rate_hz", "counts_per_rev", "hand.stiffness", "bias.torque"]


def analysis(kind: str, rest: str = "") -> str:
    return DESIGN.replace("kind: sweep", f"kind: {kind}").split("starts")[0] + rest


def rows(path: Path) -> list[dict]:
    return pq.read_table(path).to_pylist()


def versions(path: Path) -> dict[str, str]:
    return json.loads(pq.read_schema(path).metadata[b"hknob.provenance"])["versions"]


@pytest.mark.long
def test_a_sweep_of_a_design(hknob, spec_file, tmp_path: Path) -> None:
    path = spec_file(DESIGN)
    assert "sweep 'small', 16 cells: good" in hknob("check", path).stdout
    done = hknob("sweep", path, "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "16 cells" in done.stdout
    cells = rows(tmp_path / "out" / "cells.parquet")
    assert list(cells[0])[:4] == AXES
    assert [{axis: row[axis] for axis in AXES} for row in cells] == list(cells_of(load(path)))
    assert versions(tmp_path / "out" / "cells.parquet")["scipy"] == version("scipy")
    hknob("sweep", path, "-o", "again", "-j", "1")
    for name in ("cells.parquet", "orbits.parquet"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()
    assert "(up to date)" in hknob("sweep", path, "-o", "out").stdout


def test_only_what_scipy_draws_depends_on_its_version(hknob, spec_file, tmp_path: Path) -> None:
    hknob("sweep", spec_file(), "-o", "grid")
    hknob("sweep", spec_file(DESIGN), "-o", "random", "--set", "grid.design={random: 4}")
    hknob("predict", spec_file(analysis("predict")), "-o", "laws")
    found = {name: versions(next((tmp_path / name).glob("*.parquet"))) for name in ("grid", "random", "laws")}
    assert ["scipy" in found[name] for name in ("grid", "random", "laws")] == [False, False, True]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("kind", "file", "column"), [("dfa", "dfa", "method"), ("predict", "predict", "law")])
def test_analyses_meet_the_sweep_on_the_same_points(kind, file, column, hknob, spec_file, tmp_path: Path) -> None:
    hknob("sweep", spec_file(DESIGN, "sweep.yaml"), "-o", "swept")
    path = spec_file(analysis(kind, "against: swept\n"))
    done = hknob(kind, path, "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    swept = {tuple(row[axis] for axis in AXES): row for row in rows(tmp_path / "swept" / "cells.parquet")}
    assert len(swept) == 16
    found = rows(tmp_path / "out" / f"{file}.parquet")
    assert {tuple(row[axis] for axis in AXES) for row in found} == set(swept)
    known = [row for row in found if row["p2p_difference"] is not None]
    assert len({row[column] for row in known}) >= 3
    for row in known:
        cell = swept[tuple(row[axis] for axis in AXES)]
        if not cell["at_rest_fraction"]:
            assert row["p2p_difference"] == pytest.approx(row["p2p_rad"] / cell["p2p_rad"] - 1.0)
    other = hknob(kind, path, "-o", "other", "--set", "grid.design.seed=2")
    assert other.returncode == 2
    assert "against: swept/cells.parquet has no cell of this grid" in other.stderr


def test_points_that_coincide_are_compared(hknob, spec_file, tmp_path: Path) -> None:
    lists = ("--set", "grid.sample_rate_hz=1000", "--set", "grid.hand.stiffness=[0.04, 0.08]")
    hknob("sweep", spec_file(DESIGN, "sweep.yaml"), "-o", "swept", *lists)
    assert len({tuple(row[axis] for axis in AXES) for row in rows(tmp_path / "swept" / "cells.parquet")}) < 16
    done = hknob("predict", spec_file(analysis("predict", "against: swept\n")), "-o", "out", *lists)
    assert done.returncode == 0, done.stderr
    assert len(rows(tmp_path / "out" / "predict.parquet")) == 3 * 16


@pytest.mark.long
def test_two_ranges_are_no_map(hknob, spec_file, tmp_path: Path) -> None:
    two = ("--set", "grid.hand.stiffness=0.04", "--set", "grid.counts_per_rev={log: [128, 4096]}", "--plot")
    for kind in ("sweep", "dfa", "predict"):
        text = DESIGN if kind == "sweep" else analysis(kind)
        done = hknob(kind, spec_file(text.replace("sobol: 16", "sobol: 8"), f"{kind}.yaml"), "-o", kind, *two)
        assert done.returncode == 0, done.stderr
    page = "kind: report\nname: page\nresults: {sweep: sweep, dfa: dfa, predict: predict}\n"
    done = hknob("report", spec_file(page, "page.yaml"), "-o", "page")
    assert done.returncode == 0, done.stderr
    figure = "{id: fig-size, draw: grid_map, of: sweep, with: {column: p2p_rad}, title: Size, caption: Size, alt: Size}"
    done = hknob(
        "report", spec_file(f"{page}chapters: [{{title: One, figures: [{figure}]}}]\n", "maps.yaml"), "-o", "maps"
    )
    assert done.returncode == 0, done.stderr
    assert "whose points are on no grid" in (tmp_path / "maps" / "report.html").read_text()


@pytest.mark.long
def test_what_matters_in_words_and_as_a_picture(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("sweep", spec_file(DESIGN), "-o", "out", "--plot", "--set", "grid.design.sobol=64")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    lines = done.stdout.splitlines()
    first = lines.index(next(line for line in lines if line.startswith("what matters most")))
    # Size goes as 1 / counts and 1 / rate in the law, and hardly with the hand's stiffness; rate spans 8, counts 4.
    assert [line.split()[0] for line in lines[first + 1 : first + 4]] == [
        "sample_rate_hz", "counts_per_rev", "hand.stiffness",
    ]  # fmt: skip
    assert (tmp_path / "out" / "grid.png").stat().st_size > 50_000
    summary = json.loads(hknob("sweep", spec_file(DESIGN), "-o", "small", "--json").stdout)
    assert [one["axis"] for one in summary["what_matters"]][-1] == "hand.stiffness"
    assert sum(found["cells"] for found in summary["what_matters"][0]["bins"]) == 16


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("kind", "file"), [("dfa", "dfa.png"), ("predict", "predict.png")])
def test_analyses_of_a_design_have_a_picture(kind: str, file: str, hknob, spec_file, tmp_path: Path) -> None:
    done = hknob(kind, spec_file(analysis(kind)), "-o", "out", "--plot", "--set", "grid.design.sobol=32")
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines()[1:] == []  # it may be the first to compile
    assert (tmp_path / "out" / file).stat().st_size > 50_000
