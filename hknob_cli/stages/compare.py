"""Predictions beside a sweep, like with like: cell by cell, and as statistics over the grid.

Differences are relative to the sweep, (prediction - sweep) / sweep. The dissertation compared the *amplitude* of its
describing functions with the *peak to peak* of its simulations (sec. 7.3), so that reading is computed, too.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.errors import UsageError
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.results.files import input_digest
from hknob_cli.results.parted import read_result, result_schema
from hknob_cli.results.provenance import axes_of, origin, scene_of
from hknob_cli.specs.cells import Cells
from hknob_cli.specs.parquet import ChangedError, why_unreadable
from hknob_cli.specs.plan import Axes, Cell, Scene

COLUMNS = (
    Column("sweep_p2p_rad", pa.float64(), "rad", "the sweep's peak to peak, mean of the trials that cycle"),
    Column("sweep_p2p_max_rad", pa.float64(), "rad", "peak to peak of the sweep's largest cycle in the cell"),
    Column("sweep_frequency_hz", pa.float64(), "Hz", "the sweep's frequency, mean of the trials that cycle"),
    Column("p2p_difference", pa.float64(), "1", "(p2p_rad - sweep_p2p_rad) / sweep_p2p_rad"),
    Column("p2p_max_difference", pa.float64(), "1", "(p2p_rad - sweep_p2p_max_rad) / sweep_p2p_max_rad"),
    Column(
        "amplitude_difference", pa.float64(), "1", "(p2p_rad / 2 - sweep_p2p_rad) / sweep_p2p_rad: unlike with unlike"
    ),
    Column("frequency_difference", pa.float64(), "1", "(frequency_hz - sweep_frequency_hz) / sweep_frequency_hz"),
)


def sweep_file(folder: str) -> Path:
    """Cells of the sweep in a results folder. Raises `UsageError` if there are none."""
    return result_file(folder, "cells.parquet", "sweep", what="sweep")


def result_file(folder: str, file: str, stage: str, *, what: str) -> Path:
    """A file that a stage left in a folder; ``what``: that stage's work. Raises `UsageError` if there is none."""
    path = Path(folder) / file
    try:
        found = origin(result_schema(path).metadata)
    except ChangedError as error:
        raise UsageError(f"against: {path} {why_unreadable(error)}; run the {what} again") from None
    except FileNotFoundError:
        raise UsageError(f"against: {path} is not there or cannot be read; run the {what} first") from None
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"against: {path} {why_unreadable(error)}; run the {what} first") from None
    if found is None or found[0] != stage:
        raise UsageError(f"against: {path} is not the result of a {what}")
    return path


def digest(folder: str) -> str:
    """Digest of the sweep's cells, as an input of what is compared with them. Raises `UsageError`."""
    return input_digest(sweep_file(folder))


def scene_differences(folder: str, scene: Scene, axes: Axes) -> list[str]:
    """What is different in the sweep's scene, as ``wall.stiffness 0.8, here 0.45``; axes and the bias apart.

    The bias is what describing functions and laws assume, whatever the sweep's is. Raises `UsageError`.
    """
    theirs = scene_of(result_schema(sweep_file(folder)).metadata)
    return list(_differences(theirs, scene, "", {*axes, "bias"})) if theirs is not None else []


def _differences(theirs: Any, ours: Any, path: str, left_out: set[str]) -> Iterator[str]:
    """Differences of two parts of a scene, by dotted path."""
    for name in ours._fields:
        where, one, other = f"{path}{name}", getattr(theirs, name), getattr(ours, name)
        if where in left_out or one == other:
            continue
        if hasattr(one, "_fields") and hasattr(other, "_fields"):
            yield from _differences(one, other, f"{where}.", left_out)
        else:
            yield f"{where} {_said(one)}, here {_said(other)}"


def _said(value: Any) -> str:
    return "none" if value is None else "something" if hasattr(value, "_fields") else f"{value}"


_INSIDE = "_in_domain"
_COMPARED = ("p2p_rad", "p2p_max_rad", "frequency_hz")  # columns of a sweep; a cell has no value where nothing cycles


class Against:
    """The cells of a sweep, by the axis values of another grid or design."""

    def __init__(
        self, folder: str, axes: Sequence[str], cells: Iterable[Cell], *, table: pa.Table | None = None
    ) -> None:
        """Read them, unless ``table`` has them: a campaign's trials as cells. ``axes``, ``cells``: of the other grid.

        Raises `UsageError` if the sweep's axes are others, or no cell is common to both.
        """
        path = Path(folder)
        own: set[str] | None = None
        if table is None:
            path = sweep_file(folder)
            table = read_table(path, what="sweep")
            own = set(axes_of(table.schema.metadata))
        lacking = [axis for axis in axes if axis not in table.column_names]
        if lacking:
            raise UsageError(f"against: {path} has no axis {', '.join(lacking)}")
        self._axes = list(axes)
        rows = _numbers(table, self._axes, path)
        self._cells = {self._key(row): row for row in rows}
        # Points of a design may coincide, of a list of values or where counts are rounded.
        if len(self._cells) < len(rows) and (own is None or not own <= set(axes)):
            raise UsageError(f"against: {path} has further axes, so a cell here is several there")
        if not any(self._key(cell) in self._cells for cell in cells):
            raise UsageError(f"against: {path} has no cell of this grid")

    def _key(self, cell: Cell) -> tuple[str, ...]:
        return key_of(cell, self._axes)

    def partners(self, cells: Iterable[Cell]) -> int:
        """How many of these cells the sweep has, too."""
        return sum(self._key(cell) in self._cells for cell in cells)

    def cycles(self, cell: Cell) -> bool | None:
        """Whether any trial of the sweep cycles in a cell; None where the sweep has no such cell."""
        row = self._cells.get(self._key(cell))
        return None if row is None else _above_0(row.get("p2p_rad")) is not None

    def columns(self, cell: Cell, *, p2p_rad: float | None, frequency_hz: float | None) -> dict[str, Any]:
        """Values of `COLUMNS` for one prediction; None where either side has no value, or the sweep is at rest."""
        row = self._cells.get(self._key(cell), {})
        p2p, largest, frequency = (_above_0(row.get(name)) for name in _COMPARED)
        if p2p is None or frequency is None:
            p2p = largest = frequency = None
        return {
            "sweep_p2p_rad": p2p,
            "sweep_p2p_max_rad": largest,
            "sweep_frequency_hz": frequency,
            "p2p_difference": _relative(p2p_rad, p2p),
            "p2p_max_difference": _relative(p2p_rad, largest),
            "amplitude_difference": _relative(None if p2p_rad is None else 0.5 * p2p_rad, p2p),
            "frequency_difference": _relative(frequency_hz, frequency),
        }


