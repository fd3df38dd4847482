"""The ledger as a file: its faults, each with its place."""

import re

import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.results.result_set import ResultSet

GOOD = """\
  - id: sum
    place: section 1
    says: two and two are five
    printed: 5
    check: arithmetic
    with: {expression: 2 + 2}
    holds: {within: 0.5}
    because: a count is exact
"""


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (
            "check: arithmetic",
            "check: arithmetik",
            "7:12: claims[0].check: unknown check 'arithmetik'; did you mean",
        ),
        (
            "check: arithmetic",
            "check: arithmetic\n    untestable: no",
            "3:5: claims[0]: must have either a check, or the",
        ),
        ("    check: arithmetic\n", "", "3:5: claims[0]: must have either a check, or the reason"),
        ("    holds: {within: 0.5}\n", "", "3:5: claims[0]: must say when it holds"),
        ("    because: a count is exact\n", "", "3:5: claims[0]: must say when it holds, and because of what"),
        ("{within: 0.5}", "{}", "9:12: claims[0].holds: must give at least one of within"),
        ("{within: 0.5}", "{within: -1}", "9:21: claims[0].holds.within: must be > 0, got -1"),
        ("    printed: 5\n", "", "3:5: claims[0]: must have a printed value for within"),
        ("    printed: 5\n", "    printd: 5\n", "6:5: claims[0].printd: unknown key; did you mean 'printed'?"),
        ("id: sum", "id: A Sum", "3:9: claims[0].id: "),
        ("    place: section 1\n", "", "3:5: claims[0].place: missing, and required"),
    ],
)
def test_faults_have_their_place(ledger, old: str, new: str, fault: str) -> None:
    with pytest.raises(SpecError) as found:
        ledger(GOOD.replace(old, new))
    assert any(f"claims.yaml:{fault}" in str(one) for one in found.value.faults), found.value


def test_an_id_is_one_claims(ledger) -> None:
    with pytest.raises(SpecError, match=r"claims\.yaml:11:9: claims\[1\]\.id: must be unique; claim 1 has it, too"):
        ledger(GOOD + GOOD)


def test_every_fault_is_told_at_once(ledger) -> None:
    with pytest.raises(SpecError) as found:
        ledger(GOOD.replace("place", "plaice") + GOOD.replace("id: sum", "id: Sum"))
    assert len(found.value.faults) >= 3


def test_arguments_a_check_does_not_take_are_faults_of_the_claim(ledger) -> None:
    from hknob_cli.page.claims.verdict import judge

    for arguments in ("{expression: 2 + q}", "{expression: 1/0}", "{expression: 5}", "{expression: 1, where: [1]}"):
        claims = ledger(GOOD.replace("{expression: 2 + 2}", arguments))
        with pytest.raises(UsageError, match="claim sum: arithmetic cannot use "):
            judge(claims, ResultSet({}))
    for arguments, wrong in (("{}", "needs expression"), ("{expression: 1, wher: {}}", "did you mean 'where'?")):
        with pytest.raises(UsageError, match=rf"claims\.yaml:7:12: .*{re.escape(wrong)}"):
            ledger(GOOD.replace("{expression: 2 + 2}", arguments))
