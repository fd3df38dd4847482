"""The picture of a sweep over a population: how many people have at most so much, or maps of how many and how much."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.figures.colour_map import colour_map
from hknob_cli.figures.labels import axis_name
from hknob_cli.figures.sheet import save
from hknob_cli.report.matrix import is_whole
from hknob_cli.report.population import Row, by_cell, describe_people, pitches, sizes
from hknob_cli.specs.plan import PERSON

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CURVES = 7
_STYLES = ("-", "--", "-.", ":")


def draw_population(cells: list[Row], axes: list[str], *, title: str, path: Path) -> bool:
    """Draw into ``path`` (PNG): maps over two axes, else curves; False, drawing nothing, without a grid of so few.

    Raises `ComputationError` if the file cannot be written.
    """
    axes = [axis for axis in axes if axis != PERSON]
    wide = [axis for axis in axes if len({row[axis] for row in cells}) > 1]
    if len(wide) > 2 or not is_whole(cells, wide):
        return False
    fixed = ", ".join(f"{axis} = {cells[0][axis]:g}" for axis in axes if axis not in wide)
    from matplotlib.figure import Figure

    if len(wide) == 2:
        figure = Figure(figsize=(13.5, 0.52 * len({row[wide[0]] for row in cells}) + 2.6), layout="constrained")
        _maps(figure, describe_people(cells, axes), wide)
    else:
        figure = Figure(figsize=(11.0, 5.0), layout="constrained")
        _curves(figure, thinned(by_cell(cells, axes)), wide)
    people = len({row[PERSON] for row in cells})
    figure.suptitle(f"{title}: limit cycles of {people} people" + (f"  ({fixed})" if fixed else ""))
    save(figure, path, stage="sweep", name=title)
    return True


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


def _curves(figure: "Figure", cells: list[tuple[Row, list[Row]]], wide: list[str]) -> None:
    left, right = figure.subplots(1, 2, sharey=True)
    for i, (cell, people) in enumerate(cells):
        label = f"{cell[wide[0]]:.6g}" if wide else None
        for axes, values, scale in ((left, sizes(people), 1e3), (right, pitches(people), 1.0)):
            if values:
                style = _STYLES[i % len(_STYLES)]
                axes.step(*cumulative(values, scale), where="post", linestyle=style, color=f"C{i}", label=label)
    left.set_ylabel("people who have at most this, %")
    left.set_xlabel("peak to peak of the largest cycle, mrad (0: at rest)")
    right.set_xlabel("frequency of the largest cycle, Hz (of those for whom it buzzes)")
    for axes in (left, right):
        axes.set_ylim(0.0, 100.0)
        axes.grid(alpha=0.3)
    if wide:
        left.legend(title=axis_name(wide[0]))


def _maps(figure: "Figure", rows: list[Row], wide: list[str]) -> None:
    import numpy as np

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
