"""Work that is silent for a while says how far it is, and how to limit it; not while something else is told."""

import time
from collections.abc import Callable

import pytest

from hknob_cli import terminal
from hknob_cli.terminal import LINE_EVERY, SILENT, progress_bar, say


class Clock:
    """Seconds that a test sets."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def lines(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[[int], list[str]]:
    """What was said since the last time, after waiting for so many lines."""
    monkeypatch.setattr(terminal, "LOOK_EVERY", 0.005)

    def read(count: int) -> list[str]:
        found, until = "", time.monotonic() + (20.0 if count else 0.1)
        while found.count("\n") < max(count, 1) and time.monotonic() < until:
            time.sleep(0.01)
            found += capsys.readouterr().err
        return found.splitlines()

    return read


def test_how_far_it_is_and_once_the_hint(lines) -> None:
    clock = Clock()
    with progress_bar(5, show=True, long=False, name="mine", hint="limit it", clock=clock) as progress:
        clock.now += SILENT - 1.0
        assert lines(0) == []
        clock.now += 2.0
        assert lines(1) == ["mine: 0 of 5 cells, 16 s"]
        progress(2, 5)
        clock.now += LINE_EVERY + 1.0
        assert lines(1) == ["mine: 2 of 5 cells, 47 s"]
        clock.now += LINE_EVERY + 1.0
        assert lines(2) == ["mine: 2 of 5 cells, 78 s", "limit it"]
        clock.now += LINE_EVERY + 1.0
        assert lines(1) == ["mine: 2 of 5 cells, 109 s"]
    clock.now += 1000.0
    assert lines(0) == []


def test_another_word_is_enough(lines) -> None:
    clock = Clock()
    with progress_bar(0, show=True, what="recordings", clock=clock):
        clock.now += SILENT - 1.0
        say("compiling")
        assert lines(1) == ["compiling"]
        clock.now += 2.0
        assert lines(0) == []
        clock.now += SILENT
        assert lines(1) == ["0 recordings, 31 s"]


def test_nothing_if_it_is_to_be_quiet(lines) -> None:
    clock = Clock()
    with progress_bar(5, show=False, clock=clock):
        clock.now += 1000.0
        assert lines(0) == []
