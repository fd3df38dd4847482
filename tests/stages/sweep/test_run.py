"""Some cells of a sweep, asked for again and again."""

import pytest

from hknob_cli.measure.unsampled import PEAKS
from hknob_cli.specs.cells import cells_of
from hknob_cli.stages.sweep import cell as sweep_cell
from hknob_cli.stages.sweep import run as sweep
from hknob_cli.stages.sweep.run import SweepStage
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
