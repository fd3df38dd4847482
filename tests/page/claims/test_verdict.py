"""From values to verdicts: the rule, with readings, exclusions, and what is missing."""

import pytest

from hknob_cli.page.claims.checks import CHECKS
from hknob_cli.page.claims.ledger import Ledger
from hknob_cli.page.claims.verdict import COLUMNS, CONTRADICTED, DIFFERS, NOT_TESTABLE, REPRODUCED, judge, reading_text
from hknob_cli.results.result_set import ResultSet

CLAIM = {
    "id": "one",
    "place": "here",
    "says": "it is 10",
    "printed": 10.0,
    "unit": "N",
    "check": "arithmetic",
    "holds": {"within": 0.5},
    "near": {"within_percent": 20},
    "because": "half a digit",
}


def verdict(**changes: object) -> dict[str, object]:
    claim = {key: value for key, value in {**CLAIM, **changes}.items() if value is not None}
    table = judge(Ledger.model_validate({"text": "t", "claims": [claim]}), ResultSet({}))
    assert table.column_names == [column.name for column in COLUMNS]
    return table.to_pylist()[0]


def value(number: object) -> dict[str, str]:
    return {"expression": str(number)}


@pytest.mark.parametrize(
    ("number", "expected"),
    [(10, REPRODUCED), (10.5, REPRODUCED), (9.5, REPRODUCED), (10.6, DIFFERS), (12, DIFFERS), (12.1, CONTRADICTED)],
)
def test_by_the_printed_value(number: float, expected: str) -> None:
    row = verdict(**{"with": value(number)})
    assert row["verdict"] == expected
    assert row["computed"] == number
    assert row["tolerance"] == "holds: within 0.5; differs: within 20 %"


def test_without_near_nothing_only_differs() -> None:
    assert verdict(near=None, **{"with": value(10.6)})["verdict"] == CONTRADICTED


@pytest.mark.parametrize(("number", "expected"), [(0.9, REPRODUCED), (0.89, DIFFERS), (0.4, CONTRADICTED)])
def test_of_a_statement(number: float, expected: str) -> None:
    row = verdict(
        printed=None, holds={"at_least": 0.9, "at_most": 1.0}, near={"at_least": 0.5}, **{"with": value(number)}
    )
    assert row["verdict"] == expected
    assert row["printed"] is None


def test_the_reading_that_agrees_best_decides_unless_excluded() -> None:
    readings = [
        {"name": "a", "with": value(12)},
        {"name": "b", "with": value(9.8)},
        {"name": "c", "with": value(9.9)},
        {"name": "d", "with": value(10), "excluded": "the print says otherwise"},
    ]
    row = verdict(readings=readings)
    assert (row["verdict"], row["reading"], row["computed"]) == (REPRODUCED, "c", 9.9)
    last = row["readings"][-1]
    assert (last["name"], last["computed"], last["verdict"]) == ("d", 10.0, REPRODUCED)
    assert (last["missing"], last["excluded"]) == ("", "the print says otherwise")
    assert [one["excluded"] for one in row["readings"][:-1]] == [None] * 3
    assert reading_text(last, "N") == "d: 10 N, reproduced (not allowed: the print says otherwise)"
    assert verdict(readings=[readings[0], readings[3]])["verdict"] == DIFFERS
    assert verdict(readings=[readings[3]])["verdict"] == NOT_TESTABLE


def test_what_is_missing_is_not_testable_and_says_what(monkeypatch: pytest.MonkeyPatch) -> None:
    def of_a_sweep(evidence: ResultSet) -> float:
        return float(evidence["main"].rows("cells")[0]["p2p_rad"])

    monkeypatch.setitem(CHECKS, "of_a_sweep", of_a_sweep)
    row = verdict(check="of_a_sweep")
    assert (row["verdict"], row["computed"], row["reading"]) == (NOT_TESTABLE, None, "")
    assert row["because"] == "no result 'main'"
    monkeypatch.setitem(CHECKS, "of_a_sweep", lambda _: None)
    assert verdict(check="of_a_sweep")["because"] == "the computation has no value here"


def test_untestable_says_why() -> None:
    row = verdict(check=None, holds=None, near=None, because=None, printed=None, untestable="not recorded")
    assert (row["verdict"], row["because"], row["tolerance"]) == (NOT_TESTABLE, "not recorded", "")
