"""What one cell ends in: the range of the angle of every attractor, inside and outside the wall, pitch and share."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import axes_of
from hknob_cli.figures.numbers import number
from hknob_cli.figures.panel import edges_between
from hknob_cli.figures.trajectory_picture import Scale
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import COUNTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 30  # attractors


@drawing
def attractors(evidence: ResultSet, of: str) -> "Figure":
    """A bar from least to largest angle for every attractor of the one cell of a sweep, the most frequent uppermost.

    Beside it stand peak to peak, frequency, and the share of the trials that end there. The wall is shaded; dotted
    lines are count edges, where they are few. Trials that diverge or stay undecided have no bar. Of more than 30
    attractors the most frequent are drawn. Raises `MissingError` for a sweep of several cells.
    """
    result = evidence[of]
    rows = result.rows("orbits")
    axes = axes_of(result, rows)
    if not rows or len({tuple(row[axis] for axis in axes) for row in rows}) > 1:
        raise MissingError(f"'{of}' is not a sweep of one cell")
    shown = sorted(rows, key=lambda row: -row["basin_fraction"])[:MOST]
    figure = theme.figure(0.34 * len(shown) + 1.2)
    panel = figure.subplots()
    ends = [abs(row[name]) for row in shown for name in ("min_rad", "max_rad") if row.get(name) is not None]
    unit = Scale(10.0 * max(ends, default=1e-3))
    for i, row in enumerate(shown):
        _bar(panel, row, len(shown) - 1 - i, unit)
    low, high = panel.get_xlim()
    low, high = min(low, -0.05 * (high - low)), max(high, 0.05 * (high - low))
    panel.axvspan(low, 0.0, color="black", alpha=0.06, linewidth=0)
    panel.axvline(0.0, color="black", linewidth=0.8, linestyle=(0, (4, 2)))
    if counts := rows[0].get(COUNTS):
        for edge in edges_between(low, high, unit.factor * 6.283185307179586 / counts):
            panel.axvline(edge, color="black", linewidth=0.5, alpha=0.35, linestyle=(0, (1, 2)))
    panel.set_xlim(low, high)
    panel.set_ylim(-0.7, len(shown) - 0.3)
    panel.grid(visible=False)
    panel.set_xlabel(f"angle, {unit.prefix}rad (shaded: inside the wall)")
    panel.set_yticks(range(len(shown)), [f"{100 * row['basin_fraction']:.3g} %" for row in reversed(shown)])
    panel.set_ylabel("trials")
    right = panel.secondary_yaxis("right")
    right.set_yticks(range(len(shown)), [_said(row) for row in reversed(shown)], fontsize=8)
    right.tick_params(length=0)
    if len(rows) > len(shown):
        figure.supxlabel(f"{len(shown)} of {len(rows)} attractors, the most frequent", fontsize=8)
    return figure


def _bar(panel: "Axes", row: dict[str, float | None], place: int, unit: Scale) -> None:
    low, high = row.get("min_rad"), row.get("max_rad")
    if low is None or high is None:
        return
    ends = [unit.factor * low, unit.factor * high]
    panel.plot(ends, [place, place], color=theme.COLOURS[0], linewidth=5.0, solid_capstyle="butt")
    if not row["p2p_rad"]:
        panel.plot(ends[:1], [place], color=theme.COLOURS[0], marker="D", markersize=5.0)


def _said(row: dict[str, float | str | None]) -> str:
    """An attractor in words."""
    if row["outcome"] != "cycle" or not row["p2p_rad"]:
        return {"cycle": "undecided", "rest": "at rest"}.get(str(row["outcome"]), str(row["outcome"]))
    pitch = f", {number(float(row['frequency_hz']))} Hz" if row["frequency_hz"] else ""
    proven = "" if row["certified"] else ", not proven"
    return f"{number(1e3 * float(row['p2p_rad']))} mrad{pitch}{proven}"
