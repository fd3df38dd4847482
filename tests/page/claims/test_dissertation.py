"""The ledger of the dissertation: its computations exist, and follow the constants of what was run."""

import inspect
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import known
from hknob_cli.page.claims.ledger import Ledger
from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import ResultSet
from hknob_cli.results.store import write
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from hknob_cli.stages.sweep.run import SweepStage
from tests import ledger as whole
from tests.conftest import SPEC


@pytest.fixture(scope="module")
def ledger() -> Ledger:
    return whole.ledger()


def test_every_reading_fits_its_computation(ledger: Ledger) -> None:
    """A slip in an argument's name is found here, without any result."""
    for claim in ledger.claims:
        if claim.check:
            for reading in claim.all_readings:
                inspect.signature(known()[claim.check]).bind(None, **{**claim.arguments, **reading.arguments})


def test_an_argument_that_a_computation_lacks_is_a_mistake_of_the_ledger(ledger: Ledger) -> None:
    claim = whole.claim("sec-9.3-constant")
    wrong = claim.model_copy(update={"arguments": {**claim.arguments, "lawn": "green"}, "readings": []})
    with pytest.raises(UsageError, match=r"sec-9.3-constant: law_constant cannot use .*lawn"):
        judge_claim(wrong, ResultSet({}))


def swept(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """A small sweep under the name of another, with constants of the spec replaced."""
    text = SPEC.replace("[1000]", "[1000, 4641.588833612777]").replace("[1024]", "[256, 1024]")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    plan = validate(parse(text, "spec.yaml"))
    stage: Any = SweepStage(plan)
    result = stage.run()
    out = folder / name
    out.mkdir(parents=True)
    provenance = describe(stage="sweep", values=plan.values, overrides=())
    write({out / "cells.parquet": result.cells, out / "orbits.parquet": result.orbits}, provenance)
    return out


def test_a_changed_constant_changes_verdicts(ledger: Ledger, tmp_path: Path) -> None:
    """Twice the damping halves C = 2 K / (pi b), and what the sweep itself shows, so 500 is no longer right."""
    printed = ResultSet({"hand-on-knob": swept(tmp_path, "printed")})
    doubled = ResultSet({"hand-on-knob": swept(tmp_path, "doubled", ("3.45e-4", "6.9e-4"))})
    law, fitted = (whole.claim(name) for name in ("sec-9.3-constant", "sec-9.3-constant-fitted"))
    assert judge_claim(law, printed)["verdict"] == "reproduced"
    assert judge_claim(fitted, printed)["verdict"] in ("reproduced", "differs")
    for claim in (law, fitted):
        row = judge_claim(claim, doubled)
        assert row["verdict"] == "contradicted"
        assert row["computed"] == pytest.approx(0.5 * judge_claim(claim, printed)["computed"], rel=0.2)


def test_a_stiffer_hand_changes_a_verdict(ledger: Ledger, tmp_path: Path) -> None:
    """At 2048 counts a hand of 0.08 N*m/rad carries the push within a count; one of 0.04 does not."""
    claim = whole.claim("sec-6.4.2-table-7")
    stiffer = swept(tmp_path, "firm", ("1024", "2048"), ("0.04", "0.08"))
    light = ResultSet({"stiffer": stiffer, "hand-on-knob": swept(tmp_path, "light", ("1024", "2048"))})
    firm = ResultSet({"stiffer": stiffer, "hand-on-knob": stiffer})
    assert judge_claim(claim, light)["verdict"] == "reproduced"
    assert judge_claim(claim, firm)["verdict"] == "contradicted"


def test_simulations_of_table_7_are_judged_at_its_bias(ledger: Ledger) -> None:
    """No claim has half a count and 0.001 N*m as equals in one place, and only one of them in another."""
    judged = {"abs", "fig"}, ("hand-on-knob",)
    for claim in ledger.claims:
        for reading in claim.readings if claim.id.split("-")[0] in judged[0] else ():
            arguments = {**claim.arguments, **reading.arguments}
            if claim.arguments.get("result") in judged[1] and arguments["result"] == "half-quantum":
                assert reading.excluded or claim.id == "abs-entry-exit", claim.id
