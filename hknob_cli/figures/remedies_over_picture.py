"""The picture of remedies over a further axis: blue where the largest cycle is smaller, red where it is larger."""

from math import log2
from pathlib import Path
from typing import Any

from hknob_cli.figures.sheet import save
from hknob_cli.report.remedies_over import over_axis, said

REACH = 3.0  # of the colours: eight times smaller or larger


def draw_over(rows: list[dict[str, Any]], axis: str, unit: str, *, title: str, path: Path) -> None:
    """Draw remedies.parquet's rows into ``path`` (PNG). Raises `ComputationError` if the file cannot be written."""
    from matplotlib.figure import Figure

    found = over_axis(rows, axis)
    names = list(found)
    values = [row[axis] for row in found[names[0]]]
    figure = Figure(figsize=(3.6 + 0.75 * len(values), 1.9 + 0.27 * len(names)), layout="constrained")
    axes = figure.subplots()
    colours = [[_colour(row) for row in found[name]] for name in names]
    image = axes.imshow(colours, cmap="RdBu", vmin=-REACH, vmax=REACH, aspect="auto", interpolation="nearest")
    for i, name in enumerate(names):
        for j, row in enumerate(found[name]):
            dark = abs(colours[i][j]) > 0.65 * REACH
            axes.text(j, i, said(row), ha="center", va="center", fontsize=8, color="white" if dark else "black")
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.set_xticks(range(len(values)), [f"{value:.3g}" for value in values], fontsize=8)
    axes.set_xlabel(f"{axis}, {unit}" if unit != "1" else axis)
    bar = figure.colorbar(image, ax=axes, ticks=[-3, -2, -1, 0, 1, 2, 3], fraction=0.05)
    bar.ax.set_yticklabels(["1/8", "1/4", "1/2", "1", "2", "4", "8"])
    bar.set_label("times smaller (red: larger)")
    figure.suptitle(
        f"{title}: largest cycle of the plain reference over that of each remedy,\n"
        "for the hand and cell that gain least (*: outside the controller's domain)",
        fontsize=9,
    )
    save(figure, path, stage="remedies", name=title)


def _colour(row: dict[str, Any]) -> float:
    """Twofold steps by which the cycle is smaller, within the colours' reach."""
    if row["starts"]:
        return -REACH
    if row["rests"]:
        return REACH
    times = row["times_least"]
    return 0.0 if times is None else max(-REACH, min(REACH, log2(times)))
