"""What one cell ends in: its attractors, from which states each is reached, and the motion on its orbits.

Of an attractor: the range of its angle, inside and outside the wall, pitch and share. Motion is drawn over time, and in
the phase plane.
"""

from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import axes_of
from hknob_cli.figures.numbers import number
from hknob_cli.figures.panel import Scale, edges_between
from hknob_cli.figures.sheet import save
from hknob_cli.report.table import short
from hknob_cli.results.result_set import MissingError, ResultSet, Where, matching
from hknob_cli.specs.plan import COUNTS, RATE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

MOST = 30  # attractors

MOST_PANELS = 6
MOST_NAMED = 8  # attractors in a legend
MOST_EDGES = 120  # count edges that are drawn as lines
PERIODS = 3  # of the slowest cycle that is shown
MOST_LINES = 20
MOST_UNDRAWN = 6  # cycles that are named though no motion on them is drawn
SETTLED = 0.02  # of an orbit's peak to peak: how near a recording's must be
_INKS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# Colours that people with any kind of colour vision tell apart (Okabe & Ito 2008), pale ones last.
_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#999999")


@drawing
def attractors(evidence: ResultSet, of: str) -> "Figure":
    """A bar from least to largest angle for every attractor of the one cell of a sweep, the most frequent uppermost.

    Beside it stand peak to peak, frequency, and the share of the trials that end there. The wall is shaded; dotted
    lines are count edges, where they are few. Trials that diverge or stay undecided have no bar. The 30 most
    frequent attractors are drawn. Raises `MissingError` for a sweep of several cells.
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


@drawing
def basins(evidence: ResultSet, of: str, where: Where | None = None) -> "Figure":
    """A map for each cell of a sweep that has maps of basins, of the first six that ``where`` allows.

    Every start has the colour of the attractor it ends in, white where that is not proven; dots are samples of the
    attractors. Raises `MissingError` for a sweep without such maps.
    """
    result = evidence[of]
    axes = result.axes
    cells = maps_of(result.table("basins"), result.table("orbits"), axes)
    named = [dict(zip(axes, one.cell, strict=True)) for one in cells]
    kept = [one for one, cell in zip(cells, named, strict=True) if matching([cell], where or {})]
    if not kept:
        raise MissingError(f"no such cell in the maps of '{of}'")
    shown = kept[:MOST_PANELS]
    across = min(2, len(shown))
    figure = theme.figure(3.3 * ceil(len(shown) / across))
    panels = figure.subplots(ceil(len(shown) / across), across, squeeze=False)
    for empty in list(panels.flat)[len(shown) :]:
        empty.set_axis_off()
    for panel, one in zip(panels.flat, shown, strict=False):
        draw_map(panel, one)
        panel.set_title(", ".join(_axis_value(*pair) for pair in zip(axes, one.cell, strict=True)))
        panel.grid(visible=False)
    if len(kept) > len(shown):
        figure.supxlabel(f"the first {len(shown)} of {len(kept)} cells", fontsize=8)
    return figure


def _axis_value(axis: str, value: float) -> str:
    """The value of an axis in words."""
    unit = {RATE: " Hz", COUNTS: " counts"}.get(axis)
    return f"{number(value)}{unit}" if unit else f"{axis} {number(value)}"


class BasinMap(NamedTuple):
    """A cell by its values on the axes; its rows of basins.parquet, and of orbits.parquet."""

    cell: tuple[Any, ...]
    table: pa.Table
    orbits: list[dict[str, Any]]


def maps_of(basins: pa.Table, orbits: pa.Table, axes: list[str]) -> list[BasinMap]:
    """The maps of a sweep's cells, in their order."""
    cells: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in orbits.to_pylist():
        cells.setdefault(tuple(row[name] for name in axes), []).append(row)
    keys = zip(*(basins[name].to_numpy() for name in axes), strict=True)
    place = {key: i for i, key in enumerate(cells)}
    which = np.fromiter((place[key] for key in keys), dtype=np.int64, count=basins.num_rows)
    return [BasinMap(key, basins.filter(pa.array(which == i)), rows) for i, (key, rows) in enumerate(cells.items())]


