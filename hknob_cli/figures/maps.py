"""Maps of a column over two axes, with a surface beside them, and what is drawn as such maps.

A surface over a grid, small, beside its map: the form of the dissertation's meshes (Hasser, Figs 33, 35, 38, 47).

Where limit cycles exceed one count to either side: a map of two tones, with signs (Hasser, Fig. 37).

The notional optimisation: the worse of size and pitch, from 0 to 1 over the grid (Hasser, sec. 10.7, Fig. 70).
"""

from math import floor, log
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Layout, Measure, Row, cell_text, column_label, ends, grid, notes
from hknob_cli.figures.heat import about_zero, diverging, draw_key, draw_map, height_of, norm_of, ramp
from hknob_cli.figures.numbers import tick_labels
from hknob_cli.results.columns import WORST
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

_MOST = 16  # values of an axis; more are thinned
_SHORT = {"sample_rate_hz": "rate, Hz", "counts_per_rev": "counts"}

_LESS, _MORE = "#1f4e79", "#f0c75e"


def draw_mesh(
    figure: "Figure", place: "SubplotSpec", grid: Grid, values: list[list[float]], *, norm: "Normalize", log: bool
) -> None:
    """Draw values over evenly spaced axes, on a log scale of height if ``log``; a hole where there is no value.

    Both axes need two values or more.
    """
    import numpy as np

    axes: Any = figure.add_subplot(place, projection="3d", computed_zorder=False)
    shown = np.array(values, dtype=float)
    height = np.log10(np.where(shown > 0, shown, np.nan)) if log else shown
    down, across = (1 + (size - 1) // _MOST for size in height.shape)
    height = height[::down, ::across]
    x, y = np.meshgrid(np.arange(shown.shape[1])[::across], np.arange(shown.shape[0])[::down])
    middle = np.mean([height[:-1, :-1], height[1:, :-1], height[:-1, 1:], height[1:, 1:]], axis=0)
    colours = ramp()(norm(10.0**middle if log else middle))
    axes.plot_surface(
        x, y, height, facecolors=colours, rstride=1, cstride=1, shade=False, edgecolor="#808080", linewidth=0.5
    )
    _dress(axes, grid, height, log=log)


def _dress(axes: Any, grid: Grid, height: Any, *, log: bool) -> None:
    """Sparse ticks, no panes, the view from the lowest corner."""
    import numpy as np

    corners = [height[-1, -1], height[-1, 0], height[0, 0], height[0, -1]]  # by the angle from which they are in front
    corner = min(range(4), key=lambda i: corners[i] if np.isfinite(corners[i]) else np.inf)
    for axis, name, values in ((axes.xaxis, grid.across, grid.acrosses), (axes.yaxis, grid.down, grid.downs)):
        texts = tick_labels(values)
        step = max(1, (len(values) - 1) // 2)
        axis.set_ticks(range(0, len(values), step), texts[::step])
        for label in axis.get_ticklabels():  # those of the two axes meet at the front corner
            label.set_horizontalalignment("left" if (axis is axes.xaxis) == (corner % 2 == 0) else "right")
        axis.set_label_text(_SHORT.get(name, name), fontsize=8)
        axis.labelpad = 2 if max(map(len, texts)) < 5 else 5  # below five digits it meets none of them
    found = height[np.isfinite(height)]
    if log and found.size:
        powers = range(floor(found.min()), floor(found.max()) + 2)
        inside = [power for power in powers if found.min() - 0.3 <= power <= found.max() + 0.3]
        axes.zaxis.set_ticks(inside, [f"{10.0**power:g}" for power in inside])
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((0.0, 0.0, 0.0, 0.0))
        axis._axinfo["grid"].update(color=(0.5, 0.5, 0.5, 0.4), linewidth=0.4)
        axis.line.set_color("black")
        axis.set_tick_params(labelsize=8, pad=-1)
    axes.view_init(elev=28, azim=40 + 90 * corner)
    axes.set_box_aspect((1, 1, 0.8), zoom=0.95)


@drawing
def grid_map(
    evidence: ResultSet,
    of: str,
    *,
    measure: Measure,
    layout: Layout,
    where: Row | None = None,
    log: bool = True,
    mesh: bool = False,
    digits: int = 3,
) -> "Figure":
    """One column over two axes, its values written in (Hasser, Figs 29, 30, 33-36, 38, 47, 50, 55, 56, 59, 62-65).

    ``where`` chooses rows, such as those of a method; ``log``: of the colours, and of the surface that ``mesh`` puts
    beside the map. Raises `MissingError`.
    """
    result, column = evidence[of], measure.column
    cells = grid(result, layout, where=where, columns=(column,))
    name, factor = column_label(result, *measure)
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
    layout: Layout,
    log: bool = True,
    digits: int = 2,
) -> "Figure":
    """Two maps side by side, of two results or two columns (Hasser, Figs 48, 51, 57, 61-65).

    Maps with the same label share one scale of colours. ``names`` stand above them, ``wheres`` choose the rows of each,
    such as those of a method. Raises `MissingError`.
    """
    results = [evidence[name] for name in _two(of)]
    chosen = _two(columns)
    where = wheres or [{}, {}]
    grids = [
        grid(result, layout, where=one, columns=(column,))
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


@drawing
def saturated_map(
    evidence: ResultSet,
    of: str,
    *,
    column: str = "p2p_counts",
    limit: float = 2.0,
    layout: Layout,
    where: Row | None = None,
) -> "Figure":
    """Two tones: ``column`` above ``limit`` (+1) or not (-1); 2 counts of peak to peak are one to either side.

    ``where`` chooses rows, such as those of a method. Raises `MissingError`.
    """
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.patches import Patch

    cells = grid(evidence[of], layout, where=where, columns=(column,))
    signs = [[value if value != value else (1.0 if value > limit else -1.0) for value in line]
             for line in cells.values(column)]  # fmt: skip
    texts: list[list[str]] = []
    for i, line in enumerate(cells.cells):
        texts.append([])
        for j, cell in enumerate(line):
            words = " ".join(ends(cell)) if cell else ""
            still = cell is not None and not cell[column]
            signs[i][j] = float("nan") if still else signs[i][j]
            texts[i].append(words or "none" if still else "+1" if signs[i][j] > 0 else "\u22121" if cell else "")
    figure = theme.figure(height_of(cells, extra=1.0))
    axes = figure.subplots()
    colours = ListedColormap([_LESS, _MORE])
    draw_map(axes, cells, signs, texts, norm=Normalize(-1.0, 1.0), colours=colours)
    size = "one count to either side" if (column, limit) == ("p2p_counts", 2.0) else f"{limit:g}"
    more = sum(sign > 0 for line in signs for sign in line)
    less = sum(sign < 0 for line in signs for sign in line)
    handles = [
        Patch(facecolor=_MORE, label=f"+1: exceeds {size} ({more} cells)"),
        Patch(facecolor=_LESS, label=f"\u22121: does not ({less} cells)"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


@drawing
def surface(
    evidence: ResultSet,
    of: str,
    *,
    layout: Layout,
    mesh: bool = False,
    log_pitch: bool = False,
) -> "Figure":
    """The larger of log peak to peak and frequency, both scaled to 0..1 over the grid; small is good.

    Both are those of the largest cycle of a cell.
    ``log_pitch``: log frequency, too. A letter says which of the two it is (s: size, p: pitch); the best cell of each
    row has a frame. Raises `MissingError`.
    """
    from matplotlib.colors import Normalize

    size_of, pitch_of = WORST
    cells = grid(evidence[of], layout, columns=WORST)
    sizes = [[log(value) if value > 0 else float("nan") for value in line] for line in cells.values(size_of)]
    pitches = [
        [(log(value) if log_pitch else value) if value > 0 else float("nan") for value in line]
        for line in cells.values(pitch_of)
    ]
    if not any(value == value for line in sizes for value in line):
        raise MissingError(f"'{of}' has no limit cycle")
    size, pitch = _scaled(sizes), _scaled(pitches)
    values = [[max(s, p) for s, p in zip(*both, strict=True)] for both in zip(size, pitch, strict=True)]
    texts = [
        [
            f"{max(s, p):.2f} {'s' if s >= p else 'p'}" if s == s else ending(cell)
            for s, p, cell in zip(*line, strict=True)
        ]
        for line in zip(size, pitch, cells.cells, strict=True)
    ]
    figure = draw_surface(cells, values, texts, norm=Normalize(0.0, 1.0), label="worse of the two, 0 to 1", mesh=mesh)
    pitch_is = "log frequency" if log_pitch else "frequency"
    said = f"s: size (log peak to peak) is the worse;  p: pitch ({pitch_is});  frame: best of its row"
    figure.supxlabel(said, fontsize=8)
    return figure


def ending(cell: Row | None) -> str:
    """How a cell without a limit cycle ends, in words; empty where there is no cell."""
    return " ".join(ends(cell)) if cell else ""


def draw_surface(
    cells: Grid,
    values: list[list[float]],
    texts: list[list[str]],
    *,
    norm: "Normalize",
    label: str,
    mesh: bool,
    least: int = 1,
) -> "Figure":
    """A map with a frame about the least value of each row and a key; beside it a mesh, where the grid has two axes.

    ``label``: of the key. ``least``: values that a row needs for a frame.
    """
    found = [[(value, j) for j, value in enumerate(line) if value == value] for line in values]
    best = {(i, min(line)[1]) for i, line in enumerate(found) if len(line) >= least and len(values[i]) > 1}
    mesh = mesh and min(len(cells.acrosses), len(cells.downs)) > 1
    figure = theme.figure(height_of(cells, extra=1.45 if mesh else 1.0))
    outer = figure.add_gridspec(1, 2 if mesh else 1, width_ratios=[1.6, 1.0] if mesh else [1.0])
    axes = figure.add_subplot(outer[0])
    draw_map(axes, cells, values, texts, norm=norm, colours=ramp(), bold=best)
    draw_key(figure, axes, norm, ramp(), label, below=mesh)
    if mesh:
        draw_mesh(figure, outer[1], cells, values, norm=norm, log=False)
    return figure


def _scaled(values: list[list[float]]) -> list[list[float]]:
    """Values from 0 to 1 over their range."""
    found = [value for line in values for value in line if value == value]
    low, span = min(found), (max(found) - min(found)) or 1.0
    return [[(value - low) / span for value in line] for line in values]
