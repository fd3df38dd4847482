"""Values of one cell by method or law as bars, beside what a sweep has found there."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Row = dict[str, Any]


def draw_bars(axes: "Axes", rows: Sequence[Row], by: str, column: str, scale: float, label: str) -> None:
    """A bar for each row with a value, faint outside the domain; a line at the sweep's value, where there is one."""
    shown = [row for row in rows if row[column] is not None]
    names = [str(row[by]).replace("_", " ") for row in shown]
    values = [scale * row[column] for row in shown]
    places = list(range(len(shown)))
    bars = axes.barh(places, values, color="#0072B2")
    for bar, row in zip(bars, shown, strict=True):
        bar.set_alpha(1.0 if row["in_domain"] else 0.35)
    for place, value in zip(places, values, strict=True):
        axes.text(
            0.0, place, f"  {value:.4g}", va="center", fontsize=9, bbox={"facecolor": "white", "pad": 1.5, "lw": 0}
        )
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.set_xlabel(f"{label}    (faint: out of domain)")
    swept = next((scale * row[f"sweep_{column}"] for row in shown if row.get(f"sweep_{column}")), None)
    if swept is not None:
        axes.axvline(swept, color="black", linestyle="--", linewidth=1.2)
        axes.set_title(f"dashed: the sweep's mean, {swept:.4g}", fontsize=9)
