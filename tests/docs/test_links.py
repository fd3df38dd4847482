"""Pages lead somewhere: links, pictures and anchors exist, every page is in the site's menu."""

import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tests.conftest import ROOT

from .markdown import ABOVE, DOCS, PAGES, anchors, links, name_of

OURS = re.compile(
    r"(?<![\w/.-])((?:docs|experiments|data|tests|schemas)/[\w./-]+\.(?:md|yaml|csv|py|pl|txt|json|png|svg))\b"
)
MADE = re.compile(r"hknob_cli/[\w/]+\.(?:py|c|h)\b")


@pytest.mark.parametrize("page", [*ABOVE, *PAGES], ids=name_of)
def test_links_lead_somewhere(page: Path) -> None:
    wrong = []
    for link in links(page):
        if re.match(r"https?:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists():
            wrong.append(f"{link}: no such file")
        elif anchor and anchor not in anchors(target):
            wrong.append(f"{link}: no such heading")
    assert not wrong


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_pages_of_the_site_link_to_pages_of_the_site(page: Path) -> None:
    """What lies outside docs/ is not in the site: it is named, not linked."""
    local = [link.partition("#")[0] for link in links(page) if not re.match(r"https?:", link)]
    assert all((page.parent / path).resolve().is_relative_to(DOCS) for path in local)


@pytest.mark.parametrize("page", [*ABOVE, *PAGES], ids=name_of)
def test_files_that_are_named_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    named = {*OURS.findall(text), *MADE.findall(text)}
    example = re.compile(r"NAME|KIND|SUBJECT")  # for a name of the reader's
    assert not [path for path in sorted(named) if not (ROOT / path).exists() and not example.search(path)]


def test_files_that_the_program_names_exist() -> None:
    """Messages, docstrings, comments and specs that send a reader to a page."""
    places = [ROOT / name for name in ("Makefile", "mkdocs.yml", "pyproject.toml")]
    for folder in ("hknob_cli", "experiments", "tests", "schemas", "data"):
        kinds = (".py", ".c", ".h", ".pl", ".yaml", ".json", ".txt")
        places += [path for path in (ROOT / folder).rglob("*") if path.suffix in kinds]
    wrong = []
    for path in places:
        text = path.read_text(encoding="utf-8", errors="replace")
        wrong += [f"{path}: {page}" for page in re.findall(r"docs/[\w/]+\.md\b", text) if not (ROOT / page).exists()]
    assert not wrong


def _menu(node: object) -> list[str]:
    if isinstance(node, str):
        return [node]
    inner = node if isinstance(node, list) else list(node.values()) if isinstance(node, dict) else []
    return [page for one in inner for page in _menu(one)]


def test_every_page_is_in_the_menu_once() -> None:
    site = YAML(typ="safe").load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert sorted(_menu(site["nav"])) == [str(page.relative_to(DOCS)) for page in PAGES]
    assert (DOCS / site["extra"]["polyfills"][0]).exists()


def test_every_picture_is_shown() -> None:
    shown = {(page.parent / link).resolve() for page in [*ABOVE, *PAGES] for link in links(page)}
    assert not [path.name for path in (DOCS / "pictures").iterdir() if path.resolve() not in shown]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_lists_begin_after_an_empty_line(page: Path) -> None:
    """Else the site's Markdown shows them as part of the paragraph before."""
    lines, fenced, wrong = page.read_text(encoding="utf-8").splitlines(), False, []
    for before, line in zip(["", *lines], lines, strict=False):
        fenced ^= line.lstrip().startswith("```")
        item = re.match(r"\s*(?:[-*]|\d+\.) ", line)
        if item and not fenced and before.strip() and not re.match(r"\s*(?:[-*]|\d+\.) |\s{2,}\S", before):
            wrong.append(line)
    assert not wrong
