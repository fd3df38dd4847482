"""Sets of starts under a controller that take too much work: trials of some phases say what they can."""

from pathlib import Path

import pytest

from hknob_cli.engine.general.sets import law_search
from hknob_cli.stages.sweep.every_start import INCOMPLETE, SOME_PHASES
from tests.conftest import swept

SPEC = """\
kind: sweep
name: lag
scene:
  knob: {inertia: 1.9e-6, coulomb_torque: 2.0e-4}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
  controller: {kind: bounded_lag, keep: 0.15}
grid: {sample_rate_hz: 464, counts_per_rev: 256}
starts: {angle: 0.02}
"""


@pytest.mark.long
def test_sets_that_are_given_up_are_sampled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC)
    (whole,) = swept(path).cells.to_pylist()
    assert whole["complete"]
    assert whole["certified_fraction"] == pytest.approx(1.0)
    monkeypatch.setattr(law_search, "PHASES", -1)
    tables = swept(path)
    (some,) = tables.cells.to_pylist()
    assert (some["complete"], some["piece_count"]) == (False, 0)
    assert some["incomplete_reason"] == INCOMPLETE[SOME_PHASES]
    assert some["certified_fraction"] == 1.0  # of 64 phases, though the sets had no time for any
    assert some["p2p_max_rad"] <= whole["p2p_max_rad"] * (1.0 + 1e-9)
    assert all((64.0 * row["basin_fraction"]).is_integer() for row in tables.orbits.to_pylist())
