"""One result against another over a grid: in percent, as a ratio, one cause after another (Hasser, Figs 49, 52, 55-59).

Without and with what the simulations left out: two maps on one scale and their ratio (Hasser, Figs 55-59).

What explains what: pitch and size of campaigns over the simulated ones, one cause switched on at a time.
"""

from statistics import stdev
from typing import TYPE_CHECKING

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Layout, Row, cell_text, column_label, grid, notes
from hknob_cli.figures.heat import diverging, draw_key, draw_map, height_of, norm_of, ramp
from hknob_cli.figures.numbers import log_ticks, number
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BESIDE = 5  # columns up to which the maps stand side by side, else below each other
Printed = dict[str, float]
_PANELS = (("frequency_hz", "pitch over the simulated"), ("p2p_rad", "peak to peak over the simulated"))
_SPREAD = 0.2  # of dots about their row


@drawing
def grid_difference(
    evidence: ResultSet,
    of: list[str],
    *,
    column: str = "p2p_rad",
    amplitude: bool = False,
    layout: Layout,
    where: Row | None = None,
    where_second: Row | None = None,
    full_scale: float = 100.0,
) -> "Figure":
    """(first - second) / second of a column, in percent, for two results ``of`` the same grid.

    ``amplitude`` takes half of the first, which sets an amplitude against a peak to peak (the reading that gives the
    printed numbers of Fig. 49); colours end at +- ``full_scale`` percent. ``where`` chooses rows of the first, such as
    a method. Beneath: mean, standard deviation (n - 1), least and largest. Raises `MissingError`.
    """
    from matplotlib.colors import Normalize

    first = grid(evidence[of[0]], layout, where=where, columns=(column,))
    same = Layout(first.across or None, first.down or None, layout.at)
    second = grid(evidence[of[1]], same, where=where_second, columns=(column,))
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
    """A column's value; None if there is none, as in a cell without a cycle."""
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


@drawing
def hardware_grid(
    evidence: ResultSet,
    of: list[str],
    *,
    column: str = "p2p_rad",
    names: tuple[str, str] = ("without friction", "with friction"),
    digits: int = 3,
) -> "Figure":
    """Maps of a column of two results ``of`` the same grid, and the second over the first, as a factor.

    Beneath: the mean factor and its range, over the cells where both cycle. Raises `MissingError`.
    """
    from matplotlib.colors import LogNorm

    results = [evidence[name] for name in of]
    grids = [grid(result, columns=(column,)) for result in results]
    name, factor = column_label(results[0], column)
    values = [one.values(column, factor) for one in grids]
    norm = norm_of([value for one in values for line in one for value in line], log=True)
    ratio = [[1.0 + value / 100.0 for value in line] for line in differences(grids[1], grids[0], column)]
    tall = len(grids[0].acrosses) > _BESIDE
    figure = theme.figure(3.0 * height_of(grids[0], extra=0.9) if tall else height_of(grids[0], extra=1.65))
    panels = figure.subplots(3, 1) if tall else figure.subplots(1, 3)
    for i in (0, 1):
        texts = [
            [cell_text(cell, value, column, digits) for cell, value in zip(*line, strict=True)]
            for line in zip(grids[i].cells, values[i], strict=True)
        ]
        draw_map(panels[i], grids[i], values[i], texts, norm=norm, colours=ramp(), left=tall or i == 0)
        panels[i].set_title(names[i])
    found = [value for line in ratio for value in line if value == value]
    reach = max([4.0, *(max(value, 1.0 / value) for value in found if value > 0)])
    scale = LogNorm(1.0 / reach, reach)
    texts = [["" if value != value else f"\u00d7 {number(value, 2)}" for value in line] for line in ratio]
    draw_map(panels[2], grids[0], ratio, texts, norm=scale, colours=diverging(), left=tall)
    panels[2].set_title("the second over the first")
    draw_key(figure, list(panels[:2]), norm, ramp(), name, below=not tall)
    draw_key(figure, panels[2], scale, diverging(), "factor", below=not tall, most=4)
    said = [notes(grids, column)]
    if found:
        mean = number(sum(found) / len(found), 2)
        said.append(f"factor: mean {mean}, from {number(min(found), 2)} to {number(max(found), 2)}, {len(found)} cells")
    figure.supxlabel(";  ".join(filter(None, said)), fontsize=8)
    return figure


