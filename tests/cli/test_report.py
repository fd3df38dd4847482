"""``hknob report`` through the installed command: pages that list what is on them, pages that do not, and faults."""

import json
import re
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import SPEC

GRID = SPEC.replace("[1000]", "[500, 1000]").replace("[1024]", "[512, 1024]")
PLAIN = "kind: report\nname: page\nresults: [results/small]\n"
VALUE = "{check: cell_statistic, with: {result: mine, column: p2p_rad, statistic: largest}, scale: 1000.0}"
FULL = """\
kind: report
name: page
title: A page
results: {mine: results/small}
claims: claims.yaml
summary:
  - Two cells and more.
  - {text: "Peak to peak up to {most} mrad.", values: {most: VALUE}}
lead: [fig-size]
chapters:
  - title: Size
    text: |
      First.

      Second.
    figures:
      - {id: fig-size, draw: grid_map, of: mine, with: {column: p2p_rad}, title: Size, caption: "What to see."}
      - {id: fig-gone, draw: grid_map, of: other, title: Gone, caption: "Nothing."}
""".replace(
    "VALUE", "{check: cell_statistic, with: {result: mine, column: p2p_rad, statistic: largest}, scale: 1000.0}"
)
CLAIMS = """\
text: a text
claims:
  - id: large
    place: section 1
    says: it is large
    check: cell_statistic
    with: {result: mine, column: p2p_rad, statistic: largest}
    holds: {at_least: 0.001}
    because: a milliradian is large
    figure: fig-size
"""


@pytest.fixture
def swept(hknob, spec_file, tmp_path: Path) -> Path:
    assert hknob("sweep", spec_file(GRID)).returncode == 0
    (tmp_path / "claims.yaml").write_text(CLAIMS)
    return tmp_path


def test_a_list_of_results_is_enough(hknob, spec_file, swept: Path) -> None:
    done = hknob("report", spec_file(PLAIN, "page.yaml"))
    assert done.returncode == 0, done.stderr
    assert "wrote results/page/report.html" in done.stdout
    page = (swept / "results" / "page" / "report.html").read_text()
    assert "small: It buzzes in all 4 cells, from the starts tried. The most: " in page
    assert "<b>4 of 4</b>" in page
    assert page.count("<figure id=") == 2  # size, pitch; means are in brackets
    assert {path.name for path in (swept / "results" / "page").iterdir()} == {"report.html", "figures", ".hknob.lock"}
    assert "up to date" in hknob("report", spec_file(PLAIN, "page.yaml"), "--dry-run").stdout