def key_of(cell: Cell, axes: Iterable[str]) -> tuple[str, ...]:
    """Axis values to 12 digits: grids written in two ways meet."""
    return tuple(f"{cell[axis]:.12g}" for axis in axes)


def overlap(folder: str, axes: Axes, cells: Cells) -> dict[str, int]:
    """How many ``cells`` there are, and how many of them the sweep in ``folder`` has, too. Raises `UsageError`."""
    return {"cells": len(cells), "with_partner": Against(folder, list(axes), cells).partners(cells)}


def read_table(path: Path, *, what: str) -> pa.Table:
    """The table of a `result_file`. Raises `UsageError` if it cannot be read."""
    try:
        return read_result(path)
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"against: {path} {why_unreadable(error)}; run the {what} again") from None


def _numbers(table: pa.Table, axes: list[str], path: Path) -> list[dict[str, Any]]:
    """Rows of the axes and of what is compared, all numbers. Raises `UsageError` for a file that has others.

    Cells of earlier versions, whose means took rest as 0, lack the largest peak to peak, and are refused.
    """
    columns = {}
    for name in (*axes, *_COMPARED):
        try:
            columns[name] = table.column(name).cast(pa.float64())
        except (KeyError, pa.ArrowException):
            raise UsageError(f"against: {path} has no column {name} of numbers; run the sweep again") from None
        if columns[name].null_count and name in axes:
            raise UsageError(f"against: {path} has cells without a {name}")
    rows: list[dict[str, Any]] = pa.table(columns).to_pylist()
    return rows


def _above_0(value: float | None) -> float | None:
    """A size or frequency; None for a cell without a cycle."""
    return value if value and isfinite(value) else None


def _relative(value: float | None, reference: float | None) -> float | None:
    if value is None or not isfinite(value) or not reference:
        return None
    found = (value - reference) / reference
    return found if isfinite(found) else None


class Statistics(NamedTuple):
    """Of relative differences over ``cells`` cells: mean, standard deviation (n - 1), least, largest."""

    cells: int
    mean: float
    std: float
    least: float
    largest: float


Groups = dict[str, Statistics | None]

_QUANTITIES = ("p2p_difference", "p2p_max_difference", "amplitude_difference", "frequency_difference")
_STATISTICS = (
    Column(
        "quantity",
        pa.string(),
        "",
        "which difference; p2p_max: to the largest cycle; amplitude: of half the prediction",
    ),
    Column("in_domain", pa.bool_(), "", "whether only cells in the domain are counted, or all"),
    Column("cells", pa.int64(), "1", "cells where both sides have a value"),
    Column("mean", pa.float64(), "1", "mean relative difference"),
    Column("std", pa.float64(), "1", "standard deviation, n - 1"),
    Column("least", pa.float64(), "1", "least relative difference"),
    Column("largest", pa.float64(), "1", "largest relative difference"),
)


def statistics(values: Iterable[float | None]) -> Statistics | None:
    """Statistics of differences; None if there are none."""
    found = [value for value in values if value is not None]
    if not found:
        return None
    mean = sum(found) / len(found)
    spread = sqrt(sum((value - mean) ** 2 for value in found) / (len(found) - 1)) if len(found) > 1 else 0.0
    return Statistics(len(found), mean, spread, min(found), max(found))


def summarise(rows: list[dict[str, Any]]) -> Groups:
    """Statistics of one method's or law's rows, over all cells and over those in its domain."""
    inside = [row for row in rows if row["in_domain"]]
    return {
        f"{column}{suffix}": statistics(row[column] for row in chosen)
        for column in _QUANTITIES
        for chosen, suffix in ((rows, ""), (inside, _INSIDE))
    }


def statistics_table(name: str, groups: dict[str, Groups]) -> pa.Table:
    """Statistics by method or law (the column ``name``) as a table."""
    rows = [
        {name: key, "quantity": title.removesuffix(_INSIDE), "in_domain": title.endswith(_INSIDE), **found._asdict()}
        for key, group in groups.items()
        for title, found in group.items()
        if found is not None
    ]
    return build_table([Column(name, pa.string(), "", "what is compared with the sweep"), *_STATISTICS], rows)


def grouped(table: pa.Table, name: str) -> dict[str, dict[str, dict[str, Any]]]:
    """The table of `statistics_table` as nested plain data: by ``name``, then by quantity and domain."""
    groups: dict[str, dict[str, dict[str, Any]]] = {}
    for row in table.to_pylist():
        title = row["quantity"] + (_INSIDE if row["in_domain"] else "")
        numbers = {key: row[key] for key in Statistics._fields}
        groups.setdefault(row[name], {})[title] = numbers
    return groups
