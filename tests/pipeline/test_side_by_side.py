"""Tests of `pipeline.side_by_side`: which stages are made at the same time, and what comes of those that fail."""

import os
import signal
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from hknob_cli.errors import ComputationError, Fault, SpecError
from hknob_cli.pipeline.side_by_side import SideBySide, Task
from hknob_cli.terminal import say

MEETS_S = 20.0  # how long one waits for the other before it is said not to come


def _task(run: Callable[[], str], *needs: str, missing: bool = True, alone: bool = False) -> Task:
    return Task(frozenset(needs), lambda _jobs: (True, run()), lambda: missing, alone)


def _makers(jobs: int = 2, **tasks: Task) -> tuple[SideBySide, list[str]]:
    heard: list[str] = []
    makers = SideBySide(jobs, lambda name, text: heard.append(f"{name}: {text}"))
    makers.tasks.update(tasks)
    return makers, heard


def _meet(folder: Path, own: str, other: str, *, within_s: float = MEETS_S) -> str:
    """Say that one is there, and wait for another: only both at the same time come to an end."""
    (folder / own).touch()
    end = time.monotonic() + within_s
    while not (folder / other).exists():
        if time.monotonic() > end:
            return f"{other} did not come"
        time.sleep(0.01)
    return f"{other} came"


def test_stages_that_need_nothing_of_one_another_are_made_at_the_same_time(tmp_path: Path) -> None:
    a, b = _task(partial(_meet, tmp_path, "a", "b")), _task(partial(_meet, tmp_path, "b", "a"))
    makers, heard = _makers(a=a, b=b)
    with makers:
        assert makers.make("a")
        assert makers.make("b")
    assert sorted(heard) == ["a: ", "a: b came", "b: ", "b: a came"]


def test_a_stage_waits_for_those_that_it_needs(tmp_path: Path) -> None:
    def look() -> str:
        return "there" if (tmp_path / "b").exists() else "not there"

    b = _task(lambda: time.sleep(0.2) or str((tmp_path / "b").touch()))
    makers, heard = _makers(3, a=_task(str), b=b, c=_task(look, "b"))
    with makers:
        for name in "abc":
            makers.make(name)
    assert heard[-1] == "c: there"


def test_what_is_there_is_made_only_where_it_is_asked_for(tmp_path: Path) -> None:
    there = _task(lambda: str((tmp_path / "made").touch()), missing=False)
    makers, _ = _makers(a=_task(partial(time.sleep, 0.1)), b=_task(partial(time.sleep, 0.1)), there=there)
    with makers:
        makers.make("a")
        makers.make("b")
        assert not (tmp_path / "made").exists()
        makers.make("there")
    assert (tmp_path / "made").exists()


@pytest.mark.parametrize("order", ["abc", "cab"])
def test_nothing_is_made_beside_what_wants_the_machine_for_itself(tmp_path: Path, order: str) -> None:
    def alone() -> str:
        return _meet(tmp_path, "c", "never", within_s=0.3)

    def other(name: str) -> str:
        begin = time.monotonic()
        time.sleep(0.2)
        return f"{name} {begin} {time.monotonic()}"

    def timed() -> str:
        begin = time.monotonic()
        alone()
        return f"c {begin} {time.monotonic()}"

    makers, heard = _makers(a=_task(partial(other, "a")), b=_task(partial(other, "b")), c=_task(timed, alone=True))
    with makers:
        for name in order:
            makers.make(name)
    spans = {text.split()[1]: [float(one) for one in text.split()[2:]] for text in heard if len(text.split()) == 4}
    begin, end = spans.pop("c")
    assert len(spans) == 2
    assert all(last <= begin or first >= end for first, last in spans.values())


def test_a_stage_that_nothing_can_be_made_beside_is_made_here() -> None:
    makers, heard = _makers(a=_task(lambda: str(os.getpid())))
    with makers:
        makers.make("a")
    assert heard[-1] == f"a: {os.getpid()}"


