"""What a trial of remedies says of all of them together."""

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.rows import rows_of
from hknob_cli.results.result_set import ResultSet


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
