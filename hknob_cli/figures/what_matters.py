"""What matters most over many axes, or in a design: one block of panels an axis, the one that explains most first.

In a block, over the axis: peak to peak, frequency, and the share at rest or in domain; medians and the band from 10 to
90 %, in bins or at the values of the axis. Several methods or laws are several lines, without bands.

What matters most over many axes, or in a design: one block of panels an axis, the one that explains most first.
"""

from collections.abc import Mapping, Sequence
from math import ceil
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import pyarrow as pa

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of, axis_name, rows_of
from hknob_cli.figures.numbers import is_geometric, log_ticks
from hknob_cli.figures.sheet import save
from hknob_cli.report.theory import largest_cycles
from hknob_cli.report.what_matters import MOST_BINS, Columns, Matter, columns_of, measures_in
from hknob_cli.report.what_matters import what_matters as found_in
from hknob_cli.results.columns import ONE, WORST
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.unit_points import Points

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_ACROSS = 4  # blocks beside one another
_MOST_DOTS = 4000
_MOST_TICKS = 6
_SHARES = {"at_rest_fraction": "at rest, %", "in_domain": "in domain, %"}

_FIGURE_ACROSS = 3
_DOTS = 100  # cells drawn in a panel, which each take room in the file


def draw_matters(
    series: Mapping[str, Columns],
    axes: Sequence[str],
    *,
    title: str,
    path: Path,
    stage: str,
    scales: Mapping[str, str] | None = None,
    share: str = "at_rest_fraction",
    total: int | None = None,
) -> bool:
    """Draw into ``path`` (PNG); False, drawing nothing, where too few cells have a size.

    ``series``: columns by method or law, or of a sweep alone; the first decides the order. ``scales``: log or lin, by
    the name of an axis that is a range. ``total``: cells there are, if the columns have some of them.

    Raises `ComputationError` if the file cannot be written.
    """
    found = {name: found_in(columns, axes, share=share) for name, columns in series.items()}
    name, matters = next(iter(found.items()))
    if not matters:
        return False

    across = min(_ACROSS, len(matters))
    figure = theme.figure(width=3.5 * across + 0.6, height=5.4 * ceil(len(matters) / across) + 0.9)
    draw_blocks(figure, found, series, across=across, scales=scales or {}, share=share)
    columns = next(iter(series.values()))
    cells = len(columns[measures_in(columns)[0]])
    of = f"{cells:,} of {total:,}" if total and total != cells else f"{cells:,}"
    figure.suptitle(f"{title}: what matters most for limit cycles against a virtual wall ({of} cells)")
    figure.supxlabel(note_of(matters, name if len(found) > 1 else "", 60 * across), fontsize=8)
    save(figure, path, stage=stage, name=title)
    return True


