"""The picture of remedies tried on a knob: what each leaves of the buzz as measured, and beside it as computed."""

from statistics import fmean, median
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.remedies import plain_numbers
from hknob_cli.report.remedies import over_the_trials
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_APART = 0.15  # of what is computed from what is measured, in rows
Look = tuple[str, str, float, dict[str, Any]]  # a label, the columns' prefix, the place in a row, the style


@drawing
def remedies_tried(evidence: ResultSet, of: str, *, reference: str = "plain wall") -> "Figure":
    """A row a remedy that a campaign tried, over the cells: peak to peak, pitch, times smaller, share that buzzes.

    A dot is the median, a line reaches from the least to the largest, of cells where the knob buzzes: filled as
    measured, hollow as computed, where that is known. The share is of all trials, or of all starts. The remedy with the
    smallest buzz is uppermost. ``reference``: what the others are smaller than. Raises `MissingError` for a result
    without remedies.
    """
    rows = evidence[of].rows("remedies")
    if not rows:
        raise MissingError(f"'{of}' has no trial that could be measured")
    names = [row["remedy"] for row in reversed(over_the_trials(rows))]
    looks: list[Look] = [("measured", "", 0.0, {"color": theme.COLOURS[0]})]
    if "computed_p2p_rad" in rows[0]:
        hollow = {"color": theme.COLOURS[1], "fillstyle": "none", "linestyle": theme.STYLES[1]}
        looks = [(*looks[0][:2], _APART, looks[0][3]), ("computed", "computed_", -_APART, hollow)]
    figure = theme.figure(0.28 * len(names) + 1.5)
    panels: list[Axes] = list(figure.subplots(1, 4, sharey=True, width_ratios=(1.3, 1.1, 1.1, 0.8)))
    columns = (("p2p_rad", 1e3), ("frequency_hz", 1.0), ("p2p_ratio", 1.0))
    for label, which, apart, style in looks:
        for y, name in enumerate(names):
            mine = [row for row in rows if row["remedy"] == name]
            for panel, (column, scale) in zip(panels, columns, strict=False):
                _range(panel, [scale * row[which + column] for row in mine if row[which + column]], y + apart, style)
            share = _share(mine, computed=bool(which))
            if share is not None:
                panels[3].plot([share], [y + apart], marker="o", markersize=5.0, **style)
        panels[0].plot([], [], marker="o", markersize=5.0, label=label, **style)
    _dress(panels, names, reference)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure


def _range(panel: "Axes", values: list[float], y: float, style: dict[str, Any]) -> None:
    if values:
        panel.plot([min(values), max(values)], [y, y], linewidth=1.4, **style)
        panel.plot([median(values)], [y], marker="o", markersize=5.0, **style)


def _share(rows: Rows, *, computed: bool) -> float | None:
    """How many of the trials, or starts, buzz, in per cent; None where that is not known."""
    if not computed:
        return 100.0 * float(sum(row["sustained"] for row in rows) / sum(row["trials"] for row in rows))
    rest = [row["computed_at_rest_fraction"] for row in rows if row["computed_at_rest_fraction"] is not None]
    return 100.0 * (1.0 - fmean(rest)) if rest else None


def _dress(panels: "list[Axes]", names: list[str], reference: str) -> None:
    panels[0].set_yticks(range(len(names)), names, fontsize=8)
    panels[0].set_ylim(-0.7, len(names) - 0.3)
    of = reference if len(reference) <= 24 else "reference"
    for panel, label in zip(panels, ("peak to peak, mrad", "frequency, Hz", f"times smaller than\nthe {of}'s"),
                            strict=False):  # fmt: skip
        panel.set_xlabel(label)
        if any(np.size(line.get_xdata()) for line in panel.lines):
            panel.set_xscale("log")
            plain_numbers(panel)
        else:
            panel.text(0.5, 0.5, "no buzz", ha="center", va="center", transform=panel.transAxes)
            panel.set_xticks([])
    panels[2].axvline(1.0, color="black", linewidth=0.6, alpha=0.5)
    panels[3].set_xlabel("buzzes, %")
    panels[3].set_xlim(-6.0, 106.0)
    panels[3].tick_params(axis="x", labelsize=7.5)
