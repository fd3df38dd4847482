"""The mutation tool: what it changes, that its list of accepted changes fits the source, and some of its campaign."""

import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.engine import jit, linking
from tests.conftest import ROOT
from tests.mutation import sample, whole
from tests.mutation.accepted import KINDS
from tests.mutation.campaign import forget, nothing_compiled, stopped_after
from tests.mutation.mutate import mutants
from tests.mutation.table import WATCHED, path_of, watchers_of

SOURCE = '''\
"""A file."""
MARGIN = 0.5
COUNT = 3


def near(a, b, list):
    """Docstring 1.0."""
    for k in range(7):
        if a < b and not list[k + 1] == 2:
            return max(abs(a), 4.0), 0.0
    return False


class Ball:
    """A class."""

    def holds(self, x):
        """Docstring 1.0."""
        return x < self.radius

    @property
    def size(self):
        return 2.0
'''
CHANGES = {
    "MARGIN": {"0.5 => 0.25", "0.5 => 1.0"},
    "near": {
        "a < b and (not list[k + 1] == 2) => a < b or not list[k + 1] == 2",
        "a < b and (not list[k + 1] == 2) => not list[k + 1] == 2",
        "a < b and (not list[k + 1] == 2) => a < b",
        "a < b => a <= b",
        "a < b => a >= b",
        "not list[k + 1] == 2 => list[k + 1] == 2",
        "list[k + 1] == 2 => list[k + 1] != 2",
        "list[k + 1] == 2 => list[k + 1] == 1",
        "list[k + 1] == 2 => list[k + 1] == 3",
        "max(abs(a), 4.0) => min(abs(a), 4.0)",
        "max(abs(a), 4.0) => 4.0",
        "max(abs(a), 4.0) => abs(a)",
        "abs(a) => a",
        "max(abs(a), 4.0) => max(abs(a), 2.0)",
        "max(abs(a), 4.0) => max(abs(a), 8.0)",
        "False => True",
    },
    "Ball.holds": {"x < self.radius => x <= self.radius", "x < self.radius => x >= self.radius"},
}


def test_every_comparison_coefficient_and_condition_is_changed(tmp_path: Path) -> None:
    """And neither names, nor indices, nor lengths of loops, nor what fills a tuple."""
    path = tmp_path / "near.py"
    path.write_text(SOURCE)
    found: dict[str, set[str]] = {}
    for one in mutants(path):
        found.setdefault(one.name, set()).add(one.change)
        assert one.value() if one.function is None else one.code().co_name in ("near", "holds")
    assert found == CHANGES


def test_a_changed_function_does_what_the_change_says(tmp_path: Path) -> None:
    path = tmp_path / "near.py"
    path.write_text(SOURCE)
    names: dict = {}
    exec(compile(SOURCE, str(path), "exec"), names)
    near, before = names["near"], names["near"].__code__
    assert near(1.0, 1.0, [0] * 9) is False
    near.__code__ = next(one for one in mutants(path) if one.change == "a < b => a <= b").code()
    assert near(1.0, 1.0, [0] * 9) == (4.0, 0.0)
    near.__code__ = before
    assert near(1.0, 1.0, [0] * 9) is False


def test_accepted_changes_are_changes_of_the_source_and_have_a_reason() -> None:
    """A list that has fallen behind would let anything through that looks alike."""
    listed = tomllib.loads((ROOT / "tests/mutation/accepted.toml").read_text())
    assert all(path_of(name).exists() for name in listed)
    for name, entries in listed.items():
        functions = {entry["function"] for entry in entries}
        known = [(one.name, one.text, one.change) for one in mutants(path_of(name), functions)]
        for entry in entries:
            assert entry["kind"] in KINDS
            assert len(entry["reason"]) > 20
            for change in entry["changes"]:
                assert any(
                    (entry["function"], change) == (function, found) and entry.get("line", text) == text
                    for function, text, found in known
                ), f"{name}, {entry['function']}: {change}"


def test_every_watched_file_and_its_tests_are_there() -> None:
    for name in WATCHED:
        assert (path_of(name)).exists()
        assert all(test.exists() for test in watchers_of(path_of(name)))


def test_changed_code_is_not_compiled_and_so_not_kept() -> None:
    """What is kept goes by the sources' digest: a later run would take a changed function for theirs."""
    try:
        with nothing_compiled():
            for group in ("plain", "laws"):
                assert not jit.is_kept(group)
                with pytest.raises(pytest.skip.Exception, match="not changed"):
                    jit.compiled(group)
    finally:
        jit.compiled.cache_clear()


def test_compiled_code_is_of_one_kind_whatever_is_forgotten() -> None:
    """Parts of another kind are not linked into an entry: it would call what is not there."""
    before = linking.kinds()
    forget()
    assert linking.kinds() is before


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "function"),
    [
        ("rest.py", "monotone"),
        ("certificate.py", "distance"),
        ("certificate.py", "step_error"),
        ("certificate.py", "growth"),
        ("sets/ball.py", "captor"),
        ("sets/polygon.py", "clip"),
        ("sets/polygon.py", "keep"),
        ("general/standstill.py", "stays_held"),
    ],
)
def test_no_change_of_a_proof_goes_unseen(name: str, function: str) -> None:
    """The whole campaign is run by hand."""
    command = [sys.executable, "tests/mutation/campaign.py", name, "--function", function]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 survived" in done.stdout


def test_a_compiler_is_let_end_and_what_comes_behind_it_is_stopped() -> None:
    """An exception in a function that LLVM has called ends the process."""

    def spend(seconds: float) -> None:
        end = time.process_time() + seconds
        while time.process_time() < end:
            pass

    compiler: dict[str, Any] = {}
    exec(compile("def call(function):\n    function()\n", "/lib/llvmlite/binding/ffi.py", "exec"), compiler)
    done = []
    with stopped_after(0.01):
        compiler["call"](lambda: done.append(spend(0.3)))
        done.append(spend(60.0))
    assert len(done) == 1


def test_rows_of_groups_that_were_not_judged_stay_and_no_others_come(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither those of the first table nor of files that were tried whole, which have columns of their own."""
    page = tmp_path / "scores.md"
    row, first, file = "| specs | 1000 | 9 |", "| specs | 4000 | 1 |", "| `rest.py` | 5 |"
    page.write_text(f"{first}\n\n{sample.NEXT}\n\n| group | x |\n|---|\n{row}\n\n{whole.HEAD}{file}\n")
    monkeypatch.setattr(sample, "SCORES", page)
    monkeypatch.setattr(sample, "FOLDER", tmp_path)
    told = sample.next_ones(1)
    assert [line for line in told if line.startswith("| ")][1:] == [row]
    assert told[0] == sample.NEXT
