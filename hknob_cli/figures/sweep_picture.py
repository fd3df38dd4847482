"""The pictures of a sweep of one cell, and of one over a population.

Of one cell: the motion on each of its orbits over time, and in the phase plane. Of a population: how many people have
at most so much, or maps of how many and how much.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.figures import theme
from hknob_cli.figures.defaults import figures_of
from hknob_cli.figures.grid import axis_name
from hknob_cli.figures.heat import colour_map
from hknob_cli.figures.sheet import save, write_sheet
from hknob_cli.report.large import Row, describe_people
from hknob_cli.report.table import is_whole, short
from hknob_cli.results.result_set import Held
from hknob_cli.specs.plan import PERSON

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

PERIODS = 3  # of the slowest cycle that is shown
MOST_EDGES = 20
MOST_UNDRAWN = 6  # cycles that are named though no motion on them is drawn
SETTLED = 0.02  # of an orbit's peak to peak: how near a recording's must be
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")


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
        style: dict[str, Any] = {"color": _COLOURS[i % len(_COLOURS)], "linewidth": 1.3}
        over_time.plot(1e3 * (one.time - one.time[0]), 1e3 * one.angle, label=one.name, **style)
        plane.plot(1e3 * one.angle, one.velocity, **style)
    drawn = {one.name for one in motions}
    for cycle in [row for row in orbits if row["outcome"] == "cycle" and _called(row) not in drawn][:MOST_UNDRAWN]:
        over_time.plot([], [], linestyle="none", label=f"not drawn, no recorded trial ends there: {_called(cycle)}")
    over_time.set_xlabel("time, ms")
    over_time.set_ylabel("angle, mrad (the wall is below 0)")
    plane.set_xlabel("angle, mrad (the wall is left of 0)")
    plane.set_ylabel("velocity, rad/s")
    _edges(over_time, plane, quantum)
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
        name = _name(angle[late], cycles)
        found.setdefault(name, Motion(time[late], angle[late], velocity[late], name))
    return sorted(found.values(), key=lambda one: -float(np.ptp(one.angle)))


def period_of(cycle: dict[str, Any]) -> float:
    """Seconds after which a cycle of orbits.parquet repeats itself."""
    return float(cycle["cycles_per_period"]) / float(cycle["frequency_hz"])


def _name(angle: "NDArray[np.float64]", cycles: list[dict[str, Any]]) -> str:
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


def _edges(over_time: "Axes", plane: "Axes", quantum: float | None) -> None:
    """The wall's edge, and those of counts where they can be told apart."""
    low, high = over_time.get_ylim()
    over_time.axhline(0.0, color="0.3", linewidth=1.0, linestyle=":", label="edge of the wall")
    plane.axvline(0.0, color="0.3", linewidth=1.0, linestyle=":")
    if quantum and (high - low) / (1e3 * quantum) <= MOST_EDGES:
        first, last = int(np.ceil(low / (1e3 * quantum))), int(np.floor(high / (1e3 * quantum)))
        for count in range(first, last + 1):
            over_time.axhline(1e3 * quantum * count, color="0.7", linewidth=0.6, linestyle=(0, (1, 3)), zorder=0)
            plane.axvline(1e3 * quantum * count, color="0.7", linewidth=0.6, linestyle=(0, (1, 3)), zorder=0)
    over_time.set_ylim(low, high)


def draw_population(cells: list[Row], axes: list[str], *, title: str, path: Path) -> bool:
    """Draw into ``path`` (PNG): maps over two axes, else curves; False, drawing nothing, without a grid of so few.

    Raises `ComputationError` if the file cannot be written.
    """
    axes = [axis for axis in axes if axis != PERSON]
    wide = [axis for axis in axes if len({row[axis] for row in cells}) > 1]
    if len(wide) > 2 or not is_whole(cells, wide):
        return False
    fixed = ", ".join(f"{axis} = {cells[0][axis]:g}" for axis in axes if axis not in wide)
    from matplotlib.figure import Figure

    if len(wide) < 2:
        result = Held(title, "sweep", {"cells": pa.Table.from_pylist(cells)}, [*axes, PERSON])
        return write_sheet(result, figures_of(result), path=path)
    figure = Figure(figsize=(13.5, 0.52 * len({row[wide[0]] for row in cells}) + 2.6), layout="constrained")
    _maps(figure, describe_people(cells, axes), wide)
    people = len({row[PERSON] for row in cells})
    figure.suptitle(f"{title}: limit cycles of {people} people" + (f"  ({fixed})" if fixed else ""))
    save(figure, path, stage="sweep", name=title)
    return True


def _maps(figure: "Figure", rows: list[Row], wide: list[str]) -> None:
    import numpy as np

    down, across = wide
    downs, acrosses = (sorted({row[axis] for row in rows}) for axis in wide)
    grid = {(row[down], row[across]): row for row in rows}
    left, right = figure.subplots(1, 2, sharey=True)
    panels: tuple[tuple[Axes, str, float, str, tuple[float, float] | None], ...] = (
        (left, "buzzing_fraction", 100.0, "people for whom the knob buzzes, %", (0.0, 100.0)),
        (right, "p2p_max_rad_p95", 1e3, "peak to peak, mrad: 95 % of the people have less", None),
    )
    for axes, column, scale, label, limits in panels:
        table: Any = [[grid[d, a][column] for a in acrosses] for d in downs]
        values = np.array([[np.nan if value is None else scale * value for value in line] for line in table])
        inks = colour_map(axes, values, label, limits=limits)
        axes.set_xticks(range(len(acrosses)), [f"{value:.6g}" for value in acrosses], rotation=30, ha="right")
        axes.set_xlabel(axis_name(across))
        for i, j in np.ndindex(*values.shape) if len(rows) <= 400 else ():
            text = "" if np.isnan(values[i, j]) else f"{values[i, j]:.3g}"
            axes.text(j, i, text, ha="center", va="center", fontsize=8, color=inks[i][j])
    left.set_yticks(range(len(downs)), [f"{float(f'{value:.4g}'):g}" for value in downs])
    left.set_ylabel(axis_name(down))
