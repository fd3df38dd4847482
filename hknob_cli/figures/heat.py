"""A map: the cells of a grid in colour, with their values written in, and the key to the colours.

Cells are of equal size whatever the axis values, which stand beside them. A cell without a colour has the page's
background, and says in words why.

A map with colours on one scale, and the colour in which to write on each cell.
"""

from math import isfinite
from textwrap import fill
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import theme
from hknob_cli.figures.grid import MOST_WRITTEN, Grid
from hknob_cli.figures.numbers import log_ticks, tick_labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure

LEVELS = 32  # steps of colour; few enough for a key without a raster image
CELL = 0.36  # inches of height
MOST_LETTERS = 92  # of a row of cells, at full size
LETTER = 0.0625  # inches that a letter of a key's label takes at full size
_DIFFERENCE = ("#08306b", "#5b9bd0", "#f4f4f4", "#f0a24a", "#b35806")


def colour_map(axes: "Axes", values: Any, label: str, *, limits: tuple[float, float] | None = None) -> list[list[str]]:
    """Draw one map; the colour in which to write on each of its cells.

    Colours are on a log scale of the values above 0, or with ``limits`` on an even one between these.
    """
    import numpy as np
    from matplotlib.colors import LogNorm, Normalize

    shown = values if limits else np.where(values > 0, values, np.nan)
    found = shown[np.isfinite(shown)]
    low, high = (float(found.min()), float(found.max())) if found.size else (1.0, 1.0)
    norm = Normalize(*limits) if limits else LogNorm(low, high if high > low else low * 1.01)
    axes.set_facecolor("0.85")
    image = axes.imshow(shown, origin="lower", aspect="auto", cmap="cividis", norm=norm)
    axes.set_title(label, fontsize=10)
    axes.tick_params(length=0)
    # Relative luminance (ITU-R BT.709) decides; cells without a value are light grey.
    light = image.to_rgba(shown)[..., :3] @ np.array([0.2126, 0.7152, 0.0722])
    return [
        ["white" if dark and some else "black" for dark, some in zip(*row, strict=True)]
        for row in zip(light < 0.5, np.isfinite(shown), strict=True)
    ]


def norm_of(values: list[float], *, log: bool) -> "Normalize":
    """Scale of colours over the values; on a log scale, over those above 0."""
    from matplotlib.colors import LogNorm, Normalize

    found = [value for value in values if isfinite(value) and (value > 0 or not log)]
    low, high = (min(found), max(found)) if found else (1.0, 1.0)
    if high <= low:
        high = low * 1.01 if low > 0 else low + 1.0
    return LogNorm(low, high) if log else Normalize(low, high)


def about_zero(values: list[float]) -> "Normalize":
    """Scale of colours of differences, as far to either side of 0 as the largest of them."""
    from matplotlib.colors import Normalize

    reach = max((abs(value) for value in values if isfinite(value)), default=0.0) or 1.0
    return Normalize(-reach, reach)


def ramp() -> "Colormap":
    """Colours of sizes."""
    import matplotlib as mpl

    return mpl.colormaps[theme.MAP].resampled(LEVELS)


