"""Remedies over a whole grid: how large a buzz each leaves, how many times smaller it is, how much comes to rest."""

from statistics import median
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@drawing
def remedy_grid(evidence: ResultSet, of: str) -> "Figure":
    """A row a remedy over the cells of the grid and all hands: peak to peak, times smaller than the reference, at rest.

    A dot is the median, a line reaches from the least to the largest, of cells where the knob buzzes, and the share at
    rest is of all trials. With levels a last panel has how much louder a remedy is to the skin than the reference, dB.
    The remedy with the smallest buzz at its worst is uppermost. Raises `MissingError` for a result of another kind.
    """
    result = evidence[of]
    rows = result.rows("remedies")
    if not rows:
        raise MissingError(f"'{of}' has no cells of a grid")
    size = "p2p_max_rad" if "p2p_max_rad" in rows[0] else "p2p_rad"
    felt = any(row.get("touch_change_db") is not None for row in rows)
    names = list(dict.fromkeys(row["remedy"] for row in rows))
    names.sort(key=lambda name: _worst(rows, name, size), reverse=True)
    figure = theme.figure(0.24 * len(names) + 1.3)
    panels = list(figure.subplots(1, 4 if felt else 3, sharey=True, width_ratios=(1.4, 1.2, 0.9, *([1.1] * felt))))
    for y, name in enumerate(names):
        mine = [row for row in rows if row["remedy"] == name]
        _range(panels[0], [1e3 * row[size] for row in mine if row[size]], y)
        _range(panels[1], [row["p2p_ratio"] for row in mine if row["p2p_ratio"]], y)
        rest = 100.0 * sum(row["at_rest_fraction"] for row in mine) / len(mine)
        panels[2].barh([y], [rest], height=0.5, color=theme.COLOURS[0])
        if felt:
            _range(panels[3], [row["touch_change_db"] for row in mine if row["touch_change_db"] is not None], y)
    _dress(panels, names)
    return figure


def _worst(rows: Rows, name: str, size: str) -> float:
    """Largest peak to peak of a remedy over cells and hands; what diverges counts as infinite."""
    mine = [row for row in rows if row["remedy"] == name]
    if any(row["diverged_fraction"] for row in mine):
        return float("inf")
    return max(row[size] or 0.0 for row in mine)


def _range(panel: "Axes", values: list[float], y: int) -> None:
    if not values:
        return
    style: dict[str, Any] = {"color": theme.COLOURS[0]}
    panel.plot([min(values), max(values)], [y, y], linewidth=1.6, solid_capstyle="butt", **style)
    panel.plot([median(values)], [y], marker="o", markersize=5.0, **style)


def _dress(panels: "list[Axes]", names: list[str]) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    panels[0].set_yticks(range(len(names)), names, fontsize=8)
    panels[0].set_ylim(-0.7, len(names) - 0.3)
    panels[0].set_xlabel("peak to peak, mrad")
    panels[1].set_xlabel("times smaller than\nthe reference's")
    panels[2].set_xlabel("at rest, %")
    panels[2].set_xlim(0.0, 100.0)
    for panel in panels[:2]:
        if not panel.lines:
            panel.text(0.5, 0.5, "no buzz", ha="center", va="center", transform=panel.transAxes)
            panel.set_xticks([])
            continue
        panel.set_xscale("log")
        low, high = panel.get_xlim()
        panel.xaxis.set_major_locator(LogLocator(subs=(1.0,) if high > 40.0 * low else (1.0, 2.0, 5.0)))
        panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
        panel.xaxis.set_minor_formatter(NullFormatter())
    if panels[1].lines:
        panels[1].axvline(1.0, color="black", linewidth=0.6, alpha=0.5)
    for panel in panels[3:]:
        panel.axvline(0.0, color="black", linewidth=0.6, alpha=0.5)
        panel.set_xlabel("felt more than\nthe reference, dB")
