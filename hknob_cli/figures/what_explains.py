"""What explains what: pitch and size of campaigns over the simulated ones, one cause switched on at a time."""

from typing import TYPE_CHECKING

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.difference import differences
from hknob_cli.figures.grid import grid
from hknob_cli.figures.numbers import log_ticks, number
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Printed = dict[str, float]
_PANELS = (("frequency_hz", "pitch over the simulated"), ("p2p_rad", "peak to peak over the simulated"))
_SPREAD = 0.2  # of dots about their row


@drawing
def what_explains(
    evidence: ResultSet,
    of: list[str],
    *,
    over: str,
    names: list[str] | None = None,
    printed: dict[str, Printed] | None = None,
) -> "Figure":
    """Campaigns ``of`` one grid over the sweep ``over``, cell by cell, a row a campaign: dots, and their mean as a bar.

    Cells where both buzz; at the right how many of the campaign's do. Shape and height of a dot in its row tell the
    resolution, from the coarsest (low) to the finest. ``printed``: by column, `mean` (a line), and `least` and
    `largest` (a band). Raises `MissingError`.
    """
    reference = grid(evidence[over], columns=tuple(column for column, _ in _PANELS))
    drawn = theme.figure(0.72 * len(of) + 1.25)
    panels = drawn.subplots(1, 2, sharey=True)
    grids = [grid(evidence[name], columns=tuple(column for column, _ in _PANELS)) for name in of]
    for panel, (column, label) in zip(panels, _PANELS, strict=True):
        _draw_printed(panel, (printed or {}).get(column))
        for y, one in zip(range(len(of) - 1, -1, -1), grids, strict=True):
            ratios = [[1.0 + value / 100.0 for value in line] for line in differences(one, reference, column)]
            if not any(value == value for line in ratios for value in line):
                raise MissingError(f"'{of[len(of) - 1 - y]}' and '{over}' have no cell in common where both buzz")
            _draw_row(panel, y, ratios)
        panel.axvline(1.0, color="black", linewidth=0.8)
        panel.set_xscale("log")
        panel.set_xticks(*log_ticks(*panel.get_xlim()))
        panel.set_xticks([], minor=True)
        panel.set_xlabel(label)
        panel.set_ylim(-0.6, len(of) - 0.25)
    said = names or of
    panels[0].set_yticks(range(len(of)), list(reversed(said)), fontsize=8)
    for y, one in zip(range(len(of) - 1, -1, -1), grids, strict=True):
        buzzing = sum(cell["at_rest_fraction"] < 1.0 for cell in one.rows)
        panels[1].text(1.02, y, f"{buzzing} of {len(one.rows)}\nbuzz", va="center", fontsize=8,
                       transform=panels[1].get_yaxis_transform())  # fmt: skip
    for i, count in enumerate(reference.downs):
        panels[0].plot([], [], markersize=4.5, label=f"{count:g}", **theme.points(i))
    drawn.legend(loc="outside upper center", ncols=len(reference.downs) + 1, title="counts per revolution")
    return drawn


def _draw_printed(panel: "Axes", printed: Printed | None) -> None:
    if printed and "least" in printed and "largest" in printed:
        panel.axvspan(printed["least"], printed["largest"], color=theme.COLOURS[1], alpha=0.13, linewidth=0)
    if printed and "mean" in printed:
        panel.axvline(printed["mean"], color=theme.COLOURS[1], linestyle="--", linewidth=1.2)
        panel.text(printed["mean"], 1.0, " printed", transform=panel.get_xaxis_transform(), fontsize=8, va="bottom",
                   ha="center", color=theme.COLOURS[1])  # fmt: skip


def _draw_row(panel: "Axes", y: int, ratios: list[list[float]]) -> None:
    """Dots of one campaign by resolution, from below, and the mean of all."""
    heights = np.linspace(-_SPREAD, _SPREAD, len(ratios)) if len(ratios) > 1 else [0.0]
    for i, (line, height) in enumerate(zip(ratios, heights, strict=True)):
        found = [value for value in line if value == value]
        panel.plot(found, [y + height] * len(found), markersize=4.5, **theme.points(i))
    every = [value for line in ratios for value in line if value == value]
    mean = sum(every) / len(every)
    panel.plot([mean, mean], [y - 0.28, y + 0.28], color="black", linewidth=2.2, solid_capstyle="butt")
    panel.text(mean, y + 0.3, number(mean), ha="center", va="bottom", fontsize=8)
