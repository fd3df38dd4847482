"""Trials of remedies: at one case, over a whole grid, over a further axis, and on a knob.

Remedies over a whole grid: how large a buzz each leaves, how many times smaller it is, how much comes to rest.

The picture of remedies over a further axis: blue where the largest cycle is smaller, red where it is larger.
"""

from math import log2
from pathlib import Path
from statistics import fmean, median
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.sheet import save
from hknob_cli.report.remedies import over_axis, over_the_trials, said
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

REACH = 3.0  # of the colours: eight times smaller or larger


@drawing
def remedy_dots(evidence: ResultSet, of: str, *, case: str, felt: bool = False) -> "Figure":
    """A row a remedy, a marker a hand: size (mrad) and pitch (Hz) of the largest cycle, and stiffness kept.

    The remedy that leaves least, of the hand that it helps least, is uppermost. In the third panel filled markers are
    the stiffness under a steady push, hollow ones the depth of a knock, both over the reference's; in the first a tick
    is the mean of the trials that cycle. ``felt`` adds how much more the buzz is felt (filled) and heard (hollow) than
    the reference's, dB. Raises `MissingError` where there is no such case.
    """
    rows = [row for row in evidence[of].rows("cases") if row["case"] == case]
    if not rows:
        raise MissingError(f"'{of}' has no case '{case}'")
    names = sorted(dict.fromkeys(row["remedy"] for row in rows), key=lambda name: _worst(rows, name), reverse=True)
    hands = list(dict.fromkeys(row["hand"] for row in rows))
    figure = theme.figure(0.2 * len(names) + 1.2)
    panels = figure.subplots(1, 4 if felt else 3, sharey=True, width_ratios=(1.5, 1.1, 1.0, *([1.1] * felt)))
    moving = [row["p2p_max_rad"] for row in rows if row["p2p_max_rad"]]
    rest = 0.4e3 * min(moving, default=1e-6)  # where rest is drawn, left of all that moves
    for i, hand in enumerate(hands):
        mine = {row["remedy"]: row for row in rows if row["hand"] == hand}
        _draw_hand(list(panels), [mine[name] for name in names], i, len(hands), hand, rest)
    for axes in panels[:3]:
        axes.set_xscale("log")
        plain_numbers(axes)
    panels[0].set_yticks(range(len(names)), names, fontsize=8)
    panels[0].set_ylim(-0.7, len(names) - 0.3)
    panels[0].axvline(1.5 * rest, color="black", linewidth=0.6, alpha=0.5)
    panels[0].set_xlabel("largest peak to peak, mrad\n(tick: mean; left of the line: at rest)")
    panels[1].set_xlabel("its frequency, Hz")
    panels[2].set_xlabel("times the plain wall's\n(\N{BLACK CIRCLE} stiffness, \N{WHITE CIRCLE} knock)")
    panels[2].axvline(1.0, color="black", linewidth=0.6, alpha=0.5)
    for axes in panels[3:]:
        axes.axvline(0.0, color="black", linewidth=0.6, alpha=0.5)
        axes.set_xlabel("over the reference, dB\n(\N{BLACK CIRCLE} felt, \N{WHITE CIRCLE} heard)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=min(3, len(labels)))
    return figure


def _worst(rows: Rows, name: str) -> float:
    """Largest peak to peak of a remedy over the hands; what diverges counts as infinite."""
    sizes = [row["p2p_max_rad"] for row in rows if row["remedy"] == name]
    return max(float("inf") if size is None else size for size in sizes)


def _draw_hand(panels: "list[Axes]", rows: Rows, i: int, count: int, hand: str, rest: float) -> None:
    size, pitch, stiffness, *louder = panels
    at = [y + (i - 0.5 * (count - 1)) * 0.4 / count for y in range(len(rows))]
    style: dict[str, Any] = {**theme.points(i), "markersize": 4.5}
    none = float("nan")
    sizes = [none if row["p2p_max_rad"] is None else (1e3 * row["p2p_max_rad"] or rest) for row in rows]
    size.plot(sizes, at, label=hand, **style)
    means = [1e3 * (row["p2p_rad"] or none) for row in rows]
    size.plot(means, at, **{**style, "marker": "|", "markersize": 6.0})
    pitch.plot([row["frequency_at_max_hz"] or none for row in rows], at, **style)
    stiffness.plot([row["stiffness_kept"] or none for row in rows], at, **style)
    stiffness.plot([row["knock_ratio"] or none for row in rows], at, **{**style, "fillstyle": "none"})
    for panel in louder:
        for column, fill in (("touch_change_db", "full"), ("hearing_change_db", "none")):
            changes = [none if row[column] is None else row[column] for row in rows]
            panel.plot(changes, at, **{**style, "fillstyle": fill})


def plain_numbers(axes: "Axes") -> None:
    """Label a logarithmic axis across with plain numbers, as many as it has room for."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 40.0 * low else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", labelsize=7.5)


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
    names.sort(key=lambda name: _worst_of_grid(rows, name, size), reverse=True)
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


def _worst_of_grid(rows: Rows, name: str, size: str) -> float:
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


def draw_over(rows: list[dict[str, Any]], axis: str, unit: str, *, title: str, path: Path) -> None:
    """Draw remedies.parquet's rows into ``path`` (PNG). Raises `ComputationError` if the file cannot be written."""
    found = over_axis(rows, axis)
    names = list(found)
    values = [row[axis] for row in found[names[0]]]
    figure = theme.figure(width=3.6 + 0.75 * len(values), height=1.9 + 0.27 * len(names))
    axes = figure.subplots()
    colours = [[_colour(row) for row in found[name]] for name in names]
    image = axes.imshow(colours, cmap="RdBu", vmin=-REACH, vmax=REACH, aspect="auto", interpolation="nearest")
    for i, name in enumerate(names):
        for j, row in enumerate(found[name]):
            dark = abs(colours[i][j]) > 0.65 * REACH
            axes.text(j, i, said(row), ha="center", va="center", fontsize=8, color="white" if dark else "black")
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.set_xticks(range(len(values)), [f"{value:.3g}" for value in values], fontsize=8)
    axes.set_xlabel(f"{axis}, {unit}" if unit != "1" else axis)
    bar = figure.colorbar(image, ax=axes, ticks=[-3, -2, -1, 0, 1, 2, 3], fraction=0.05)
    bar.ax.set_yticklabels(["1/8", "1/4", "1/2", "1", "2", "4", "8"])
    bar.set_label("times smaller (red: larger)")
    figure.suptitle(
        f"{title}: largest cycle of the plain reference over that of each remedy,\n"
        "for the hand and cell that gain least (*: outside the controller's domain)",
        fontsize=9,
    )
    save(figure, path, stage="remedies", name=title)


def _colour(row: dict[str, Any]) -> float:
    """Twofold steps by which the cycle is smaller, within the colours' reach."""
    if row["starts"]:
        return -REACH
    if row["rests"]:
        return REACH
    times = row["times_least"]
    return 0.0 if times is None else max(-REACH, min(REACH, log2(times)))


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
                _tried_range(
                    panel, [scale * row[which + column] for row in mine if row[which + column]], y + apart, style
                )
            share = _share(mine, computed=bool(which))
            if share is not None:
                panels[3].plot([share], [y + apart], marker="o", markersize=5.0, **style)
        panels[0].plot([], [], marker="o", markersize=5.0, label=label, **style)
    _dress_tried(panels, names, reference)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure


def _tried_range(panel: "Axes", values: list[float], y: float, style: dict[str, Any]) -> None:
    if values:
        panel.plot([min(values), max(values)], [y, y], linewidth=1.4, **style)
        panel.plot([median(values)], [y], marker="o", markersize=5.0, **style)


def _share(rows: Rows, *, computed: bool) -> float | None:
    """How many of the trials, or starts, buzz, in per cent; None where that is not known."""
    if not computed:
        return 100.0 * float(sum(row["sustained"] for row in rows) / sum(row["trials"] for row in rows))
    rest = [row["computed_at_rest_fraction"] for row in rows if row["computed_at_rest_fraction"] is not None]
    return 100.0 * (1.0 - fmean(rest)) if rest else None


def _dress_tried(panels: "list[Axes]", names: list[str], reference: str) -> None:
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
