"""What holds of all limit cycles of a cell, where a sweep lists them completely."""

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.edge import edge_of
from hknob_cli.page.claims.checks.rows import percent, rows_of
from hknob_cli.results.result_set import MissingError, ResultSet, Where, matching


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