def test_chapters_sentences_and_claims(hknob, spec_file, swept: Path) -> None:
    done = hknob("report", spec_file(FULL, "page.yaml"), "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["verdicts"]["reproduced"] == 1
    out = swept / "results" / "page"
    page = (out / "report.html").read_text()
    assert re.search(r"Peak to peak up to [\d.]+ mrad\.", page)
    assert "<p>First.</p>" in page
    assert "No picture here: no result &#39;other&#39;" in page
    assert (out / "figures" / "fig-size.svg").read_text().startswith("<!-- hknob report page ")
    assert "no result 'other'" in (out / "figures" / "fig-gone.svg").read_text()
    assert pq.read_table(out / "claims.parquet").column("verdict").to_pylist() == ["reproduced"]


def test_the_same_work_gives_the_same_bytes_and_changes_are_seen(hknob, spec_file, swept: Path) -> None:
    spec = spec_file(FULL, "page.yaml")
    out = swept / "results" / "page"
    hknob("report", spec)
    files = sorted(path for path in out.rglob("*") if path.suffix in {".html", ".svg", ".parquet"})
    before = [path.read_bytes() for path in files]
    hknob("report", spec, "--force")
    assert [path.read_bytes() for path in files] == before
    (out / "figures" / "fig-size.svg").unlink()
    assert json.loads(hknob("report", spec, "--json").stdout)["status"] == "computed"
    assert [path.read_bytes() for path in files] == before
    (swept / "claims.yaml").write_text(CLAIMS.replace("0.001", "1.0"))
    assert json.loads(hknob("report", spec, "--json").stdout)["verdicts"]["contradicted"] == 1


def test_figures_of_an_earlier_page_go_and_foreign_ones_are_refused(hknob, spec_file, swept: Path) -> None:
    figures = swept / "results" / "page" / "figures"
    hknob("report", spec_file(FULL, "page.yaml"))
    assert hknob("report", spec_file(FULL.replace("fig-gone", "fig-else"), "page.yaml")).returncode == 0
    assert {path.name for path in figures.iterdir()} == {"fig-size.svg", "fig-else.svg"}
    (figures / "mine.svg").write_text("<svg/>")
    refused = hknob("report", spec_file(FULL, "page.yaml"))
    assert (refused.returncode, "mine.svg: not written by hknob" in refused.stderr) == (3, True)
    (figures / "mine.svg").unlink()
    (swept / "results" / "page" / "report.html").write_text("<p>mine</p>")
    refused = hknob("report", spec_file(FULL, "page.yaml"), "--force")
    assert (refused.returncode, "report.html: not written by hknob" in refused.stderr) == (3, True)


def test_a_page_that_is_no_text_any_more_is_made_anew(hknob, spec_file, swept: Path) -> None:
    page = swept / "results" / "list" / "report.html"
    spec = spec_file("kind: report\nname: list\nresults: {mine: results/small}\n", "page.yaml")
    assert hknob("report", spec).returncode == 0
    whole = page.read_bytes()
    page.write_bytes(whole[:-20] + b"\xff" + whole[-20:])
    done = hknob("report", spec)
    said = "results/list/report.html: is not as it was written: damaged, or changed; it is made again\n"
    assert (done.returncode, done.stderr) == (0, said)
    assert page.read_bytes() == whole


def test_results_beside_the_spec_are_noticed(hknob, tmp_path: Path) -> None:
    """Folders of results begin where the command runs; a reader may expect them to begin at the spec."""
    for folder in ("mine", "results"):
        (tmp_path / folder).mkdir()
    (tmp_path / "results" / "cells.parquet").write_bytes(b"")
    (tmp_path / "mine" / "page.yaml").write_text("kind: report\nname: page\ntitle: One\nresults: [../results]\n")
    done = hknob("report", "mine/page.yaml")
    assert done.returncode == 2
    said = (
        "results: ../results has no tables; run the stage 'results' first; its path begins at the working folder, and "
    )
    assert done.stderr == f"{said}mine/../results has tables\n"


BAD = {
    "no results": ("results: {mine: results/small}", "results: {}", "results: must have at least 1 item"),
    "no such folder": (
        "results/small",
        "results/none",
        "results: results/none has no tables; run the stage 'mine' first",
    ),
    "no such name": ("results/small", f"results/{'x' * 300}", "xxx: File name too long"),
    "no ledger": ("claims.yaml", "nowhere.yaml", "nowhere.yaml: No such file"),
    "unknown drawing": (
        "draw: grid_map, of: mine",
        "draw: gridmap, of: mine",
        "figures[0].draw: must be '",
    ),
    "same id": ("fig-gone", "fig-size", "chapters[0].figures[1].id: must be unique, got 'fig-size' again"),
    "id": ("id: fig-size", "id: top", "chapters[0].figures[0].id: must match pattern"),
    "lead": ("lead: [fig-size]", "lead: [fig-other]", "lead[0]: must be the id of a figure, got 'fig-other'"),
    "no value": ("{most} mrad", "{least} mrad", "summary[1]: 'least' has no value"),
    "open brace": ("{most} mrad", "{most mrad", "summary[1]: must be text with {names}"),
    "unknown check": ("check: cell_statistic", "check: cell_statistics", "did you mean 'cell_statistic'?"),
    "unknown check of two lines": (
        "check: cell_statistic",
        'check: "a\\nb\\e[2J"',
        "page.yaml:8:5: summary[1]: most: unknown check 'a?b?[2J'; allowed: ",
    ),
    "unknown argument of two lines": (
        "statistic: largest",
        '"a\\nb": largest',
        "page.yaml:8:5: summary[1]: most: cell_statistic: unknown argument 'a?b'; allowed: ",
    ),
    "wrong argument": (
        "statistic: largest",
        "statistics: largest",
        "unknown argument 'statistics'; did you",
    ),
    "no argument": (
        ", column: p2p_rad, statistic",
        ", statistic",
        "page.yaml:8:5: summary[1]: most: cell_statistic: needs",
    ),
    "wrong statistic": ("statistic: largest", "statistic: middle", "summary[1]: most: "),
    "odd value": ("statistic: largest", "statistic: [1]", "summary[1]: most: "),
    "wrong option": (
        "with: {column: p2p_rad}",
        "with: {colum: red}",
        "page.yaml:17:9: chapters[0].figures[0]: grid_map: ",
    ),
    "odd option": (
        "with: {column: p2p_rad}",
        "with: {scale: [1]}",
        "chapters[0].figures[0]: grid_map of",
    ),
    "of nothing": (
        "of: mine, with: {column: p2p_rad}",
        "of: []",
        "chapters[0].figures[0]: grid_map of",
    ),
    "attribute": ("{most} mrad", "{most.__class__} mrad", "must have {names} of letters, digits and '_' only"),
    "conversion": ("{most} mrad", "{most!r} mrad", "must have {names} of letters, digits and '_' only"),
    "its own folder": ("results/small", "results/page", "results/page is where the report itself goes"),
    "ghost": ("lead: [fig-size]\nchapters:", "lead: [fig-size]\nnothing:", "nothing: unknown key"),
    "unknown key": ("title: A page", "titel: A page", "titel: unknown key; did you mean 'title'?"),
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", BAD)
def test_bad_reports(hknob, spec_file, swept: Path, name: str) -> None:
    old, new, wanted = BAD[name]
    assert old in FULL
    done = hknob("report", spec_file(FULL.replace(old, new), "page.yaml"))
    assert done.returncode == 2, done.stderr
    assert wanted in done.stderr
    assert "Traceback" not in done.stderr
    assert not (swept / "results" / "page").exists()
