"""A trial of remedies at one case: what each leaves of the buzz, at what pitch, and what it costs in stiffness."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
        _plain_numbers(axes)
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


def _plain_numbers(axes: "Axes") -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 80.0 * low else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", labelsize=7.5)
