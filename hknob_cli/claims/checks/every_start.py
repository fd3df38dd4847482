"""What holds of all limit cycles of a cell, where a sweep lists them completely."""

from hknob_cli.claims.checks import check
from hknob_cli.claims.checks.edge import edge_of
from hknob_cli.claims.checks.rows import Where, percent, rows_of
from hknob_cli.results.evidence import Evidence, MissingError


def _complete(evidence: Evidence, result: str, where: Where | None, column: str) -> list[dict[str, float]]:
    """Cells with a column. Raises `MissingError` where a list is not proven to be complete."""
    rows = rows_of(evidence, result, "cells", where, needs=["complete", column])
    if not all(row["complete"] for row in rows):
        raise MissingError(f"a list of limit cycles of '{result}' is not complete")
    return rows


@check
def largest_within(evidence: Evidence, result: str, counts: float, where: Where | None = None) -> float | None:
    """Share of the cells, %, whose largest cycle, of all there are, is smaller than so many counts, peak to peak."""
    rows = _complete(evidence, result, where, "p2p_max_rad")
    return percent(
        (row["p2p_max_rad"] or 0.0) < counts * edge_of(evidence, result, row).quantum_rad * (1.0 - 1e-9) for row in rows
    )


@check
def alone(evidence: Evidence, result: str, where: Where | None = None) -> float | None:
    """Share of the cells, %, with one attractor only."""
    return percent(row["orbit_count"] == 1 for row in _complete(evidence, result, where, "orbit_count"))
