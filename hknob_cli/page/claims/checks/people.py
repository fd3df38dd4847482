"""People against one wall: how their limit cycles spread."""

import numpy as np

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.rows import rows_of
from hknob_cli.results.result_set import MissingError, ResultSet, Where
from hknob_cli.specs.plan import PERSON


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
