"""The pictures of a campaign: of the wall over the grid, of pulses, and its sample clock.

The picture of a campaign's sample clock: how far the intervals between samples are from the one asked for.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from hknob_cli.figures import theme
from hknob_cli.figures.campaign import draw_thumbnails, held_of
from hknob_cli.figures.grid import axis_name
from hknob_cli.figures.heat import colour_map
from hknob_cli.figures.sheet import save
from hknob_cli.hardware.order import period_ns
from hknob_cli.hardware.sample_clock import audit, histogram, jitter_of
from hknob_cli.report.hw_run import cells_of, quiet_text
from hknob_cli.results.columns import differs, mean_beside
from hknob_cli.specs.plan import COUNTS, RATE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

Row = dict[str, Any]
THUMBNAIL_CYCLES = 8
_MOST_THUMBNAILS = 8  # of rows, and of columns
_MOST_TICKS = 40


def draw_hw_run(
    samples: pa.Table, trials: list[Row], *, target_n: float, name: str, path: Path, title: str = ""
) -> None:
    """Draw a campaign, or trials of it, into ``path`` (PNG); ``title``: of these trials, where it is not its name.

    Raises `ComputationError` if the file cannot be written.
    """
    cells = cells_of(trials)
    rates, counts = sorted({cell[RATE] for cell in cells}), sorted({cell[COUNTS] for cell in cells})
    small = len(rates) <= _MOST_THUMBNAILS and len(counts) <= _MOST_THUMBNAILS
    top = 0.5 * len(counts) + 2.2
    bottom = 1.1 * len(counts) + 0.9 if small else 0.0
    figure = theme.figure(width=13.5, height=top + 2.6 + bottom)
    parts: Any = figure.subfigures(3 if small else 2, 1, height_ratios=[top, 2.6, bottom][: 3 if small else 2])
    _maps(parts[0], cells, rates, counts)
    _grips(parts[1], trials, target_n)
    if small:
        draw_thumbnails(parts[2], held_of(trials, samples, 0.0), cycles=THUMBNAIL_CYCLES)
    buzzing = sum(row["sustained"] for row in trials)
    figure.suptitle(f"{title or name}: trials against a virtual wall, {buzzing} of {len(trials)} with sustained buzz")
    save(figure, path, stage="hw-run", name=name)


def _maps(figure: "SubFigure", cells: list[Row], rates: list[float], counts: list[int]) -> None:
    import numpy as np

    grid = {(cell[COUNTS], cell[RATE]): cell for cell in cells}
    axes = figure.subplots(1, 2, sharey=True)
    panels = (
        (
            "p2p_max_rad",
            1e3,
            "peak to peak, mrad" if differs(cells) else "peak to peak, mrad (mean peak minus mean trough)",
        ),
        ("frequency_at_max_hz", 1.0, "frequency, Hz"),
    )
    of = ", of the trial that buzzes most (mean of those that buzz)" if differs(cells) else ""
    for ax, (column, scale, label) in zip(axes, panels, strict=True):
        values = np.array(
            [[scale * (grid.get((count, rate), {}).get(column) or np.nan) for rate in rates] for count in counts],
            dtype=float,
        )
        inks = colour_map(ax, values, label + of)
        ax.set_xticks(range(len(rates)), [f"{rate:.6g}" for rate in rates])
        ax.set_xlabel(axis_name(RATE))
        for i, j in np.ndindex(*values.shape):
            cell = grid.get((counts[i], rates[j]))
            if cell is None:  # none of its trials could be measured
                ax.text(j, i, "not measured", ha="center", va="center", fontsize=8, color=inks[i][j])
                continue
            mean = mean_beside(cell, column)
            texts = ["" if np.isnan(values[i, j]) else f"{values[i, j]:.3g}", f"({scale * mean:.3g})" if mean else ""]
            text = "\n".join(filter(None, [" ".join(filter(None, texts)), quiet_text(cell)]))
            ax.text(j, i, text, ha="center", va="center", fontsize=8, color=inks[i][j])
    axes[0].set_yticks(range(len(counts)), [f"{count}" for count in counts])
    axes[0].set_ylabel(axis_name(COUNTS))


def _grips(figure: "SubFigure", trials: list[Row], target_n: float) -> None:
    """Grip of each trial in the order they were run, with its standard deviation within the trial."""
    ax = figure.subplots()
    shown = [row for row in trials if row["grip_mean_n"] is not None]
    if not shown:
        ax.text(0.5, 0.5, "the knob has no grip cell", ha="center", va="center", transform=ax.transAxes)
        ax.set_axis_off()
        return
    ax.axhline(target_n, color="0.4", linewidth=1.0, linestyle="--", label=f"target {target_n:g} N")
    ax.errorbar(
        [row["order"] for row in shown],
        [row["grip_mean_n"] for row in shown],
        yerr=[row["grip_std_n"] for row in shown],
        fmt="o",
        markersize=4,
        capsize=2,
        color="C0",
        label="mean and standard deviation of a trial",
    )
    ax.set_ylim(0.0, 1.2 * max([target_n, *(row["grip_mean_n"] + row["grip_std_n"] for row in shown)]))
    last = max(row["order"] for row in trials)
    ax.set_xlim(0.5, last + 0.5)
    if last <= _MOST_TICKS:
        ax.set_xticks([row["order"] for row in trials])
    ax.set_ylabel("grip force, N")
    ax.set_xlabel("trial, in the order they were run")
    ax.grid(alpha=0.3)
    ax.legend(fontsize=8, loc="lower right", ncols=2)


def draw_timing(samples: pa.Table, trials: list[Row], *, name: str, path: Path) -> None:
    """Draw a histogram for each sample rate into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    import numpy as np

    rates = sorted({row[RATE] for row in trials})
    columns = min(len(rates), 4)
    lines = -(-len(rates) // columns)
    figure = theme.figure(width=3.6 * columns + 1.0, height=2.9 * lines + 0.7)
    axes = figure.subplots(lines, columns, squeeze=False)
    columns_of = {name: samples[name].to_numpy() for name in ("trial", "device_time_us", "sample")}
    for ax, rate in zip(axes.flat, rates, strict=False):
        here = [columns_of["trial"] == row["order"] for row in trials if row[RATE] == rate]
        parts = [
            jitter_of(columns_of["sample"][one], columns_of["device_time_us"][one], period_ns=period_ns(rate))
            for one in here
        ]
        jitter = np.concatenate(parts)
        edges, found = histogram(jitter)
        ax.stairs(found, 1e6 * edges, fill=True, color="C0")
        ax.set_yscale("log")
        ax.set_ylim(0.5, 3.0 * max(1, jitter.size))
        ax.set_title(f"{rate:g} Hz: {jitter.size} intervals", fontsize=9)
        ax.grid(alpha=0.3)
        ax.tick_params(labelsize=8)
        rows = [row for row in trials if row[RATE] == rate]
        lost, late = sum(row["gaps"] for row in rows), sum(row["overruns"] for row in rows)
        skipped = sum(
            audit(
                columns_of["sample"][one], columns_of["device_time_us"][one], period_ns=period_ns(rate), overruns=0
            ).missed_ticks
            for one in here
        )
        ax.text(
            0.03,
            0.95,
            f"missing: {lost}\nlate: {late}\nticks skipped: {skipped}",
            transform=ax.transAxes,
            va="top",
            fontsize=8,
        )
    for ax in list(axes.flat)[len(rates) :]:
        ax.set_axis_off()
    between = "\n" if columns == 1 else " "  # one line is wider than one drawing
    label = f"interval from sample to sample, less the one asked for, us{between}(the device's clock counts whole us)"
    figure.supxlabel(label, fontsize=9)
    figure.supylabel("intervals", fontsize=9)
    figure.suptitle(f"{name}: sample clock")
    save(figure, path, stage="hw-run", name=name)


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
