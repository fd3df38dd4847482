"""What a page shows of results that it is only given: tables of another shape are told."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.figures.what_matters import what_matters
from hknob_cli.page.answers import answers_of, tiles_of
from hknob_cli.page.compose import chapters_of
from hknob_cli.results.parted import Parted, Parting, as_file, put_part
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import ResultSet
from hknob_cli.results.store import write

CELLS: dict[str, Any] = {
    "sample_rate_hz": [500.0, 1000.0],
    "p2p_rad": [1.5e-3, 1e-3],
    "p2p_max_rad": [2e-3, 1e-3],
    "frequency_hz": [85.0, 90.0],
    "frequency_at_max_hz": [80.0, 90.0],
    "certified_fraction": [1.0, 1.0],
    "at_rest_fraction": [0.0, 0.0],
}


def evidence(folder: Path, **columns: Any) -> ResultSet:
    """A sweep over the sample rate, some columns of its cells as others have them, or absent."""
    table = pa.table({name: values for name, values in {**CELLS, **columns}.items() if values is not None})
    stamp = describe(stage="sweep", values={"name": "x", "grid": {"sample_rate_hz": [500, 1000]}}, overrides=())
    write({folder / "cells.parquet": table}, stamp)
    return ResultSet({"tried": folder})


def test_a_sweep_is_said_and_shown(tmp_path: Path) -> None:
    assert answers_of(evidence(tmp_path)) == (
        "tried: It buzzes in all 2 cells, from the starts tried. The most: 2 mrad at 80 Hz (sample_rate_hz = 500). "
        "The least: 1 mrad at 90 Hz (sample_rate_hz = 1000). Every trial is proven.",
    )
    assert [(tile.value, tile.words) for tile in tiles_of(evidence(tmp_path), ())] == [
        ("2 of 2", "cells buzz, from the starts tried"),
        ("2 mrad", "largest buzz, peak to peak, at 80 Hz"),
    ]
    (chapter,) = chapters_of(evidence(tmp_path))
    assert [figure.draw for figure in chapter.figures] == ["axis_lines"]  # there are no orbits for a staircase
    assert [(table.file, table.key) for table in chapter.tables] == [("cells", "p2p_max_rad")]


@pytest.mark.parametrize(
    "columns", [{"frequency_at_max_hz": None}, {"p2p_max_rad": ["x", "y"]}, {"certified_fraction": [None, 1.0]}]
)
def test_tables_of_another_shape_have_no_answer(tmp_path: Path, columns: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match=r"results: the tables of 'tried' in .* are not as its stage writes them"):
        answers_of(evidence(tmp_path, **columns))


def test_tables_without_their_axis_are_not_shown(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="'tried' has no column sample_rate_hz"):
        chapters_of(evidence(tmp_path, sample_rate_hz=None))


def test_a_design_over_several_axes_of_too_few_points_to_tell_shows_every_cell(tmp_path: Path) -> None:
    grid = {"design": {"sobol": 2}, "sample_rate_hz": {"log": [500, 1000]}, "bias.torque": {"lin": [0.0, 0.001]}}
    stamp = describe(stage="sweep", values={"name": "x", "grid": grid}, overrides=())
    write({tmp_path / "cells.parquet": pa.table({**CELLS, "bias.torque": [0.0, 0.001]})}, stamp)
    found = ResultSet({"tried": tmp_path})
    assert found["tried"].scales == {"sample_rate_hz": "log", "bias.torque": "lin"}
    assert [figure.draw for figure in chapters_of(found)[0].figures] == ["cell_dots"]


def design(folder: Path, *, parts: int) -> ResultSet:
    """A design of 90 points over two axes, in one file or in parts."""
    dice = np.random.default_rng(0)
    rate, bias = dice.uniform(500.0, 1000.0, 90), dice.uniform(0.0, 1e-3, 90)
    rest = bias < 1e-4
    table = pa.table({
        "sample_rate_hz": rate, "bias.torque": bias, "p2p_max_rad": np.where(rest, 0.0, 1.0 / rate),
        "frequency_at_max_hz": np.where(rest, np.nan, 90.0 + 1e4 * bias), "p2p_rad": 0.9 / rate,
        "certified_fraction": np.ones(90), "at_rest_fraction": rest.astype(float),
    })  # fmt: skip
    grid = {"design": {"random": 90}, "sample_rate_hz": {"log": [500, 1000]}, "bias.torque": {"lin": [0.0, 0.001]}}
    stamp = describe(stage="sweep", values={"name": "x", "grid": grid}, overrides=())
    folder.mkdir()
    if parts == 1:
        write({folder / "cells.parquet": table}, stamp)
        return ResultSet({"tried": folder})
    parting = Parting(90, stamp, most=90 // parts)
    (folder / "cells.parquet").mkdir()
    for number in range(parts):
        start, stop = parting.range(number)
        put_part(as_file(table.slice(start, stop - start), parting.metadata(number)), folder / "cells.parquet", number)
    return ResultSet({"tried": folder})


def test_a_large_design_is_said_and_shown_part_by_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, parted = design(tmp_path / "whole", parts=1), design(tmp_path / "parted", parts=3)

    def table(*_: Any) -> None:
        raise AssertionError("a large table was read as a whole")

    monkeypatch.setattr(Parted, "table", table)
    assert answers_of(parted) == answers_of(whole)
    assert tiles_of(parted, ()) == tiles_of(whole, ())
    assert chapters_of(parted) == chapters_of(whole)
    assert [figure.draw for figure in chapters_of(parted)[0].figures] == ["what_matters"]
    drawn = [what_matters(one, "tried") for one in (whole, parted)]
    shown = [[line.get_ydata().tolist() for panel in one.axes for line in panel.lines] for one in drawn]
    np.testing.assert_equal(shown[1], shown[0])
    assert len(shown[0]) > 4


@pytest.mark.parametrize(
    ("proven", "said"),
    [
        ([0.0, 1.0], "In some cells no trial is proven."),
        ([0.25, 1.0], "At least 25 % of the trials of a cell are proven."),
    ],
)
def test_what_is_not_proven_is_said(tmp_path: Path, proven: list[float], said: str) -> None:
    assert answers_of(evidence(tmp_path, certified_fraction=proven))[0].endswith(said)
