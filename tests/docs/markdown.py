"""Pages as Markdown: where they are, their headings, links, and fenced blocks."""

import re
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt
from markdown_it.token import Token

from tests.conftest import ROOT

DOCS = ROOT / "docs"
ABOVE = [ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "data/README.md")]
PAGES = sorted(DOCS.rglob("*.md"))
_READER = MarkdownIt("commonmark").enable("table")


class Block(NamedTuple):
    """A fenced block: its language, what else its first line says, its text, and its line in the page."""

    language: str
    more: str
    text: str
    line: int


def name_of(page: Path) -> str:
    """A page as a test calls it."""
    return str(page.relative_to(ROOT))


@cache
def tokens(page: Path) -> list[Token]:
    """A page, read once."""
    return _READER.parse(page.read_text(encoding="utf-8"))


def links(page: Path) -> list[str]:
    """Targets of links and pictures, in order."""
    inline = [child for token in tokens(page) for child in token.children or ()]
    return [str(token.attrs[key]) for token in inline for key in ("href", "src") if key in token.attrs]


def anchors(page: Path) -> set[str]:
    """What a link into a page may say after #: of each heading, as GitHub makes it."""
    found: set[str] = set()
    parsed = tokens(page)
    for token, text in pairwise(parsed):
        if token.type == "heading_open":
            spoken = "".join(child.content for child in text.children or ())
            slug = re.sub(r"[^\w\- ]", "", spoken.lower()).replace(" ", "-")
            same = sum(one == slug or re.fullmatch(re.escape(slug) + r"-\d+", one) is not None for one in found)
            found.add(f"{slug}-{same}" if same else slug)
    return found


def blocks(page: Path) -> list[Block]:
    """Every fenced block of a page."""
    fences = [token for token in tokens(page) if token.type == "fence"]
    found = []
    for token in fences:
        language, _, more = token.info.partition(" ")
        found.append(Block(language, more, token.content, (token.map or [0])[0] + 1))
    return found
