"""The sizes and frequencies of a cell are of what cycles in it: rest is a share, not a cycle of size 0."""

from math import isnan, nan
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.orbit import OrbitMeasures, at_rest
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.cell import CellFinder, CellResult
from hknob_cli.stages.sweep.plain_chunk import GROUP, plain_chunk
from hknob_cli.stages.sweep.tables import cells_table, in_columns
from tests.conftest import EXPERIMENTS, loaded

PUSHED = ("grid.sample_rate_hz=455", "grid.counts_per_rev=256", "scene.bias.torque=0.007")


@pytest.mark.parametrize("way", ["one by one", "all at once"])
def test_a_cell_that_also_rests_has_the_size_and_pitch_of_its_cycles(way: str) -> None:
    plan = load(EXPERIMENTS / "hand_on_knob.yaml", PUSHED)
    if way == "one by one":
        results = [CellFinder({}).find(plan, cell) for cell in cells_of(plan)]
        cells = cells_table(plan, results)
        assert sorted(one.p2p_rad for one in results[0].measures) == pytest.approx([0.0, 0.0574, 0.0873], abs=5e-5)
    else:
        cells = plain_chunk(plan, cells_of(plan).columns(0, 1), compiled(GROUP)).cells
    cell = cells.to_pylist()[0]
    # Of 64 phases 32 reach the orbit of 57.4 mrad and 56.9 Hz, 8 that of 87.3 mrad and 50.6 Hz, 24 rest.
    assert cell["at_rest_fraction"] == 0.375
    assert cell["p2p_rad"] == pytest.approx((4 * 0.05743 + 0.08731) / 5, abs=5e-6)
    assert cell["frequency_hz"] == pytest.approx((4 * 56.875 + 455.0 / 9) / 5, rel=1e-12)
    assert cell["p2p_max_rad"] == pytest.approx(0.08731, abs=5e-6)
    assert cell["frequency_at_max_hz"] == pytest.approx(455.0 / 9, rel=1e-12)
    assert cell["p2p_counts"] == pytest.approx(cell["p2p_rad"] * 256 / (2.0 * np.pi), rel=1e-12)
    assert 0.2 * cell["p2p_rad"] < cell["rms_rad"] < 0.5 * cell["p2p_rad"]


def test_a_cell_in_which_nothing_cycles_has_no_size_but_a_largest_of_0() -> None:
    cell = of_attractors((Outcome.REST, 8, at_rest(-1e-3, -1e-3)))
    assert [cell[name] for name in ("p2p_rad", "p2p_counts", "frequency_hz", "rms_rad")] == [None] * 4
    assert (cell["p2p_max_rad"], cell["frequency_at_max_hz"]) == (0.0, None)
    assert (cell["at_rest_fraction"], cell["orbit_count"]) == (1.0, 1)


def test_a_cell_in_which_nothing_is_bounded_has_no_largest() -> None:
    cell = of_attractors((Outcome.DIVERGED, 8, OrbitMeasures()))
    assert (cell["p2p_rad"], cell["p2p_max_rad"], cell["frequency_at_max_hz"]) == (None, None, None)
    assert (cell["diverged_fraction"], cell["orbit_count"]) == (1.0, 0)


def test_a_motion_that_is_measured_but_not_proven_counts_with_the_cycles() -> None:
    cell = of_attractors(
        (Outcome.CYCLE, 4, cycle(1e-3, 50.0)), (Outcome.REST, 3, at_rest(0, 0)), (Outcome.UNDECIDED, 1, cycle(6e-3, 30))
    )
    assert cell["p2p_rad"] == pytest.approx((4 * 1e-3 + 6e-3) / 5)
    assert (cell["p2p_max_rad"], cell["frequency_at_max_hz"]) == (6e-3, 30.0)
    assert (cell["undecided_fraction"], cell["at_rest_fraction"], cell["orbit_count"]) == (0.125, 0.375, 3)


def test_what_has_no_size_is_in_no_mean() -> None:
    cell = of_attractors((Outcome.UNDECIDED, 7, OrbitMeasures()), (Outcome.CYCLE, 1, cycle(2e-3, 80.0)))
    assert (cell["p2p_rad"], cell["p2p_max_rad"], cell["frequency_hz"]) == (2e-3, 2e-3, 80.0)


def test_of_equal_sizes_the_most_frequent_is_the_largest() -> None:
    found = in_columns([result(1), result(0), result(3)])
    values = np.array([nan, 2.0, 5.0, 5.0])
    assert found.largest(values).tolist() == [4, 4, 2]  # past the last: no value, no attractor


def of_attractors(*found: tuple[Outcome, int, OrbitMeasures]) -> dict[str, Any]:
    """Row of a cell that has these attractors, each with the trials that reach it."""
    plan = loaded()
    cell = next(iter(cells_of(plan)))
    attractors = tuple(
        Attractor(outcome=outcome, reason=Reason.NONE, trials=trials, period=8 if outcome is Outcome.CYCLE else 1)
        for outcome, trials, _ in found
    )
    one = CellResult(cell, 6e-3, attractors, tuple(measures for *_, measures in found), 0)
    row: dict[str, Any] = cells_table(plan, [one]).to_pylist()[0]
    assert not any(isinstance(value, float) and isnan(value) for value in row.values())
    return row


def cycle(p2p_rad: float, frequency_hz: float) -> OrbitMeasures:
    return OrbitMeasures(cycles=1, p2p_rad=p2p_rad, rms_rad=0.3 * p2p_rad, frequency_hz=frequency_hz)


def result(attractors: int) -> CellResult:
    """A cell with some attractors."""
    one = Attractor(outcome=Outcome.CYCLE, reason=Reason.NONE, trials=1)
    return CellResult({}, 1e-3, (one,) * attractors, (cycle(1e-3, 50.0),) * attractors, 0)
