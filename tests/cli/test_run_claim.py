"""``hknob run --claim``: one claim of a pipeline's page, judged as on the page, by the stages that it needs alone."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import SPEC

PIPELINE = """\
kind: pipeline
name: text
stages:
  slow: {spec: sweep.yaml}
  fast: {spec: sweep.yaml, set: {grid.sample_rate_hz: [4000]}}
  other: {spec: sweep.yaml, set: {starts.phases: 4}}
  page: {spec: page.yaml, set: {results: {from: all}}}
"""
PAGE = "kind: report\nname: page\nresults: [results/small]\nclaims: claims.yaml\n"
CLAIMS = """\
text: a text
claims:
  - id: size-at-1-khz
    place: sec. 6.4, Figure 35
    says: the buzz is larger than a milliradian
    printed: 0.003
    unit: rad
    check: cell_statistic
    with: {result: slow, column: p2p_rad, statistic: largest}
    holds: {within: 0.001}
    near: {within: 0.002}
    because: the text says about
    finding: it is.
  - id: ratio
    place: sec. 6.4
    says: at four times the rate the buzz is four times smaller
    check: cell_statistic
    with: {column: p2p_rad, statistic: largest}
    readings:
      - {name: faster, with: {result: fast}}
      - {name: slower, with: {result: slow}, excluded: the text means the faster one}
    holds: {at_most: 1.0e-9}
    because: nothing is that small
  - {id: history, place: sec. 1, says: knobs are old, untestable: it is no matter of computing}
"""


@pytest.fixture
def pipeline(tmp_path: Path) -> Path:
    for name, text in (("sweep", SPEC), ("page", PAGE), ("claims", CLAIMS), ("text", PIPELINE)):
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path / "text.yaml"


def of(hknob, pipeline: Path, asked: str) -> dict:
    done = hknob("run", pipeline, "--claim", asked, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_claim_needs_its_results_alone_and_is_judged_as_on_the_page(hknob, pipeline: Path, tmp_path: Path) -> None:
    found = {name: of(hknob, pipeline, name) for name in ("size-at-1-khz", "ratio", "history")}
    assert [stage["name"] for stage in found["size-at-1-khz"]["stages"]] == ["slow"]
    assert {stage["name"]: stage["status"] for stage in found["ratio"]["stages"]} == {
        "fast": "computed",
        "slow": "up to date",
    }
    assert found["history"]["stages"] == []
    assert not (tmp_path / "results" / "text" / "other").exists()
    whole = hknob("run", pipeline, "--json")
    assert {stage["name"]: stage["status"] for stage in json.loads(whole.stdout)["stages"]} == {
        "slow": "up to date",
        "fast": "up to date",
        "other": "computed",
        "page": "computed",
    }
    rows = pq.read_table(tmp_path / "results/text/page/claims.parquet").to_pylist()
    assert [one["claim"] for one in found.values()] == rows
    assert [row["verdict"] for row in rows] == ["reproduced", "contradicted", "not testable"]
    # The record of the whole run is not replaced by that of a part.
    of(hknob, pipeline, "ratio")
    again = json.loads(hknob("run", pipeline, "--json").stdout)
    assert {stage["status"] for stage in again["stages"]} == {"up to date"}


def test_the_verdict_comes_first(hknob, pipeline: Path) -> None:
    done = hknob("run", pipeline, "--claim", "size-at-1-khz")
    computed = pq.read_table(pipeline.parent / "results/text/slow/cells.parquet").column("p2p_rad")[0].as_py()
    lines = done.stdout.splitlines()
    assert lines[0] == f"Reproduced: computed {computed:.4g} rad, printed 0.003 rad."
    assert "The rule: reproduced: within 0.001; differs: within 0.002 (the text says about)" in lines
    assert lines[-2:] == ["results: results/text/slow", f"next: hknob run {pipeline}"]
    assert done.stderr.startswith("size-at-1-khz: needs slow\n")
    two = hknob("run", pipeline, "--claim", "ratio").stdout
    assert two.startswith("Contradicted: computed ")
    assert "contradicted (not allowed: the text means the" in " ".join(two.split())
    none = hknob("run", pipeline, "--claim", "history")
    assert none.stdout.startswith("Not testable: it is no matter of computing.\n")


def test_a_place_or_words_find_a_claim(hknob, pipeline: Path) -> None:
    assert of(hknob, pipeline, "Figure 35")["claim"]["claim"] == "size-at-1-khz"
    assert of(hknob, pipeline, "old knobs")["claim"]["claim"] == "history"
    assert of(hknob, pipeline, "four times the speed")["claim"]["claim"] == "ratio"
    several = hknob("run", pipeline, "--claim", "6.4")
    assert several.returncode == 2
    assert several.stderr.splitlines() == [
        "--claim: 2 claims answer to '6.4'; choose one:",
        "  size-at-1-khz (sec. 6.4, Figure 35): the buzz is larger than a milliradian",
        "  ratio (sec. 6.4): at four times the rate the buzz is four times smaller",
    ]


def test_faults(hknob, pipeline: Path, tmp_path: Path) -> None:
    none = hknob("run", pipeline, "--claim", "raito")
    assert none.returncode == 2
    assert "no claim has the id 'raito'" in none.stderr
    assert "did you mean 'ratio'?" in none.stderr
    both = hknob("run", pipeline, "--claim", "ratio", "--until", "slow")
    assert (both.returncode, both.stderr) == (2, "--claim: names the stages to run itself; leave --until out\n")
    (tmp_path / "page.yaml").write_text(PAGE.replace("claims: claims.yaml\n", ""))
    without = hknob("run", pipeline, "--claim", "ratio")
    assert without.returncode == 2
    assert without.stderr == "--claim: no stage of 'text' is a report that names a ledger under claims\n"
    assert not (tmp_path / "results").exists()
