"""What printed numbers amount to: arithmetic over them, and trends of the hand models in Tables 1-5.

Arithmetic as text, evaluated safely: numbers, names, + - * / **, and a few functions; nothing else is reachable.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from math import isclose, pi, sqrt
from statistics import mean, stdev

import numpy as np

from hknob_cli.page.claims.checks import check
from hknob_cli.printed import Row, cell, half_widths, table
from hknob_cli.results.result_set import ResultSet

_TWO: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}
_ONE: dict[type[ast.unaryop], Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "abs": abs,
    "min": min,
    "max": max,
    "floor": math.floor,
}
_CONSTANTS = {"pi": math.pi}

_STATISTICS: dict[str, Callable[[Sequence[float]], float]] = {
    "mean": mean,
    "std": stdev,
    "least": min,
    "largest": max,
}
Place = tuple[int, float | str, str]
Names = dict[str, float | str | Place]


def evaluate(expression: str, names: Mapping[str, float] | None = None) -> float:
    """Value of an arithmetic expression; ``names`` are bound beside ``pi``.

    Raises `TypeError` for anything that is not such arithmetic, for an unknown name, and where there is no value.
    """
    known = {**_CONSTANTS, **(names or {})}

    def value(node: ast.expr) -> float:
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return float(number)
            case ast.Name(id=name) if name in known:
                return known[name]
            case ast.Name(id=name):
                raise TypeError(f"unknown name '{name}' in '{expression}'; known: {', '.join(known)}")
            case ast.BinOp(left=left, op=sign, right=right) if type(sign) in _TWO:
                return _TWO[type(sign)](value(left), value(right))
            case ast.UnaryOp(op=sign, operand=inner) if type(sign) in _ONE:
                return _ONE[type(sign)](value(inner))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in _FUNCTIONS:
                return float(_FUNCTIONS[name](*map(value, arguments)))
        raise TypeError(f"not arithmetic: '{expression}'")

    try:
        found = value(ast.parse(expression.strip(), mode="eval").body)
    except (SyntaxError, ArithmeticError, ValueError, RecursionError, MemoryError) as error:
        raise TypeError(f"no value of '{expression}': {error}") from None
    if not math.isfinite(found):
        raise TypeError(f"no value of '{expression}': it is not finite")
    return found


def bound(where: Names | None) -> dict[str, float]:
    """Names with their numbers: given, at a (table, row, column), or by an expression over earlier names.

    Raises `UsageError` where a table has no such place, `TypeError` where an expression has no value.
    """
    names: dict[str, float] = {}
    for name, value in (where or {}).items():
        if isinstance(value, str):
            names[name] = evaluate(value, names)
        elif isinstance(value, int | float):
            names[name] = float(value)
        else:
            names[name] = cell(*value)
    return names


@check
def arithmetic(_: ResultSet, *, expression: str, where: Names | None = None) -> float:
    """Value of an expression over numbers, and names for numbers of the tables; in whatever unit it has."""
    return evaluate(expression, bound(where))


@check
def spread_over_columns(
    _: ResultSet, *, table_number: int, rows: list[float | str], columns: list[str], what: str
) -> float:
    """Statistic of a block of a table, in the unit of the table: mean, sample standard deviation, least, largest."""
    return _STATISTICS[what]([cell(table_number, row, column) for row in rows for column in columns])


@check
def largest_margin_error(
    _: ResultSet, *, table_number: int, rows: list[float | str], columns: list[str], margin: str, what: str
) -> float:
    """Largest difference between a printed margin and what its cells give, in the unit of the table.

    ``margin`` is a column, for margins over the columns, or a row, for margins over the rows; ``what`` the statistic.
    """
    if margin in table(table_number)[0]:
        lines = [(cell(table_number, row, margin), [cell(table_number, row, one) for one in columns]) for row in rows]
    else:
        lines = [(cell(table_number, margin, one), [cell(table_number, row, one) for row in rows]) for one in columns]
    return max(abs(printed - _STATISTICS[what](values)) for printed, values in lines)


@check
def largest_total_error(_: ResultSet, *, table_number: int, total: str, rows: int | None = None) -> float:
    """Largest difference between a printed total and the sum of what is printed above it, in the unit of the table.

    ``rows`` of the table are read, all by default, the total last. Columns without a number as total are left out.
    """
    *parts, totals = table(table_number)[:rows]
    key = next(iter(totals))
    if totals[key] != total:
        raise TypeError(f"the last row read of table {table_number} is {totals[key]!r}, not {total!r}")
    return max(
        abs(value - sum(part for row in parts if isinstance(part := row[name], float)))
        for name, value in totals.items()
        if isinstance(value, float)
    )


@check
def share_among(_: ResultSet, *, values: list[float], among: list[float], within_percent: float = 0.0) -> float:
    """Share of the values that are among the others, or within a percentage of one of them; a fraction."""
    near = 0.01 * within_percent
    return sum(any(isclose(one, other, rel_tol=max(near, 1e-12)) for other in among) for one in values) / len(values)


GRIP = "grip_n"
# Radius (m) of the knob that each table was measured with: 17.8 mm and 29.9 mm across.
RADIUS_M = {1: 8.9e-3, 2: 8.9e-3, 3: 14.95e-3, 4: 14.95e-3, 5: 14.95e-3}
_J, _B, _K, _RATIO = "inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad", "damping_ratio"


def column(number: int, name: str, grips: list[float] | None = None, *, translational: bool = False) -> list[float]:
    """A column of a table at the given grip forces, the lightest first; all by default.

    ``translational``: divided by the square of the knob's radius, as for motion along its rim. Raises `UsageError`.
    """
    scale = RADIUS_M[number] ** 2 if translational else 1.0
    rows = sorted(grips or [float(row[GRIP] or 0) for row in table(number)])
    return [cell(number, grip, name) / scale for grip in rows]


@check
def share_of_steps(_: ResultSet, *, tables: list[int], quantity: str, way: str) -> float:
    """Share of the steps from one grip force to the next in which a column rises or falls (``way``); a fraction."""
    sign = {"rises": 1.0, "falls": -1.0}[way]
    steps = [sign * step > 0 for number in tables for step in np.diff(column(number, quantity))]
    return sum(steps) / len(steps)


@check
def least_r_squared(_: ResultSet, *, tables: list[int], quantities: list[str]) -> float:
    """Least share of the variance of a column over the grips that a straight line over grip force explains."""
    fits = [np.corrcoef(column(n, GRIP), column(n, quantity))[0, 1] ** 2 for n in tables for quantity in quantities]
    return float(min(fits))


@check
def share_of_grips_above(
    _: ResultSet,
    *,
    pairs: list[tuple[int, int]],
    quantity: str,
    grips: list[float] | None = None,
    translational: bool = False,
) -> float:
    """Share of grip forces and pairs of tables at which a column is larger in the second table; a fraction."""
    above = [
        b > a
        for one, other in pairs
        for a, b in zip(
            column(one, quantity, grips, translational=translational),
            column(other, quantity, grips, translational=translational),
            strict=True,
        )
    ]
    return sum(above) / len(above)


@check
def largest_difference_percent(
    _: ResultSet, *, pairs: list[tuple[int, int]], quantity: str, grips: list[float] | None = None
) -> float:
    """Largest difference of a column between two tables, in % of the first."""
    return 100.0 * max(
        abs(b / a - 1.0)
        for one, other in pairs
        for a, b in zip(column(one, quantity, grips), column(other, quantity, grips), strict=True)
    )


@check
def share_within_deviation(
    _: ResultSet, *, pairs: list[tuple[int, int]], quantity: str, deviation: str, grips: list[float] | None = None
) -> float:
    """Share of grip forces at which two tables differ by less than the smaller standard deviation of the two."""
    inside = [
        abs(b - a) < min(spread_a, spread_b)
        for one, other in pairs
        for a, b, spread_a, spread_b in zip(
            column(one, quantity, grips),
            column(other, quantity, grips),
            column(one, deviation, grips),
            column(other, deviation, grips),
            strict=True,
        )
    ]
    return sum(inside) / len(inside)


@check
def extreme(_: ResultSet, *, tables: list[int], quantity: str, which: str, grips: list[float] | None = None) -> float:
    """Least or largest value of a column, in its unit."""
    return {"least": min, "largest": max}[which](value for n in tables for value in column(n, quantity, grips))


@check
def share_below(
    _: ResultSet, *, tables: list[int], quantity: str, limit: float, grips: list[float] | None = None
) -> float:
    """Share of the values of a column that are below a limit; a fraction."""
    values = [value for number in tables for value in column(number, quantity, grips)]
    return sum(value < limit for value in values) / len(values)


@check
def share_of_ratios_of_means(_: ResultSet, *, tables: list[int]) -> float:
    """Share of the printed damping ratios that B/(2 sqrt(J K)) of the printed means gives, within all rounding."""
    met = []
    for number in tables:
        for row, half in zip(table(number), half_widths(number), strict=True):
            low, high = _ratio(row, half, -1.0), _ratio(row, half, 1.0)
            printed, slack = float(row[_RATIO] or 0), half[_RATIO] + 1e-12
            met.append(low <= printed + slack and printed - slack <= high)
    return sum(met) / len(met)


def _ratio(row: Row, half: dict[str, float], side: float) -> float:
    """Damping ratio at the low (-1) or high (+1) end of what the rounding of J, B and K allows."""
    j, b, k = (float(row[name] or 0) for name in (_J, _B, _K))
    return (b + side * half[_B]) / (2.0 * sqrt((j - side * half[_J]) * (k - side * half[_K])))


@check
def share_of_variations(_: ResultSet, *, tables: list[int], quantities: dict[str, tuple[str, str]]) -> float:
    """Share of printed coefficients of variation that standard deviation over mean gives, within all rounding.

    ``quantities``: columns of mean and standard deviation by the column of the coefficient, which is in %.
    """
    met = []
    for number in tables:
        for row, half in zip(table(number), half_widths(number), strict=True):
            for name, (middle, spread) in quantities.items():
                mean, deviation, printed = (float(row[key] or 0) for key in (middle, spread, name))
                low = 100.0 * (deviation - half[spread]) / (mean + half[middle])
                high = 100.0 * (deviation + half[spread]) / (mean - half[middle])
                met.append(low <= printed + half[name] + 1e-12 and printed - half[name] - 1e-12 <= high)
    return sum(met) / len(met)


@check
def oscillation_torque(_: ResultSet, *, number: int, grip_n: float, amplitude_rad: float, frequency_hz: float) -> float:
    """Amplitude (N·m) of the torque that moves a hand of a table, apparatus included, in a sinusoid."""
    omega = 2.0 * pi * frequency_hz
    inertia, damping, stiffness = (cell(number, grip_n, name) for name in (_J, _B, _K))
    return amplitude_rad * abs(complex(stiffness - inertia * omega**2, damping * omega))
