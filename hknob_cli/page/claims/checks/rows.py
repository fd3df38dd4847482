"""Rows of results by what a claim says of them, and one number from many."""

from collections.abc import Callable, Iterable
from math import isfinite, nan, sqrt
from typing import Any

from hknob_cli.errors import UsageError
from hknob_cli.results.result_set import MissingError, ResultSet, Rows, Where, matching

Line = list[tuple[float, float]]

_SIZES = ("p2p_rad", "p2p_counts", "rms_rad")  # of a cell's cycles


def rows_of(evidence: ResultSet, result: str, file: str, where: Where | None = None, *, needs: Iterable[str]) -> Rows:
    """Rows of a result's table that ``where`` asks for, and that have all columns of ``needs``.

    ``where``: by column, a value (numbers as printed, to 0.5 %), a list of them, or bounds (`at_least`, `at_most`,
    `above`, `below`). A cell in which all trials rest has the size 0, as a print of one trial a cell has it, and no
    pitch. Raises `MissingError` where there is no such result, column or row, and `UsageError` for an unknown bound.
    """
    asked = where or {}
    table = evidence[result].table(file)
    if lacking := sorted({*needs, *asked} - set(table.column_names)):
        raise MissingError(f"no column {', '.join(lacking)} in {file} of '{result}'")
    found = matching([_sized(row) for row in table.to_pylist()], asked)
    if not found:
        raise MissingError(f"no such row in {file} of '{result}'")
    return found


def rests(row: dict[str, Any]) -> bool:
    """Whether all trials of a cell rest."""
    return bool(row.get("at_rest_fraction") == 1.0)


def _sized(row: dict[str, Any]) -> dict[str, Any]:
    return {**row, **{name: 0.0 for name in _SIZES if name in row and row[name] is None}} if rests(row) else row


def one_number(values: Iterable[float | None], statistic: str) -> float | None:
    """Mean, std (n - 1), least, largest, median or count of the values there are; None if there are none.

    `largest_size` and `mean_size` are of absolute values. Raises `UsageError` for an unknown statistic.
    """
    if statistic not in _STATISTICS:
        raise UsageError(f"unknown statistic '{statistic}'; there are {', '.join(_STATISTICS)}")
    found = sorted(value for value in values if value is not None and isfinite(value))
    return _STATISTICS[statistic](found) if found else None


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)


def _std(values: list[float]) -> float:
    mean = _mean(values)
    return sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1)) if len(values) > 1 else 0.0


_STATISTICS: dict[str, Callable[[list[float]], float]] = {
    "mean": _mean,
    "std": _std,
    "least": min,
    "largest": max,
    "median": lambda values: 0.5 * (values[(len(values) - 1) // 2] + values[len(values) // 2]),
    "count": len,
    "largest_size": lambda values: max(abs(value) for value in values),
    "mean_size": lambda values: _mean([abs(value) for value in values]),
}


def percent(flags: Iterable[bool]) -> float | None:
    """Share of true ones, %; None if there are none at all."""
    found = list(flags)
    return 100.0 * sum(found) / len(found) if found else None


def lines(rows: Rows, axes: list[str], *, along: str, column: str, resting: bool = False) -> list[Line]:
    """(axis value, column value) in ascending order along an axis, a list for each value of the other axes.

    Raises `MissingError` if ``along`` is no axis. Rows without a value are left out; with ``resting`` a cell in which
    all trials rest stays in its place, and its value is not a number.
    """
    if along not in axes:
        raise MissingError(f"no axis {along}; there are {', '.join(axes)}")
    found: dict[tuple[Any, ...], Line] = {}
    for row in rows:
        value = nan if row[column] is None and resting and rests(row) else row[column]
        if value is not None:
            key = tuple(row[axis] for axis in axes if axis != along)
            found.setdefault(key, []).append((row[along], value))
    return [sorted(line, key=lambda point: point[0]) for line in found.values()]


def averaged(many: list[Line]) -> list[Line]:
    """One line: the mean over all lines, at every axis value."""
    by: dict[float, list[float]] = {}
    for line in many:
        for at, value in line:
            by.setdefault(at, []).append(value)
    return [[(at, _mean(values)) for at, values in sorted(by.items())]]
