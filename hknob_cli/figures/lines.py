"""Lines of a column over one axis, one a value of the other, or their mean (Hasser, Figs 30, 34, 39, 40, 66)."""

from math import sqrt
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Layout, LinesLayout, Measure, Row, column_label, grid
from hknob_cli.figures.numbers import log_ticks, number, tick_labels
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_MEANS = 10  # whose values are written above
_WIDE = 8.0  # span of an axis from which a logarithmic scale is of use
Points = list[tuple[float, float, Row]]


class Style(NamedTuple):
    """How lines are drawn.

    ``log``: the axes that are logarithmic, of "x" and "y". ``mean_over``: the mean of the lines, with its values, and
    the cells faint behind. ``values`` are written beside their points, where there is room. ``error``: column of a
    standard deviation, over the root of the column ``trials`` if given.
    """

    log: str = "xy"
    mean_over: bool = False
    values: bool = False
    error: str | None = None
    trials: str | None = None


@drawing
def grid_lines(
    evidence: ResultSet,
    of: str,
    *,
    measure: Measure,
    layout: LinesLayout,
    where: Row | None = None,
    style: Style,
    height: float = 3.4,
) -> "Figure":
    """A column over one axis, a line for each value of another.

    ``where`` chooses rows, such as those of a method; ``height`` in inches. A value not above 0 on a logarithmic axis
    is hollow, at its size. Raises `MissingError`.
    """
    result, column = evidence[of], measure.column
    needed = tuple(filter(None, (column, style.error, style.trials)))
    cells = grid(result, Layout(*layout), where=where, columns=needed)
    name, factor = column_label(result, *measure)
    table = cells.values(column, factor)
    if not any(value == value for line in table for value in line):
        raise MissingError(f"'{of}' has no value of {column}")
    figure = theme.figure(height)
    axes = figure.subplots()
    _scales(axes, cells, style.log)
    series = [_points(cells, line, table[i]) for i, line in enumerate(cells.cells)]
    log = "y" in style.log
    if style.mean_over:
        _mean(axes, series, log=log)
    else:
        for i, (points, text) in enumerate(zip(series, tick_labels(cells.downs), strict=True)):
            _line(axes, points, i, text, style, factor)
    axes.set_xlabel(cells.names[0])
    axes.set_ylabel(name)
    axes.margins(x=0.07)
    if log:
        axes.set_yticks(*log_ticks(*axes.get_ylim()))
        axes.set_yticks([], minor=True)
    if not log and all(y >= 0 for points in series for _, y, _ in points):
        axes.set_ylim(bottom=0.0)
    if style.values and not style.mean_over:
        _write(axes, series, room=0.13 / (height - 0.7))
    if log and any(y < 0 for points in series for _, y, _ in points):
        figure.supxlabel("hollow: the value is negative, its size is shown", fontsize=8)
    if cells.down and (len(cells.downs) > 1 or style.mean_over):
        figure.legend(title=fill(cells.names[1], 20) if not style.mean_over else None, loc="outside right upper",
                      handlelength=3.2)  # fmt: skip
    return figure


def _scales(axes: "Axes", cells: Grid, log: str) -> None:
    """Scales, and ticks at the values of the axis where they are few."""
    xs = [value for value in cells.acrosses if value is not None]
    if "x" in log and xs and min(xs) > 0 and max(xs) >= _WIDE * min(xs):
        axes.set_xscale("log")
    if 0 < len(xs) <= 10:
        axes.set_xticks(xs, tick_labels(xs))
        axes.set_xticks([], minor=True)
    if "y" in log:
        axes.set_yscale("log")


def _points(cells: Grid, line: list[Row | None], values: list[float]) -> Points:
    xs = [0.0 if value is None else float(value) for value in cells.acrosses]
    return [(x, y, cell) for x, y, cell in zip(xs, values, line, strict=True) if cell is not None and y == y]


def _line(axes: "Axes", points: Points, index: int, text: str, style: Style, factor: float) -> None:
    log = "y" in style.log
    sure = [point for point in points if point[1] > 0 or not log]
    xs, ys = [x for x, _, _ in sure], [y for _, y, _ in sure]
    marker = theme.points(index)["marker"]
    axes.plot(xs, ys, marker=marker, markersize=4.5, label=text, **theme.series(index))
    if style.error is not None:
        counts = [cell[style.trials] if style.trials else 1 for *_, cell in sure]
        errors = [cell[style.error] or 0.0 for *_, cell in sure]
        size = [factor * error / sqrt(max(1, count)) for error, count in zip(errors, counts, strict=True)]
        below = [min(one, 0.9 * y) if log else one for one, (_, y, _) in zip(size, sure, strict=True)]
        colour = theme.series(index)["color"]
        axes.errorbar(xs, ys, yerr=[below, size], linestyle="none", color=colour, capsize=2, elinewidth=0.8)
    rest = [point for point in points if point[1] < 0 and log]
    if rest:
        hollow = {**theme.points(index), "markerfacecolor": "none"}
        axes.plot([x for x, _, _ in rest], [-y for _, y, _ in rest], markersize=4.5, **hollow)


def _write(axes: "Axes", series: list[Points], *, room: float) -> None:
    """Values right of and above their points, except for those with another point less than ``room`` above.

    ``room`` is a part of the axes' height.
    """
    axes.autoscale_view()
    to_axes = axes.transData + axes.transAxes.inverted()
    for x in dict.fromkeys(x for points in series for x, _, _ in points):
        ys = [y for points in series for at, y, _ in points if at == x and (y > 0 or axes.get_yscale() != "log")]
        places = [float(to_axes.transform((x, y))[1]) for y in ys]
        for y, place in zip(ys, places, strict=True):
            if not any(0 < other - place < room for other in places):
                axes.annotate(number(y), (x, y), textcoords="offset points", xytext=(4, 3), fontsize=8)


def _mean(axes: "Axes", series: list[Points], *, log: bool) -> None:
    """The mean of the lines, thick, each value written; the single cells faint."""
    xs, ys = [], []
    for x in dict.fromkeys(x for points in series for x, _, _ in points):
        found = [y for points in series for at, y, _ in points if at == x and (y > 0 or not log)]
        if found:
            xs.append(x)
            ys.append(sum(found) / len(found))
    order = sorted(range(len(xs)), key=xs.__getitem__)
    xs, ys = [xs[i] for i in order], [ys[i] for i in order]
    for i, points in enumerate(series):
        shown = [(x, y) for x, y, _ in points if y > 0 or not log]
        axes.plot(*zip(*shown, strict=True) if shown else ([], []), linestyle="none", marker="_", markersize=9,
                  color=theme.COLOURS[-1], label="single cells" if i == 0 else None)  # fmt: skip
    axes.plot(xs, ys, marker="o", markersize=5, label="mean", color=theme.COLOURS[0])
    if len(xs) > _MOST_MEANS:
        return
    for x, y in zip(xs, ys, strict=True):
        axes.annotate(number(y), (x, 1.0), xycoords=("data", "axes fraction"), textcoords="offset points",
                      xytext=(0, 8), ha="center", fontsize=8)  # fmt: skip
    axes.annotate("mean", (0.0, 1.0), xycoords="axes fraction", textcoords="offset points", xytext=(-6, 8), ha="right",
                  fontsize=8)  # fmt: skip
