"""A campaign beside sweeps of its grid, resolution by resolution (Hasser, Fig. 57)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, axis_label, column_label, grid
from hknob_cli.figures.numbers import log_ticks, tick_labels
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 6  # panels
_WIDE = 3  # of them from which on they stand in two rows


@drawing
def campaign_lines(
    evidence: ResultSet,
    of: list[str],
    *,
    names: list[str] | None = None,
    column: str = "p2p_rad",
    law: str | None = None,
) -> "Figure":
    """A column over the sample rate, a panel a resolution: ``of`` sweeps as lines, then a campaign as points, last.

    With ``law``, the first of ``of`` is a prediction, whose law of that name is drawn thin. Rest has no place on a
    logarithmic scale: it is a mark at the foot of the panel. Raises `MissingError`.
    """
    wheres = [{"law": law} if law is not None and i == 0 else None for i in range(len(of))]
    grids = [grid(evidence[name], columns=(column,), where=where) for name, where in zip(of, wheres, strict=True)]
    counts = grids[-1].downs
    if len(counts) > _MOST or len(grids[-1].acrosses) < 2:
        raise MissingError(f"'{of[-1]}' has {len(counts)} resolutions at {len(grids[-1].acrosses)} rates")
    rows = 2 if len(counts) > _WIDE else 1
    drawn = theme.figure(0.9 + 1.75 * rows)
    panels = drawn.subplots(rows, -(-len(counts) // rows), sharex=True, sharey=True, squeeze=False).ravel()
    label, factor = column_label(evidence[of[-1]], column)
    for panel, text in zip(panels, tick_labels(counts), strict=False):
        panel.set_title(f"{text} counts", loc="left")
        panel.set_xscale("log")
        panel.set_yscale("log")
    for i, (one, name) in enumerate(zip(grids, names or of, strict=True)):
        for panel, count in zip(panels, counts, strict=False):
            _draw(panel, one, count, column, factor, name, i, last=one is grids[-1], thin=law is not None and i == 0)
    for panel in panels[len(counts) :]:
        panel.set_visible(False)
    panels[0].set_xticks(grids[-1].acrosses, tick_labels(grids[-1].acrosses))
    panels[0].set_xticks([], minor=True)
    panels[0].set_yticks(*log_ticks(*panels[0].get_ylim()))
    panels[0].set_yticks([], minor=True)
    drawn.supxlabel(axis_label(evidence[of[-1]], grids[-1].across), fontsize=9)
    drawn.supylabel(label, fontsize=9)
    drawn.legend(
        *panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=min(4, len(of)), handlelength=3.0
    )
    return drawn


def _draw(
    panel: object, one: Grid, count: object, column: str, factor: float, name: str, i: int, *, last: bool, thin: bool
) -> None:
    """One resolution of one result."""
    from matplotlib.axes import Axes

    assert isinstance(panel, Axes)
    line = one.values(column, factor)[one.downs.index(count)] if count in one.downs else []
    pairs = [(x, y) for x, y in zip(one.acrosses, line, strict=False) if y == y and y > 0.0]
    cells = one.cells[one.downs.index(count)] if count in one.downs else []
    at_rest = [x for x, cell in zip(one.acrosses, cells, strict=False) if cell and cell.get("at_rest_fraction") == 1.0]
    xs, ys = zip(*pairs, strict=True) if pairs else ((), ())
    if last:
        panel.plot(xs, ys, color="black", marker="o", linestyle="none", markersize=5.0, label=name, zorder=4)
        panel.plot(at_rest, [0.05] * len(at_rest), transform=panel.get_xaxis_transform(), color="black", marker="x",
                   linestyle="none", markersize=6.0)  # fmt: skip
        return
    style = theme.series(i)
    panel.plot(xs, ys, label=name, **{**style, "linewidth": 0.8 if thin else 1.3})
