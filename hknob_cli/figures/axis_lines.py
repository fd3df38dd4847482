"""Size and pitch of the cells over the one axis that varies: a line for each method or law, or for each of a sweep."""

from math import nan
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.cell_series import Cells, Series, cells_of
from hknob_cli.figures.grid import axis_label
from hknob_cli.figures.numbers import is_geometric, tick_labels
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FEW = 10  # values of the axis that have a tick each


@drawing
def axis_lines(evidence: ResultSet, of: str, *, column: str | None = None) -> "Figure":
    """Peak to peak (mrad) and frequency (Hz) over the axis that varies, or one ``column``; a line a series.

    Series are the methods or laws of an analysis, with the sweep that it is compared with, or of a sweep the largest
    attractor and the mean. Of several cycles of a method in a cell the line has the largest. A cell at rest is at 0;
    outside a method's domain a line is thin. Raises `MissingError` where no axis varies, or several do.
    """
    result = evidence[of]
    cells = cells_of(result, column=column)
    if len(cells.wide) != 1:
        raise MissingError(f"'{of}' varies over {', '.join(cells.wide) or 'nothing'}, not over one axis")
    over = cells.wide[0]
    figure = theme.figure(2.1 * len(cells.panels) + 0.8)
    panels = figure.subplots(len(cells.panels), 1, sharex=True, squeeze=False)[:, 0]
    for i, one in enumerate(cells.series):
        _draw(list(panels), one, over, i)
    _finish(list(panels), cells, over, axis_label(result, over), signed=column is not None)
    if len(cells.series) > 1:
        handles, texts = panels[0].get_legend_handles_labels()
        figure.legend(handles, texts, loc="outside upper left", ncols=min(5, len(texts)), handlelength=3.0)
    return figure


def _draw(panels: "list[Axes]", series: Series, over: str, index: int) -> None:
    best: dict[Any, tuple[float | None, ...]] = {}
    for point in series.points:
        known = best.get(point.row[over])
        if known is None or (point.values[0] or 0.0) > (known[0] or 0.0):
            best[point.row[over]] = point.values
    outside = {point.row[over] for point in series.points if series.by_domain and not point.row["in_domain"]}
    style = theme.series(index) | {"marker": theme.MARKERS[index % len(theme.MARKERS)], "markersize": 4.5}
    for i, panel in enumerate(panels):
        shown = [(x, y) for x, values in sorted(best.items()) if (y := values[i]) is not None]
        if i:  # at rest there is no pitch
            shown = [(x, y) for x, y in shown if y]
        xs, ys = [x for x, _ in shown], [y for _, y in shown]
        if outside:
            panel.plot(xs, ys, **{**theme.series(index), "linewidth": 0.7, "alpha": 0.6})
            ys = [nan if x in outside else y for x, y in shown]
        panel.plot(xs, ys, label=series.name or None, **style)


def _finish(panels: "list[Axes]", cells: Cells, over: str, label: str, *, signed: bool) -> None:
    values = sorted({point.row[over] for one in cells.series for point in one.points})
    for panel, name in zip(panels, cells.panels, strict=True):
        panel.set_ylabel(name)
        panel.margins(y=0.12)
        if not any(line.get_xdata().size for line in panel.lines):  # type: ignore[union-attr]
            panel.text(0.5, 0.5, "no limit cycle in any cell", ha="center", transform=panel.transAxes)
            panel.set_yticks([])
        elif not signed:
            panel.set_ylim(0.0, max(panel.get_ylim()[1], 1e-12))
    if values[0] > 0 and is_geometric(values):
        panels[-1].set_xscale("log")
    if len(values) <= _FEW:
        panels[-1].set_xticks(values, tick_labels(values))
        panels[-1].set_xticks([], minor=True)
    panels[-1].set_xlabel(label)
