"""Stability drawn: the K-B plane of a wall, and the Nyquist curve of hand and knob (Hasser, Figs 45, 46).

The K-B plane is stiffness over virtual damping, with the lines within which a wall is passive or stable. Beside the
Nyquist curve the describing function is turned by each hold's delay.
"""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import TABLES, axis_name
from hknob_cli.figures.numbers import is_geometric, log_ticks
from hknob_cli.report.table import short
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.plan import COUNTS, RATE, Cell, scene_at
from hknob_cli.theory.laws import working_edge
from hknob_cli.theory.stiffness_limits import stiffness_limits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hknob_cli.scene.plain_knob import SampledKnob
    from hknob_cli.theory.relay import Crossing

STIFFNESS, DAMPING = "wall.stiffness", "wall.damping"
_POINTS = 161  # of a line
_LINES = {
    "colgate_schenkel": "passive in any hand, no counts\n(Colgate & Schenkel)",
    "abbott_okamura": "passive in any hand, with\ncounts (Abbott & Okamura)",
    "gil_hulin": "stable in this hand, no counts\n(Gil & Hulin)",
    "exact": "stable in this hand, no counts,\nexact",
    "niemeyer": "friction holds over a count\n(Niemeyer)",
}
_CELLS = ("cell passive in any hand", "cell stable in this hand\n(Gil & Hulin)", "cell neither")


@drawing
def kb_plane(evidence: ResultSet, of: str, *, height: float = 4.4) -> "Figure":
    """Limits of a prediction over the wall's stiffness and damping as lines, and the verdict of each cell as a point.

    ``of``: a prediction of which only `wall.stiffness` and `wall.damping` vary. Below a line its limit holds. Limits
    that no stiffness satisfies have no line, and are named. Raises `MissingError`.
    """
    import numpy as np

    result = evidence[of]
    rows = result.rows("passivity")
    stiffness, damping = (sorted({row[axis] for row in rows}) for axis in _axes(result, rows))
    cell: Cell = {axis: rows[0][axis] for axis in result.axes}
    edge = working_edge(scene_at(result.scene, cell), cell)
    over = np.linspace(damping[0], damping[-1], _POINTS)
    figure = theme.figure(height)
    axes = figure.subplots()
    none = []
    for i, (name, line) in enumerate(stiffness_limits(edge, over.tolist())._asdict().items()):
        drawn = np.array(line)
        if not np.any(drawn > 0.0):
            none += [_LINES[name].replace("\n", " ")] if np.any(drawn == 0.0) else []
            continue
        axes.plot(over, drawn, **theme.series(i), label=_LINES[name])
    _draw_cells(axes, rows)
    _scale(axes, stiffness)
    axes.set_xlabel(axis_name(DAMPING))
    axes.set_ylabel(axis_name(STIFFNESS))
    said = [f"{short(cell[RATE], 6)} Hz, {cell[COUNTS]:g} counts. Below a line its limit holds."]
    said += [f"At no stiffness: {name}" for name in none]
    figure.supxlabel("\n".join(said), fontsize=8)
    figure.legend(loc="outside right upper", handlelength=3.0)
    return figure


def is_kb(axes: list[str]) -> bool:
    """Whether these axes, and no others, span the plane."""
    return sorted(axes) == [DAMPING, STIFFNESS]


def _axes(result: Result, rows: list[dict[str, Any]]) -> tuple[str, str]:
    wide = [axis for axis in result.axes if len({row[axis] for row in rows}) > 1]
    if not is_kb(wide) or result.is_design:
        raise MissingError(f"'{result.name}' is no grid over {STIFFNESS} and {DAMPING} alone")
    return STIFFNESS, DAMPING


def _draw_cells(axes: "Axes", rows: list[dict[str, Any]]) -> None:
    """A point a cell: filled, hollow, or a cross."""
    kinds = [0 if row["device_passive"] else 1 if row["gil_hulin"] else 2 for row in rows]
    for kind, marker in enumerate(("o", "o", "x")):
        mine = [row for row, one in zip(rows, kinds, strict=True) if one == kind]
        style: dict[str, Any] = {"color": "black", "marker": marker, "markersize": 3.5, "linestyle": "none"}
        if mine:
            places = [row[DAMPING] for row in mine], [row[STIFFNESS] for row in mine]
            axes.plot(*places, **style, fillstyle="none" if kind == 1 else "full", label=_CELLS[kind])


def _scale(axes: "Axes", stiffness: list[float]) -> None:
    """The stiffness of the cells, with a margin: by factors where they are, else from 0."""
    if stiffness[0] > 0.0 and is_geometric(stiffness):
        margin = (stiffness[-1] / stiffness[0]) ** 0.04
        axes.set_yscale("log")
        axes.set_ylim(stiffness[0] / margin, stiffness[-1] * margin)
        axes.set_yticks(*log_ticks(stiffness[0], stiffness[-1]))
        axes.set_yticks([], minor=True)
    else:
        margin = 0.04 * (stiffness[-1] - stiffness[0])
        axes.set_ylim(stiffness[0] - margin, stiffness[-1] + margin)


