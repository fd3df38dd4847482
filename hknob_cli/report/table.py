"""Tables and text as wide as the terminal: columns are left for a second table, or rows and columns exchanged.

A terminal breaks what is too wide wherever it ends, in the middle of a number, too. Nothing here is broken but between
words.

Numbers in rows and columns, for the terminal.
"""

import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from math import ceil, prod
from textwrap import wrap
from typing import Any

LEAST, MOST = 40, 400  # columns that are believed of a terminal
NO_TERMINAL = 80
_GAP = 2  # between columns
_LEAST_FLOW = 24  # of a column of text
_LEAST_CELL = 8  # of a grid, where there is room

_TIED = "\u00a0±\u00a0"

Rows = Sequence[Sequence[str]]

MAX_ROWS = 60  # of a table on the terminal
Mark = Callable[[dict[str, Any]], str]


def columns() -> int:
    """Width to write for: $COLUMNS, else of the terminal that any standard stream is, else 80."""
    try:
        given = int(os.environ.get("COLUMNS", ""))
    except ValueError:
        given = 0
    if given > 0:
        return min(max(given, LEAST), MOST)
    for stream in (sys.stdout, sys.stderr, sys.stdin):  # of `hknob ... | less` stdout is none, stderr is
        try:
            found = os.get_terminal_size(stream.fileno()).columns
        except (OSError, ValueError, AttributeError):
            continue
        if found > 0:
            return min(max(found, LEAST), MOST)
    return NO_TERMINAL


def folded(text: str, width: int | None = None) -> str:
    """A text whose lines are no wider than the terminal: broken between words, what follows indented by two more."""
    room = width or columns()
    return "\n".join(part for line in text.split("\n") for part in _folded(line, room))


def _folded(line: str, room: int) -> list[str]:
    if len(line) <= room:
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    whole = line.replace(" ± ", _TIED)  # a value stays with its deviation
    parts = wrap(whole, room, subsequent_indent=f"{indent}  ", break_long_words=False, break_on_hyphens=False)
    return [part.replace(_TIED, " ± ") for part in parts]


def table(
    heads: Sequence[str],
    rows: Rows,
    *,
    left: Collection[int] = (),
    keys: int = 1,
    flow: int | None = None,
    width: int | None = None,
) -> list[str]:
    """Lines of a table, its columns flush right but those of ``left``.

    Where it is too wide, the text of column ``flow`` is broken between words; else few rows become columns; else the
    columns after the first ``keys`` are given to several tables, each of which begins with the keys.
    """
    room = width or columns()
    lines = [list(heads), *(list(row) for row in rows)]
    if _total(lines) <= room:
        return _aligned(lines, left)
    if flow is not None and room - _total(_without(lines, flow)) - _GAP >= _LEAST_FLOW:
        return _flowed(lines, flow, room, left)
    turned = [list(column) for column in zip(*lines, strict=True)]
    if len(rows) <= len(heads) and _total(turned) <= room:
        return _aligned(turned, {0})
    found: list[str] = []
    for some in _blocks(lines, keys, room):
        chosen = [*range(keys), *some]
        block = [[line[i] for i in chosen] for line in lines]
        found += [""] if found else []
        if _total(block) <= room:
            found += _aligned(block, {chosen.index(i) for i in left if i in chosen})
        elif flow in chosen and room - _total(_without(block, chosen.index(flow))) - _GAP >= _LEAST_FLOW:
            found += _flowed(block, chosen.index(flow), room, {chosen.index(i) for i in left if i in chosen})
        else:
            found += _listed(block, room)
    return found


