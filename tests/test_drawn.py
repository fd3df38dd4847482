"""What `make long` draws: the same in every process, each case in its turn, and never without a word about it."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import ROOT
from tests.drawn import Draw, turns

LIKE = """
import pytest
pytestmark = [pytest.mark.long, pytest.mark.drawn({drawn})]
@pytest.mark.parametrize("k", range(20))
def test_like(k): pass
"""
WORDS = [f"word {k}" for k in range(60)]


class Marked:
    """As much of a collected test as is drawn by."""

    def __init__(self, number: int, *marks: pytest.Mark) -> None:
        self.number, self.marks = number, {mark.name: mark for mark in marks}

    def get_closest_marker(self, name: str) -> pytest.Mark | None:
        return self.marks.get(name)


def chosen(by: str, *marks: pytest.MarkDecorator) -> tuple[set[int], set[int]]:
    """Numbers of a hundred cases: those to run, and those left out."""
    items: list[Any] = [Marked(k, *(one.mark for one in marks)) for k in range(100)]
    found: tuple[list[Any], list[Any]] = Draw(by).choose(items)
    run, out = ({one.number for one in part} for part in found)
    return run, out


@pytest.mark.parametrize(("n", "k"), [(7, 1), (3, 1), (5, 2)])
def test_each_stretch_has_its_share_and_each_case_its_turn(n: int, k: int) -> None:
    assert {turns(by, n) for by in WORDS} == set(range(n))
    met: set[int] = set()
    for by in WORDS:
        run, out = chosen(by, pytest.mark.long, pytest.mark.drawn(n, k))
        assert run | out == set(range(100))
        assert all(len(run & set(range(first, first + n))) == k for first in range(100 - n))
        met |= run
    assert met == set(range(100))


def test_what_is_not_long_or_not_to_be_drawn_runs() -> None:
    for marks in ((), (pytest.mark.long,), (pytest.mark.drawn(7),)):
        assert chosen("word", *marks) == (set(range(100)), set())


@pytest.mark.one_in(2)
@pytest.mark.parametrize("workers", [(), ("-n", "2", "--dist", "loadfile")], ids=["alone", "workers"])
def test_it_is_said_what_was_drawn(tmp_path: Path, workers: tuple[str, ...]) -> None:
    for k in range(3):
        (tmp_path / f"test_{k}.py").write_text(LIKE.format(drawn="4"))
    (tmp_path / "conftest.py").write_text("from tests.conftest import pytest_addoption, pytest_configure\n")
    options = ["-o", "addopts=", "-o", "testpaths=", "--rootdir", tmp_path, "-c", ROOT / "pyproject.toml"]
    options += ["-p", "no:cacheprovider", "-m", "long", *workers, tmp_path]

    def told(*more: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *options, *more], cwd=ROOT, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    some = told("--draw", "abc")
    assert "drawn by abc: 15 of 60 long cases" in some
    assert "15 passed" in some
    every = told()
    assert "60 passed" in every
    assert "drawn by" not in every
