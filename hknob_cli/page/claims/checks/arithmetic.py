"""Arithmetic over printed numbers: what an expression in the text amounts to, and whether values are among others.

Arithmetic as text, evaluated safely: numbers, names, + - * / **, and a few functions; nothing else is reachable.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from math import isclose
from statistics import mean, stdev

from hknob_cli.page.claims.checks import check
from hknob_cli.printed.tables import cell, table
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
