"""Lines of a column over one axis, one a value of the other, or their mean (Hasser, Figs 30, 34, 39, 40, 66).

Where one axis alone varies: size and pitch of the cells over it, a line for each method or law, or for each of a sweep.
"""

from math import nan, sqrt
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import (
    CHOICES,
    TABLES,
    Grid,
    Layout,
    LinesLayout,
    Measure,
    Row,
    axes_of,
    axis_label,
    column_label,
    grid,
)
from hknob_cli.figures.numbers import log_ticks, mark_values, number, tick_labels
from hknob_cli.report.table import short
from hknob_cli.results.columns import WORST, differs
from hknob_cli.results.result_set import MissingError, Result, ResultSet, Rows

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


_SHORT = {"sample_rate_hz": "{} Hz", "counts_per_rev": "{} counts", "person": "person {}"}
SIZE, PITCH = ("peak to peak, mrad", 1e3), ("frequency, Hz", 1.0)

_FEW = 10  # values of the axis that have a tick each


class Point(NamedTuple):
    """A cell's values as drawn, one a panel; None where it has none. The first is 0 at rest."""

    row: Row
    values: tuple[float | None, ...]


class Series(NamedTuple):
    """Points of one name; ``by_domain``: of a method or law, which has a domain."""

    name: str
    points: list[Point]
    by_domain: bool = False


class Cells(NamedTuple):
    """All series, the names of the panels, the axes of the result and those of them that vary."""

    series: list[Series]
    panels: tuple[str, ...]
    axes: list[str]
    wide: list[str]


def cells_of(result: Result, *, column: str | None = None) -> Cells:
    """Series of peak to peak and frequency, or of one ``column``. Raises `MissingError`.

    Of a method that finds several limit cycles in a cell all are there.
    """
    if result.stage not in TABLES:
        raise MissingError(f"'{result.name}' is of stage {result.stage}, which has no cells")
    file = TABLES[result.stage]
    names = result.schema(file).names if result.stage != "hw-run" else result.table(file).column_names
    if lacking := [name for name in ([column] if column else ["p2p_rad", "frequency_hz"]) if name not in names]:
        raise MissingError(f"'{result.name}' has no column {', '.join(lacking)}")
    rows = result.rows(file)
    axes = axes_of(result, rows)
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if column:
        name, factor = column_label(result, column)
        return Cells([Series("", _cell_points(rows, ((column, factor),)))], (name,), axes, wide)
    return Cells(_sized(result, rows, names), (SIZE[0], PITCH[0]), axes, wide)


def place_of(row: Row, axes: list[str]) -> str:
    """A cell in words, by its values of some axes."""
    return ", ".join(_SHORT.get(axis, f"{axis.replace('.', ' ')} {{}}").format(short(row[axis], 6)) for axis in axes)


def _sized(result: Result, rows: Rows, names: list[str]) -> list[Series]:
    mean = _cell_points(rows, (("p2p_rad", SIZE[1]), ("frequency_hz", PITCH[1])))
    choice = CHOICES.get(result.stage)
    if choice in names:
        found: dict[str, list[Point]] = {row[choice]: [] for row in rows}
        for point in mean:
            found[point.row[choice]].append(point)
        series = [Series(name, points, "in_domain" in names) for name, points in found.items()]
        if "sweep_p2p_rad" in names:
            cells = list({tuple(row[axis] for axis in result.axes): row for row in rows}.values())
            swept = (("sweep_p2p_rad", SIZE[1]), ("sweep_frequency_hz", PITCH[1]))
            apart = any(row.get("sweep_p2p_max_rad") != row["sweep_p2p_rad"] for row in cells)
            if apart and "sweep_p2p_max_rad" in names:
                sizes = [
                    Point(one.row, (one.values[0], None))
                    for one in _cell_points(cells, (("sweep_p2p_max_rad", SIZE[1]),))
                ]
                series.append(Series("sweep, largest cycle", sizes))
            series.append(Series("sweep, mean" if apart else "sweep", _cell_points(cells, swept)))
        return series
    if "p2p_max_rad" not in names:
        return [Series("", mean)]
    largest = _cell_points(rows, ((WORST[0], SIZE[1]), (WORST[1], PITCH[1])))
    if not differs(rows):
        return [Series("", largest)]
    worst = "largest cycle" if result.stage == "sweep" else "trial that buzzes most"
    return [Series(worst, largest), Series("mean of those that cycle", mean)]


def _cell_points(rows: Rows, columns: tuple[tuple[str, float], ...]) -> list[Point]:
    return [
        Point(row, tuple(None if row[name] is None else factor * row[name] for name, factor in columns)) for row in rows
    ]


@drawing
def axis_lines(evidence: ResultSet, of: str, *, column: str | None = None) -> "Figure":
    """Peak to peak (mrad) and frequency (Hz) over the axis that varies, or one ``column``; a line a series.

    Series are the methods or laws of an analysis, with the sweep that it is compared with, or of a sweep the largest
    attractor and the mean. If a method finds several cycles in a cell, the line has the largest. A cell at rest is at
    0; outside a method's domain a line is thin. Raises `MissingError` where no axis varies, or several do.
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
    mark_values(panels[-1], values, few=_FEW)
    panels[-1].set_xlabel(label)
