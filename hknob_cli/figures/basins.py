"""Where each start of a cell ends, in the plane of angle and velocity, with the attractors in it."""

from math import ceil
from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.basins_picture import MOST_PANELS, draw_map, maps_of
from hknob_cli.figures.grid import number
from hknob_cli.results.matching import Where, matching
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import COUNTS, RATE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawing
def basins(evidence: ResultSet, of: str, where: Where | None = None) -> "Figure":
    """A map for each cell of a sweep that has maps of basins, of the first six that ``where`` allows.

    Every start has the colour of the attractor it ends in, white where that is not proven; dots are samples of the
    attractors. Raises `MissingError` for a sweep without such maps.
    """
    result = evidence[of]
    axes = result.axes
    cells = maps_of(result.table("basins"), result.table("orbits"), axes)
    named = [dict(zip(axes, one.cell, strict=True)) for one in cells]
    kept = [one for one, cell in zip(cells, named, strict=True) if matching([cell], where or {})]
    if not kept:
        raise MissingError(f"no such cell in the maps of '{of}'")
    shown = kept[:MOST_PANELS]
    across = min(2, len(shown))
    figure = theme.figure(3.3 * ceil(len(shown) / across))
    panels = figure.subplots(ceil(len(shown) / across), across, squeeze=False)
    for empty in list(panels.flat)[len(shown) :]:
        empty.set_axis_off()
    for panel, one in zip(panels.flat, shown, strict=False):
        draw_map(panel, one)
        panel.set_title(", ".join(_said(*pair) for pair in zip(axes, one.cell, strict=True)))
        panel.grid(visible=False)
    if len(kept) > len(shown):
        figure.supxlabel(f"the first {len(shown)} of {len(kept)} cells", fontsize=8)
    return figure


def _said(axis: str, value: float) -> str:
    """The value of an axis in words."""
    unit = {RATE: " Hz", COUNTS: " counts"}.get(axis)
    return f"{number(value)}{unit}" if unit else f"{axis} {number(value)}"
