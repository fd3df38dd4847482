"""What the cells of a grid say: values, shares, trends and slopes, their lists of limit cycles, and people.

What holds of all limit cycles of a cell, where a sweep lists them completely.

People against one wall: how their limit cycles spread.
"""

import itertools
from math import log, nan

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import Line, averaged, check, lines, one_number, percent, rows_of
from hknob_cli.page.claims.checks.edge import edge_of
from hknob_cli.results.result_set import MissingError, ResultSet, Where, matching
from hknob_cli.specs.plan import PERSON


@check
def cell_statistic(
    evidence: ResultSet,
    result: str,
    column: str,
    statistic: str = "mean",
    where: Where | None = None,
    over: str | None = None,
    file: str = "cells",
) -> float | None:
    """A statistic of a column over cells, in the column's unit; ``over``: of its ratio to another column."""
    rows = rows_of(evidence, result, file, where, needs=[column, *([over] if over else [])])
    if over is None:
        return one_number((row[column] for row in rows), statistic)
    return one_number((row[column] / row[over] for row in rows if row[column] is not None and row[over]), statistic)


@check
def share_of_cells(
    evidence: ResultSet, result: str, having: Where, where: Where | None = None, file: str = "cells"
) -> float | None:
    """Share of the cells, %, that have column values within the bounds of ``having``."""
    rows = rows_of(evidence, result, file, where, needs=having)
    return 100.0 * len(matching(rows, having)) / len(rows)


@check
def count_of_cells(
    evidence: ResultSet, result: str, having: Where, where: Where | None = None, file: str = "cells"
) -> float:
    """Number of cells that have column values within the bounds of ``having``."""
    return len(matching(rows_of(evidence, result, file, where, needs=having), having))


@check
def trend(
    evidence: ResultSet,
    result: str,
    column: str,
    along: str,
    direction: str,
    where: Where | None = None,
    average: bool = False,
    file: str = "cells",
) -> float | None:
    """Share of the steps along an axis, %, in which a column goes ``up`` or ``down``.

    ``average``: of its mean over the other axes. A step from or to a cell at rest does not go either way where rest has
    no value, as it has no pitch.
    """
    sign = _sign(direction)
    return percent(
        sign * (after - before) > 0.0
        for line in _lines(evidence, result, column, along, where, average, file, resting=not average)
        for (_, before), (_, after) in itertools.pairwise(line)
    )


@check
def slope(
    evidence: ResultSet,
    result: str,
    column: str,
    along: str,
    where: Where | None = None,
    average: bool = False,
    statistic: str = "mean",
    file: str = "cells",
) -> float | None:
    """Exponent of a column as a power of an axis, by least squares on log axes; a statistic over the other axes.

    ``average``: of its mean over the other axes. Values that are not positive have no logarithm and are left out.
    """
    many = _lines(evidence, result, column, along, where, average, file)
    return one_number((exponent(line) for line in many), statistic)


