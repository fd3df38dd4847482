"""The picture of a campaign's sample clock: how far the intervals between samples are from the one asked for."""

from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.figures.sheet import save
from hknob_cli.hardware.order import period_ns
from hknob_cli.hardware.timing import audit, histogram, jitter_of
from hknob_cli.specs.plan import RATE

Row = dict[str, Any]


def draw_timing(samples: pa.Table, trials: list[Row], *, name: str, path: Path) -> None:
    """Draw a histogram for each sample rate into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    import numpy as np
    from matplotlib.figure import Figure

    rates = sorted({row[RATE] for row in trials})
    columns = min(len(rates), 4)
    lines = -(-len(rates) // columns)
    figure = Figure(figsize=(3.6 * columns + 1.0, 2.9 * lines + 0.7), layout="constrained")
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
