"""The picture of a sweep over a population: how many people have at most so much, or maps of how many and how much."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from hknob_cli.figures.defaults import figures_of
from hknob_cli.figures.grid import axis_name
from hknob_cli.figures.heat import colour_map
from hknob_cli.figures.sheet import save, write_sheet
from hknob_cli.report.population import Row, describe_people
from hknob_cli.report.table import is_whole
from hknob_cli.results.result_set import Held
from hknob_cli.specs.plan import PERSON

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
