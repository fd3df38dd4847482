"""Size and pitch of the cells over the one axis that varies: a line for each method or law, or for each of a sweep.

Size and pitch of the cells over the one axis that varies: a line for each method or law, or for each of a sweep.
"""

from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import CHOICES, TABLES, axes_of, axis_label, column_label
from hknob_cli.figures.numbers import mark_values
from hknob_cli.report.table import short
from hknob_cli.results.means import WORST, differs
from hknob_cli.results.result_set import MissingError, Result, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]
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
        return Cells([Series("", _points(rows, ((column, factor),)))], (name,), axes, wide)
    return Cells(_sized(result, rows, names), (SIZE[0], PITCH[0]), axes, wide)


def place_of(row: Row, axes: list[str]) -> str:
    """A cell in words, by its values of some axes."""
    return ", ".join(_SHORT.get(axis, f"{axis.replace('.', ' ')} {{}}").format(short(row[axis], 6)) for axis in axes)


def _sized(result: Result, rows: Rows, names: list[str]) -> list[Series]:
    mean = _points(rows, (("p2p_rad", SIZE[1]), ("frequency_hz", PITCH[1])))
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
                    Point(one.row, (one.values[0], None)) for one in _points(cells, (("sweep_p2p_max_rad", SIZE[1]),))
                ]
                series.append(Series("sweep, largest cycle", sizes))
            series.append(Series("sweep, mean" if apart else "sweep", _points(cells, swept)))
        return series
    if "p2p_max_rad" not in names:
        return [Series("", mean)]
    largest = _points(rows, ((WORST[0], SIZE[1]), (WORST[1], PITCH[1])))
    if not differs(rows):
        return [Series("", largest)]
    worst = "largest cycle" if result.stage == "sweep" else "trial that buzzes most"
    return [Series(worst, largest), Series("mean of those that cycle", mean)]


def _points(rows: Rows, columns: tuple[tuple[str, float], ...]) -> list[Point]:
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
