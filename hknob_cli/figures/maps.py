"""Maps of a column over two axes: one with a surface beside it, or two on one scale."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Row, cell_text, column_label, grid, notes
from hknob_cli.figures.heat import about_zero, diverging, draw_key, draw_map, height_of, norm_of, ramp
from hknob_cli.figures.mesh import draw_mesh
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawing
def grid_map(
    evidence: ResultSet,
    of: str,
    *,
    column: str = "p2p_rad",
    scale: float | None = None,
    label: str | None = None,
    across: str | None = None,
    down: str | None = None,
    at: Row | None = None,
    where: Row | None = None,
    log: bool = True,
    mesh: bool = False,
    digits: int = 3,
) -> "Figure":
    """One column over two axes, its values written in (Hasser, Figs 29, 30, 33-36, 38, 47, 50, 55, 56, 59, 62-65).

    ``scale`` times SI values is what ``label`` says; ``log``: of the colours, and of the surface that ``mesh`` puts
    beside the map. For axes and rows see `grid`. Raises `MissingError`.
    """
    result = evidence[of]
    cells = grid(result, across=across, down=down, at=at, where=where, columns=(column,))
    name, factor = column_label(result, column, scale, label)
    values = cells.values(column, factor)
    mesh = mesh and min(len(cells.acrosses), len(cells.downs)) > 1
    flat = [value for line in values for value in line]
    signed = column.endswith("_difference")
    norm, colours = (about_zero(flat), diverging()) if signed else (norm_of(flat, log=log), ramp())
    note = _note([cells], column)
    figure = theme.figure(height_of(cells, extra=(1.35 if mesh else 0.75) + (0.25 if note else 0.0)))
    outer = figure.add_gridspec(1, 2 if mesh else 1, width_ratios=[1.45, 1.0] if mesh else [1.0])
    axes = figure.add_subplot(outer[0])
    draw_map(axes, cells, values, _texts(cells, values, column, digits), norm=norm, colours=colours)
    draw_key(figure, axes, norm, colours, name, below=mesh)
    if mesh:
        draw_mesh(figure, outer[1], cells, values, norm=norm, log=log)
    if note:
        figure.supxlabel(note, fontsize=8)
    return figure


@drawing
def grid_pair(
    evidence: ResultSet,
    of: str | list[str],
    *,
    columns: str | list[str] = "p2p_rad",
    names: list[str] | None = None,
    wheres: list[Row] | None = None,
    across: str | None = None,
    down: str | None = None,
    at: Row | None = None,
    log: bool = True,
    digits: int = 2,
) -> "Figure":
    """Two maps side by side, of two results or two columns (Hasser, Figs 48, 51, 57, 61-65).

    Maps with the same label share one scale of colours. ``names`` stand above them, ``wheres`` choose the rows of each,
    such as a method; for axes see `grid`. Raises `MissingError`.
    """
    results = [evidence[name] for name in _two(of)]
    chosen = _two(columns)
    where = wheres or [{}, {}]
    grids = [
        grid(result, across=across, down=down, at=at, where=one, columns=(column,))
        for result, one, column in zip(results, where, chosen, strict=True)
    ]
    labels = [column_label(result, column) for result, column in zip(results, chosen, strict=True)]
    values = [one.values(column, scale) for one, column, (_, scale) in zip(grids, chosen, labels, strict=True)]
    shared = labels[0][0].split(", ")[-1] == labels[1][0].split(", ")[-1]
    flat = [[value for line in of_one for value in line] for of_one in values]
    norms = [norm_of(flat[0] + flat[1], log=log)] * 2 if shared else [norm_of(one, log=log) for one in flat]
    note = _note(grids, chosen[0])
    figure = theme.figure(max(height_of(one, extra=1.5 + (0.25 if note else 0.0)) for one in grids))
    panels = figure.subplots(1, 2)
    same = grids[0].downs == grids[1].downs and grids[0].down == grids[1].down
    for i, axes in enumerate(panels):
        texts = _texts(grids[i], values[i], chosen[i], digits)
        draw_map(axes, grids[i], values[i], texts, norm=norms[i], colours=ramp(), left=i == 0 or not same)
        axes.set_title((names or [result.name for result in results])[i])
        if not shared:
            draw_key(figure, axes, norms[i], ramp(), labels[i][0], below=True)
    if shared:
        said = labels[0][0] if labels[0][0] == labels[1][0] else f"{labels[0][0]};  {labels[1][0]}"
        draw_key(figure, list(panels), norms[0], ramp(), said, below=True)
    if note:
        figure.supxlabel(note, fontsize=8)
    return figure


def _two(value: str | list[str]) -> list[str]:
    """Two names; the same twice, of one."""
    if isinstance(value, str):
        return [value, value]
    return list(value) if len(value) == 2 else [value[0], value[0]]


def _texts(cells: Grid, values: list[list[float]], column: str, digits: int) -> list[list[str]]:
    return [
        [cell_text(cell, value, column, digits) for cell, value in zip(line, of_line, strict=True)]
        for line, of_line in zip(cells.cells, values, strict=True)
    ]


def _note(grids: list[Grid], column: str) -> str:
    """What the cells' marks mean, and where the axes not drawn stand, if any vary in nothing but are not trivial."""
    fixed: dict[str, Any] = dict.fromkeys(one.fixed for one in grids if one.fixed)
    return ";  ".join(filter(None, [notes(grids, column), *fixed]))
