"""Work against precision: the error of every run over its time, one panel a scene, one line a method.

Methods are told apart by marker, families by line style, so that the picture reads in grey. A hollow marker is the
method's default setting, a thin line with small markers its other treatment of friction. Runs without an error on the
scale stand in the strip on top.
"""

from math import ceil, isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures.sheet import save
from hknob_cli.figures.ticks import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

Rows = list[dict[str, Any]]

LEAST, LARGEST, STRIP, TOP = 1e-17, 1e2, 2e3, 1e6
_COLUMNS = 4


class Style(NamedTuple):
    """How the points of a method look."""

    marker: str
    line: str
    colour: str
    label: str


STYLES = {
    "exact": Style("*", "-", "black", "hknob, exact"),
    "rk23": Style("o", "-", "#0072B2", "SciPy RK23"),
    "rk45": Style("s", "-", "#0072B2", "SciPy RK45"),
    "dop853": Style("^", "-", "#0072B2", "SciPy DOP853"),
    "lsoda": Style("D", "--", "#D55E00", "SciPy LSODA"),
    "radau": Style("v", "--", "#D55E00", "SciPy Radau"),
    "bdf": Style("p", "--", "#D55E00", "SciPy BDF"),
    "euler": Style("<", ":", "#009E73", "semi-implicit Euler, compiled"),
    "midpoint": Style(">", ":", "#009E73", "implicit midpoint, compiled"),
    "rk4": Style("h", ":", "#009E73", "Runge-Kutta 4, compiled"),
    "mujoco_euler": Style("X", "-.", "#7A7A7A", "MuJoCo Euler"),
    "mujoco_implicitfast": Style("P", "-.", "#7A7A7A", "MuJoCo implicitfast"),
    "mujoco_rk4": Style("8", "-.", "#7A7A7A", "MuJoCo RK4"),
}
_OTHER_FRICTION = ("smoothed", "soft")


def draw_scene(scene: str, rows: Rows, *, accurate: float, name: str, path: Path) -> None:
    """Draw one scene into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 6.0), layout="constrained")
    axes = figure.subplots()
    _draw(axes, rows, accurate=accurate, size=7.0)
    axes.set_title(f"{scene.replace('_', ' ')}: error against run time, {rows[0]['samples']} samples")
    axes.set_xlabel("processor time of a run, s")
    axes.set_ylabel("largest error of the angle / swing of the reference")
    figure.legend(handles=_legend(rows), loc="outside right upper", fontsize=9, frameon=False)
    save(figure, path, stage="bench", name=name)


def draw_sheet(scenes: dict[str, Rows], *, accurate: float, name: str, path: Path) -> None:
    """Draw all scenes on one sheet (PNG). Raises `ComputationError` if it cannot be written."""
    from matplotlib.figure import Figure

    columns = min(_COLUMNS, len(scenes))
    down = ceil(len(scenes) / columns)
    figure = Figure(figsize=(max(8.0, 4.2 * columns), 3.1 * down + 1.4), layout="constrained")
    panels = list(figure.subplots(down, columns, squeeze=False, sharex=True, sharey=True).flat)
    for axes, (scene, rows) in zip(panels, scenes.items(), strict=False):
        _draw(axes, rows, accurate=accurate, size=4.5)
        axes.set_title(scene.replace("_", " "), fontsize=10)
    for axes in panels[len(scenes) :]:
        axes.set_axis_off()
    for axes in panels[max(0, len(scenes) - columns) : len(scenes)]:
        axes.set_xlabel("processor time, s", fontsize=9)
        axes.tick_params(labelbottom=True)
    for axes in panels[::columns]:
        axes.set_ylabel("error / swing", fontsize=9)
    rows = [row for rows in scenes.values() for row in rows]
    figure.legend(
        handles=_legend(rows), loc="outside lower center", ncols=min(5, columns + 1), fontsize=9, frameon=False
    )
    figure.suptitle(f"{name}: largest error of the angle, over the reference's swing, against run time")
    save(figure, path, stage="bench", name=name)


def _draw(axes: "Axes", rows: Rows, *, accurate: float, size: float) -> None:
    axes.axhspan(LEAST / 10.0, accurate, color="0.94", lw=0, zorder=0)
    axes.axhspan(LARGEST * 3.0, TOP, color="0.88", lw=0, zorder=0)
    for method, style in STYLES.items():
        for other in (True, False):
            of = [row for row in rows if row["method"] == method and (row["friction"] in _OTHER_FRICTION) == other]
            _draw_line(axes, of, style, size=(0.6 if other else 1.0) * size, thin=other)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(LEAST / 3.0, TOP)
    ticks = [10.0**power for power in range(-16, 1 + round(log10(LARGEST)), 3)]
    axes.set_yticks([*ticks, STRIP], [*map(plain, ticks), "none"])
    axes.tick_params(axis="y", which="minor", length=0)
    axes.grid(alpha=0.25)
    for y, text in ((accurate * 0.6, "accurate"), (TOP * 0.5, "failed, too slow, or off scale")):
        axes.text(0.01, y, text, fontsize=7, color="0.4", va="top", transform=axes.get_yaxis_transform())


def _draw_line(axes: "Axes", rows: Rows, style: Style, *, size: float, thin: bool) -> None:
    points = [(row["seconds"], row["relative_error"], row["setting"].startswith("default")) for row in rows]
    shown = [(seconds, max(error, LEAST) if _on_scale(error) else STRIP, default) for seconds, error, default in points]
    line = [(x, y) for x, y, default in shown if y < STRIP and not default]
    width = 0.6 if thin else 1.2
    big = 1.9 * size if style.marker == "*" else size
    axes.plot(*zip(*line, strict=True) if line else ([], []), ls=style.line, lw=width, color=style.colour, zorder=2)
    for x, y, default in shown:
        face = "white" if default else style.colour
        axes.plot(
            [x], [y], ls="", marker=style.marker, ms=big if y < STRIP else 0.6 * big, mec=style.colour, mfc=face,
            mew=0.9, zorder=4 if style.marker == "*" else 3,
        )  # fmt: skip


def _on_scale(error: float | None) -> bool:
    return error is not None and isfinite(error) and error <= LARGEST


def _legend(rows: Rows) -> list["Line2D"]:
    """A line for every method there is, and what else the markers say."""
    from matplotlib.lines import Line2D

    there = {row["method"] for row in rows}
    handles = [
        Line2D([], [], ls=style.line, lw=1.2, marker=style.marker, color=style.colour, label=style.label,
               ms=11 if style.marker == "*" else 6)
        for method, style in STYLES.items() if method in there
    ]  # fmt: skip
    if any(row["setting"].startswith("default") for row in rows):
        handles.append(Line2D([], [], ls="", marker="o", mec="0.3", mfc="white", label="hollow: as it comes"))
    if any(row["friction"] in _OTHER_FRICTION for row in rows):
        handles.append(Line2D([], [], ls="-", lw=0.6, marker="o", ms=3.5, color="0.3", label="small: soft friction"))
    return handles