_REACH = 1.35  # of a ray, beyond its crossing


@drawing
def nyquist(evidence: ResultSet, of: str, *, rates: list[float] | None = None, zoom: bool | None = None) -> "Figure":
    """The plant's curve in rad/(N m), a ray a sample rate (Hz, by default all the result has), circles where they meet.

    The key gives each rate and the pitch where its ray meets the curve. Dashed: the inverse of the describing function
    without delay. ``zoom``: a second panel for the crossings near the origin, by default with three rates or more.
    Raises `MissingError` where the scene has no sample clock, and where hysteresis makes another line of the ray.
    """
    from hknob_cli.scene.plain_knob import sample_knob
    from hknob_cli.specs.capabilities import PARTS, parts_of
    from hknob_cli.theory.relay import crossing

    result = evidence[of]
    scene = result.scene
    if not scene.sampled:
        raise MissingError(f"'{of}' has no sample clock")
    if result.stage == "dfa" and {"finger", "lag", "friction"} & set(parts_of(scene)):
        raise MissingError(f"'{of}' has more than one body with damping and stiffness")
    if any(part in parts_of(scene) or PARTS[part].path in result.axes for part in ("hysteresis", "backlash")):
        raise MissingError(f"'{of}' has an encoder with hysteresis, whose inverse is no ray")
    chosen = [float(rate) for rate in rates] if rates else _values(result, RATE)
    counts = int(_values(result, COUNTS)[0])
    knobs = [sample_knob(scene, sample_rate_hz=rate, counts_per_rev=counts) for rate in chosen]
    found = [one for one in map(crossing, knobs) if one is not None]
    if not found:
        raise MissingError(f"'{of}' has no crossing below the Nyquist frequency")
    both = len(found) > 2 if zoom is None else zoom
    figure = theme.figure(4.6 if both else 3.9)
    figure.set_layout_engine("constrained", h_pad=0.08)
    panels = figure.subplots(1, 2 if both else 1, squeeze=False)[0]
    _panel(panels[0], knobs[0], found, found)
    if both:
        near = sorted(found, key=lambda one: abs(one.point))
        _panel(panels[1], knobs[0], found, near[: (len(near) + 1) // 2])
        panels[1].set_title("the same, near the origin")
    handles, texts = panels[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=3, handlelength=3.4)
    return figure


def _values(result: Result, axis: str) -> list[float]:
    """Values of an axis in the order of the grid. Raises `MissingError`."""
    table = result.table(TABLES.get(result.stage, "cells"))
    if axis not in table.column_names:
        raise MissingError(f"'{result.name}' has no axis {axis}")
    return sorted({float(value) for value in table.column(axis).to_pylist()})


def _panel(axes: "Axes", knob: "SampledKnob", found: "list[Crossing]", shown: "list[Crossing]") -> None:
    """One panel, with room for the crossings ``shown``."""
    import numpy as np

    from hknob_cli.theory.relay import plant_curve

    right = max(-one.point.real for one in shown)
    down = max(0.5 * right, *(-one.point.imag for one in shown))
    reach = abs(complex(right, down))
    fastest, slowest = max(one.omega for one in found), min(one.omega for one in found)
    curve = plant_curve(knob, np.geomspace(0.3 * slowest, 6.0 * fastest, 300))
    curve = curve[np.abs(curve) < 4.0 * reach]
    axes.plot(curve.real, curve.imag, color="black", linewidth=1.6, label="hand and knob")
    axes.plot(
        [-2.0 * reach, 0.0], [0.0, 0.0], color="black", linestyle="--", linewidth=1.0, label="relay without delay"
    )
    for i, one in enumerate(found):
        far = max(_REACH * abs(one.point), 0.1 * reach) / abs(one.point)
        style = theme.series(i)
        label = f"rate {short(one.rate_hz)} Hz: {short(one.frequency_hz, 3)} Hz"
        axes.plot([0.0, far * one.point.real], [0.0, far * one.point.imag], marker="o", markevery=[], **style)
        axes.plot([one.point.real], [one.point.imag], marker="o", markersize=6, markerfacecolor="none",
                  markeredgewidth=1.4, label=label, **style)  # fmt: skip
    axes.set_xlim(-1.3 * right, 0.12 * right)
    axes.set_ylim(-1.25 * down, 0.12 * down)
    axes.set_aspect("equal")
    axes.set_xlabel("Re G, rad/(N\u00b7m)")
    axes.set_ylabel("Im G, rad/(N\u00b7m)")
