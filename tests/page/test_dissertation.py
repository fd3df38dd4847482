"""The dissertation's page, built from nothing by its pipeline: complete, in time, and sound in a real browser."""

import json
import re
import subprocess
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.pipeline.one_claim import claims_of
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.load import load_pipeline
from tests.conftest import EXPERIMENTS, HKNOB, ROOT
from tests.page.opened import PHONE, WIDE, Opened

pytestmark = pytest.mark.long

PIPELINE = EXPERIMENTS / "dissertation.yaml"


def run(out: Path, *more: str) -> dict[str, Any]:
    done = subprocess.run(
        [HKNOB, "run", PIPELINE, "-o", out, "--json", *more], capture_output=True, text=True, check=False, timeout=900
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("paper") / "dissertation"
    run(out)
    return out


def test_it_is_complete(paper: Path) -> None:
    page = (paper / "report" / "report.html").read_text()
    assert len(page.encode()) <= 3_000_000
    assert page.count("<audio ") == 4
    assert "No picture here" not in page
    figures = set(re.findall(r'<figure id="([^"]+)"', page))
    assert len(figures) >= 60
    assert {path.stem for path in (paper / "report" / "figures").glob("*.svg")} == figures
    assert not [path for path in (paper / "report" / "figures").glob("*.svg") if path.stat().st_size < 1000]


def test_the_docs_count_the_claims_as_they_are_judged(paper: Path) -> None:
    counts = Counter(row["verdict"] for row in pq.read_table(paper / "report" / "claims.parquet").to_pylist())
    numbers = {str(number) for number in (counts.total(), *counts.values())}
    places = (("README.md", "checked claims of the dissertation"), ("docs/explanation/dissertation.md", "Now "))
    for name, line in places:
        said = next(one for one in (ROOT / name).read_text().splitlines() if line in one)
        assert set(re.findall(r"\b\d{2,}\b", said)) == numbers, (name, counts)


def test_every_claim_has_a_verdict_and_every_figure_it_names_is_there(paper: Path) -> None:
    rows = pq.read_table(paper / "report" / "claims.parquet").to_pylist()
    page = (paper / "report" / "report.html").read_text()
    assert len(rows) >= 80
    assert {row["verdict"] for row in rows} == {"reproduced", "differs", "contradicted", "not testable"}
    for row in rows:
        assert (row["verdict"] == "not testable") == (row["check"] == ""), row["claim"]
        assert (row["computed"] is None) == (row["verdict"] == "not testable"), row["claim"]
        assert not row["figure"] or f'<figure id="{row["figure"]}"' in page, row["claim"]


def test_every_claim_names_what_its_check_reads(paper: Path) -> None:
    """With those results alone that ``--claim`` would make, each claim has the row of the page."""
    rows = {row["claim"]: row for row in pq.read_table(paper / "report" / "claims.parquet").to_pylist()}
    claims = claims_of(load_pipeline(PIPELINE), paper)
    assert {one.claim.id for one in claims} == set(rows)
    for one in claims:
        alone = ResultSet({name: one.folders[name] for name in one.results})
        assert judge_claim(one.claim, alone) == rows[one.claim.id]


def test_a_second_run_does_nothing(paper: Path) -> None:
    stamps = {path: path.stat().st_mtime_ns for path in paper.rglob("*") if path.is_file()}
    begin = time.perf_counter()
    stages = run(paper)["stages"]
    assert time.perf_counter() - begin < 10.0  # generous: tests/benchmarks/startup.py has the ratio
    assert {stage["status"] for stage in stages} == {"up to date"}
    assert {path: path.stat().st_mtime_ns for path in paper.rglob("*") if path.is_file()} == stamps


def test_a_changed_constant_changes_verdicts(paper: Path, tmp_path: Path) -> None:
    before = {row["claim"]: row["verdict"] for row in pq.read_table(paper / "report" / "claims.parquet").to_pylist()}
    changed = run(
        paper,
        "--set",
        "stages.hand-on-knob.set.scene.hand.damping=6.9e-4",
        "--set",
        "stages.predict.set.scene.hand.damping=6.9e-4",
    )
    computed = {stage["name"] for stage in changed["stages"] if stage["status"] == "computed"}
    assert computed == {"hand-on-knob", "predict", "predict-500", "report"}
    after = {row["claim"]: row["verdict"] for row in pq.read_table(paper / "report" / "claims.parquet").to_pylist()}
    assert before["sec-9.3-constant"] == "reproduced"
    assert after["sec-9.3-constant"] == "contradicted"
    assert sum(before[claim] != after[claim] for claim in before) >= 2
    run(paper)
    again = {row["claim"]: row["verdict"] for row in pq.read_table(paper / "report" / "claims.parquet").to_pylist()}
    assert again == before


@pytest.mark.parametrize(("viewport", "scheme"), [(WIDE, "light"), (PHONE, "dark")], ids=["wide", "phone"])
def test_in_a_browser(paper: Path, browser: Any, scheme: str, viewport: dict[str, int]) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe()
    address = (paper / "report" / "report.html").as_uri()
    with Opened(browser, address, color_scheme=scheme, viewport=viewport) as opened:
        tab = opened.tab
        assert {url for url in opened.asked if not url.startswith("data:")} == {address}
        found = axe.run(tab).response["violations"]
        assert not [violation["id"] for violation in found if violation["impact"] in ("serious", "critical")]
        whole = opened.unfold().tab.inner_text("#claims-count")
        drawn = tab.eval_on_selector_all(
            ".ink > svg", "all => all.map(one => Math.min(one.getBBox().width, one.getBBox().height))"
        )
        assert len(drawn) >= 60
        assert min(drawn) > 20
        tab.get_by_label("contradicted").check()
        assert tab.inner_text("#claims-count") != whole
        verdicts = tab.locator("#claims tbody:not([hidden]) .verdict").all_inner_texts()
        assert {text.split()[0] for text in verdicts} == {"contradicted"}
        tab.get_by_role("button", name="Show all").click()
        assert tab.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        found = axe.run(tab).response["violations"]
        assert not [violation["id"] for violation in found if violation["impact"] in ("serious", "critical")]
        assert opened.said == []
