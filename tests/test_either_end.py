"""Tests of `either_end`: each worker collects all that there is, and other paths are left as they are."""

from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.either_end import TESTS, from_either_end


@pytest.mark.parametrize("args", [["tests"], [str(TESTS)]])
def test_every_other_worker_takes_all_from_its_end(args: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for worker in ("", "gw0", "gw2", "master"):
        monkeypatch.setenv("PYTEST_XDIST_WORKER", worker)
        assert from_either_end(args, ROOT) == args
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw1")
    found = [Path(one) for one in from_either_end(args, ROOT)]
    assert found == sorted(found, reverse=True)
    for file in TESTS.rglob("test_*.py"):
        assert sum(one == file or one in file.parents for one in found) == 1


@pytest.mark.parametrize("args", [["tests/cli"], ["tests", "tests/cli"], ["tests/test_layers.py"]])
def test_what_is_asked_for_is_collected_as_it_is_asked_for(args: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw1")
    assert from_either_end(args, ROOT) == args
