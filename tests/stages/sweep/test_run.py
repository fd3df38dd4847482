"""Tests of `stages.sweep.run`: some cells again and again, and when compiled code is worth its time."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import sleep
from typing import Any

import pytest

from hknob_cli.engine import compiling, jit
from hknob_cli.measure.unsampled import PEAKS
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep import cell as sweep_cell
from hknob_cli.stages.sweep import run as engines_of_sweeps
from hknob_cli.stages.sweep import run as sweep
from hknob_cli.stages.sweep.run import COMPILE_ABOVE, HEAVIER, LOADING_S, Engines, SweepStage
from hknob_cli.stages.sweep.tables import cells_table
from tests.conftest import EXPERIMENTS, SPEC, loaded, swept

FRICTION = SPEC.replace("{inertia: 1.9e-6}", "{inertia: 1.9e-6, coulomb_torque: 1.0e-4}")


@pytest.mark.parametrize("text", [SPEC, FRICTION])
def test_cells_are_found_again_with_and_without_threads(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = loaded(text.replace("[1000]", "[1000, 2000]"))
    stage = SweepStage(plan, jobs=2)
    every = list(cells_of(plan))
    whole = stage.run().cells
    for least in (0, 10**12, 0):  # trial-samples above which there are threads
        monkeypatch.setattr(sweep, "THREADS_ABOVE", least)
        assert cells_table(plan, stage.find(every)).equals(whole)
        assert cells_table(plan, stage.find(every[1:])).equals(whole.slice(1))


def test_an_undamped_motion_is_the_same_however_long_the_interpreter_may_take(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is followed through as many bounces; what the interpreter does not reach is compiled."""
    spec = EXPERIMENTS / "encoder_wall.yaml"
    found = []
    for most in (sweep_cell.MAX_EVENTS_INTERPRETED, 10, sweep_cell.MAX_EVENTS):
        monkeypatch.setattr(sweep_cell, "MAX_EVENTS_INTERPRETED", most)
        found.append(swept(spec).orbits)
    assert found[0].equals(found[1])
    assert found[0].equals(found[2])
    assert found[0].to_pylist()[0]["bounces"] == PEAKS + 1


def planned(*overrides: str, spec: Path = EXPERIMENTS / "hand_on_knob.yaml") -> SweepPlan:
    found = load(spec, overrides, kind="sweep")
    assert isinstance(found, SweepPlan)
    return found


@pytest.fixture
def nothing_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for compiled code with nothing in it yet; the file of what was interpreted, not there either."""
    monkeypatch.setenv("HKNOB_CACHE_DIR", str(tmp_path))
    folder = jit.cache_directory()
    assert folder is not None
    return folder / jit.INTERPRETED


@pytest.mark.usefixtures("nothing_kept")
def test_what_many_sweeps_had_interpreted_is_counted_together() -> None:
    engines = Engines()
    whole_s = compiling.COMPILING_S["laws"]
    before = engines.patience("laws")
    assert before.seconds == whole_s
    engines.note("laws", 0.75 * whole_s)
    assert engines.patience("laws").seconds == pytest.approx(0.25 * whole_s)
    assert not engines.is_due("laws")
    engines.note("laws", 0.75 * whole_s)
    assert engines.patience("laws") == before._replace(seconds=0.0)
    assert engines.is_due("laws")
    assert not engines.is_due("plain")


@pytest.mark.usefixtures("nothing_kept")
def test_what_earlier_runs_had_interpreted_is_counted_too() -> None:
    whole_s = compiling.COMPILING_S["laws"]
    for share in (0.75, 0.5, 0.25):
        run = Engines()
        assert run.patience("laws").seconds == pytest.approx((share + 0.25) * whole_s, abs=0.01)
        run.note("laws", 0.25 * whole_s)
        run.keep()
        run.keep()  # once is enough
    assert Engines().patience("plain").seconds == compiling.COMPILING_S["plain"]
    run = Engines()
    run.note("laws", 10.0 * whole_s)
    run.keep()
    assert Engines().patience("laws").seconds == LOADING_S


def test_runs_as_short_as_loading_compiled_code_are_not_counted(nothing_kept: Path) -> None:
    run = Engines()
    run.note("laws", LOADING_S)
    run.keep()
    assert not nothing_kept.exists()


def test_a_damaged_line_is_not_counted(nothing_kept: Path) -> None:
    jit.note_interpreted("laws", 2.5)
    with nothing_kept.open("ab") as file:
        file.write(b"laws: nan\nlaws: 9\xff.00\nlaws\nlaws: -3.00\nlaws: 1e9\ngeneral: 1.25\nlaws: 3.7")
    assert jit.interpreted_s("laws") == 2.5
    assert jit.interpreted_s("general") == 1.25


def test_where_nothing_can_be_kept_the_interpreter_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "_not_kept", lambda: "a reason")
    jit.note_interpreted("laws", 2.5)
    assert jit.interpreted_s("laws") == 0.0


@pytest.mark.usefixtures("nothing_kept")
def test_a_grid_that_is_run_again_and_again_is_compiled_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first runs are interpreted, until they have taken as long as compiling; so `make sweep` does not wait."""
    asked: list[str] = []
    monkeypatch.setattr(Engines, "compile", lambda self, group: asked.append(group))
    for takes_s in (3.5, 3.5, 3.5):
        run = Engines()
        run.compile_for({"plain": COMPILE_ABOVE * takes_s / LOADING_S})
        if not asked:
            run.note("plain", takes_s)
            run.keep()
    assert asked == ["plain"]


