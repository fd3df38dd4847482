"""A sweep that others are compared with: read as numbers, and refused where it has none."""

from math import inf, nan
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.results.provenance import KEY, describe
from hknob_cli.stages.compare import Against

CELL: dict[str, Any] = {
    "sample_rate_hz": [1000.0],
    "p2p_rad": [4e-3],
    "p2p_max_rad": [6e-3],
    "frequency_hz": [80.0],
}
AXES, GRID = ["sample_rate_hz"], [{"sample_rate_hz": 1000.0}]


def written(folder: Path, stage: str = "sweep", **columns: Any) -> str:
    """A folder with cells.parquet of one cell."""
    table = pa.table({name: values for name, values in {**CELL, **columns}.items() if values is not None})
    stamp = describe(stage=stage, values={"name": "x"}, overrides=())
    pq.write_table(table.replace_schema_metadata({KEY: stamp}), folder / "cells.parquet")
    return str(folder)


def test_what_cycles_is_compared(tmp_path: Path) -> None:
    found = Against(written(tmp_path), AXES, GRID).columns({"sample_rate_hz": 1000.0}, p2p_rad=3e-3, frequency_hz=100.0)
    assert (found["sweep_p2p_rad"], found["p2p_difference"]) == (4e-3, pytest.approx(-0.25))
    assert (found["sweep_p2p_max_rad"], found["p2p_max_difference"]) == (6e-3, pytest.approx(-0.5))
    assert (found["sweep_frequency_hz"], found["frequency_difference"]) == (80.0, pytest.approx(0.25))


def test_a_cell_in_which_all_trials_rest_is_not_compared(tmp_path: Path) -> None:
    none = pa.array([None], pa.float64())
    folder = written(tmp_path, p2p_rad=none, p2p_max_rad=[0.0], frequency_hz=none)
    found = Against(folder, AXES, GRID).columns({"sample_rate_hz": 1000.0}, p2p_rad=3e-3, frequency_hz=100.0)
    assert set(found.values()) == {None}


def test_cells_of_a_version_that_took_rest_as_0_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cells.parquet has no column p2p_max_rad of numbers; run the sweep again"):
        Against(written(tmp_path, p2p_max_rad=None), AXES, GRID)


@pytest.mark.parametrize("value", [None, nan, inf])
@pytest.mark.parametrize("column", ["p2p_rad", "frequency_hz"])
def test_what_has_no_number_is_not_compared(tmp_path: Path, column: str, value: float | None) -> None:
    folder = written(tmp_path, **{column: pa.array([value], pa.float64())})
    found = Against(folder, AXES, GRID).columns({"sample_rate_hz": 1000.0}, p2p_rad=3e-3, frequency_hz=100.0)
    assert (found["sweep_p2p_rad"], found["p2p_difference"], found["frequency_difference"]) == (None, None, None)


def test_a_difference_too_large_for_a_number_is_none(tmp_path: Path) -> None:
    folder = written(tmp_path, p2p_rad=[5e-324])
    found = Against(folder, AXES, GRID).columns({"sample_rate_hz": 1000.0}, p2p_rad=3e-3, frequency_hz=100.0)
    assert found["p2p_difference"] is None


@pytest.mark.parametrize("column", CELL)
@pytest.mark.parametrize("values", [["x"], [[1.0]], None, [None]])
def test_a_file_of_another_shape_is_told(tmp_path: Path, column: str, values: Any) -> None:
    if values == [None] and column not in AXES:
        return
    with pytest.raises(UsageError, match=rf"against: .*cells.parquet has (no|cells without).*{column}"):
        Against(written(tmp_path, **{column: values}), AXES, GRID)


def test_a_torn_file_is_told(tmp_path: Path) -> None:
    path = Path(written(tmp_path)) / "cells.parquet"
    whole = path.read_bytes()
    path.write_bytes(whole[:4] + bytes(len(whole) // 4) + whole[4 + len(whole) // 4 :])
    with pytest.raises(UsageError, match=r"against: .*cells.parquet (cannot be read|is not there)"):
        Against(str(tmp_path), AXES, GRID)


def test_a_file_that_says_too_much_of_where_it_is_from_is_not_a_sweep(tmp_path: Path) -> None:
    table = pa.table(CELL).replace_schema_metadata({KEY: b"[" * 100_000})
    pq.write_table(table, tmp_path / "cells.parquet")
    with pytest.raises(UsageError, match="is not the result of a sweep"):
        Against(str(tmp_path), AXES, GRID)
