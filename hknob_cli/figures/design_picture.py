"""A search for a design: what designs cost, how far above threshold they are felt, and the grid of plain walls.

A search for a design: what every design costs, and how far above threshold it is felt, with the answer marked.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.sheet import save
from hknob_cli.report.design import flagged, limits, name_of
from hknob_cli.results.result_set import MissingError, ResultSet, Rows
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.stage_plans import DesignPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 600  # designs drawn, which each take room in the file

Row = dict[str, Any]


class _Heights(NamedTuple):
    """Where designs stand, dB: at their levels, those at rest below them all, those without a known level above."""

    rest: float
    unknown: float
    room: float  # from these to the next level

    def of(self, row: Row) -> float:
        """The height of a design."""
        level: float | None = row["touch_db"]
        return level if level is not None else self.unknown if row["unknown"] else self.rest


def _heights(rows: Rows, part: float) -> _Heights:
    """Heights of ends that are a ``part`` of the levels' range away from them."""
    known = [row["touch_db"] for row in rows if row["touch_db"] is not None] or [0.0]
    room = part * max(1.0, max(known) - min(known))
    return _Heights(min(known) - room, max(known) + room, room)


@drawing
def design_costs(evidence: ResultSet, of: str) -> "Figure":
    """Touch (dB above threshold) over cost, a marker a remedy: filled where every limit is met, hollow where not.

    The line joins the front: designs stiff enough that nothing as cheap and as stiff is felt less. Designs at rest are
    below the axis, and those of which no level is known above it. If there are more than 600 designs, those on the
    front and others from all over are drawn. Raises `MissingError` for a result of another kind.
    """
    rows = evidence[of].rows("design")
    if not rows:
        raise MissingError(f"'{of}' has no designs")
    shown = _thinned(rows)
    figure = theme.figure(4.0)
    panel = figure.subplots()
    heights = _heights(rows, 0.09)
    height = heights.of
    _mark_designs(panel, rows, shown, heights)
    for flag, marker, size, text in (("present", "s", 13.0, "the present design"), ("chosen", "*", 17.0, "the answer")):
        for row in (row for row in rows if row[flag]):
            panel.plot([row["cost"]], [height(row)], marker=marker, markersize=size, fillstyle="none", color="black",
                       linestyle="none", label=text)  # fmt: skip
    _label_ends(panel, rows, heights)
    panel.margins(x=0.06, y=0.1)
    panel.set_xlabel("cost (filled: meets every limit)")
    panel.set_ylabel("touch, dB above threshold")
    if len(shown) < len(rows):
        figure.supxlabel(f"{len(shown)} of {len(rows):,} designs", fontsize=8)
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper left", ncols=4)
    return figure


def _label_ends(panel: "Axes", rows: Rows, heights: _Heights) -> None:
    """Ticks in words for designs at rest, and for those of which no level is known."""
    named = []
    if any(row["touch_db"] is None and not row["unknown"] for row in rows):
        named.append((heights.rest, "rest "))
    if any(row["touch_db"] is None and row["unknown"] for row in rows):
        named.append((heights.unknown, "not known "))
    for place, text in named:
        panel.text(0.99, place, text, ha="right", va="center", fontsize=8, transform=panel.get_yaxis_transform())
        panel.axhline(place, color="black", linewidth=0.5, alpha=0.3, linestyle=(0, (1, 2)))


def _thinned(rows: Rows) -> Rows:
    """All designs, or of very many those that are marked and others from all over."""
    if len(rows) <= MOST:
        return rows
    marked = [row for row in rows if row["front"] or row["chosen"] or row["present"]]
    others = [row for row in rows if not (row["front"] or row["chosen"] or row["present"])]
    return marked[:MOST] + others[:: 1 + len(others) // MOST]


def draw_design(plan: DesignPlan, rows: list[Row], *, path: Path) -> None:
    """Draw design.parquet's rows into ``path`` (PNG). Raises `ComputationError` if the file cannot be written."""
    plain = [row for row in rows if row["notional"] is not None]
    wide = min(len({row[RATE] for row in plain}), len({row[COUNTS] for row in plain})) > 1 if plain else False
    figure = theme.figure(width=15.0 if wide else 9.0, height=7.2)
    if wide:
        grid = figure.add_gridspec(2, 2, width_ratios=(1.6, 1.0))
        axes = figure.add_subplot(grid[:, 0])
        upper, lower = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
        _map(
            upper,
            plain,
            "touch_db",
            "plain walls: touch, dB above threshold (frame: rate and counts of the answer)",
            chosen=flagged(rows, "chosen"),
        )
        _map(lower, plain, "notional", "plain walls: Hasser's notional surface (Fig. 70); small is good")
    else:
        axes = figure.add_subplot()
    _scatter(axes, plan, rows)
    figure.suptitle(f"{plan.name}: what a quiet knob costs\n{'; '.join(limits(plan)) or 'no limits'}", fontsize=10)
    save(figure, path, stage="design", name=plan.name)


def _scatter(axes: "Axes", plan: DesignPlan, rows: list[Row]) -> None:
    heights = _heights(rows, 0.08)
    _mark_designs(axes, rows, rows, heights)
    for flag in ("present", "chosen"):
        if row := flagged(rows, flag):
            _mark_one(axes, plan, row, heights.of(row), flag)
    text: dict[str, Any] = {"ha": "right", "transform": axes.get_yaxis_transform(), "color": "0.4"}
    if any(row["touch_db"] is None and not row["unknown"] for row in rows):
        axes.axhspan(heights.rest - heights.room, heights.rest + 0.5 * heights.room, color="0.93", zorder=-1)
        axes.text(0.99, heights.rest, "at rest ", va="center", **text)
    if any(row["unknown"] for row in rows):
        axes.text(0.99, heights.unknown, "not known ", va="bottom", **text)
    if plan.touch:
        limit, off = _touch_limit(plan, rows), plan.uncertainty_db
        axes.axhspan(limit - off, limit + off, color="C3", alpha=0.1, linewidth=0.0, zorder=-1)
        axes.axhline(limit, color="C3", linewidth=0.9, linestyle="--")
    axes.set_xlabel("cost (open: fails a limit, filled: meets all; line: front)")
    axes.set_ylabel(
        "touch, dB above threshold, of all but the allowed share of people\n"
        "(dashed: allowed; band: how well that is known)"
    )
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=8, frameon=True)


