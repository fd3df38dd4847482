"""The picture of predictions: every law over the grid, and its difference to a sweep where there is one.

Over two axes: maps, one column a law. Over one: lines, whole inside a law's domain and faint outside it. Of one cell:
bars.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from hknob_cli.figures.bars import draw_bars
from hknob_cli.figures.colour_map import colour_map
from hknob_cli.figures.labels import axis_name
from hknob_cli.figures.sheet import save
from hknob_cli.figures.ticks import is_geometric
from hknob_cli.report.matrix import is_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = (
    ("p2p_rad", 1e3, "peak to peak, mrad", ".3g"),
    ("frequency_hz", 1.0, "frequency, Hz", ".3g"),
    ("p2p_difference", 100.0, "peak to peak beside the sweep, %", "+.0f"),
    ("frequency_difference", 100.0, "frequency beside the sweep, %", "+.0f"),
)
_FULL_SCALE = 50.0  # percent of difference at which the colours end
_MOST_LABELS = 400


def draw_predictions(predictions: pa.Table, axes: list[str], *, title: str, path: Path) -> bool:
    """Draw predictions into ``path`` (PNG); False, drawing nothing, where more than two axes vary, or there is no grid.

    Raises `ComputationError` if the file cannot be written.
    """
    rows = predictions.to_pylist()
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if len(wide) > 2 or not is_whole(rows, wide):
        return False
    laws = list(dict.fromkeys(row["law"] for row in rows))
    panels = [panel for panel in _PANELS if any(row.get(panel[0]) is not None for row in rows)]
    fixed = ", ".join(f"{axis} = {rows[0][axis]:g}" for axis in axes if axis not in wide)
    from matplotlib.figure import Figure

    if len(wide) == 2:
        height = 0.4 * len({row[wide[0]] for row in rows}) + 0.9
        figure = Figure(figsize=(5.2 * len(laws) + 1.0, height * len(panels) + 1.0), layout="constrained")
        _draw_maps(figure, rows, wide, laws, panels)
    elif wide:
        figure = Figure(figsize=(9.5, 6.4), layout="constrained")
        _draw_lines(figure, rows, wide[0], laws)
    else:
        figure = Figure(figsize=(9.5, 5.0), layout="constrained")
        for panel, (column, scale, label, _) in zip(figure.subplots(2, 1), _PANELS, strict=False):
            draw_bars(panel, rows, "law", column, scale, label)
    figure.suptitle(f"{title}: limit cycles by law" + (f"  ({fixed})" if fixed else ""))
    save(figure, path, stage="predict", name=title)
    return True


def _draw_maps(
    figure: "Figure", rows: list[dict[str, Any]], wide: list[str], laws: list[str], panels: list[Any]
) -> None:
    import numpy as np

    down, across = wide
    downs, acrosses = (sorted({row[axis] for row in rows}) for axis in wide)
    grid = {(row["law"], row[down], row[across]): row for row in rows}
    places = figure.subplots(len(panels), len(laws), sharex=True, sharey=True, squeeze=False)
    for line, (column, scale, label, form) in zip(places, panels, strict=True):
        for axes, law in zip(line, laws, strict=True):
            cells = [[grid[law, d, a] for a in acrosses] for d in downs]
            values = np.array([[np.nan if r[column] is None else scale * r[column] for r in row] for row in cells])
            title = f"{law.replace('_', ' ')}: {label}"
            inks = (_difference_map if "difference" in column else colour_map)(axes, values, title)
            axes.set_xticks(range(len(acrosses)), [f"{value:.6g}" for value in acrosses], rotation=30, ha="right")
            axes.set_yticks(range(len(downs)), [f"{float(f'{value:.4g}'):g}" for value in downs])
            if values.size <= _MOST_LABELS:
                for (i, j), value in np.ndenumerate(values):
                    text = "" if np.isnan(value) else format(value, form)
                    text = text if cells[i][j]["in_domain"] or not text else f"({text})"
                    axes.text(j, i, text, ha="center", va="center", fontsize=8, color=inks[i][j])
    for axes in places[-1]:
        axes.set_xlabel(axis_name(across))
    for axes in places[:, 0]:
        axes.set_ylabel(axis_name(down))
    figure.supxlabel("in brackets: outside the law's domain", fontsize=8)


def _difference_map(axes: "Axes", values: Any, title: str) -> list[list[str]]:
    """Draw one map of percentages about 0; the colour in which to write on each of its cells."""
    axes.set_facecolor("0.85")
    axes.imshow(values, origin="lower", aspect="auto", cmap="RdBu_r", vmin=-_FULL_SCALE, vmax=_FULL_SCALE)
    axes.set_title(title, fontsize=10)
    axes.tick_params(length=0)
    return [["white" if abs(value) > 0.75 * _FULL_SCALE else "black" for value in row] for row in values]


def _draw_lines(figure: "Figure", rows: list[dict[str, Any]], axis: str, laws: list[str]) -> None:
    places = figure.subplots(2, 1, sharex=True)
    for axes, (column, scale, label, _) in zip(places, _PANELS, strict=False):
        for i, law in enumerate(laws):
            own = [row for row in rows if row["law"] == law and row[column] is not None]
            xs = [row[axis] for row in own]
            ys = [scale * row[column] for row in own]
            axes.plot(xs, ys, color=f"C{i}", alpha=0.35, linewidth=1.0)
            inside = [y if row["in_domain"] else float("nan") for y, row in zip(ys, own, strict=True)]
            axes.plot(xs, inside, color=f"C{i}", marker="o", markersize=3, label=law.replace("_", " "))
        swept = [row for row in rows if row["law"] == laws[0] and row.get(f"sweep_{column}") is not None]
        if swept:
            ys = [scale * row[f"sweep_{column}"] for row in swept]
            axes.plot([row[axis] for row in swept], ys, "k.", label="sweep")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    xs = sorted({row[axis] for row in rows})
    if xs[0] > 0 and is_geometric(xs):
        places[1].set_xscale("log")
    places[1].set_xlabel(f"{axis_name(axis)}    (faint: outside the law's domain)")
    places[0].legend(fontsize=8)