def draw_map(panel: Any, one: BasinMap) -> None:
    """One cell: its starts in the colour of where they end, white where that is not proven; attractors as dots."""
    from matplotlib.colors import ListedColormap

    table, orbits = one.table, one.orbits
    angle, velocity = 1e3 * table["angle_rad"].to_numpy(), table["velocity_rad_s"].to_numpy()
    orbit, on_orbit = table["orbit"].to_numpy(zero_copy_only=False), table["on_orbit"].to_numpy(zero_copy_only=False)
    side = int(np.sqrt(np.count_nonzero(~on_orbit)))
    grid = np.ma.masked_invalid(orbit[~on_orbit].astype(np.float64).reshape(side, side))
    spread = [values[~on_orbit] for values in (angle, velocity)]
    halves = [0.5 * (float(values.max()) - float(values.min())) / (side - 1) for values in spread]
    (left, right), (bottom, top) = (
        (float(values.min()) - half, float(values.max()) + half) for values, half in zip(spread, halves, strict=True)
    )
    colours = [_COLOURS[i % len(_COLOURS)] for i in range(len(orbits))]
    panel.imshow(
        grid % len(_COLOURS),
        origin="lower",
        aspect="auto",
        extent=(left, right, bottom, top),
        cmap=ListedColormap(_COLOURS),
        vmin=-0.5,
        vmax=len(_COLOURS) - 0.5,
        alpha=0.45,
        interpolation="nearest",
    )
    _draw_edges(panel, orbits, left, right)
    for place, row in enumerate(orbits):
        own = on_orbit & (orbit == place)
        label = _name(row) if place < MOST_NAMED else None
        panel.scatter(
            angle[own], velocity[own], s=14, color=colours[place], edgecolors="white", linewidths=0.5, label=label
        )
    panel.axvline(0.0, color="black", linewidth=0.8)
    panel.set_xlim(left, right)
    panel.set_ylim(bottom, top)
    panel.set_xlabel("angle at a sample, mrad (the wall is left of 0)")
    panel.set_ylabel("velocity, rad/s")
    panel.legend(fontsize=8, loc="upper right", frameon=True, framealpha=0.9)


def _draw_edges(panel: Any, orbits: list[dict[str, Any]], left: float, right: float) -> None:
    """Count edges inside the wall, where there are few enough to be seen."""
    counts = orbits[0].get("counts_per_rev")
    if not counts:
        return
    quantum = 2e3 * np.pi / counts
    edges = np.arange(np.ceil(left / quantum), 0) * quantum
    if len(edges) <= MOST_EDGES:
        for edge in edges[edges < right]:
            panel.axvline(edge, color="black", linewidth=0.25, alpha=0.5)


def _name(one: dict[str, Any]) -> str:
    share = f"{100 * one['basin_fraction']:.3g} % of starts"
    if one["outcome"] == "cycle":
        return f"{1e3 * one['p2p_rad']:.3g} mrad, {one['frequency_hz']:.3g} Hz: {share}"
    return f"{one['outcome']}: {share}"


class Motion(NamedTuple):
    """The end of a recorded trial: time (s), angle (rad), velocity (rad/s), and what it is called."""

    time: "NDArray[np.float64]"
    angle: "NDArray[np.float64]"
    velocity: "NDArray[np.float64]"
    name: str


