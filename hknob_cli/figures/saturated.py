"""Where limit cycles exceed one count to either side: a map of two tones, with signs (Hasser, Fig. 37)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, ends, grid
from hknob_cli.figures.heat import draw_map, height_of
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LESS, _MORE = "#1f4e79", "#f0c75e"


@drawing
def saturated_map(
    evidence: ResultSet,
    of: str,
    *,
    column: str = "p2p_counts",
    limit: float = 2.0,
    across: str | None = None,
    down: str | None = None,
    at: Row | None = None,
    where: Row | None = None,
) -> "Figure":
    """Two tones: ``column`` above ``limit`` (+1) or not (-1); 2 counts of peak to peak are one to either side.

    For axes and rows see `grid`. Raises `MissingError`.
    """
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.patches import Patch

    cells = grid(evidence[of], across=across, down=down, at=at, where=where, columns=(column,))
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
