"""The disk after a crash: what is synced is there, and of the rest whatever may be."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.faults.disk import CONTENTS, NAMES, Change, Crash, Disk, after

# A file beside its place, written and renamed; `half` stands for its name before.
OLD = {"a": b"old"}


def put(*, synced: bool, named: bool) -> list[Change]:
    """A new file takes the place of another, as far as that is made to last."""
    disk = Disk(dict(OLD))
    number = disk.make(0, "half", is_folder=False)
    disk.take(Change("write", number, data=b"new" * 500))
    if synced:
        disk.take(Change("sync", number))
    disk.take(Change("move", number, 0, "a", (0, "half")))
    if named:
        disk.take(Change("sync", 0))
    assert disk.tree() == {"a": b"new" * 500}
    return disk.changes


def every(changes: list[Change]) -> set[bytes | None]:
    """Contents that the file may have after a crash behind all changes."""
    crashes = [Crash(len(changes), names, contents, s) for names in NAMES for contents in CONTENTS for s in range(20)]
    return {after(dict(OLD), changes, crash).get("a") for crash in crashes}


def test_what_is_synced_before_and_after_is_there() -> None:
    assert every(put(synced=True, named=True)) == {b"new" * 500}


def test_a_name_that_is_not_synced_is_as_before_or_as_after() -> None:
    assert every(put(synced=True, named=False)) == {b"old", b"new" * 500}


def test_a_name_may_be_there_before_what_it_names() -> None:
    found = every(put(synced=False, named=True))
    assert {b"", b"new" * 500, bytes(1500)} < found
    assert b"old" not in found
    assert len(found) > 20


def test_what_is_in_a_folder_goes_with_it() -> None:
    disk = Disk({})
    folder = disk.make(0, "folder", is_folder=True)
    number = disk.make(folder, "file", is_folder=False)
    disk.take(Change("write", number, data=b"x"))
    disk.take(Change("sync", number))
    disk.take(Change("sync", folder))
    end = len(disk.changes)
    assert after({}, disk.changes, Crash(end, "none", "none")) == {}
    assert after({}, disk.changes, Crash(end, "all", "none")) == {"folder": None, "folder/file": b"x"}
    disk.take(Change("sync", 0))
    assert after({}, disk.changes, Crash(end + 1, "none", "none")) == {"folder": None, "folder/file": b"x"}
    disk.take(Change("move", folder, 0, "other", (0, "folder")))
    assert after({}, disk.changes, Crash(end + 2, "all", "all")) == {"other": None, "other/file": b"x"}


def test_of_changes_in_order_the_first_are_there() -> None:
    disk = Disk({})
    for name in "abcdef":
        disk.make(0, name, is_folder=False)
    found = {"".join(after({}, disk.changes, Crash(6, "first", "all", seed))) for seed in range(100)}
    assert found == {"abcdef"[:length] for length in range(7)}
    assert len({"".join(after({}, disk.changes, Crash(6, "some", "all", seed))) for seed in range(300)}) > 40


WRITES = """
import os, shutil, sys
from pathlib import Path
from tests.faults.disk import Crash, after
from tests.faults.recorder import Recorder, tree_of
root = Path(sys.argv[1])
first = tree_of(root)
recorder = Recorder(root)
recorder.watch()
(root / "new" / "deep").mkdir(parents=True)
with (root / "new" / "file").open("xb") as stream:
    stream.write(b"some ")
    stream.write(b"bytes")
with (root / "new" / "file").open("ab", buffering=0) as stream:
    stream.write(b" more")
    os.fsync(stream.fileno())
with (root / "new" / "file").open("rb+") as stream:
    stream.truncate(7)
    stream.seek(3)
    stream.write(b"X")
(root / "new" / "text").write_text("words")
(root / "new" / "text").write_text("other words")
(root / "new").replace(root / "moved")
os.close(os.open(root / "moved" / "empty", os.O_CREAT | os.O_RDWR))
shutil.rmtree(root / "there")
os.chdir(root)
Path("moved/text").unlink()
end = recorder.disk.changes
assert recorder.disk.tree() == tree_of(root) == after(first, end, Crash(len(end), "all", "all")), end
assert (root / "moved" / "file").read_bytes() == b"somX by"
least = after(first, end, Crash(len(end), "none", "none"))
assert least == first, least
print(len(end))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="finds what a number of a file leads to in /proc")
def test_all_ways_of_writing_are_written_down(tmp_path: Path) -> None:
    (tmp_path / "root" / "there" / "below").mkdir(parents=True)
    (tmp_path / "root" / "there" / "below" / "file").write_text("old")
    done = subprocess.run(
        [sys.executable, "-c", WRITES, tmp_path / "root"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) == 18
