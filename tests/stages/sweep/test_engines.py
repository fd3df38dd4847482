"""When compiled code is worth its time, over several sweeps of one command, and that no result depends on it."""

from pathlib import Path

import pytest

from hknob_cli.engine import compiling, jit
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.engines import COMPILE_ABOVE, HEAVIER, LOADING_S, Engines
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import EXPERIMENTS


def planned(*overrides: str, spec: Path = EXPERIMENTS / "hand_on_knob.yaml") -> SweepPlan:
    found = load(spec, overrides, kind="sweep")
    assert isinstance(found, SweepPlan)
    return found


def test_what_many_sweeps_had_interpreted_is_counted_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "is_kept", lambda _group="plain": False)
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
    kept: bool, worth_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jit, "is_kept", lambda _group="plain": kept)
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
