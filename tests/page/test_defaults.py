"""What a page shows of results that it is only given: tables of another shape are told."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.defaults import chapters_of, sentences_of
from hknob_cli.results.evidence import Evidence
from hknob_cli.results.provenance import describe
from hknob_cli.results.store import write

CELLS: dict[str, Any] = {
    "sample_rate_hz": [500.0, 1000.0],
    "p2p_rad": [2e-3, 1e-3],
    "frequency_hz": [80.0, 90.0],
    "certified_fraction": [1.0, 1.0],
    "at_rest_fraction": [0.0, 0.0],
}


def evidence(folder: Path, **columns: Any) -> Evidence:
    """A sweep over the sample rate, some columns of its cells as others have them, or absent."""
    table = pa.table({name: values for name, values in {**CELLS, **columns}.items() if values is not None})
    stamp = describe(stage="sweep", values={"name": "x", "grid": {"sample_rate_hz": [500, 1000]}}, overrides=())
    write({folder / "cells.parquet": table}, stamp)
    return Evidence({"tried": folder})


def test_a_sweep_is_said_and_shown(tmp_path: Path) -> None:
    assert "2 cells: peak to peak from 1 to 2 mrad" in sentences_of(evidence(tmp_path))[0]
    assert [figure.draw for figure in chapters_of(evidence(tmp_path))[0].figures] == ["staircase"]


@pytest.mark.parametrize(
    "columns", [{"frequency_hz": None}, {"p2p_rad": ["x", "y"]}, {"certified_fraction": [None, 1.0]}]
)
def test_tables_of_another_shape_have_no_sentence(tmp_path: Path, columns: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match=r"results: the tables of 'tried' in .* are not as its stage writes them"):
        sentences_of(evidence(tmp_path, **columns))


def test_tables_without_their_axis_are_not_shown(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="'tried' has no column sample_rate_hz"):
        chapters_of(evidence(tmp_path, sample_rate_hz=None))


def test_a_design_over_several_axes_shows_what_matters(tmp_path: Path) -> None:
    grid = {"design": {"sobol": 2}, "sample_rate_hz": {"log": [500, 1000]}, "bias.torque": {"lin": [0.0, 0.001]}}
    stamp = describe(stage="sweep", values={"name": "x", "grid": grid}, overrides=())
    write({tmp_path / "cells.parquet": pa.table({**CELLS, "bias.torque": [0.0, 0.001]})}, stamp)
    found = Evidence({"tried": tmp_path})
    assert found["tried"].scales == {"sample_rate_hz": "log", "bias.torque": "lin"}
    assert [figure.draw for figure in chapters_of(found)[0].figures] == ["what_matters"]
