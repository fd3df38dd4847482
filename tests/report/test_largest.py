"""Tables and pictures go by the largest cycle of a cell, and show the mean of what cycles beside it."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from hknob_cli.figures import what_matters
from hknob_cli.report.large import pitches, sizes
from hknob_cli.report.theory import largest_cycles, nearest_cycles
from hknob_cli.results.columns import differs, mean_beside
from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.text import describe_sweep, table_text
from tests.conftest import EXPERIMENTS

AXES = ["sample_rate_hz", "counts_per_rev"]


def said(*overrides: str) -> str:
    result = SweepStage(load(EXPERIMENTS / "hand_on_knob.yaml", ("scene.bias.torque=0.007", *overrides))).run()
    summary = describe_sweep(result.cells, result.orbits, axes=AXES)
    return table_text({**summary, "name": "knob", "status": "done"}, AXES)


def test_a_cell_that_also_rests_is_printed_with_cycles_that_there_are() -> None:
    """87.3 mrad at 50.6 Hz is its largest cycle; of 57.4 and 87.3 mrad the mean is 63.4, whatever part rests."""
    text = said("grid.sample_rate_hz=455", "grid.counts_per_rev=256")
    for number in ("87.31", "63.41", "50.56", "55.61", "37.5"):
        assert number in text
    assert "39.6" not in text
    assert "34.8" not in text
    assert "37.5 % of the starts come to rest" in text


def test_a_grid_has_a_table_of_the_largest_cycles_and_one_of_the_means() -> None:
    text = said("grid.sample_rate_hz=[455, 1000]", "grid.counts_per_rev=[128, 256]")
    lines = text.splitlines()
    titles = [i for i, line in enumerate(lines) if line.startswith("peak to peak, mrad")]
    assert ["of the largest cycle" in lines[i] for i in titles] == [True, False]
    largest, means = ([line.split() for line in lines[i + 3 : i + 5]] for i in titles)
    assert [largest[0][2], means[0][2]] == ["87.31*r", "63.41*r"]
    assert [largest[1][2], means[1][2]] == ["0r", "-r"]  # at 1 kHz and 256 counts every trial rests


def test_one_table_where_every_cell_has_one_cycle() -> None:
    text = said("scene.bias.torque=0.001", "grid.sample_rate_hz=[1000, 2154]", "grid.counts_per_rev=[256, 2048]",
                "starts.phases=1")  # fmt: skip
    assert text.count("peak to peak, mrad") == 1
    assert "mean of the trials" not in text


def test_a_mean_that_is_the_largest_is_not_told() -> None:
    cell = {"p2p_max_rad": 2e-3, "p2p_rad": 1e-3, "frequency_at_max_hz": 80.0, "frequency_hz": 80.0}
    assert (mean_beside(cell, "p2p_max_rad"), mean_beside(cell, "frequency_at_max_hz")) == (1e-3, None)
    assert mean_beside(cell, "p2p_rad") is None
    assert differs([cell])
    assert not differs([{"p2p_max_rad": 0.0, "p2p_rad": None, "frequency_at_max_hz": None, "frequency_hz": None}])


def test_people_are_told_by_their_largest_cycle() -> None:
    people: list[dict[str, Any]] = [
        {"p2p_max_rad": 4e-3, "p2p_rad": 1e-3, "frequency_at_max_hz": 50.0, "frequency_hz": 70.0},
        {"p2p_max_rad": 0.0, "p2p_rad": None, "frequency_at_max_hz": None, "frequency_hz": None},
        {"p2p_max_rad": None, "p2p_rad": None, "frequency_at_max_hz": None, "frequency_hz": None},
    ]
    assert (sizes(people), pitches(people)) == ([0.0, 4e-3], [50.0])


def cycle(rate: float, p2p: float | None, difference: float | None = None, **more: Any) -> dict[str, Any]:
    return {"rate": rate, "p2p_rad": p2p, "p2p_difference": difference, **more}


def test_of_several_cycles_of_a_method_one_a_cell() -> None:
    rows = [cycle(1, 1.0, -0.9), cycle(1, 3.0, 0.5), cycle(1, 2.0, -0.1), cycle(2, None), cycle(2, 5.0, 0.2)]
    assert [row["p2p_rad"] for row in largest_cycles(rows, ["rate"])] == [3.0, 5.0]
    assert [row["p2p_rad"] for row in nearest_cycles(rows, ["rate"])] == [2.0, 5.0]


def test_what_matters_counts_a_cell_with_several_cycles_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: dict[str, Any] = {}
    monkeypatch.setattr(what_matters, "draw_matters", lambda series, *_, **__: drawn.update(series) or True)
    rows = [
        {"rate": float(rate), "method": "sampled", "orbit": orbit, "p2p_rad": size, "frequency_hz": 9.0, "in_domain": 1}
        for rate in (1, 2)
        for orbit, size in enumerate((1.0, 3.0, 2.0))
    ]
    table = pa.Table.from_pylist(rows)
    path = tmp_path / "a.png"
    assert what_matters.draw_by(table, "method", ["rate"], title="", path=path, stage="dfa", points=None)
    assert drawn["sampled"]["p2p_rad"].tolist() == [3.0, 3.0]


def test_what_does_not_repeat_has_tables_of_its_own(loop_not_kept: None) -> None:
    """A clock that jitters has no cycles; a cell without jitter beside it has one, and no swing."""
    few = "starts.phases=1", "limits.max_samples=1024"
    jitters = "scene.clock={jitter: 0.05, seed: 1}", "scene.bias.torque=0.001", *few
    text = said(*jitters, "grid.sample_rate_hz=[1000, 2154]", "grid.counts_per_rev=[256, 2048]")
    assert "peak to peak" not in text
    titles = [line for line in text.splitlines() if "mrad" in line and line.endswith("proven)")]
    assert [line.split(",")[0] for line in titles] == ["mean swing", "swing at most"]
    mean, most = ([line.split()[1:] for line in text.partition(one)[2].splitlines()[3:5]] for one in titles)
    for some, least_upper in zip(mean, most, strict=True):
        assert all(0.0 < float(one.rstrip("?")) < float(other) for one, other in zip(some, least_upper, strict=True))
    listed = said(*jitters, "grid.sample_rate_hz=1000", "grid.counts_per_rev=1024", "grid.clock.jitter=[0, 0.05]")
    assert "mean swing mrad" in listed
    assert "at most mrad" in listed
