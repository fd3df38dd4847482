"""A page of docs/ as sentences and tables, to hold computed numbers against."""

import re

from tests.conftest import ROOT


def page(name: str) -> str:
    """Text of a page, every run of white space one space."""
    return re.sub(r"\s+", " ", (ROOT / "docs" / name).read_text(encoding="utf-8"))


def says(name: str, *sentences: str) -> None:
    """Assert that a page has each of these sentences, whose numbers the caller has computed."""
    text = page(name)
    missing = [sentence for sentence in sentences if sentence not in text]
    assert not missing, f"docs/{name} does not say: " + " | ".join(missing)


def table(name: str, heading: str) -> list[list[str]]:
    """Cells of the first table after a heading or a sentence, row by row, its head left out."""
    lines = (ROOT / "docs" / name).read_text(encoding="utf-8").split(heading, 1)[1].splitlines()
    rows: list[list[str]] = []
    for line in lines:
        if line.lstrip().startswith("|"):
            rows.append([cell.strip() for cell in line.strip().strip("|").split("|")])
        elif rows:
            break
    return rows[2:]


def agrees(printed: str, computed: float) -> bool:
    """Whether a printed number is the computed one, rounded to the digits that are printed."""
    text = printed.replace("\u2212", "-")
    decimals = len(text.partition(".")[2])
    return abs(float(text) - computed) <= 0.5 * 10.0**-decimals * (1.0 + 1e-6)