@drawing
def what_explains(
    evidence: ResultSet,
    of: list[str],
    *,
    over: str,
    names: list[str] | None = None,
    printed: dict[str, Printed] | None = None,
) -> "Figure":
    """Campaigns ``of`` one grid over the sweep ``over``, cell by cell, a row a campaign: dots, and their mean as a bar.

    Cells where both buzz; at the right how many of the campaign's do. Shape and height of a dot in its row tell the
    resolution, from the coarsest (low) to the finest. ``printed``: by column, `mean` (a line), and `least` and
    `largest` (a band). Raises `MissingError`.
    """
    reference = grid(evidence[over], columns=tuple(column for column, _ in _PANELS))
    drawn = theme.figure(0.72 * len(of) + 1.25)
    panels = drawn.subplots(1, 2, sharey=True)
    grids = [grid(evidence[name], columns=tuple(column for column, _ in _PANELS)) for name in of]
    for panel, (column, label) in zip(panels, _PANELS, strict=True):
        _draw_printed(panel, (printed or {}).get(column))
        for y, one in zip(range(len(of) - 1, -1, -1), grids, strict=True):
            ratios = [[1.0 + value / 100.0 for value in line] for line in differences(one, reference, column)]
            if not any(value == value for line in ratios for value in line):
                raise MissingError(f"'{of[len(of) - 1 - y]}' and '{over}' have no cell in common where both buzz")
            _draw_row(panel, y, ratios)
        panel.axvline(1.0, color="black", linewidth=0.8)
        panel.set_xscale("log")
        panel.set_xticks(*log_ticks(*panel.get_xlim()))
        panel.set_xticks([], minor=True)
        panel.set_xlabel(label)
        panel.set_ylim(-0.6, len(of) - 0.25)
    said = names or of
    panels[0].set_yticks(range(len(of)), list(reversed(said)), fontsize=8)
    for y, one in zip(range(len(of) - 1, -1, -1), grids, strict=True):
        buzzing = sum(cell["at_rest_fraction"] < 1.0 for cell in one.rows)
        panels[1].text(1.02, y, f"{buzzing} of {len(one.rows)}\nbuzz", va="center", fontsize=8,
                       transform=panels[1].get_yaxis_transform())  # fmt: skip
    for i, count in enumerate(reference.downs):
        panels[0].plot([], [], markersize=4.5, label=f"{count:g}", **theme.points(i))
    drawn.legend(loc="outside upper center", ncols=len(reference.downs) + 1, title="counts per revolution")
    return drawn


def _draw_printed(panel: "Axes", printed: Printed | None) -> None:
    if printed and "least" in printed and "largest" in printed:
        panel.axvspan(printed["least"], printed["largest"], color=theme.COLOURS[1], alpha=0.13, linewidth=0)
    if printed and "mean" in printed:
        panel.axvline(printed["mean"], color=theme.COLOURS[1], linestyle="--", linewidth=1.2)
        panel.text(printed["mean"], 1.0, " printed", transform=panel.get_xaxis_transform(), fontsize=8, va="bottom",
                   ha="center", color=theme.COLOURS[1])  # fmt: skip


def _draw_row(panel: "Axes", y: int, ratios: list[list[float]]) -> None:
    """Dots of one campaign by resolution, from below, and the mean of all."""
    heights = np.linspace(-_SPREAD, _SPREAD, len(ratios)) if len(ratios) > 1 else [0.0]
    for i, (line, height) in enumerate(zip(ratios, heights, strict=True)):
        found = [value for value in line if value == value]
        panel.plot(found, [y + height] * len(found), markersize=4.5, **theme.points(i))
    every = [value for line in ratios for value in line if value == value]
    mean = sum(every) / len(every)
    panel.plot([mean, mean], [y - 0.28, y + 0.28], color="black", linewidth=2.2, solid_capstyle="butt")
    panel.text(mean, y + 0.3, number(mean), ha="center", va="bottom", fontsize=8)
