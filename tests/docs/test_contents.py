"""The dissertation's table of contents: complete, every row answered, and what it names exists."""

import runpy
from typing import Any

import pytest

from hknob_cli.specs import source
from tests.conftest import EXPERIMENTS, ROOT

LISTED = ROOT / "data" / "contents.yaml"
MAKE = ROOT / "docs" / "make" / "contents.py"


@pytest.fixture(scope="module")
def made() -> dict[str, Any]:
    return runpy.run_path(str(MAKE))


@pytest.fixture(scope="module")
def found(made: dict[str, Any]) -> list[Any]:
    return made["rows"]()


@pytest.fixture(scope="module")
def made_page(made: dict[str, Any]) -> str:
    return made["page"]()


@pytest.fixture
def listed() -> dict[str, Any]:
    return source.read(LISTED).value


def numbers(rows: list[dict[str, Any]], kind: str) -> list[int]:
    return [int(row["id"].removeprefix(kind)) for row in rows if row["id"].startswith(kind)]


def test_nothing_of_the_text_is_left_out(listed: dict[str, Any]) -> None:
    assert numbers(listed["figures"], "Figure ") == list(range(1, 98))
    assert numbers(listed["tables"], "Table ") == list(range(1, 11))
    assert numbers(listed["equations"], "Equation ") == [1, 2]
    sections = [row["id"] for row in listed["sections"]]
    assert [int(one) for one in sections if one.isdigit()] == list(range(1, 13))
    assert [one for one in sections if one.isalpha()] == ["abstract", "A", "B", "C", "D"]
    for one in (
        section for section in sections if "," not in section
    ):  # each after the one before it: 4.2.3 needs 4.2.2, and 4.2
        head, _, last = one.rpartition(".")
        assert not head or head in sections
        assert not head or last == "1" or f"{head}.{int(last) - 1}" in sections
    ids = [row["id"] for kind in ("sections", "figures", "tables", "equations") for row in listed[kind]]
    assert len(ids) == len(set(ids))
    assert {row["section"] for kind in ("figures", "tables", "equations") for row in listed[kind]} <= set(sections)


def test_every_row_has_an_answer(found: list[Any], made_page: str) -> None:
    for row in found:
        assert any(row.where) or row.reason or row.parts, row.id
        assert bool(row.lacks) == bool(row.reason), row.id
    cells = [line.split("|")[3].strip() for line in made_page.splitlines() if line.startswith("| ")]
    assert len(cells) == len(found) + sum(row.id == row.section and "." not in row.id for row in found)
    assert all(cells)


def test_page_is_current(made_page: str) -> None:
    assert (ROOT / "docs" / "reference" / "contents.md").read_text(encoding="utf-8") == made_page, "make schemas"


def test_what_it_names_exists(found: list[Any]) -> None:
    report = (EXPERIMENTS / "dissertation_report.yaml").read_text()
    ledger = (ROOT / "data" / "claims.yaml").read_text()
    for row in found:
        for kind, name in row.where.experiments:
            assert f"\nkind: {kind}\n" in (EXPERIMENTS / f"{name}.yaml").read_text(), row.id
        for file in row.where.files:
            assert (ROOT / file).is_file(), row.id
        for figure in row.where.figures:
            assert f"- id: {figure}\n" in report, row.id
        for claim in row.where.claims:
            assert f"- id: {claim.id}\n" in ledger, row.id


ONE_MORE = {"section": "D", "title": "A figure that the text does not have"}


def change(listed: dict[str, Any], kind: str, name: str, **keys: Any) -> None:
    row = next((row for row in listed[kind] if row["id"] == name), {"id": name})
    if row not in listed[kind]:
        listed[kind].append(row)
    for key, value in keys.items():
        row.pop(key, None) if value is None else row.update({key: value})


@pytest.mark.parametrize(
    ("kind", "name", "keys", "said"),
    [
        ("sections", "6.4.2", {"not_built": "no time"}, "6.4.2: .*'not_built', but it is there: .*hand_on_knob"),
        ("sections", "1.1", {"nothing": None}, "1.1: nothing names it"),
        ("figures", "Figure 98", {**ONE_MORE}, "Figure 98: nothing names it"),
        ("figures", "Figure 98", {**ONE_MORE, "by": ["sec-9.3-constant"]}, "Figure 98: no figure of the page draws it"),
        ("figures", "Figure 35", {"id": "Figure 98"}, "Figure 35, which data/contents.yaml does not have"),
        ("equations", "Equation 1", {"by": None}, "Equation 1: docstrings alone name it"),
        ("equations", "9.3(b)", {"by": ["sec-9.3-lawn"]}, "'sec-9.3-lawn'"),
        ("equations", "9.3(b)", {"by": ["hknob_cli.theory.laws:lawn"]}, "hknob_cli.theory.laws:lawn"),
    ],
)
def test_a_row_that_does_not_fit_is_refused(
    listed: dict[str, Any], made: dict[str, Any], kind: str, name: str, keys: dict[str, Any], said: str
) -> None:
    change(listed, kind, name, **keys)
    with pytest.raises(ValueError, match=said):
        made["rows"](listed)
