"""Numbers in rows and columns, for the terminal."""

from collections.abc import Callable
from math import prod
from typing import Any

from hknob_cli.report.table import grid

MAX_ROWS = 60  # of a table on the terminal

Mark = Callable[[dict[str, Any]], str]


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
