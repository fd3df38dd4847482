"""The explore page as text: it needs nothing else, and its policy names exactly what is in it."""

import base64
import hashlib
import json
import re

import pytest

from hknob_cli.page.explore import Knobs, knobs_of, sheet
from hknob_cli.specs.capabilities import PARTS, VERDICTS
from tests.conftest import SPEC, loaded

GRID = SPEC.replace("[1000]", "[500, 1000]").replace("[1024]", "[256, 1024]")


@pytest.fixture(scope="module")
def page() -> str:
    return sheet(knobs_of(loaded(GRID), "spec.yaml"))


def digests(texts: list[str]) -> set[str]:
    return {f"'sha256-{base64.b64encode(hashlib.sha256(one.encode()).digest()).decode()}'" for one in texts}


def test_the_policy_names_what_is_in_the_page_and_nothing_more(page: str) -> None:
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', page)
    assert policy
    rules = dict(part.strip().split(" ", 1) for part in policy[1].replace("&#39;", "'").split(";"))
    assert rules["default-src"] == "'none'"
    assert set(rules["script-src"].split()) == digests(re.findall(r"<script>(.*?)</script>", page, re.DOTALL))
    assert set(rules["style-src"].split()) == digests(re.findall(r"<style>(.*?)</style>", page, re.DOTALL))
    assert len(rules["script-src"].split()) == 3
    assert "unsafe" not in policy[1]


def test_it_loads_nothing(page: str) -> None:
    assert not re.findall(r"https?:|@import|\burl\(|\bfetch\(|XMLHttpRequest|WebSocket|\bimport\(", page)
    assert not re.findall(r'\b(?:src|href)="(?!#)', page)
    assert not re.findall(r"\son\w+=|\sstyle=", page)


def test_every_cell_is_a_scene(page: str) -> None:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    cells = json.loads(found[1])["cells"]
    assert [cell["label"] for cell in cells] == [
        "500 Hz, 256 counts",
        "500 Hz, 1024 counts",
        "1000 Hz, 256 counts",
        "1000 Hz, 1024 counts",
    ]
    assert cells[2]["scene"]["rate"] == 1000.0
    assert cells[2]["scene"]["hand"] == {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}


def test_no_text_ends_its_element(page: str) -> None:
    knobs = Knobs(
        "<b>&name", [{"label": "</script><script>alert(1)", "scene": {}}], ["<i>"], {"title": "", "source": ""}
    )
    text = sheet(knobs)
    assert "alert(1)</script>" not in text
    assert text.count("<script>") == page.count("<script>")
    assert "<b>" not in text.split("<main>")[0]
    assert text.count("</script>") == text.count("<script")
    assert text.count("<!--") == 1


def test_the_table_says_of_each_part_whether_it_is_followed() -> None:
    assert {VERDICTS[part, "explore"] for part in PARTS} == {"E", "-"}
