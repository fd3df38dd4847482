"""The picture of a sweep: peak-to-peak and frequency over the grid, with the orbits that coexist.

Over two axes: two maps with their values written in. Over one: every orbit as a point, sized by its share of the
trials, which shows steps and coexistence that a line through means would hide.
"""

from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from hknob_cli.errors import ComputationError
from hknob_cli.figures.growth_picture import draw_growth
from hknob_cli.figures.literal import literal
from hknob_cli.report.matrix import is_whole
from hknob_cli.report.means import differs, mean_beside
from hknob_cli.report.perceived import level_limits, perceived_levels
from hknob_cli.results.place import create
from hknob_cli.results.png import KEYWORD, source_text
from hknob_cli.results.store import partial

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMES = {
    "sample_rate_hz": "sample rate, Hz",
    "counts_per_rev": "encoder, counts per revolution",
    "bias.torque": "bias torque, N·m",
    "hand.stiffness": "hand stiffness, N·m/rad",
    "hand.grip_n": "grip force, N",
    "hand.damping": "hand damping, N·m·s/rad",
    "wall.stiffness": "wall stiffness, N·m/rad",
    "knob.inertia": "knob inertia, kg·m²",
    "knob.damping": "knob damping, N·m·s/rad",
    "knob.coulomb_torque": "Coulomb friction, N·m",
    "hand.inertia": "hand inertia, kg·m²",
    "wall.damping": "virtual damping, N·m·s/rad",
    "encoder.offset_counts": "encoder edges, counts above the wall's",
    "actuator.delay_samples": "delay, samples",
    "actuator.time_constant": "actuator lag, s",
    "hand_inertia_kg_m2": "inertia of the person's hand, kg·m²",
    "hand_damping_nm_s_per_rad": "damping of the person's hand, N·m·s/rad",
    "hand_stiffness_nm_per_rad": "stiffness of the person's hand, N·m/rad",
}
_MOST_LABELS = 400


def draw_sweep(cells: pa.Table, orbits: pa.Table, axes: list[str], *, title: str, path: Path) -> bool:
    """Draw a sweep into ``path`` (PNG); False, drawing nothing, without an axis, where more than two vary, or no grid.

    Raises `ComputationError` if the file cannot be written.
    """
    rows = cells.to_pylist()
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if len(wide) > 2 or not axes or not is_whole(rows, wide):
        return False
    fixed = ", ".join(f"{axis} = {rows[0][axis]:g}" for axis in axes if axis not in wide)
    from matplotlib.figure import Figure

    grown = "growth_j_per_s2" in rows[0]
    if grown:
        figure = Figure(figsize=(9.5, 6.4), layout="constrained")
        draw_growth(figure, rows, wide or axes[:1], axis_name)
    elif len(wide) == 2:
        tall = 0.52 * len({row[wide[0]] for row in rows}) + 2.2
        figure = Figure(figsize=(13.5, tall * (2 if perceived_levels(rows) else 1) + 0.4), layout="constrained")
        _draw_maps(figure, rows, wide)
    else:
        figure = Figure(figsize=(9.5, 6.4), layout="constrained")
        _draw_orbits(figure, orbits.to_pylist(), (wide or axes[:1])[0])
    what = "energy of an undamped knob" if grown else "limit cycles"
    figure.suptitle(f"{title}: {what} against a virtual wall" + (f"  ({fixed})" if fixed else ""))
    save(figure, path, stage="sweep", name=title)
    return True


def save(figure: "Figure", path: Path, *, stage: str, name: str) -> None:
    """Write a figure, whole or not at all, with what it was drawn for (PNG).

    Raises `ComputationError` if the file cannot be written.
    """
    half = partial(path)
    try:
        with create(half) as stream, literal(figure):
            figure.savefig(stream, dpi=130, format="png", metadata={KEYWORD: source_text(stage, name)})
        half.replace(path)
    except OSError as error:
        raise ComputationError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        half.unlink(missing_ok=True)


def axis_name(axis: str) -> str:
    """Name of a grid axis, with its unit."""
    return _NAMES.get(axis, axis)


def _draw_maps(figure: "Figure", rows: list[dict[str, Any]], wide: list[str]) -> None:
    import numpy as np

    down, across = wide
    downs, acrosses = (sorted({row[axis] for row in rows}) for axis in wide)
    grid = {(row[down], row[across]): row for row in rows}
    levels = perceived_levels(rows)
    of = ", of the largest cycle" if differs(rows) else ""
    places = figure.subplots(2 if levels else 1, 2, sharey=True, squeeze=False)
    panels: list[tuple[Axes, str, float, str, tuple[float, float] | None]] = [
        (places[0, 0], "p2p_max_rad", 1e3, f"peak to peak, mrad (mean peak minus mean trough){of}", None),
        (places[0, 1], "frequency_at_max_hz", 1.0, f"frequency, Hz{of}", None),
    ]
    for one, level in zip(places[1:].flat, levels, strict=False):
        panels.append((one, level.column, 1.0, level.title, level_limits(rows, level)))
    for empty in list(places.flat)[len(panels) :]:
        empty.set_axis_off()
    for axes, column, scale, label, limits in panels:
        values = np.array(
            [
                [(grid[d, a][column] if grid[d, a][column] is not None else np.nan) * scale for a in acrosses]
                for d in downs
            ]
        )
        inks = colour_map(axes, values, label, limits=limits)
        axes.set_xticks(range(len(acrosses)), [f"{value:.6g}" for value in acrosses], rotation=30, ha="right")
        axes.set_xlabel(axis_name(across))
        if len(rows) <= _MOST_LABELS:
            for i, d in enumerate(downs):
                for j, a in enumerate(acrosses):
                    mean = mean_beside(grid[d, a], column)
                    _write(axes, j, i, float(values[i, j]), grid[d, a], theme=inks[i][j], mean=mean and scale * mean)
    for left in places[:, 0]:
        left.set_yticks(range(len(downs)), [f"{float(f'{value:.4g}'):g}" for value in downs])
        left.set_ylabel(axis_name(down))
    marks = (
        "a dot for each orbit that coexists in a cell"
        + (";  in brackets: the mean of the trials that cycle" if of else "")
        + (";  levels are those of the most noticeable orbit" if levels else "")
    )
    figure.supxlabel(f"{marks};  rest: trials come to rest;  div: they diverge;  ?: undecided", fontsize=8)


