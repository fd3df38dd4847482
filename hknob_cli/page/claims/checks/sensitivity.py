"""Whether two results change alike along an axis of their grid."""

from typing import Any

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.grid import exponent
from hknob_cli.page.claims.checks.rows import Line, lines, one_number, rows_of
from hknob_cli.results.result_set import ResultSet, Where


@check
def slope_difference(
    evidence: ResultSet,
    result: str,
    against: str,
    column: str,
    along: str,
    where: Where | None = None,
    statistic: str = "mean",
) -> float | None:
    """Size of the difference of a column's exponents along an axis in two results of one grid.

    Of a statistic of the differences over the other axes; only cells in which both have a value above 0, so buzz.
    """
    axes = evidence[result].axes

    def place(row: dict[str, Any]) -> tuple[Any, ...]:
        return tuple(row[axis] for axis in axes)

    rows = [rows_of(evidence, name, "cells", where, needs=[*axes, column]) for name in (result, against)]
    first_places, second_places = ({place(row) for row in some if row[column]} for some in rows)
    both = first_places & second_places
    kept = [sorted((row for row in some if place(row) in both), key=place) for some in rows]
    pairs: list[list[Line]] = [lines(some, axes, along=along, column=column) for some in kept]
    found = []
    for one, other in zip(*pairs, strict=True):
        first, second = exponent(one), exponent(other)
        if first is not None and second is not None:
            found.append(first - second)
    size = one_number(found, statistic)
    return None if size is None else abs(size)
