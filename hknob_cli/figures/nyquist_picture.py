"""The picture of a describing-function analysis.

Left: the plant's Nyquist curve with the rays -1/N(A), one a sample rate, and where they meet (Hasser, Figs 45, 46); the
ray is turned by the delay of the hold. Right: peak to peak by method, beside a sweep where there is one. Below: where
there is a sweep, its difference from the first method over the grid (Figs 49, 52).
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures.bars import draw_bars
from hknob_cli.figures.sheet import save
from hknob_cli.report.dfa import nearest_cycles
from hknob_cli.scene.sampled_knob import sample_knob
from hknob_cli.specs.plan import COUNTS, RATE, DfaPlan
from hknob_cli.theory.nyquist import crossing, plant_curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_dfa(plan: DfaPlan, rows: list[dict[str, Any]], *, path: Path) -> bool:
    """Draw into ``path`` (PNG); False where more than two axes vary, or for a design. Raises `ComputationError`."""
    wide = [axis for axis, values in plan.axes.items() if len(values) > 1]
    if len(wide) > 2 or plan.points:
        return False
    from matplotlib.figure import Figure

    differs = plan.against is not None and len(wide) == 2
    figure = Figure(figsize=(14, 10.5 if differs else 5.6), layout="constrained")
    panels = figure.subplots(2 if differs else 1, 2, squeeze=False, width_ratios=[1, 1.15])
    _draw_nyquist(panels[0][0], plan)
    if wide:
        _draw_sizes(panels[0][1], rows, plan.methods, wide)
    else:
        draw_bars(panels[0][1], rows, "method", "p2p_rad", 1e3, "peak to peak, mrad")
    if differs:
        method = plan.methods[0]
        of = nearest_cycles([row for row in rows if row["method"] == method], list(plan.axes))
        draw_difference(panels[1][0], of, wide, "p2p_difference", f"{method}: peak to peak against the sweep, %")
        draw_difference(panels[1][1], of, wide, "frequency_difference", f"{method}: frequency against the sweep, %")
    figure.suptitle(f"{plan.name}: limit cycles by describing functions")
    save(figure, path, stage="dfa", name=plan.name)
    return True


def _draw_nyquist(axes: "Axes", plan: DfaPlan) -> None:
    """Curve of the plant in rad/(N m), and rays for each sample rate with df1's intersection."""
    from matplotlib import colormaps

    rates = [float(rate) for rate in plan.axes[RATE]]
    counts = int(plan.axes[COUNTS][0])
    seen = []
    for i, rate in enumerate(rates):
        knob = sample_knob(plan.scene, sample_rate_hz=rate, counts_per_rev=counts)
        found = crossing(knob)
        if found is None:
            continue
        point = found.point
        colour = colormaps["cividis"](0.85 * i / max(len(rates) - 1, 1))
        axes.plot([0.0, 1.7 * point.real], [0.0, 1.7 * point.imag], color=colour, lw=1)
        label = f"{float(f'{rate:.4g}'):g} Hz: {found.frequency_hz:.4g} Hz"
        axes.plot([point.real], [point.imag], "o", color=colour, label=label)
        seen.append((point, found.omega))
    if seen:
        low, high = min(omega for _, omega in seen), max(omega for _, omega in seen)
        sweep = np.geomspace(0.5 * low, 4.0 * high, 600)
        curve = plant_curve(knob, sweep)
        axes.plot(curve.real, curve.imag, color="0.25", lw=1.4)
        reach = 1.5 * max(abs(point) for point, _ in seen)
        axes.set_xlim(-reach, 0.25 * reach)
        axes.set_ylim(-reach, 0.12 * reach)
        axes.legend(title="sample rate: df1 cycle", fontsize=8)
    axes.axhline(0.0, color="0.7", lw=0.8)
    axes.axvline(0.0, color="0.7", lw=0.8)
    axes.set_xlabel("Re G, rad/(N·m)")
    axes.set_ylabel("Im G, rad/(N·m)")
    axes.set_title("Nyquist curve of hand and knob, and -1/N(A) turned by the hold", fontsize=10)


def draw_difference(axes: "Axes", rows: list[dict[str, Any]], wide: list[str], column: str, title: str) -> None:
    """A map of one relative difference over two axes, in percent; cells out of domain are written in brackets."""
    down, across = wide
    downs, acrosses = (sorted({row[axis] for row in rows}) for axis in wide)
    values = np.full((len(downs), len(acrosses)), np.nan)
    for row in rows:
        if row[column] is not None:
            i, j = downs.index(row[down]), acrosses.index(row[across])
            values[i, j] = 100.0 * row[column]
            text = f"{values[i, j]:.0f}" if row["in_domain"] else f"({values[i, j]:.0f})"
            axes.text(j, i, text, ha="center", va="center", fontsize=8)
    axes.set_facecolor("0.85")
    axes.imshow(values, origin="lower", aspect="auto", cmap="PuOr", vmin=-100, vmax=100, alpha=0.85)
    axes.set_xticks(range(len(acrosses)), [f"{value:.6g}" for value in acrosses])
    axes.set_yticks(range(len(downs)), [f"{float(f'{value:.4g}'):g}" for value in downs])
    axes.set_xlabel(across)
    axes.set_ylabel(down)
    axes.set_title(f"{title} (in brackets: out of domain)", fontsize=10)
    axes.tick_params(length=0)


def _draw_sizes(axes: "Axes", rows: list[dict[str, Any]], methods: tuple[str, ...], wide: list[str]) -> None:
    """Peak to peak in counts over the first axis; every other axis at its middle value."""
    across, *others = wide
    fixed = {axis: sorted({row[axis] for row in rows})[len({row[axis] for row in rows}) // 2] for axis in others}
    chosen = [row for row in rows if all(row[axis] == value for axis, value in fixed.items()) and row["p2p_rad"]]
    for method, mark in zip(methods, "os^xv+D*" * len(methods), strict=False):
        of = [row for row in chosen if row["method"] == method]
        style = {"ls": "", "ms": 4, "alpha": 0.6} if method == "sampled" else {"lw": 1, "ms": 5}
        axes.plot([row[across] for row in of], [1e3 * row["p2p_rad"] for row in of], marker=mark, label=method, **style)
    for column, line, name in (("sweep_p2p_max_rad", "k-", "largest"), ("sweep_p2p_rad", "k--", "mean")):
        beside = {row[across]: row[column] for row in chosen if row.get(column)}
        if beside:
            axes.plot(list(beside), [1e3 * value for value in beside.values()], line, lw=1.5, label=f"sweep, {name}")
    values = sorted({row[across] for row in chosen})
    if values and values[0] > 0 and values[-1] > 5 * values[0]:
        axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(across)
    axes.set_ylabel("peak to peak, mrad")
    title = ", ".join(f"{axis} = {value:g}" for axis, value in fixed.items())
    axes.set_title("peak to peak by method" + (f" ({title})" if title else ""), fontsize=10)
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8)
