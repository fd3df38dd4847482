"""The picture of energy growth without damping: over the sample rate, by resolution (Hasser, Figs. 29, 30)."""

from math import sqrt
from typing import TYPE_CHECKING, Any

from hknob_cli.report.matrix import short

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GROWTH = "growth_j_per_s2"
LABEL = "growth of energy at bounce peaks, J/s\u00b2"


def draw_growth(figure: "Figure", rows: list[dict[str, Any]], wide: list[str], name: Any) -> None:
    """Draw growth along the first of two axes, one line for each value of the second; hollow where not above 0."""
    import matplotlib

    along, apart = wide[0], wide[1] if len(wide) > 1 else None
    panel = figure.subplots()
    values = sorted({row[apart] for row in rows}) if apart else [None]
    colours = matplotlib.colormaps["viridis"]
    markers = "osD^v<>"
    for i, value in enumerate(values):
        line = sorted((row for row in rows if apart is None or row[apart] == value), key=lambda row: row[along])
        line = [row for row in line if row[GROWTH] is not None]
        colour = colours(i / max(1, len(values) - 1) * 0.9)
        sure = [row for row in line if row[GROWTH] > 0.0]
        label = None if value is None else short(value, 6)
        error = [row["growth_std_j_per_s2"] / sqrt(max(1, row["growth_fits"])) for row in sure]
        panel.errorbar(
            [row[along] for row in sure],
            [row[GROWTH] for row in sure],
            yerr=[[min(e, 0.999 * row[GROWTH]) for e, row in zip(error, sure, strict=True)], error],
            color=colour,
            marker=markers[i % len(markers)],
            linewidth=1.0,
            capsize=2,
            label=label,
        )
        rest = [row for row in line if row[GROWTH] <= 0.0]
        panel.plot(
            [row[along] for row in rest],
            [-row[GROWTH] for row in rest],
            color=colour,
            marker=markers[i % len(markers)],
            markerfacecolor="none",
            linestyle="none",
        )
    panel.set_xscale("log")
    panel.set_yscale("log")
    sizes = [abs(row[GROWTH]) for row in rows if row[GROWTH]]
    if sizes:  # an error as large as the mean reaches down to 0
        panel.set_ylim(bottom=0.3 * min(sizes))
    panel.set_xlabel(name(along))
    panel.set_ylabel(LABEL)
    panel.grid(alpha=0.3, which="both")
    if apart:
        panel.legend(title=name(apart), fontsize=8)
    figure.supxlabel(
        "mean of the trials and its standard error;  hollow: the mean is negative, its size shown", fontsize=8
    )