def _mark_designs(axes: "Axes", rows: Rows, shown: Rows, heights: _Heights) -> None:
    """A marker a remedy for those ``shown``, filled where every limit is met, and the line of the front."""
    for i, name in enumerate(dict.fromkeys(row["remedy"] for row in rows)):
        for feasible in (False, True):
            mine = [row for row in shown if row["remedy"] == name and row["feasible"] == feasible]
            style = theme.points(i) | ({} if feasible else {"markerfacecolor": "none"})
            axes.plot([row["cost"] for row in mine], [heights.of(row) for row in mine], markersize=5.0, **style)
        axes.plot([], [], label=name, **theme.points(i))
    front = sorted((row for row in rows if row["front"]), key=lambda row: float(row["cost"]))
    axes.step([row["cost"] for row in front], [heights.of(row) for row in front], where="post", color="black",
              linewidth=0.8, alpha=0.6, zorder=0)  # fmt: skip


def _mark_one(axes: "Axes", plan: DesignPlan, row: Row, height: float, flag: str) -> None:
    """The present design, or the chosen one, with what it is."""
    chosen = flag == "chosen"
    mark, size, colour, face = ("*", 420, "crimson", "crimson") if chosen else ("s", 190, "black", "none")
    axes.scatter([row["cost"]], [height], marker=mark, s=size, edgecolors=colour, facecolors=face, zorder=3)
    said = name_of(plan, row).replace(", ", "\n")
    unproven = "" if row["certified"] else " (not proven for all)"
    axes.annotate(
        f"{flag}{unproven}: cost {row['cost']:g}\n{said}",
        (row["cost"], height),
        xytext=(14, 12),
        textcoords="offset points",
        fontsize=8,
        va="bottom",
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.5},
        zorder=4,
    )


def _touch_limit(plan: DesignPlan, rows: list[Row]) -> float:
    """What is allowed; of a limit above the present design, that of its level."""
    assert plan.touch
    there = flagged(rows, "present") or {}
    return plan.touch.most_db + ((there.get("touch_db") or 0.0) if plan.touch.above_present else 0.0)


def _map(axes: "Axes", rows: list[Row], column: str, title: str, chosen: Row | None = None) -> None:
    rates = sorted({row[RATE] for row in rows})
    counts = sorted({row[COUNTS] for row in rows})
    at = {(row[RATE], row[COUNTS]): row[column] for row in rows}
    values = [
        [float("nan") if at.get((rate, count)) is None else at[rate, count] for count in counts] for rate in rates
    ]
    image = axes.imshow(values, origin="lower", aspect="auto", cmap="viridis")
    middle = sum(image.get_clim()) / 2.0
    for i, line in enumerate(values):
        for j, value in enumerate(line):
            text = "rest" if value != value else f"{value:.3g}"
            axes.text(j, i, text, ha="center", va="center", fontsize=8, color="black" if value > middle else "white")
    if chosen and chosen[RATE] in rates and chosen[COUNTS] in counts:
        place = counts.index(chosen[COUNTS]), rates.index(chosen[RATE])
        axes.scatter(*place, marker="s", s=900, facecolors="none", edgecolors="crimson", linewidths=1.6)
    axes.set_xticks(range(len(counts)), [f"{count:g}" for count in counts])
    axes.set_yticks(range(len(rates)), [f"{rate:g}" for rate in rates])
    axes.set_xlabel("encoder, counts per revolution")
    axes.set_ylabel("sample rate, Hz")
    axes.set_title(title, fontsize=9)
