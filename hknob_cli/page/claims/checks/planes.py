"""Results over the axes of their grid: whether two change alike, how plane they are, and the surface of sec. 10.7.

Whether two results change alike along an axis of their grid.
"""

from math import log
from typing import Any

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.edge import edge_of
from hknob_cli.page.claims.checks.grid import exponent
from hknob_cli.page.claims.checks.rows import Line, lines, one_number, rows_of
from hknob_cli.results.result_set import ResultSet, Where
from hknob_cli.specs.plan import COUNTS, RATE


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

    The exponents are those of a statistic over the other axes. Only cells count in which both have a value above 0.
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


@check
def planarity(evidence: ResultSet, result: str, column: str, where: Where | None = None) -> float | None:
    """Part of the variance of a column's logarithm, %, that a plane over log sample rate and log counts explains."""
    rows = rows_of(evidence, result, "cells", where, needs=[column, RATE, COUNTS])
    found = [(log(row[RATE]), log(row[COUNTS]), log(row[column])) for row in rows if (row[column] or 0.0) > 0.0]
    return _explained([list(point[:2]) for point in found], [point[2] for point in found])


@check
def product_explains(
    evidence: ResultSet, result: str, where: Where | None = None, step: str | None = None
) -> float | None:
    """Part of the variance of log p2p, %, that C q T explains with the slope of 1 and the best C.

    ``step``: an axis of torque steps; q is then such a step over the wall's stiffness, instead of a count.
    """
    rows = rows_of(evidence, result, "cells", where, needs=["p2p_rad", RATE, step or COUNTS])
    left, values = [], []
    for row in rows:
        if row["p2p_rad"]:
            edge = edge_of(evidence, result, row)
            values.append(log(row["p2p_rad"]))
            quantum = row[step] / edge.wall_stiffness if step else edge.quantum_rad
            left.append(values[-1] - log(quantum * edge.period_s))
    return 100.0 * float(1.0 - np.var(left) / np.var(values)) if len(values) > 1 else None


def _explained(points: list[list[float]], values: list[float]) -> float | None:
    if len(values) < 4:
        return None
    design = np.column_stack([np.ones(len(values)), np.array(points)])
    fit = np.linalg.lstsq(design, np.array(values), rcond=None)[0]
    return 100.0 * float(1.0 - np.var(np.array(values) - design @ fit) / np.var(values))


@check
def trough(
    evidence: ResultSet,
    result: str,
    where: Where | None = None,
    statistic: str = "median",
    column: str = "p2p_rad",
    log_pitch: bool = False,
) -> float | None:
    """Sample rate, Hz, of the least of max(log p2p, frequency), each scaled to 0...1; a statistic over resolutions.

    ``log_pitch``: log frequency, too. That is the bottom of the notional surface of Fig. 70. A cell at rest has no
    logarithm and is left out.
    """
    rows = [
        row
        for row in rows_of(evidence, result, "cells", where, needs=[column, "frequency_hz", RATE, COUNTS])
        if (row[column] or 0.0) > 0.0
    ]
    if not rows:
        return None
    sizes = _scaled([log(row[column]) for row in rows])
    pitches = _scaled([log(row["frequency_hz"]) if log_pitch else row["frequency_hz"] for row in rows])
    best: dict[float, tuple[float, float]] = {}
    for row, size, pitch in zip(rows, sizes, pitches, strict=True):
        here = (max(size, pitch), row[RATE])
        best[row[COUNTS]] = min(best.get(row[COUNTS], here), here)
    return one_number((rate for _, rate in best.values()), statistic)


def _scaled(values: list[float]) -> list[float]:
    low, high = min(values), max(values)
    if high <= low:
        raise UsageError("trough: the surface is flat, so it cannot be scaled")
    return [(value - low) / (high - low) for value in values]