def colour_map(axes: "Axes", values: Any, label: str, *, limits: tuple[float, float] | None = None) -> list[list[str]]:
    """Draw one map; the colour in which to write on each of its cells.

    Colours are on a log scale of the values above 0, or with ``limits`` on an even one between these.
    """
    import numpy as np
    from matplotlib.colors import LogNorm, Normalize

    shown = values if limits else np.where(values > 0, values, np.nan)
    found = shown[np.isfinite(shown)]
    low, high = (float(found.min()), float(found.max())) if found.size else (1.0, 1.0)
    norm = Normalize(*limits) if limits else LogNorm(low, high if high > low else low * 1.01)
    axes.set_facecolor("0.85")
    image = axes.imshow(shown, origin="lower", aspect="auto", cmap="cividis", norm=norm)
    axes.set_title(label, fontsize=10)
    axes.tick_params(length=0)
    # Relative luminance (ITU-R BT.709) decides; cells without a value are light grey.
    light = image.to_rgba(shown)[..., :3] @ np.array([0.2126, 0.7152, 0.0722])
    return [
        ["white" if dark and some else "black" for dark, some in zip(*row, strict=True)]
        for row in zip(light < 0.5, np.isfinite(shown), strict=True)
    ]


def _write(
    axes: "Axes", x: int, y: int, value: float, row: dict[str, Any], *, theme: str, mean: float | None = None
) -> None:
    """The value of a cell, the mean beside it, a dot per coexisting orbit, and how trials end that do not cycle."""
    words = [
        word
        for word, column in (("rest", "at_rest_fraction"), ("div", "diverged_fraction"), ("?", "undecided_fraction"))
        if row[column] > 0
    ]
    text = "" if isnan(value) or (value == 0 and words) else f"{value:.3g}"
    text += f" ({_few(mean, 11 - len(text))})" if text and mean else ""
    axes.text(x, y, "\n".join(filter(None, [text, " ".join(words)])), ha="center", va="center", fontsize=8, color=theme)
    count = int(row["orbit_count"])
    if count > 1:
        axes.text(x, y - 0.33, "•" * min(count, 8), ha="center", va="center", fontsize=7, color=theme)


def _few(value: float, room: int) -> str:
    """A number to three digits, or to two where these take more letters than there is room."""
    text = f"{value:.3g}"
    return text if len(text) <= room else f"{float(f'{value:.2g}'):g}"


def _draw_orbits(figure: "Figure", orbits: list[dict[str, Any]], axis: str) -> None:
    level = next((one for one in perceived_levels(orbits) if one.column == "touch_db"), None)
    top, *middle, bottom = figure.subplots(3 if level else 2, 1, sharex=True)
    shown = [row for row in orbits if row["p2p_rad"] is not None]
    xs = [row[axis] for row in shown]
    size = [6.0 + 30.0 * row["basin_fraction"] for row in shown]
    colour = [row["basin_fraction"] for row in shown]
    panels = [(top, "p2p_rad", 1e3, "peak to peak, mrad"), (bottom, "frequency_hz", 1.0, "frequency, Hz")]
    panels += [(one, "touch_db", 1.0, "touch, dB above threshold") for one in middle]
    for axes, column, scale, label in panels:
        ys = [nan if row[column] is None else row[column] * scale for row in shown]
        dots = axes.scatter(xs, ys, s=size, c=colour, cmap="cividis_r", vmin=0.0, vmax=1.0, linewidths=0)
        axes.set_ylabel(label)
        known = [y for y in ys if not isnan(y)]
        axes.set_ylim(min([0.0, *known]), 1.06 * max([0.0, *known]) or 1.0)
        axes.grid(alpha=0.3)
    bottom.set_xlabel(axis_name(axis))
    if xs and min(xs) > 0 and is_geometric(sorted(set(xs))):
        bottom.set_xscale("log")
    figure.colorbar(dots, ax=[top, *middle, bottom], label="share of the trials that reach the orbit", shrink=0.6)


def is_geometric(values: list[float]) -> bool:
    """Whether axis values grow by a factor rather than by a step."""
    return len(values) > 2 and values[-1] / values[-2] > 0.9 * values[1] / values[0] and values[1] > 1.2 * values[0]
