"""A closed law beside the simulation: lines and points over one axis (Hasser, sec. 9.3, Figs 62-65)."""

from textwrap import fill
from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Layout, LinesLayout, column_label, grid
from hknob_cli.figures.numbers import log_ticks, mark_values, tick_labels
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LAWS = {"quantum_period": "the law C \u0394\u03b8 T"}


@drawing
def law_lines(
    evidence: ResultSet,
    of: str | list[str],
    *,
    law: str = "quantum_period",
    column: str = "p2p_rad",
    layout: LinesLayout,
    height: float = 3.8,
) -> "Figure":
    """A law of a prediction as lines over an axis, and the simulated values as points.

    ``of``: the prediction, and the sweep, unless the prediction has one beside it. Lines are faint outside the law's
    domain. Mean over the trials that cycle. Raises `MissingError`.
    """
    names = [of] if isinstance(of, str) else list(of)
    result = evidence[names[0]]
    beside = column if len(names) > 1 else f"sweep_{column}"
    cells = grid(result, Layout(*layout), where={"law": law}, columns=(column,))
    there: Grid | None = cells
    if len(names) > 1:
        same = Layout(cells.across or None, cells.down or None, layout.at)
        there = grid(evidence[names[1]], same, columns=(column,))
    elif cells.rows and beside not in cells.rows[0]:
        there = None
    name, factor = column_label(result, column)
    figure = theme.figure(height)
    axes = figure.subplots()
    computed = cells.values(column, factor)
    if not any(value == value for line in computed for value in line):
        raise MissingError(f"'{names[0]}' has no value of {column} by the law {law}")
    for i, (line, text) in enumerate(zip(computed, tick_labels(cells.downs), strict=True)):
        _line(axes, cells, i, line)
        axes.plot([], [], **theme.series(i), marker=theme.points(i)["marker"], markersize=5, label=text)
    if there is not None:
        for i, line in enumerate(there.values(beside, factor)):
            shown = [(x, y) for x, y in zip(there.acrosses, line, strict=True) if y == y and y > 0]
            axes.plot(*zip(*shown, strict=True) if shown else ([], []), markersize=5, **theme.points(i))
    values = [value for value in cells.acrosses if value is not None]
    mark_values(axes, values, few=10)
    axes.set_yscale("log")
    axes.set_yticks(*log_ticks(*axes.get_ylim()))
    axes.set_yticks([], minor=True)
    axes.set_xlabel(cells.names[0])
    axes.set_ylabel(name)
    what = [f"lines: {_LAWS.get(law, law.replace('_', ' '))}, thin outside its domain"]
    figure.supxlabel(";  ".join(what + (["points: simulated"] if there is not None else [])), fontsize=8)
    if cells.down:
        figure.legend(title=fill(cells.names[1], 20), loc="outside right upper", handlelength=3.4)
    return figure


def _line(axes: "Axes", cells: Grid, index: int, values: list[float]) -> None:
    """A row of the grid as a line, faint outside the law's domain."""
    style = theme.series(index)
    inside = [
        value if cell is not None and cell["in_domain"] else float("nan")
        for value, cell in zip(values, cells.cells[index], strict=True)
    ]
    axes.plot(cells.acrosses, values, **{**style, "linewidth": 0.8, "alpha": 0.6})
    axes.plot(cells.acrosses, inside, **style)
