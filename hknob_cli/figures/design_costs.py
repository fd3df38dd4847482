"""A search for a design: what every design costs, and how far above threshold it is felt, with the answer marked."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, object]
MOST = 600  # designs drawn, which each take room in the file


@drawing
def design_costs(evidence: ResultSet, of: str) -> "Figure":
    """Touch (dB above threshold) over cost, a marker a remedy: filled where every limit is met, hollow where not.

    The line joins the front: designs stiff enough that nothing as cheap and as stiff is felt less. Designs at rest are
    below the axis, and those of which no level is known above it. Of more than 600 designs those on the front, and
    others from all over, are drawn. Raises `MissingError` for a result of another kind.
    """
    rows = evidence[of].rows("design")
    if not rows:
        raise MissingError(f"'{of}' has no designs")
    shown = _thinned(rows)
    figure = theme.figure(4.0)
    panel = figure.subplots()
    known = [row["touch_db"] for row in rows if row["touch_db"] is not None]
    low, high = min(known, default=0.0), max(known, default=0.0)
    room = 0.09 * max(1.0, high - low)
    rest, unknown = low - room, high + room

    def height(row: dict[str, float | None]) -> float:
        level = row["touch_db"]
        return level if level is not None else unknown if row["unknown"] else rest

    for i, name in enumerate(dict.fromkeys(row["remedy"] for row in rows)):
        for feasible in (False, True):
            mine = [row for row in shown if row["remedy"] == name and row["feasible"] == feasible]
            style = theme.points(i) | ({} if feasible else {"markerfacecolor": "none"})
            panel.plot([row["cost"] for row in mine], [height(row) for row in mine], markersize=5.0, **style)
        panel.plot([], [], label=name, **theme.points(i))
    front = sorted((row for row in rows if row["front"]), key=lambda row: float(row["cost"]))
    panel.step([row["cost"] for row in front], [height(row) for row in front], where="post", color="black",
               linewidth=0.8, alpha=0.6, zorder=0)  # fmt: skip
    for flag, marker, size, text in (("present", "s", 13.0, "the present design"), ("chosen", "*", 17.0, "the answer")):
        for row in (row for row in rows if row[flag]):
            panel.plot([row["cost"]], [height(row)], marker=marker, markersize=size, fillstyle="none", color="black",
                       linestyle="none", label=text)  # fmt: skip
    _label_ends(panel, rows, rest, unknown)
    panel.margins(x=0.06, y=0.1)
    panel.set_xlabel("cost (filled: meets every limit)")
    panel.set_ylabel("touch, dB above threshold")
    if len(shown) < len(rows):
        figure.supxlabel(f"{len(shown)} of {len(rows):,} designs", fontsize=8)
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper left", ncols=4)
    return figure


def _label_ends(panel: "Axes", rows: Rows, rest: float, unknown: float) -> None:
    """Ticks in words for designs at rest, and for those of which no level is known."""
    named = []
    if any(row["touch_db"] is None and not row["unknown"] for row in rows):
        named.append((rest, "rest "))
    if any(row["touch_db"] is None and row["unknown"] for row in rows):
        named.append((unknown, "not known "))
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