def draw_one_cell(
    recorded: pa.Table, orbits: list[dict[str, Any]], quantum: float | None, *, title: str, path: Path
) -> None:
    """Draw into ``path`` (PNG); ``recorded``: some trials, to their ends; ``quantum``: angle of a count, if any (rad).

    Raises `ComputationError` if the file cannot be written.
    """
    motions = _motions(recorded, orbits)
    figure = theme.figure(width=13.0, height=6.0)
    over_time, plane = figure.subplots(1, 2)
    for i, one in enumerate(motions):
        style: dict[str, Any] = {"color": _INKS[i % len(_INKS)], "linewidth": 1.3}
        over_time.plot(1e3 * (one.time - one.time[0]), 1e3 * one.angle, label=one.name, **style)
        plane.plot(1e3 * one.angle, one.velocity, **style)
    drawn = {one.name for one in motions}
    for cycle in [row for row in orbits if row["outcome"] == "cycle" and _called(row) not in drawn][:MOST_UNDRAWN]:
        over_time.plot([], [], linestyle="none", label=f"not drawn, no recorded trial ends there: {_called(cycle)}")
    over_time.set_xlabel("time, ms")
    over_time.set_ylabel("angle, mrad (the wall is below 0)")
    plane.set_xlabel("angle, mrad (the wall is left of 0)")
    plane.set_ylabel("velocity, rad/s")
    _lines_of_counts(over_time, plane, quantum)
    figure.legend(*over_time.get_legend_handles_labels(), fontsize=9, loc="outside lower center", ncols=2)
    figure.suptitle(f"{title}: motion against a virtual wall")
    save(figure, path, stage="sweep", name=title)


def _motions(recorded: pa.Table, orbits: list[dict[str, Any]]) -> list[Motion]:
    """The last periods of one trial for each orbit that is reached; all of it where nothing cycles."""
    columns = {name: recorded[name].to_numpy() for name in ("trial", "time_s", "angle_rad", "velocity_rad_s")}
    cycles = [row for row in orbits if row["outcome"] == "cycle"]
    window = PERIODS * max((period_of(row) for row in cycles), default=0.0)
    found: dict[str, Motion] = {}
    for trial in dict.fromkeys(columns["trial"].tolist()):
        time, angle, velocity = (
            columns[name][columns["trial"] == trial] for name in ("time_s", "angle_rad", "velocity_rad_s")
        )
        late = time >= (time[-1] - window if window else 0.0)
        name = _settled_on(angle[late], cycles)
        found.setdefault(name, Motion(time[late], angle[late], velocity[late], name))
    return sorted(found.values(), key=lambda one: -float(np.ptp(one.angle)))


def period_of(cycle: dict[str, Any]) -> float:
    """Seconds after which a cycle of orbits.parquet repeats itself."""
    return float(cycle["cycles_per_period"]) / float(cycle["frequency_hz"])


def _settled_on(angle: "NDArray[np.float64]", cycles: list[dict[str, Any]]) -> str:
    """Size, pitch and share of the cycle with the same extremes as a motion; else that it is none of them."""
    low, high = float(angle.min()), float(angle.max())

    def apart(cycle: dict[str, Any]) -> float:
        return max(abs(low - float(cycle["min_rad"])), abs(high - float(cycle["max_rad"])))

    nearest = min(cycles, key=apart, default=None)
    if nearest is None or apart(nearest) > SETTLED * nearest["p2p_rad"]:
        return "on its way" if cycles else "no cycle"
    return _called(nearest)


def _called(cycle: dict[str, Any]) -> str:
    """A cycle's size, pitch and share."""
    size, pitch = short(1e3 * cycle["p2p_rad"]), short(cycle["frequency_hz"])
    proven = "proven" if cycle["certified"] else "not proven"
    return f"{size} mrad, {pitch} Hz, {short(100.0 * cycle['basin_fraction'])} % of the starts, {proven}"


def _lines_of_counts(over_time: "Axes", plane: "Axes", quantum: float | None) -> None:
    """The wall's edge, and those of counts where they can be told apart."""
    low, high = over_time.get_ylim()
    over_time.axhline(0.0, color="0.3", linewidth=1.0, linestyle=":", label="edge of the wall")
    plane.axvline(0.0, color="0.3", linewidth=1.0, linestyle=":")
    if quantum and (high - low) / (1e3 * quantum) <= MOST_LINES:
        first, last = int(np.ceil(low / (1e3 * quantum))), int(np.floor(high / (1e3 * quantum)))
        for count in range(first, last + 1):
            over_time.axhline(1e3 * quantum * count, color="0.7", linewidth=0.6, linestyle=(0, (1, 3)), zorder=0)
            plane.axvline(1e3 * quantum * count, color="0.7", linewidth=0.6, linestyle=(0, (1, 3)), zorder=0)
    over_time.set_ylim(low, high)
