"""Lines of a column over one axis, one line a value of the other, or their mean (Hasser, Figs 29, 30, 33-35, 39, 40, 66)."""

from math import sqrt
from typing import TYPE_CHECKING, Any

from hknob_cli.page import ink
from hknob_cli.page.figures import drawing
from hknob_cli.page.figures.grid import Grid, Row, axis_label, column_label, grid, number, tick_labels
from hknob_cli.report.picture import is_geometric
from hknob_cli.results.evidence import Evidence, MissingError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Points = list[tuple[float, float, Row]]


@drawing
def grid_lines(
    evidence: Evidence,
    of: str,
    *,
    column: str = "p2p_rad",
    scale: float | None = None,
    label: str | None = None,
    over: str | None = None,
    lines: str | None = None,
    at: Row | None = None,
    where: Row | None = None,
    log: str = "xy",
    mean_over: bool = False,
    error: str | None = None,
    trials: str | None = None,
    height: float = 3.4,
) -> "Figure":
    """A column over the axis ``over``, one line for each value of the axis ``lines``.

    ``log``: the axes that are logarithmic, of "x" and "y". ``mean_over``: the mean of the lines, with its values, and
    the cells faint behind. ``error``: column of a standard deviation, over the root of the column ``trials`` if given.
    A value not above 0 on a logarithmic axis is hollow, at its size. For rows see `grid`. Raises `MissingError`.
    """
    result = evidence[of]
    needed = tuple(filter(None, (column, error, trials)))
    cells = grid(result, across=over, down=lines, at=at, where=where, columns=needed)
    name, factor = column_label(result, column, scale, label)
    values = cells.values(column, factor)
    if not any(value == value for line in values for value in line):
        raise MissingError(f"'{of}' has no value of {column}")
    figure = ink.figure(height)
    axes = figure.subplots()
    _scales(axes, cells, log)
    series = [_points(cells, line, values[i]) for i, line in enumerate(cells.cells)]
    if mean_over:
        _mean(axes, cells, series, log="y" in log)
    else:
        for i, (points, text) in enumerate(zip(series, tick_labels(cells.downs), strict=True)):
            _line(axes, points, i, text, log="y" in log, error=error, trials=trials, factor=factor)
    axes.set_xlabel(axis_label(cells.across))
    axes.set_ylabel(name)
    if "y" not in log and all(y >= 0 for points in series for _, y, _ in points):
        axes.set_ylim(bottom=0.0)
    if cells.down and (len(cells.downs) > 1 or mean_over):
        figure.legend(title=axis_label(cells.down, room=20) if not mean_over else None, loc="outside right upper",
                      handlelength=3.2)  # fmt: skip
    return figure


def _scales(axes: "Axes", cells: Grid, log: str) -> None:
    """Scales, and ticks at the values of the axis where they are few."""
    xs = [value for value in cells.acrosses if value is not None]
    if "x" in log and xs and min(xs) > 0 and is_geometric(xs):
        axes.set_xscale("log")
    if 0 < len(xs) <= 10:
        axes.set_xticks(xs, tick_labels(xs))
        axes.set_xticks([], minor=True)
    if "y" in log:
        axes.set_yscale("log")
        axes.grid(visible=True, which="minor", axis="y", alpha=0.1)


def _points(cells: Grid, line: list[Row | None], values: list[float]) -> Points:
    xs = [0.0 if value is None else float(value) for value in cells.acrosses]
    return [(x, y, cell) for x, y, cell in zip(xs, values, line, strict=True) if cell is not None and y == y]


def _line(
    axes: "Axes", points: Points, index: int, text: str, *, log: bool, error: str | None, trials: str | None, factor: float
) -> None:
    sure = [point for point in points if point[1] > 0 or not log]
    bars: dict[str, Any] = {}
    if error is not None:
        size = [factor * (cell[error] or 0.0) / sqrt(max(1, cell[trials] if trials else 1)) for *_, cell in sure]
        below = [min(one, 0.9 * y) if log else one for one, (_, y, _) in zip(size, sure, strict=True)]
        bars = {"yerr": [below, size], "capsize": 2, "elinewidth": 0.8}
    xs, ys = [x for x, _, _ in sure], [y for _, y, _ in sure]
    marker = ink.points(index)["marker"]
    axes.errorbar(xs, ys, marker=marker, markersize=4.5, label=text, **ink.series(index), **bars)
    rest = [point for point in points if point[1] < 0 and log]
    if rest:
        style = {**ink.points(index), "markerfacecolor": "none"}
        axes.plot([x for x, _, _ in rest], [-y for _, y, _ in rest], markersize=4.5, **style)


def _mean(axes: "Axes", cells: Grid, series: list[Points], *, log: bool) -> None:
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
                  color=ink.COLOURS[-1], label="single cells" if i == 0 else None)  # fmt: skip
    axes.plot(xs, ys, marker="o", markersize=5, label="mean", color=ink.COLOURS[0])
    for x, y in zip(xs, ys, strict=True):
        axes.annotate(number(y), (x, y), textcoords="offset points", xytext=(-6, 7), ha="right", fontsize=8)