@check
def slope_ratio(
    evidence: ResultSet,
    result: str,
    column: str,
    to: str,
    along: str,
    where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """Size of a column's mean exponent along an axis over that of the column ``to``."""
    first = slope(evidence, result, column, along, where, file=file)
    second = slope(evidence, result, to, along, where, file=file)
    return None if first is None or not second else abs(first / second)


@check
def spread_along(
    evidence: ResultSet,
    result: str,
    column: str,
    along: str,
    where: Where | None = None,
    statistic: str = "mean",
    average: bool = False,
    file: str = "cells",
) -> float | None:
    """Largest over least value of a column along an axis, rests left out; a statistic over the other axes."""
    many = _lines(evidence, result, column, along, where, average, file)
    positive = ([value for _, value in line if value > 0.0] for line in many)
    return one_number((max(values) / min(values) for values in positive if values), statistic)


@check
def end_to_end(
    evidence: ResultSet,
    result: str,
    column: str,
    along: str,
    where: Where | None = None,
    average: bool = False,
    statistic: str = "mean",
    file: str = "cells",
) -> float | None:
    """A column at the end of an axis over that at its start; a statistic over the other axes' values."""
    many = _lines(evidence, result, column, along, where, average, file, resting=not average)
    return one_number((line[-1][1] / line[0][1] for line in many if line and line[0][1]), statistic)


@check
def largest_over(
    evidence: ResultSet, result: str, column: str, at: Where, where: Where | None = None, file: str = "cells"
) -> float | None:
    """Largest value of a column over the cells, over its value in the cell ``at``."""
    largest = cell_statistic(evidence, result, column, "largest", where, file=file)
    here = cell_statistic(evidence, result, column, "mean", at, file=file)
    return None if largest is None or not here else largest / here


@check
def paired_trend(
    evidence: ResultSet,
    result: str,
    column: str,
    pairs: dict[str, list[float]],
    direction: str,
    first_only: bool = False,
    where: Where | None = None,
) -> float | None:
    """Share of the steps, %, in which a column goes ``up`` or ``down`` while several axes change together.

    ``pairs``: by axis, the values that belong together, in order. ``first_only``: share of the other axes' values for
    which the first is beyond all others.
    """
    sign = _sign(direction)
    steps = list(zip(*pairs.values(), strict=True))
    rows = rows_of(evidence, result, "cells", where, needs=[column, *pairs])
    others = [axis for axis in evidence[result].axes if axis not in pairs]
    series: dict[tuple[float, ...], list[float]] = {}
    for step in steps:
        for row in matching(rows, dict(zip(pairs, step, strict=True))):
            value = nan if row[column] is None else sign * row[column]
            series.setdefault(tuple(row[axis] for axis in others), []).append(value)
    if first_only:
        return percent(values[0] < min(values[1:]) for values in series.values())
    return percent(after > before for values in series.values() for before, after in itertools.pairwise(values))


def _sign(direction: str) -> float:
    if direction not in ("up", "down"):
        raise UsageError(f"direction: must be up or down, got '{direction}'")
    return 1.0 if direction == "up" else -1.0


def _lines(
    evidence: ResultSet,
    result: str,
    column: str,
    along: str,
    where: Where | None,
    average: bool,
    file: str,
    *,
    resting: bool = False,
) -> list[Line]:
    rows = rows_of(evidence, result, file, where, needs=[column, along])
    many = lines(rows, evidence[result].axes, along=along, column=column, resting=resting)
    return averaged(many) if average else many


def exponent(line: Line) -> float | None:
    """Least-squares slope of log value on log axis; None of fewer than two points."""
    points = [(log(at), log(value)) for at, value in line if at > 0.0 and value > 0.0]
    if len(points) < 2:
        return None
    mean_x, mean_y = (sum(point[i] for point in points) / len(points) for i in (0, 1))
    square = sum((x - mean_x) ** 2 for x, _ in points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / square if square else None


def _complete(evidence: ResultSet, result: str, where: Where | None, column: str) -> list[dict[str, float]]:
    """Cells with a column. Raises `MissingError` where a list is not proven to be complete."""
    rows = rows_of(evidence, result, "cells", where, needs=["complete", column])
    if not all(row["complete"] for row in rows):
        raise MissingError(f"a list of limit cycles of '{result}' is not complete")
    return rows


@check
def largest_within(evidence: ResultSet, result: str, counts: float, where: Where | None = None) -> float | None:
    """Share of the cells, %, whose largest cycle, of all there are, is smaller than so many counts, peak to peak."""
    rows = _complete(evidence, result, where, "p2p_max_rad")
    return percent(
        (row["p2p_max_rad"] or 0.0) < counts * edge_of(evidence, result, row).quantum_rad * (1.0 - 1e-9) for row in rows
    )


@check
def alone(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Share of the cells, %, with one attractor only."""
    return percent(row["orbit_count"] == 1 for row in _complete(evidence, result, where, "orbit_count"))


@check
def rows_in(evidence: ResultSet, result: str, file: str = "cells", where: Where | None = None) -> float:
    """Number of rows of a table."""
    return len(rows_of(evidence, result, file, where, needs=[]))


@check
def cells_larger(evidence: ResultSet, result: str, than: str, times: float = 1.0) -> float:
    """Number of cells whose largest cycle, of all there are, is more than so many times that of another sweep."""
    axes = evidence[than].axes
    others = rows_of(evidence, than, "cells", needs=[*axes, "p2p_max_rad"])
    larger = 0
    for row in _complete(evidence, result, None, "p2p_max_rad"):
        (other,) = matching(others, {axis: row[axis] for axis in axes})
        larger += (row["p2p_max_rad"] or 0.0) > times * (other["p2p_max_rad"] or 0.0) * (1.0 + 1e-9)
    return larger


def _values(evidence: ResultSet, result: str, column: str, where: Where | None) -> "np.ndarray":
    rows = rows_of(evidence, result, "cells", where, needs=[column, PERSON])
    found = np.array([row[column] for row in rows if row[column]], dtype=float)
    if len(found) < 2:
        raise MissingError(f"fewer than two people of '{result}' have a {column} above 0")
    return found


@check
def people_percentile(
    evidence: ResultSet, result: str, column: str, percentile: float, where: Where | None = None
) -> float:
    """Value of a column that so many per cent of the people for whom it is above 0 do not exceed; in its unit."""
    return float(np.percentile(_values(evidence, result, column, where), percentile))


@check
def people_spread(
    evidence: ResultSet, result: str, column: str, low: float = 5.0, high: float = 95.0, where: Where | None = None
) -> float:
    """Value of a column at a high percentile of the people over that at a low one; of those for whom it is above 0."""
    least, largest = np.percentile(_values(evidence, result, column, where), [low, high])
    return float(largest / least)
