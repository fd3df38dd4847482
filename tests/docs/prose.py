"""Pages in plain English: proselint's rules, and those of the house (`house_style`).

Looks at what a reader reads as sentences: code, console blocks and addresses are left out. ``make lint`` and ``make
test`` run it over files and folders. Each finding is one line, ``FILE:LINE: rule: what is wrong``.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt
from proselint.checks import __register__ as built_in
from proselint.config import DEFAULT, Config
from proselint.registry import CheckRegistry
from proselint.tools import LintFile

from .house_style import CODE, END, LINK, OFF, RULES, off_in

_READER = MarkdownIt("commonmark").enable("table")
_SPOKEN = {"softbreak": "\n", "hardbreak": "\n", "code_inline": CODE, "image": "", "html_inline": ""}
_SPOKEN |= {"link_open": LINK[0], "link_close": LINK[1]}
_MANY = 10_000  # findings of a page


class Finding(NamedTuple):
    """What is wrong in a page: its line, the rule, and the rule's words."""

    line: int
    rule: str
    message: str


def prose(page: str) -> Iterator[tuple[int, str]]:
    """Lines of a page as they are read, each with its line in the page; `END` after each block."""
    yield 0, END
    for token in _READER.parse(page):
        if token.type == "inline":
            spoken = "".join(_SPOKEN.get(part.type, part.content) for part in token.children or ())
            yield from enumerate(spoken.split("\n"), start=(token.map or [0])[0] + 1)
            yield 0, END


def findings(page: str, off: tuple[str, ...] = ()) -> list[Finding]:
    """All that the rules find in a page, line by line; ``off`` are rules that do not hold there."""
    lines = list(prose(page))
    numbers = [number for number, _ in lines]
    text = "\n".join(line for _, line in lines)
    silent = dict.fromkeys((*OFF, *off), False)
    checks = silent | DEFAULT["checks"] | {"house": True} | silent  # the first that names a rule decides
    found = []
    for result in LintFile("page", text).lint(Config(max_errors=_MANY, checks=checks)):
        path, message, (start, end), _ = result.check_result
        # Proselint puts an empty line above the text.
        first = start + len(wanted := f"\n{text}\n"[start:end]) - len(wanted.lstrip())
        found.append(Finding(numbers[f"\n{text}\n".count("\n", 0, first) - 1], path, message.replace("\n", " ")))
    return sorted(found)


def main(places: list[str]) -> int:
    """Print what is wrong in files and folders; 1 where anything is."""
    bad = 0
    for place in map(Path, places):
        for page in sorted(place.rglob("*.md")) if place.is_dir() else [place]:
            for line, rule, message in findings(page.read_text(encoding="utf-8"), off_in(page.as_posix())):
                print(f"{page}:{line}: {rule}: {message}")
                bad += 1
    return int(bad > 0)


CheckRegistry().register_many((*built_in, *RULES))

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
