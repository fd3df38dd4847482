"""Tests of `compiled_first`: the shares are of different groups, and leave out those that compile in a moment."""

import pytest

from hknob_cli.engine.compiling import COMPILING_S
from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.plain_chunk import chunk_group
from hknob_cli.stages.sweep.run import SweepStage
from tests import compiled_first
from tests.conftest import EXPERIMENTS

GRID = EXPERIMENTS / "hand_on_knob.yaml"


def groups_of(share: tuple[tuple[str, ...], ...]) -> set[str]:
    found = set()
    for overrides in share:
        stage = SweepStage(load(GRID, (*compiled_first.CELL, *overrides), kind="sweep"))  # type: ignore[arg-type]
        found |= {*stage.expected, *([chunk_group(stage.plan)] if stage.plain else [])}
    return found


SETS = {"general sets", "friction sets"}  # which quick tests do not take


def test_each_share_has_groups_of_its_own() -> None:
    one, other = map(groups_of, compiled_first.SHARES)
    assert one & other <= {"sets"}  # of which one takes a box, the other its cells
    slow = {name for name, seconds in COMPILING_S.items() if seconds > 5.0}
    assert slow - SETS - {"friction arcs", "cogging sets"} <= one | other
    assert not SETS & (one | other)


def test_long_tests_have_all_sets() -> None:
    one, other = map(groups_of, compiled_first.MORE)
    assert one & other == {"friction sets"}  # a part of it, for a law
    assert one | other >= SETS


def test_where_all_is_compiled_nothing_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled_first, "is_kept", lambda _group: True)
    monkeypatch.setattr(SweepStage, "run", None)
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw1")
    compiled_first.compile_share(GRID, long=True)


@pytest.mark.parametrize("worker", ["gw7", "", "master"])
def test_further_workers_and_single_processes_wait_for_nothing(worker: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled_first, "is_kept", lambda _group: False)
    monkeypatch.setattr(SweepStage, "run", None)
    monkeypatch.setenv("PYTEST_XDIST_WORKER", worker)
    compiled_first.compile_share(GRID, long=True)
