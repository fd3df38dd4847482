"""Results beside one another: cell by cell beside a sweep, like with like, and over the axes of their grid.

What a trial of remedies says of all of them together.

Over the axes: whether two results change alike along one, how plane they are, and the surface of sec. 10.7.
"""

from math import log
from typing import Any

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import Line, check, lines, one_number, percent, rows_of
from hknob_cli.page.claims.checks.edge import edge_of
from hknob_cli.page.claims.checks.grid import exponent
from hknob_cli.results.result_set import CAMPAIGN, MissingError, ResultSet, Rows, Where, matching
from hknob_cli.specs.plan import COUNTS, RATE

QUANTITIES = {
    "p2p": "p2p_difference",
    "largest": "p2p_max_difference",
    "amplitude": "amplitude_difference",
    "frequency": "frequency_difference",
}
_NEEDS = ("p2p_rad", "frequency_hz")


@check
def difference(
    evidence: ResultSet,
    result: str,
    against: str,
    quantity: str = "p2p",
    statistic: str = "mean",
    where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """A statistic of (result - sweep) / sweep over the cells, %.

    ``quantity``: `p2p`, `frequency`, `largest` (peak to peak against that of the sweep's largest cycle), or `amplitude`
    (half of peak to peak, against the sweep's peak to peak: unlike with unlike). ``file`` and ``where`` pick a method
    or a law. Cells that rest on either side do not count; of several cycles in a cell the nearest to the sweep does.
    """
    return one_number(
        (100.0 * value for value in _differences(evidence, result, against, quantity, where, file)), statistic
    )


@check
def largest_deviation(
    evidence: ResultSet,
    result: str,
    against: str,
    printed: dict[str, float],
    quantity: str = "p2p",
    where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """Largest distance, in points, of several statistics of the differences from those ``printed``, by name.

    So one reading has to give all numbers of a sentence. Other arguments as in `difference`.
    """
    found = [100.0 * value for value in _differences(evidence, result, against, quantity, where, file)]
    pairs = [(one_number(found, statistic), value) for statistic, value in printed.items()]
    return max((abs(computed - value) for computed, value in pairs if computed is not None), default=None)


@check
def ratio(
    evidence: ResultSet,
    result: str,
    against: str,
    quantity: str = "p2p",
    statistic: str = "mean",
    where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """A statistic of result / sweep over the cells that cycle on both sides; arguments as in `difference`."""
    return one_number(
        (1.0 + value for value in _differences(evidence, result, against, quantity, where, file)), statistic
    )


@check
def agreement(
    evidence: ResultSet,
    result: str,
    against: str,
    least: float,
    largest: float,
    quantity: str = "p2p",
    where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """Share of the cells, %, where the difference to the sweep is between ``least`` and ``largest`` (%)."""
    found = _differences(evidence, result, against, quantity, where, file)
    return percent(least <= 100.0 * value <= largest for value in found)


@check
def accuracy_ratio(
    evidence: ResultSet, result: str, against: str, where: Where | None = None, file: str = "cells"
) -> float | None:
    """Mean size of the differences in frequency over that of those in peak to peak; below 1: pitch is nearer."""
    pitch, size = (
        one_number(_differences(evidence, result, against, quantity, where, file), "mean_size")
        for quantity in ("frequency", "p2p")
    )
    return None if pitch is None or not size else pitch / size


@check
def largest_beside(
    evidence: ResultSet,
    result: str,
    column: str,
    to: str,
    reaching: float | None = None,
    statistic: str = "mean",
    where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """Largest value of a column over the axes that only ``result`` has, over that of the same cell of the sweep ``to``.

    A statistic over the cells of ``to`` that cycle; with ``reaching`` the share of them, %, where it is at least that.
    """
    axes = evidence[to].axes
    rows = rows_of(evidence, result, file, where, needs=[*axes, column])
    ratios = []
    for cell in rows_of(evidence, to, "cells", needs=[*axes, column]):
        here = [row[column] for row in matching(rows, {axis: cell[axis] for axis in axes}) if row[column] is not None]
        if here and cell[column]:
            ratios.append(max(here) / cell[column])
    if reaching is not None:
        return percent(value >= reaching for value in ratios)
    return one_number(ratios, statistic)


@check
def of_two_cells(
    evidence: ResultSet,
    column: str,
    result: str,
    to: str,
    where: Where | None = None,
    to_where: Where | None = None,
    file: str = "cells",
) -> float | None:
    """A column in one row over the same in another, of the same or another result; means where several fit."""
    first = one_number((row[column] for row in rows_of(evidence, result, file, where, needs=[column])), "mean")
    second = one_number((row[column] for row in rows_of(evidence, to, file, to_where, needs=[column])), "mean")
    return None if first is None or not second else first / second


def _differences(
    evidence: ResultSet, result: str, against: str, quantity: str, where: Where | None, file: str
) -> list[float]:
    """Relative differences to the sweep, one a cell. Raises `UsageError` for an unknown quantity, `MissingError`."""
    from hknob_cli.report.theory import nearest_cycles

    if quantity not in QUANTITIES:
        raise UsageError(f"quantity: must be one of {', '.join(QUANTITIES)}, got '{quantity}'")
    axes = evidence[result].axes
    rows = rows_of(evidence, result, file, where, needs=[*axes, *_NEEDS])
    column = QUANTITIES[quantity]
    return [
        row[column] for row in nearest_cycles(_beside(evidence, rows, result, against), axes) if row[column] is not None
    ]


def _beside(evidence: ResultSet, rows: Rows, result: str, against: str) -> Rows:
    """The rows with the values of the sweep, or campaign, and the differences; what rests has none."""
    from hknob_cli.stages.compare import Against

    axes = evidence[result].axes
    recorded = evidence[against].table("cells") if evidence[against].stage == CAMPAIGN else None
    sweep = Against(str(evidence[against].folder), axes, rows, table=recorded)
    joined = []
    for row in rows:
        p2p, frequency = (row[name] or None for name in _NEEDS)
        joined.append({**row, **sweep.columns(row, p2p_rad=p2p, frequency_hz=frequency)})
    if all(row["sweep_p2p_rad"] is None for row in joined):
        raise MissingError(f"'{against}' cycles in no cell of '{result}'")
    return joined


@check
def remedies_that(
    evidence: ResultSet, result: str, case: str, smaller: float = 0.0, reference: str = "plain wall"
) -> float:
    """Number of remedies that make the buzz so many times smaller at a case, or end it, for every hand.

    By the largest cycle of each. The ``reference`` is none of them. With ``smaller`` 0: of all that were tried.
    """
    rows = rows_of(evidence, result, "cases", {"case": case}, needs=["remedy", "p2p_max_rad", "p2p_ratio"])
    helps: dict[str, bool] = {}
    for row in rows:
        rests = row["p2p_max_rad"] == 0.0
        enough = smaller <= 0.0 or rests or (row["p2p_ratio"] is not None and row["p2p_ratio"] >= smaller)
        helps[row["remedy"]] = helps.get(row["remedy"], True) and enough
    return sum(enough for name, enough in helps.items() if name != reference)


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
