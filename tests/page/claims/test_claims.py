"""The ledger of the dissertation: verdicts that follow from the tables, and from nothing else."""

import inspect
from pathlib import Path

import pytest

from hknob_cli import printed
from hknob_cli.page.claims.checks import known
from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.printed import file_of
from hknob_cli.results.result_set import ResultSet
from tests.ledger import claim, verdicts


def verdict(name: str) -> str:
    """What is said of one claim by the tables as they are now."""
    return str(judge_claim(claim(name), ResultSet({}))["verdict"])


def test_print_that_does_not_hold_together_is_found() -> None:
    rows = verdicts()
    contradicted = {
        "ch4-fatigue-weight", "eq2-state-matrix", "ch5-stiffness-starts-identical", "ch5-stiffness-progression",
        "table7-stiffness", "ch8-subset", "appendix-d-rates", "eq2-input",
    }  # fmt: skip
    differs = {
        "ch4-lightest-grip", "ch4-damping-ratio-definition", "ch4-cv-inertia-largest", "ch4-inertia-falls",
        "ch5-stiffness-grows-apart", "ch5-medium-knob-inertia", "table7-inertia", "ch9-staircase-energy",
        "table10-within-5", "fig3-torque-balance", "ch10-tenth-of-the-rate",
    }  # fmt: skip
    for names, verdict in ((contradicted, "contradicted"), (differs, "differs")):
        assert {name: rows[name]["verdict"] for name in names} == dict.fromkeys(names, verdict)
        assert all(rows[name]["finding"] for name in names)


def test_every_claim_is_judged_or_says_why_not() -> None:
    for row in verdicts().values():
        assert row["because"]
        assert (row["computed"] is None) == (row["verdict"] == "not testable")


def test_without_results_nothing_that_needs_one_is_decided() -> None:
    for row in verdicts().values():
        if row["check"] and "result" in inspect.signature(known()[row["check"]]).parameters:
            assert row["verdict"] == "not testable", row["claim"]


@pytest.mark.parametrize(
    ("number", "old", "new", "claim", "before", "after"),
    [
        (1, "48.3,0.6,0.12", "47.3,0.6,0.12", "ch4-cv-stiffness-largest", "reproduced", "contradicted"),
        (1, "3.45E-04", "5.63E-04", "ch5-key-damping", "reproduced", "differs"),
        (1, "3.45E-04", "3.55E-04", "table7-damping", "reproduced", "contradicted"),
        (1, "18.8,0.04,", "18.8,0.08,", "table7-stiffness", "contradicted", "reproduced"),
        (1, "2.11E-06", "2.21E-06", "ch4-inertia-falls", "differs", "reproduced"),
        (2, "9.8,0.02,", "9.8,0.04,", "ch5-stiffness-starts-identical", "contradicted", "reproduced"),
        (8, "8,0.72,0.64", "8,0.72,0.84", "table8-row-means", "reproduced", "contradicted"),
        (9, "75.07", "75.17", "table9-totals", "reproduced", "contradicted"),
        (10, "8.14", "8.04", "table10-within-5", "differs", "reproduced"),
        (10, "32.7", "32.2", "ch5-medium-knob-inertia", "differs", "reproduced"),
    ],
)
def test_a_printed_number_decides(
    number: int, old: str, new: str, claim: str, before: str, after: str, copied_tables: Path
) -> None:
    assert verdict(claim) == before
    path = file_of(number)
    assert path.is_relative_to(copied_tables)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    printed._read.cache_clear()
    try:
        assert verdict(claim) == after
    finally:
        printed._read.cache_clear()