def test_one_process_makes_all_of_it_here() -> None:
    makers, heard = _makers(1, a=_task(lambda: str(os.getpid())), b=_task(lambda: str(os.getpid())))
    with makers:
        makers.make("a")
        makers.make("b")
    assert heard[1::2] == [f"a: {os.getpid()}", f"b: {os.getpid()}"]


def test_faults_are_raised_where_the_stage_is_asked_for_and_others_go_on() -> None:
    def fail() -> str:
        raise SpecError([Fault("spec.yaml", 3, 5, "grid", "must be there")])

    def break_down() -> str:
        raise ZeroDivisionError("no fault of a user's")

    makers, heard = _makers(a=_task(fail), b=_task(break_down), c=_task(lambda: "made"), d=_task(str, "a"))
    with makers:
        assert makers.make("c")
        with pytest.raises(SpecError, match="must be there") as told:
            makers.make("a")
        with pytest.raises(ZeroDivisionError) as broken:
            makers.make("b")
    assert told.value.faults == (Fault("spec.yaml", 3, 5, "grid", "must be there"),)
    assert "in break_down" in "".join(broken.value.__notes__)  # where it was, in the other process
    assert "c: made" in heard
    assert not any(text.startswith("d:") for text in heard)  # what it needs was never made


def test_an_error_that_cannot_be_told_to_another_process_is_told_in_words() -> None:
    class OwnError(Exception):
        def __init__(self, one: str, two: str) -> None:
            super().__init__(f"{one} and {two}")

    def fail() -> str:
        raise OwnError("this", "that")

    makers, _ = _makers(a=_task(fail), b=_task(str))
    with makers, pytest.raises(ComputationError, match="OwnError: this and that"):
        makers.make("a")


def _here_only(folder: Path, parent: int, end: Callable[[], object]) -> str:
    """Comes to an end of its own in another process than this."""
    (folder / "tried").touch()
    if os.getpid() != parent:
        end()
    return "made here"


def _out_of_memory() -> None:
    raise MemoryError


@pytest.mark.parametrize("end", [_out_of_memory, lambda: os.kill(os.getpid(), signal.SIGKILL)])
def test_what_memory_does_not_suffice_for_beside_others_is_made_again_alone(tmp_path: Path, end) -> None:
    makers, heard = _makers(a=_task(partial(_here_only, tmp_path, os.getpid(), end)), b=_task(lambda: "made"))
    with makers:
        assert makers.make("b")
        assert makers.make("a")
    assert "a: made here" in heard
    assert "b: made" in heard


def test_an_interrupted_stage_keeps_what_it_has(tmp_path: Path) -> None:
    def work() -> str:
        try:
            _meet(tmp_path, "begun", "never")
        finally:
            (tmp_path / "kept").touch()
        return ""

    makers, _ = _makers(a=_task(work), b=_task(partial(_meet, tmp_path, "b", "begun")))
    with makers:
        makers.make("b")  # and it is left while the other is at work
    assert (tmp_path / "kept").exists()


def test_what_a_stage_has_to_say_is_said_here(capsys: pytest.CaptureFixture[str]) -> None:
    makers, _ = _makers(a=_task(lambda: str(say("a word"))), b=_task(lambda: str(say("another"))))
    with makers:
        makers.make("a")
        makers.make("b")
    assert sorted(capsys.readouterr().err.splitlines()) == ["a word", "another"]


def test_processes_end_with_it() -> None:
    makers, heard = _makers(a=_task(lambda: str(os.getpid())), b=_task(lambda: str(os.getpid())))
    with makers:
        makers.make("a")
        makers.make("b")
    others = {int(text.split()[1]) for text in heard if text.split()[1:]}
    assert os.getpid() not in others
    for one in others:
        with pytest.raises(ProcessLookupError):
            os.kill(one, 0)
