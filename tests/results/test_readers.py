"""Results open in pandas, Polars and DuckDB, without this program, with the contract's columns."""

import json
from pathlib import Path

import duckdb
import pandas as pd
import polars as pl
import pyarrow.parquet as pq
import pytest

from hknob_cli.results import store
from hknob_cli.results.provenance import describe
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import SPEC, loaded

CELLS = {
    "sample_rate_hz", "counts_per_rev", "p2p_rad", "p2p_max_rad", "p2p_counts", "frequency_hz", "frequency_at_max_hz",
    "rms_rad", "orbit_count",
    "certified_fraction", "at_rest_fraction", "diverged_fraction", "undecided_fraction",
}  # fmt: skip
ORBITS = {
    "sample_rate_hz", "counts_per_rev", "orbit", "outcome", "period_samples", "cycles_per_period", "p2p_rad",
    "min_rad", "max_rad", "rms_rad", "frequency_hz", "basin_fraction", "certified", "margin_counts", "closure_rad",
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out")
    spec = loaded(SPEC.replace("[1000]", "[500, 1000]"))
    result = SweepStage(spec).run()
    stamp = describe(stage="sweep", values=spec.values, overrides=())
    store.write({out / "cells.parquet": result.cells, out / "orbits.parquet": result.orbits}, stamp)
    return out


def test_pandas(folder: Path) -> None:
    cells = pd.read_parquet(folder / "cells.parquet")
    orbits = pd.read_parquet(folder / "orbits.parquet")
    assert set(cells.columns) >= CELLS
    assert set(orbits.columns) >= ORBITS
    assert len(cells) == 2
    assert orbits["certified"].all()
    share = orbits.groupby("sample_rate_hz")["basin_fraction"].sum()
    assert share.to_list() == pytest.approx([1.0, 1.0], abs=1e-12)


def test_polars(folder: Path) -> None:
    cells = pl.read_parquet(folder / "cells.parquet")
    assert cells["sample_rate_hz"].to_list() == [500.0, 1000.0]
    assert (cells["p2p_rad"] > 0).all()


def test_duckdb(folder: Path) -> None:
    query = f"select count(*), min(frequency_hz) from '{folder / 'orbits.parquet'}' where certified"
    with duckdb.connect() as connection:
        row = connection.execute(query).fetchone()
    assert row is not None
    assert row[0] >= 2
    assert row[1] > 10.0


def test_weights_of_a_cell(folder: Path) -> None:
    cells = pd.read_parquet(folder / "cells.parquet")
    orbits = pd.read_parquet(folder / "orbits.parquet")
    for _, cell in cells.iterrows():
        of = orbits[orbits.sample_rate_hz == cell.sample_rate_hz]
        for column in ("p2p_rad", "frequency_hz", "rms_rad"):
            assert cell[column] == pytest.approx((of[column] * of.basin_fraction).sum(), rel=1e-12)
        assert cell.p2p_counts == pytest.approx(cell.p2p_rad * cell.counts_per_rev / 6.283185307179586, rel=1e-14)


def test_provenance_says_spec_and_versions(folder: Path) -> None:
    record = json.loads(pq.read_schema(folder / "cells.parquet").metadata[b"hknob.provenance"])
    assert record["spec"]["scene"]["wall"] == {"stiffness": 0.27}
    assert {"hknob", "numpy", "pyarrow", "python"} <= set(record["versions"])
    assert len(record["inputs"]["spec_sha256"]) == 64