def grid(
    title: str,
    down: str,
    across: str,
    names: Sequence[str],
    heads: Sequence[str],
    cells: Rows,
    width: int | None = None,
) -> list[str]:
    """Lines of a table over two axes, ``down`` with ``names`` and ``across`` with ``heads``.

    Where it is too wide, rows and columns are exchanged if that fits, else the columns are given to several tables.
    """
    room = width or columns()
    turned = [list(column) for column in zip(*cells, strict=True)]
    one, other = _Grid(down, across, names, heads, cells), _Grid(across, down, heads, names, turned)
    if one.width > room >= other.width:
        return [title, *other.lines(range(len(names)))]
    each = max(1, (room - one.left) // one.cell)
    each = ceil(len(heads) / ceil(len(heads) / each)) if heads else 1
    found = [title]
    for start in range(0, len(heads), each):
        found += one.lines(range(start, min(start + each, len(heads))))
    return found


class _Grid:
    """A table over two axes, in one of its two ways round."""

    def __init__(self, down: str, across: str, names: Sequence[str], heads: Sequence[str], cells: Rows) -> None:
        self.down, self.across, self.names, self.heads, self.cells = down, across, names, heads, cells
        self.left = max(len(down), *(len(name) for name in names))
        self.cell = max(
            _LEAST_CELL,
            *(len(head) + 1 for head in heads),
            *(len(cell) + 1 for line in cells for cell in line),
        )
        self.width = self.left + len(heads) * self.cell

    def lines(self, some: range) -> Iterator[str]:
        """Lines with some of the columns."""
        yield f"{self.down:<{self.left}}  {self.across}"
        yield " " * self.left + "".join(f"{self.heads[i]:>{self.cell}}" for i in some)
        for name, line in zip(self.names, self.cells, strict=True):
            yield f"{name:>{self.left}}" + "".join(f"{line[i]:>{self.cell}}" for i in some)


def _total(lines: Rows) -> int:
    widths = [max(len(text) for text in column) for column in zip(*lines, strict=True)]
    return sum(widths) + _GAP * (len(widths) - 1)


def _aligned(lines: Rows, left: Collection[int]) -> list[str]:
    widths = [max(len(text) for text in column) for column in zip(*lines, strict=True)]
    gap = " " * _GAP
    return [
        gap.join(
            f"{text:<{width}}" if i in left else f"{text:>{width}}"
            for i, (text, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    ]


def _without(lines: Rows, column: int) -> list[list[str]]:
    return [[*line[:column], *line[column + 1 :]] for line in lines]


def _flowed(lines: Rows, flow: int, room: int, left: Collection[int]) -> list[str]:
    """Lines of a table whose text in one column is broken between words, so that all fit."""
    wide = room - _total(_without(lines, flow)) - _GAP
    return _aligned([part for line in lines for part in _flowing(line, flow, wide)], left)


def _flowing(line: Sequence[str], flow: int, room: int) -> Iterator[list[str]]:
    """A line whose text in one column is broken between words, the other columns empty below the first."""
    parts = wrap(line[flow], room, break_long_words=False, break_on_hyphens=False) or [""]
    for i, part in enumerate(parts):
        yield [part if column == flow else text if i == 0 else "" for column, text in enumerate(line)]


def _blocks(lines: Rows, keys: int, room: int) -> Iterator[list[int]]:
    """Columns after the keys, as many at a time as fit beside these, at least one."""
    some: list[int] = []
    for i in range(keys, len(lines[0])):
        if some and _total([[line[j] for j in (*range(keys), *some, i)] for line in lines]) > room:
            yield some
            some = []
        some.append(i)
    if some:
        yield some


def _listed(lines: Rows, room: int) -> Iterator[str]:
    """Each row as lines of a head and its value, where not even two columns fit."""
    heads, *rows = lines
    for row in rows:
        for head, text in zip(heads, row, strict=True):
            yield from _folded(f"{head}: {text}" if head else text, room) if text else ()


def short(value: float | None, digits: int = 4) -> str:
    """A number for a table; a dash for none."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < 1e7 else text


def matrix(
    rows: list[dict[str, Any]], axes: list[str], column: str, *, scale: float, title: str, mark: Mark = lambda _row: ""
) -> list[str]:
    """Lines of a table of one column over two axes, times ``scale``, each value followed by its row's ``mark``."""
    down, across = axes
    heads = list(dict.fromkeys(row[across] for row in rows))
    table: dict[Any, dict[Any, str]] = {}
    for row in rows:
        value = row[column]
        table.setdefault(row[down], {})[row[across]] = short(None if value is None else scale * value) + mark(row)
    cells = [[line.get(head, "-") for head in heads] for line in table.values()]
    return grid(title, down, across, labels(list(table)), labels(heads), cells)


def labels(values: list[float | int]) -> list[str]:
    """Axis values in as few digits as tell them apart, at least four."""
    for digits in range(4, 17):
        texts = [short(value, digits) for value in values]
        if len(set(texts)) == len(set(values)):
            return texts
    return [repr(value) for value in values]


def fits(rows: list[dict[str, Any]], axes: list[str]) -> bool:
    """Whether there is a table over two axes, and small enough to read on a terminal."""
    down, across = (len({row[axis] for row in rows}) for axis in axes)
    return down <= MAX_ROWS and across <= 24 and is_whole(rows, axes)


def is_whole(rows: list[dict[str, Any]], axes: list[str]) -> bool:
    """Whether there are rows for every combination of axis values, as there are not of a design."""
    return len({tuple(row[axis] for axis in axes) for row in rows}) == prod(
        len({row[axis] for row in rows}) for axis in axes
    )
