"""Every cell of a result over any number of axes, and the people of a population: how many have at most so much.

People: how many of a population have at most so large a limit cycle, and so high a pitch, cells as lines.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of, axis_label, axis_name, nearest_rows, rows_of
from hknob_cli.figures.heat import colour_map
from hknob_cli.figures.lines import Cells, Point, cells_of, place_of
from hknob_cli.figures.numbers import tick_labels
from hknob_cli.figures.sheet import save, write_sheet
from hknob_cli.report.large import by_cell, describe_people, pitches, sizes
from hknob_cli.report.table import is_whole
from hknob_cli.results.result_set import Held, MissingError, ResultSet
from hknob_cli.specs.plan import PERSON

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CURVES = 7

MOST = 30  # cells that have a row of their own
_WIDE = 30.0  # largest over least value, from which a scale is logarithmic


@drawing
def population(evidence: ResultSet, of: str, *, at: Row | None = None, height: float = 3.4) -> "Figure":
    """Cumulative distribution over people of peak to peak and of frequency, a line for each cell.

    ``at`` gives values of axes, the nearest of which are taken. Both are of a person's largest cycle: peak to peak of
    all people, 0 at rest; frequency of those for whom the knob buzzes. If there are many cells, a few are drawn. Raises
    `MissingError` where the result has no population.
    """
    result = evidence[of]
    rows = rows_of(result)
    axes = axes_of(result, rows)
    if PERSON not in axes:
        raise MissingError(f"'{of}' is a sweep of one hand, not of a population")
    for axis in at or {}:
        if axis not in axes:
            raise MissingError(f"'{of}' has no axis {axis}; it has {', '.join(axes)}")
    rows = nearest_rows(rows, at)
    wide = [axis for axis in axes if axis != PERSON and len({row[axis] for row in rows}) > 1]
    cells = thinned(by_cell(rows, axes))
    names = [tick_labels([cell[axis] for cell, _ in cells]) for axis in wide]
    figure = theme.figure(height)
    left, right = figure.subplots(1, 2, sharey=True)
    for i, (_, people) in enumerate(cells):
        label = ", ".join(texts[i] for texts in names) or None
        for panel, values, scale in ((left, sizes(people), 1e3), (right, pitches(people), 1.0)):
            xs, ys = cumulative(values, scale) if values else ([], [])
            panel.step(xs, ys, where="post", label=label if panel is left else None, **theme.series(i))
    left.set_ylabel("people who have at most this, %")
    left.set_xlabel("peak to peak, mrad (0: at rest)")
    right.set_xlabel("frequency, Hz, where it buzzes")
    for panel in (left, right):
        panel.set_ylim(0.0, 101.0)
    if wide:
        title = ", ".join(axis_label(result, axis) for axis in wide)
        figure.legend(title=title, loc="outside upper center", ncols=min(len(cells), 4), handlelength=3.2)
    return figure


def thinned(cells: list[tuple[Row, list[Row]]]) -> list[tuple[Row, list[Row]]]:
    """Cells spread over all, few enough to tell apart as curves; the first and the last among them."""
    last, most = len(cells) - 1, MOST_CURVES - 1
    return cells if last <= most else [cells[round(i * last / most)] for i in range(MOST_CURVES)]


def cumulative(values: list[float], scale: float) -> tuple[list[float], list[float]]:
    """Corners of the steps of the distribution of ordered values: values times ``scale``, and % that have at most it.

    A curve starts at 0 % at the least value, so that people who share it show as an upright line.
    """
    parts = [100.0 * (i + 1) / len(values) for i in range(len(values))]
    return [scale * value for value in values[:1] + values], [0.0, *parts]


@drawing
def cell_dots(evidence: ResultSet, of: str, *, column: str | None = None) -> "Figure":
    """Peak to peak (mrad) and frequency (Hz) of every cell, or one ``column``; a marker a series.

    Up to 30 cells have a row each. For more the figure shows how many of them, in per cent, have at most so large a
    value. A cell at rest is at 0, or, on a logarithmic scale, left of a line. Series are as in `axis_lines`. Raises
    `MissingError` for a result without cells.
    """
    result = evidence[of]
    cells = cells_of(result, column=column)
    places = list(dict.fromkeys(_place(point, cells) for one in cells.series for point in one.points))
    if not places:
        raise MissingError(f"'{of}' has no cells")
    draw = _rows if len(places) <= MOST else _shares
    figure = draw(cells, places, signed=column is not None)
    if len(cells.series) > 1:
        handles, texts = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, texts, loc="outside upper left", ncols=min(5, len(texts)), handlelength=2.4)
    return figure


def _place(point: Point, cells: Cells) -> tuple[Any, ...]:
    return tuple(point.row[axis] for axis in cells.wide)


def _rows(cells: Cells, places: list[tuple[Any, ...]], *, signed: bool) -> "Figure":
    """A row a cell, the first uppermost."""
    figure = theme.figure(max(1.4, 0.24 * len(places) + 1.1))
    panels = figure.subplots(1, len(cells.panels), sharey=True, squeeze=False)[0]
    at = {place: len(places) - 1 - i for i, place in enumerate(places)}
    lift = 0.5 / len(cells.series)
    for number, panel in enumerate(panels):
        rest = None if signed else _scale(panel, cells, number)
        for i, one in enumerate(cells.series):
            shift = (0.5 * (len(cells.series) - 1) - i) * lift
            shown = _valued(one.points, number, signed=signed)
            xs = [value or rest or 0.0 for _, value in shown]
            ys = [at[_place(point, cells)] + shift for point, _ in shown]
            panel.plot(xs, ys, label=one.name or None, **theme.points(i), markersize=5.0)
        if signed and all(value >= 0.0 for one in cells.series for point in one.points if (value := point.values[0])):
            panel.set_xlim(left=0.0)
        panel.set_xlabel(cells.panels[number] + ("\n(left of the line: at rest)" if rest is not None else ""))
        panel.set_ylim(-0.7, len(places) - 0.3)
        if _say_none(panel, len(cells.series)):
            panel.set_xticks([])
    first = {_place(point, cells): point.row for one in cells.series for point in one.points}
    names = [place_of(first[place], cells.wide or cells.axes[:2]) for place in places]
    panels[0].set_yticks([at[place] for place in places], names, fontsize=7.5)
    return figure


def _valued(points: list[Point], number: int, *, signed: bool) -> list[tuple[Point, float]]:
    """Points that have a value on the panel of a number; the pitch of a cell at rest, which is 0, is none."""
    found = [(point, point.values[number]) for point in points]
    return [(point, value) for point, value in found if value is not None and (value or number == 0 or signed)]


def _say_none(panel: "Axes", series: int) -> bool:
    """Write "none" into a panel whose series are empty, and tell whether it is one."""
    import numpy as np

    empty = not any(np.size(line.get_xdata()) for line in panel.lines[:series])
    if empty:
        panel.text(0.5, 0.5, "none", ha="center", va="center", transform=panel.transAxes)
    return empty


def _scale(panel: "Axes", cells: Cells, number: int) -> float | None:
    """Scale of the values from 0, or a logarithmic one; on that, where rest is drawn, if any cell is at rest."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    values = [point.values[number] for one in cells.series for point in one.points]
    some = [value for value in values if value]
    if not some or max(some) < _WIDE * min(some):
        panel.set_xlim(0.0 if some else -0.05, 1.12 * max(some, default=0.9))
        panel.margins(x=0.1)
        if any(value == 0.0 for value in values):
            panel.set_xlim(left=-0.05 * max(some, default=1.0))
        return None
    panel.set_xscale("log")
    panel.xaxis.set_major_locator(LogLocator(subs=(1.0,) if max(some) > 80.0 * min(some) else (1.0, 2.0, 5.0)))
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    panel.xaxis.set_minor_formatter(NullFormatter())
    if number or 0.0 not in values:
        return None
    panel.axvline(0.6 * min(some), color="black", linewidth=0.6, alpha=0.5)
    return 0.4 * min(some)


