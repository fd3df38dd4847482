"""What panels of motion share: units, the wall and its counts, keys above the axes, steps; and recorded trials.

Recorded trials are drawn as in Hasser, Figs. 22-28: the torque is divided by -K, so that a wall that follows the angle
at once and exactly would lie on it; where that would dwarf the motion (Fig. 24), it has a scale of its own. Below, the
energy of knob, hand and push, bold while the wall does not act: what leaks in shows there. Without a wall (Figs. 15,
16) the accelerations.
"""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from hknob_cli.figures import theme
from hknob_cli.figures.recording import Recording
from hknob_cli.figures.sheet import save
from hknob_cli.report.table import short

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_PANELS = 6
HIDDEN = 2.0  # times the motion that the torque may be, in angle, before it gets a scale of its own
_PREFIXES = (("", 1.0), ("m", 1e3), ("\u00b5", 1e6), ("n", 1e9))


class Scale:
    """A unit that suits the largest of some numbers: its prefix, and the factor from SI."""

    def __init__(self, largest: float) -> None:
        self.prefix, self.factor = next(
            ((prefix, factor) for prefix, factor in _PREFIXES[1:] if largest * factor >= 1.0), _PREFIXES[-1]
        )

    def of(self, rows: list[dict[str, Any]], column: str) -> list[float]:
        """A column in this unit."""
        return [self.factor * row[column] for row in rows]


