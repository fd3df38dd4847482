"""Links planted in a results folder: nothing outside it is written, emptied or removed through them."""

import os
from pathlib import Path

import pytest

from hknob_cli.errors import RefusedError
from hknob_cli.results.files import Staging, create, make_folder, refuse_link
from tests.conftest import SPEC

PRECIOUS = b"what is not of these results"
REPORT = """\
kind: report
name: page
results: {small: small}
"""


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    path = tmp_path / "elsewhere" / "precious"
    path.parent.mkdir()
    path.write_bytes(PRECIOUS)
    return path


def untouched(precious: Path) -> bool:
    return precious.read_bytes() == PRECIOUS and [path.name for path in precious.parent.iterdir()] == ["precious"]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [".cells.parquet.partial", ".orbits.parquet.partial", ".grid.png.partial"])
@pytest.mark.parametrize("dangling", [False, True])
def test_a_half_written_file_is_no_link(name: str, dangling: bool, hknob, spec_file, tmp_path: Path, precious) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / name).symlink_to(precious.with_name("new") if dangling else precious)
    done = hknob("sweep", spec_file(), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert untouched(precious)
    assert sorted(path.name for path in out.iterdir() if not path.name.startswith(".")) == [
        "cells.parquet", "grid.png", "orbits.parquet",
    ]  # fmt: skip


def test_the_lock_is_no_link(hknob, spec_file, tmp_path: Path, precious) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ".hknob.lock").symlink_to(precious)
    done = hknob("sweep", spec_file(), "-o", "out")
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert untouched(precious)


def test_a_result_that_is_a_link_is_replaced_or_refused(hknob, spec_file, tmp_path: Path, precious) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "cells.parquet").symlink_to(precious)
    done = hknob("sweep", spec_file(), "-o", "out")
    assert done.returncode == 3, done.stderr
    assert untouched(precious)


def test_figures_are_not_drawn_through_a_link(hknob, spec_file, tmp_path: Path, precious) -> None:
    hknob("sweep", spec_file(SPEC.replace("[1000]", "[1000, 2000]")), "-o", "small")
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "figures").symlink_to(precious.parent)
    done = hknob("report", spec_file(REPORT, "page.yaml"), "-o", "page")
    assert done.returncode == 3, done.stderr
    assert "figures: is a link, which nothing is written through" in done.stderr
    assert untouched(precious)


def test_a_pipeline_follows_no_link(hknob, spec_file, tmp_path: Path, precious) -> None:
    spec_file()
    pipeline = spec_file("kind: pipeline\nname: all\nstages: {small: {spec: spec.yaml}}\n", "all.yaml")
    out = tmp_path / "out"
    out.mkdir()
    for name in ("pytask.lock", "pytask.lock.journal", "pytask.lock.tmp", ".pytask.toml", ".pipeline.json.partial"):
        (out / name).symlink_to(precious)
    done = hknob("run", pipeline, "-o", "out")
    assert done.returncode == 0, done.stderr
    assert untouched(precious)
    assert "up to date" in hknob("run", pipeline, "-o", "out").stdout
    other = tmp_path / "other"
    other.mkdir()
    (other / "small").symlink_to(precious.parent)
    done = hknob("run", pipeline, "-o", "other")
    assert done.returncode == 3, done.stderr
    assert "small: is a link" in done.stderr
    assert untouched(precious)


def test_a_campaign_follows_no_link(hknob, spec_file, tmp_path: Path, precious) -> None:
    text = "kind: hw-run\nname: c\ngrid: {sample_rate_hz: [1000], counts_per_rev: [512]}\ntrial: {buzz: [0.1, 0.2]}\n"
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "recording").symlink_to(precious.parent)
    done = hknob("hw-run", spec_file(text), "-o", "out")
    assert done.returncode == 3, done.stderr
    assert untouched(precious)


def test_pieces_of_a_long_sweep_follow_no_link(tmp_path: Path, precious) -> None:
    staging = Staging(tmp_path, b"stamp")
    staging.folder.symlink_to(precious.parent)
    with pytest.raises(RefusedError, match="is a link"):
        staging.begin()
    staging.folder.unlink()
    staging.begin()
    (staging.folder / "0-3.half").symlink_to(precious)
    staging.put(0, 3, b"data")
    assert staging.get(0, 3) == b"data"
    assert untouched(precious)


def test_new_files_are_new(tmp_path: Path, precious) -> None:
    path = tmp_path / "new"
    os.link(precious, path)  # a second name of the same file
    with create(path) as stream:
        stream.write(b"new")
    assert path.read_bytes() == b"new"
    assert untouched(precious)
    make_folder(tmp_path / "folder")
    make_folder(tmp_path / "folder")
    refuse_link(tmp_path / "nothing")
    (tmp_path / "link").symlink_to(precious.parent)
    with pytest.raises(RefusedError, match="link: is a link, which nothing is written through; remove it"):
        make_folder(tmp_path / "link")
