"""The picture of recorded trials: the knob's motion, and the torque as the angle that the wall answers to.

As in Hasser, Figs. 22-28: the torque is divided by -K, so that a wall that follows the angle at once and exactly would
lie on it. Below, the energy of knob, hand and push: what leaks in shows.
"""

from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.report.matrix import short
from hknob_cli.report.picture import save

MOST_PANELS = 6


def draw_trajectories(table: pa.Table, axes: list[str], stiffness: float, *, title: str, path: Path) -> None:
    """Draw the first trials of ``table`` into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    from matplotlib.figure import Figure

    rows = table.to_pylist()
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((*(row[axis] for axis in axes), row["trial"]), []).append(row)
    shown = list(groups.items())[:MOST_PANELS]
    figure = Figure(figsize=(9.5, 1.2 + 3.6 * len(shown)), layout="constrained")
    panels = figure.subplots(2 * len(shown), 1, squeeze=False, height_ratios=[2.2, 1.0] * len(shown))[:, 0]
    for i, (key, trial) in enumerate(shown):
        _draw_motion(panels[2 * i], trial, stiffness)
        _draw_energy(panels[2 * i + 1], trial)
        panels[2 * i + 1].sharex(panels[2 * i])
        names = [f"{axis} = {short(value, 6)}" for axis, value in zip(axes, key, strict=False)]
        panels[2 * i].set_title(", ".join([*names, *([f"trial {key[-1]}"] if _several(groups) else [])]), fontsize=10)
    panels[-1].set_xlabel("time, ms")
    left = len(groups) - len(shown)
    figure.suptitle(f"{title}: motion against the wall" + (f"  ({left} more recordings not drawn)" if left else ""))
    save(figure, path, stage="sweep", name=title)


def _several(groups: dict[tuple[Any, ...], Any]) -> bool:
    return len({key[-1] for key in groups}) > 1


def _draw_motion(panel: Any, rows: list[dict[str, Any]], stiffness: float) -> None:
    time = [1e3 * row["time_s"] for row in rows]
    panel.axhspan(min(0.0, *(1e3 * row["angle_rad"] for row in rows)), 0.0, color="0.9", linewidth=0)
    panel.plot(time, [1e3 * row["angle_rad"] for row in rows], color="#1f4e8c", linewidth=1.6, label="knob")
    if "finger_angle_rad" in rows[0]:
        finger = [1e3 * row["finger_angle_rad"] for row in rows]
        panel.plot(time, finger, color="#6aa2d8", linewidth=1.2, linestyle="--", label="finger")
    if stiffness > 0.0:
        torque = [-1e3 * row["torque_nm"] / stiffness for row in rows]
        panel.plot(
            time, torque, color="#c4501b", linewidth=1.2, drawstyle="steps-post", label="torque of the wall / -K"
        )
    panel.axhline(0.0, color="0.4", linewidth=0.8)
    panel.set_ylabel("angle, mrad")
    panel.legend(loc="best", fontsize=8)
    panel.grid(alpha=0.3)


def _draw_energy(panel: Any, rows: list[dict[str, Any]]) -> None:
    panel.plot([1e3 * row["time_s"] for row in rows], [1e6 * row["energy_j"] for row in rows], color="0.25")
    panel.set_ylabel("energy, \u00b5J")
    panel.grid(alpha=0.3)
