"""The computations that claims name: each takes the evidence and the claim's arguments, and gives a number.

A computation returns a float (a flag counts as 1 or 0), or None where the quantity does not exist, and raises
`MissingError` where the evidence lacks what it needs. Its docstring says what it computes, and in which unit.

The checks share how rows of results are found by what a claim says of them, and one number is made of many.
"""

from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module
from inspect import Parameter, signature
from math import isfinite, nan, sqrt
from pkgutil import iter_modules
from typing import Any

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.results.result_set import MissingError, ResultSet, Rows, Where, matching
from hknob_cli.specs.messages import nearest, shown

Check = Callable[..., float | bool | None]

CHECKS: dict[str, Check] = {}


def check(function: Check) -> Check:
    """Register a computation under its name, which no other has."""
    assert function.__name__ not in CHECKS, function.__name__
    CHECKS[function.__name__] = function
    return function


@cache
def known() -> dict[str, Check]:
    """Every computation by name: those that the modules of this folder register."""
    for module in iter_modules(__path__, f"{__name__}."):
        import_module(module.name)
    return CHECKS


def argument_fault(function: Callable[..., Any], given: dict[str, Any], *, before: int) -> str | None:
    """What is wrong with keyword arguments, whatever their values; None if nothing is.

    The first ``before`` parameters are not the user's.
    """
    names = list(signature(function).parameters.values())[before:]
    allowed = [one.name for one in names]
    for name in given:
        if name not in allowed:
            return nearest(name, allowed).replace("unknown key", f"unknown argument {shown(name)}")
    lacking = [one.name for one in names if one.default is Parameter.empty and one.name not in given]
    return f"needs {', '.join(lacking)}" if lacking else None


def check_fault(name: str, given: dict[str, Any]) -> str | None:
    """What is wrong with a computation's name or arguments; None if nothing is."""
    if name not in known():
        return nearest(name, sorted(known())).replace("unknown key", f"unknown check {shown(name)}")
    wrong = argument_fault(known()[name], given, before=1)
    return f"{name}: {wrong}" if wrong else None


def compute(name: str, evidence: ResultSet, arguments: dict[str, Any]) -> float | None:
    """Value of a computation. Raises `MissingError`, and `UsageError` for arguments that it cannot use."""
    try:
        value = known()[name](evidence, **arguments)
        return None if value is None else float(value)
    except MISSHAPEN as error:
        raise UsageError(f"{name} cannot use {arguments}: {error}") from error


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
