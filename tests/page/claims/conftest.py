"""Ledgers from text, printed tables that a test may change, and evidence made by hand."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from hknob_cli import printed
from hknob_cli.page.claims.ledger import Ledger, load_ledger
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import ResultSet
from hknob_cli.results.store import write

HEAD = "text: a text\nclaims:\n"
SCENE = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"half_quantum": True},
}
BOUNDED = {"at_rest_fraction": 0.0, "diverged_fraction": 0.0, "undecided_fraction": 0.0, "certified_fraction": 1.0}
Made = Callable[..., ResultSet]


@pytest.fixture
def ledger(tmp_path: Path) -> Callable[[str], Ledger]:
    """Reads the claims of a ledger, given as YAML."""

    def read(claims: str) -> Ledger:
        path = tmp_path / "claims.yaml"
        path.write_text(HEAD + claims)
        return load_ledger(path)

    return read


@pytest.fixture
def copied_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a copy of the tables, which the program reads instead of its own."""
    folder = tmp_path / "tables"
    shutil.copytree(printed.folder(), folder)
    monkeypatch.setattr(printed, "FOLDERS", (folder,))
    return folder


@pytest.fixture
def made(tmp_path: Path) -> Made:
    """Evidence with one more result: its name, tables as lists of rows by file, axes, scene and stage."""
    folders: dict[str, Path] = {}

    def make(
        name: str,
        tables: dict[str, list[dict[str, Any]]],
        *,
        axes: tuple[str, ...] = ("sample_rate_hz", "counts_per_rev"),
        scene: dict[str, Any] = SCENE,
        stage: str = "sweep",
    ) -> ResultSet:
        folder = tmp_path / name
        folder.mkdir()
        values = {"name": name, "scene": scene, "grid": {axis: [] for axis in axes}}
        provenance = describe(stage=stage, values=values, overrides=())
        write({folder / f"{file}.parquet": pa.Table.from_pylist(rows) for file, rows in tables.items()}, provenance)
        folders[name] = folder
        return ResultSet(folders)

    return make


def cell(rate: float, counts: int, p2p: float, frequency: float, **more: Any) -> dict[str, Any]:
    """A row of cells.parquet, whose cycles are all alike; ``p2p`` 0: none, for all trials rest."""
    return {
        "sample_rate_hz": float(rate),
        "counts_per_rev": counts,
        "p2p_rad": p2p or None,
        "p2p_max_rad": p2p,
        "frequency_at_max_hz": frequency if p2p else None,
        "frequency_hz": frequency if p2p else None,
        **BOUNDED,
        **more,
    }


def lawful(constant: float = 600.0) -> list[dict[str, Any]]:
    """Cells with p2p = C q T exactly, and a frequency that goes with the root of the rate."""
    from math import pi, sqrt

    return [
        cell(rate, counts, constant * 2.0 * pi / counts / rate, 2.5 * sqrt(rate))
        for rate in (100, 1000, 10000)
        for counts in (128, 512, 2048)
    ]