def diverging() -> "Colormap":
    """Colours of differences: dark blue below 0, lighter orange above, so that grey tells the ends apart, too."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("difference", _DIFFERENCE, N=LEVELS + 1)


def draw_map(
    axes: "Axes",
    grid: Grid,
    values: list[list[float]],
    texts: list[list[str]],
    *,
    norm: "Normalize",
    colours: "Colormap",
    left: bool = True,
    bold: set[tuple[int, int]] | frozenset[tuple[int, int]] = frozenset(),
) -> None:
    """Draw values (row by row, upward) with their texts; ``left``: with the labels of the rows.

    Cells of ``bold`` have a frame and bold text.
    """
    import numpy as np
    from matplotlib.patches import Rectangle

    shown = np.array(values, dtype=float)
    if getattr(norm, "vmin", None) is not None and type(norm).__name__ == "LogNorm":
        shown = np.where(shown > 0, shown, np.nan)
    rows, columns = shown.shape
    _fill(axes, shown, norm, colours)
    axes.grid(visible=False)
    axes.set_xticks(np.arange(columns) + 0.5, tick_labels(grid.acrosses), fontsize=8)
    axes.set_yticks(np.arange(rows) + 0.5, tick_labels(grid.downs) if left else [""] * rows, fontsize=8)
    axes.tick_params(length=0)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
    axes.set_xlabel(grid.names[0])
    axes.set_ylabel(fill(grid.names[1], 5 * max(rows, 3) if rows <= MOST_WRITTEN else 60) if left else "")
    if max(rows, columns) > MOST_WRITTEN:
        _sparse(axes, rows, columns)
        return
    longest = max(len(line) for row in texts for text in row for line in text.split("\n"))
    size = min(8.0, max(5.5, 8.0 * MOST_LETTERS / max(longest * columns, 1)))
    for i, j in np.ndindex(rows, columns):
        inked = writing(float(shown[i, j]), norm, colours)
        weight = "bold" if (i, j) in bold else "normal"
        axes.text(j + 0.5, i + 0.5, texts[i][j], ha="center", va="center", fontsize=size, color=inked, weight=weight,
                  linespacing=1.0)  # fmt: skip
        if (i, j) in bold:
            axes.add_patch(Rectangle((j + 0.06, i + 0.08), 0.88, 0.84, fill=False, edgecolor=inked, linewidth=1.4))


def writing(value: float, norm: "Normalize", colours: "Colormap") -> str:
    """Colour in which to write on a cell, by the luminance of its colour (ITU-R BT.709); black where it has none."""
    if not isfinite(value):
        return "black"
    red, green, blue, _ = colours(norm(value))
    return theme.ON_DARK if 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.45 else theme.ON_LIGHT


def draw_key(
    figure: "Figure", axes: Any, norm: "Normalize", colours: "Colormap", label: str, *, below: bool, most: int = 6
) -> None:
    """Draw the key to the colours of ``axes`` (one or several), below or right of them, with ``most`` ticks."""
    from matplotlib.cm import ScalarMappable

    place = "bottom" if below else "right"
    options: dict[str, Any] = {"aspect": 40, "shrink": 0.7} if below else {"aspect": 24, "shrink": 0.9}
    key = figure.colorbar(ScalarMappable(norm, colours), ax=axes, location=place, pad=0.02, **options)
    beside = (figure.get_size_inches()[1] - 0.7) / LETTER  # letters that fit beside the cells
    key.set_label(label, fontsize=8.5 if below else min(8.5, max(6.0, 8.5 * beside / len(label))))
    if type(norm).__name__ == "LogNorm":
        ticks, texts = log_ticks(norm.vmin or 1.0, norm.vmax or 1.0, most=most)
        key.set_ticks(ticks, labels=texts)
        key.ax.minorticks_off()
    key.ax.tick_params(labelsize=8)
    key.ax.grid(visible=False)
    if key.solids is not None:
        key.solids.set(edgecolor="face", linewidth=0.4)
    key.outline.set_visible(False)


def height_of(grid: Grid, *, extra: float = 0.75) -> float:
    """Height of a figure of a map, in inches, with ``extra`` for what is around its cells."""
    rows = max(3, len(grid.downs))  # the axis needs room for its name
    return max(1.3, (CELL if rows <= MOST_WRITTEN else 0.16) * rows + extra)


def _fill(axes: "Axes", shown: Any, norm: "Normalize", colours: "Colormap") -> None:
    """Fill the cells that have a value: one path a colour, runs of a row merged, which keeps the SVG small."""
    from itertools import groupby

    from matplotlib.colors import to_hex
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    rows, columns = shown.shape
    outlines: dict[str, list[tuple[float, float]]] = {}
    for i in range(rows):
        inks = [to_hex(colours(norm(float(value)))) if isfinite(value) else "" for value in shown[i]]
        for colour, run in groupby(range(columns), key=inks.__getitem__):
            if colour:
                first, *_ = span = list(run)
                left, right = first, span[-1] + 1
                outlines.setdefault(colour, []).extend(
                    [(left, i), (right, i), (right, i + 1), (left, i + 1), (left, i)]
                )
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    for colour, corners in outlines.items():
        path = Path(corners, codes * (len(corners) // len(codes)))
        axes.add_patch(PathPatch(path, facecolor=colour, edgecolor="none", antialiased=False))
    axes.set_xlim(0, columns)
    axes.set_ylim(0, rows)


def _sparse(axes: "Axes", rows: int, columns: int) -> None:
    """Label every few cells only, of a map that is too fine for values."""
    for axis, count in ((axes.xaxis, columns), (axes.yaxis, rows)):
        step = 1 + (count - 1) // 10
        texts = [tick.get_text() for tick in axis.get_ticklabels()]
        axis.set_ticks([i + 0.5 for i in range(0, count, step)], texts[::step])
