"""Without and with what the simulations left out: two maps on one scale and their ratio (Hasser, Figs 55-59)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.difference import differences
from hknob_cli.figures.grid import cell_text, column_label, grid, notes
from hknob_cli.figures.heat import diverging, draw_key, draw_map, height_of, norm_of, ramp
from hknob_cli.figures.numbers import number
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BESIDE = 5  # columns up to which the maps stand side by side, else below each other


@drawing
def hardware_grid(
    evidence: ResultSet,
    of: list[str],
    *,
    column: str = "p2p_rad",
    names: tuple[str, str] = ("without friction", "with friction"),
    digits: int = 3,
) -> "Figure":
    """Maps of a column of two results ``of`` the same grid, and the second over the first, as a factor.

    Beneath: the mean factor and its range, over the cells where both cycle. Raises `MissingError`.
    """
    from matplotlib.colors import LogNorm

    results = [evidence[name] for name in of]
    grids = [grid(result, columns=(column,)) for result in results]
    name, factor = column_label(results[0], column)
    values = [one.values(column, factor) for one in grids]
    norm = norm_of([value for one in values for line in one for value in line], log=True)
    ratio = [[1.0 + value / 100.0 for value in line] for line in differences(grids[1], grids[0], column)]
    tall = len(grids[0].acrosses) > _BESIDE
    figure = theme.figure(3.0 * height_of(grids[0], extra=0.9) if tall else height_of(grids[0], extra=1.65))
    panels = figure.subplots(3, 1) if tall else figure.subplots(1, 3)
    for i in (0, 1):
        texts = [
            [cell_text(cell, value, column, digits) for cell, value in zip(*line, strict=True)]
            for line in zip(grids[i].cells, values[i], strict=True)
        ]
        draw_map(panels[i], grids[i], values[i], texts, norm=norm, colours=ramp(), left=tall or i == 0)
        panels[i].set_title(names[i])
    found = [value for line in ratio for value in line if value == value]
    reach = max([4.0, *(max(value, 1.0 / value) for value in found if value > 0)])
    scale = LogNorm(1.0 / reach, reach)
    texts = [["" if value != value else f"\u00d7 {number(value, 2)}" for value in line] for line in ratio]
    draw_map(panels[2], grids[0], ratio, texts, norm=scale, colours=diverging(), left=tall)
    panels[2].set_title("the second over the first")
    draw_key(figure, list(panels[:2]), norm, ramp(), name, below=not tall)
    draw_key(figure, panels[2], scale, diverging(), "factor", below=not tall, most=4)
    said = [notes(grids, column)]
    if found:
        mean = number(sum(found) / len(found), 2)
        said.append(f"factor: mean {mean}, from {number(min(found), 2)} to {number(max(found), 2)}, {len(found)} cells")
    figure.supxlabel(";  ".join(filter(None, said)), fontsize=8)
    return figure
