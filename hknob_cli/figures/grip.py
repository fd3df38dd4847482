"""Grip forces of the hardware test, a cell each trial, as printed and as recorded (Hasser, Fig. 53, Table 8)."""

from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import grid
from hknob_cli.figures.numbers import tick_labels
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOWEST, TARGET, HIGHEST = 0.60, 0.71, 0.82  # N; the target is in the middle of the colours (Hasser, sec. 8.2)


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
        _draw(panel, forces)
        panel.set_title(title)
    panels[0].set_ylabel("counts per revolution")
    return drawn


def _printed() -> Forces:
    from hknob_cli.printed.tables import table

    rows: list[dict[str, Any]] = [row for row in table(8) if isinstance(row["encoder_bits"], float)]
    columns = [name for name in rows[0] if name.startswith("grip_") and name.endswith("_hz_n")]
    newtons = [[float(row[name] or 0.0) for name in columns] for row in rows]
    rates = [name.split("_")[1] for name in columns]
    return Forces(rates, [f"{2 ** int(row['encoder_bits'])}" for row in rows], newtons)


def _draw(panel: "Axes", forces: Forces) -> None:
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
