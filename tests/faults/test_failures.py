"""A share of the calls that fail (`failures.py`), and that the layer makes them fail, once each, in every process."""

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from pickle import dumps, loads  # themselves: what is watched is the module's
from typing import Any

import pytest

from tests.faults.failing_calls import SHORT, WAYS, Calls, Fault
from tests.faults.fault_cases import CASES

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="finds what a number of a file leads to in /proc")
FAILURES = Path(__file__).with_name("failures.py")


def fail(cases: list[str], states: int, seed: int, *more: str) -> list[dict[str, Any]]:
    """What came of so many faults of each command."""
    command = [sys.executable, FAILURES, "--only", ",".join(cases), "--states", str(states), "--seed", str(seed), *more]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_a_few_calls_that_fail() -> None:
    cases = ["sweep", "new", "verify"]
    found = fail(cases, 3, 3)
    assert [(one["case"], one["wrong"]) for one in found] == [(case, 0) for case in cases], found
    assert sum(one["faults"] for one in found) > 6


@pytest.mark.long
def test_calls_of_every_command_that_fail() -> None:
    """But for a benchmark, whose processes each load everything anew; that is run by hand."""
    cases = [name for name in CASES if name != "bench"]
    found = fail(cases, 6, 5)
    assert [(one["case"], one["wrong"]) for one in found] == [(case, 0) for case in cases], found
    assert {kind for one in found for kind in WAYS if one.get(kind)} == set(WAYS)


@pytest.mark.long
def test_a_program_that_bears_no_fault_is_found() -> None:
    """One that takes every file for written."""
    found = fail(["sweep"], 40, 3, "--careless")
    assert found[-1]["wrong"] > 0
    assert any("said it was done" in text for one in found[:-1] for text in one["wrong"])


def in_a_copy(act: Callable[[], Any], calls: Calls, fault: Fault | None) -> Any:
    """What an act gives in a copy of this process, in which that call fails."""
    read, write = os.pipe()
    calls.clear(fault)
    child = os.fork()
    if child == 0:
        try:
            calls.watch()
            try:
                found = act()
            except Exception as error:
                found = (type(error).__name__, getattr(error, "errno", None))
            os.write(write, dumps(found))
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    os.close(write)
    with os.fdopen(read, "rb") as pipe:
        return loads(pipe.read())


def write_and_read(folder: Path) -> bytes:
    """Calls of most kinds."""
    (folder / "new").mkdir()
    half = folder / "new" / "half"
    with half.open("wb") as stream:
        stream.write(b"0123456789")
        stream.flush()
        os.fsync(stream.fileno())
    half.replace(folder / "whole")
    (folder / "new").rmdir()
    assert [path.name for path in folder.iterdir()] == ["whole"]
    child = os.fork()
    if child == 0:
        (folder / "whole").stat()
        os._exit(0)
    os.waitpid(child, 0)
    return (folder / "whole").read_bytes()


def test_the_layer_counts_calls_and_fails_the_one_that_is_asked_for(tmp_path: Path) -> None:
    kinds = ("mkdir", "create", "write", "sync", "rename", "remove", "list", "fork", "open", "read")
    calls = Calls([tmp_path])

    def fresh() -> Path:
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        return folder

    folder = fresh()
    assert in_a_copy(lambda: write_and_read(folder), calls, None) == b"0123456789"
    counts = calls.counts()
    assert {kind for process, kind in counts if process == 0} == {*kinds}
    assert counts[1, "look"] == 1
    assert not calls.met
    for kind in kinds:
        for way in WAYS[kind]:
            folder = fresh()
            found = in_a_copy(lambda folder=folder: write_and_read(folder), calls, Fault(0, kind, 1, way))
            assert calls.met
            wanted = b"0123456789" if way == SHORT else ("OSError", getattr(errno, way, None))
            assert found == wanted or (way in ("EACCES", "EAGAIN") and found[1] == wanted[1]), (kind, way)
    folder = fresh()
    in_a_copy(lambda: write_and_read(folder), calls, Fault(0, "mkdir", 2, "EIO"))
    assert not calls.met


def test_a_call_elsewhere_does_not_count(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "there").write_bytes(b"1")
    calls = Calls([tmp_path / "here"])
    assert in_a_copy((tmp_path / "there").read_bytes, calls, Fault(0, "open", 1, "EIO")) == b"1"
    assert calls.counts() == {}
