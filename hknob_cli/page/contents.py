"""A text's table of contents beside its claims: a page in Markdown, of which a section each has a table of places."""

import re
from html import unescape
from pathlib import Path

from hknob_cli.errors import UsageError
from hknob_cli.page.book import Part, Place
from hknob_cli.specs.named_file import read_named

_HEADING = re.compile(r"^## (.+)$")
_CELLS = 3  # place, what it is, where it is here


def read_contents(path: Path) -> tuple[Part, ...]:
    """The sections of a file, each with the rows of its table. Raises `UsageError` where there is no such row."""
    parts: list[tuple[str, list[Place]]] = []
    for line in read_named(path).decode("utf-8", "replace").splitlines():
        if heading := _HEADING.match(line):
            parts.append((heading[1].strip(), []))
        elif parts and line.startswith("| ") and (place := _place(line)):
            parts[-1][1].append(place)
    found = tuple(Part(title, tuple(places)) for title, places in parts if places)
    if not found:
        raise UsageError(f"{path}: has no section with a table of places: | place | what it is | where it is here |")
    return found


def _place(line: str) -> Place | None:
    cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
    if len(cells) != _CELLS or cells[0] == "place":
        return None
    name, title, where = (unescape(cell) for cell in cells)
    pieces = tuple((piece, place % 2 == 1) for place, piece in enumerate(where.split("`")) if piece)
    return Place(name.strip("*"), title, pieces, name.startswith("**"))