def _shares(cells: Cells, places: list[tuple[Any, ...]], *, signed: bool) -> "Figure":
    """How many of the cells have at most so large a value."""
    figure = theme.figure(3.4)
    panels = figure.subplots(1, len(cells.panels), sharey=True, squeeze=False)[0]
    for number, panel in enumerate(panels):
        for i, one in enumerate(cells.series):
            values = sorted(value for _, value in _valued(one.points, number, signed=signed))
            xs, ys = cumulative(values, 1.0) if values else ([], [])
            panel.step(xs, ys, where="post", label=one.name or None, **theme.series(i))
        panel.set_xlabel(cells.panels[number])
        panel.set_ylim(0.0, 101.0)
        _say_none(panel, len(cells.series))
    panels[0].set_ylabel(f"of the {len(places):,} cells at most this, %")
    return figure


def draw_population(cells: list[Row], axes: list[str], *, title: str, path: Path) -> bool:
    """Draw into ``path`` (PNG): maps over two axes, else curves; False, drawing nothing, without a grid of so few.

    Raises `ComputationError` if the file cannot be written.
    """
    from hknob_cli.figures.defaults import figures_of

    axes = [axis for axis in axes if axis != PERSON]
    wide = [axis for axis in axes if len({row[axis] for row in cells}) > 1]
    if len(wide) > 2 or not is_whole(cells, wide):
        return False
    fixed = ", ".join(f"{axis} = {cells[0][axis]:g}" for axis in axes if axis not in wide)
    from matplotlib.figure import Figure

    if len(wide) < 2:
        result = Held(title, "sweep", {"cells": pa.Table.from_pylist(cells)}, [*axes, PERSON])
        return write_sheet(result, figures_of(result), path=path)
    figure = Figure(figsize=(13.5, 0.52 * len({row[wide[0]] for row in cells}) + 2.6), layout="constrained")
    _maps(figure, describe_people(cells, axes), wide)
    people = len({row[PERSON] for row in cells})
    figure.suptitle(f"{title}: limit cycles of {people} people" + (f"  ({fixed})" if fixed else ""))
    save(figure, path, stage="sweep", name=title)
    return True


