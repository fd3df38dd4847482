"""A text's table of contents on its page: read whole from Markdown, and refused where it has no places."""

from pathlib import Path

import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.page.book import Place
from hknob_cli.page.compose import read_contents
from hknob_cli.specs.load import load
from tests.conftest import ROOT

TEXT = """\
# A text

| place | what it is | where it is here |
|---|---|---|
| 0 | before any section | nowhere |

## Chapter 1: Sizes

| place | what it is | where it is here |
|---|---|---|
| **1** | Sizes &#124; pitches | claims: `a-b`, `c`. |
| Figure 1 | A picture | Not built: a photograph. |

## Nothing here
"""


def test_sections_have_their_places(tmp_path: Path) -> None:
    path = tmp_path / "contents.md"
    path.write_text(TEXT, encoding="utf-8")
    (part,) = read_contents(path)
    names = (("claims: ", False), ("a-b", True), (", ", False), ("c", True), (".", False))
    assert part.title == "Chapter 1: Sizes"
    assert part.places == (
        Place("1", "Sizes | pitches", names, heads=True),
        Place("Figure 1", "A picture", (("Not built: a photograph.", False),), heads=False),
    )


def test_of_the_dissertation_no_place_is_lost() -> None:
    path = ROOT / "docs" / "reference" / "contents.md"
    rows = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    parts = read_contents(path)
    assert sum(len(part.places) for part in parts) == len(rows) - len(parts) > 200
    assert {"Abstract", "Chapter 7: Limit Cycle Prediction"} & {part.title for part in parts}


def test_a_file_without_places_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "contents.md"
    path.write_text("# A text\n\n## A section\n\nWords.\n", encoding="utf-8")
    with pytest.raises(UsageError, match="has no section with a table of places"):
        read_contents(path)


def test_a_file_that_is_not_there_is_a_fault_of_the_spec(tmp_path: Path) -> None:
    spec = tmp_path / "page.yaml"
    spec.write_text("kind: report\nname: page\nresults: [here]\ncontents: gone.md\n", encoding="utf-8")
    with pytest.raises(SpecError, match=r"page.yaml:4:11: contents: .*gone.md"):
        load(spec, ())
