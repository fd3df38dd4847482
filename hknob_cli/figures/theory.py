"""Theory drawn: closed laws beside the simulation, the K-B plane of a wall, and Nyquist curves of hand and knob.

Hasser, Figs 45, 46; of laws, which are lines and points over one axis, sec. 9.3, Figs 62-65.
"""

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import TABLES, Grid, Layout, LinesLayout, axis_name, column_label, grid
from hknob_cli.figures.numbers import is_geometric, log_ticks, mark_values, tick_labels
from hknob_cli.report.table import short
from hknob_cli.results.columns import WORST
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


_LAWS = {"quantum_period": "the law C \u0394\u03b8 T"}


@drawing
def law_lines(
    evidence: ResultSet,
    of: str | list[str],
    *,
    law: str = "quantum_period",
    column: str = "p2p_rad",
    layout: LinesLayout,
    height: float = 3.8,
) -> "Figure":
    """A law of a prediction as lines over an axis, and the simulated values as points.

    ``of``: the prediction, and the sweep, unless the prediction has one beside it. Lines are faint outside the law's
    domain. Mean over the trials that cycle. Raises `MissingError`.
    """
    names = [of] if isinstance(of, str) else list(of)
    result = evidence[names[0]]
    beside = column if len(names) > 1 else f"sweep_{column}"
    cells = grid(result, Layout(*layout), where={"law": law}, columns=(column,))
    there: Grid | None = cells
    if len(names) > 1:
        same = Layout(cells.across or None, cells.down or None, layout.at)
        there = grid(evidence[names[1]], same, columns=(column,))
    elif cells.rows and beside not in cells.rows[0]:
        there = None
    name, factor = column_label(result, column)
    figure = theme.figure(height)
    axes = figure.subplots()
    computed = cells.values(column, factor)
    if not any(value == value for line in computed for value in line):
        raise MissingError(f"'{names[0]}' has no value of {column} by the law {law}")
    for i, (line, text) in enumerate(zip(computed, tick_labels(cells.downs), strict=True)):
        _line(axes, cells, i, line)
        axes.plot([], [], **theme.series(i), marker=theme.points(i)["marker"], markersize=5, label=text)
    if there is not None:
        for i, line in enumerate(there.values(beside, factor)):
            shown = [(x, y) for x, y in zip(there.acrosses, line, strict=True) if y == y and y > 0]
            axes.plot(*zip(*shown, strict=True) if shown else ([], []), markersize=5, **theme.points(i))
    values = [value for value in cells.acrosses if value is not None]
    mark_values(axes, values, few=10)
    axes.set_yscale("log")
    axes.set_yticks(*log_ticks(*axes.get_ylim()))
    axes.set_yticks([], minor=True)
    axes.set_xlabel(cells.names[0])
    axes.set_ylabel(name)
    what = [f"lines: {_LAWS.get(law, law.replace('_', ' '))}, thin outside its domain"]
    figure.supxlabel(";  ".join(what + (["points: simulated"] if there is not None else [])), fontsize=8)
    if cells.down:
        figure.legend(title=fill(cells.names[1], 20), loc="outside right upper", handlelength=3.4)
    return figure


def _line(axes: "Axes", cells: Grid, index: int, values: list[float]) -> None:
    """A row of the grid as a line, faint outside the law's domain."""
    style = theme.series(index)
    inside = [
        value if cell is not None and cell["in_domain"] else float("nan")
        for value, cell in zip(values, cells.cells[index], strict=True)
    ]
    axes.plot(cells.acrosses, values, **{**style, "linewidth": 0.8, "alpha": 0.6})
    axes.plot(cells.acrosses, inside, **style)


_MARGIN = 3.0  # factor of frequency that the line reaches beyond the points


@drawing
def torque_reach(
    evidence: ResultSet,
    of: list[str],
    *,
    names: list[str] | None = None,
    printed_hz: float | None = None,
    printed_rad: float | None = None,
) -> "Figure":
    """Peak to peak (mrad) over pitch (Hz): the most that +- half a count's torque gives the inertia, K q / (32 J f^2).

    The first ``of`` is a sweep of one cell, whose scene has the wall and the inertia; it and the others (sweeps and
    campaigns of one cell) are points, the largest cycle of each. ``printed_hz``, ``printed_rad``: what a text says.
    Raises `MissingError` where one is at rest.
    """
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.laws import working_edge

    points: list[tuple[str, float, float]] = []
    for name, said in zip(of, names or of, strict=True):
        cells = grid(evidence[name], columns=WORST).rows
        if len(cells) != 1 or not cells[0][WORST[0]]:
            raise MissingError(f"'{name}' is at rest, or of several cells")
        size, pitch = (float(cells[0][column]) for column in WORST)
        points.append((said, pitch, size))
    pitches = [pitch for _, pitch, _ in points] + ([printed_hz] if printed_hz else [])
    line = np.geomspace(min(pitches) / _MARGIN, max(pitches) * _MARGIN, 60)
    first = evidence[of[0]]
    cell = {axis: first.rows("cells")[0][axis] for axis in first.axes}
    edge = working_edge(scene_at(first.scene, cell), cell)
    at_one = edge.wall_stiffness * edge.quantum_rad / (32.0 * edge.inertia)  # a triangle of velocity, at 1 Hz
    drawn = theme.figure(3.3)
    panel = drawn.subplots()
    panel.plot(line, 1e3 * at_one / line**2, color="black", linewidth=1.2, label="half a count's torque, no losses")
    for i, (said, at_hz, p2p_rad) in enumerate(points):
        panel.plot([at_hz], [1e3 * p2p_rad], markersize=7, label=said, **theme.points(i))
    if printed_hz and printed_rad:
        reach = at_one / printed_hz**2
        panel.plot([printed_hz], [1e3 * printed_rad], markersize=13, marker="*", linestyle="none", color="black",
                   label="printed")  # fmt: skip
        panel.plot([printed_hz] * 2, [1e3 * reach, 1e3 * printed_rad], color="black", linestyle=":", linewidth=1.0)
        panel.text(1.05 * printed_hz, 1e3 * (reach * printed_rad) ** 0.5, f"{printed_rad / reach:.0f}-fold", fontsize=8)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xticks(*log_ticks(*panel.get_xlim()))
    panel.set_yticks(*log_ticks(*panel.get_ylim()))
    panel.set_xticks([], minor=True)
    panel.set_yticks([], minor=True)
    panel.set_xlabel("frequency, Hz")
    panel.set_ylabel("peak to peak, mrad")
    panel.legend(loc="lower left")
    return drawn