def test_threads_that_want_a_group_at_once_compile_it_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """And what is to be waited for is said once."""
    asked: list[str] = []
    made: list[str] = []

    def compiled(group: str) -> dict[str, Any]:
        made.append(group)
        sleep(0.05)  # so that the others come in between
        return {}

    monkeypatch.setattr(engines_of_sweeps, "waiting", lambda group: f"waits for {group}")
    monkeypatch.setattr(engines_of_sweeps, "compiled", compiled)
    engines = Engines(notify=asked.append)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(engines.compile, ["laws"] * 4))
    assert (made, asked) == (["laws"], ["waits for laws"])


def test_what_one_sweep_has_compiled_the_next_one_takes() -> None:
    engines = Engines()
    engines.compile("plain")
    short = planned("grid.sample_rate_hz=1000", "grid.counts_per_rev=1024", "starts.phases=4")
    later = SweepStage(short, jobs=1, engines=engines)
    assert later.compiled
    alone = SweepStage(short, jobs=1)
    assert alone.run().orbits.equals(later.run().orbits)
    assert not alone.compiled


@pytest.mark.parametrize(("kept", "worth_s"), [(True, LOADING_S), (False, compiling.COMPILING_S["general"])])
def test_work_is_compiled_for_where_it_takes_longer(
    kept: bool, worth_s: float, nothing_kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines_of_sweeps, "is_kept", lambda _group="plain": kept)
    asked: list[str] = []
    monkeypatch.setattr(Engines, "compile", lambda self, group: asked.append(group))
    enough = COMPILE_ABOVE / HEAVIER["general"] * worth_s / LOADING_S
    Engines().compile_for({"general": 0.99 * enough})
    assert asked == []
    Engines().compile_for({"general": 1.01 * enough})
    assert asked == ["general"]


def test_an_end_without_proof_is_the_same_however_it_is_computed() -> None:
    """The passivity controller under a strong push: repeats for long without proof, and is proven later.

    Interpreted for fewer samples than the trial has, it was called unproven.
    """
    plan = load(EXPERIMENTS / "remedies.yaml", (), kind="remedies")
    (remedy,) = (one for one in plan.remedies if one.name == "passivity controller")  # type: ignore[attr-defined]
    pushed = remedy.cases[0]._replace(axes={**remedy.cases[0].axes, "person": [1]})
    push = pushed.scene.bias._replace(torque=0.025)
    pushed = pushed._replace(scene=pushed.scene._replace(bias=push))
    engines = Engines()
    engines.compile("laws")
    ends = [SweepStage(pushed, jobs=1, engines=one).run().orbits for one in (None, engines)]
    assert ends[0].equals(ends[1])
    assert ends[0]["certified"].to_pylist() == [True]