def _maps(figure: "Figure", rows: list[Row], wide: list[str]) -> None:
    down, across = wide
    downs, acrosses = (sorted({row[axis] for row in rows}) for axis in wide)
    grid = {(row[down], row[across]): row for row in rows}
    left, right = figure.subplots(1, 2, sharey=True)
    panels: tuple[tuple[Axes, str, float, str, tuple[float, float] | None], ...] = (
        (left, "buzzing_fraction", 100.0, "people for whom the knob buzzes, %", (0.0, 100.0)),
        (right, "p2p_max_rad_p95", 1e3, "peak to peak, mrad: 95 % of the people have less", None),
    )
    for axes, column, scale, label, limits in panels:
        table: Any = [[grid[d, a][column] for a in acrosses] for d in downs]
        values = np.array([[np.nan if value is None else scale * value for value in line] for line in table])
        inks = colour_map(axes, values, label, limits=limits)
        axes.set_xticks(range(len(acrosses)), [f"{value:.6g}" for value in acrosses], rotation=30, ha="right")
        axes.set_xlabel(axis_name(across))
        for i, j in np.ndindex(*values.shape) if len(rows) <= 400 else ():
            text = "" if np.isnan(values[i, j]) else f"{values[i, j]:.3g}"
            axes.text(j, i, text, ha="center", va="center", fontsize=8, color=inks[i][j])
    left.set_yticks(range(len(downs)), [f"{float(f'{value:.4g}'):g}" for value in downs])
    left.set_ylabel(axis_name(down))
