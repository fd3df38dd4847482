"""What stands where a spread sweep writes, and is not what it should be: mended, or refused, never followed or lost."""

import os
import shutil
import stat
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.faults.spread_runs import SLOW, SWEEP, finish, left, pieces, run, start, wait_until

AWAY = "not written by hknob; move it away, or choose another --out"
Sweep = tuple[Path, Path]


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    """The spec, and the folder of a run."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "spec.yaml").write_text(SWEEP)
    assert run(folder / "spec.yaml", folder / "out") == (0, "")
    return folder / "spec.yaml", folder / "out"


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A folder of somebody else, with things in it whose names are like ours."""
    folder = tmp_path / "elsewhere"
    (folder / "cells").mkdir(parents=True)
    for name in ("0-2.piece", "0-2.half", "part-000000.parquet", "note.txt", "cells/part-000000.parquet"):
        (folder / name).write_text("mine")
    return folder


@pytest.fixture(scope="module")
def half_done(sweep: Sweep, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was killed half way."""
    out = tmp_path_factory.mktemp("half") / "out"
    process = start(sweep[0], out, fault=SLOW)
    wait_until(lambda: len(list(out.rglob("part-*"))) >= 2 and len(list(out.rglob("*.piece"))) >= 1, "parts are there")
    process.kill()
    finish(process)
    assert pieces(out) >= 3
    return out


def staging(out: Path) -> Path:
    return next(out.glob(".hknob.partial-*"))


def link(path: Path, target: Path) -> None:
    """A link in place of what is there."""
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    path.symlink_to(target)


def a_file(path: Path, _target: Path) -> None:
    shutil.rmtree(path)
    path.write_text("mine")


PLANTED: dict[str, Callable[[Path, Path], None]] = {
    "the folder is a link": lambda out, other: link(staging(out), other),
    "the folder is a file": lambda out, other: a_file(staging(out), other),
    "cells are a link": lambda out, other: link(staging(out) / "cells", other),
    "orbits are a file": lambda out, other: a_file(staging(out) / "orbits", other),
    "a piece is a link": lambda out, other: link(staging(out) / "20-22.piece", other / "0-2.piece"),
    "a piece is a folder": lambda out, _: (staging(out) / "20-22.piece" / "mine").mkdir(parents=True),
    "a piece is a pipe": lambda out, _: os.mkfifo(staging(out) / "20-22.piece"),
    "what was set aside is a link": lambda out, other: link(out / ".cells.parquet.old", other),
    "what was set aside is not ours": lambda out, other: shutil.copytree(other, out / ".orbits.parquet.old") and None,
    "results are a link": lambda out, other: link(out / "cells.parquet", other),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("what", PLANTED)
def test_what_is_planted_is_refused_and_never_followed(sweep, half_done, elsewhere, tmp_path: Path, what: str) -> None:
    out = tmp_path / "out"
    shutil.copytree(half_done, out)
    PLANTED[what](out, elsewhere)
    theirs, before = left(elsewhere), {path: path.lstat().st_mode for path in out.rglob("*")}
    for more in ((), ("--force",)):
        code, errors = run(sweep[0], out, "-q", *more)
        if code == 0:  # begun afresh, without what was planted in the folder of the run before
            assert more == ("--force",)
            assert staged_away(what)
            assert left(out) == left(sweep[1])
            break
        assert (code, errors.count("\n")) == (3, 1), errors
        assert "choose another --out" in errors
        assert {path: path.lstat().st_mode for path in out.rglob("*")} == before
    assert left(elsewhere) == theirs


def staged_away(what: str) -> bool:
    """Whether it stood inside the folder that --force removes."""
    return what.startswith(("cells", "orbits", "a piece"))


def test_links_of_other_runs_are_left_alone(sweep, elsewhere, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / ".hknob.partial-0123456789abcdef").symlink_to(elsewhere)
    theirs = left(elsewhere)
    assert run(sweep[0], out, "-q") == (0, "")
    assert left(elsewhere) == theirs


def torn(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


TORN: dict[str, Callable[[Path], None]] = {
    "a torn part": lambda out: torn(out / "cells.parquet" / "part-000002.parquet"),
    "the first part torn": lambda out: torn(out / "orbits.parquet" / "part-000000.parquet"),
    "an empty part": lambda out: (out / "cells.parquet" / "part-000005.parquet").write_bytes(b"") and None,
    "a missing part": lambda out: (out / "cells.parquet" / "part-000002.parquet").unlink(),
    "a missing last part": lambda out: (out / "orbits.parquet" / "part-000005.parquet").unlink(),
    "two parts exchanged": lambda out: exchange(out / "cells.parquet"),
    "no orbits": lambda out: shutil.rmtree(out / "orbits.parquet"),
}


def exchange(folder: Path) -> None:
    one, other = (folder / f"part-00000{number}.parquet" for number in (1, 2))
    content = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(content)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("what", TORN)
def test_damaged_parts_are_computed_again_and_others_kept(sweep, tmp_path: Path, what: str) -> None:
    out = tmp_path / "out"
    shutil.copytree(sweep[1], out)
    TORN[what](out)
    code, errors = run(sweep[0], out)
    assert code == 0, errors
    if what != "no orbits":
        *damaged, kept = errors.splitlines()
        assert kept in {f"{count} of 24 cells are there from an earlier run" for count in (16, 20)}
        assert [line for line in damaged if "is not as it was written" not in line] == []
    assert left(out) == left(sweep[1])


def foreign(path: Path) -> None:
    pq.write_table(pa.table({"x": [1]}), path)


FOREIGN: dict[str, Callable[[Path], None]] = {
    "a note": lambda folder: (folder / "note.txt").write_text("mine") and None,
    "a table": lambda folder: foreign(folder / "mine.parquet"),
    "a table with the name of a part": lambda folder: foreign(folder / "part-000009.parquet"),
    "a table in place of a part": lambda folder: foreign(folder / "part-000002.parquet"),
    "a folder": lambda folder: (folder / "part-000009.parquet").mkdir(),
    "a link": lambda folder: (folder / "part-000009.parquet").symlink_to("part-000000.parquet"),
    "a pipe": lambda folder: os.mkfifo(folder / "part-000009.parquet"),
}


@pytest.mark.parametrize("what", FOREIGN)
def test_what_is_not_ours_in_a_folder_of_parts_is_kept(sweep, tmp_path: Path, what: str) -> None:
    out = tmp_path / "out"
    shutil.copytree(sweep[1], out)
    FOREIGN[what](out / "cells.parquet")
    before = {path: (path.lstat().st_mode, path.lstat().st_size) for path in out.rglob("*")}
    code, errors = run(sweep[0], out, "-q", "--force")
    assert (code, errors) == (3, f"{out / 'cells.parquet'}: {AWAY}\n")
    assert {path: (path.lstat().st_mode, path.lstat().st_size) for path in out.rglob("*")} == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written(sweep, half_done, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(half_done, out)
    staging(out).chmod(stat.S_IRUSR | stat.S_IXUSR)
    code, errors = run(sweep[0], out, "-q")
    assert (code, errors.count("\n")) == (1, 1)
    assert "cannot be written: Permission denied; what is finished is kept, run the same command again" in errors
    staging(out).chmod(stat.S_IRWXU)
    assert run(sweep[0], out, "-q") == (0, "")
    assert left(out) == left(sweep[1])
