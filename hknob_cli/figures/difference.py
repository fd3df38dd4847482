"""One result against another over a grid, in percent of the second (Hasser, Figs 49, 52, 58)."""

from statistics import stdev
from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Row, cell_text, column_label, grid
from hknob_cli.figures.heat import diverging, draw_key, draw_map, height_of
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawing
def grid_difference(
    evidence: ResultSet,
    of: list[str],
    *,
    column: str = "p2p_rad",
    amplitude: bool = False,
    across: str | None = None,
    down: str | None = None,
    at: Row | None = None,
    where: Row | None = None,
    where_second: Row | None = None,
    full_scale: float = 100.0,
) -> "Figure":
    """(first - second) / second of a column, in percent, for two results ``of`` the same grid.

    ``amplitude`` takes half of the first, which sets an amplitude against a peak to peak (the reading that gives the
    printed numbers of Fig. 49); colours end at +- ``full_scale`` percent. ``where`` chooses rows of the first, such as
    a method. For axes see `grid`. Beneath: mean, standard deviation (n - 1), least and largest. Raises `MissingError`.
    """
    from matplotlib.colors import Normalize

    first = grid(evidence[of[0]], across=across, down=down, at=at, where=where, columns=(column,))
    second = grid(evidence[of[1]], across=first.across or None, down=first.down or None, at=at, where=where_second,
                  columns=(column,))  # fmt: skip
    percent = differences(first, second, column, factor=0.5 if amplitude else 1.0)
    texts = [
        [_text(one, other, value, column) for one, other, value in zip(ones, others, line, strict=True)]
        for ones, others, line in zip(first.cells, _aligned(first, second), percent, strict=True)
    ]
    found = [value for line in percent for value in line if value == value]
    if not found:
        raise MissingError(f"'{of[0]}' and '{of[1]}' have no cell in common where both have a limit cycle")
    figure = theme.figure(height_of(first, extra=1.2))
    axes = figure.subplots()
    norm = Normalize(-full_scale, full_scale, clip=True)
    draw_map(axes, first, percent, texts, norm=norm, colours=diverging())
    name = column_label(evidence[of[0]], column)[0].rsplit(", ", 1)[0]
    said = f"amplitude against {name}" if amplitude else name
    draw_key(figure, axes, norm, diverging(), f"{said}: difference, %", below=False)
    mean = _percent(sum(found) / len(found))
    spread = f"mean {mean}, standard deviation {stdev(found):.0f} %, " if len(found) > 1 else ""
    reach = f"from {_percent(min(found))} to {_percent(max(found))}, {len(found)} cells"
    lines = [f"{spread}{reach}"]
    if any("(" in text for line in texts for text in line):
        lines.append("in brackets: outside the domain of the method")
    figure.supxlabel("\n".join(lines), fontsize=8.5)
    return figure


def differences(first: Grid, second: Grid, column: str, *, factor: float = 1.0) -> list[list[float]]:
    """Percent of the second by which ``factor`` times the first differs; not a number where one has no cycle."""
    return [
        [
            100.0 * (factor * a - b) / b
            if (a := _value(one, column)) and (b := _value(other, column))
            else float("nan")
            for one, other in zip(ones, others, strict=True)
        ]
        for ones, others in zip(first.cells, _aligned(first, second), strict=True)
    ]


def _value(cell: Row | None, column: str) -> float | None:
    """A column's value; None where there is none, as in a cell without a cycle."""
    return None if cell is None or cell[column] is None else float(cell[column])


def _aligned(first: Grid, second: Grid) -> list[list[Row | None]]:
    """Cells of the second at the places of the first, whose axis values are the same to 12 digits."""
    there = {_key(second, cell): cell for cell in second.rows}
    return [
        [there.get(tuple(f"{value:.12g}" for value in (d, a) if value is not None)) for a in first.acrosses]
        for d in first.downs
    ]


def _key(cells: Grid, cell: Row) -> tuple[str, ...]:
    return tuple(f"{cell[axis]:.12g}" for axis in (cells.down, cells.across) if axis)


def _text(one: Row | None, other: Row | None, value: float, column: str) -> str:
    if value == value:
        text = _signed(value)
        return f"({text})" if one is not None and one.get("in_domain") is False else text
    for cell in (one, other):
        if cell is not None and not _value(cell, column):
            return cell_text(cell, 0.0, column) if "at_rest_fraction" in cell else "none"
    return ""


def _signed(value: float) -> str:
    return f"{round(value):+d}".replace("-", "\u2212") if round(value) else "0"


def _percent(value: float) -> str:
    return f"{_signed(value)} %"
