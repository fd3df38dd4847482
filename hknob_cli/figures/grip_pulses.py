"""The pictures of a campaign of pulses: grip force and angle about each pulse, and the sample clock."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from hknob_cli.figures import theme
from hknob_cli.figures.hw_run_picture import draw_timing
from hknob_cli.figures.sheet import save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Row = dict[str, Any]
MOST_POINTS = 2000  # of a line


def draw_grip_pulses(samples: pa.Table, trials: list[Row], *, name: str, paths: list[Path]) -> list[Path]:
    """Draw grip and angle of each trial, a row of panels a grip force, and the sample clock; the files (PNG) drawn.

    Raises `ComputationError` if a file cannot be written.
    """
    targets = sorted({row["grip_target_n"] for row in trials})
    figure = theme.figure(width=11.0, height=1.6 * len(targets) + 1.3)
    panels = figure.subplots(len(targets), 2, squeeze=False, sharex="col")
    column = {one: samples[one].to_numpy() for one in ("trial", "time_s", "grip_n", "angle_rad", "torque_nm")}
    for (grip, angle), target in zip(panels, targets, strict=True):
        same = [row for row in trials if row["grip_target_n"] == target]
        for row in same:
            kept = column["trial"] == row["order"]
            _trial(grip, angle, {one: values[kept] for one, values in column.items()})
        grip.axhline(target, color="0.4", linewidth=1.0, linestyle="--")
        grip.set_ylabel(f"target {target:g} N\ngrip, N", fontsize=8)
        angle.set_ylabel("angle, mrad", fontsize=8)
        fired = sum(row["fired"] for row in same)
        if fired < len(same):
            text = f"{len(same) - fired} of {len(same)} without a pulse: their last samples"
            grip.text(0.02, 0.95, text, transform=grip.transAxes, va="top", fontsize=8)
        for panel in (grip, angle):
            panel.grid(alpha=0.3)
            panel.tick_params(labelsize=8)
    for panel in panels[-1]:
        panel.set_xlabel("time from the first sample of the pulse, ms", fontsize=8)
    every = sum(row["fired"] for row in trials)
    figure.suptitle(f"{name}: pulses that a grip fires, {every} of {len(trials)} trials with a pulse")
    save(figure, paths[0], stage="hw-run", name=name)
    draw_timing(samples, trials, name=name, path=paths[1])
    return paths[:2]


def _trial(grip: "Axes", angle: "Axes", column: dict[str, Any]) -> None:
    """Draw one: its grip, and if it fired its angle from where the knob rested."""
    pushed = np.flatnonzero(column["torque_nm"])
    time_ms = 1e3 * (column["time_s"] - column["time_s"][int(pushed[0]) if pushed.size else -1])
    thin = slice(None, None, max(1, time_ms.size // MOST_POINTS))
    look: dict[str, Any] = {"linewidth": 0.8, "alpha": 0.8}
    grip.plot(time_ms[thin], column["grip_n"][thin], color=theme.COLOURS[0] if pushed.size else "0.5", **look)
    if pushed.size:
        turned = 1e3 * (column["angle_rad"] - column["angle_rad"][: int(pushed[0]) + 1].mean())
        near = (time_ms > -10.0) & (time_ms < 110.0)
        angle.plot(time_ms[near], turned[near], color=theme.COLOURS[1], **look)
