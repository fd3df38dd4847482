"""The picture of the finger that hides behind its pad: the inertia that a second-order fit finds, over their ratio."""

from pathlib import Path

from hknob_cli.figures.estimators import COLOURS, MARKERS, NAMES
from hknob_cli.figures.sheet import save
from hknob_cli.report.study import Row


def draw_hidden(rows: list[Row], *, title: str, path: Path) -> None:
    """Draw into ``path`` (PNG): the inertia, and on a log scale what of the finger shows in it.

    The dotted line is J1/(1 + r)^2, of a finger that moves 1/(1 + r) of what the knob does. Raises `ComputationError`
    if the file cannot be written.
    """
    import numpy as np
    from matplotlib.figure import Figure

    knob, finger = rows[0]["knob_inertia_kg_m2"], rows[0]["finger_inertia_kg_m2"]
    ratios = np.geomspace(min(row["ratio"] for row in rows), max(row["ratio"] for row in rows), 200)
    share = 1e7 * finger / (1.0 + ratios) ** 2
    figure = Figure(figsize=(11.0, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True)
    for axes, base in ((left, 0.0), (right, 1e7 * knob)):
        for estimator in dict.fromkeys(row["estimator"] for row in rows):
            chosen = [row for row in rows if row["estimator"] == estimator]
            axes.plot(
                [row["ratio"] for row in chosen],
                [1e7 * row["inertia_kg_m2"] - base for row in chosen],
                color=COLOURS[estimator],
                marker=MARKERS[estimator],
                markersize=5,
                label=NAMES[estimator],
            )
        axes.plot(ratios, 1e7 * knob - base + share, ":", color="0.2", label="knob + finger / (1 + ratio)²")
        axes.set_xscale("log")
        axes.set_xlabel("finger over pad, K1/K2 = B1/B2")
        axes.grid(alpha=0.3)
    left.axhline(1e7 * knob, color="0.4", linewidth=1.0)
    left.annotate(
        f"the knob alone, {1e7 * knob:.3g} g·cm²",
        (ratios[-1], 1e7 * knob),
        (0, 5),
        textcoords="offset points",
        ha="right",
    )
    left.axhline(1e7 * (knob + finger), color="0.4", linewidth=1.0, linestyle="--")
    left.annotate(
        f"with the finger, {1e7 * (knob + finger):.3g} g·cm²",
        (ratios[-1], 1e7 * (knob + finger)),
        (0, -13),
        textcoords="offset points",
        ha="right",
    )
    left.set_ylabel("inertia of the second-order fit, g·cm²")
    right.set_ylabel("of it beyond the knob's own, g·cm²")
    right.set_yscale("log")
    right.legend()
    figure.suptitle(f"{title}: the stiffer the finger beside its pad, the less of its inertia shows")
    save(figure, path, stage="sysid", name=title)