def draw_trajectories(table: pa.Table, axes: list[str], stiffness: float, *, title: str, path: Path) -> None:
    """Draw the first trials of ``table`` into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    rows = table.to_pylist()
    apart = [*axes, *(["start_rad"] if "start_rad" in rows[0] else []), "trial"]
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in apart), []).append(row)
    shown = list(groups.items())[:MOST_PANELS]
    figure = theme.figure(width=9.5, height=1.2 + 3.6 * len(shown))
    panels = figure.subplots(2 * len(shown), 1, squeeze=False, height_ratios=[2.2, 1.0] * len(shown))[:, 0]
    time = Scale(max(row["time_s"] for row in rows))
    several = len({key[-1] for key in groups}) > 1
    drawn = [row for _, trial in shown for row in trial]
    apart_scale = max(abs(row["torque_nm"]) for row in drawn) > HIDDEN * stiffness * max(
        abs(row["angle_rad"]) for row in drawn
    )
    for i, (key, trial) in enumerate(shown):
        _draw_motion(panels[2 * i], trial, stiffness, time, apart=apart_scale)
        (_draw_energy if stiffness > 0.0 else _draw_acceleration)(panels[2 * i + 1], trial, time)
        panels[2 * i + 1].sharex(panels[2 * i])
        names = [f"{name} = {short(value, 6)}" for name, value in zip(apart[:-1], key, strict=False)]
        panels[2 * i].set_title(", ".join([*names, *([f"trial {key[-1]}"] if several else [])]), fontsize=10)
    panels[-1].set_xlabel(f"time, {time.prefix}s")
    left = len(groups) - len(shown)
    what = "motion against the wall" if stiffness > 0.0 else "motion"
    figure.suptitle(f"{title}: {what}" + (f"  ({left} more recordings not drawn)" if left else ""))
    save(figure, path, stage="sweep", name=title)


def _draw_motion(panel: Any, rows: list[dict[str, Any]], stiffness: float, time: Scale, *, apart: bool) -> None:
    columns = ["angle_rad", *(["finger_angle_rad"] if "finger_angle_rad" in rows[0] else [])]
    largest = max(abs(row[column]) for row in rows for column in columns)
    angle, times = Scale(largest), time.of(rows, "time_s")
    if stiffness > 0.0:
        panel.axhspan(min(0.0, *angle.of(rows, "angle_rad")), 0.0, color="0.9", linewidth=0)
    lines = panel.plot(times, angle.of(rows, "angle_rad"), color="#1f4e8c", linewidth=1.6, label="knob")
    if len(columns) > 1:
        finger = angle.of(rows, "finger_angle_rad")
        lines += panel.plot(times, finger, color="#6aa2d8", linewidth=1.2, linestyle="--", label="finger")
    pulse = [t for t, row in zip(times, rows, strict=True) if row["event"] == "pulse ends"]
    if pulse:
        lines.append(panel.axvspan(0.0, pulse[0], color="#f2d9b0", linewidth=0, label="pulse"))
    step = max(abs(row["torque_nm"]) for row in rows)
    if apart and step > 0.0:
        own, unit = panel.twinx(), Scale(step)
        torque = [-unit.factor * row["torque_nm"] for row in rows]
        lines += _draw_torque(own, times, torque, f"torque of the wall, -{unit.prefix}N\u00b7m (right)")
        low, high = panel.get_ylim()
        low = min(low, -0.5 * high)
        panel.set_ylim(low, high)
        deep = -1.1 * unit.factor * step
        own.set_ylim(deep, deep * high / low)  # the same zero on both sides
    elif stiffness > 0.0:
        torque = [-angle.factor * row["torque_nm"] / stiffness for row in rows]
        lines += _draw_torque(panel, times, torque, "torque of the wall / -K")
    panel.axhline(0.0, color="0.4", linewidth=0.8)
    panel.set_ylabel(f"angle, {angle.prefix}rad")
    panel.legend(handles=lines, loc="best", fontsize=8)
    panel.grid(alpha=0.3)


def _draw_torque(panel: Any, times: list[float], values: list[float], label: str) -> list[Any]:
    drawn: list[Any] = panel.plot(times, values, color="#c4501b", linewidth=1.2, drawstyle="steps-post", label=label)
    return drawn


def _draw_energy(panel: Any, rows: list[dict[str, Any]], time: Scale) -> None:
    unit = Scale(max(abs(row["energy_j"]) for row in rows))
    times, energy = time.of(rows, "time_s"), unit.of(rows, "energy_j")
    panel.plot(times, energy, color="0.6", linewidth=1.0)
    free = [e if row["torque_nm"] == 0.0 else float("nan") for e, row in zip(energy, rows, strict=True)]
    panel.plot(times, free, color="0.15", linewidth=2.2, label="while the wall does not act")
    panel.legend(loc="best", fontsize=8)
    panel.set_ylabel(f"energy, {unit.prefix}J")
    panel.grid(alpha=0.3)


def _draw_acceleration(panel: Any, rows: list[dict[str, Any]], time: Scale) -> None:
    """Mean accelerations between rows."""
    pairs = [(a, b) for a, b in pairwise(rows) if b["time_s"] > a["time_s"]]
    times = [0.5 * time.factor * (a["time_s"] + b["time_s"]) for a, b in pairs]
    for part, color, style in (("", "#1f4e8c", "-"), ("finger_", "#6aa2d8", "--")):
        column = f"{part}velocity_rad_s"
        if column in rows[0]:
            values = [1e-3 * (b[column] - a[column]) / (b["time_s"] - a["time_s"]) for a, b in pairs]
            panel.plot(times, values, color=color, linestyle=style, linewidth=1.4)
    panel.set_ylabel("acceleration,\n10\u00b3 rad/s\u00b2")
    panel.grid(alpha=0.3)


ROOM = 145  # characters of a key's line in a full-width figure, its lines and gaps counted as six an entry
BESIDE = 0.8  # inches beside a panel, of any width, for its labels
MOST_EDGES = 40  # count edges that a panel shows


def scale_of(*arrays: np.ndarray) -> Scale:
    """A unit in which the largest of some arrays is at least 0.1."""
    return Scale(10.0 * max(float(np.abs(array).max()) for array in arrays))


def torque_scale(*shown: Recording) -> Scale:
    """A unit that suits the largest torque of the actuator; 1.3 N·m rather than 1300 mN·m."""
    unit = scale_of(*(each.acts for each in shown))
    if unit.factor * max(float(np.abs(each.acts).max()) for each in shown) >= 1000.0:
        unit.prefix, unit.factor = "", 1.0
    return unit


def draw_torque_axis(panel: "Axes", one: Recording, unit: Scale) -> None:
    """At the right, the torque of a wall whose angle is the one on the left, in ``unit``."""
    torque = torque_scale(one)
    per = -torque.factor * one.scene.wall.stiffness / unit.factor

    def to_torque(angle: Any) -> Any:
        return per * angle

    def to_angle(torque: Any) -> Any:
        return torque / per

    own = panel.secondary_yaxis("right", functions=(to_torque, to_angle))
    own.set_ylabel(f"torque, {torque.prefix}N\u00b7m")
    own.spines["right"].set_visible(True)


def key(panel: "Axes") -> None:
    """Legend above the axes, where nothing is drawn, in as many columns as its longest entry leaves room for."""
    longest = max(len(label) for label in panel.get_legend_handles_labels()[1])
    figure = panel.get_figure(root=True)
    assert figure is not None  # a panel is always in one
    room = ROOM * (figure.get_figwidth() - BESIDE) / (theme.WIDTH - BESIDE)
    columns = min(5, max(1, int(room / (longest + 6))))
    panel.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        borderaxespad=0.2,
        handlelength=2.6,
        columnspacing=1.4,
    )


def draw_wall(panel: "Axes", one: Recording, unit: Scale, *, counts: bool = True) -> None:
    """Shade the wall below angle 0, and rule its edge and the count edges that are in view."""
    low, high = panel.get_ylim()
    if one.scene.wall.stiffness == 0.0:
        return
    panel.axhspan(min(low, 0.0), 0.0, color="black", alpha=0.06, linewidth=0)
    panel.axhline(0.0, color="black", linewidth=0.8, linestyle=(0, (4, 2)))
    if counts:
        for edge in edges_between(low, high, unit.factor * one.quantum):
            panel.axhline(edge, color="black", linewidth=0.5, alpha=0.35, linestyle=(0, (1, 2)))
    panel.set_ylim(low, high)


def edges_between(low: float, high: float, step: float) -> list[float]:
    """Multiples of ``step`` but 0 between two values; none where they are too many to tell apart."""
    if step <= 0.0 or (high - low) / step > MOST_EDGES:
        return []
    return [float(i * step) for i in range(int(np.ceil(low / step)), int(np.floor(high / step)) + 1) if i]


def draw_steps(panel: "Axes", one: Recording, time: Scale, factor: float, **style: Any) -> None:
    """The actuator's torque, times ``factor``, as it holds from change to change."""
    times, torques = one.steps
    panel.plot(time.factor * times, factor * torques, drawstyle="steps-post", **style)
