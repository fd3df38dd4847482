"""Stability limits and friction, beside what a sweep does."""

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.edge import edge_of
from hknob_cli.page.claims.checks.rows import percent, rows_of
from hknob_cli.results.result_set import ResultSet, Where, matching
from hknob_cli.specs.plan import COUNTS


@check
def cycles_where_limit(
    evidence: ResultSet, result: str, limit: str, holds: bool, where: Where | None = None
) -> float | None:
    """Share of a sweep's cells, %, with any trial that cycles, of those where a limit holds (or does not).

    ``limit``: `colgate_schenkel` or `abbott_okamura`, passivity by the knob's own damping; the same names followed by
    `_with_hand`, by that of knob and hand; `gil_hulin`, `niemeyer`.
    """
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.laws import working_edge
    from hknob_cli.theory.passivity import LIMITS, verdict

    if limit not in LIMITS:
        raise UsageError(f"limit: must be one of {', '.join(LIMITS)}, got '{limit}'")
    found = []
    for row in rows_of(evidence, result, "cells", where, needs=["at_rest_fraction"]):
        cell = {axis: row[axis] for axis in evidence[result].axes}
        # A continuous sensor is the limit of many counts.
        full = {COUNTS: 2**31, **cell}
        if verdict(working_edge(scene_at(evidence[result].scene, cell), full)).limits[limit].holds == holds:
            found.append(row)
    return percent(row["at_rest_fraction"] < 1.0 for row in found)


@check
def friction_that_ends(
    evidence: ResultSet, result: str, column: str = "knob.coulomb_torque", where: Where | None = None
) -> float | None:
    """Least Coulomb friction from which on every trial rests, over all pushes of the grid, in torque steps K q."""
    rows = rows_of(evidence, result, "cells", where, needs=[column, "at_rest_fraction"])
    moving = [row[column] for row in matching(rows, {"at_rest_fraction": {"below": 1.0}})]
    most = max(moving, default=-1.0)
    least = min((row[column] for row in rows if row[column] > most), default=None)
    return None if least is None else least / edge_of(evidence, result, rows[0]).torque_step


@check
def counts_that_end(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Fewest counts per revolution of the grid from which on every trial of every cell rests."""
    rows = rows_of(evidence, result, "cells", where, needs=[COUNTS, "at_rest_fraction"])
    most = max((row[COUNTS] for row in matching(rows, {"at_rest_fraction": {"below": 1.0}})), default=-1)
    return min((row[COUNTS] for row in rows if row[COUNTS] > most), default=None)
