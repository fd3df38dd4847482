"""What is said while the engine is compiled, and that one cell does not wait where the interpreter is done sooner."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hknob_cli.engine import compiling, jit
from hknob_cli.engine.attractors import PATIENCE
from hknob_cli.stages.sweep import run
from hknob_cli.stages.sweep.run import LOADING_S, Engines, SweepStage
from tests.conftest import loaded

# Two functions of the smallest group.
SMALL = """
from hknob_cli.engine import compiling
from hknob_cli.engine.jit import compiled

compiling.EVERY_S = -1.0
compiling.tell_compiling(print)
compiled("bounces")["hold_coefficients"](0.1, 0.2, 0.5)
compiled("bounces")["make_loop"](0.1, 0.2, 0.5, 0.1, 1.0, 0.0, 0.0)
"""
ONE_CELL = """
kind: sweep
name: one
scene:
  knob: {inertia: 1.9e-6, coulomb_torque: 2.0e-4}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
grid: {sample_rate_hz: [1000], counts_per_rev: [1024]}
"""


def said(base: Path) -> list[str]:
    env = {**os.environ, "HKNOB_CACHE_DIR": str(base)}
    done = subprocess.run([sys.executable, "-c", SMALL], env=env, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


GROUP = "friction sets"  # of the engine, that the one cell takes


def test_what_is_compiled_and_how_long_it_took_is_told_and_nothing_where_it_is_kept(tmp_path: Path) -> None:
    first = said(tmp_path)
    assert first[0] == "compiling the engine for this machine: 1 function"
    assert first[1].startswith("compiled 1 function in ")
    assert first[1].endswith(" s")
    # The second calls the first, which is compiled already, and one more.
    assert first[2].startswith("compiling the engine for this machine: ")
    assert first[-1].startswith("compiled ")
    assert said(tmp_path) == []


def test_functions_are_counted_with_all_that_they_call() -> None:
    functions = jit.compiled("general")
    every = compiling.left_to_compile(functions["general.run_trials"])
    assert compiling.left_to_compile(functions["general.follow_trial"]) < every or every <= 1
    assert every <= len(functions)


def test_one_cell_does_not_wait_for_a_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without compiled code on disk the interpreter goes on until it has taken as long as compiling would."""
    monkeypatch.setenv("HKNOB_CACHE_DIR", str(tmp_path))
    told: list[str] = []
    stage = SweepStage(loaded(ONE_CELL), jobs=1, engines=Engines(notify=told.append))
    result = stage.run()
    assert result.cells.num_rows == 1
    assert not stage.compiled
    assert told == []
    patience = stage.engines.patience(GROUP)
    assert patience.samples == int(PATIENCE * compiling.COMPILING_S[GROUP] / LOADING_S)
    assert 0.0 < patience.seconds < compiling.COMPILING_S[GROUP]


def test_work_that_takes_longer_than_compiling_is_compiled_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HKNOB_CACHE_DIR", str(tmp_path))
    asked: list[str] = []
    monkeypatch.setattr(Engines, "compile", lambda self, group: asked.append(group))
    monkeypatch.setattr(SweepStage, "_results", lambda self, some, expected: iter(()))
    for kept in (True, False):
        monkeypatch.setattr(run, "is_kept", lambda _group="plain", kept=kept: kept)
        stage = SweepStage(loaded(ONE_CELL.replace("[1000]", "{log: [500, 5000, 12]}")), jobs=1)
        assert stage.expected[GROUP] * run.HEAVIER[GROUP] > run.COMPILE_ABOVE
        stage._find(None)
    assert asked == [GROUP]


def test_an_interpreter_that_has_taken_its_time_gives_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HKNOB_CACHE_DIR", str(tmp_path))
    asked: list[str] = []
    monkeypatch.setattr(Engines, "compile", lambda self, group: asked.append(group))
    stage = SweepStage(loaded(ONE_CELL), jobs=1)
    stage.engines.note(GROUP, compiling.COMPILING_S[GROUP] + 1.0)
    with pytest.raises(Exception, match=GROUP):
        stage.run()
    assert asked == [GROUP]
