"""The ledger of the dissertation, read once by a process, and what it says without any result."""

from functools import cache
from typing import Any

from hknob_cli.page.claims.ledger import Claim, Ledger, load_ledger
from hknob_cli.page.claims.verdict import judge
from hknob_cli.results.result_set import ResultSet
from tests.conftest import ROOT


@cache
def ledger() -> Ledger:
    """All claims. Whoever changes one makes a copy."""
    return load_ledger(ROOT / "data" / "claims.yaml")


def claim(name: str) -> Claim:
    """The claim with an id."""
    (found,) = (one for one in ledger().claims if one.id == name)
    return found


@cache
def verdicts() -> dict[str, dict[str, Any]]:
    """Rows by the claims' ids, where there is no result."""
    return {row["claim"]: row for row in judge(ledger(), ResultSet({})).to_pylist()}
