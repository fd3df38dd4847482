"""A surface over a grid, small, beside its map: the form of the dissertation's meshes (Hasser, Figs 33, 35, 38, 47)."""

from math import floor
from typing import TYPE_CHECKING, Any

from hknob_cli.figures.grid import Grid
from hknob_cli.figures.heat import ramp
from hknob_cli.figures.numbers import tick_labels

if TYPE_CHECKING:
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

_MOST = 16  # values of an axis; more are thinned
_SHORT = {"sample_rate_hz": "rate, Hz", "counts_per_rev": "counts"}


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
        axis.labelpad = 2
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
