"""Every cell of a result over any number of axes: a row a cell, or of many cells how many have at most so much."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.cell_series import Cells, Point, cells_of, place_of
from hknob_cli.figures.population import cumulative
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 30  # cells that have a row of their own
_WIDE = 30.0  # largest over least value, from which a scale is logarithmic


@drawing
def cell_dots(evidence: ResultSet, of: str, *, column: str | None = None) -> "Figure":
    """Peak to peak (mrad) and frequency (Hz) of every cell, or one ``column``; a marker a series.

    Up to 30 cells have a row each. Of more the figure shows how many of them, in per cent, have at most so large a
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
            shown = [(point.values[number], at[_place(point, cells)] + shift) for point in one.points]
            shown = [(x, y) for x, y in shown if x is not None and (x or number == 0 or signed)]
            xs = [x if x or rest is None else rest for x, _ in shown]
            panel.plot(xs, [y for _, y in shown], label=one.name or None, **theme.points(i), markersize=5.0)
        if signed and all(value >= 0.0 for one in cells.series for point in one.points if (value := point.values[0])):
            panel.set_xlim(left=0.0)
        panel.set_xlabel(cells.panels[number] + ("\n(left of the line: at rest)" if rest is not None else ""))
        panel.set_ylim(-0.7, len(places) - 0.3)
        if not any(line.get_xdata().size for line in panel.lines[: len(cells.series)]):
            panel.text(0.5, 0.5, "none", ha="center", va="center", transform=panel.transAxes)
            panel.set_xticks([])
    first = {_place(point, cells): point.row for one in cells.series for point in one.points}
    names = [place_of(first[place], cells.wide or cells.axes[:2]) for place in places]
    panels[0].set_yticks([at[place] for place in places], names, fontsize=7.5)
    return figure


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
            known = [point.values[number] for point in one.points if point.values[number] is not None]
            values = sorted(value for value in known if value is not None and (value or number == 0 or signed))
            xs, ys = cumulative(values, 1.0) if values else ([], [])
            panel.step(xs, ys, where="post", label=one.name or None, **theme.series(i))
        panel.set_xlabel(cells.panels[number])
        panel.set_ylim(0.0, 101.0)
        if not any(line.get_xdata().size for line in panel.lines):
            panel.text(0.5, 0.5, "none", ha="center", va="center", transform=panel.transAxes)
    panels[0].set_ylabel(f"of the {len(places):,} cells at most this, %")
    return figure
