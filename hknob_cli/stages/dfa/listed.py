"""Cycles found by formula beside the complete lists of a sweep: which of them those have, and how many they have."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.errors import UsageError
from hknob_cli.results.columns import Column
from hknob_cli.results.files import input_digest
from hknob_cli.results.parted import read_result, result_schema
from hknob_cli.results.provenance import scene_of
from hknob_cli.specs.parquet import why_unreadable
from hknob_cli.specs.plan import Cell, Scene
from hknob_cli.stages.compare import key_of, sweep_file

COLUMNS = (
    Column("listed", pa.bool_(), "", "whether the sweep's complete list has this cycle; null where none is complete"),
    Column("listed_count", pa.int64(), "1", "cycles in the cell's list; null where it is not complete"),
)

SAME = 1e-9  # of two peaks to peak that are of one cycle, relative

_Cycle = tuple[int, float]  # period in samples, peak to peak in rad


def digest(folder: str) -> str | None:
    """Digest of the sweep's orbits, an input of what is compared with them; None without. Raises `UsageError`."""
    path = sweep_file(folder).with_name("orbits.parquet")
    return input_digest(path) if path.exists() else None


class Lists:
    """The complete lists of a sweep's cycles, by cell; ``any``: whether there is one."""

    def __init__(self, folder: str, axes: Sequence[str], scene: Scene) -> None:
        """Read those of the sweep in ``folder``; none if its push is another. Raises `UsageError`."""
        self._axes = list(axes)
        self._lists: dict[tuple[str, ...], list[_Cycle]] = {}
        cells = sweep_file(folder)
        theirs = scene_of(result_schema(cells).metadata)
        if theirs is None or theirs.bias != scene.bias:
            return
        for row in _rows(cells, [*axes, "complete"]):
            if row["complete"]:
                self._lists[key_of(row, axes)] = []
        if not self._lists:
            return
        for row in _rows(cells.with_name("orbits.parquet"), [*axes, "outcome", "period_samples", "p2p_rad"]):
            left = self._lists.get(key_of(row, axes))
            if left is not None and row["outcome"] == "cycle":
                left.append((row["period_samples"], row["p2p_rad"]))

    @property
    def any(self) -> bool:
        """Whether a list is complete."""
        return bool(self._lists)

    def mark(self, cell: Cell, found: list[dict[str, Any]]) -> None:
        """Give each row ``found`` in a cell its `COLUMNS`; no two rows are one listed cycle."""
        listed = self._lists.get(key_of(cell, self._axes))
        if listed is None:
            return
        left = list(listed)
        for row in found:
            row["listed_count"] = len(listed)
            period, p2p = row.get("period_samples"), row["p2p_rad"]
            if period is None or p2p is None:
                continue
            match = next((one for one in left if one[0] == period and abs(one[1] - p2p) <= SAME * p2p), None)
            row["listed"] = match is not None
            if match:
                left.remove(match)


def _rows(path: Path, columns: list[str]) -> list[dict[str, Any]]:
    """Some columns of a table. Raises `UsageError` where it cannot be read or lacks one that every sweep has."""
    try:
        table = read_result(path)
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"against: {path} {why_unreadable(error)}; run the sweep again") from None
    there = [name for name in columns if name in table.column_names]
    rows: list[dict[str, Any]] = table.select(there).to_pylist()
    return [{**dict.fromkeys(columns), **row} for row in rows]
