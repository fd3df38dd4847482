"""A campaign over its grid: the grip of every trial, and size and pitch beside sweeps (Hasser, Figs 53, 57).

Grip forces of the hardware test, a cell each trial, as printed and as recorded (Hasser, Fig. 53, Table 8).
"""

from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, axis_label, column_label, grid
from hknob_cli.figures.numbers import log_ticks, tick_labels
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOWEST, TARGET, HIGHEST = 0.60, 0.71, 0.82  # N; the target is in the middle of the colours (Hasser, sec. 8.2)

_MOST = 6  # panels
_WIDE = 3  # of them from which on they stand in two rows


class Forces(NamedTuple):
    """Mean grip force (N) by resolution, upward, and rate; not a number where there is none."""

    rates: list[str]
    counts: list[str]
    newtons: list[list[float]]


@drawing
def grip_forces(evidence: ResultSet, of: Any = None) -> "Figure":
    """Mean grip force (N) of each of Table 8's 16 trials over sample rate and resolution, and those of a campaign.

    ``of``: the campaign; without one the printed table alone. Raises `MissingError`.
    """
    name = of[0] if isinstance(of, list) and of else of or None
    maps = [("printed, Table 8", _printed())] if name else [("", _printed())]
    if name:
        cells = grid(evidence[name], columns=("grip_mean_n",))
        recorded = Forces(tick_labels(cells.acrosses), tick_labels(cells.downs), cells.values("grip_mean_n"))
        maps.append(("a virtual person", recorded))
    drawn = theme.figure(2.4 + 0.35 * len(maps), width=4.6 if len(maps) == 1 else theme.WIDTH)
    panels = drawn.subplots(1, len(maps), squeeze=False)[0]
    for panel, (title, forces) in zip(panels, maps, strict=True):
        _draw_forces(panel, forces)
        panel.set_title(title)
    panels[0].set_ylabel("counts per revolution")
    return drawn


def _printed() -> Forces:
    from hknob_cli.printed import table

    rows: list[dict[str, Any]] = [row for row in table(8) if isinstance(row["encoder_bits"], float)]
    columns = [name for name in rows[0] if name.startswith("grip_") and name.endswith("_hz_n")]
    newtons = [[float(row[name] or 0.0) for name in columns] for row in rows]
    rates = [name.split("_")[1] for name in columns]
    return Forces(rates, [f"{2 ** int(row['encoder_bits'])}" for row in rows], newtons)


def _draw_forces(panel: "Axes", forces: Forces) -> None:
    """One map, its values written in, and under it their mean and sample standard deviation."""
    panel.pcolormesh(forces.newtons, cmap=theme.MAP, vmin=LOWEST, vmax=HIGHEST, edgecolors="none")
    for i, line in enumerate(forces.newtons):
        for j, force in enumerate(line):
            colour = theme.ON_DARK if force < TARGET else theme.ON_LIGHT
            panel.text(j + 0.5, i + 0.5, f"{force:.2f}", ha="center", va="center", color=colour)
    panel.set_xticks([j + 0.5 for j in range(len(forces.rates))], forces.rates)
    panel.set_yticks([i + 0.5 for i in range(len(forces.counts))], forces.counts)
    panel.tick_params(length=0)
    panel.grid(visible=False)
    every = [force for line in forces.newtons for force in line if force == force]
    spread = f" \u00b1 {stdev(every):.2f}" if len(every) > 1 else ""
    panel.set_xlabel(f"sample rate, Hz\nmean {fmean(every):.2f}{spread} N")


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
            look = (
                {"color": "black", "marker": "o", "linestyle": "none", "markersize": 5.0, "zorder": 4}
                if one is grids[-1]
                else {**theme.series(i), "linewidth": 0.8 if law is not None and i == 0 else 1.3}
            )
            xs, ys = _line(one, count, column, factor)
            panel.plot(xs, ys, label=name, **look)
            if one is grids[-1]:
                at_rest = _at_rest(one, count)
                panel.plot(at_rest, [0.05] * len(at_rest), transform=panel.get_xaxis_transform(), color="black",
                           marker="x", linestyle="none", markersize=6.0)  # fmt: skip
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


def _line(one: Grid, count: object, column: str, factor: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Rates and values of one resolution of one result, where there is a value above 0."""
    line = one.values(column, factor)[one.downs.index(count)] if count in one.downs else []
    pairs = [(x, y) for x, y in zip(one.acrosses, line, strict=False) if y == y and y > 0.0]
    return tuple(x for x, _ in pairs), tuple(y for _, y in pairs)


def _at_rest(one: Grid, count: object) -> list[float]:
    """Rates at which every trial of one resolution comes to rest."""
    cells = one.cells[one.downs.index(count)] if count in one.downs else []
    return [x for x, cell in zip(one.acrosses, cells, strict=False) if cell and cell.get("at_rest_fraction") == 1.0]