def draw_blocks(
    figure: "Figure",
    found: Mapping[str, Sequence[Matter]],
    series: Mapping[str, Columns],
    *,
    across: int,
    scales: Mapping[str, str],
    share: str,
    dots: int = _MOST_DOTS,
) -> None:
    """The blocks of all axes, ``across`` of them in a row; ``found``: what matters, by method; ``dots``: at most."""
    name, matters = next(iter(found.items()))
    down = ceil(len(matters) / across)
    ticks = min(_MOST_TICKS, round(1.75 * figure.get_figwidth() / across))
    heights = [3.0, 1.5, 0.9]
    places = figure.subplots(3 * down, across, squeeze=False, sharey="none", height_ratios=heights * down)
    for i, one in enumerate(matters):
        block = [places[3 * (i // across) + row, i % across] for row in range(3)]
        for panel, first in zip(block, places[:3, 0], strict=True):
            if panel is not first:
                panel.sharey(first)
        for panel in block[:2]:
            panel.sharex(block[2])
        for method, every in found.items():
            same = next((other for other in every if other.axis == one.axis), None)
            if same:
                _draw(block, same, series[method], label=method if len(found) > 1 else None, dots=dots)
        _dress(block, one, i + 1, _is_log(one, series[name], scales), _SHARES[share], left=i % across == 0, ticks=ticks)
    for i in range(len(matters), down * across):
        for row in range(3):
            places[3 * (i // across) + row, i % across].set_axis_off()
    for panel in places[:2, 0]:
        _few_ticks(panel.yaxis, *panel.get_ylim())
    if len(found) > 1:
        places[0, 0].legend(fontsize=7)


def draw_by(
    table: pa.Table, choice: str, axes: Sequence[str], *, title: str, path: Path, stage: str, points: Points | None
) -> bool:
    """The same of predictions, a line for each value of the column ``choice``, with the share in domain.

    Of several cycles that a method finds in a cell the largest.
    """
    import numpy as np

    names = [*axes, *ONE, "in_domain"]
    if "orbit" in table.column_names:
        table = pa.Table.from_pylist(largest_cycles(table.to_pylist(), [*axes, choice]), table.schema)
    columns = columns_of(table, names)
    chosen = np.array(table[choice].to_pylist())
    series = {
        name: {column: values[chosen == name] for column, values in columns.items()}
        for name in dict.fromkeys(chosen.tolist())
    }
    scales = points.scales if points else {}
    return draw_matters(series, axes, title=title, path=path, stage=stage, scales=scales, share="in_domain")


def _draw(block: "list[Axes]", one: Matter, columns: Columns, *, label: str | None, dots: int) -> None:
    """One method in the panels of an axis; without a ``label``, the only one, with its cells and bands."""
    values = [found.value for found in one.bins]
    if label is None:
        _dots(block, one.axis, columns, dots)
    for panel, name, scale in ((block[0], "p2p_rad", 1e3), (block[1], "frequency_hz", 1.0)):
        bands = [getattr(found, name) for found in one.bins]
        low, middle, high = ([_scaled(band, i, scale) for band in bands] for i in range(3))
        (line,) = panel.plot(values, middle, marker="o", markersize=3.5, linewidth=1.4, label=label)
        if label is None:
            panel.fill_between(values, low, high, alpha=0.22, linewidth=0, color=line.get_color())
    shares = [100.0 * found.share for found in one.bins]
    (line,) = block[2].plot(values, shares, linewidth=1.4, label=label)
    if label is None:
        block[2].fill_between(values, 0.0, shares, alpha=0.3, linewidth=0, color=line.get_color())


def _scaled(band: tuple[float, float, float] | None, i: int, scale: float) -> float:
    return float("nan") if band is None else scale * band[i]


def _dots(block: "list[Axes]", axis: str, columns: Columns, most: int) -> None:
    """Cells themselves, at most so many, evenly chosen."""
    import numpy as np

    size, pitch = measures_in(columns)
    buzzing = np.flatnonzero(columns[size] > 0.0)
    buzzing = buzzing[:: max(1, ceil(len(buzzing) / most))]
    for panel, name, scale in ((block[0], size, 1e3), (block[1], pitch, 1.0)):
        values, sizes = columns[axis][buzzing], scale * columns[name][buzzing]
        panel.plot(values, sizes, ".", color="0.6", markersize=1.6, alpha=0.5, zorder=0)


def _is_log(one: Matter, columns: Columns, scales: Mapping[str, str]) -> bool:
    """Whether an axis is drawn on a log scale: a range as it was given, a list if its values grow by a factor."""
    import numpy as np

    if one.axis in scales:
        return scales[one.axis] == "log"
    values = np.unique(columns[one.axis])
    if len(values) > MOST_BINS:
        return bool(values[0] > 0.0 and values[-1] > 30.0 * values[0])
    return bool(values[0] > 0.0 and is_geometric(values.tolist()))


def _dress(block: "list[Axes]", one: Matter, place: int, log: bool, share: str, *, left: bool, ticks: int) -> None:
    top, middle, bottom = block
    top.set_title(f"{place}. {axis_name(one.axis)}\nexplains {100.0 * one.explained:.0f} %", fontsize=10)
    bottom.set_ylim(-4.0, 104.0)
    bottom.set_xscale("log" if log else "linear")
    for panel in (top, middle):
        panel.set_yscale("log")
        panel.tick_params(which="both", labelbottom=False)
    for panel in block:
        panel.grid(alpha=0.3)
        panel.tick_params(labelsize=8)
        panel.tick_params(which="both", labelleft=left)
    if log:
        low, high = bottom.get_xlim()
        _few_ticks(bottom.xaxis, low, high, ticks)
        bottom.set_xlim(low, high)
    else:
        bottom.locator_params(axis="x", nbins=5)
    if left:
        for panel, label in ((top, "peak to peak, mrad"), (middle, "frequency, Hz"), (bottom, share)):
            panel.set_ylabel(label, fontsize=9)


def _few_ticks(axis: "Axis", low: float, high: float, most: int = _MOST_TICKS) -> None:
    """A few numbers, as they are said, along an axis on a log scale."""
    from matplotlib.ticker import NullLocator

    ticks, texts = log_ticks(low, high, most)
    axis.set_ticks(ticks, texts)
    axis.set_minor_locator(NullLocator())


def note_of(matters: Sequence[Matter], first: str, width: int) -> str:
    """What a reader must know, in lines of so many letters at most."""
    left = 100.0 * max(0.0, 1.0 - sum(one.explained for one in matters))
    order = f"the order of the cells by size{f' ({first})' if first else ''}, rest the least"
    drawn = "lines: medians" if first else "dots: cells; lines: medians; bands: 10 to 90 %"
    text = (
        f"explains: by itself, of the variance of places in {order}, between the bins of the axis (epsilon squared); "
        f"{left:.0f} % is the interplay of axes, or within bins.  {drawn}, of cells that "
        "buzz, each by its largest cycle"
    )
    return fill(text.replace(" %", "~%"), width).replace("~%", " %")  # a number stays with its sign


@drawing
def what_matters(evidence: ResultSet, of: str, *, where: Row | None = None, most: int = 6) -> "Figure":
    """Peak to peak, frequency, and the share at rest (or in domain) over each axis that varies, at most ``most``.

    A cell is judged by its largest cycle; one in which all trials rest is the least.

    Lines are medians, bands reach from 10 to 90 % of the cells that buzz, dots are some of them. "Explains" is the
    share of the variance of the cells' places in order of size that lies between the bins of an axis (epsilon squared
    of Kruskal and Wallis). ``where`` chooses a method or law. Raises `MissingError` where too few cells have a size.
    """
    from hknob_cli.report.what_matters import what_matters as found_in

    result = evidence[of]
    axes, columns, share = _cells(result, where)
    matters = found_in(columns, axes, share=share)
    if not matters:
        raise MissingError(f"'{of}' has too few cells with a size to tell what matters")
    shown = matters[:most]
    across = min(_FIGURE_ACROSS, len(shown))
    figure = theme.figure(4.0 * ceil(len(shown) / across) + 0.6)
    draw_blocks(figure, {of: shown}, {of: columns}, across=across, scales=result.scales, share=share, dots=_DOTS)
    note = note_of(matters, "", 120)
    if hidden := len(matters) - len(shown):
        note += f"\nleft out: {hidden} that explain{'s' if hidden == 1 else ''} less"
    if (large := result.parted("cells")) and (looked_at := len(columns[share])) < large.num_rows:
        note += f"\nof {looked_at:,} of {large.num_rows:,} cells, from all over them"
    figure.supxlabel(note, fontsize=7)
    return figure


def can_tell(result: Result, where: Row | None = None) -> bool:
    """Whether enough cells have a size to tell what matters."""
    from hknob_cli.report.what_matters import what_matters as found_in

    axes, columns, share = _cells(result, where)
    return bool(found_in(columns, axes, share=share))


def _cells(result: Result, where: Row | None) -> tuple[list[str], "Columns", str]:
    """Axes that may matter, columns of the cells, or of some of very many, and which of them is a share."""
    from hknob_cli.report.large import matters_at_large
    from hknob_cli.report.what_matters import axes_that_matter, columns_in

    if large := result.parted("cells"):
        _refuse_lacking(result, large.column_names, (*WORST, "at_rest_fraction"))
        return *matters_at_large(large, result.axes), "at_rest_fraction"
    rows = rows_of(result, where)
    share = "at_rest_fraction" if "at_rest_fraction" in rows[0] else "in_domain"
    needed = (*(WORST if share == "at_rest_fraction" else ONE), share)
    _refuse_lacking(result, list(rows[0]), needed)
    axes = axes_that_matter(axes_of(result, rows), list(rows[0]))
    return axes, columns_in(rows, [*axes, *needed]), share


def _refuse_lacking(result: Result, names: Sequence[str], needed: Sequence[str]) -> None:
    """Raise `MissingError` where ``names`` lack a column that is ``needed`` beside the axes."""
    if lacking := [name for name in needed if name not in names]:
        raise MissingError(f"'{result.name}' has no column {', '.join(lacking)}")
